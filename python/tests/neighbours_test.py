# SPDX-License-Identifier: Apache-2.0
"""h5py and OpenCV in the same process, with libraries of their own or with ours, imported before and after."""

import importlib.util
import subprocess
import sys
import tempfile
import unittest

from testing import DEMO, demo_frames, program

WORK = f"""
import os, sys
import numpy as np
for name in sys.argv[1:]:
    globals()[name] = __import__(name)

def use_neighbours(depth):
    if "h5py" in sys.argv:
        with h5py.File("own.h5", "w") as file:
            file.create_dataset("depth", data=depth, compression="gzip", chunks=True)
        with h5py.File("own.h5") as file:
            assert np.array_equal(file["depth"][:], depth)
    if "cv2" in sys.argv:
        whole_mm = np.rint(depth).astype(np.uint16)
        assert np.array_equal(cv2.imdecode(cv2.imencode(".png", whole_mm)[1], cv2.IMREAD_UNCHANGED), whole_mm)
        cv2.GaussianBlur(depth, (5, 5), 0)

def numbers():
    frame = knuckle.open_source("h5:set.h5")[0]
    rendered = knuckle.render({str(DEMO)!r}, 0)
    hand, = knuckle.Pipeline.default().estimate(rendered.depth_mm, rendered.camera).hands
    return frame.depth_mm, hand.landmarks_mm

first = numbers()
use_neighbours(first[0])
for before, after in zip(first, numbers()):
    assert np.array_equal(before, after)
use_neighbours(first[0])
sys.stdout.write(first[1].tobytes().hex())
"""


class Neighbours(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        demo_frames()
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = scratch.name
        subprocess.run([program(), "render", "--manifest", DEMO, "--count", "2", "--out", "set.h5"], cwd=cls.folder, check=True,
                       capture_output=True)
        cls.expected = cls.numbers_with("knuckle")

    @classmethod
    def numbers_with(cls, *modules):
        """What a process finds that imports these in this order."""
        ran = subprocess.run([sys.executable, "-c", WORK, *modules], cwd=cls.folder, capture_output=True, text=True, check=False)
        assert (ran.stderr, ran.returncode) == ("", 0), (modules, ran.returncode, ran.stderr)
        return ran.stdout

    def assert_they_go_together(self, *modules):
        for module in modules:
            if importlib.util.find_spec(module) is None:
                self.skipTest(f"{module} is missing")
        for order in (("knuckle", *modules), (*modules, "knuckle")):
            self.assertEqual(self.numbers_with(*order), self.expected, order)

    def test_h5py(self):
        self.assert_they_go_together("h5py")

    def test_opencv(self):
        self.assert_they_go_together("cv2")

    def test_both(self):
        self.assert_they_go_together("h5py", "cv2")


if __name__ == "__main__":
    unittest.main()
