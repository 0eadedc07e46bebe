# SPDX-License-Identifier: Apache-2.0
"""Python threads: the same answers as one, at the same time; a tracker refuses two."""

import concurrent.futures
import threading
import time
import unittest

import numpy as np

import knuckle
from testing import SMALL_PIPELINE, demo_frames, poses_of

CALLS = 40


class Threads(unittest.TestCase):
    def test_four_threads_give_the_same_answers(self):
        pipeline = knuckle.Pipeline.default()
        frames = list(demo_frames()[:8])
        estimate = lambda frame: poses_of(pipeline.estimate(frame.depth_mm, frame.camera))  # noqa: E731
        expected = [estimate(frame) for frame in frames]
        with concurrent.futures.ThreadPoolExecutor(4) as threads:
            self.assertEqual(list(threads.map(estimate, 3 * frames)), 3 * expected)

    def test_four_threads_render_the_same_frames(self):
        frames = demo_frames()
        expected = [frames[i].depth_mm.tobytes() for i in range(8)]
        with concurrent.futures.ThreadPoolExecutor(4) as threads:
            self.assertEqual([frame.depth_mm.tobytes() for frame in threads.map(frames.__getitem__, range(8))], expected)

    def test_other_threads_run_while_it_computes(self):
        pipeline, frame = knuckle.Pipeline.default(), demo_frames()[0]
        is_done = threading.Event()

        def compute():
            for _ in range(CALLS):
                pipeline.estimate(frame.depth_mm, frame.camera)
            is_done.set()

        thread = threading.Thread(target=compute)
        thread.start()
        turns = 0
        while not is_done.is_set():
            time.sleep(0.0002)
            turns += 1
        thread.join()
        self.assertGreater(turns, 3 * CALLS)  # with the lock held there would be one between two calls

    def test_a_tracker_is_for_one_thread(self):
        tracker = knuckle.Tracker(knuckle.Pipeline.from_toml(SMALL_PIPELINE))
        frames = demo_frames()
        timed = [knuckle.Frame(frames[0].depth_mm, frames[0].camera, time_s=i / 30) for i in range(60)]
        faults = []

        def update():
            for frame in timed:
                try:
                    tracker.update(frame)
                except knuckle.Error as error:
                    faults.append(str(error))

        threads = [threading.Thread(target=update) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(faults)
        self.assertEqual(set(faults), {"tracker: two threads use it at once; each needs its own"})

    def test_an_estimator_that_calls_its_tracker(self):
        frame, faults = demo_frames()[3], []

        def again(patch):
            try:
                tracker.update(frame)
            except knuckle.Error as error:
                faults.append(str(error))
            return np.full((22, 3), 0.1 * float(patch.min()))

        tracker = knuckle.Tracker(knuckle.Pipeline.from_toml('[segmentation]\nmethod = "threshold"\n',
                                                             estimator=knuckle.Estimator(again, "knuckle22")))
        tracker.update(frame)
        self.assertEqual(set(faults), {"tracker: is called by its own pipeline's estimator, before it has done with the last frame"})


if __name__ == "__main__":
    unittest.main()
