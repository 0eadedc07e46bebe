# SPDX-License-Identifier: Apache-2.0
"""Streams: a source played, at its times, to an iterator."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import knuckle
from testing import DEMO, demo_frames

PLAYED = f"synthetic:{DEMO}?rate=1000"

WAITING = """
import knuckle
print("begun", flush=True)
try:
    for frame in knuckle.open_stream("synthetic:{manifest}?rate=0.01"):
        print("frame", flush=True)
except KeyboardInterrupt:
    print("ended", flush=True)
"""


class Streams(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.frames = demo_frames()

    def test_gives_the_frames_of_the_source(self):
        frames = list(knuckle.open_stream(PLAYED))
        self.assertEqual([frame.name for frame in frames], [frame.name for frame in self.frames])
        for index in (0, 17, 39):
            self.assertTrue(np.array_equal(frames[index].depth_mm, self.frames[index].depth_mm))

    def test_keeps_to_the_rate(self):
        stream = knuckle.open_stream(f"synthetic:{DEMO}?rate=50")
        next(stream)
        begun = time.monotonic()
        for _ in range(10):
            next(stream)
        self.assertGreater(time.monotonic() - begun, 0.15)  # 10 of them are 0.2 s; never ahead of it

    def test_has_ended_for_good(self):
        stream = knuckle.open_stream(PLAYED)
        self.assertIs(iter(stream), stream)
        self.assertEqual(sum(1 for _ in stream), 40)
        self.assertEqual(list(stream), [])
        self.assertEqual(stream.lost_frames, 0)

    def test_can_be_closed(self):
        with knuckle.open_stream(PLAYED) as stream:
            self.assertEqual(next(stream).name, "000000")
        self.assertEqual(list(stream), [])
        stream.close()

    def test_a_frame_that_cannot_be_read_does_not_end_it(self):
        with tempfile.TemporaryDirectory() as folder:
            made = pathlib.Path(folder) / "set"
            subprocess.run([os.environ["KNUCKLE_PROGRAM"], "render", "--manifest", DEMO, "--count", "3", "--format", "folder", "--out",
                            made], check=True, capture_output=True)
            sorted((made / "depth").glob("*.png"))[1].write_bytes(b"no image")
            stream = knuckle.open_stream(f"folder:{made}?rate=1000")
            self.assertEqual(next(stream).name, "00000000")
            with self.assertRaisesRegex(knuckle.Error, "00000001.png"):
                next(stream)
            self.assertEqual([frame.name for frame in stream], ["00000002"])

    def test_no_such_stream(self):
        for text, words in (("nothing:x", "nothing"), ("folder:nowhere", "nowhere"), ("v4l2:/dev/null", "/dev/null"),
                            (f"synthetic:{DEMO}?rate=-1", "rate")):
            with self.assertRaisesRegex(knuckle.Error, words) as caught:
                knuckle.open_stream(text)
            self.assertNotIn("\n", str(caught.exception))

    def test_other_threads_run_while_it_waits(self):
        stream = knuckle.open_stream(f"synthetic:{DEMO}?rate=4")
        next(stream)
        turns = 0
        thread = threading.Thread(target=lambda: next(stream))
        thread.start()
        while thread.is_alive():
            time.sleep(0.001)
            turns += 1
        self.assertGreater(turns, 20)

    def test_is_for_one_thread_at_a_time(self):
        stream = knuckle.open_stream(f"synthetic:{DEMO}?rate=2")
        next(stream)
        thread = threading.Thread(target=lambda: next(stream))
        thread.start()
        time.sleep(0.1)
        with self.assertRaisesRegex(knuckle.Error, "two threads"):
            next(stream)
        thread.join()

    def test_close_ends_the_waiting_of_another_thread(self):
        stream = knuckle.open_stream(f"synthetic:{DEMO}?rate=0.01")
        next(stream)
        other = knuckle.open_stream(f"synthetic:{DEMO}?rate=2")
        next(other)
        came, of_other = [], []
        threads = [threading.Thread(target=lambda: came.extend(stream)), threading.Thread(target=lambda: of_other.append(next(other)))]
        for thread in threads:
            thread.start()
        time.sleep(0.1)
        self.assertEqual(stream.lost_frames, 0)  # does not wait either
        stream.close()
        for thread in threads:
            thread.join(20)
            self.assertFalse(thread.is_alive())
        self.assertEqual(came, [])
        self.assertEqual(len(of_other), 1)  # all other work goes on
        self.assertEqual(list(stream), [])

    def test_control_c_ends_the_waiting(self):
        program = subprocess.Popen([sys.executable, "-c", WAITING.format(manifest=DEMO)], stdout=subprocess.PIPE, text=True)
        self.assertEqual(program.stdout.readline(), "begun\n")
        self.assertEqual(program.stdout.readline(), "frame\n")
        time.sleep(0.2)
        program.send_signal(signal.SIGINT)
        self.assertEqual(program.communicate(timeout=30)[0], "ended\n")

    def test_a_tracker_follows_a_stream(self):
        tracker = knuckle.Tracker(knuckle.Pipeline.load(knuckle.data_file("pipelines/track.toml")))
        ids = [hand.id for frame in knuckle.open_stream(PLAYED) for hand in tracker.update(frame)]
        self.assertTrue(ids)
        self.assertEqual(ids[0], 1)


if __name__ == "__main__":
    unittest.main()
