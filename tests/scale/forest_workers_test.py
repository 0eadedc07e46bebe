#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Forests trained by several processes: the same bytes for any number of workers, killed and resumed with another; and each way in
which one of them is missing, lost or different ends all with one line.

    forest_workers_test.py CASE PROGRAM
"""
import os
import signal
import subprocess
import sys
import time

from slurm_testing import local_slurm
from training_testing import LONGEST_S, PROJECT, ended, failed_with, run_case, succeeded
from workers_testing import WorkersPlace, free_port, met

KINDS = ("pose-forest", "segmentation-forest")
CONFIG = {
    "pose-forest": """
source = 'synthetic:{manifest}?count={frames}'
[patch]
size_px = 24
[forest]
splits_per_node = {splits}
samples_per_node = 40
min_leaf_samples = 2
""",
    "segmentation-forest": """
source = 'synthetic:{manifest}?count={frames}'
[pixels]
hand_pixels = 60
background_pixels = 30
[forest]
splits_per_node = {splits}
offsets_per_node = 32
samples_per_node = 1500
min_leaf_samples = 2
""",
}


class ForestPlace(WorkersPlace):
    """A folder with configurations of forests, and the program that trains from them."""

    def forest(self, kind, out, workers, *more, trees=2, frames=40, splits=60, config="train.toml"):
        text = CONFIG[kind].format(manifest=PROJECT / "manifests/demo.toml", frames=frames, splits=splits)
        (self.folder / config).write_text(f"{text}trees = {trees}\n")
        return [self.program, "train", kind, "--config", self.folder / config, "--out", self.folder / out, "--workers",
                str(workers), *more]

    def forget(self, out):
        for name in (out, f"{out}.checkpoint", f"{out}.checkpoint.tree"):
            (self.folder / name).unlink(missing_ok=True)


def same_bytes(place):
    for kind in KINDS:
        for workers in (1, 2, 4):
            out = succeeded(place.start(place.forest(kind, f"{workers}.model", workers)))
            place.assert_all_end()
            assert workers == 1 or f"{workers} workers;" in out, out
        assert place.bytes_of("1.model") == place.bytes_of("2.model") == place.bytes_of("4.model"), kind
        assert not (place.folder / "4.model.checkpoint").exists()


def resumed(place):
    for kind in KINDS:
        long = {"trees": 30, "splits": 400}
        succeeded(place.start(place.forest(kind, "whole.model", 1, **long)))
        for before, after in ((2, 4), (4, 1), (1, 2)):
            process = place.start(place.forest(kind, "parts.model", before, **long))
            place.wait_for_checkpoint("parts.model", process)
            process.kill()
            assert ended(process)[0] == -signal.SIGKILL, "faster than its killer"
            while place.started_workers():
                time.sleep(0.05)
            succeeded(place.start(place.forest(kind, "parts.model", after, "--resume", **long)))
            assert place.bytes_of("parts.model") == place.bytes_of("whole.model"), (kind, before, after)
            place.forget("parts.model")


def lost_worker(place):
    for kind in KINDS:
        process = place.start(place.forest(kind, "f.model", 3, trees=250))
        place.wait_for_checkpoint("f.model", process)
        os.kill(place.started_workers()[1], signal.SIGKILL)
        failed_with(process, "worker 1 of 3 was ended by signal 9", "--resume")
        place.assert_all_end()
        assert (place.folder / "f.model.checkpoint").exists(), "what was done is kept"
        place.forget("f.model")
        process = place.start(place.forest(kind, "f.model", 2, trees=250))
        place.wait_for_checkpoint("f.model", process)
        for worker in (process.pid, *place.started_workers().values()):
            os.kill(worker, signal.SIGINT)
        failed_with(process, "interrupted after", "--resume")
        place.assert_all_end()
        place.forget("f.model")


def failed_at_its_end(place):
    """Where worker 0 cannot write its model, when all that workers do together is done, the other has not succeeded either."""
    for kind in KINDS:
        port = free_port()
        workers = [place.start(place.forest(kind, "f.model", 2, trees=30), **met(rank, 2, port)) for rank in (0, 1)]
        place.wait_for_checkpoint("f.model", workers[0])
        (place.folder / "f.model").mkdir()  # in its way
        failed_with(workers[0], "f.model")
        assert ended(workers[1])[0] == 1, "it says that there is a model"
        (place.folder / "f.model").rmdir()
        succeeded(place.start(place.forest(kind, "f.model", 1, "--resume", trees=30)))
        succeeded(place.start(place.forest(kind, "whole.model", 1, trees=30)))
        assert place.bytes_of("f.model") == place.bytes_of("whole.model"), "what was done is not kept"
        place.forget("f.model")


def missing_worker(place):
    for kind in KINDS:
        failed_with(place.start(place.forest(kind, "f.model", 2, "--wait", "5"), **met(0, 2, free_port())),
                    "worker 1 of 2 did not come", "5 s")
        failed_with(place.start(place.forest(kind, "f.model", 3), **met(0, 2, free_port())), "--workers 2")
    assert not (place.folder / "f.model").exists()


def other_options(place):
    kind = KINDS[0]
    port = free_port()
    other = place.start(place.forest(kind, "f.model", 2, config="other.toml", trees=7), **met(1, 2, port))
    failed_with(place.start(place.forest(kind, "f.model", 2), **met(0, 2, port)), "worker 1 of 2", "other options")
    assert ended(other)[0] == 1
    port = free_port()
    other = place.start(place.forest(kind, "f.model", 2), **met(1, 2, port))
    succeeded(place.start(place.forest(kind, "f.model", 2), **met(0, 2, port)))
    status, out, lines, _ = ended(other)
    assert status == 0 and not out and not lines, "worker 0 alone speaks"
    # A checkpoint of other samples is refused by worker 0, and all end.
    process = place.start(place.forest(kind, "g.model", 2, trees=250))
    place.wait_for_checkpoint("g.model", process)
    process.kill()
    ended(process)
    place_is_empty = place.forest(kind, "g.model", 2, "--resume", trees=250, frames=30)
    failed_with(place.start(place_is_empty), "g.model.checkpoint", "other options or samples")
    place.assert_all_end()


def bad_source(place):
    """What only one worker meets is said by its name."""
    bad = place.forest(KINDS[1], "f.model", 2)
    text = (place.folder / "train.toml").read_text()
    (place.folder / "train.toml").write_text(text.replace("[pixels]", "[pixels]\nwrist_mm = 30.0").replace("synthetic:", "synthetic:/none"))
    failed_with(place.start(bad), "/none")
    place.assert_all_end()


def full_disk(place):
    for kind in KINDS:
        command = place.forest(kind, "f.model", 2, trees=60, splits=20)
        limited = place.start(command, longest_file=3000)
        failed_with(limited, "f.model")
        place.assert_all_end()


def slurm(place):
    with local_slurm(place.folder / "slurm") as found:
        for kind in KINDS:
            # By hand, then by the script, for an allocation of both tasks.
            arguments = place.forest(kind, f"{kind}.two", 2)
            step = ["srun", "--ntasks=2", "--cpus-per-task=1", "--overcommit", *arguments]
            succeeded(place.start(step, **found, MASTER_ADDR="127.0.0.1"))
            log = place.folder / f"{kind}.log"
            job = ["sbatch", "--wait", "--ntasks=2", "--overcommit", f"--output={log}", f"--chdir={PROJECT}",
                   PROJECT / "scripts/slurm/train_forest.sh", kind, arguments[arguments.index("--config") + 1], place.folder / f"{kind}.job"]
            process = place.start(job, **found, KNUCKLE=str(place.program), SLURM_OVERCOMMIT="1")
            assert ended(process)[0] == 0, log.read_text()
            assert "2 workers" in log.read_text(), log.read_text()
    for kind in KINDS:
        succeeded(place.start(place.forest(kind, f"{kind}.one", 1)))
        assert place.bytes_of(f"{kind}.one") == place.bytes_of(f"{kind}.two") == place.bytes_of(f"{kind}.job"), kind


if __name__ == "__main__":
    run_case(ForestPlace, same_bytes, resumed, lost_worker, failed_at_its_end, missing_worker, other_options, bad_source, full_disk, slurm)
