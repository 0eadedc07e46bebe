#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Damages files of every reader at random and runs the program on each: it has to end with status 0 or 1, with one line
that starts with "knuckle: " where it is 1, print nothing that a terminal would take for a command, and need less than
10 s and 1 GB.

    python3 scripts/damage_files.py COUNT [--program build/release/bin/knuckle] [--first 0] [--seed 1] [--jobs 1] [--keep FOLDER]

Prints how many runs each reader had and how many of them were refused; status 1 where a run broke a rule, whose file is
kept in --keep.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zlib

PROJECT = pathlib.Path(__file__).resolve().parents[1]
MOST_SECONDS = 10
MOST_MEGABYTES = 1000
GROWING = (".partial", ".resume", ".jsonl")
HANGS_AFTER_SECONDS = 180  # by the clock: a busy machine may leave a run waiting


class Case:
    """A reader: a good file, and the program's arguments that read it; FOLDER and FILE stand for their places.

    `mend` makes sums fit again, so that what lies after them is reached. Most run on one thread, which shows faults that hang on
    nothing else; those of readers that work on several at once on two.
    """

    def __init__(self, name, folder, file, arguments, mend=lambda content: content, threads=1):
        self.name, self.folder, self.file, self.arguments, self.mend = name, folder, file, arguments, mend
        self.threads = threads

    def command(self, program, folder):
        """The command that reads this case's file in `folder`."""
        places = [a.replace("FOLDER", str(folder)).replace("FILE", str(folder / self.file)) for a in self.arguments]
        return [program, *places, "--threads", str(self.threads)]


def run(program, arguments):
    subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, cwd=PROJECT)


def png(width, height, bits, kind, pixels):
    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    row = len(pixels) // height
    rows = b"".join(b"\0" + pixels[i * row : (i + 1) * row] for i in range(height))
    header = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    )


def with_png_sums(content):
    """The sums of its chunks made anew, so that damage reaches what lies after them."""
    fixed, place = bytearray(content[:8]), 8
    while place + 12 <= len(content):
        length = struct.unpack(">I", content[place : place + 4])[0]
        if place + 12 + length > len(content):
            break
        body = content[place + 4 : place + 8 + length]
        fixed += content[place : place + 4] + body + struct.pack(">I", zlib.crc32(body))
        place += 12 + length
    return bytes(fixed + content[place:])


def with_model_sum(content):
    body = content[:-16]
    return body + f"{zlib.crc32(body):08x}{zlib.adler32(body):08x}".encode()


def depth_png(width, height, generator):
    values = [generator.randrange(300, 900) for _ in range(width * height)]
    return png(width, height, 16, 0, struct.pack(f">{len(values)}H", *values))


def mat_file(frames, packed):
    """joint_uvd, 3 x frames x 36 x 3 doubles, as Matlab 5 stores it."""

    def element(kind, content):
        return struct.pack("<II", kind, len(content)) + content + b"\0" * (-len(content) % 8)

    values = [100.0 + i % 300 for i in range(3 * frames * 36 * 3)]
    array = (
        element(6, struct.pack("<II", 6, 0))
        + element(5, struct.pack("<iiii", 3, frames, 36, 3))
        + element(1, b"joint_uvd")
        + element(9, struct.pack(f"<{len(values)}d", *values))
    )
    content = element(14, array)
    if packed:
        stream = zlib.compress(content)
        content = struct.pack("<II", 15, len(stream)) + stream
    return b"MATLAB 5.0 MAT-file".ljust(116) + b"\0" * 8 + struct.pack("<HH", 0x0100, 0x4D49) + content


