# SPDX-License-Identifier: Apache-2.0
"""What may be handed over as a depth image and a camera, what is refused, and in which words."""

import pickle
import unittest

import numpy as np

import knuckle
from testing import SMALL_PIPELINE, demo_frames, poses_of


class Arrays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pipeline = knuckle.Pipeline.from_toml(SMALL_PIPELINE)
        cls.frame = demo_frames()[3]
        cls.depth = cls.frame.depth_mm.copy()
        cls.camera = cls.frame.camera
        cls.expected = poses_of(cls.pipeline.estimate(cls.depth, cls.camera))
        assert len(cls.expected) == 1

    def poses(self, depth, **options):
        return poses_of(self.pipeline.estimate(depth, self.camera, **options))

    def assert_refused(self, kind, words, depth, camera=None, **options):
        with self.assertRaisesRegex(kind, words) as caught:
            self.pipeline.estimate(depth, camera or self.camera, **options)
        self.assertNotIn("\n", str(caught.exception))

    # ---- what is accepted ----

    def test_types_that_hold_the_same_depths_give_the_same_poses(self):
        whole_mm = np.rint(self.depth)
        expected = self.poses(whole_mm.astype(np.float32))
        for depth in (whole_mm.astype(np.float64), whole_mm.astype(np.uint16), whole_mm.astype(">f4"), whole_mm.astype(">f8"),
                      whole_mm.astype(">u2"), whole_mm.astype("<u2")):
            self.assertEqual(self.poses(depth), expected, depth.dtype)

    def test_the_unit_applies_to_any_type(self):
        tenths = np.rint(self.depth * 10).astype(np.uint16)
        expected = self.poses(tenths.astype(np.float64) * 0.1)
        self.assertEqual(self.poses(tenths, depth_unit_mm=0.1), expected)
        self.assertEqual(self.poses(tenths.astype(np.float32), depth_unit_mm=0.1), expected)
        self.assertNotEqual(expected, [])

    def test_strides_do_not_matter(self):
        rows, columns = self.depth.shape
        padded = np.full((rows + 2, 2 * columns + 3), 100.0, np.float32)
        padded[1:-1, 1:-2:2] = self.depth
        self.assertEqual(self.poses(padded[1:-1, 1:-2:2]), self.expected)
        self.assertEqual(self.poses(np.asfortranarray(self.depth)), self.expected)
        self.assertEqual(self.poses(np.ascontiguousarray(self.depth[::-1, ::-1])[::-1, ::-1]), self.expected)

    def test_places_that_are_not_aligned_do_not_matter(self):
        behind_a_byte = np.zeros(self.depth.shape, np.dtype([("flag", "u1"), ("depth", "f4")]))
        behind_a_byte["depth"] = self.depth
        self.assertEqual(self.poses(behind_a_byte["depth"]), self.expected)

    def test_one_value_for_all_pixels_is_an_image_without_a_hand(self):
        self.assertEqual(self.pipeline.estimate(np.broadcast_to(np.float32(0), self.depth.shape), self.camera).hands, [])

    def test_what_is_no_depth_is_not_measured(self):
        for nothing in (np.nan, np.inf, -np.inf, -5.0):
            depth = self.depth.copy()
            depth[depth == 0] = nothing
            self.assertEqual(self.poses(depth), self.expected, nothing)
            np.testing.assert_array_equal(knuckle.Frame(depth, self.camera).depth_mm, self.depth)
        huge = np.where(self.depth > 0, self.depth, np.float64(1e300))  # beyond what float32 holds
        self.assertEqual(self.poses(huge), self.expected)

    def test_what_is_masked_is_not_measured(self):
        for kind in (np.float32, np.uint16, ">f8"):
            whole_mm = np.rint(self.depth).astype(kind)
            nearer = np.where(whole_mm > 0, whole_mm, 200).astype(kind)  # would be the hand, as the nearest
            masked = np.ma.masked_array(nearer, whole_mm == 0)
            self.assertEqual(self.poses(masked), self.poses(whole_mm), kind)
            np.testing.assert_array_equal(knuckle.Frame(masked, self.camera).depth_mm, np.rint(self.depth))
            np.testing.assert_array_equal(masked.data, nearer)  # nothing was written
        self.assertEqual(self.poses(np.ma.masked_array(self.depth)), self.expected)
        start = np.ma.masked_array([0, 0, 500], [False, True, False])
        self.assert_refused(knuckle.Error, "start", self.depth, start=start)

    def test_depths_of_any_size_make_no_pose_that_is_not_finite(self):
        random = np.random.default_rng(5)
        bits = random.integers(0, 2**32, self.depth.shape, dtype=np.uint32).view(np.float32)
        sizes = np.exp(random.uniform(-80, 80, self.depth.shape)).astype(np.float32)
        salted = np.where(random.random(self.depth.shape) < 0.3, np.float32(1e-30), self.depth)
        for depth in (bits, sizes, salted, self.depth * np.float32(1e-3), self.depth * np.float32(1e3)):
            for start in (None, (0.0, 0.0, 1e-30), (1e30, 0.0, 500.0)):
                for hand in self.pipeline.estimate(depth, self.camera, start=start).hands:
                    self.assertTrue(np.isfinite(hand.landmarks_mm).all())

    def test_an_image_of_nan_has_no_hand_and_says_why(self):
        estimate = self.pipeline.estimate(np.full_like(self.depth, np.nan), self.camera)
        self.assertEqual(estimate.hands, [])
        self.assertNotEqual(estimate.status, "")

    def test_a_read_only_array_is_fine_and_none_is_written(self):
        depth = self.depth.copy()
        depth.flags.writeable = False
        self.assertEqual(self.poses(depth), self.expected)
        np.testing.assert_array_equal(depth, self.depth)

    def test_an_array_may_be_freed_after_the_call(self):
        frame = knuckle.Frame(self.depth.copy(), self.camera)
        self.assertEqual(poses_of(self.pipeline.estimate(frame.depth_mm, self.camera)), self.expected)
        pixels = knuckle.Frame(self.depth, self.camera).depth_mm  # keeps its frame
        np.testing.assert_array_equal(pixels, self.depth)

    def test_a_start_is_any_three_numbers(self):
        start = np.nanmean(self.frame.truth_mm, axis=0)
        expected = self.poses(self.depth, start=start)
        self.assertEqual(self.poses(self.depth, start=list(start)), expected)
        self.assertEqual(self.poses(self.depth, start=tuple(start)), expected)
        self.assertEqual(len(expected), 1)

    # ---- what is refused ----

    def test_other_types_are_refused(self):
        for kind in (np.int32, np.int16, np.uint8, np.float16, np.complex64, bool, object, "S4", "U4", "M8[s]"):
            self.assert_refused(TypeError, "depth: expected an array of float32, float64 or uint16, found",
                                np.zeros(self.depth.shape, kind))
        self.assert_refused(TypeError, "found", np.zeros(self.depth.shape, [("a", "f4"), ("b", "f4")]))

    def test_what_is_no_array_is_refused(self):
        for depth in (None, 5, "depth", [[1.0, 2.0]], memoryview(b"1234"), self.frame):
            self.assert_refused(TypeError, "depth: expected a numpy array", depth)

    def test_other_shapes_are_refused(self):
        for depth in (self.depth[1:], self.depth[:, 1:], self.depth.T, self.depth[:0]):
            self.assert_refused(knuckle.Error, r"depth: has \d+ rows and \d+ columns, the camera 240 and 320", depth)
        for depth in (self.depth.ravel(), self.depth[..., None], np.array(3, np.float32)):
            self.assert_refused(knuckle.Error, r"depth: has \d dimensions", depth)

    def test_impossible_units_are_refused(self):
        for unit in (0.0, -1.0, np.nan, np.inf):
            self.assert_refused(knuckle.Error, "depth_unit_mm", self.depth, depth_unit_mm=unit)

    def test_impossible_starts_are_refused(self):
        self.assert_refused(knuckle.Error, "start", self.depth, start=(0.0, np.nan, 400.0))
        self.assert_refused(knuckle.Error, r"start: has the shape \(2\), expected \(3\)", self.depth, start=(0.0, 400.0))
        self.assert_refused(TypeError, "start: expected numbers", self.depth, start="here")
        self.assert_refused(TypeError, "start: expected numbers", self.depth, start=object())

    def test_what_is_no_camera_is_refused(self):
        with self.assertRaises(TypeError):
            self.pipeline.estimate(self.depth, None)
        with self.assertRaises(TypeError):
            self.pipeline.estimate(self.depth, (224.0, 224.0, 159.5, 119.5))

    def test_impossible_cameras_are_refused(self):
        good = dict(fx=224.0, fy=224.0, cx=159.5, cy=119.5, width=320, height=240)
        for name, value in (("fx", 0.0), ("fx", 1e-320), ("fy", np.nan), ("cx", np.inf), ("width", 0), ("height", -1),
                            ("width", 20000), ("model", "fisheye"), ("distortion", [0.0] * 9), ("distortion", [np.nan])):
            with self.assertRaisesRegex(knuckle.Error, f"camera: .*({name}|pixels)"):
                knuckle.Camera(**{**good, name: value})
        for name, value in (("width", 320.5), ("width", 10**30), ("fx", "224"), ("distortion", "none")):
            with self.assertRaises(TypeError):
                knuckle.Camera(**{**good, name: value})

    # ---- cameras and frames as values ----

    def test_cameras_are_values(self):
        camera = knuckle.Camera(1.0, 2.0, 3.0, 4.0, 5, 6, [0.1, 0.2], "projective")
        self.assertEqual(camera.distortion, (0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            self.assertEqual(pickle.loads(pickle.dumps(camera, protocol)), camera)
        self.assertEqual(len({camera, pickle.loads(pickle.dumps(camera)), self.camera}), 2)
        self.assertNotEqual(camera, self.camera)
        self.assertNotEqual(camera, "camera")
        with self.assertRaises(AttributeError):
            camera.fx = 0.0

    def test_a_frame_shows_its_own_memory(self):
        frame = knuckle.Frame(np.rint(self.depth).astype(np.uint16), self.camera, depth_unit_mm=2.0, time_s=0.5, name="a")
        np.testing.assert_array_equal(frame.depth_mm, 2 * np.rint(self.depth))
        frame.depth_mm[0, 0] = 7.0
        self.assertEqual(frame.depth_mm[0, 0], 7.0)
        self.assertEqual((frame.time_s, frame.name, frame.camera), (0.5, "a", self.camera))
        self.assertEqual((frame.mask, frame.infrared, frame.truth_mm, frame.side), (None, None, None, None))

    def test_frames_are_no_pickles(self):
        for thing in (self.frame, self.pipeline, knuckle.Tracker(self.pipeline)):
            for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
                with self.assertRaisesRegex(TypeError, "cannot pickle"):
                    pickle.dumps(thing, protocol)


if __name__ == "__main__":
    unittest.main()
