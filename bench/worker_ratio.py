#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How fast two workers of one thread train beside one process of two threads, on the same two cores.

    /usr/bin/python3 bench/worker_ratio.py [--build build/release] [--rounds 5] [--frames 12000] [--only WORD] [--set FILE.h5]

`dense`, a pose forest and a segmentation forest, each trained by both in turns: steps per second of the network, seconds per tree of
the forests, each without the start and the reading of frames. Nothing else should run meanwhile.

--only takes those whose name has the word: a pose forest of the paper's size is `--only pose --frames 400000` (9 GB of memory).
--set takes frames that were rendered before (`knuckle render --manifest manifests/small_pictures.toml --count N`).
"""
import argparse
import csv
import pathlib
import re
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
WAYS = {"one process, two threads": ["--threads", "2"], "two workers, one thread each": ["--threads", "2", "--workers", "2"]}
SEGMENTATION = '[segmentation]\nmethod = "mean_shift"\nbandwidth_mm = 13.5\n'
NETWORK = f"""
source = "h5:FRAMES"
validation = "h5:FRAMES"
start = "truth"
{SEGMENTATION}
[patch]
mode = "cube"
size_px = 96
cube_mm = 250.0
[samples]
most = 2000
most_validation = 64
[network]
architecture = "dense"
convention = "knuckle22"
[training]
epochs = 4
batch_size = 64
shards = 2
validate_every = 20
seed = 1
"""
POSE_FOREST = f"""
source = "h5:FRAMES"
convention = "icg20"
start = "truth"
{SEGMENTATION}
[patch]
size_px = 96
[forest]
trees = 3
max_depth = 25
splits_per_node = 10000
samples_per_node = 5000
min_leaf_samples = 5
leaf_bits = 8
seed = 1
"""
SEGMENTATION_FOREST = """
source = "h5:FRAMES"
[pixels]
share = 1.0
hand_pixels = 120
background_pixels = 60
[forest]
trees = 3
max_depth = 25
splits_per_node = 10000
samples_per_node = 5000
min_leaf_samples = 5
seed = 1
"""


def train(program, kind, text, way, folder):
    """What the program printed; the model is thrown away."""
    config, model = folder / "train.toml", folder / "trained.model"
    config.write_text(text.replace("FRAMES", str(folder / "frames.h5")))
    for left in folder.glob("trained*"):
        left.unlink()
    return subprocess.run([program, "train", kind, "--config", config, "--out", model, *way], check=True, text=True, capture_output=True).stdout


def steps_per_second(program, way, folder, text=NETWORK):
    """The median over the rows of the metrics but the first, which waits for memory and processors to warm up."""
    train(program, "network", text, way, folder)
    with open(folder / "trained.model.metrics.csv", encoding="utf-8") as file:
        rates = [float(row["samples_per_second"]) for row in csv.DictReader(file)]
    return statistics.median(rates[1:])


def trees_per_second(kind, text, program, way, folder):
    """From the end of the first tree to that of the last."""
    printed = train(program, kind, text, way, folder)
    ends = [float(seconds) for seconds in re.findall(r"^tree \d+ of \d+ done after ([\d.]+) s", printed, re.MULTILINE)]
    return (len(ends) - 1) / (ends[-1] - ends[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frames", type=int, default=12000)
    parser.add_argument("--only", default="")
    parser.add_argument("--set", type=pathlib.Path)
    arguments = parser.parse_args()
    program = (arguments.build / "bin/knuckle").resolve()
    trainings = {
        "dense [samples/s]": steps_per_second,
        "pose forest [trees/s]": lambda *given: trees_per_second("pose-forest", POSE_FOREST, *given),
        "segmentation forest [trees/s]": lambda *given: trees_per_second("segmentation-forest", SEGMENTATION_FOREST, *given),
    }
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        if arguments.set:
            (folder / "frames.h5").symlink_to(arguments.set.resolve())
        else:
            subprocess.run([program, "render", "--manifest", ROOT / "manifests/small_pictures.toml", "--count", str(arguments.frames), "--out",
                            folder / "frames.h5"], check=True, stdout=subprocess.DEVNULL)
        for what, rate_of in trainings.items():
            if arguments.only not in what:
                continue
            rates = [[rate_of(program, way, folder) for way in WAYS.values()] for _ in range(arguments.rounds)]
            for name, of_way in zip(WAYS, zip(*rates)):
                print(f"{what}, {name}: " + ", ".join(f"{rate:.3g}" for rate in of_way))
            ratios = [workers / threads for threads, workers in rates]
            print(f"{what}, ratio: " + ", ".join(f"{ratio:.2f}" for ratio in ratios) + f"; median {statistics.median(ratios):.2f}", flush=True)


if __name__ == "__main__":
    main()