def mkv_with_calibration():
    """A recording of one image as an Azure Kinect's own program writes it: with the camera as an attachment."""

    def element(number, *parts):
        content = b"".join(parts)
        return bytes.fromhex(number) + struct.pack(">Q", len(content) | 1 << 56) + content

    width, height = 320, 288
    code = struct.pack("<IiiHH", 40, width, -height, 1, 16) + b"b16g" + bytes(20)
    video = element("e0", element("b0", struct.pack(">H", width)), element("ba", struct.pack(">H", height)))
    track = [element("d7", b"\1"), element("73c5", b"\1"), element("83", b"\1"), element("536e", b"DEPTH")]
    track += [element("86", b"V_MS/VFW/FOURCC"), element("63a2", code), video]
    tag = element("67c8", element("45a3", b"K4A_DEPTH_MODE"), element("4487", b"NFOV_2X2BINNED"))
    calibration = (PROJECT / "fuzz/corpus/mkv/calibration").read_bytes()
    file = [element("466e", b"calibration.json"), element("4660", b"application/octet-stream"), element("46ae", b"\1")]
    return element("1a45dfa3", element("4282", b"matroska")) + element(
        "18538067",
        element("1549a966", element("2ad7b1", b"\x0f\x42\x40")),
        element("1654ae6b", element("ae", *track)),
        element("1254c367", element("7373", element("63c0"), tag)),
        element("1941a469", element("61a7", *file, element("465c", calibration))),
        element("1f43b675", element("e7", b"\0"), element("a3", b"\x81\0\0\x80", b"\x02\x58" * (width * height))),
    )


def label_line(name, joints):
    return name + " " + " ".join("100 90 400" for _ in range(joints)) + "\n"


def folder_set(folder, generator):
    for name in ("depth", "mask", "infrared"):
        (folder / name).mkdir(parents=True)
    for i in range(2):
        (folder / f"depth/{i:06}.png").write_bytes(depth_png(64, 48, generator))
        (folder / f"mask/{i:06}.png").write_bytes(png(64, 48, 8, 0, bytes(64 * 48)))
        (folder / f"infrared/{i:06}.png").write_bytes(depth_png(64, 48, generator))
    (folder / "dataset.toml").write_text(
        "convention = 'icg20'\ndepth_unit_mm = 1.0\nside = 'right'\nrate_hz = 30\n"
        "[camera]\nmodel = 'projective'\nwidth = 64\nheight = 48\nfx = 60\nfy = 60\ncx = 32\ncy = 24\n"
        "distortion = [0.01, 0, 0, 0, 0, 0, 0, 0]\n"
    )
    (folder / "joints.txt").write_text(2 * label_line("", 20))
    (folder / "times.txt").write_text("0\n0.033\n")
    (folder / "sequences.txt").write_text("0\n")


