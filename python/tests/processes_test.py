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

    def test_ctrl_c(self):
        demo_frames()
        with subprocess.Popen([sys.executable, "-c", FOR_EVER], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
            self.assertEqual(program.stdout.readline(), "begins\n")
            time.sleep(0.2)
            program.send_signal(signal.SIGINT)
            _, errors = program.communicate(timeout=30)
        self.assertEqual(program.returncode, -signal.SIGINT)
        self.assertIn("KeyboardInterrupt", errors)


if __name__ == "__main__":
    unittest.main()
