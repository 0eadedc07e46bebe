# SPDX-License-Identifier: Apache-2.0
"""The hand as a mechanism: posed, and found again from its landmarks."""

import unittest

import numpy as np

import knuckle
from testing import PROJECT  # noqa: F401 - skips where numpy is missing

NAMES = knuckle.conventions["knuckle22"]
# Turned by a right angle about z, and before the camera.
CAMERA_FROM_HAND = np.array([[0.0, -1, 0, 30], [1, 0, 0, -20], [0, 0, 1, 500], [0, 0, 0, 1]])


class HandSkeleton(unittest.TestCase):
    def setUp(self):
        self.hand = knuckle.HandSkeleton.adult()

    def test_the_straight_hand(self):
        straight = self.hand.landmarks()
        self.assertEqual(straight.shape, (22, 3))
        np.testing.assert_array_equal(straight[NAMES.index("wrist")], 0)
        self.assertAlmostEqual(np.linalg.norm(straight[NAMES.index("middle_tip")]), 186, delta=1)

    def test_a_transform_moves_and_a_size_scales(self):
        angles = {"index_pip": 0.8, "thumb_palmar": 0.3}
        own = self.hand.landmarks(angles)
        moved = self.hand.landmarks(angles, CAMERA_FROM_HAND)
        np.testing.assert_allclose(moved, own @ CAMERA_FROM_HAND[:3, :3].T + CAMERA_FROM_HAND[:3, 3], atol=1e-9)
        np.testing.assert_allclose(self.hand.landmarks(angles, size=1.1), 1.1 * own, atol=1e-9)
        np.testing.assert_allclose(self.hand.scaled(1.1).landmarks(angles), 1.1 * own, atol=1e-9)
        np.testing.assert_allclose(self.hand.mirrored().landmarks(angles), own * [-1, 1, 1], atol=1e-9)

    def test_a_fit_finds_the_landmarks_again(self):
        landmarks = self.hand.landmarks({"index_pip": 0.9, "index_dip": 0.6, "ring_mcp": 0.5}, CAMERA_FROM_HAND, size=1.05)
        fit = self.hand.fit(landmarks)
        self.assertLess(fit.rms_mm, 2)
        np.testing.assert_allclose(fit.landmarks_mm, landmarks, atol=6)
        np.testing.assert_allclose(fit.camera_from_hand[:3, :3], CAMERA_FROM_HAND[:3, :3], atol=0.05)
        for name, angle in fit.angles_rad.items():
            low, high = self.hand.limits_rad[name]
            self.assertTrue(low - 1e-9 <= angle <= high + 1e-9, name)

    def test_a_weight_of_nothing_leaves_a_landmark_out(self):
        landmarks = self.hand.landmarks({"index_pip": 0.9}, CAMERA_FROM_HAND)
        wrong = landmarks.copy()
        wrong[5] += 100.0
        weights = np.ones(22)
        weights[5] = 0.0
        np.testing.assert_allclose(self.hand.fit(wrong, weights).landmarks_mm[6:], self.hand.fit(landmarks).landmarks_mm[6:], atol=3)

    def test_too_little_is_known(self):
        self.assertIsNone(self.hand.fit(np.full((22, 3), np.nan)))

    def test_refuses(self):
        for words, call in (("little_toe", lambda: self.hand.landmarks({"little_toe": 1.0})),
                            ("index_pip", lambda: self.hand.landmarks({"index_pip": np.nan})),
                            ("camera_from_hand", lambda: self.hand.landmarks({}, np.ones((4, 4)))),
                            (r"\(3, 3\), expected \(4, 4\)", lambda: self.hand.landmarks({}, np.eye(3))),
                            ("size", lambda: self.hand.landmarks(size=0.0)), ("factor", lambda: self.hand.scaled(np.nan)),
                            ("landmarks_mm", lambda: self.hand.fit(np.zeros((21, 3)))),
                            ("weight", lambda: self.hand.fit(self.hand.landmarks(), np.full(22, -1.0)))):
            with self.assertRaisesRegex(knuckle.Error, words):
                call()
        for call in (lambda: self.hand.landmarks(5), lambda: self.hand.landmarks({"index_pip": "bent"}),
                     lambda: self.hand.fit("hand")):
            with self.assertRaises(TypeError):
                call()


if __name__ == "__main__":
    unittest.main()
