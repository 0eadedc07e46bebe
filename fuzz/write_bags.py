#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the bags of fuzz/corpus/rosbag with ROS's own library, which rosbag_test.cpp compares with, too.

    fuzz/write_bags.py FOLDER        (Debian: python3-rosbag python3-sensor-msgs)

Pixel (column, row) of image i is 600 + i + column + 3 row [mm]; every seventh is not measured.
"""
import pathlib
import struct
import sys

import genpy
import rosbag
from sensor_msgs.msg import CameraInfo, Image

WIDTH, HEIGHT = 16, 12


def depth_image(number: int, time_s: float) -> Image:
    message = Image(width=WIDTH, height=HEIGHT, encoding="16UC1", is_bigendian=0, step=2 * WIDTH)
    message.header.stamp = genpy.Time.from_sec(time_s)
    message.header.frame_id = "camera_depth_optical_frame"
    pixels = [0 if (row + column) % 7 == 0 else 600 + number + column + 3 * row
              for row in range(HEIGHT) for column in range(WIDTH)]
    message.data = struct.pack(f"<{len(pixels)}H", *pixels)
    return message


def camera_info(time_s: float) -> CameraInfo:
    message = CameraInfo(width=WIDTH, height=HEIGHT, distortion_model="plumb_bob")
    message.header.stamp = genpy.Time.from_sec(time_s)
    message.D = [0.1, -0.2, 0.001, 0.002, 0.03]
    message.K = [15.5, 0, 7.25, 0, 16.25, 5.75, 0, 0, 1]
    message.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
    message.P = [15.5, 0, 7.25, 0, 0, 16.25, 5.75, 0, 0, 0, 1, 0]
    return message


def write_bag(path: pathlib.Path, compression: str) -> None:
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=2500) as bag:
        for number in range(3):
            time_s = 1600000000.25 + number / 32
            recorded = genpy.Time.from_sec(time_s + 0.01)
            bag.write("/camera/depth/camera_info", camera_info(time_s), recorded)
            bag.write("/camera/depth/image_raw", depth_image(number, time_s), recorded)


for kind in (CameraInfo, Image):  # without comments the bags are a third as large
    kind._full_text = "\n".join(line for line in kind._full_text.split("\n") if line and line[0] != "#")

for name in ("none", "bz2", "lz4"):
    write_bag(pathlib.Path(sys.argv[1]) / name, name)
