# SPDX-License-Identifier: Apache-2.0
"""The Python code of docs/python.md and the example run as they stand."""

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from testing import DEMO, PROJECT, demo_frames, program


class Documents(unittest.TestCase):
    def setUp(self):
        demo_frames()
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(scratch.name)

    def test_the_code_of_the_page(self):
        """One program of all its blocks, in a folder with what users have."""
        for command in (["render", "--manifest", DEMO, "--count", "12", "--format", "folder", "--out", "my_set"],
                        ["estimate", "--source", "folder:my_set", "--out", "poses.txt"]):
            subprocess.run([program(), *command], check=True, capture_output=True)
        blocks = re.findall(r"^```python\n(.*?)^```", (PROJECT / "docs/python.md").read_text(), re.MULTILINE | re.DOTALL)
        self.assertEqual(len(blocks), 4)
        depth = np.kron(demo_frames()[0].depth_mm, np.ones((2, 2), np.float32))  # 640 x 480
        with contextlib.redirect_stdout(io.StringIO()) as output:
            code = "\n".join(blocks).replace("v4l2:/dev/video2?format=z16", f"synthetic:{DEMO}?count=12&rate=1000")
            exec(code, {"depth": depth, "network": lambda patches: np.zeros((1, 66))})  # pylint: disable=exec-used
        for words in ("right", "000010", "000011", "(240, 320)"):
            self.assertIn(words, output.getvalue())

    def test_the_example(self):
        lines = subprocess.run([sys.executable, PROJECT / "examples/estimate.py", f"synthetic:{DEMO}?count=3"], check=True,
                               capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(len(lines), 3)
        for number, line in enumerate(lines):
            self.assertRegex(line, rf"^00000{number} right 0\.\d\d( -?\d+\.\d){{3}}$")


if __name__ == "__main__":
    unittest.main()