def cases(program, root):
    generator = random.Random(1)
    folder_set(root / "folder", generator)
    inspect = ["inspect", "--source"]
    made = [
        Case(f"folder {file}", root / "folder", file, [*inspect, "folder:FOLDER"], mend)
        for file, mend in (
            ("depth/000000.png", with_png_sums),
            ("mask/000000.png", with_png_sums),
            ("infrared/000000.png", with_png_sums),
            ("dataset.toml", lambda content: content),
            ("joints.txt", lambda content: content),
            ("times.txt", lambda content: content),
            ("sequences.txt", lambda content: content),
        )
    ]
    (root / "h5").mkdir()
    run(program, ["render", "--manifest", "manifests/demo.toml", "--count", 2, "--out", root / "h5/set.h5"])
    (root / "h5/set.h5.options.toml").unlink(missing_ok=True)
    made.append(Case("h5", root / "h5", "set.h5", [*inspect, "h5:FILE"]))
    run(
        program,
        ["render", "--manifest", "manifests/demo.toml", "--count", 1, "--format", "icg", "--out", root / "icg"],
    )
    exr = next((root / "icg").rglob("*.exr")).relative_to(root / "icg")
    made.append(Case("icg exr", root / "icg", str(exr), [*inspect, "icg:FOLDER"]))
    for path in (root / "icg").rglob("*.txt"):
        made.append(Case("icg txt", root / "icg", str(path.relative_to(root / "icg")), [*inspect, "icg:FOLDER"]))
    for path in (root / "icg").rglob("*rgb*.png"):
        made.append(
            Case("icg png", root / "icg", str(path.relative_to(root / "icg")), [*inspect, "icg:FOLDER"], with_png_sums)
        )
    (root / "csv/clean").mkdir(parents=True)
    (root / "csv/calib.txt").write_text("200 200\n2 2\n")
    (root / "csv/clean/1_2_depth.csv").write_text("400,401,402\n500,501,502\n")
    (root / "csv/clean/1_2_infrared.csv").write_text("40,41,42\n50,51,52\n")
    for file in ("calib.txt", "clean/1_2_depth.csv", "clean/1_2_infrared.csv"):
        made.append(Case("icg csv", root / "csv", file, [*inspect, "icg:FOLDER"]))
    for packed in (False, True):
        folder = root / f"nyu{packed}"
        folder.mkdir()
        (folder / "depth_1_0000001.png").write_bytes(png(640, 480, 8, 2, bytes([0, 2, 88]) * (640 * 480)))
        (folder / "joint_data.mat").write_bytes(mat_file(4, packed))
        made.append(Case("nyu mat", folder, "joint_data.mat", [*inspect, "nyu:FOLDER"]))
    for kind, joints, size, images, labels in (
        ("icvl", 16, (320, 240), "Depth", "labels.txt"),
        ("hands17", 21, (640, 480), "images", "Training_Annotation.txt"),
    ):
        folder = root / kind
        (folder / images).mkdir(parents=True)
        (folder / images / "a.png").write_bytes(png(*size, 16, 0, b"\1\x90" * (size[0] * size[1])))
        (folder / labels).write_text(2 * label_line("a.png", joints))
        made.append(Case(f"{kind} labels", folder, labels, [*inspect, f"{kind}:FOLDER"]))
        made.append(Case(f"{kind} png", folder, f"{images}/a.png", [*inspect, f"{kind}:FOLDER"], with_png_sums))
    folder = root / "msra/P0/1"
    folder.mkdir(parents=True)
    (folder / "000000_depth.bin").write_bytes(
        struct.pack("<6i", 320, 240, 10, 20, 40, 50) + struct.pack("<900f", *[400.0] * 900)
    )
    (folder / "joint.txt").write_text("1\n" + 63 * "10 " + "\n")
    for file in ("P0/1/000000_depth.bin", "P0/1/joint.txt"):
        made.append(Case("msra15", root / "msra", file, [*inspect, "msra15:FOLDER"]))
    made.append(Case("nyu png", root / "nyuFalse", "depth_1_0000001.png", [*inspect, "nyu:FOLDER"], with_png_sums))
    for make in (recording_cases, model_cases, convention_cases, interrupted_cases, training_cases, plan_cases):
        made += make(program, root)
    poses = root / "poses"
    poses.mkdir()
    (poses / "poses.txt").write_text("# convention: icg20\n" + 2 * label_line("", 20))
    (poses / "boxes.csv").write_text("frame,found,x,y,width,height,milliseconds\n0,1,3,4,20,20,0.1\n1,0,0,0,0,0,0.1\n")
    evaluate = ["evaluate", "--truth", f"folder:{root / 'folder'}"]
    estimate = ["estimate", "--source", f"folder:{root / 'folder'}", "--out", root / "poses.txt"]
    run(program, [*estimate, "--records", poses / "x.jsonl"])
    made.append(Case("frame records", poses, "x.jsonl", [*evaluate, "--records", "x=FILE"]))
    made.append(Case("poses", poses, "poses.txt", [*evaluate, "--predictions", "x=FILE"]))
    made.append(Case("boxes", poses, "boxes.csv", [*evaluate, "--boxes", "x=FILE"]))
    return made


