# SPDX-License-Identifier: Apache-2.0
"""What scripts that measure have in common: they run the program, and what it makes lies in one folder."""
import argparse
import csv
import json
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


class Laboratory:
    """Runs the program; what it makes lies in one folder."""

    def __init__(self, program, out):
        self.program, self.out = program, out
        self.out.mkdir(parents=True, exist_ok=True)

    def run(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"knuckle {' '.join(map(str, arguments))}\n{done.stderr}")
        return done.stdout + done.stderr

    def rendered(self, name, manifest=None, text=None):
        """The set of a manifest, or of a manifest's text."""
        path = self.out / f"{name}.h5"
        if text is not None:
            manifest = self.out / f"{name}.toml"
            manifest.write_text(text)
        if not path.exists():
            self.run("render", "--manifest", manifest, "--out", path)
        return path

    def pipeline(self, name, **keys):
        """A shipped pipeline, with some of its keys changed; `refine=False` takes all its steps away."""
        text = (ROOT / "pipelines" / f"{name}.toml").read_text().replace('"../', f'"{ROOT}/')
        if not keys.pop("refine", True):
            text = text[: text.index("[[refine]]")]
        for key, value in keys.items():
            text, found = re.subn(rf"(?m)^{key} = \S+", f"{key} = {value}", text)
            assert found == 1, key
        path = self.out / f"{name}_{len(list(self.out.glob(f'{name}_*.toml')))}.toml"
        path.write_text(text)
        return path

    def estimated(self, name, source, pipeline, *options):
        """Poses and records; the program's last line says how long a frame took."""
        poses, records = self.out / f"{name}.txt", self.out / f"{name}.jsonl"
        said = self.run("estimate", "--source", source, "--pipeline", pipeline, "--out", poses, "--records", records, *options)
        return poses, records, float(re.search(r"median ([0-9.]+) ms", said)[1])

    def scored(self, name, source, poses=None, records=None, strip=False):
        """The report's metrics.json, and the error of each frame."""
        report = self.out / f"report_{name}"
        arguments = ["evaluate", "--truth", source, "--out", report]
        if poses:
            arguments += ["--predictions", f"a={poses}"]
        if records:
            arguments += ["--records", f"a={records}"]
        if strip:
            arguments += ["--strip", self.out / f"strip_{name}.png"]
        self.run(*arguments)
        errors = {}
        if poses:
            with open(report / "frames.csv", encoding="utf-8") as file:
                errors = {int(row["frame"]): float(row["mean_3d_mm"]) for row in csv.DictReader(file) if row["mean_3d_mm"]}
        return json.loads((report / "metrics.json").read_text()), errors


def laboratory_and_recordings(description):
    """As the command line says; no recordings: None."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/knuckle")
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    recordings = arguments.recordings.resolve() if arguments.recordings else None
    return Laboratory(arguments.program.resolve(), arguments.out.resolve()), recordings
