#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What it takes to render many frames and to train on them: time and money over machines, and a simulation of stragglers and
failures. docs/scale.md shows its tables, and says where the numbers below were measured.

    scale_model.py [--frames 1e8] [--runs 20] [--seed 1]
"""
import argparse
import heapq
import math
import random
import statistics
from dataclasses import dataclass

HOUR_S = 3600.0


@dataclass(frozen=True)
class Costs:
    """Measured here, but for those marked as assumed."""

    render_s: float = 2.8e-3  # processor time per frame of 320 x 240 (docs/scale.md)
    start_s: float = 3.1  # of a process that renders, until it has all bodies (bench/scale_check.py)
    join_s: float = 1.1e-3  # per frame, on one core
    frame_bytes: float = 14e3  # on the disk
    sample_bytes: float = 20.7e3  # of a cut-out hand in memory (CubeSamples)
    cut_s: float = 1.93e-3  # processor time per frame whose hand is cut out: 1,037 frames/s on two cores (docs/performance.md)
    samples_per_core_s: float = 254.0  # `dense`, single precision, AVX-512: half of two cores' 509 (docs/scale.md)
    gradient_bytes: float = 4.0 * 558750  # of `dense`
    batch: int = 64  # samples per step
    shards: int = 4
    core_price_h: float = 0.04  # assumed: US dollars per core and hour
    disk_price_gb: float = 0.02  # assumed: US dollars per 10^9 bytes and month
    link_bytes_s: float = 1.25e9 / 2  # assumed: half of what a link of 10 Gbit/s carries
    latency_s: float = 2e-4  # per exchange and doubling of the workers; measured here over the loopback for two (docs/scale.md)
    failure_h: float = 50000.0  # assumed: mean time to a failure of one worker; Dubey et al. 2024 report 419 in 54 days on 16,384 GPUs
    restart_s: float = 120.0  # assumed: until all are started again and have their samples
    patch_bytes: float = 18.75e3  # of a sample of the pose forest: a patch of 96 x 96, and its targets
    moved_share: float = 0.34  # of the bytes of all patches, what each of two workers sends per tree, packed (docs/scale.md)
    tree_s: float = 275.0 / 399929  # processor time per patch and tree at the paper's options (docs/performance.md)
    spread: float = 0.1  # assumed: standard deviation of the logarithm of a step's time on one worker


# ---------------------------------------------------------------- without failures


def exchange_s(costs, workers):
    """Two exchanges per step: (shards / workers + 1) (1 - 1 / workers) gradients are sent by each (training/shard_sum.h)."""
    if workers == 1:
        return 0.0
    sent = (costs.shards / workers + 1.0) * (1.0 - 1.0 / workers) * costs.gradient_bytes
    return sent / costs.link_bytes_s + 2.0 * costs.latency_s * math.log2(workers)


def step_s(costs, workers):
    """A step of all workers, each of one core."""
    return costs.batch / workers / costs.samples_per_core_s + exchange_s(costs, workers)


def rendering_s(costs, frames, workers):
    return costs.start_s + costs.render_s * frames / workers


def training_s(costs, samples, workers):
    return samples / costs.batch * step_s(costs, workers)


def forest_worker_bytes(costs, samples, workers):
    """A worker's part of the patches."""
    return costs.patch_bytes * samples / workers


def forest_tree_s(costs, samples, workers):
    """A tree of all workers, each of one core. A patch moves when a tree begins, and about once for each halving of the workers
    whose parts a node spans: what two workers send, log2(N) times, shared by all N."""
    if workers == 1:
        return costs.tree_s * samples
    sent = costs.moved_share * 2.0 * math.log2(workers) / workers * costs.patch_bytes * samples
    return costs.tree_s * samples / workers + sent / costs.link_bytes_s


# ---------------------------------------------------------------- simulations


def render_with_failures(costs, frames, workers, parts, draw):
    """An array of parts, each taken by the next free worker. A failed worker comes back after the restart and goes on with its
    part where it was: rendering keeps each written frame. Returns the time until the last part is done [s]."""
    part_s = rendering_s(costs, frames, parts)
    free = [0.0] * workers
    heapq.heapify(free)
    last = 0.0
    for _ in range(parts):
        begin = heapq.heappop(free)
        needed = part_s * draw.lognormvariate(0.0, costs.spread)
        end = begin + needed
        failure = draw.expovariate(1.0 / (costs.failure_h * HOUR_S))
        while failure < needed:  # what is done stays done
            end += costs.restart_s
            needed -= failure
            failure = draw.expovariate(1.0 / (costs.failure_h * HOUR_S))
        last = max(last, end)
        heapq.heappush(free, end)
    return last


def straggling(costs, workers, draw, steps=200):
    """How much longer a step takes that waits for the slowest worker."""
    slowest = [max(draw.lognormvariate(0.0, costs.spread) for _ in range(workers)) for _ in range(steps)]
    return statistics.fmean(slowest)


def best_interval_s(checkpoint_s, failure_s):
    """Time between checkpoints that costs least (Young 1974, first order)."""
    return math.sqrt(2.0 * checkpoint_s * failure_s)


