# SPDX-License-Identifier: Apache-2.0
"""Worker processes give the same frames and poses; Ctrl-C ends a program as it ends any other in Python."""

import multiprocessing
import signal
import subprocess
import sys
import time
import unittest

import knuckle
from testing import DEMO, SMALL_PIPELINE, demo_frames, poses_of

COUNT = 6
FOR_EVER = f"""
import knuckle
pipeline, frame = knuckle.Pipeline.from_toml('''{SMALL_PIPELINE}'''), knuckle.render({str(DEMO)!r}, 0)
print("begins", flush=True)
while True:
    pipeline.estimate(frame.depth_mm, frame.camera)
"""
# The truth of 1,000,000 frames.
LONG_CALL = f"""
import knuckle, pathlib, tempfile
with tempfile.TemporaryDirectory() as folder:
    manifest = pathlib.Path(folder) / "long.toml"
    manifest.write_text(pathlib.Path({str(DEMO)!r}).read_text().replace("frames = 40", "frames = 1000000"))
    print("begins", flush=True)
    knuckle.evaluate(f"synthetic:{{manifest}}", {{"none": manifest}})
"""


def work(index):
    frame = knuckle.render(DEMO, index)
    pipeline = knuckle.Pipeline.from_toml(SMALL_PIPELINE)
    return frame.depth_mm.tobytes(), poses_of(pipeline.estimate(frame.depth_mm, frame.camera))


class Processes(unittest.TestCase):
    def test_workers_give_the_same_answers(self):
        demo_frames()
        expected = [work(index) for index in range(COUNT)]
        for way in ("fork", "spawn"):
            with multiprocessing.get_context(way).Pool(2) as workers:
                self.assertEqual(workers.map(work, range(COUNT)), expected, way)

    def assert_ctrl_c_ends(self, program):
        """Within seconds, and as Python says it."""
        with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            self.assertEqual(running.stdout.readline(), "begins\n")
            time.sleep(0.5)
            running.send_signal(signal.SIGINT)
            _, errors = running.communicate(timeout=30)
        self.assertEqual(running.returncode, -signal.SIGINT, errors)
        self.assertIn("KeyboardInterrupt", errors)

    def test_ctrl_c_between_calls(self):
        demo_frames()
        self.assert_ctrl_c_ends(FOR_EVER)

    def test_ctrl_c_in_a_long_call(self):
        demo_frames()
        self.assert_ctrl_c_ends(LONG_CALL)


if __name__ == "__main__":
    unittest.main()
