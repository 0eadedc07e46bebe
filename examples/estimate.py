# SPDX-License-Identifier: Apache-2.0
"""The hands in the frames of a source: a line for each, with its score and where its index finger's tip is [mm].

usage: estimate.py SOURCE        for example: estimate.py folder:my_set
"""
import sys

import knuckle

pipeline = knuckle.Pipeline.default()
for frame in knuckle.open_source(sys.argv[1]):
    estimate = pipeline.estimate(frame.depth_mm, frame.camera)
    for hand in estimate.hands:
        x, y, z = hand.landmarks_mm[hand.landmark_names.index("index_tip")]
        print(f"{frame.name} {hand.side} {hand.score:.2f} {x:.1f} {y:.1f} {z:.1f}")
    if not estimate.hands:
        print(f"{frame.name} no hand: {estimate.status}")
