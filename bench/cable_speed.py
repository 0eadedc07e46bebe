#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the network costs two workers on two machines: name spaces of this one, joined by a cable of so many Mbit/s.

    /usr/bin/python3 bench/cable_speed.py [--build build/release] [--mbit 1000 10000] [--rounds 3]

How long gradients take by their size, and how many samples per second `dense` and the paper's `regression` (196 MB of gradient) are trained
on, in batches of 64 and 256; first with a cable as fast as this machine, then with slow ones. Needs root or name spaces of one's own, and
`tc`. Nothing else should run meanwhile.
"""
import argparse
import csv
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

from worker_ratio import NETWORK, ROOT

sys.path.insert(0, str(ROOT / "tests/scale"))
from two_machines import ADDRESSES, enter_first_machine, two_machines  # noqa: E402
from workers_testing import free_port, met  # noqa: E402

NETWORKS = {
    "dense": NETWORK,
    "regression": NETWORK.replace('"dense"', '"regression"').replace("knuckle22", "icg20").replace("batch_size = 64", "batch_size = 256")
                         .replace("validate_every = 20", "validate_every = 8").replace("epochs = 4", "epochs = 2"),
}


def on_both(machines, command):
    """What worker 0 prints, on the first machine; worker 1 is on the second."""
    port = free_port()
    workers = [subprocess.Popen(machines.on(rank, list(map(str, command))), stdout=subprocess.PIPE, text=True,
                                env={**os.environ, **met(rank, 2, port), "MASTER_ADDR": ADDRESSES[0]}) for rank in (0, 1)]
    printed = [worker.communicate()[0] for worker in workers]
    if any(worker.returncode for worker in workers):
        sys.exit(1)
    return printed[0]


def samples_per_second(machines, program, text, folder):
    """The median over the rows of the metrics but the first."""
    config, model = folder / "train.toml", folder / "trained.pt"
    config.write_text(text.replace("FRAMES", str(folder / "frames.h5")))
    for left in folder.glob("trained*"):
        left.unlink()
    on_both(machines, [program, "train", "network", "--config", config, "--out", model, "--workers", "2", "--threads", "1",
                       "--cache", folder / "cache"])
    with open(f"{model}.metrics.csv", encoding="utf-8") as file:
        rates = [float(row["samples_per_second"]) for row in csv.DictReader(file)]
    return statistics.median(rates[1:])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--mbit", type=int, nargs="*", default=[1000, 10000])
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    enter_first_machine()
    binaries = (arguments.build / "bin").resolve()
    with tempfile.TemporaryDirectory() as temporary, two_machines() as machines:
        folder = pathlib.Path(temporary)
        subprocess.run([binaries / "knuckle", "render", "--manifest", ROOT / "manifests/small_pictures.toml", "--count", "2100", "--out",
                        folder / "frames.h5"], check=True, stdout=subprocess.DEVNULL)
        for megabits in (None, *arguments.mbit):
            if megabits:
                machines.slow_down(megabits)
            cable = f"{megabits} Mbit/s" if megabits else "as fast as it goes"
            print(f"{cable}:\n{on_both(machines, [binaries / 'knuckle_exchange_time', '2'])}", end="", flush=True)
            for name, text in NETWORKS.items():
                rates = [samples_per_second(machines, binaries / "knuckle", text, folder) for _ in range(arguments.rounds)]
                print(f"  {name}: " + ", ".join(f"{rate:.1f}" for rate in rates) + f" samples/s; median {statistics.median(rates):.1f}", flush=True)


if __name__ == "__main__":
    main()
