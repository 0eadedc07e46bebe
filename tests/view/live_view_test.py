# SPDX-License-Identifier: Apache-2.0
"""`knuckle live --view` from outside: its address, page, sockets, recordings, and how it ends.

usage: live_view_test.py KNUCKLE LIVE_CLIENT
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from live_program import LONGEST_S, PROJECT, SOURCE, Live, Socket, program, skip_without_server


def run(*arguments, **options):
    return subprocess.run([program(), *arguments], cwd=PROJECT, capture_output=True, text=True, timeout=LONGEST_S, check=False,
                          **options)


def frames_in(path):
    """The number of frames of a set, as `inspect` says it."""
    kind = "folder" if path.is_dir() else "h5"
    found = run("inspect", "--source", f"{kind}:{path}")
    assert found.returncode == 0, found.stderr
    return next(int(line.split()[1]) for line in found.stdout.splitlines() if line.startswith("frames"))


class LiveViewTest(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = pathlib.Path(place.name)

    def test_records_and_frames_tell_the_same(self):
        with Live() as live:
            records = Socket(live, "/api/records")
            frames = Socket(live, "/api/frames")
            by_number = {}
            for _ in range(10):
                record = json.loads(records.message())
                by_number[record["frame"]] = record
                self.assertGreater(record["latency_ms"], 0.0)
            compared = 0
            for _ in range(10):
                header, pixels = frames.frame()
                self.assertEqual(len(pixels), header["width"] * header["height"])
                self.assertEqual(len(header["surface"]), len(header["record"]["hands"]))
                self.assertTrue(any(pixels))
                record = by_number.get(header["record"]["frame"])
                if record:
                    compared += 1
                    self.assertEqual(record, header["record"])
            self.assertGreater(compared, 0)
            status, _, info = live.ask("GET", "/api/info")
            self.assertEqual(status, 200)
            info = json.loads(info)
            self.assertEqual(info["source"], SOURCE)
            self.assertEqual(list(header["record"]["hands"][0]["landmarks_mm"]), info["landmarks"])
            self.assertEqual(info["camera"], header["camera"])
            self.assertFalse(info["can_record"])

    def test_ctrl_c_ends_it_and_its_sockets(self):
        with Live() as live:
            records = Socket(live, "/api/records")
            frames = Socket(live, "/api/frames")
            records.message()
            frames.message()
            status, out, errors = live.end()
            self.assertEqual((status, errors), (0, ""))
            self.assertIn("frames came", out)
            while records.message() is not None:
                pass
            while frames.message() is not None:
                pass

    def test_the_page_is_a_page_or_a_sentence(self):
        with Live() as live:
            status, fields, body = live.ask("GET", "/")
            if (PROJECT / "web/dist/index.html").exists():
                self.assertEqual(status, 200)
                self.assertEqual(body, (PROJECT / "web/dist/index.html").read_bytes())
                self.assertIn("default-src 'self'", fields["content-security-policy"])
            else:
                self.assertEqual(status, 404)
                self.assertIn(b"The page is not installed", body)

    def test_a_port_in_use_is_one_line(self):
        with Live() as live:
            second = run("live", "--source", SOURCE, "--view", str(live.port))
            self.assertEqual(second.returncode, 1)
            self.assertEqual(second.stderr, f"knuckle: port {live.port} of 127.0.0.1 is in use by another program; choose another "
                                            "port, or 0 for any that is free\n")

    def test_wrong_options_are_said(self):
        for options, status, part in [(["--view", "x"], 2, "'x' is no port"), (["--view", "70000"], 2, "'70000' is no port"),
                                      (["--host", "0.0.0.0"], 2, "--view"), (["--record-folder", "x"], 2, "--view"),
                                      (["--view", "0", "--host", "nowhere"], 1, "nowhere")]:
            wrong = run("live", "--source", SOURCE, *options)
            self.assertEqual(wrong.returncode, status, wrong.stderr)
            self.assertIn(part, wrong.stderr)

    def test_without_a_number_it_is_the_usual_port(self):
        seen = run("live", "--view", "--source", SOURCE, "--frames", "1").stderr
        self.assertRegex(seen, r"^(view: http://127\.0\.0\.1:8790/|knuckle: port 8790 of 127\.0\.0\.1 is in use)")

    def test_another_host_needs_the_token(self):
        with Live("--host", "0.0.0.0") as live:
            self.assertEqual(len(live.token), 32)
            for path in ["/", "/api/info", "/api/records.jsonl"]:
                self.assertEqual(live.ask("GET", path)[0], 403)
                self.assertEqual(live.ask("GET", f"{path}?token={live.token[:-1]}x")[0], 403)
            self.assertEqual(live.ask("GET", f"/api/info?token={live.token}", Host="lab.example:1")[0], 200)
            self.assertEqual(Socket(live, "/api/records").status, 403)
            self.assertEqual(Socket(live, f"/api/records?token={live.token}").status, 101)

    def test_clients_that_come_and_go_leave_nothing(self):
        with Live() as live:
            records = Socket(live, "/api/records")
            records.message()
            before = live.descriptors()
            for i in range(500):
                if i == 100:
                    memory = live.memory_kb()  # by now all has been used once
                guest = Socket(live, ("/api/records", "/api/frames")[i % 2])
                self.assertEqual(guest.status, 101)
                if i % 50 == 0:
                    guest.message()
                guest.close()
            for _ in range(300):
                if live.descriptors() <= before:
                    break
                records.message()
            self.assertLessEqual(live.descriptors(), before)
            if os.environ.get("KNUCKLE_SANITIZE") != "thread":  # which keeps memory of its own beside what is used
                self.assertLess(live.memory_kb() - memory, 20000)

    def test_a_sleeping_client_costs_nobody_a_record(self):
        with Live() as live:
            asleep = Socket(live, "/api/frames")
            readers = [Socket(live, "/api/records") for _ in range(3)]
            seen = [[json.loads(reader.message())["frame"] for _ in range(40)] for reader in readers]
            for numbers in seen:
                self.assertEqual(numbers, sorted(numbers))
            common = max(numbers[0] for numbers in seen)
            alike = [[number for number in numbers if number >= common] for numbers in seen]
            shortest = min(len(numbers) for numbers in alike)
            self.assertEqual(alike[0][:shortest], alike[1][:shortest])
            self.assertEqual(alike[0][:shortest], alike[2][:shortest])
            asleep.close()

    def set_recording(self, live, on, **fields):
        status, _, body = live.ask("POST", "/api/recording", json.dumps({"on": on}), **fields)
        return status, body.decode()

    def test_the_page_begins_and_ends_recordings(self):
        with Live("--record-folder", str(self.folder / "takes")) as live:
            frames = Socket(live, "/api/frames")
            self.assertIsNone(frames.frame()[0]["recording"]["file"])
            self.assertEqual(self.set_recording(live, True, Origin="http://evil.org")[0], 403)
            self.assertEqual(self.set_recording(live, True)[0], 200)
            recording = {"frames": 0}
            while recording["frames"] < 5:
                recording = frames.frame()[0]["recording"]
            self.assertRegex(recording["file"], r"^hand-\d{8}-\d{6}\.h5$")
            self.assertEqual(self.set_recording(live, False)[0], 200)
            path = self.folder / "takes" / recording["file"]
            for _ in range(600):
                if path.exists():
                    break
                time.sleep(0.1)
            self.assertGreaterEqual(frames_in(path), 5)
            for _ in range(600):  # the one before may still be on its way
                status, body = self.set_recording(live, True)
                if status == 200:
                    break
                self.assertEqual(status, 409, body)
                time.sleep(0.1)
            self.assertEqual(status, 200)
            first = recording["file"]
            while recording["file"] in (None, first) or recording["frames"] == 0:
                recording = frames.frame()[0]["recording"]
            status, _, errors = live.end()
            self.assertEqual((status, errors), (0, ""), "the second one is made whole at the end")
            takes = list((self.folder / "takes").iterdir())
            self.assertEqual(len(takes), 2, takes)
            for take in takes:
                self.assertGreater(frames_in(take), 0)

    def test_a_full_disk_ends_the_recording_and_nothing_else(self):
        with Live("--record-folder", str(self.folder), most_kb=60) as live:
            frames = Socket(live, "/api/frames")
            self.assertEqual(self.set_recording(live, True)[0], 200)
            recording = {"fault": ""}
            while not recording["fault"]:
                recording = frames.frame()[0]["recording"]
            self.assertIn("cannot write", recording["fault"])
            self.assertIsNone(recording["file"])
            for _ in range(5):
                frames.frame()
            status, _, errors = live.end()
            self.assertEqual(status, 1)
            self.assertRegex(errors, r"^knuckle: .*cannot write: .*`knuckle record --finish .*\n$")

    def test_a_recording_of_the_whole_run_is_not_the_pages(self):
        with Live("--record", str(self.folder / "a.h5")) as live:
            frames = Socket(live, "/api/frames")
            for _ in range(5):
                header = frames.frame()[0]
            self.assertEqual(header["recording"]["file"], "a.h5")
            self.assertEqual(self.set_recording(live, False)[0], 409)
            self.assertEqual(live.end()[0], 0)
            self.assertGreaterEqual(frames_in(self.folder / "a.h5"), 5)

    def test_without_a_place_there_is_no_recording(self):
        with Live() as live:
            status, body = self.set_recording(live, True)
            self.assertEqual(status, 409)
            self.assertIn("--record-folder", body)


if __name__ == "__main__":
    skip_without_server()
    unittest.main(argv=sys.argv[:1])
