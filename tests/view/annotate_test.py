# SPDX-License-Identifier: Apache-2.0
"""`knuckle annotate` and `knuckle labels` as programs see them: kills, a full disk, labels that are wrong, two authors.

    annotate_test.py KNUCKLE LIVE_CLIENT [KILLS]
"""
import json
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request

from live_program import PROJECT, program, skip_without_server

SOURCE = "synthetic:manifests/demo.toml?count=3"
KILLS = int(sys.argv.pop()) if len(sys.argv) > 3 else 8
LONGEST_S = 60


def run(*arguments):
    return subprocess.run([program(), *arguments], cwd=PROJECT, capture_output=True, text=True, check=False)


class Annotate:
    """A running program; `with` ends it."""

    def __init__(self, labels, *arguments, source=SOURCE, most_bytes=None):
        def prepare():
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if most_bytes:  # files may grow no longer, as on a full disk
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, resource.RLIM_INFINITY))

        self.errors = tempfile.NamedTemporaryFile("w")
        self.process = subprocess.Popen([program(), "annotate", "--source", source, "--labels", str(labels), "--port", "0", *arguments],
                                        cwd=PROJECT, stdout=subprocess.PIPE, stderr=self.errors, text=True, preexec_fn=prepare)
        end = time.monotonic() + LONGEST_S
        while not (found := re.search(r"annotate: (http://\S+/)\n", self.said())):
            if self.process.poll() is not None or time.monotonic() > end:
                raise AssertionError(f"no address: {self.said()}")
            time.sleep(0.02)
        self.address = found[1]

    def said(self):
        return pathlib.Path(self.errors.name).read_text()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(LONGEST_S)
        self.process.stdout.close()

    def post(self, change, **fields):
        """Status and answer, parsed where it is JSON."""
        body = change if isinstance(change, bytes) else json.dumps(change).encode()
        request = urllib.request.Request(self.address + "api/labels", data=body, headers=fields, method="POST")
        try:
            with urllib.request.urlopen(request, timeout=LONGEST_S) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as refusal:
            text = refusal.read().decode()
            return refusal.code, json.loads(text) if text.startswith("{") else text

    def place(self, revision, **more):
        return self.post({"act": "move", "frame": 0, "side": "right", "revision": revision, "landmark": "wrist",
                          "point_mm": [revision % 50, 10, 500], "model": False, **more})


def lines_of(file):
    return file.read_text().splitlines() if file.exists() else []


class AnnotateTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.labels = self.folder / "labels"
        self.file = self.labels / "labels.jsonl"

    def assert_refused(self, run_, *parts):
        self.assertEqual(run_.returncode, 1, run_.stderr)
        self.assertEqual(len(run_.stderr.splitlines()), 1, run_.stderr)
        for part in parts:
            self.assertIn(part, run_.stderr)

    def annotate_refused(self, *parts, source=SOURCE, arguments=()):
        refused = subprocess.run([program(), "annotate", "--source", source, "--labels", str(self.labels), "--port", "0", *arguments],
                                 cwd=PROJECT, capture_output=True, text=True, check=False, timeout=LONGEST_S)
        self.assert_refused(refused, *parts)

    def test_kills_at_random_lose_no_accepted_change(self):
        chance = random.Random(4)
        accepted = 0
        for _ in range(KILLS):
            with Annotate(self.labels) as annotate:
                revision = max(0, len(lines_of(self.file)) - 1)
                self.assertGreaterEqual(revision, accepted, "an accepted change is lost")
                self.assertLessEqual(revision, accepted + 1, "at most one was on its way")
                accepted = revision  # what is on the disk stays there, answered or not
                killer = threading.Timer(chance.uniform(0.05, 0.5), annotate.process.kill)
                killer.start()
                try:
                    while True:
                        status, answer = annotate.place(revision)
                        self.assertEqual(status, 200, answer)
                        revision = accepted = answer["labels"][0]["revision"]
                except (urllib.error.URLError, ConnectionError, OSError):
                    pass
                killer.join()
                annotate.process.wait(LONGEST_S)
        self.assertGreater(accepted, 0)
        print(f"{KILLS} kills, {accepted} changes accepted", flush=True)

    def test_on_a_full_disk_work_waits_in_memory_and_is_said(self):
        with Annotate(self.labels, most_bytes=4096) as annotate:
            revision, fault = 0, ""
            while not fault:
                status, answer = annotate.place(revision)
                self.assertEqual(status, 200)
                revision, fault = answer["labels"][0]["revision"], answer["fault"]
            self.assertIn("labels.jsonl: cannot write", fault)
            self.assertEqual(answer["waiting"], 1)
            self.assertEqual(self.file.read_text()[-1], "\n", "nothing half-written")
            resource.prlimit(annotate.process.pid, resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            end = time.monotonic() + LONGEST_S
            while len(lines_of(self.file)) != revision + 1 and time.monotonic() < end:
                time.sleep(0.05)
            self.assertEqual(len(lines_of(self.file)), revision + 1, "written once there is room")
            self.assertEqual(annotate.place(revision)[1]["fault"], "")

    def test_what_is_lost_with_the_end_of_the_program_is_said(self):
        with Annotate(self.labels, most_bytes=2048) as annotate:
            for revision in range(5):
                annotate.place(revision)
            annotate.process.send_signal(signal.SIGINT)
            self.assertEqual(annotate.process.wait(LONGEST_S), 1)
            self.assertIn("changes are lost", annotate.said().splitlines()[-1])

    def test_labels_that_are_wrong_end_in_one_line(self):
        with Annotate(self.labels) as annotate:
            for revision in range(3):
                annotate.place(revision)
        good = self.file.read_text()
        lines = good.splitlines()
        self.file.write_text("\n".join([lines[0], lines[1].replace('"act"', '"acts"'), *lines[2:]]) + "\n")
        self.annotate_refused("labels.jsonl:2", "unknown key 'acts'")
        self.file.write_text("\n".join([lines[0], *lines[2:]]) + "\n")
        self.annotate_refused("labels.jsonl:2", "revision 2 of the right hand of frame 0, expected 1")
        self.file.write_text(good)
        self.annotate_refused("3 frames", source="synthetic:manifests/demo.toml?count=2")
        self.annotate_refused("--convention knuckle22", arguments=["--convention", "icg20"])
        self.file.write_text(good.replace('"fingerprint":"', '"fingerprint":"0'))
        self.annotate_refused("have changed", "--accept-changed-source")
        with Annotate(self.labels, "--accept-changed-source") as annotate:
            self.assertEqual(annotate.place(3)[0], 200)
            self.annotate_refused("another program writes these labels")
        shutil.rmtree(self.labels)
        self.labels.write_text("a file")
        self.annotate_refused(str(self.labels))
        self.annotate_refused("author", arguments=["--author", "../x"])

    def test_messages_that_are_wrong_change_nothing(self):
        with Annotate(self.labels) as annotate:
            self.assertEqual(annotate.place(0)[0], 200)
            for body, status in [(b"{", 400), (b"x" * 9000, 413), (b'{"act":"verify","frame":3,"side":"right","revision":1}', 400),
                                 (b'{"act":"verify","frame":0,"side":"right","revision":0}', 409)]:
                self.assertEqual(annotate.post(body)[0], status, body)
            self.assertEqual(annotate.place(1, frame=7)[0], 400)
            self.assertEqual(annotate.post({"act": "undo"}, Origin="http://example.org")[0], 403)
            self.assertEqual(annotate.post({"act": "undo"}, Host="example.org")[0], 403)
        self.assertEqual(len(lines_of(self.file)), 2)

    def test_authors_are_apart_and_compared(self):
        for author, place_mm in [("ann", 0), ("bea", 3)]:
            with Annotate(self.labels, "--author", author) as annotate:
                annotate.place(0, point_mm=[place_mm, 10, 500], seconds=2.5 + place_mm)
                annotate.post({"act": "verify", "frame": 0, "side": "right", "revision": 1, "seconds": 1})
                annotate.post({"act": "brush", "frame": 0, "side": "right", "revision": 2, "points": [[50 + place_mm, 50]], "radius_px": 4,
                               "erases": False})
        report = self.folder / "report.json"
        compared = run("labels", "compare", "--labels", str(self.labels), "--authors", "ann", "bea", "--json", str(report))
        self.assertEqual(compared.returncode, 0, compared.stderr)
        self.assertRegex(compared.stdout, r"wrist +1 +3\.00 +3\.00")
        self.assertIn("bea: worked on 1 frames, 6.5 s each (median), 90th percentile 6.5 s, 6 s in all", compared.stdout)
        said = json.loads(report.read_text())
        self.assertEqual(said["hands"], 1)
        self.assertEqual(said["authors"], [{"name": name, "frames": 1, "median_s": s, "percentile90_s": s, "total_s": s}
                                           for name, s in [("ann", 3.5), ("bea", 6.5)]])
        self.assertAlmostEqual(said["landmarks"]["wrist"]["mean_mm"], 3, places=3)
        self.assertIsNone(said["landmarks"]["palm"]["mean_mm"], "nobody has labelled it")
        [hand] = said["frames"]
        self.assertEqual([hand["frame"], hand["side"], hand["landmarks"]], [0, "right", 1])
        self.assertAlmostEqual(hand["mean_mm"], 3, places=3)
        self.assertTrue(0.3 < hand["mask_iou"] < 0.9, hand["mask_iou"])
        refused = run("labels", "compare", "--labels", str(self.labels), "--authors", "ann", "bea", "--json", str(self.labels))
        self.assert_refused(refused, str(self.labels))
        self.assert_refused(run("labels", "compare", "--labels", str(self.labels), "--authors", "ann", "cid"), "labels.cid.jsonl")

    def test_labels_are_exported_smooth_where_asked_for(self):
        common = ["--source", "synthetic:manifests/test_still.toml?count=9", "--labels", str(self.labels)]
        imported = run("labels", "import", *common)
        self.assertEqual(imported.returncode, 0, imported.stderr)
        out = self.folder / "poses.txt"

        def exported(*smooth):
            done = run("labels", "export", *common, "--format", "poses", "--out", str(out), *smooth)
            self.assertEqual(done.returncode, 0, done.stderr)
            return [float(number) for line in out.read_text().splitlines() if not line.startswith("#") for number in line.split()]

        plain = exported()
        self.assertEqual(exported("--smooth", "0"), plain)
        smooth = exported("--smooth", "4")
        self.assertEqual(len(smooth), len(plain))
        self.assertLess(max(abs(a - b) for a, b in zip(smooth, plain)), 0.01, "a hand that is still stays where it is")
        lines = self.file.read_text().splitlines()
        record = json.loads(lines[5])
        record["landmarks"]["palm"][2] += 20
        lines[5] = json.dumps(record, separators=(",", ":"))
        self.file.write_text("\n".join(lines) + "\n")
        far_off = max(abs(a - b) for a, b in zip(exported(), plain))
        self.assertAlmostEqual(far_off, 20, places=2)
        self.assertLess(max(abs(a - b) for a, b in zip(exported("--smooth", "4"), plain)), 8, "the others say where it was")
        for wrong in ["-1", "101", "few"]:
            refused = run("labels", "export", *common, "--format", "poses", "--out", str(out), "--smooth", wrong)
            self.assertEqual(refused.returncode, 2, "a wrong option")
            self.assertIn("--smooth", refused.stderr)


if __name__ == "__main__":
    skip_without_server()
    unittest.main(argv=sys.argv[:1], verbosity=2)
