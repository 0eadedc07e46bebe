# SPDX-License-Identifier: Apache-2.0
"""The package finds what the program finds, to the last bit that the program writes."""

import json
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import knuckle
from testing import demo_frames, program

COUNT = 6


def run(*command):
    subprocess.run([program(), *map(str, command)], check=True, capture_output=True)


class SameAsProgram(unittest.TestCase):
    def setUp(self):
        self.frames = demo_frames()[:COUNT]
        self.source = f"{self.frames.name}?count={COUNT}"
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def estimate(self, pipeline_file):
        """What the program writes: lines of records, and of poses."""
        records, poses = self.folder / "records.jsonl", self.folder / "poses.txt"
        run("estimate", "--source", self.source, "--pipeline", pipeline_file, "--out", poses, "--records", records)
        return records.read_text().splitlines(), [line for line in poses.read_text().splitlines() if line[0] != "#"]

    def compare(self, name):
        path = knuckle.data_file(f"pipelines/{name}.toml")
        pipeline = knuckle.Pipeline.load(path)
        records, poses = self.estimate(path)
        self.assertEqual(len(records), COUNT)
        self.assertEqual(len(poses), COUNT)
        for number, frame in enumerate(self.frames):
            estimate = pipeline.estimate(frame.depth_mm, frame.camera)
            self.assertEqual(estimate.to_json(number, frame.name, frame.time_s), records[number])
            self.assertEqual(" ".join(self.pose_words(estimate)), poses[number])

    @staticmethod
    def pose_words(estimate):
        hand = estimate.hands[0]
        uvd = np.column_stack([hand.landmarks_px, hand.landmarks_mm[:, 2]])
        return [f"{number:.4f}" for number in uvd.ravel()]

    def test_default(self):
        self.compare("default")

    def test_pose_forest(self):
        self.compare("pose_forest")

    def test_attributes_are_those_of_the_record(self):
        frame = self.frames[0]
        estimate = knuckle.Pipeline.default().estimate(frame.depth_mm, frame.camera)
        hand, record = estimate.hands[0], json.loads(estimate.to_json())["hands"][0]
        self.assertEqual(list(record["landmarks_mm"]), hand.landmark_names)
        self.assertEqual(hand.landmark_names, list(knuckle.conventions[hand.convention]))
        np.testing.assert_allclose(hand.landmarks_mm, list(record["landmarks_mm"].values()), atol=0.0005)
        np.testing.assert_allclose(hand.landmarks_px, list(record["landmarks_px"].values()), atol=0.0005)
        np.testing.assert_allclose(hand.confidence, list(record["confidence"].values()), atol=0.00005)
        self.assertEqual(list(hand.angles_rad), list(record["angles_rad"]))
        np.testing.assert_allclose(list(hand.angles_rad.values()), list(record["angles_rad"].values()), atol=0.000005)
        self.assertEqual((hand.id, hand.side, hand.skeleton), (1, "right", "adult"))
        self.assertAlmostEqual(hand.score, record["score"], places=4)

    def test_tracker(self):
        path = knuckle.data_file("pipelines/track.toml")
        tracker = knuckle.Tracker(knuckle.Pipeline.load(path))
        records, poses = self.estimate(path)
        for number, frame in enumerate(self.frames):
            hands = tracker.update(frame)
            record = json.loads(records[number])
            self.assertEqual([hand.id for hand in hands], [hand["id"] for hand in record["hands"]])
            for hand, written in zip(hands, record["hands"]):
                self.assertEqual([[f"{x:.3f}" for x in point] for point in hand.landmarks_mm],
                                 [[f"{x:.3f}" for x in point] for point in written["landmarks_mm"].values()])
                self.assertEqual({name: f"{angle:.5f}" for name, angle in hand.angles_rad.items()},
                                 {name: f"{angle:.5f}" for name, angle in written["angles_rad"].items()})
        tracker.reset()
        self.assertEqual([hand.id for hand in tracker.update(self.frames[0])], [1])

    def test_a_pipeline_from_text_is_that_of_the_file(self):
        text = knuckle.data_file("pipelines/default.toml").read_text()
        frame = self.frames[1]
        from_text = knuckle.Pipeline.from_toml(text).estimate(frame.depth_mm, frame.camera)
        from_file = knuckle.Pipeline.default().estimate(frame.depth_mm, frame.camera)
        self.assertEqual(from_text.to_json(), from_file.to_json())
        with self.assertRaisesRegex(knuckle.Error, "pipeline:1: hands: unknown key"):
            knuckle.Pipeline.from_toml("hands = 5\n" + text)
        with self.assertRaisesRegex(knuckle.Error, "nowhere"):
            knuckle.Pipeline.from_toml(text, folder="nowhere")
        with self.assertRaisesRegex(knuckle.Error, "none.toml"):
            knuckle.Pipeline.load(pathlib.Path("none.toml"))

    def test_evaluate(self):
        poses, scores = self.folder / "poses.txt", self.folder / "scores.json"
        run("estimate", "--source", self.source, "--out", poses)
        run("evaluate", "--truth", self.source, "--predictions", f"mine={poses}", "--json", scores)
        expected = json.loads(scores.read_text())
        self.assertEqual(knuckle.evaluate(self.source, {"mine": poses}), expected)

        array = np.loadtxt(poses, comments="#").reshape(COUNT, -1, 3)
        self.assertEqual(knuckle.evaluate(self.source, {"mine": array}), expected)
        for axes, unit, mm in (("x,y,z", "mm", 1.0), ("x,-y,-z", "m", 1000.0)):
            in_space = self.in_camera(array) * ([1, -1, -1] if "-" in axes else [1, 1, 1]) / mm
            method = knuckle.evaluate(self.source, {"mine": in_space}, format="xyz", axes=axes, unit=unit)["methods"][0]
            self.assertAlmostEqual(method["mean_3d_mm"], expected["methods"][0]["mean_3d_mm"], places=4)
        array[2] = np.nan
        self.assertEqual(knuckle.evaluate(self.source, {"mine": array, "file": str(poses)})["methods"][0]["missing"], 1)

    def in_camera(self, uvd):
        """Points [mm] of u, v, depth, each seen by its frame's camera."""
        points = np.empty_like(uvd)
        for i, frame in enumerate(self.frames):
            camera, (u, v, d) = frame.camera, uvd[i].T
            points[i] = np.stack([(u - camera.cx) * d / camera.fx, (v - camera.cy) * d / camera.fy, d], 1)
        return points

    def test_landmark_definitions(self):
        definition, poses, moved = (self.folder / name for name in ("landmarks.toml", "poses.txt", "moved.txt"))
        run("landmarks", "--source", f"{self.frames.name}?count=12", "--out", definition)
        run("estimate", "--source", self.source, "--landmarks", definition, "--out", moved)
        pipeline = knuckle.Pipeline.default(landmarks=definition)
        lines = moved.read_text().splitlines()[1:]
        found = [self.pose_words(pipeline.estimate(frame.depth_mm, frame.camera)) for frame in self.frames]
        self.assertEqual([" ".join(words) for words in found], lines)

        scores = self.folder / "scores.json"
        run("estimate", "--source", self.source, "--out", poses)
        run("evaluate", "--truth", self.source, "--predictions", f"mine={poses}", "--landmarks", definition, "--json", scores)
        self.assertNotEqual(poses.read_text(), moved.read_text())
        self.assertEqual(knuckle.evaluate(self.source, {"mine": poses}, landmarks=definition), json.loads(scores.read_text()))
        with self.assertRaisesRegex(knuckle.Error, "tracker"):
            knuckle.Pipeline.load(knuckle.data_file("pipelines/track.toml"), landmarks=definition)

    def test_evaluate_refuses(self):
        good = np.zeros((COUNT, 22, 3))
        for predictions, words in (({}, "nothing to score"), ({"a": good[1:]}, "frames|poses"), ({"a": good[:, 1:]}, "22"),
                                   ({"a": good[0]}, "22"), ({"a": self.folder / "none.txt"}, "none.txt")):
            with self.assertRaisesRegex(knuckle.Error, words):
                knuckle.evaluate(self.source, predictions)
        with self.assertRaisesRegex(knuckle.Error, "unknown|convention"):
            knuckle.evaluate(self.source, {"a": good}, convention="klingon")
        for options, words in (({"format": "zyx"}, "zyx"), ({"axes": "x,-y,-z"}, "xyz"), ({"unit": "inch"}, "inch"),
                               ({"format": "xyz", "axes": "x,y,y"}, "x,y,y")):
            with self.assertRaisesRegex(knuckle.Error, words):
                knuckle.evaluate(self.source, {"a": good}, **options)
        with self.assertRaises(TypeError):
            knuckle.evaluate(self.source, {"a": np.array(["x"], object)})
        with self.assertRaises(TypeError):
            knuckle.evaluate(self.source, {"a": 5})
        with self.assertRaisesRegex(knuckle.Error, "camera"):
            knuckle.evaluate("poses.txt", {"a": good})


if __name__ == "__main__":
    unittest.main()