def recording_cases(_, root):
    folder = root / "recordings"
    folder.mkdir()
    (folder / "INDEX.txt").write_text("d-1300000000.033333-8000000.pgm\nr-1300000000.04-8000000.ppm\n")
    (folder / "d-1300000000.033333-8000000.pgm").write_bytes(b"P5 64 48 65535\n" + b"\x20\x03" * (64 * 48))
    (folder / "camera.toml").write_text("[camera]\nwidth = 64\nheight = 48\nfx = 60\nfy = 60\ncx = 32\ncy = 24\n")
    fakenect = ["inspect", "--source", "fakenect:FOLDER?camera=FOLDER/camera.toml"]
    made = [
        Case(f"fakenect {file}", folder, file, fakenect)
        for file in ("INDEX.txt", "d-1300000000.033333-8000000.pgm", "camera.toml")
    ]
    for packing in ("none", "bz2", "lz4"):
        shutil.copy(PROJECT / "fuzz/corpus/rosbag" / packing, folder / packing)
        made.append(Case(f"rosbag {packing}", folder, packing, ["inspect", "--source", "rosbag:FILE"]))
    for layout in ("none", "lz4", "zstd", "no_indexes", "no_chunks"):
        shutil.copy(PROJECT / "fuzz/corpus/mcap" / layout, folder / f"mcap_{layout}")
        made.append(Case(f"mcap {layout}", folder, f"mcap_{layout}", ["inspect", "--source", "mcap:FILE"]))
    (folder / "small.toml").write_text("[camera]\nwidth = 16\nheight = 12\nfx = 15\nfy = 15\ncx = 8\ncy = 6\n")
    for layout in ("b16g", "y16", "live"):
        shutil.copy(PROJECT / "fuzz/corpus/mkv" / layout, folder / f"mkv_{layout}")
        mkv = ["inspect", "--source", "mkv:FILE?camera=FOLDER/small.toml"]
        made.append(Case(f"mkv {layout}", folder, f"mkv_{layout}", mkv))
    (folder / "own.mkv").write_bytes(mkv_with_calibration())
    made.append(Case("mkv calibration", folder, "own.mkv", ["inspect", "--source", "mkv:FILE"]))
    return made + oni_cases(folder)


def oni_cases(folder):
    """OpenNI2's stand-in for a camera, recorded by OpenNI2 itself, where the tests' recorder is built."""
    recorder = PROJECT / "build/release/bin/knuckle_oni_recorder"
    if not recorder.exists():
        return []
    run(recorder, [folder / "dummy.oni", folder / "dummy.raw", 3])
    (folder / "dummy.raw").unlink()
    oni = (folder / "dummy.oni").read_bytes()
    # It lacks a property that OpenNI2 needs to play it; that takes the place of another, see openni2_test.cpp.
    place = oni.index(b"xnIsGenerating") - 32
    cropping = b"NIR\0" + struct.pack("<4IQI", 6, 1, 59, 0, 0, 11) + b"xnCropping\0" + struct.pack("<I12x", 12)
    (folder / "dummy.oni").write_bytes(oni[:place] + cropping + oni[place + len(cropping) :])
    return [Case("oni", folder, "dummy.oni", ["inspect", "--source", "oni:FILE?fov_deg=60"])]


def model_cases(program, root):
    source = f"folder:{root / 'folder'}"
    folder = root / "models"
    folder.mkdir()
    pipelines = {
        "pose_forest.model": "[patch]\nsize_px = 96\n[estimator]\nmethod = 'forest'\nmodel = 'pose_forest.model'\n",
        "dense.pt": "[estimator]\nmethod = 'dense'\nmodel = 'dense.pt'\n",
        "dense_scenes.pt": "[estimator]\nmethod = 'dense'\nmodel = 'dense_scenes.pt'\n",
        "detector.pt": "[segmentation]\nmethod = 'detector'\nmodel = 'detector.pt'\n",
        "dense.onnx": "[estimator]\nmethod = 'onnx'\nmodel = 'dense.onnx'\n",
        "segmentation_forest_wrist.model": "[segmentation]\nmethod = 'forest'\nmodel = 'segmentation_forest_wrist.model'\n",
    }
    onnx = ["export", "--model", "models/dense.pt", "--out", folder / "dense.onnx"]
    run(program, onnx)
    made = []
    for name, pipeline in pipelines.items():
        if not (folder / name).exists():
            shutil.copy(PROJECT / "models" / name, folder / name)
        (folder / f"{name}.toml").write_text(pipeline)
        verb = "segment" if pipeline.startswith("[segmentation]") else "estimate"
        arguments = [verb, "--source", source, "--pipeline", f"FOLDER/{name}.toml", "--out", "FOLDER/out"]
        mend = (lambda content: content) if name.endswith(".onnx") else with_model_sum
        made.append(Case(f"model {name}", folder, name, arguments, mend, threads=2))
        made.append(Case("pipeline", folder, f"{name}.toml", arguments))
    body = next(
        (path for path in (PROJECT / "build/release/makehuman.model",) if path.exists()),
        None,
    )
    shutil.copy(PROJECT / "manifests/demo.toml", folder / "manifest.toml")
    made.append(Case("manifest", folder, "manifest.toml", ["inspect", "--source", "synthetic:FILE"]))
    if body:
        shutil.copy(body, folder / "body.model")
        (folder / "body.toml").write_text("frames = 1\n[body]\nfile = 'body.model'\n")
        made.append(
            Case("model body", folder, "body.model", ["inspect", "--source", "synthetic:FOLDER/body.toml"], with_model_sum)
        )
    return made


