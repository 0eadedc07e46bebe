#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A network trained by several processes: the same bytes for any number of workers, killed and resumed with another; and each
way in which one of them is missing, lost or different ends all with one line.

    workers_test.py CASE PROGRAM
"""
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import time

from slurm_testing import local_slurm
from training_testing import LONGEST_S, PROJECT, SMALL_NETWORK, ended, failed_with, run_case, succeeded
from workers_testing import WorkersPlace, free_port, met

CONFIG = """
source = 'synthetic:{manifest}?count=12'
validation = 'synthetic:{manifest}?first=12&count=4'
start = 'truth'
[patch]
mode = 'cube'
size_px = {size}
[samples]
crop_px = {crop}
{network}
[training]
epochs = {epochs}
batch_size = 8
shards = 4
validate_every = {every}
"""
# Gradients of 4 and 8 MB, which go by themselves while those before them are computed.
LARGE_NETWORK = """
[network]
convention = 'icg20'
architecture = 'regression'
first_maps = 4
second_maps = 8
hidden_units = 1024
"""


class NetworkPlace(WorkersPlace):
    """A place with a configuration of a network."""

    def command(self, out, workers, *more, epochs=6, every=2, config="train.toml", network=SMALL_NETWORK, size=32):
        text = CONFIG.format(manifest=PROJECT / "manifests/demo.toml", epochs=epochs, every=every, network=network, size=size,
                             crop=3 * size // 2)
        (self.folder / config).write_text(text)
        return [self.program, "train", "network", "--config", self.folder / config, "--out", self.folder / out, "--workers",
                str(workers), "--cache", self.folder / "cache", *more]


def same_bytes(place, **network):
    for workers in (1, 2, 4):
        succeeded(place.start(place.command(f"{workers}.pt", workers, **network)))
        place.assert_all_end()
    assert place.bytes_of("1.pt") == place.bytes_of("2.pt") == place.bytes_of("4.pt")
    # The metrics, but for the two that are times.
    metrics = [[line.split(",")[:-2] for line in place.bytes_of(f"{workers}.pt.metrics.csv").decode().splitlines()]
               for workers in (1, 2, 4)]
    assert metrics[0] == metrics[1] == metrics[2], metrics


def same_bytes_large(place):
    same_bytes(place, network=LARGE_NETWORK, size=96)


def resumed(place):
    long = {"epochs": 40, "every": 12}  # 60 steps
    succeeded(place.start(place.command("whole.pt", 1, **long)))
    for before, after in ((2, 4), (4, 1)):
        process = place.start(place.command("parts.pt", before, **long))
        place.wait_for_checkpoint("parts.pt", process)
        process.kill()
        assert ended(process)[0] == -signal.SIGKILL, "faster than its killer"
        while place.started_workers():
            time.sleep(0.05)
        succeeded(place.start(place.command("parts.pt", after, "--resume", **long)))
        assert place.bytes_of("parts.pt") == place.bytes_of("whole.pt"), (before, after)
        (place.folder / "parts.pt").unlink()
        (place.folder / "parts.pt.checkpoint").unlink()


def lost_worker(place):
    for sent, name, wait_s in ((signal.SIGKILL, "worker 1 of 3 was ended by signal 9", 300),
                               (signal.SIGSTOP, "worker 1 of 3 was lost", 30)):
        process = place.start(place.command("net.pt", 3, "--wait", str(wait_s), epochs=4000))
        place.wait_for_checkpoint("net.pt", process)
        os.kill(place.started_workers()[1], sent)
        failed_with(process, name, "--resume")
        place.assert_all_end()
        (place.folder / "net.pt.checkpoint").unlink()
    process = place.start(place.command("net.pt", 2, epochs=4000))
    place.wait_for_checkpoint("net.pt", process)
    process.kill()
    failed = process.communicate(timeout=LONGEST_S)[1]
    assert "worker 0 of 2 was lost" in failed, failed
    place.assert_all_end()
    (place.folder / "net.pt.checkpoint").unlink()
    process = place.start(place.command("net.pt", 2, epochs=4000))
    place.wait_for_checkpoint("net.pt", process)
    for worker in (process.pid, *place.started_workers().values()):
        os.kill(worker, signal.SIGINT)
    failed_with(process, "interrupted after", "--resume")
    place.assert_all_end()


def lost_while_it_starts(place):
    """One that ends before it has met the others is not waited for."""
    process = place.start(place.command("net.pt", 2))
    while not (started := place.started_workers()):
        assert process.poll() is None, process.communicate()
    os.kill(started[1], signal.SIGKILL)
    failed_with(process, "worker 1 of 2 was ended by signal 9 before it had begun")
    place.assert_all_end()


def watches_for_signals(process):
    status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
    caught = int(re.search(r"^SigCgt:\s*(\w+)", status, re.MULTILINE).group(1), 16)
    return bool(caught >> signal.SIGTERM - 1 & 1)


def interrupted_while_it_starts(place):
    """The program that trains takes the first one's place: a signal that comes meanwhile is not lost, and ends nobody in silence."""
    for later_s in (0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8):
        process = place.start(place.command("net.pt", 2, epochs=4000))
        while not watches_for_signals(process):
            time.sleep(0.001)
        time.sleep(later_s)
        process.send_signal(signal.SIGTERM)
        failed_with(process, "interrupted")
        place.assert_all_end()
        (place.folder / "net.pt.checkpoint").unlink(missing_ok=True)


