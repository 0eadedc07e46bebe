# SPDX-License-Identifier: Apache-2.0
"""A program may end while daemon threads are inside the library: quietly, with the status that it asks for."""

import subprocess
import sys
import unittest

from testing import DEMO, SMALL_PIPELINE, demo_frames

TIMES = 4  # where a thread is when the interpreter ends is chance

BEGINNING = f"""
import sys, threading, time
import numpy as np
import knuckle
frame = knuckle.render({str(DEMO)!r}, 0)
NEAREST = '[segmentation]\\nmethod = "threshold"\\n'

def middle(patch):
    return np.zeros((22, 3))

def for_ever(work):
    def loop():
        while True:
            work()
    threading.Thread(target=loop, daemon=True).start()
"""

WORKS = {
    "an estimator of Python's": """
pipeline = knuckle.Pipeline.from_toml(NEAREST, estimator=knuckle.Estimator(middle, "knuckle22", passes=5))
for _ in range(3):
    for_ever(lambda: pipeline.estimate(frame.depth_mm, frame.camera))
""",
    "an estimator of Python's that is at work": """
def slow(patch):
    time.sleep(0.01)
    return sum(range(100_000)) * middle(patch)

tracker = knuckle.Tracker(knuckle.Pipeline.from_toml(NEAREST, estimator=knuckle.Estimator(slow, "knuckle22", passes=5)))
for_ever(lambda: tracker.update(frame))
pipeline = knuckle.Pipeline.from_toml(NEAREST, estimator=knuckle.Estimator(slow, "knuckle22", passes=5))
for _ in range(2):
    for_ever(lambda: pipeline.estimate(frame.depth_mm, frame.camera))
""",
    "a network": f"""
pipeline = knuckle.Pipeline.from_toml('''{SMALL_PIPELINE}''')
for _ in range(2):
    for_ever(lambda: pipeline.estimate(frame.depth_mm, frame.camera))
""",
    "a stream that is waited for": f"""
stream = knuckle.open_stream("synthetic:{DEMO}?rate=0.01")
next(stream)
for_ever(lambda: next(stream))
""",
    "a source": f"""
source = knuckle.open_source("synthetic:{DEMO}")
for _ in range(3):
    for_ever(lambda: source[0].depth_mm)
""",
    "an evaluation": f"""
for_ever(lambda: knuckle.evaluate("synthetic:{DEMO}", {{"none": np.ones((40, 22, 3))}}))
""",
}

END = """
time.sleep(0.3)
print("leaves", flush=True)
sys.exit(3)
"""


class Endings(unittest.TestCase):
    maxDiff = None

    def test_daemon_threads_end_quietly(self):
        demo_frames()
        for name, work in WORKS.items():
            for _ in range(TIMES):
                with self.subTest(name):
                    ended = subprocess.run([sys.executable, "-c", BEGINNING + work + END], capture_output=True, text=True, timeout=60,
                                           check=False)
                    self.assertEqual((ended.stdout, ended.stderr, ended.returncode), ("leaves\n", "", 3))


if __name__ == "__main__":
    unittest.main()