def convention_cases(_, root):
    """Conventions of one's own, beside a folder set and alone, and labels."""
    own = (
        "format = 'knuckle-landmarks'\nversion = 1\nconvention = 'knob2'\nlandmarks = ['wrist', 'knob_tip']\n"
        "[knob_tip]\nbone = 'index_tip'\noffset = [0.1, 0, -0.2]\nbent = [0, 0.1, 0]\n"
    )
    folder = root / "own"
    shutil.copytree(root / "folder", folder)
    (folder / "own.toml").write_text(own)
    description = (folder / "dataset.toml").read_text().replace("'icg20'", "'own.toml'")
    (folder / "dataset.toml").write_text(description)
    (folder / "joints.txt").write_text(2 * label_line("", 2))
    made = [Case("convention", folder, "own.toml", ["inspect", "--source", "folder:FOLDER"])]
    folder = root / "definition"
    folder.mkdir()
    shutil.copy(PROJECT / "landmarks/icg20.toml", folder / "icg20.toml")
    (folder / "poses.txt").write_text("# convention: knuckle22\n" + 2 * label_line("", 22))
    evaluate = ["evaluate", "--truth", f"folder:{root / 'folder'}", "--predictions", "x=FOLDER/poses.txt"]
    made.append(Case("landmarks", folder, "icg20.toml", [*evaluate, "--landmarks", "FILE"]))
    return made


def killed(program, arguments, left, bytes_at_least=1, later_s=0.0):
    """Runs the program until it has left that file, so long at least, and kills it so much later; again where it was done before."""
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    for _ in range(20):
        process = subprocess.Popen([program, *map(str, arguments)], cwd=PROJECT, **silent)
        while process.poll() is None and not (left.exists() and left.stat().st_size >= bytes_at_least):
            time.sleep(0.001)
        time.sleep(later_s)
        process.kill()
        process.wait()
        if left.exists():
            return
    sys.exit(f"{' '.join(map(str, arguments))} left no {left.name}")


