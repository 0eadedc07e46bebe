#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes recordings as of an Azure Kinect with ffmpeg, which mkv_test.cpp compares with.

    fuzz/write_mkvs.py FOLDER [--azure]        (Debian: ffmpeg)

Those of 16 x 12 pixels, and a calibration, are fuzz/corpus/mkv; azure.mkv (--azure) has the size, the calibration and
the tags of a real one. Pixel (column, row) of depth image i is 600 + i + column + 3 row [mm]; every seventh is not
measured. That of infrared image i is 100 + i + 2 column + row. There are 32 images per second.
"""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

FRAMES = 3

# Of a device that its owner showed in public (Azure-Kinect-Sensor-SDK, issue 1488).
PARAMETERS = [
    0.5014757513999939, 0.49704870581626892, 0.49203813076019287, 0.49193161725997925,
    4.72473669052124, 3.2092227935791016, 0.17059645056724548, 5.0558595657348633, 4.775780200958252,
    0.88649415969848633, 0, 0, 0.0001238211989402771, 5.87981094213319e-6,
]


def camera(purpose, parameters):
    return {
        "Intrinsics": {
            "ModelParameterCount": 14,
            "ModelParameters": parameters,
            "ModelType": "CALIBRATION_LensDistortionModelBrownConrady",
        },
        "Purpose": f"CALIBRATION_CameraPurpose{purpose}",
        "SensorHeight": 1024,
        "SensorWidth": 1024,
    }


CALIBRATION = {
    "CalibrationInformation": {"Cameras": [camera("PhotoVideo", [0.5] * 14), camera("Depth", PARAMETERS)]}
}


def samples(width, height, order, value):
    numbers = [value(i, column, row) for i in range(FRAMES) for row in range(height) for column in range(width)]
    return struct.pack(f"{order}{len(numbers)}H", *numbers)


def depth(i, column, row):
    return 0 if (row + column) % 7 == 0 else 600 + i + column + 3 * row


def infrared(i, column, row):
    return 100 + i + 2 * column + row


def with_pixel_code(content, width, height, code, is_uncompressed):
    """ffmpeg names no 16-bit samples: it writes 0 as their code, and 24 bits. The sum of the tracks follows."""
    for bits in (16, 24):
        header = struct.pack("<IiiHH", 40, width, -height, 1, bits) + bytes(4)
        content = content.replace(header, struct.pack("<IiiHH", 40, width, -height, 1, 16) + code)
    if is_uncompressed:
        content = content.replace(b"\x86\x8fV_MS/VFW/FOURCC", b"\x86\x8fV_UNCOMPRESSED\0")
        content = content.replace(b"\x2e\xb5\x24\x84" + bytes(4), b"\x2e\xb5\x24\x84" + code)
    tracks = content.index(b"\x16\x54\xae\x6b\x41")  # with a length of two bytes; the list of places has the name alone
    if content[tracks + 6] == 0xBF:
        end = tracks + 6 + (struct.unpack_from(">H", content, tracks + 4)[0] & 0x3FFF)
        total = struct.pack("<I", zlib.crc32(content[tracks + 12 : end]))
        content = content[: tracks + 8] + total + content[tracks + 12 :]
    return content


def write_mkv(path, width, height, code, options=(), tags=(), is_uncompressed=False):
    order = ">" if code == b"b16g" else "<"
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        (folder / "calibration.json").write_bytes(json.dumps(CALIBRATION).encode() + b"\0")
        command = ["ffmpeg", "-nostdin", "-loglevel", "error"]
        for name, value in (("DEPTH", depth), ("IR", infrared)):
            (folder / name).write_bytes(samples(width, height, order, value))
            command += ["-f", "rawvideo", "-pix_fmt", "gray16be" if order == ">" else "gray16le"]
            command += ["-video_size", f"{width}x{height}", "-framerate", "32", "-i", str(folder / name)]
        command += ["-map", "0", "-map", "1", "-c", "copy", "-metadata:s:v:0", "title=DEPTH", "-metadata:s:v:1", "title=IR"]
        for tag in tags:
            command += ["-metadata:s:v:0", tag]
        if tags:
            command += ["-attach", str(folder / "calibration.json")]
            command += ["-metadata:s:t:0", "mimetype=application/octet-stream"]
        command += ["-allow_raw_vfw", "1", *options, "-fflags", "+bitexact", "-f", "matroska", "-y", str(path)]
        subprocess.run(command, check=True)
    path.write_bytes(with_pixel_code(path.read_bytes(), width, height, code, is_uncompressed))


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
write_mkv(folder / "b16g", 16, 12, b"b16g", ["-write_crc32", "0"])
write_mkv(folder / "y16", 16, 12, b"Y16 ")
write_mkv(folder / "uncompressed", 16, 12, b"Y16 ", is_uncompressed=True)
write_mkv(folder / "live", 16, 12, b"b16g", ["-live", "1"])
(folder / "calibration").write_text(json.dumps(CALIBRATION))
if len(sys.argv) > 2 and sys.argv[2] == "--azure":
    write_mkv(folder / "azure.mkv", 320, 288, b"b16g", tags=["K4A_DEPTH_TRACK=1", "K4A_DEPTH_MODE=NFOV_2X2BINNED"])
