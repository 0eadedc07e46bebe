#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A small experiment whose steps are jobs of Slurm: the results of one process, also where it is killed and started again; and a job
that fails is named in one line. Skipped by name where this machine cannot have a Slurm.

    experiment_slurm_test.py CASE PROGRAM
"""
import signal
import subprocess
import time

from slurm_testing import local_slurm
from training_testing import LONGEST_S, PROJECT, SMALL_NETWORK, Place, ended, failed_with, run_case, succeeded

FILES = {
    "forest.toml": "source = 'synthetic:scene.toml?count=40'\n[patch]\nsize_px = 24\n[forest]\ntrees = {trees}\nsplits_per_node = 100\n"
                   "samples_per_node = 40\nmin_leaf_samples = 2\n",
    "net.toml": "source = 'synthetic:scene.toml?count=28'\nvalidation = 'synthetic:scene.toml?first=28&count=12'\nstart = 'truth'\n"
                "[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 48\n" + SMALL_NETWORK +
                "[training]\nepochs = 4\nbatch_size = 8\nshards = 4\nvalidate_every = 10\n",
    "threshold.toml": "[segmentation]\nmethod = 'threshold'\n",
    "by_forest.toml": "[segmentation]\nmethod = 'mean_shift'\n[estimator]\nmethod = 'forest'\nmodel = '../models/forest.model'\n",
    "by_net.toml": "[segmentation]\nmethod = 'mean_shift'\n[estimator]\nmethod = 'dense'\nmodel = '../models/net.pt'\n",
    "plan.toml": "title = 'A small plan'\n[[sequence]]\nname = 'scene'\ntitle = 'The scene'\nsource = 'synthetic:scene.toml?count=12'\n"
                 "[[model]]\nfile = 'forest.model'\nkind = 'pose-forest'\nconfig = 'forest.toml'\n"
                 "[[model]]\nfile = 'net.pt'\nkind = 'network'\nconfig = 'net.toml'\n"
                 "[[segmentation]]\nname = 'threshold'\npipeline = 'threshold.toml'\n"
                 "[[estimation]]\nname = 'forest'\npipeline = 'by_forest.toml'\n"
                 "[[estimation]]\nname = 'net'\npipeline = 'by_net.toml'\n",
}
STEPS = ("models/forest.model", "models/net.pt", "scene/boxes/threshold.csv", "scene/poses/forest.txt", "scene/poses/net.txt",
         "report.html")
# Two tasks and a job beside them, on machines of few cores.
SLURM = "--overcommit --oversubscribe"


class ExperimentPlace(Place):
    """A place with a plan of one short sequence, a forest and a network."""

    def __init__(self, program, folder):
        super().__init__(program, folder)
        (folder / "scene.toml").write_bytes((PROJECT / "manifests/demo.toml").read_bytes())
        self.write_plan()

    def write_plan(self, trees=3):
        for name, text in FILES.items():
            (self.folder / name).write_text(text.replace("{trees}", str(trees)))

    def command(self, out, *more):
        return [self.program, "experiment", self.folder / "plan.toml", "--out", self.folder / out, "--threads", "1", "--scale", "0.8", *more]

    def by_slurm(self, out, *more):
        return self.command(out, "--slurm", SLURM, *more)

    def results(self, out):
        """Models, poses and tables: what is the same in every run."""
        folder = self.folder / out
        files = [*(folder / "models").glob("*.model"), *(folder / "models").glob("*.pt"), *(folder / "tables").iterdir(),
                 *(folder / "scene/poses").glob("*.txt"), folder / "scene/metrics.json"]
        return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def jobs_in_queue(found, place):
    said = subprocess.run(["squeue", "--noheader", "--format=%j"], env=place.environment(**found), check=True, capture_output=True, text=True)
    return said.stdout.split()


def workers(place):
    """Needs no Slurm."""
    for model in ("forest.model", "net.pt"):
        for count in ("1", "2"):
            succeeded(place.start(place.command(count, "--step", f"models/{model}", "--workers", count)))
        assert place.bytes_of(f"1/models/{model}") == place.bytes_of(f"2/models/{model}")


def same_results(place):
    with local_slurm(place.folder / "slurm") as found:
        out = succeeded(place.start(place.by_slurm("jobs", "--workers", "2"), **found))
        assert out.count(": job ") == len(STEPS), out
        again = succeeded(place.start(place.by_slurm("jobs", "--workers", "2"), **found))
        assert ": job " not in again, "a second run has nothing to do"
    assert "2 workers" in (place.folder / "jobs/logs/models_forest.model.log").read_text()
    assert not [*(place.folder / "jobs").rglob("*.claim"), *(place.folder / "jobs").rglob("*.begun")]
    succeeded(place.start(place.command("here")))
    expected = place.results("here")
    assert len(expected) >= 8 and place.results("jobs") == expected, (sorted(expected), sorted(place.results("jobs")))


def killed(place):
    place.write_plan(trees=120)
    with local_slurm(place.folder / "slurm") as found:
        first = place.start(place.by_slurm("jobs"), **found)
        place.wait_for("jobs/models/forest.model.checkpoint", first)
        first.kill()
        assert ended(first)[0] == -signal.SIGKILL, "faster than its killer"
        assert jobs_in_queue(found, place), "the jobs go on alone"
        # Two at once: each step is still done by one.
        both = [place.start(place.by_slurm("jobs"), **found) for _ in range(2)]
        for process in both:
            succeeded(process)
        second = place.start(place.by_slurm("interrupted"), **found)
        place.wait_for("interrupted/models/forest.model.checkpoint", second)
        second.send_signal(signal.SIGINT)
        failed_with(second, "interrupted", "the same command goes on")
        end = time.monotonic() + LONGEST_S
        while jobs_in_queue(found, place):
            assert time.monotonic() < end, "its jobs are cancelled"
            time.sleep(0.1)
        succeeded(place.start(place.by_slurm("interrupted"), **found))
    succeeded(place.start(place.command("here")))
    assert place.results("jobs") == place.results("interrupted") == place.results("here")


def failures(place):
    with local_slurm(place.folder / "slurm") as found:
        failed_with(place.start(place.command("refused", "--slurm", "--partition=none"), **found), "sbatch does not take it", "partition")
        net = (place.folder / "net.toml").read_text()
        (place.folder / "net.toml").write_text(net.replace("crop_px = 48", "crop_px = 48\nmemory_gb = 0.00001"))
        for more in ([], ["--workers", "2"]):
            failed_with(place.start(place.by_slurm("failed", *more), **found), "models/net.pt: job", "more than memory_gb",
                        "failed/logs/models_net.pt.log")
        failed_with(place.start(place.by_slurm("failed", "--workers", "2"), PATH="/nowhere"), "sbatch: not found")


if __name__ == "__main__":
    run_case(ExperimentPlace, workers, same_results, killed, failures)
