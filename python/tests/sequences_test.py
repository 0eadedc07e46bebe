# SPDX-License-Identifier: Apache-2.0
"""Sources behave as Python's sequences do; rendering gives their frames."""

import collections.abc
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import knuckle
from testing import DEMO, demo_frames, program


def same(first, second):
    return first.name == second.name and np.array_equal(first.depth_mm, second.depth_mm)


class Sequences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = demo_frames()

    def test_is_a_sequence(self):
        self.assertIsInstance(self.frames, collections.abc.Sequence)
        self.assertEqual(len(self.frames), 40)
        self.assertEqual(self.frames[np.int64(2)].name, "000002")
        self.assertEqual(self.frames[-1].name, "000039")
        self.assertEqual(self.frames[-40].name, "000000")
        self.assertEqual(self.frames.convention, "knuckle22")

    def test_beyond_its_end(self):
        for index in (40, -41, 10**30):
            with self.assertRaises(IndexError):
                self.frames[index]
        for key in ("1", 1.0, None):
            with self.assertRaises(TypeError):
                self.frames[key]

    def test_slices_are_sources(self):
        self.assertEqual([frame.name for frame in self.frames[2:8:3]], ["000002", "000005"])
        self.assertEqual([frame.name for frame in self.frames[:-39]], ["000000"])
        self.assertEqual([frame.name for frame in self.frames[38:100][::-1]], ["000039", "000038"])
        self.assertEqual(len(self.frames[40:]), 0)
        self.assertEqual(self.frames[10:20][-1].name, "000019")
        with self.assertRaisesRegex(IndexError, "frame 3 of 3: synthetic:"):
            self.frames[:3][3]

    def test_frames_hold_what_is_known(self):
        frame = self.frames[4]
        self.assertEqual((frame.depth_mm.shape, frame.depth_mm.dtype), ((240, 320), np.float32))
        self.assertEqual((frame.mask.shape, frame.mask.dtype), ((240, 320), np.uint8))
        self.assertIsNone(frame.infrared)
        self.assertEqual((frame.truth_mm.shape, frame.truth_px.shape, frame.convention), ((22, 3), (22, 2), "knuckle22"))
        self.assertEqual((frame.side, frame.sequence), ("right", 0))
        self.assertAlmostEqual(frame.time_s, 4 / 30)
        camera = frame.camera
        projected = np.array([camera.cx, camera.cy]) + frame.truth_mm[:, :2] * [camera.fx, camera.fy] / frame.truth_mm[:, 2:]
        np.testing.assert_allclose(frame.truth_px, projected, atol=1e-9)
        palm = frame.depth_mm[tuple(np.rint(frame.truth_px[1, ::-1]).astype(int))]
        self.assertLess(abs(palm - frame.truth_mm[1, 2]), 40)

    def test_all_hands_of_a_frame_are_told_of(self):
        frame = knuckle.render(DEMO.with_name("test_two_hands.toml"), 0)
        first, second = frame.hands
        self.assertEqual((first.side, second.side), ("right", "left"))
        np.testing.assert_array_equal(first.truth_mm, frame.truth_mm)
        np.testing.assert_array_equal(first.truth_px, frame.truth_px)
        self.assertEqual((second.truth_mm.shape, second.truth_px.shape, second.convention), ((22, 3), (22, 2), "knuckle22"))
        self.assertEqual((frame.labels.shape, frame.labels.dtype), (frame.depth_mm.shape, np.uint8))
        np.testing.assert_array_equal(frame.labels == 1, frame.mask == 1)
        for hand, label in ((first, 1), (second, 2)):
            self.assertTrue(0 < hand.visible_share <= 1)
            seen = [tuple(np.rint(at[::-1]).astype(int)) for at, over in zip(hand.truth_px, hand.occluders) if over == "none"]
            self.assertGreater(len(seen), 5)
            self.assertGreater(sum(frame.labels[at] == label for at in seen), 0.8 * len(seen))
        self.assertLessEqual(set(first.occluders), {"none", "own_hand", "other_hand", "person", "object", "border"})
        self.assertEqual(repr(second), f"<knuckle.TrueHand left, {100 * second.visible_share:.0f} % of it visible>")

    def test_names_of_files_need_not_be_utf_8(self):
        with tempfile.TemporaryDirectory() as folder:
            made = pathlib.Path(folder) / "set"
            subprocess.run([program(), "render", "--manifest", DEMO, "--count", "1", "--format", "folder", "--out", made], check=True,
                           capture_output=True)
            for image in made.glob("*/*.png"):
                image.rename(image.with_name(os.fsdecode(b"\xff.png")))
            frame, = knuckle.open_source(f"folder:{made}")
            self.assertEqual(os.fsencode(frame.name), b"\xff")
            self.assertIn("xff", repr(frame))

    def test_no_such_source(self):
        for text, words in (("nothing:x", "nothing"), ("folder:nowhere", "nowhere"), ("", ""), ("\0:\n", "")):
            with self.assertRaisesRegex(knuckle.Error, words) as caught:
                knuckle.open_source(text)
            self.assertNotIn("\n", str(caught.exception))
        with self.assertRaises(TypeError):
            knuckle.open_source(5)

    def test_render_gives_the_frames_of_the_source(self):
        for index in (0, 7, -1):
            self.assertTrue(same(knuckle.render(DEMO, index), self.frames[index]))
        self.assertTrue(same(knuckle.render(str(DEMO), 3), self.frames[3]))
        with self.assertRaises(IndexError):
            knuckle.render(DEMO, 40)
        with self.assertRaisesRegex(knuckle.Error, "none.toml"):
            knuckle.render("none.toml", 0)

    def test_render_sees_that_a_manifest_has_changed(self):
        with tempfile.TemporaryDirectory() as folder:
            manifest = pathlib.Path(shutil.copy(DEMO, folder))
            before = knuckle.render(manifest, 0)
            manifest.write_text(manifest.read_text().replace("seed = 1 ", "seed = 2 "))
            os.utime(manifest, ns=(1, 1))
            self.assertFalse(same(knuckle.render(manifest, 0), before))


if __name__ == "__main__":
    unittest.main()