def interrupted_cases(program, root):
    """What a run left that was killed, for one that goes on; parts of a set; and labels."""
    folder = root / "stopped"
    folder.mkdir()
    (folder / "pipeline.toml").write_text(
        f"[segmentation]\nmethod = 'threshold'\n[estimator]\nmethod = 'dense'\nmodel = '{PROJECT / 'models/dense.pt'}'\n"
    )
    shutil.copy(root / "h5/set.h5", folder / "set.h5")
    estimate = ["estimate", "--source", "h5:SET", "--pipeline", "FOLDER/pipeline.toml", "--out", "FOLDER/poses.txt"]
    estimate = [a.replace("SET", str(folder / "set.h5?first=0&count=2")) for a in estimate]
    killed(program, [a.replace("FOLDER", str(folder)) for a in estimate], folder / "poses.txt.partial")
    made = [
        Case(f"resumed {file}", folder, file, [*estimate, "--resume"])
        for file in ("poses.txt.resume", "poses.txt.partial")
    ]
    take = root / "take"
    take.mkdir()
    record = ["record", "--source", f"folder:{root / 'folder'}?rate=0.2", "--out", take / "take.h5"]
    # More than its head, and the first frame to its end; the next one comes after 5 s.
    killed(program, record, take / "take.h5.partial", bytes_at_least=1000, later_s=2.0)
    made.append(Case("record --finish", take, "take.h5.partial", ["record", "--finish", "FOLDER/take.h5"], with_record_sums))
    parts = root / "parts"
    parts.mkdir()
    for i in range(2):
        demo = ["--manifest", "manifests/demo.toml", "--count", 2]
        run(program, ["render", *demo, "--shard", f"{i}/2", "--out", parts / f"{i}.h5"])
    join = ["join", "FOLDER/0.h5", "FOLDER/1.h5", "--out", "FOLDER/out.h5"]
    made.append(Case("join", parts, "1.h5", join, threads=2))
    labels = root / "labels"
    source = f"folder:{root / 'folder'}"
    run(program, ["labels", "import", "--source", source, "--labels", labels, "--convention", "icg20"])
    export = ["labels", "export", "--source", source, "--labels", "FOLDER", "--state", "estimated", "--out", "FOLDER/out"]
    made.append(Case("labels.jsonl", labels, "labels.jsonl", export))
    return made


def with_record_sums(content):
    """The sums of a frame log's records made anew (frame_log.h)."""
    lines = content.split(b"\n", 2)
    if len(lines) < 3 or not lines[1].isdigit():
        return content
    place = len(lines[0]) + len(lines[1]) + 2 + int(lines[1]) + 1
    fixed = bytearray(content)
    while place + 20 <= len(fixed):
        end = place + 16 + struct.unpack("<Q", fixed[place + 8 : place + 16])[0]
        if end + 4 > len(fixed):
            break
        fixed[end : end + 4] = struct.pack("<I", zlib.adler32(fixed[place:end]))
        place = end + 4
    return bytes(fixed)


def training_cases(program, root):
    """Configurations of trainings, and what a training keeps for the next one."""
    folder = root / "training"
    folder.mkdir()
    source = f"source = 'h5:{root / 'h5/set.h5'}'\n"
    tree = "[forest]\ntrees = 100\nmax_depth = 3\nsplits_per_node = 10\nmin_leaf_samples = 1\n"
    forests = {
        "pose-forest": "start = 'truth'\n[segmentation]\nmethod = 'threshold'\n[patch]\nsize_px = 24\n" + tree,
        "segmentation-forest": "[pixels]\nhand_pixels = 20\nbackground_pixels = 20\n" + tree,
    }
    made = []
    for kind, text in forests.items():
        (folder / f"{kind}.toml").write_text(source + text)
        train = ["train", kind, "--config", f"FOLDER/{kind}.toml", "--out", f"FOLDER/{kind}.model"]
        made.append(Case(f"training {kind}", folder, f"{kind}.toml", train))
        checkpoint = folder / f"{kind}.model.checkpoint"
        killed(program, [a.replace("FOLDER", str(folder)) for a in train], checkpoint)
        made.append(Case(f"checkpoint {kind}", folder, checkpoint.name, [*train, "--resume"], with_model_sum, threads=2))
    return made + network_training_cases(program, root, source)


def network_training_cases(program, root, source):
    """Those of networks, where the program that trains them is built."""
    if not pathlib.Path(program).with_name("knuckle-train-network").exists():
        return []
    folder = root / "network"
    folder.mkdir()
    (folder / "net.toml").write_text(
        source
        + source.replace("source", "validation", 1)
        + "start = 'truth'\n[segmentation]\nmethod = 'threshold'\n[patch]\nmode = 'cube'\nsize_px = 32\n[samples]\ncrop_px = 48\n"
        "[network]\nconvention = 'icg20'\narchitecture = 'dense'\nstem_channels = 4\nquarter_channels = 8\neighth_channels = 8\n"
        "sixteenth_channels = 8\nhead_channels = 8\n[training]\nepochs = 1\nbatch_size = 2\nshards = 2\n"
    )
    train = ["train", "network", "--config", "FOLDER/net.toml", "--out", "FOLDER/net.pt"]
    run(program, [a.replace("FOLDER", str(folder)) for a in [*train, "--cache", "FOLDER/cache"]])
    sample_file = next((folder / "cache").rglob("*.h5")).relative_to(folder)
    return [
        Case("training network", folder, "net.toml", train),
        Case("checkpoint network", folder, "net.pt.checkpoint", [*train, "--resume"], threads=2),
        Case("sample cache", folder, str(sample_file), [*train, "--cache", "FOLDER/cache"]),
    ]


