# SPDX-License-Identifier: Apache-2.0
"""What the tests of the importers share: running scripts, the reference for skinning, random poses."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77  # CTest's SKIP_RETURN_CODE
HERE = pathlib.Path(__file__).resolve().parent
SCRIPTS = HERE.parents[1] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True

try:
    import h5py  # noqa: F401
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-numpy, python3-h5py)")
    sys.exit(SKIPPED)
import knuckle_body as kb  # noqa: E402


def require_blender():
    if shutil.which("blender") is None:
        print("skipped: Blender is not installed")
        sys.exit(SKIPPED)


def run_blender(script, *arguments, scene=None):
    """Runs a script in Blender without its window; returns the finished process with its output as text."""
    start = [str(scene)] if scene else ["--factory-startup"]
    command = [
        "blender",
        "--background",
        *start,
        "--python-exit-code",
        "3",
        "--python",
        str(script),
        "--",
        *map(str, arguments),
    ]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def run_python(script, *arguments):
    return subprocess.run(
        [sys.executable, str(script), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


class ImportTest(unittest.TestCase):
    """A test with an empty folder of its own."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="knuckle-import-")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)

    def assert_done(self, process):
        self.assertEqual(process.returncode, 0, process.stdout + process.stderr)

    def assert_fails(self, process, *parts, output=None):
        """Exit status 1, one line on standard error that has all `parts`, and no output file."""
        self.assertEqual(process.returncode, 1, process.stdout + process.stderr)
        lines = process.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, process.stderr)
        for part in parts:
            self.assertIn(str(part), lines[0])
        if output is not None:
            self.assertFalse(os.path.exists(output))

    def assert_invariants(self, body):
        """What holds of every body that an importer made."""
        np.testing.assert_allclose(body.weights.sum(axis=1, dtype=np.float64), 1, atol=1e-6)
        self.assertTrue(all(-1 <= parent < bone for bone, parent in enumerate(body.parents)))
        for group in [*body.joint_regressor, *body.landmark_regressor]:
            self.assertAlmostEqual(float(group.weights.sum(dtype=np.float64)), 1, delta=1e-5)


def hand_map(**changes):
    """The landmark map of blender_model.py's rig, as TOML, with changed lines (None leaves one out)."""
    points = {"wrist": "hand head"}
    for finger in kb.FINGERS:
        names = [name for name in kb.LANDMARKS if name.startswith(finger)]
        points |= {name: f"{finger}.{k + 1} head" for k, name in enumerate(names[:3])}
        points[names[3]] = f"{finger}.3 tail"
    lines = [f'{name} = "{value}"' for name, value in (points | changes).items() if value is not None]
    return "\n".join(["[landmarks]", *lines, "[bones]", '"lowerarm01.R" = "arm"', ""])


def random_rotations(random, count, largest=1.2):
    """count x 3 x 3 rotations about random axes by up to `largest` rad."""
    axes = random.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = random.uniform(-largest, largest, count)
    cross = np.zeros((count, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[:, k, j], cross[:, j, k] = axes[:, i], -axes[:, i]
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + sine * cross + (1 - cosine) * cross @ cross


def shaped(body, coefficients):
    """V x 3: the template and its shape directions."""
    vertices = body.v_template.astype(np.float64)
    for direction, coefficient in zip(body.shapedirs, coefficients, strict=True):
        vertices[direction.vertices] += coefficient * direction.offsets_mm.astype(np.float64)
    return vertices


def bone_transforms(body, heads, rotations):
    """B x 4 x 4: each bone turns about its own head, relative to its parent."""
    transforms = np.tile(np.eye(4), (len(heads), 1, 1))
    for bone, (head, rotation) in enumerate(zip(heads, rotations)):
        transforms[bone, :3, :3] = rotation
        transforms[bone, :3, 3] = head - rotation @ head
        if body.parents[bone] >= 0:
            transforms[bone] = transforms[body.parents[bone]] @ transforms[bone]
    return transforms


def skinned(body, vertices, transforms):
    """V x 3 by linear blend skinning."""
    blended = np.einsum("vk,vkij->vij", body.weights.astype(np.float64), transforms[body.weight_bones])
    return np.einsum("vij,vj->vi", blended[:, :3, :3], vertices) + blended[:, :3, 3]
