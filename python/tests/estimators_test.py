# SPDX-License-Identifier: Apache-2.0
"""A function of one's own as the estimator: what it is shown, what becomes of its answer, and of its faults."""

import gc
import pathlib
import tempfile
import threading
import unittest
import warnings
import weakref

import numpy as np

import knuckle
from testing import DEMO, demo_frames

NEAREST = '[segmentation]\nmethod = "threshold"\n'
FIVE_TIPS = [knuckle.conventions["knuckle22"].index(f"{finger}_tip") for finger in ("thumb", "index", "middle", "ring", "little")]


def pipeline_of(function, toml=NEAREST, **options):
    return knuckle.Pipeline.from_toml(toml, estimator=knuckle.Estimator(function, options.pop("convention", "knuckle22"), **options))


def middle(patch):
    """All landmarks in the middle of the patch."""
    del patch
    return np.zeros((22, 3))


class Estimators(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frame = demo_frames()[3]
        cls.start = cls.frame.truth_mm[1]

    def estimate(self, pipeline, start=True):
        return pipeline.estimate(self.frame.depth_mm, self.frame.camera, self.start if start else None)

    def test_is_shown_the_cube_around_the_hand(self):
        seen = []
        pipeline = pipeline_of(lambda patch: seen.append(patch) or middle(patch), size_px=64, cube_mm=300)
        hand, = self.estimate(pipeline).hands
        patch, = seen
        self.assertEqual((patch.shape, patch.dtype), ((64, 64), np.float32))
        self.assertEqual(patch.max(), 1.0)  # what is not measured
        self.assertGreaterEqual(patch.min(), -1.0)
        self.assertTrue(0.05 < (patch < 1.0).mean() < 0.9)
        # The middle of the patch is the middle of the cube: the nearest pixel's depth is 150 mm a unit from there.
        centre = hand.landmarks_mm[0]
        np.testing.assert_allclose(hand.landmarks_mm, np.tile(centre, (22, 1)), atol=1e-9)
        nearest = self.frame.depth_mm[self.frame.depth_mm > 0].min()
        self.assertAlmostEqual(centre[2] + 150 * patch.min(), nearest, delta=0.5)

    def test_landmarks_are_in_patch_coordinates(self):
        corners = np.zeros((22, 3))
        corners[0], corners[1], corners[2] = (-1, -1, 0), (1, -1, 0.5), (-1, 1, -0.5)
        for side in (200.0, 320.0):
            size = 101
            hand, = self.estimate(pipeline_of(lambda patch: corners, size_px=size, cube_mm=side)).hands
            first, right, low, centre = hand.landmarks_px[0], hand.landmarks_px[1], hand.landmarks_px[2], hand.landmarks_px[3]
            depth = hand.landmarks_mm[3, 2]
            # From the first pixel's centre to the last one's, of a cube projected at its middle's depth.
            width = side * (size - 1) / size * self.frame.camera.fx / depth
            np.testing.assert_allclose(right - first, (width, 0), atol=1e-6)
            np.testing.assert_allclose(low - first, (0, width), atol=1e-6)
            np.testing.assert_allclose((right + low) / 2, centre, atol=1e-6)
            np.testing.assert_allclose(hand.landmarks_mm[1:3, 2] - depth, (side / 4, -side / 4), atol=1e-6)

    def test_knows_the_truth(self):
        """The function inverts what was done to the patch: a whole round trip."""
        frame, cube, places = self.frame, 250.0, []

        def truth(patch):
            size = patch.shape[0]
            centre = frame.truth_mm[1]
            camera = frame.camera
            scale = cube / size * (size - 1) / 2
            u = (frame.truth_px[:, 0] - (camera.cx + camera.fx * centre[0] / centre[2])) * centre[2] / camera.fx / scale
            v = (frame.truth_px[:, 1] - (camera.cy + camera.fy * centre[1] / centre[2])) * centre[2] / camera.fy / scale
            places.append(np.stack([u, v, (frame.truth_mm[:, 2] - centre[2]) / (cube / 2)], axis=1))
            return places[-1], np.full(22, 0.75)

        pipeline = pipeline_of(truth, cube_mm=cube)
        hand, = self.estimate(pipeline).hands
        self.assertEqual(hand.confidence.tolist(), [0.75] * 22)
        # Segmentation moves the centre, and the landmarks with it, all by the same.
        apart = hand.landmarks_mm - frame.truth_mm
        self.assertLess(np.linalg.norm(apart - apart.mean(axis=0), axis=1).max(), 8.0)

        np.testing.assert_allclose(knuckle.Estimator(middle, "knuckle22").crop(frame, self.start).to_patch(frame.truth_mm), places[0],
                                   atol=1e-9)

    def test_crops_are_what_the_function_is_shown(self):
        seen = []
        own = knuckle.Estimator(lambda patch: seen.append(patch) or middle(patch), "knuckle22", size_px=96, cube_mm=220)
        hand, = self.estimate(knuckle.Pipeline.from_toml(NEAREST, estimator=own)).hands
        patch = own.crop(self.frame, hand.landmarks_mm[0])  # the middle of what was shown
        self.assertTrue(np.array_equal(patch.pixels, seen[0]))
        np.testing.assert_allclose(patch.to_patch(hand.landmarks_mm), np.zeros((22, 3)), atol=1e-9)
        np.testing.assert_allclose(patch.to_camera(patch.to_patch(self.frame.truth_mm)), self.frame.truth_mm, atol=1e-9)
        self.assertEqual(patch.to_camera(np.zeros((0, 3))).shape, (0, 3))
        self.assertIsNone(own.crop(self.frame, (0, 0, 5000)))
        self.assertIsNone(own.crop(self.frame, (0, 0, float("nan"))))
        with self.assertRaisesRegex(knuckle.Error, "hand alone"):
            knuckle.Estimator(middle, "knuckle22", patch="hand").crop(self.frame, self.start)
        with self.assertRaisesRegex(knuckle.Error, "landmarks_mm"):
            patch.to_patch([1, 2, 3])

    def test_looks_again_around_what_it_found(self):
        seen = []
        moved = np.tile([0.2, 0.0, 0.0], (22, 1))
        hand, = self.estimate(pipeline_of(lambda patch: seen.append(patch) or moved, passes=3)).hands
        self.assertEqual(len(seen), 3)
        self.assertFalse(np.array_equal(seen[0], seen[1]))
        once, = self.estimate(pipeline_of(lambda patch: moved)).hands
        self.assertGreater(hand.landmarks_px[0, 0], once.landmarks_px[0, 0] + 5)

    def test_patch_of_the_hand_alone(self):
        seen = []
        self.estimate(pipeline_of(lambda patch: seen.append(patch) or middle(patch), patch="hand", size_px=48))
        hand = seen[0][seen[0] < 3]
        self.assertAlmostEqual(hand.mean(), 0.0, delta=0.05)
        self.assertAlmostEqual(hand.std(), 1.0, delta=0.1)

    def test_takes_the_place_of_the_files_own(self):
        own = knuckle.Estimator(middle, "knuckle22")
        for pipeline in (knuckle.Pipeline.default(estimator=own),
                         knuckle.Pipeline.load(knuckle.data_file("pipelines/free_hand.toml"), estimator=own)):
            self.assertNotIn("[estimator]", pipeline.toml)
            self.assertIn("[segmentation]", pipeline.toml)

    def test_has_the_landmarks_that_it_names(self):
        tips = knuckle.Estimator(lambda patch: middle(patch)[FIVE_TIPS], "mediapipe21")
        self.assertEqual(tips.convention, "mediapipe21")
        with self.assertRaisesRegex(knuckle.Error, r"landmarks: has the shape \(5, 3\), expected \(21, 3\)"):
            self.estimate(knuckle.Pipeline.from_toml(NEAREST, estimator=tips))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "tips.toml"
            file.write_text('convention = "tips_of_python"\nlandmarks = ["index_tip", "palm"]\n')
            hand, = self.estimate(pipeline_of(lambda patch: [[0, 0, 0], [0.5, 0, 0]], convention=str(file))).hands
            self.assertEqual(hand.landmark_names, ["index_tip", "palm"])

    def test_faults_of_the_function_are_raised(self):
        def broken(patch):
            raise ZeroDivisionError("mine")

        pipeline = pipeline_of(broken)
        for _ in range(3):
            with self.assertRaisesRegex(ZeroDivisionError, "mine"):
                self.estimate(pipeline)
        with self.assertRaises(ZeroDivisionError):
            knuckle.Tracker(pipeline_of(broken)).update(knuckle.Frame(self.frame.depth_mm, self.frame.camera, time_s=0.0))

    def test_all_kinds_of_exceptions_are_raised(self):
        """Also what `except Exception` does not catch; the pipeline works on."""
        frame = knuckle.Frame(self.frame.depth_mm, self.frame.camera, time_s=0.0)
        for fault in (KeyboardInterrupt("stop"), SystemExit(3), GeneratorExit(), StopIteration("x"), MemoryError(), RecursionError("deep"),
                      BaseException("base"), UnicodeDecodeError("utf8", b"\xff", 0, 1, "bad"), knuckle.Error("mine")):
            faults = [fault]

            def look(patch, faults=faults):
                if faults:
                    raise faults.pop()
                return middle(patch)

            pipeline = pipeline_of(look)
            for ask in (lambda: self.estimate(pipeline), lambda: knuckle.Tracker(pipeline).update(frame)):
                faults[:] = [fault]
                with self.assertRaises(type(fault)) as caught:
                    ask()
                self.assertIs(caught.exception, fault)
                self.assertEqual(len(self.estimate(pipeline).hands), 1)

    def test_exceptions_of_four_threads_at_once(self):
        """Each thread gets its own."""
        at_once, seen = threading.Barrier(4), []

        def broken(patch):
            del patch
            at_once.wait(30)
            raise KeyError(threading.get_ident())

        pipeline = pipeline_of(broken)

        def ask():
            for _ in range(25):
                try:
                    self.estimate(pipeline)
                except KeyError as error:
                    seen.append(error.args == (threading.get_ident(),))

        threads = [threading.Thread(target=ask) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(seen, [True] * 100)

    def test_answers_that_are_none(self):
        nan = middle(None)
        nan[3, 1] = np.nan
        good = np.ones(22)
        for answer, kind, words in (
                (None, knuckle.Error, r"landmarks: has the shape \(\)"), ("text", TypeError, "landmarks"), (np.zeros((22, 2)), knuckle.Error, r"\(22, 2\)"),
                (np.zeros((21, 3)), knuckle.Error, r"expected \(22, 3\)"), (nan, knuckle.Error, "is not finite"),
                ((middle(None),), knuckle.Error, "tuple of 1"), ((middle(None), good[:5]), knuckle.Error, r"\(5\), expected \(22\)"),
                ((middle(None), 2 * good), knuckle.Error, "is 2, expected 0 to 1"),
                ((middle(None), np.nan * good), knuckle.Error, "expected 0 to 1")):
            with self.assertRaisesRegex(kind, words):
                self.estimate(pipeline_of(lambda patch, answer=answer: answer))

    def test_landmarks_that_lie_nowhere(self):
        z = middle(None)
        behind = z.copy()
        behind[5, 2] = -10.0  # 1250 mm towards the camera, which is nearer
        for answer, words in ((z + 1e300, "wrist has the value 1e.300"), (z - 1e19, "wrist has the value 1e.19"), (z + 1001.0, "at most 1000"),
                              (z + np.array([0, -2000.0, 0]), "the value 2000"), (behind, "lies behind the camera"), (z + np.inf, "not finite")):
            for passes in (1, 3):
                with self.assertRaisesRegex(knuckle.Error, words):
                    self.estimate(pipeline_of(lambda patch, answer=answer: answer, passes=passes))
        beside = z.copy()
        beside[5, 0] = 30.0  # a hand that is not what it seems, or a network that has learned nothing
        self.assertEqual(len(self.estimate(pipeline_of(lambda patch: beside)).hands), 1)

    def test_exceptions_of_arrays_are_the_cause(self):
        class Tensor:
            def __init__(self, error):
                self.error = error

            def __array__(self, *_):
                raise self.error

        for error in (RuntimeError("use tensor.detach()"), ValueError("mine")):
            for answer in (Tensor(error), (Tensor(error), np.ones(22)), (middle(None), Tensor(error))):
                with self.assertRaisesRegex(TypeError, "the estimator's .*: expected numbers") as caught:
                    self.estimate(pipeline_of(lambda patch, answer=answer: answer))
                self.assertIs(caught.exception.__cause__, error)
        with self.assertRaises(KeyboardInterrupt):
            self.estimate(pipeline_of(lambda patch: Tensor(KeyboardInterrupt())))

    def test_complex_numbers_are_refused(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for answer in (middle(None) + 0j, (middle(None), np.ones(22) + 1j)):
                with self.assertRaisesRegex(TypeError, "found complex ones"):
                    self.estimate(pipeline_of(lambda patch, answer=answer: answer))
            with self.assertRaisesRegex(TypeError, "start: .*found complex ones"):
                pipeline_of(middle).estimate(self.frame.depth_mm, self.frame.camera, np.array([0, 0, 500j]))
            with self.assertRaisesRegex(TypeError, "predictions 'mine': .*found complex ones"):
                knuckle.evaluate(f"synthetic:{DEMO}", {"mine": np.ones((40, 22, 3), complex)})

    def test_options_out_of_range(self):
        for options, words in (({"size_px": 1}, "size_px"), ({"cube_mm": float("nan")}, "cube_mm"), ({"passes": 0}, "passes"),
                               ({"patch": "ball"}, "ball"), ({"sure_confidence": 1.5}, "sure_confidence"),
                               ({"patch": "hand", "passes": 2}, "once"), ({"convention": "nobodys"}, "nobodys")):
            with self.assertRaisesRegex(knuckle.Error, words):
                pipeline_of(middle, **options)
        with self.assertRaises(TypeError):
            knuckle.Estimator(5, "knuckle22")

    def test_may_be_called_from_many_threads(self):
        pipeline = pipeline_of(lambda patch: np.full((22, 3), float(patch.min()) * 0.1))
        expected = self.estimate(pipeline).hands[0].landmarks_mm.tobytes()
        answers = []
        threads = [threading.Thread(target=lambda: answers.extend(
            self.estimate(pipeline).hands[0].landmarks_mm.tobytes() for _ in range(20))) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(answers, [expected] * 80)

    def test_lets_the_function_go(self):
        class Function:
            def __call__(self, patch):
                return middle(patch)

        function = Function()
        gone = weakref.ref(function)
        pipeline = pipeline_of(function)
        del function
        gc.collect()
        self.estimate(pipeline)
        del pipeline
        gc.collect()
        self.assertIsNone(gone())
        with self.assertRaises(knuckle.Error):  # one that no pipeline takes over
            pipeline_of(Function(), "[nothing]\n")


if __name__ == "__main__":
    unittest.main()
