#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A soak of everything: `render`, `estimate`, `train`, `annotate` with a scripted person and `live` with clients run beside one another on a
small disk that fills now and then, are killed at random moments and begun again. At the end nothing is lost, what came of it has the bytes
of undisturbed runs, and memory was flat; each rule that was broken is one line of the log, and the exit status is 1.

The small disk needs a name space of its own (`unshare --mount`): where that is not allowed, that is said, and the exit status is 77.
"""
import argparse
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

from soak_annotate import Annotating
from soak_jobs import LongEstimate, estimate_job, forest_job, network_job, render_job
from soak_live import RATE, LiveOn, LiveRounds
from soak_place import LONGEST_S, Place

SKIPPED = 77
PROJECT = pathlib.Path(__file__).resolve().parent.parent
MANIFEST = """
seed = 3
frames = 10000000
[body]
people = 1
[camera]
width = 64
height = 48
fx = 45.0
fy = 45.0
cx = 31.5
cy = 23.5
[placement]
nearest_mm = 350.0
farthest_mm = 500.0
off_centre = 0.05
presented_share = 1.0
"""
SHORT_MINUTES = 5.0
# The thread sanitizer keeps who used which byte last, in memory beside it: that grows with what is used.
IS_SHADOWED = os.environ.get("KNUCKLE_SANITIZE") == "thread"
MORE_CLIENTS = 8  # that may be connected at one moment, and not at another


def arguments_of():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=120.0, help="between the undisturbed runs and the calm at the end (120)")
    parser.add_argument("--folder", type=pathlib.Path, help="new or empty; keeps the log and what was different (a temporary one)")
    parser.add_argument("--program", type=pathlib.Path, default=PROJECT / "build/release/bin/knuckle")
    parser.add_argument("--seed", type=int, default=1, help="of kills, full disks and clients (1)")
    parser.add_argument("--disk-mb", type=int, default=48, help="of the small disk (48)")
    return parser.parse_args()


def enter_own_name_space():
    """Begins again where file systems may be mounted, and are gone with us."""
    for options in (["--mount"], ["--user", "--map-root-user", "--mount"]):
        way = ["unshare", *options]
        if shutil.which("unshare") and subprocess.run([*way, "true"], capture_output=True, check=False).returncode == 0:
            os.environ["KNUCKLE_SOAK_NAME_SPACE"] = "own"
            os.execvp(way[0], [*way, sys.executable, *sys.argv])
    skip("this user may mount no small disk here: `unshare --mount` fails")


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def require_whole_program(program):
    info = subprocess.run([program, "info", "--json"], capture_output=True, text=True, check=True).stdout
    if json.loads(info)["view"] != "live --view":
        skip("built without Boost")
    if not (program.parent / "knuckle-train-network").exists():
        skip("built without LibTorch")


def parts_of(place):
    """All that runs beside one another; jobs are as long as the time allows."""
    manifest = place.folder / "small.toml"
    manifest.write_text(MANIFEST)
    scale = min(max(place.minutes / 10, 0.1), 0.6)
    frames = int(min(max(60 * place.minutes, 60), 300))
    played, labelled = place.folder / "played.h5", place.folder / "labelled"
    place.undisturbed("render", ["render", "--manifest", manifest, "--count", frames, "--out", played])
    place.undisturbed("render", ["render", "--manifest", manifest, "--count", 3 + int(3 * scale), "--format", "folder", "--out", labelled])
    estimate = estimate_job(place, manifest, int(1200 * scale))
    return [render_job(place, manifest, int(4000 * scale)), estimate, network_job(place, manifest, max(2, int(16 * scale))),
            forest_job(place, manifest, max(8, int(60 * scale))), Annotating(place, labelled), LiveRounds(place, played, frames),
            LiveOn(place, played), LongEstimate(place, manifest, estimate)]


def each_in_a_thread(place, parts, what):
    def guarded(part):
        try:
            what(part)
        except Exception as fault:  # one part's end is no other's
            place.log.broken(part.who, f"cannot go on: {type(fault).__name__}: {fault}")

    threads = [threading.Thread(target=guarded, args=(part,), name=part.who, daemon=True) for part in parts]
    for thread in threads:
        thread.start()
    return threads


def disturb(place):
    """Fills the disk now and then, until the time is over."""
    chance = random.Random(f"{place.seed} disk")
    end = time.monotonic() + 60 * place.minutes
    while (left := end - time.monotonic()) > 0:
        time.sleep(min(left, chance.uniform(5, 15 + 60 * min(place.minutes / 60, 1))))
        place.disk.fill(chance.uniform(1, 8), lambda: time.monotonic() > end)
    place.calm.set()


def check_memory(place, who):
    """Of what runs through: the end against the middle. Of what is begun again and again: the peaks of the two halves."""
    memory = place.memory
    quarter, half, end = (memory.around(who, share) for share in (0.25, 0.5, 1.0))
    first, second = memory.peak(who, 0.0, 0.5), memory.peak(who, 0.5, 1.0)
    place.log.say("memory", f"{who}: {quarter:.1f} MB at a quarter, {half:.1f} MB at half, {end:.1f} MB at the end; at most {first:.1f} MB in the "
                            f"first half, {second:.1f} MB in the second; at most {max(d for _, _, d in memory.samples[who])} descriptors")
    runs_on = who in (LiveOn.who, LongEstimate.who)
    is_short = place.minutes < SHORT_MINUTES
    if is_short and not runs_on:
        return  # a round or two say nothing
    growth, allowed = (end - half, 4 + 0.03 * half) if runs_on else (second - first, 32 + 0.1 * first)
    if growth > allowed + (32 if is_short else 0) and not IS_SHADOWED:
        place.log.broken("memory", f"{who} has grown by {growth:.1f} MB, {allowed:.1f} MB are allowed")
    descriptors = [max(count for _, count in memory.between(who, *half_of_it)) for half_of_it in ((0.0, 0.5), (0.5, 1.0))]
    if runs_on and descriptors[1] > descriptors[0] + MORE_CLIENTS:
        place.log.broken("memory", f"{who} had {descriptors[0]} descriptors open in the first half, then {descriptors[1]}")


def summarise(place, parts):
    counts = place.log.counts
    for part in parts:
        of_it = [f"{number} {what}" for (who, what), number in sorted(counts.items()) if who == part.who]
        place.log.say("summary", f"{part.who}: {', '.join(of_it)}")
        if not counts[part.who, "rounds"]:
            place.log.broken(part.who, "did not come to an end once")
        if place.memory.samples[part.who]:
            check_memory(place, part.who)
    total = {what: sum(number for (_, name), number in counts.items() if name == what) for what in ("rounds", "kills", "comparisons", "differences")}
    place.log.say("summary", f"{place.minutes:g} minutes, seed {place.seed}: {total['rounds']} rounds, {total['kills']} kills, "
                             f"{len(place.disk.times_full)} times a full disk, {total['comparisons']} comparisons, {total['differences']} "
                             f"differences, {len(place.log.faults)} broken rules")


def soak(place):
    place.memory.start()
    parts = parts_of(place)
    for thread in each_in_a_thread(place, parts, lambda part: part.begin()):
        thread.join()
    if place.log.faults:
        return
    place.log.say("soak", "the undisturbed runs are there: " + ", ".join(f"{part.who} {part.seconds:.1f} s" for part in parts if hasattr(part, "seconds")))
    place.memory.samples.clear()
    threads = each_in_a_thread(place, parts, lambda part: part.run())
    disturb(place)
    place.log.say("soak", "calm: what was begun is finished")
    for thread in threads:
        thread.join(4 * LONGEST_S)
        if thread.is_alive():
            place.log.broken(thread.name, "does not come to its end")
    if not place.log.faults and place.disk.used_bytes() > 1 << 16:
        place.log.broken("disk", f"{place.disk.used_bytes()} bytes are still in use")
    summarise(place, parts)


def main():
    arguments = arguments_of()
    if os.environ.get("KNUCKLE_SOAK_NAME_SPACE") != "own":
        enter_own_name_space()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, and hand that on
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("soak: ended early"))  # and with it all that it has started
    program = arguments.program.resolve()
    require_whole_program(program)
    kept = arguments.folder
    if kept:
        kept.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as temporary:
        place = Place(PROJECT, program, (kept or pathlib.Path(temporary)).resolve(), arguments.disk_mb, arguments.seed, arguments.minutes)
        if not place.disk.is_mounted():
            skip(f"this user may mount no small disk here: {place.disk.why_not}")
        try:
            soak(place)
        finally:
            place.kill_all()
            subprocess.run(["umount", "--lazy", place.disk.folder], check=True)
    sys.exit(1 if place.log.faults else 0)


if __name__ == "__main__":
    main()
