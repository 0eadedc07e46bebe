# SPDX-License-Identifier: Apache-2.0
"""Makes a wheel of a checkout, for pip (PEP 517), with CMake and the standard library alone.

The extension is built in build/release, or in the folder that `--config-settings build-folder=FOLDER` names; a folder that
is configured already keeps its options. The wheel holds the extension, both shared libraries, the program for cameras,
pipelines, models, landmark definitions, manifests, and the body where set-up has fetched it; what these libraries link stays
Debian's, so it is for machines that have them.
"""

import base64
import hashlib
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import zipfile

PROJECT = pathlib.Path(__file__).resolve().parents[1]
SETTINGS = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTENSION = f"_knuckle{sysconfig.get_config_var('EXT_SUFFIX')}"
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the same files make the same wheel


def version():
    text = (PROJECT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"^project\(knuckle VERSION ([\d.]+)", text, re.MULTILINE)[1]


def tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def run(*command):
    subprocess.run([str(part) for part in command], cwd=PROJECT, check=True)


def configure(folder):
    # Within a virtual environment: the Python that outlives it.
    python = getattr(sys, "_base_executable", None) or sys.executable
    run("cmake", "--preset", "program", "-B", folder, f"-DKNUCKLE_PYTHON_PROGRAM={python}", "--log-level=STATUS")


def stage(folder, staged):
    """Builds what a wheel holds, and puts it into the folder `staged`."""
    if not (folder / "CMakeCache.txt").exists():
        configure(folder)
    run("cmake", "--build", folder, "--target", "knuckle_python")
    run("cmake", "--install", folder, "--component", "python", "--prefix", staged)
    if not (staged / "knuckle" / EXTENSION).exists():
        raise SystemExit(f"{folder}: is not configured for this Python ({EXTENSION} is not what it builds); name another "
                         "folder: --config-settings build-folder=FOLDER")


def metadata():
    lines = ["Metadata-Version: 2.1", f"Name: {SETTINGS['name']}", f"Version: {version()}",
             f"Summary: {SETTINGS['description']}", f"License: {SETTINGS['license']['text']}",
             f"Requires-Python: {SETTINGS['requires-python']}", *(f"Requires-Dist: {name}" for name in SETTINGS["dependencies"]),
             "Description-Content-Type: text/markdown", "", (PROJECT / SETTINGS["readme"]).read_text(encoding="utf-8")]
    return "\n".join(lines)


def information_files():
    """What tells of the wheel, in its folder `.dist-info`: names and contents."""
    description = f"Wheel-Version: 1.0\nGenerator: knuckle\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {"METADATA": metadata().encode(), "WHEEL": description.encode(), "LICENSE": (PROJECT / "LICENSE").read_bytes()}


def information_folder():
    return f"{SETTINGS['name']}-{version()}.dist-info"


def is_packed(path):
    """A library has one name in a wheel, its SONAME: libknuckle.so.0.2, not the longer one that this is a link to."""
    return path.is_file() and not re.search(r"\.so\.\d+\.\d+\.\d+$", path.name)


def pack(staged, wheel):
    record = []

    def add(name, content, mode=0o644):
        entry = zipfile.ZipInfo(name, LONG_AGO)
        entry.external_attr = (0o100000 | mode) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(entry, content)
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record.append(f"{name},sha256={digest},{len(content)}")

    with zipfile.ZipFile(wheel, "w") as archive:
        for path in sorted(filter(is_packed, staged.rglob("*"))):
            is_code = ".so" in path.name or path.parent.parent.name == "libexec"
            add(path.relative_to(staged).as_posix(), path.read_bytes(), 0o755 if is_code else 0o644)
        for name, content in information_files().items():
            add(f"{information_folder()}/{name}", content)
        own_name = f"{information_folder()}/RECORD"
        archive.writestr(zipfile.ZipInfo(own_name, LONG_AGO), "\n".join([*record, f"{own_name},,", ""]))


# ---- what pip calls ----


def get_requires_for_build_wheel(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    folder = pathlib.Path(metadata_directory) / information_folder()
    folder.mkdir()
    for name, content in information_files().items():
        (folder / name).write_bytes(content)
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    folder = PROJECT / (config_settings or {}).get("build-folder", "build/release")
    name = f"{SETTINGS['name']}-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as scratch:
        stage(folder, pathlib.Path(scratch))
        pack(pathlib.Path(scratch), pathlib.Path(wheel_directory) / name)
    return name


class UnsupportedOperation(Exception):
    """PEP 517's name for what a back end cannot do."""


def build_sdist(sdist_directory, config_settings=None):
    raise UnsupportedOperation("a checkout is the source distribution")
