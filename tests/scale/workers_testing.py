# SPDX-License-Identifier: Apache-2.0
"""What tests of trainings by several processes share: who they are, where they meet, and that none goes on alone."""
import pathlib
import socket
import time

from training_testing import LONGEST_S, Place


class WorkersPlace(Place):
    """A place whose program starts workers."""

    def started_workers(self):
        """Processes that worker 0 has started, by their rank."""
        mark = f"KNUCKLE_WORKERS_FOLDER={self.folder}".encode()
        found = {}
        for place in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                variables = (place / "environ").read_bytes().split(b"\0")
            except OSError:
                continue
            if any(variable.startswith(mark) for variable in variables):
                rank = next(variable for variable in variables if variable.startswith(b"KNUCKLE_WORKER="))
                found[int(rank.split(b"=")[1])] = int(place.name)
        return found

    def assert_all_end(self):
        end = time.monotonic() + LONGEST_S
        while self.started_workers():
            assert time.monotonic() < end, "a worker goes on alone"
            time.sleep(0.05)
        assert not list((self.folder / "tmp").iterdir()), "the workers' folder is left"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def met(rank, size, port):
    """The variables of a worker that another program has started."""
    return {"RANK": str(rank), "WORLD_SIZE": str(size), "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": port}
