#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/average_networks.py: the mean of two networks' weights."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import import_testing  # noqa: F401 finds scripts, and skips where numpy is missing
import numpy as np

import knuckle_model_file as model_file

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "average_networks.py"
FORMAT = ("knuckle-network", 3)
DENSE = "[patch]\nsize_px = 96\n[network]\narchitecture = 'dense'\n"


class AverageNetworks(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return str(pathlib.Path(self.folder.name) / name)

    def write(self, name, weights, norms, options=DENSE):
        arrays = {"weights": np.array(weights, np.float16).view(np.uint16), "norms": np.array(norms, np.float32)}
        model_file.write(self.path(name), *FORMAT, {"options": options}, arrays, compact=False)

    def run_script(self, share, second="b.pt"):
        command = [sys.executable, SCRIPT, self.path("a.pt"), self.path(second), share, self.path("out.pt")]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_weights_and_norms_are_mixed(self):
        self.write("a.pt", [1.0, -2.0, 8.0], [0.5, 4.0])
        self.write("b.pt", [2.0, 2.0, 8.0], [1.5, 0.0])
        self.assertEqual(self.run_script("0.75").returncode, 0)
        values, arrays = model_file.read(self.path("out.pt"), *FORMAT)
        self.assertEqual(values, {"options": DENSE})
        self.assertEqual(arrays["weights"].view(np.float16).tolist(), [1.75, 1.0, 8.0])
        self.assertEqual(arrays["norms"].tolist(), [1.25, 1.0])

    def test_with_no_share_of_the_second_it_is_the_first(self):
        self.write("a.pt", [1.0, -2.0, 0.1], [0.5])
        self.write("b.pt", [2.0, 2.0, 3.0], [1.5])
        self.assertEqual(self.run_script("0").returncode, 0)
        self.assertEqual(pathlib.Path(self.path("out.pt")).read_bytes(), pathlib.Path(self.path("a.pt")).read_bytes())

    def test_a_newer_program_may_say_more(self):
        self.write("a.pt", [1.0], [0.5])
        self.write("b.pt", [2.0], [1.5], options=DENSE + "kernel = 0.8\n")
        self.assertEqual(self.run_script("0.5").returncode, 0)
        values, _ = model_file.read(self.path("out.pt"), *FORMAT)
        self.assertEqual(values, {"options": DENSE + "kernel = 0.8\n"})

    def test_what_has_no_mean_is_refused(self):
        self.write("a.pt", [1.0], [0.5])
        self.write("b.pt", [2.0], [1.5], options=DENSE.replace("96", "128"))
        for share, second, text in (("0.5", "b.pt", "other options"), ("1.5", "b.pt", "0 to 1"), ("0.5", "none.pt", "none.pt")):
            refused = self.run_script(share, second)
            self.assertEqual(refused.returncode, 1)
            self.assertIn(text, refused.stderr)
            self.assertEqual(len(refused.stderr.splitlines()), 1)
            self.assertFalse(pathlib.Path(self.path("out.pt")).exists())


if __name__ == "__main__":
    unittest.main()
