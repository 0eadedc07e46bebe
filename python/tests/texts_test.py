# SPDX-License-Identifier: Apache-2.0
"""Texts with a zero byte: each is refused, in a message that does not end there."""

import unittest

import numpy as np

import knuckle
from testing import DEMO

BAD = "kn\0uckle"
POSES = np.ones((40, 22, 3))


def evaluate(truth=f"synthetic:{DEMO}", name="mine", **options):
    return knuckle.evaluate(truth, {name: POSES}, **options)


class Texts(unittest.TestCase):
    def test_zero_bytes_are_shown(self):
        for use, what in ((lambda: knuckle.Estimator(len, BAD), "convention"), (lambda: knuckle.Estimator(len, "knuckle22", patch=BAD), "patch"),
                          (lambda: knuckle.Camera(1, 1, 1, 1, 5, 5, model=BAD), "model"), (lambda: knuckle.open_source(BAD), "source"),
                          (lambda: knuckle.open_stream(BAD), "stream"), (lambda: knuckle.data_file(BAD), "name"),
                          (lambda: knuckle.HandSkeleton.adult().landmarks({BAD: 1.0}), "angles_rad"), (lambda: evaluate(BAD), "truth"),
                          (lambda: evaluate(name=BAD), "predictions"), (lambda: evaluate(convention=BAD), "convention"),
                          (lambda: evaluate(format=BAD), "format"), (lambda: evaluate(axes=BAD), "axes"), (lambda: evaluate(unit=BAD), "unit")):
            with self.assertRaises(knuckle.Error) as caught:
                use()
            self.assertEqual(str(caught.exception), rf"{what}: 'kn\x00uckle' has a zero byte")


if __name__ == "__main__":
    unittest.main()
