#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A data set in eight parts, by a Slurm array and by GNU parallel: two are killed, what is missing is made by the same command
or, with Slurm, by these two tasks alone, one part is damaged and made anew, and the joined file has the bytes of one process.
Skipped by name where Slurm or GNU parallel is missing.

    parts_test.py slurm|parallel PROGRAM
"""
import contextlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import h5py

from slurm_testing import SKIPPED, local_slurm

PROJECT = pathlib.Path(__file__).resolve().parents[2]
MANIFEST = PROJECT / "manifests/demo.toml"
PARTS = 8
KILLED = (2, 5)
DAMAGED = 3
# Stands for the program, and kills it at the first attempt of some parts, once a frame is written.
KILLER = """#!/usr/bin/env bash
out=${{@: -1}}
case "$out" in {killed}) ;; *) exec {program} "$@" ;; esac
[ -e "$out.killed" ] && exec {program} "$@"
touch "$out.killed"
{program} "$@" &
while kill -0 $! 2>/dev/null && [ "$(stat -c %s "$out.partial" 2>/dev/null || echo 0)" -lt 20000 ]; do sleep 0.01; done
kill -KILL $! 2>/dev/null
wait $! 2>/dev/null
rm -f "$out"  # where it was faster than this script
exit 137
"""


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def killer_of(program, folder):
    patterns = "|".join(f"*part-{number:05}.h5" for number in KILLED)
    script = folder / "killer.sh"
    script.write_text(KILLER.format(program=program, killed=patterns))
    script.chmod(0o755)
    return script


class Parallel:
    def __init__(self, folder):
        if shutil.which("parallel") is None:
            skip("GNU parallel is missing")
        del folder

    def render(self, parts, environment, numbers=None):
        del numbers  # it looks at all of them
        done = subprocess.run([PROJECT / "scripts/render_parts.sh", MANIFEST, str(PARTS), parts, "2"], env=environment, check=False,
                              capture_output=True)
        return done.returncode == 0

    def stop(self):
        pass


class Slurm:
    def __init__(self, folder):
        self.folder = folder
        self.open = contextlib.ExitStack()
        self.environment = self.open.enter_context(local_slurm(folder / "slurm"))

    def render(self, parts, environment, numbers=None):
        array = f"0-{PARTS - 1}" if numbers is None else ",".join(str(number) for number in numbers)
        environment = {**environment, **self.environment}
        log = self.folder / "job-%a.log"
        said = subprocess.run(["sbatch", f"--array={array}", f"--output={log}", f"--chdir={PROJECT}",
                               PROJECT / "scripts/slurm/render_array.sh", MANIFEST, str(PARTS), parts], env=environment, check=True,
                              capture_output=True, text=True).stdout
        job = re.search(r"\d+", said).group()
        while subprocess.run(["squeue", "--noheader", f"--jobs={job}"], env=environment, capture_output=True, text=True,
                             check=False).stdout.strip():
            time.sleep(0.2)
        return all((parts / f"part-{number:05}.h5").exists() for number in range(PARTS))

    def stop(self):
        self.open.close()


def damage(part):
    """One byte of the joints."""
    content = bytearray(part.read_bytes())
    with h5py.File(part) as file:
        content[file["joints_mm"].id.get_offset() + 5] ^= 1
    part.write_bytes(content)


def run(cluster, program, folder):
    parts = folder / "parts"
    environment = {**os.environ, "KNUCKLE": str(killer_of(program, folder))}
    join = [program, "join", *(parts / f"part-{number:05}.h5" for number in range(PARTS)), "--out", folder / "joined.h5"]
    assert not cluster.render(parts, environment), "two parts were to be killed"
    left = sorted(path.name for path in parts.glob("part-?????.h5"))
    assert left == [f"part-{number:05}.h5" for number in range(PARTS) if number not in KILLED], left
    written = {name: (parts / name).stat().st_mtime_ns for name in left}
    refused = subprocess.run(join, capture_output=True, text=True, check=False)
    assert refused.returncode == 1 and "part-00002.h5" in refused.stderr, refused
    assert cluster.render(parts, environment, KILLED), "the same command again makes what is missing"
    assert written == {name: (parts / name).stat().st_mtime_ns for name in left}, "parts that were whole were left alone"
    damage(parts / f"part-{DAMAGED:05}.h5")
    refused = subprocess.run(join, capture_output=True, text=True, check=False)
    assert refused.returncode == 1 and f"part-{DAMAGED:05}.h5" in refused.stderr, refused
    assert cluster.render(parts, environment), "the same command again makes what is broken"
    assert (parts / f"part-{DAMAGED:05}.h5.broken").exists()
    subprocess.run(join, check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "render", "--manifest", MANIFEST, "--out", folder / "whole.h5"], check=True, stdout=subprocess.DEVNULL)
    assert (folder / "joined.h5").read_bytes() == (folder / "whole.h5").read_bytes()
    print(f"{PARTS} parts, {len(KILLED)} of them killed, one damaged, and made again: the bytes of one process")


def main():
    kind, program = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cluster = {"slurm": Slurm, "parallel": Parallel}[kind](folder)
        try:
            run(cluster, pathlib.Path(program).resolve(), folder)
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