def plan_cases(program, root):
    folder = root / "plan"
    folder.mkdir()
    (folder / "threshold.toml").write_text("[segmentation]\nmethod = 'threshold'\n")
    (folder / "plan.toml").write_text(
        f"title = 'One'\nconvention = 'icg20'\n[[sequence]]\nname = 'one'\nsource = 'h5:{root / 'h5/set.h5'}'\n"
        "[[segmentation]]\nname = 'threshold'\npipeline = 'threshold.toml'\n"
    )
    experiment = ["experiment", "FILE", "--out", "FOLDER/out"]
    run(program, [a.replace("FOLDER", str(folder)).replace("FILE", str(folder / "plan.toml")) for a in experiment])
    shutil.copytree(folder / "out", root / "plan_results/out")
    shutil.rmtree(folder / "out")
    (root / "plan_results/out/report.html").unlink()  # made anew from the results
    for file in ("plan.toml", "threshold.toml"):
        shutil.copy(folder / file, root / "plan_results" / file)
    summary = ["experiment", "FOLDER/plan.toml", "--out", "FOLDER/out"]
    return [
        Case("plan", folder, "plan.toml", experiment),
        Case("experiment summary", root / "plan_results", "out/one/boxes/threshold.json", summary),
    ]


def damaged(content, generator, mend):
    content = bytearray(content)
    for _ in range(generator.choice((1, 1, 2, 4, 16))):
        if not content:
            break
        place = generator.randrange(len(content))
        # Headers and ends hold most of what can mislead.
        if generator.random() < 0.5:
            place = min(len(content) - 1, generator.randrange(256)) if generator.random() < 0.6 else max(
                0, len(content) - 1 - generator.randrange(256)
            )
        way = generator.randrange(8)
        if way == 0:
            content[place] ^= 1 << generator.randrange(8)
        elif way == 1:
            content[place] = generator.randrange(256)
        elif way == 2:
            content[place : place + 4] = generator.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\1\0"))
        elif way == 3:
            content[place : place + 8] = struct.pack("<Q", generator.choice((2**63, 2**40, 2**32, 65536)))
        elif way == 4:
            del content[place : place + generator.randrange(1, 64)]
        elif way == 5:
            content[place:place] = bytes(generator.randrange(256) for _ in range(generator.randrange(1, 16)))
        elif way == 6:
            content[place:place] = generator.choice((b"nan ", b"1e999 ", b"-1 ", b"99999999999 ", b"\x1b[2J", b"../../", b"\n", b"[["))
        elif generator.random() < 0.3:
            del content[place:]
    return mend(bytes(content)) if generator.random() < 0.5 else bytes(content)


def require_good(program, case):
    """The file as it is has to be read: else damage would show nothing. In a copy: what is read may be used up."""
    with tempfile.TemporaryDirectory(prefix="knuckle_damage_") as folder:
        folder = pathlib.Path(folder) / "good"
        shutil.copytree(case.folder, folder)
        process = subprocess.run(case.command(program, folder), capture_output=True, text=True, cwd=PROJECT, check=False)
    if process.returncode != 0:
        sys.exit(f"{case.name}, undamaged: {process.stderr}")


def is_printable(output):
    try:
        text = output.decode()
    except UnicodeDecodeError:
        return False
    return all(c == "\n" or (c.isprintable() and not 0x80 <= ord(c) < 0xA0) for c in text)


