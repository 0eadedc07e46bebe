# SPDX-License-Identifier: Apache-2.0
"""Parts of scripts/soak.py that go on where they were stopped: rendering, estimating, training. Each is killed at random moments and begun
again until it is whole; then its files have the bytes of an undisturbed run."""
import random
import shutil
import signal
import threading
import time

from soak_place import LONGEST_S, Started

NETWORK = """
source = 'synthetic:{manifest}?count=300'
validation = 'synthetic:{manifest}?first=300&count=4'
start = 'truth'
[patch]
mode = 'cube'
size_px = 32
[samples]
crop_px = 48
centre = 'joints'
memory_gb = 0.1
[network]
convention = 'icg20'
architecture = 'dense'
stem_channels = 4
quarter_channels = 8
eighth_channels = 8
sixteenth_channels = 8
head_channels = 8
[training]
epochs = {epochs}
batch_size = 24
shards = 2
validate_every = 10
"""
FOREST = """
source = 'synthetic:{manifest}?count=300'
[patch]
size_px = 24
[forest]
splits_per_node = {splits}
samples_per_node = 40
min_leaf_samples = 2
trees = {trees}
"""


def content_of(path):
    """A file, without what may be another each time: the command line in resolved options, the speed in the metrics of a training."""
    if path.name.endswith(".options.toml"):
        return path.read_text().partition("\n")[2]
    if path.name.endswith(".metrics.csv"):
        return [line.split(",")[:-2] for line in path.read_text().splitlines()]
    return path.read_bytes()


class Job:
    """Commands one after another, and the files that come of them."""

    def __init__(self, place, who, results, commands):
        self.place, self.who, self.commands = place, who, commands
        self.results = results  # names of files that have to be the same
        self.chance = random.Random(f"{place.seed} {who}")
        self.whole = place.folder / "whole" / who
        self.seconds = 0.0

    def begin(self):
        """The undisturbed run."""
        self.whole.mkdir(parents=True)
        start = time.monotonic()
        for command in self.commands(self.whole, self.chance):
            self.place.undisturbed(self.who, command)
        self.seconds = time.monotonic() - start

    def run(self):
        rounds = 0
        while not self.place.calm.is_set():
            rounds += 1
            folder = self.place.disk.folder / f"{self.who}-{rounds}"
            if not self.make_folder(folder):
                break
            was_killed = [self.finish(folder, step) for step in range(len(self.commands(folder, self.chance)))]
            if None in was_killed:
                break
            self.compare(folder, rounds, any(was_killed))
            shutil.rmtree(folder)

    def make_folder(self, folder):
        while True:
            try:
                folder.mkdir()
                return True
            except OSError:  # the disk is full
                time.sleep(0.5)
            if self.place.calm.is_set():
                return False

    def finish(self, folder, step):
        """One command to its end, however often it is stopped; whether it was killed. None: it cannot be finished."""
        was_killed = False
        known = len(self.place.log.faults)
        while True:
            run = Started(self.place, self.who, self.commands(folder, self.chance)[step])
            killer = self.killer_of(run)
            is_done = run.end(max(LONGEST_S, 60 * self.seconds))
            if killer:
                killer.cancel()
            if run.sent:
                self.place.log.count(self.who, "kills")
                was_killed |= run.sent == signal.SIGKILL
            if is_done:
                return was_killed
            if len(self.place.log.faults) > known + 20:  # it is said by now
                return None
            time.sleep(self.chance.uniform(0.0, 1.0))

    def killer_of(self, run):
        if self.place.calm.is_set() or self.chance.random() < 0.3:
            return None
        which = signal.SIGKILL if self.chance.random() < 0.7 else signal.SIGTERM
        killer = threading.Timer(self.chance.uniform(0.0, 0.9 * self.seconds), run.kill, [which])
        killer.start()
        return killer

    def compare(self, folder, rounds, was_killed):
        self.place.log.count(self.who, "rounds")
        for name in self.results:
            self.place.log.count(self.who, "comparisons")
            if not (folder / name).exists():
                self.differs(rounds, name, "is lost")
            elif content_of(folder / name) != content_of(self.whole / name):
                self.differs(rounds, name, "is another than undisturbed")
                shutil.copy(folder / name, self.place.folder / f"{self.who}-{rounds}-{name}")
        expected = {path.relative_to(self.whole) for path in self.whole.rglob("*")}
        left = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.relative_to(folder) not in expected)
        self.place.log.count(self.who, "left by kills", len(left))
        if left and not was_killed:
            self.place.log.broken(self.who, f"round {rounds}: {left} were left over, and nothing was killed")

    def differs(self, rounds, name, how):
        self.place.log.count(self.who, "differences")
        self.place.log.broken(self.who, f"round {rounds}: {name} {how}")


