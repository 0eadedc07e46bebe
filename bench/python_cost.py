#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the Python package costs beside the library itself, on one core.

    /usr/bin/python3 bench/python_cost.py [--build build/release] [--pipeline pipelines/default.toml]
        [--manifest manifests/demo.toml] [--frames 40] [--rounds 5] [--estimates 0] [--threads]

C++ (knuckle_frame_cost) and Python render and estimate the same frames in turns; medians over the frames, then over the
rounds. With --estimates one frame is estimated so many times in a loop, at a quarter of its size, and the memory of the
process printed on the way. With --threads the same estimates are then made by one, two and four threads, on all cores. Nothing else
should run meanwhile.
"""
import argparse
import concurrent.futures
import os
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def milliseconds_of(work):
    begin = time.perf_counter()
    result = work()
    return 1e3 * (time.perf_counter() - begin), result


def costs_in_python(knuckle, arguments):
    """Medians [ms] of rendering a frame and of estimating it."""
    pipeline = knuckle.Pipeline.load(arguments.pipeline)
    rendering, estimating = [], []
    for i in range(arguments.frames):
        took, frame = milliseconds_of(lambda: knuckle.render(arguments.manifest, i))
        rendering.append(took)
        depth, camera = frame.depth_mm, frame.camera
        took, _ = milliseconds_of(lambda: pipeline.estimate(depth, camera))
        estimating.append(took)
    return statistics.median(rendering), statistics.median(estimating)


def costs_in_cpp(arguments):
    program = arguments.build / "bin" / "knuckle_frame_cost"
    source = f"synthetic:{arguments.manifest}?count={arguments.frames}"
    done = subprocess.run([program, arguments.pipeline, source], check=True, capture_output=True, text=True)
    return tuple(map(float, done.stdout.split()))


def resident_megabytes():
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def estimate_often(knuckle, arguments):
    """One small frame, again and again: twenty lines with the time and the memory."""
    frame, step = knuckle.render(arguments.manifest, 3), 4
    depth, camera = frame.depth_mm[::step, ::step].copy(), frame.camera
    height, width = depth.shape
    small = knuckle.Camera(camera.fx / step, camera.fy / step, camera.cx / step, camera.cy / step, width, height)
    pipeline = knuckle.Pipeline.load(arguments.pipeline)
    begin = time.perf_counter()
    hands = 0
    for i in range(1, arguments.estimates + 1):
        for hand in pipeline.estimate(depth, small).hands:
            hands += hand.landmarks_mm is not None
        if i % max(1, arguments.estimates // 20) == 0:
            print(f"{i} estimates of {width} x {height}, {hands} hands, {time.perf_counter() - begin:.0f} s, "
                  f"{resident_megabytes():.1f} MB", flush=True)


def rate_of_threads(pipeline, frames, threads):
    """Estimates per second: each frame six times."""
    begin = time.perf_counter()
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda frame: pipeline.estimate(frame.depth_mm, frame.camera), 6 * frames))
    return 6 * len(frames) / (time.perf_counter() - begin)


def estimate_in_threads(knuckle, arguments):
    pipeline = knuckle.Pipeline.load(arguments.pipeline)
    frames = [knuckle.render(arguments.manifest, i) for i in range(arguments.frames)]
    for _ in range(max(1, arguments.rounds)):
        one, two, four = (rate_of_threads(pipeline, frames, threads) for threads in (1, 2, 4))
        print(f"one thread {one:.0f} estimates/s, two {two / one:.2f} times as many, four {four / one:.2f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--pipeline", type=pathlib.Path, default=ROOT / "pipelines" / "default.toml")
    parser.add_argument("--manifest", type=pathlib.Path, default=ROOT / "manifests" / "demo.toml")
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--estimates", type=int, default=0)
    parser.add_argument("--threads", action="store_true")
    arguments = parser.parse_args()
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    sys.path.insert(0, str(arguments.build / "python"))
    import knuckle

    rounds = []
    for _ in range(arguments.rounds):
        rounds.append((costs_in_cpp(arguments), costs_in_python(knuckle, arguments)))
    for k, name in enumerate(("render", "estimate") if rounds else ()):
        cpp = statistics.median(one[0][k] for one in rounds)
        python = statistics.median(one[1][k] for one in rounds)
        more = statistics.median(one[1][k] - one[0][k] for one in rounds)
        ratio = statistics.median(one[0][k] / one[1][k] for one in rounds)
        print(f"{name}: C++ {cpp:.3f} ms, Python {python:.3f} ms, {more:+.3f} ms a frame, {ratio:.2f} times the rate")
    estimate_often(knuckle, arguments)
    if arguments.threads:
        os.sched_setaffinity(0, cores)
        estimate_in_threads(knuckle, arguments)


if __name__ == "__main__":
    main()
