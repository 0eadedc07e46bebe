# SPDX-License-Identifier: Apache-2.0
"""What was labelled, exported in every format and read again is the same: every convention, left hands, both hands of a frame.

    label_round_trip_test.py KNUCKLE LIVE_CLIENT
"""
import json
import pathlib
import subprocess
import tempfile
import unittest

from live_program import PROJECT, program

FRAMES = 3
OF_THE_22 = ["knuckle22", "icg20", "mediapipe21", "msra21", "hands21"]
WITH_JOINTS_OF_THEIR_OWN = {"icvl16": 16, "nyu14": 14}
LARGEST_PX = 0.01
LARGEST_MM = 0.01


def run(*arguments):
    return subprocess.run([program(), *arguments], cwd=PROJECT, capture_output=True, text=True, check=False)


def rendered(manifest, out):
    """As a set: what is rendered anew each time takes long."""
    done = run("render", "--manifest", f"manifests/{manifest}.toml", "--count", str(FRAMES), "--out", str(out))
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return f"h5:{out}"


def hands_of(file):
    """The newest landmarks of each hand, by frame and side: name to u, v, depth; None where one is not labelled."""
    hands = {}
    for line in file.read_text().splitlines()[1:]:
        hand = json.loads(line)
        hands[hand["frame"], hand["side"]] = {name: label and label[2:] for name, label in hand["landmarks"].items()}
    return hands


class LabelRoundTripTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.one_hand = rendered("demo", pathlib.Path(folder.name) / "one.h5")
        cls.two_hands = rendered("test_two_hands", pathlib.Path(folder.name) / "two.h5")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def done(self, *arguments):
        done = run("labels", *arguments)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        return done

    def import_(self, name, convention, *arguments):
        """Imports labels into a set of their own, and says what is in its file."""
        self.done("import", "--labels", str(self.folder / name), "--convention", convention, *arguments)
        return hands_of(self.folder / name / "labels.jsonl")

    def export(self, name, source, kind, out, *arguments):
        path = self.folder / f"{out}{ {'h5': '.h5', 'poses': '.txt'}.get(kind, '') }"
        done = self.done("export", "--labels", str(self.folder / name), "--source", source, "--format", kind, "--out", str(path), *arguments)
        return path, done

    def assert_same(self, found, wanted, what):
        self.assertEqual(found.keys(), wanted.keys(), what)
        for hand, landmarks in wanted.items():
            self.assertEqual(found[hand].keys(), landmarks.keys(), what)
            for name, at in landmarks.items():
                self.assertEqual(found[hand][name] is None, at is None, f"{what}, {hand}, {name}")
                for number, again, most in zip(at or [], found[hand][name] or [], [LARGEST_PX, LARGEST_PX, LARGEST_MM]):
                    self.assertLessEqual(abs(number - again), most, f"{what}, {hand}, {name}")

    def labelled_in(self, convention, side):
        """The demo's hands, labelled in a convention: all of its landmarks, also those that data sets define themselves."""
        everything = f"all_{convention}_{side}"
        self.import_(everything, "knuckle22", "--source", self.one_hand, "--side", side)
        poses, _ = self.export(everything, self.one_hand, "poses", f"poses_{convention}_{side}", "--convention", convention)
        return self.import_(f"{convention}_{side}", convention, "--source", self.one_hand, "--poses", str(poses), "--side", side)

    def assert_comes_back(self, convention, side, kind):
        what = f"{convention} {side} {kind}"
        wanted = hands_of(self.folder / f"{convention}_{side}" / "labels.jsonl")
        out, _ = self.export(f"{convention}_{side}", self.one_hand, kind, f"{convention}_{side}_{kind}")
        source = ["--source", self.one_hand, "--poses", str(out)] if kind == "poses" else ["--source", f"{kind}:{out}"]
        says_side = kind in ("folder", "h5")  # in their own files
        read = self.import_(f"{convention}_{side}_{kind}_again", convention, *source, *([] if says_side else ["--side", side]))
        self.assert_same(read, wanted, what)

    def test_every_convention_comes_back_from_every_format_that_holds_it(self):
        for side in ["right", "left"]:
            for convention in [*OF_THE_22, *WITH_JOINTS_OF_THEIR_OWN]:
                labelled = self.labelled_in(convention, side)
                self.assertEqual([hand[1] for hand in labelled], FRAMES * [side])
                known = min(sum(at is not None for at in landmarks.values()) for landmarks in labelled.values())
                self.assertEqual(known, WITH_JOINTS_OF_THEIR_OWN.get(convention, int(convention[-2:])), f"{convention}: all are labelled")
                formats = ["folder", "poses"] + (["h5"] if convention in OF_THE_22 else []) + (["icg"] if convention == "icg20" else [])
                for kind in formats:
                    self.assert_comes_back(convention, side, kind)

    def test_landmarks_that_a_format_cannot_hold_are_refused(self):
        for convention in WITH_JOINTS_OF_THEIR_OWN:
            self.labelled_in(convention, "right")
            out = self.folder / f"{convention}.h5"
            refused = run("labels", "export", "--labels", str(self.folder / f"{convention}_right"), "--source", self.one_hand, "--format", "h5", "--out", str(out))
            self.assertEqual(refused.returncode, 1)
            self.assertEqual(len(refused.stderr.splitlines()), 1, refused.stderr)
            self.assertIn(f"not all of {convention}; choose --format folder or poses", refused.stderr)
            self.assertFalse(out.exists())

    def test_both_hands_of_a_frame_come_back(self):
        for convention in OF_THE_22:
            wanted = self.import_(f"two_{convention}", convention, "--source", self.two_hands)
            self.assertEqual({side for _, side in wanted}, {"right", "left"})
            two_handed = sum((frame, "left") in wanted and side == "right" for frame, side in wanted)
            self.assertGreater(two_handed, 0)
            h5, done = self.export(f"two_{convention}", self.two_hands, "h5", f"two_{convention}")
            self.assertEqual(done.stderr, "")
            read = self.import_(f"two_{convention}_h5", convention, "--source", f"h5:{h5}")
            self.assert_same(read, wanted, f"{convention} h5")
            _, done = self.export(f"two_{convention}", self.two_hands, "folder", f"two_{convention}_folder")
            self.assertIn(f"warning: {two_handed} frames have both hands; the format folder holds one of them, h5 and poses both", done.stderr)

    def test_both_hands_come_back_from_two_poses_files(self):
        wanted = self.import_("two", "knuckle22", "--source", self.two_hands)
        wanted = {hand: at for hand, at in wanted.items() if (hand[0], "right") in wanted}
        first, _ = self.export("two", self.two_hands, "poses", "two")
        self.import_("again", "knuckle22", "--source", self.two_hands, "--poses", str(first), "--side", "right")
        second = first.with_suffix(".hand2.txt")
        read = self.import_("again", "knuckle22", "--source", self.two_hands, "--poses", str(second), "--side", "left")
        self.assert_same({hand: at for hand, at in read.items() if hand in wanted}, wanted, "poses")


if __name__ == "__main__":
    import sys
    unittest.main(argv=sys.argv[:1], verbosity=2)
