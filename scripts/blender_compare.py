# SPDX-License-Identifier: Apache-2.0
"""Knuckle's renderer beside Blender Cycles, same body, poses and camera: how equal, and how much faster.

    python3 scripts/blender_compare.py [--body makehuman|BODY.model] [--frames 20] [--time]
        [--camera W,H,FX,FY,CX,CY]

Needs Blender, Debian's python3-numpy and python3-h5py, and the program knuckle_frame_dump (built with the
tests).
"""
import argparse
import dataclasses
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM = HERE.parent / "build" / "release" / "bin" / "knuckle_frame_dump"


@dataclasses.dataclass
class Agreement:
    """One frame, Knuckle against Blender."""

    body_iou: float
    hand_iou: float
    median_depth_mm: float  # |difference| over the pixels where both see the body
    p99_depth_mm: float
    vertex_mm: float  # largest distances
    landmark_mm: float


def run(command):
    """Runs a program in the project's root, where Knuckle finds MakeHuman's body."""
    process = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, cwd=HERE.parent
    )
    if process.returncode != 0:
        sys.exit(f"{command[0]} failed ({process.returncode}):\n{process.stdout}{process.stderr}")


def render_both(folder, body, frames, camera=None, is_timed=False, program=PROGRAM):
    """Renders the same frames with Knuckle and with Blender: the contents of the two files."""
    dump, rendered = pathlib.Path(folder) / "dump.h5", pathlib.Path(folder) / "blender.npz"
    body = body if body == "makehuman" else pathlib.Path(body).resolve()
    run(
        [
            pathlib.Path(program).resolve(),
            body,
            dump,
            "--frames",
            frames,
            *(["--camera", camera] if camera else []),
            *(["--time"] if is_timed else []),
        ]
    )
    run(
        [
            "blender",
            "--background",
            "--factory-startup",
            "--python-exit-code",
            3,
            "--python",
            HERE / "blender_render.py",
            "--",
            dump,
            "--out",
            rendered,
        ]
    )
    with h5py.File(dump, "r") as file:
        ours = {name: dataset[:] for name, dataset in file.items()} | dict(file.attrs)
    return ours, dict(np.load(rendered))


def intersection_over_union(a, b):
    union = np.count_nonzero(a | b)
    return np.count_nonzero(a & b) / union if union else 1.0


def agreement(ours, blender, frame):
    depth, reference = ours["depth_mm"][frame], blender["depth_mm"][frame]
    difference = np.abs(depth - reference)[(depth > 0) & (reference > 0)]
    if difference.size == 0:
        difference = np.array([np.inf])

    def largest(name):
        return float(np.linalg.norm(ours[name][frame] - blender[name][frame], axis=1).max())

    return Agreement(
        intersection_over_union(depth > 0, reference > 0),
        intersection_over_union(ours["mask"][frame] > 0, blender["mask"][frame] > 0),
        float(np.median(difference)),
        float(np.percentile(difference, 99)),
        largest("vertices"),
        largest("landmarks"),
    )


def print_agreement(frames):
    print(f"worst of {len(frames)} frames, Knuckle against Blender Cycles:")
    print(
        f"  IoU of the body {min(f.body_iou for f in frames):.5f}, "
        f"of the hand {min(f.hand_iou for f in frames):.5f}"
    )
    print(
        f"  |depth difference| median {max(f.median_depth_mm for f in frames):.4f} mm, "
        f"99 % below {max(f.p99_depth_mm for f in frames):.4f} mm"
    )
    print(
        f"  skinned vertices within {max(f.vertex_mm for f in frames):.5f} mm, "
        f"landmarks within {max(f.landmark_mm for f in frames):.5f} mm"
    )


def print_speed(ours, blender):
    seconds, cpu = blender["frame_seconds"], np.median(blender["frame_cpu_seconds"][1:])
    rate = 1 / np.median(seconds[1:])  # the first frame builds what the others keep
    with_setup = len(seconds) / (seconds.sum() + blender["setup_seconds"])
    print(f"speed, {int(ours['threads'])} threads, {int(ours['width'])} x {int(ours['height'])} px:")
    print(
        f"  Blender: {rate:.1f} frames/s ({with_setup:.1f} with setting up {len(seconds)} frames), "
        f"{1000 * cpu:.2f} ms CPU a frame"
    )
    for name, what in (("drawing", "skin, draw, mask"), ("source", "pose, skin, draw, mask, noise")):
        own, own_cpu = ours[f"{name}_frames_per_second"], ours[f"{name}_cpu_seconds_per_frame"]
        print(
            f"  Knuckle ({what}): {own:.0f} frames/s, {1000 * own_cpu:.3f} ms CPU a frame: "
            f"{own / rate:.0f} times Blender by the clock, {cpu / own_cpu:.0f} times by CPU time"
        )


def main():
    parser = argparse.ArgumentParser(description="Knuckle's renderer beside Blender Cycles")
    parser.add_argument("--body", default="makehuman", help="makehuman (default), or a body file")
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--camera", help="W,H,FX,FY,CX,CY (default: 320 x 240, f = 224)")
    parser.add_argument("--time", action="store_true", help="also measure the speed of both")
    parser.add_argument("--program", default=PROGRAM, help="knuckle_frame_dump (default: %(default)s)")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ours, blender = render_both(
            folder, arguments.body, arguments.frames, arguments.camera, arguments.time, arguments.program
        )
    print_agreement([agreement(ours, blender, frame) for frame in range(arguments.frames)])
    if arguments.time:
        print_speed(ours, blender)


if __name__ == "__main__":
    main()
