# SPDX-License-Identifier: Apache-2.0
"""Installs into a temporary prefix, builds the examples against it, and compares what they find with the
program and with the depths.

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


def build_example(name, prefix, scratch):
    """Configures and builds examples/NAME as a user would; returns its program."""
    folder = scratch / name
    run("cmake", "-S", PROJECT / "examples" / name, "-B", folder, f"-DCMAKE_PREFIX_PATH={prefix}",
        "-DCMAKE_BUILD_TYPE=Release")
    run("cmake", "--build", folder)
    assert b"libtorch" not in run("ldd", folder / name), "a user of the library loads LibTorch"
    return folder / name


def check_depth_array(program, prefix, depth, frames, scratch):
    """Finds the same joints as `knuckle estimate` does."""
    poses = scratch / "poses.txt"
    run(prefix / "bin/knuckle", "estimate", "--source", f"h5:{frames}?count=1", "--out", poses)
    expected = numbers(poses.read_text().splitlines()[1])
    pipeline = prefix / "share/knuckle/pipelines/default.toml"
    found = numbers(run(program, pipeline, input=depth[0].tobytes()).decode())
    assert found.shape == expected.shape, f"{found.shape} against {expected.shape}"
    error = numpy.abs(found - expected).max()
    assert error < 0.06, f"the poses differ by {error}"


def check_own_method(program, depth, scratch):
    """A pipeline of own parts: the tip at the nearest thing in view, the mean of the hand behind it and within its ball."""
    raw = scratch / "depth.f32"
    raw.write_bytes(depth.tobytes())
    lines = run(program, raw).decode().splitlines()
    assert len(lines) == len(depth), f"{len(lines)} lines for {len(depth)} frames"
    found = numpy.array([numbers(line) for line in lines]).reshape(len(depth), 2, 3)
    behind = found[:, 0, 2] - found[:, 1, 2]
    assert ((behind > 0) & (behind < 120)).all(), f"the palm lies {behind} mm behind the tip"
    nearest = numpy.where(depth > 0, depth, numpy.inf).min(axis=(1, 2))
    assert (numpy.abs(found[:, 1, 2] - nearest) < 30).all(), f"tips at {found[:, 1, 2]}, nearest {nearest} mm"

    (scratch / "short.f32").write_bytes(depth.tobytes()[:1000])
    result = subprocess.run([program, scratch / "short.f32"], capture_output=True, check=False)
    assert result.returncode == 1 and b"short.f32: 1000 bytes, expected" in result.stderr, result.stderr


def main(build):
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        prefix = scratch / "prefix"
        run("cmake", "--install", build, "--prefix", prefix)
        assert not list(prefix.rglob("*testing*")), "test files are installed"
        assert (prefix / "bin/knuckle-train-network").exists()
        # Only the program that trains networks needs LibTorch, nothing that a user of the library links.
        assert b"libtorch" not in run("ldd", prefix / "bin/knuckle"), "knuckle loads LibTorch"
        assert not list((prefix / "include").rglob("training")), "the module training is installed"

        # The frames are rendered from the source tree, which has the body; the poses come from what was installed.
        frames = scratch / "frames.h5"
        run(prefix / "bin/knuckle", "render", "--manifest", PROJECT / "manifests/demo.toml", "--count", "3", "--out", frames,
            env={**os.environ, "KNUCKLE_HOME": str(PROJECT)})
        with h5py.File(frames) as file:
            depth = file["depth"][:].astype("float32") * numpy.float32(file.attrs.get("depth_unit_mm", 1.0))

        check_depth_array(build_example("depth_array", prefix, scratch), prefix, depth, frames, scratch)
        check_own_method(build_example("own_method", prefix, scratch), depth, scratch)


main(pathlib.Path(sys.argv[1]))
