#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs two builds of knuckle_bench in turn, benchmark by benchmark, and prints the ratio of their median times.

usage: scripts/compare_benchmarks.py OLD NEW [--filter REGEX] [--rounds 9] [--min-time 0.1] [--limit 1.03]

The processor's time is compared, which other programs disturb least. Each round runs both, in an order that
changes from round to round. Ends with status 1 where the new program is slower than the limit in a benchmark that
both have.
"""

import argparse
import json
import re
import statistics
import subprocess
import sys


def benchmark_names(program, pattern):
    listed = subprocess.run([program, "--benchmark_list_tests", f"--benchmark_filter={pattern}"], check=True,
                            capture_output=True, text=True)
    return listed.stdout.split()


def cpu_time_ns(program, name, min_time_s):
    """The processor's time of one iteration."""
    result = subprocess.run([program, f"--benchmark_filter=^{re.escape(name)}$", f"--benchmark_min_time={min_time_s}",
                             "--benchmark_format=json"], check=True, capture_output=True, text=True)
    run = json.loads(result.stdout)["benchmarks"][0]
    if run.get("error_occurred"):
        sys.exit(f"{program}: {name}: {run['error_message']}")
    return run["cpu_time"] * {"ns": 1, "us": 1e3, "ms": 1e6, "s": 1e9}[run["time_unit"]]


def median_times(programs, name, options):
    """Medians over the rounds, one per program."""
    times = [[], []]
    for round_number in range(options.rounds):
        order = (0, 1) if round_number % 2 == 0 else (1, 0)
        for which in order:
            times[which].append(cpu_time_ns(programs[which], name, options.min_time))
    return [statistics.median(of_one) for of_one in times]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", help="the program to compare with")
    parser.add_argument("new")
    parser.add_argument("--filter", default=".", help="names of the benchmarks to run")
    parser.add_argument("--rounds", type=int, default=9, help="runs of each program per benchmark")
    parser.add_argument("--min-time", type=float, default=0.1, help="of one run [s]")
    parser.add_argument("--limit", type=float, default=1.03, help="the largest ratio that passes")
    options = parser.parse_args()

    old_names = benchmark_names(options.old, options.filter)
    new_names = benchmark_names(options.new, options.filter)
    for name in sorted(set(old_names) ^ set(new_names)):
        print(f"{name}: only in the {'old' if name in old_names else 'new'} program")
    shared = [name for name in old_names if name in new_names]
    if not shared:
        sys.exit(f"no benchmark that both have matches '{options.filter}'")
    slower = []
    print(f"{'benchmark':40} {'old':>12} {'new':>12} {'new / old':>9}")
    for name in shared:
        old, new = median_times((options.old, options.new), name, options)
        print(f"{name:40} {old / 1e3:9.1f} us {new / 1e3:9.1f} us {new / old:9.3f}", flush=True)
        if new > options.limit * old:
            slower.append(name)
    if slower:
        sys.exit(f"slower than {options.limit} times: {', '.join(slower)}")


main()
