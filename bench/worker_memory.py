#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much memory of its own (`RssAnon`) each process takes at most that trains a forest, with 1, 2 and 4 workers.

    /usr/bin/python3 bench/worker_memory.py [--build build/release]
"""
import argparse
import pathlib
import re
import subprocess
import tempfile
import time

from worker_ratio import POSE_FOREST, ROOT, SEGMENTATION_FOREST

WORKERS = (1, 2, 4)
POLL_S = 0.01


def quick(text):
    """Fewer trees and candidates: neither is held in memory."""
    return text.replace("splits_per_node = 10000", "splits_per_node = 1000").replace("trees = 3", "trees = 2")


def pose(size_px, samples_per_node):
    return (quick(POSE_FOREST).replace("size_px = 96", f"size_px = {size_px}")
            .replace("samples_per_node = 5000", f"samples_per_node = {samples_per_node}"))


FORESTS = {
    "pose, 3,000 patches of 160 x 160, 500 samples per node": ("pose-forest", 3000, pose(160, 500)),
    "pose, 3,000 patches of 96 x 96, 2,500 samples per node": ("pose-forest", 3000, pose(96, 2500)),
    "pose, 24,000 patches of 96 x 96, 2,500 samples per node": ("pose-forest", 24000, pose(96, 2500)),
    "pixels of 2,500 frames": ("segmentation-forest", 2500, quick(SEGMENTATION_FOREST)),
    "pixels of 24,000 frames": ("segmentation-forest", 24000, quick(SEGMENTATION_FOREST)),
}


def own_memory(process):
    """Of a process and its children [MB], by process."""
    children = pathlib.Path(f"/proc/{process}/task/{process}/children")
    sizes = {}
    for number in (process, *map(int, children.read_text().split())):
        found = re.search(r"^RssAnon:\s+(\d+) kB", pathlib.Path(f"/proc/{number}/status").read_text(), re.MULTILINE)
        if found:
            sizes[number] = int(found.group(1)) / 1e3
    return sizes


def peaks(command):
    """The most of each process, the largest first."""
    most = {}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None:
            try:
                for number, size in own_memory(process.pid).items():
                    most[number] = max(most.get(number, 0.0), size)
            except (FileNotFoundError, ProcessLookupError):
                pass  # one has just ended
            time.sleep(POLL_S)
    if process.returncode:
        raise SystemExit(f"{command[0]} ended with status {process.returncode}")
    return sorted(most.values(), reverse=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    program = (parser.parse_args().build / "bin/knuckle").resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for what, (kind, frames, text) in FORESTS.items():
            source, config, model = folder / f"{frames}.h5", folder / "train.toml", folder / "trained.model"
            if not source.exists():
                subprocess.run([program, "render", "--manifest", ROOT / "manifests/small_pictures.toml", "--count", str(frames), "--out", source],
                               check=True, stdout=subprocess.DEVNULL)
            config.write_text(text.replace("FRAMES", str(source)))
            for workers in WORKERS:
                for left in folder.glob("trained*"):
                    left.unlink()
                of_each = peaks([program, "train", kind, "--config", config, "--out", model, "--threads", "2", "--workers", str(workers)])
                print(f"{what}, {workers}: " + ", ".join(f"{size:.0f}" for size in of_each) + " MB", flush=True)


if __name__ == "__main__":
    main()
