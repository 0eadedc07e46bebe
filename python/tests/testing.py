# SPDX-License-Identifier: Apache-2.0
"""What the tests of the package share. CTest sets PYTHONPATH to the build's python/ and KNUCKLE_PROGRAM to its program."""

import os
import pathlib
import sys
import unittest

SKIPPED = 77  # CTest's SKIP_RETURN_CODE
PROJECT = pathlib.Path(__file__).resolve().parents[2]

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: numpy is missing")
    sys.exit(SKIPPED)

import knuckle

DEMO = knuckle.data_file("manifests/demo.toml")

# Fast, and a network's poses all the same; it takes the nearest thing for the hand.
SMALL_PIPELINE = """
[segmentation]
method = "threshold"
[estimator]
method = "dense"
model = "../models/dense.pt"
"""


def program():
    return os.environ["KNUCKLE_PROGRAM"]


def demo_frames():
    """The demo's frames, or the reason to skip a test: there is no body to render."""
    try:
        return knuckle.open_source(f"synthetic:{DEMO}")
    except knuckle.Error as error:
        if "body" not in str(error):
            raise
        raise unittest.SkipTest(str(error)) from None


def poses_of(estimate):
    """All numbers of an estimate, for comparisons to the last bit."""
    return [(hand.score, hand.landmarks_mm.tobytes(), hand.landmarks_px.tobytes(), hand.confidence.tobytes(), hand.angles_rad)
            for hand in estimate.hands]
