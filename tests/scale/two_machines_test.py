#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trainings by two workers on two machines: their cable is pulled and put back, pulled for good in the middle of a sum, or the disk of one
machine is full. All end with one line each, what was done is kept, and `--resume` leads to the bytes of one worker.

    two_machines_test.py CASE PROGRAM
"""
import itertools
import time

from forest_workers_test import KINDS, ForestPlace
from training_testing import ended, failed_with, run_case, succeeded
from two_machines import ADDRESSES, enter_first_machine, two_machines
from workers_test import LARGE_NETWORK, NetworkPlace
from workers_testing import free_port, met

LONG = {"epochs": 40, "every": 12}  # 60 steps
TREES = {"trees": 30, "splits": 400}
PULLED_S = 3.0
WAIT = ("--wait", "5")  # the least


class TwoMachinesPlace(NetworkPlace, ForestPlace):
    """A folder that both machines see, and trainings of every kind."""

    def trainings(self):
        """By the name of the model: the command of a training, for a name, a number of workers and further options."""
        yield "net.pt", lambda out, workers, *more: self.command(out, workers, *more, **LONG)
        for kind in KINDS:
            yield f"{kind}.model", lambda out, workers, *more, kind=kind: self.forest(kind, out, workers, *more, **TREES)

    def start_on_both(self, machines, command):
        """Worker 0 on the first, worker 1 on the second machine."""
        port = free_port()
        return [self.start(machines.on(rank, command), **{**met(rank, 2, port), "MASTER_ADDR": ADDRESSES[0]}) for rank in (0, 1)]

    def whole(self, name, command):
        """The bytes that one worker ends with."""
        succeeded(self.start(command(f"whole.{name}", 1)))
        return self.bytes_of(f"whole.{name}")


def pulled_and_put_back(place):
    with two_machines() as machines:
        for name, command in place.trainings():
            workers = place.start_on_both(machines, command(name, 2, "--wait", "60"))
            place.wait_for_checkpoint(name, workers[0])
            machines.cut()
            time.sleep(PULLED_S)
            assert all(worker.poll() is None for worker in workers), "faster than the cut"
            machines.mend()
            for worker in workers:
                succeeded(worker)
            assert place.bytes_of(name) == place.whole(name, command), name


def pulled_for_good(place):
    def large(out, workers, *more):
        return place.command(out, workers, *more, network=LARGE_NETWORK, size=96, **LONG)

    with two_machines() as machines:
        # Forests of all kinds talk in one way; large networks also while they compute.
        for name, command in (*itertools.islice(place.trainings(), 2), ("large.pt", large)):
            workers = place.start_on_both(machines, command(name, 2, *WAIT))
            place.wait_for_checkpoint(name, workers[0])
            machines.cut()
            begin = time.monotonic()
            failed_with(workers[0], "worker 1 of 2 was lost", "its connection was cut", "--resume")
            failed_with(workers[1], "worker 0 of 2 was lost", "its connection was cut", "--resume")
            assert time.monotonic() - begin < 60, "long after the time to wait"
            machines.mend()
            for worker in place.start_on_both(machines, command(name, 2, "--resume")):
                succeeded(worker)
            assert place.bytes_of(name) == place.whole(name, command), name


def full_disk(place):
    with two_machines() as machines, machines.small_disk(0, place.folder / "small", 2000) as small:
        for name, command in place.trainings():
            out = f"small/{name}"
            workers = place.start_on_both(machines, command(out, 2))
            place.wait_for_checkpoint(out, workers[0])
            ballast = fill(small / "ballast")
            failed_with(workers[0], name, "No space left on device")
            assert ended(workers[1])[0] == 1
            ballast.unlink()
            succeeded(place.start(command(out, 1, "--resume")))
            assert place.bytes_of(out) == place.whole(name, command), name


def fill(path):
    """Writes until there is no more space."""
    with path.open("wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)):
                pass
        except OSError:
            return path


if __name__ == "__main__":
    enter_first_machine()
    run_case(TwoMachinesPlace, pulled_and_put_back, pulled_for_good, full_disk)
