#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `scripts/scale_model.py` says of 1, 2 and 4 processes of one thread on this machine, beside what they take.

    /usr/bin/python3 bench/scale_check.py [--build build/release] [--frames 48000]

Rendering in parts, training `dense`, and growing a pose forest. What a core takes while all are busy, what a start takes and what messages
cost here is measured, the rest computed; processes beyond the number of cores share them. Nothing else should run meanwhile.
"""
import argparse
import dataclasses
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from worker_ratio import NETWORK, POSE_FOREST, ROOT, steps_per_second, trees_per_second

sys.path.insert(0, str(ROOT / "scripts"))
import scale_model  # noqa: E402

PROCESSES = (1, 2, 4)
SHARDS = 4


def way(workers):
    return ["--threads", str(workers), *(["--workers", str(workers)] if workers > 1 else [])]


def rendering_time(program, folder, frames, processes):
    """Seconds until the last of the parts is there."""
    for part in folder.glob("part*"):
        part.unlink()
    begin = time.monotonic()
    running = [subprocess.Popen([program, "render", "--manifest", ROOT / "manifests/small_pictures.toml", "--count", str(frames), "--threads", "1",
                                 "--shard", f"{part}/{processes}", "--out", folder / f"part{part}.h5"], stdout=subprocess.DEVNULL)
               for part in range(processes)]
    if any(process.wait() for process in running):
        sys.exit(1)
    return time.monotonic() - begin


def measured_costs(exchange_time):
    """The cost model with what messages take on this machine, by `knuckle_exchange_time 2`: two exchanges a step, of which two workers
    with a shard each send half the gradient."""
    printed = subprocess.run([exchange_time, "2"], check=True, text=True, capture_output=True).stdout
    seconds = {float(size): float(took) / 1e3 for size, took in re.findall(r"([\d.]+) MB: +([\d.]+) ms", printed)}
    smallest, largest = min(seconds), max(seconds)
    return dataclasses.replace(scale_model.Costs(), shards=SHARDS, latency_s=seconds[smallest] / 2.0,
                               link_bytes_s=1e6 * largest / (seconds[largest] - seconds[smallest]))


def print_beside(what, unit, said, measured):
    for processes in PROCESSES:
        print(f"{what}, {processes}: said {said[processes]:.3g} {unit}, measured {measured[processes]:.3g} {unit}, "
              f"ratio {measured[processes] / said[processes]:.2f}", flush=True)


def shared_by_cores(of_workers, costs, cores):
    """What the model says of a core per process, where processes share `cores`; messages are those of all."""
    return {n: of_workers(costs, n) + (1.0 / min(n, cores) - 1.0 / n) * of_workers(costs, 1) for n in PROCESSES}


def check_rendering(program, folder, costs, frames, cores):
    few, many = (rendering_time(program, folder, count, cores) for count in (frames // 4, frames))
    start = (4.0 * few - many) / 3.0
    print(f"a start takes {start:.2f} s")
    costs = dataclasses.replace(costs, start_s=start, render_s=cores * (many - start) / frames)
    more_starts = {n: start * max(0.0, n / cores - 1.0) for n in PROCESSES}
    print_beside("rendering", "s", {n: scale_model.rendering_s(costs, frames, min(n, cores)) + more_starts[n] for n in PROCESSES},
                 {n: rendering_time(program, folder, frames, n) for n in PROCESSES})


def check_training(program, folder, costs, cores):
    network = NETWORK.replace("shards = 2", f"shards = {SHARDS}").replace("epochs = 4", "epochs = 2")
    of_core = steps_per_second(program, ["--threads", str(cores)], folder, network) / cores
    costs = dataclasses.replace(costs, samples_per_core_s=of_core)
    print_beside("a step of dense", "s", shared_by_cores(scale_model.step_s, costs, cores),
                 {n: costs.batch / steps_per_second(program, way(n), folder, network) for n in PROCESSES})


def check_forest(program, folder, costs, frames, cores):
    def tree_time(options):
        return 1.0 / trees_per_second("pose-forest", POSE_FOREST, program, options, folder)

    costs = dataclasses.replace(costs, tree_s=cores * tree_time(["--threads", str(cores)]) / frames)
    print_beside("a tree of the pose forest", "s", shared_by_cores(lambda c, n: scale_model.forest_tree_s(c, frames, n), costs, cores),
                 {n: tree_time(way(n)) for n in PROCESSES})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--frames", type=int, default=48000, help="of the forest; a quarter of them are rendered in parts")
    arguments = parser.parse_args()
    binaries = (arguments.build / "bin").resolve()
    program, frames, cores = binaries / "knuckle", arguments.frames, len(os.sched_getaffinity(0))
    costs = measured_costs(binaries / "knuckle_exchange_time")
    print(f"{cores} cores; messages: {1e3 * costs.latency_s:.2f} ms and {costs.link_bytes_s / 1e6:.0f} MB/s")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        check_rendering(program, folder, costs, frames // 4, cores)
        subprocess.run([program, "render", "--manifest", ROOT / "manifests/small_pictures.toml", "--count", str(frames), "--out", folder / "frames.h5"],
                       check=True, stdout=subprocess.DEVNULL)
        check_training(program, folder, costs, cores)
        check_forest(program, folder, costs, frames, cores)


if __name__ == "__main__":
    main()
