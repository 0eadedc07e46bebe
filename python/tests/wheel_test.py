# SPDX-License-Identifier: Apache-2.0
"""What `pip install` makes of this build: a wheel that is whole, names no folder of the machine, and works where it is unpacked."""

import base64
import csv
import hashlib
import importlib.util
import io
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

from testing import PROJECT, demo_frames

sys.path.insert(0, str(PROJECT / "python"))
import build_backend  # noqa: E402

USE = """
import knuckle
frame = knuckle.render(knuckle.data_file("manifests/demo.toml"), 0)
hand, = knuckle.Pipeline.default().estimate(frame.depth_mm, frame.camera).hands
print(knuckle.__file__, knuckle.data_file("models"), knuckle.__version__, sep="\\n")
print(*{line.split()[-1] for line in open("/proc/self/maps") if "libknuckle" in line}, sep="\\n")
"""


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        demo_frames()  # a wheel without a body could not render either
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        name = build_backend.build_wheel(cls.folder, {"build-folder": os.environ["KNUCKLE_BUILD"]})
        cls.archive = zipfile.ZipFile(cls.folder / name)
        cls.addClassCleanup(cls.archive.close)

    def test_its_record_is_of_all_its_files(self):
        information = build_backend.information_folder()
        rows = list(csv.reader(io.StringIO(self.archive.read(f"{information}/RECORD").decode())))
        self.assertEqual([row[0] for row in rows], self.archive.namelist())
        for name, digest, size in rows[:-1]:
            content = self.archive.read(name)
            expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            self.assertEqual((digest, size), (f"sha256={expected}", str(len(content))), name)
        self.assertIn(f"\nVersion: {build_backend.version()}\n", self.archive.read(f"{information}/METADATA").decode())

    def test_it_names_no_folder_of_this_machine(self):
        for name in self.archive.namelist():
            self.assertNotIn(str(PROJECT).encode(), self.archive.read(name), name)

    def test_the_same_build_makes_the_same_wheel(self):
        again = self.folder / "again"
        again.mkdir()
        name = build_backend.build_wheel(again, {"build-folder": os.environ["KNUCKLE_BUILD"]})
        self.assertEqual((again / name).read_bytes(), (self.folder / name).read_bytes())

    def test_it_works_where_it_is_unpacked(self):
        place = (self.folder / "unpacked").resolve()
        self.archive.extractall(place)
        # What a stranger's environment does not have.
        environment = {name: value for name, value in os.environ.items() if not name.startswith("KNUCKLE_")}
        result = subprocess.run([sys.executable, "-c", USE], cwd=self.folder, env={**environment, "PYTHONPATH": str(place)},
                                check=True, capture_output=True, text=True)
        file, models, version, *libraries = result.stdout.splitlines()
        for path in (file, models, *libraries):
            self.assertTrue(path.startswith(f"{place}/knuckle/"), path)
        self.assertEqual(len(libraries), 2)
        self.assertEqual(version, build_backend.version())

    def test_pip_installs_it_into_a_fresh_environment(self):
        """As docs/python.md says; offline."""
        for module in ("venv", "ensurepip"):
            if importlib.util.find_spec(module) is None:
                self.skipTest(f"{module} is missing")
        place = (self.folder / "environment").resolve()
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("KNUCKLE_", "PYTHONPATH", "PIP_"))}

        def run(*command):
            ran = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, check=False)
            self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
            return ran.stdout.splitlines()

        run(sys.executable, "-m", "venv", "--system-site-packages", place)
        run(place / "bin/pip", "install", "--no-index", "--no-cache-dir", "--config-settings", f"build-folder={os.environ['KNUCKLE_BUILD']}",
            PROJECT)
        file, models, version, *libraries = run(place / "bin/python", "-c", USE)
        for path in (file, models, *libraries):
            self.assertTrue(path.startswith(f"{place}/lib/"), path)
        self.assertEqual(version, build_backend.version())

    def test_it_can_ask_for_cameras(self):
        place = self.folder / "with_cameras"
        for entry in self.archive.infolist():  # as pip unpacks: what may be run stays so
            path = pathlib.Path(self.archive.extract(entry, place))
            path.chmod(entry.external_attr >> 16 & 0o777)
        ask = "import knuckle; next(iter(knuckle.open_stream('openni2:no such device')))"
        result = subprocess.run([sys.executable, "-c", ask], cwd=self.folder, env={**os.environ, "PYTHONPATH": str(place)},
                                capture_output=True, text=True)
        self.assertIn("openni2", result.stderr.splitlines()[-1].lower())
        self.assertNotIn("cannot be found: there is no", result.stderr)

    def test_a_build_for_another_python_is_refused(self):
        with tempfile.TemporaryDirectory() as staged, self.assertRaisesRegex(SystemExit, "build-folder"):
            extension, build_backend.EXTENSION = build_backend.EXTENSION, "_knuckle.cpython-27.so"
            try:
                build_backend.stage(pathlib.Path(os.environ["KNUCKLE_BUILD"]), pathlib.Path(staged))
            finally:
                build_backend.EXTENSION = extension


if __name__ == "__main__":
    unittest.main()
