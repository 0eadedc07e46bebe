# SPDX-License-Identifier: Apache-2.0
"""Nothing that is called often keeps memory."""

import gc
import os
import pathlib
import unittest
import weakref

import numpy as np

import knuckle
from testing import SMALL_PIPELINE, demo_frames

FAST_PIPELINE = """
[segmentation]
method = "threshold"
[estimator]
method = "forest"
model = "../models/pose_forest.model"
"""
CALLS = 10_000
MOST_GROWTH = 4 << 20  # [bytes]: 400 a call; a hand's landmarks alone have 1,000


def resident_bytes():
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def growth_of(work, calls):
    """Of the second half of the calls: the first finds what is kept on purpose."""
    for _ in range(calls // 2):
        work()
    before = resident_bytes()
    for _ in range(calls // 2):
        work()
    return resident_bytes() - before


class Memory(unittest.TestCase):
    def assert_flat(self, work, calls=CALLS):
        self.assertLess(growth_of(work, calls), MOST_GROWTH)

    def test_estimates(self):
        frame, step = demo_frames()[3], 8
        depth, camera, start = frame.depth_mm[::step, ::step], frame.camera, frame.truth_mm[1]
        tiny = knuckle.Camera(camera.fx / step, camera.fy / step, camera.cx / step, camera.cy / step, 320 // step, 240 // step)
        pipeline = knuckle.Pipeline.from_toml(FAST_PIPELINE)
        self.assertEqual(len(pipeline.estimate(depth, tiny, start).hands), 1)

        def estimate():
            hand = pipeline.estimate(depth, tiny, start).hands[0]
            return hand.landmarks_mm, hand.landmarks_px, hand.confidence, hand.angles_rad

        self.assert_flat(estimate)

    def test_errors(self):
        pipeline = knuckle.Pipeline.from_toml(SMALL_PIPELINE)
        camera = knuckle.Camera(10, 10, 2, 2, 5, 5)

        def be_refused():
            for depth in (np.zeros((4, 5), np.float32), np.zeros((5, 5), np.int8)):
                try:
                    pipeline.estimate(depth, camera)
                except (knuckle.Error, TypeError):
                    continue
                self.fail("was not refused")

        self.assert_flat(be_refused)

    def test_frames(self):
        camera = knuckle.Camera(100, 100, 80, 60, 160, 120)
        depth = np.zeros((120, 160), np.uint16)
        self.assert_flat(lambda: knuckle.Frame(depth, camera).depth_mm.sum())
        frames = demo_frames()
        self.assert_flat(lambda: frames[0].mask.sum(), 100)

    def test_what_holds_itself_is_collected(self):
        """A method as the estimator, of an object that holds pipeline, estimator or tracker."""
        class Mine:
            def __init__(self, wrap):
                own = knuckle.Estimator(self.look, "knuckle22")
                self.held = wrap(own)

            def look(self, patch):
                return 0.1 * np.ones((22, 3)) * float(patch.min())

        class Kept(knuckle.Estimator):  # a class of one's own, with attributes
            pass

        def kept(own):
            mine = Kept(lambda patch: mine.other, "knuckle22")
            mine.other = own
            return mine

        def tracker(own):
            return knuckle.Tracker(pipeline(own))

        def pipeline(own):
            return knuckle.Pipeline.from_toml('[segmentation]\nmethod = "threshold"\n', estimator=own)

        frame = demo_frames()[3]
        for wrap in (lambda own: own, pipeline, tracker, kept, lambda own: [tracker(own), pipeline(own), own]):
            mine = Mine(wrap)
            gone = weakref.ref(mine)
            gc.collect()
            if wrap is pipeline:  # and works until then
                self.assertEqual(len(mine.held.estimate(frame.depth_mm, frame.camera).hands), 1)
            if wrap is tracker:
                mine.held.reset()
                mine.held.update(frame)
            del mine
            gc.collect()
            self.assertIsNone(gone())

    def test_a_tracker_keeps_its_pipeline(self):
        tracker = knuckle.Tracker(knuckle.Pipeline.from_toml(SMALL_PIPELINE))
        gc.collect()
        tracker.update(demo_frames()[3])


if __name__ == "__main__":
    unittest.main()
