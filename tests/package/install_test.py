# SPDX-License-Identifier: Apache-2.0
"""Installs into a temporary prefix, builds examples/depth_array against it, and compares its pose with the program's.

usage: install_test.py BUILD_FOLDER
"""

import os
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

PROJECT = pathlib.Path(__file__).resolve().parents[2]


def run(*command, **options):
    result = subprocess.run([str(part) for part in command], capture_output=True, check=False, **options)
    assert result.returncode == 0, f"{command}\n{result.stdout.decode()}\n{result.stderr.decode()}"
    return result.stdout


def numbers(text):
    return numpy.array([float(word) for word in text.split()])


def main(build):
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        prefix = scratch / "prefix"
        run("cmake", "--install", build, "--prefix", prefix)
        program = prefix / "bin/knuckle"
        pipeline = prefix / "share/knuckle/pipelines/default.toml"
        assert not list(prefix.rglob("*testing*")), "test files are installed"
        assert (prefix / "bin/knuckle-train-network").exists()
        # Only the program that trains networks needs LibTorch, nothing that a user of the library links.
        assert b"libtorch" not in run("ldd", program), "knuckle loads LibTorch"
        assert not list((prefix / "include").rglob("training")), "the module training is installed"

        # The frame is rendered from the source tree, which has the body; the pose comes from what was installed.
        frame = scratch / "frame.h5"
        run(program, "render", "--manifest", PROJECT / "manifests/demo.toml", "--count", "1", "--out", frame,
            env={**os.environ, "KNUCKLE_HOME": str(PROJECT)})
        poses = scratch / "poses.txt"
        run(program, "estimate", "--source", f"h5:{frame}", "--out", poses)
        expected = numbers(poses.read_text().splitlines()[1])

        consumer = scratch / "consumer"
        run("cmake", "-S", PROJECT / "examples/depth_array", "-B", consumer, f"-DCMAKE_PREFIX_PATH={prefix}",
            "-DCMAKE_BUILD_TYPE=Release")
        run("cmake", "--build", consumer)
        assert b"libtorch" not in run("ldd", consumer / "depth_array"), "a user of the library loads LibTorch"
        with h5py.File(frame) as file:
            depth = file["depth"][0].astype("float32") * float(file.attrs.get("depth_unit_mm", 1.0))
        found = numbers(run(consumer / "depth_array", pipeline, input=depth.tobytes()).decode())
        assert found.shape == expected.shape, f"{found.shape} against {expected.shape}"
        error = numpy.abs(found - expected).max()
        assert error < 0.06, f"the poses differ by {error}"


main(pathlib.Path(sys.argv[1]))
