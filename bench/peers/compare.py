#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Knuckle beside other software on the same work: the tables of docs/performance.md, in one run.

    /usr/bin/python3 bench/peers/compare.py [--build build/release] [--models MODEL.pt...] [--rounds 7] [--looks 60]

Networks against ONNX Runtime, OpenCV and LibTorch (compare_networks.py), training of forests against OpenCV's, drawing of bodies
against Blender. Nothing else should run meanwhile. What is not installed is left out, and named.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys

PEERS = pathlib.Path(__file__).resolve().parent
ROOT = PEERS.parent.parent
MODELS = [ROOT / "models" / name for name in ("dense.pt", "dense_scenes.pt")]
FOREST_LINE = re.compile(r"(\S+) +training +([\d.]+) s, +([\d.]+) s of processor time, ([\d.]+) of")


def output_of(command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, cwd=ROOT)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stderr.strip() or done.returncode}")
    return done.stdout


def compare_networks(arguments):
    command = [PEERS / "compare_networks.py", "--build", arguments.build, "--rounds", arguments.rounds,
               "--looks", arguments.looks, *arguments.models]
    print(output_of([sys.executable, *command]))


def compare_forests(build):
    """A row for each number of samples."""
    program = build / "bin" / "knuckle_forest_peer"
    if not program.exists():
        print("forests: left out, OpenCV's ml module was not there when Knuckle was built\n")
        return
    print("| training a forest, processor time | Knuckle [s] | OpenCV [s] | Knuckle right | OpenCV right |\n|---|---|---|---|---|")
    samples, own = "", None
    for line in output_of([program]).splitlines():
        found = FOREST_LINE.match(line)
        if not found:
            samples = line.split(" samples")[0]
        elif found[1] == "knuckle":
            own = found
        else:
            print(f"| {samples} samples | {own[3]} | {found[3]} ({float(found[3]) / float(own[3]):.1f} times) | {own[4]} | {found[4]} |")
    print()


def compare_rendering(build):
    if shutil.which("blender") is None:
        print("rendering: left out, Blender is not on this machine")
        return
    print(output_of([sys.executable, ROOT / "scripts" / "blender_compare.py", "--time", "--program",
                     build / "bin" / "knuckle_frame_dump"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--models", nargs="+", type=pathlib.Path, default=MODELS)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--looks", type=int, default=60)
    arguments = parser.parse_args()
    arguments.build = arguments.build.resolve()
    arguments.models = [model.resolve() for model in arguments.models]
    compare_networks(arguments)
    compare_forests(arguments.build)
    compare_rendering(arguments.build)


if __name__ == "__main__":
    main()