def missing_worker(place):
    failed_with(place.start(place.command("net.pt", 2, "--wait", "5"), **met(0, 2, free_port())), "worker 1 of 2 did not come",
                "5 s")
    failed_with(place.start(place.command("net.pt", 2, "--wait", "5"), **met(1, 2, free_port())), "worker 1 of 2", "no worker 0")
    failed_with(place.start(place.command("net.pt", 3), **met(0, 2, free_port())), "--workers 2")
    failed_with(place.start(place.command("net.pt", 8)), "8 workers for 4 shards")
    place.assert_all_end()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        failed_with(place.start(place.command("net.pt", 2, "--wait", "5"), **met(0, 2, port)), port, "in use")
    assert not (place.folder / "net.pt").exists()


def other_options(place):
    port = free_port()
    other = place.start(place.command("net.pt", 2, config="other.toml", epochs=7), **met(1, 2, port))
    failed_with(place.start(place.command("net.pt", 2), **met(0, 2, port)), "worker 1 of 2", "other options")
    assert ended(other)[0] == 1
    port = free_port()
    changed = place.folder / "knuckle-train-network"
    changed.write_bytes(place.program.with_name("knuckle-train-network").read_bytes() + b"another build")
    changed.chmod(0o755)
    other = place.start([changed, *place.command("net.pt", 2)[1:]], **met(1, 2, port))
    failed_with(place.start(place.command("net.pt", 2), **met(0, 2, port)), "worker 1 of 2", "another build")
    assert ended(other)[0] == 1
    port = free_port()
    other = place.start(place.command("net.pt", 2), **met(1, 2, port))
    succeeded(place.start(place.command("net.pt", 2), **met(0, 2, port)))
    status, out, lines, _ = ended(other)
    assert status == 0 and not out and not lines, "worker 0 alone speaks"
    port = free_port()
    other = place.start(place.command("elsewhere.pt", 2, "--resume"), **met(1, 2, port))  # where there is no checkpoint
    failed_with(place.start(place.command("net.pt", 2, "--resume"), **met(0, 2, port)), "worker 1 of 2", "elsewhere.pt.checkpoint")
    assert ended(other)[0] == 1


def full_disk(place):
    command = place.command("net.pt", 2)
    subprocess.run(place.command("first.pt", 1), cwd=PROJECT, env=place.environment(), check=True, stdout=subprocess.DEVNULL)
    limited = place.start(command, longest_file=30000)
    failed_with(limited, "net.pt")
    place.assert_all_end()


def slurm(place):
    with local_slurm(place.folder / "slurm") as found:
        arguments = place.command("two.pt", 2)
        config, cache = arguments[arguments.index("--config") + 1], arguments[arguments.index("--cache") + 1]
        # By hand, then by the script, for an allocation of both tasks.
        step = ["srun", "--ntasks=2", "--cpus-per-task=1", "--overcommit", *arguments]
        succeeded(place.start(step, **found, MASTER_ADDR="127.0.0.1"))
        log = place.folder / "job.log"
        job = ["sbatch", "--wait", "--ntasks=2", "--overcommit", f"--output={log}", f"--chdir={PROJECT}",
               PROJECT / "scripts/slurm/train_network.sh", config, place.folder / "job.pt", "--cache", cache]
        process = place.start(job, **found, KNUCKLE=str(place.program), SLURM_OVERCOMMIT="1")
        assert ended(process)[0] == 0, log.read_text()
        assert "2 workers" in log.read_text(), log.read_text()
    succeeded(place.start(place.command("one.pt", 1)))
    assert place.bytes_of("one.pt") == place.bytes_of("two.pt") == place.bytes_of("job.pt")


if __name__ == "__main__":
    run_case(NetworkPlace, same_bytes, same_bytes_large, resumed, lost_worker, lost_while_it_starts, interrupted_while_it_starts, missing_worker,
             other_options, full_disk, slurm)