def fault_of(process, output, error, seconds, megabytes):
    if process.returncode not in (0, 1):
        return f"status {process.returncode}"
    lines = [line for line in error.decode(errors="replace").split("\n") if line]
    faults = [line for line in lines if not line.startswith("warning: ")]
    if process.returncode == 1 and (len(faults) != 1 or not faults[0].startswith("knuckle: ")):
        return f"not one line: {faults}"
    if process.returncode == 0 and faults:
        return f"status 0, but: {faults}"
    if not is_printable(output) or not is_printable(error):
        return f"not printable: {error!r}"
    if seconds > MOST_SECONDS:
        return f"{seconds:.1f} s"
    return f"{megabytes:.0f} MB" if megabytes > MOST_MEGABYTES else None


def in_turn(program, case, number, seed, scratch, keep):
    generator = random.Random(f"{seed} {number}")
    folder = scratch / f"run{number}"
    folder.mkdir()
    try:
        for entry in case.folder.rglob("*"):
            target = folder / entry.relative_to(case.folder)
            if entry.is_dir():
                target.mkdir(exist_ok=True)
            else:
                target.parent.mkdir(parents=True, exist_ok=True)
                if entry.suffix in GROWING:  # readers go on writing these, and no link
                    shutil.copy(entry, target)
                else:
                    os.symlink(entry, target)
        file = folder / case.file
        file.unlink()
        file.write_bytes(damaged((case.folder / case.file).read_bytes(), generator, case.mend))
        start = time.monotonic()
        with open(folder / "run.out", "w+b") as out, open(folder / "run.err", "w+b") as err:
            process = subprocess.Popen(
                case.command(program, folder), stdout=out, stderr=err, stdin=subprocess.DEVNULL, cwd=PROJECT
            )
            while True:
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                if pid:
                    break
                if time.monotonic() - start > HANGS_AFTER_SECONDS:
                    process.send_signal(signal.SIGKILL)
                time.sleep(0.005)
            process.returncode = os.waitstatus_to_exitcode(status)
            out.seek(0), err.seek(0)
            output, error = out.read(), err.read()
        # The processor's time: a busy machine is not the program's fault.
        seconds = usage.ru_utime + usage.ru_stime
        fault = fault_of(process, output, error, seconds, usage.ru_maxrss / 1000)
        if fault and keep:
            keep.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, keep / f"{number}_{file.name}")
        return case.name, process.returncode, fault, number
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("--program", default=str(PROJECT / "build/release/bin/knuckle"))
    parser.add_argument("--seed", default="1")
    parser.add_argument("--first", type=int, default=0, help="number of the first run: a long list may be run in parts")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="only readers whose name holds this")
    parser.add_argument("--keep", type=pathlib.Path)
    arguments = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    runs, refused, faults = collections.Counter(), collections.Counter(), []
    with tempfile.TemporaryDirectory(prefix="knuckle_damage_") as root:
        root = pathlib.Path(root)
        (root / "good").mkdir(), (root / "runs").mkdir()
        readers = [case for case in cases(arguments.program, root / "good") if arguments.only in case.name]
        for case in readers:
            require_good(arguments.program, case)
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            jobs = [
                pool.submit(
                    in_turn, arguments.program, readers[i % len(readers)], i, arguments.seed, root / "runs", arguments.keep
                )
                for i in range(arguments.first, arguments.first + arguments.count)
            ]
            for job in concurrent.futures.as_completed(jobs):
                name, status, fault, number = job.result()
                runs[name] += 1
                refused[name] += status == 1
                if sum(runs.values()) % 500 == 0:
                    print(f"{sum(runs.values())} of {arguments.count}", file=sys.stderr)
                if fault:
                    faults.append(f"{name}, run {number}: {fault}")
                    print(faults[-1], file=sys.stderr)
    for name in sorted(runs):
        print(f"{name}: {runs[name]} runs, {refused[name]} refused")
    print(f"{sum(runs.values())} damaged files, {sum(refused.values())} refused, {len(faults)} broke a rule")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