def render_job(place, manifest, count):
    """In two parts, which are joined."""
    def commands(folder, _):
        parts = [folder / "part-0.h5", folder / "part-1.h5"]
        render = [["render", "--manifest", manifest, "--count", count, "--shard", f"{i}/2", "--out", part, "--threads", "1"]
                  for i, part in enumerate(parts)]
        whole = folder / "set.h5"  # there already where `join` was killed after its last write
        return [*render, ["inspect", "--source", f"h5:{whole}"] if whole.exists() else ["join", *parts, "--out", whole]]

    return Job(place, "render", ["part-0.h5", "part-0.h5.options.toml", "part-1.h5", "part-1.h5.options.toml", "set.h5"], commands)


def estimate_job(place, manifest, count):
    def commands(folder, _):
        return [["estimate", "--source", f"synthetic:{manifest}?count={count}", "--out", folder / "poses.txt", "--records", folder / "poses.jsonl",
                 "--resume", "--threads", "1"]]

    return Job(place, "estimate", ["poses.txt", "poses.txt.options.toml", "poses.jsonl"], commands)


def network_job(place, manifest, epochs):
    """By one process or two, as it comes: the bytes are the same."""
    config = place.folder / "network.toml"
    config.write_text(NETWORK.format(manifest=manifest, epochs=epochs))

    def commands(folder, chance):
        out = folder / "net.pt"
        resume = ["--resume"] if out.with_name("net.pt.checkpoint").exists() else []
        return [["train", "network", "--config", config, "--out", out, "--cache", folder / "cache", "--threads", "1", "--workers",
                 "2" if chance.random() < 0.25 else "1", *resume]]

    return Job(place, "train-network", ["net.pt", "net.pt.metrics.csv", "net.pt.options.toml"], commands)


def forest_job(place, manifest, trees):
    config = place.folder / "forest.toml"
    config.write_text(FOREST.format(manifest=manifest, splits=400, trees=trees))

    def commands(folder, _):
        return [["train", "pose-forest", "--config", config, "--out", folder / "forest.model", "--resume", "--threads", "1"]]

    return Job(place, "train-forest", ["forest.model", "forest.model.options.toml"], commands)


class LongEstimate:
    """One run beside all of it, on a disk that has room: its memory stays flat. At the end it is interrupted, and what it has
    written begins as the undisturbed run's."""

    who = "estimate-on"

    def __init__(self, place, manifest, shorter):
        self.place, self.manifest, self.shorter = place, manifest, shorter

    def begin(self):
        pass

    def run(self):
        out = self.place.folder / "long.txt"
        run = Started(self.place, self.who, ["estimate", "--source", f"synthetic:{self.manifest}", "--out", out, "--threads", "1"])
        self.place.calm.wait()
        run.kill(signal.SIGTERM)
        run.end(LONGEST_S)
        ours = out.with_name("long.txt.partial").read_bytes()
        whole = (self.shorter.whole / "poses.txt").read_bytes()
        length = min(len(ours), len(whole))
        self.place.log.count(self.who, "rounds")
        self.place.log.count(self.who, "frames", ours.count(b"\n") - 1)
        self.place.log.count(self.who, "comparisons")
        if ours[:length] != whole[:length] or not ours.endswith(b"\n"):
            self.place.log.broken(self.who, "long.txt.partial begins otherwise than undisturbed")