def train_with_failures(work_s, interval_s, checkpoint_s, restart_s, failure_s, draw):
    """One failure of any worker ends all, and the training goes on from the last checkpoint. Returns the time that `work_s` of
    steps take [s]."""
    time = done = 0.0
    next_failure = draw.expovariate(1.0 / failure_s)
    while done < work_s:
        stretch = min(interval_s, work_s - done) + checkpoint_s
        if time + stretch <= next_failure:
            time += stretch
            done += stretch - checkpoint_s
        else:
            time = next_failure + restart_s
            next_failure = time + draw.expovariate(1.0 / failure_s)
    return time


# ---------------------------------------------------------------- tables


def duration(seconds):
    for unit, name in ((86400.0, "d"), (HOUR_S, "h"), (60.0, "min")):
        if seconds >= 2.0 * unit:
            return f"{seconds / unit:.1f} {name}"
    return f"{seconds:.3g} s"


def print_rendering(costs, frames):
    print(f"Rendering {frames:.3g} frames ({frames * costs.frame_bytes / 1e12:.2f} TB, "
          f"{frames * costs.frame_bytes / 1e9 * costs.disk_price_gb:.0f} $ per month on a disk):")
    core_hours = frames * costs.render_s / HOUR_S
    print(f"  {core_hours:.0f} core hours, {core_hours * costs.core_price_h:.0f} $; joining on one core: {duration(frames * costs.join_s)}")
    cut_hours = frames * costs.cut_s / HOUR_S
    print(f"  cutting out the hands: {cut_hours:.0f} core hours, {cut_hours * costs.core_price_h:.0f} $; as samples in the memory of "
          f"each worker: {frames * costs.sample_bytes / 1e12:.2f} TB")
    for workers in (1, 4, 16, 100, 1000):
        print(f"  {workers:5} cores: {duration(rendering_s(costs, frames, workers))}")


def print_training(costs, samples):
    print(f"Training `dense` on {samples:.3g} samples, a core per worker:")
    print("  batch  shards  workers    step   exchange  samples/s  efficiency  in all   dollars")
    for batch, shards in ((64, 4), (256, 16), (4096, 256), (65536, 256)):
        for workers in (1, 4, 16, 64, 256):
            if workers > shards:
                continue
            scaled = Costs(batch=batch, shards=shards)
            step = step_s(scaled, workers)
            alone = step_s(scaled, 1) / workers
            seconds = training_s(scaled, samples, workers)
            price = seconds / HOUR_S * workers * costs.core_price_h
            print(f"  {batch:5} {shards:7} {workers:8} {1e3 * step:8.1f} ms {100 * exchange_s(scaled, workers) / step:6.1f} % "
                  f"{batch / step:9.0f} {100 * alone / step:9.0f} % {duration(seconds):>9} {price:9.0f}")


def print_forest(costs, samples):
    print(f"Pose forest, a tree on {samples:.3g} patches, a core per worker:")
    for workers in (1, 16, 64, 256, 1000):
        seconds = forest_tree_s(costs, samples, workers)
        print(f"  {workers:5} workers: {forest_worker_bytes(costs, samples, workers) / 1e9:8.1f} GB each, {duration(seconds):>8}, "
              f"efficiency {100.0 * costs.tree_s * samples / workers / seconds:.0f} %")


def print_simulation(costs, frames, runs, seed):
    workers = 1000
    draw = random.Random(seed)
    ideal = rendering_s(costs, frames, workers)
    print(f"Rendering on {workers} cores, {runs} simulations (spread {costs.spread}, a failure per {costs.failure_h:.0f} h and core):")
    for parts in (1000, 2000, 4000, 16000):
        times = [render_with_failures(costs, frames, workers, parts, draw) for _ in range(runs)]
        print(f"  {parts:6} parts: {statistics.fmean(times) / ideal:.3f} of the ideal {duration(ideal)} (worst {max(times) / ideal:.3f})")
    print("A step that waits for the slowest worker, against the median worker:")
    for count in (2, 16, 256, 1000):
        print(f"  {count:5} workers: {straggling(costs, count, draw):.3f}")
    work = 30 * 86400.0
    checkpoint = 1.0
    print(f"A training of {duration(work)} that any failure sends back to its checkpoint (1 s), {runs} simulations:")
    for count in (16, 256, 1000):
        failure = costs.failure_h * HOUR_S / count
        best = best_interval_s(checkpoint, failure)
        for interval in dict.fromkeys((best, 600.0, HOUR_S)):
            times = [train_with_failures(work, interval, checkpoint, costs.restart_s, failure, draw) for _ in range(runs)]
            kind = " (best)" if interval == best else ""
            print(f"  {count:5} workers, a failure per {duration(failure)}, checkpoint each {duration(interval)}{kind}: "
                  f"{statistics.fmean(times) / work:.4f} of the time without failures")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=float, default=1e8)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    if not 1.0 <= arguments.frames <= 1e15 or not 1 <= arguments.runs <= 10000:
        parser.error("--frames is a number from 1 to 1e15, --runs one from 1 to 10000")
    costs = Costs()
    print_rendering(costs, arguments.frames)
    print_training(costs, arguments.frames)
    print_forest(costs, arguments.frames)
    print_simulation(costs, arguments.frames, arguments.runs, arguments.seed)


if __name__ == "__main__":
    main()
