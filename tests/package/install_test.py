# SPDX-License-Identifier: Apache-2.0
"""Installs, moves what was installed to another place, and uses it there as a stranger would: runs the program, compiles every
header by itself, builds the examples, follows the links of the documents.

usage: install_test.py BUILD_FOLDER
"""

import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

PROJECT = pathlib.Path(__file__).resolve().parents[2]
# What a stranger's environment does not have.
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith("KNUCKLE_")}

# What a public header may include: public headers, Eigen, fmt, and the standard library.
ALLOWED_INCLUDES = re.compile(r"knuckle/|Eigen/|fmt/|[a-z_0-9]+$")
PRIVATE_MODULES = ("cli", "training", "experiment", "net", "forest", "storage")


def run(*command, **options):
    result = subprocess.run([str(part) for part in command], capture_output=True, check=False, env=ENVIRONMENT, **options)
    assert result.returncode == 0, f"{command}\n{result.stdout.decode()}\n{result.stderr.decode()}"
    return result.stdout


def numbers(text):
    return numpy.array([float(word) for word in text.split()])


def build_project(name, source, prefix, scratch, *options):
    """Configures and builds a project as a user would, without HDF5; returns its program."""
    folder = scratch / name
    launcher = shutil.which("ccache")
    run("cmake", "-S", source, "-B", folder, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON", *([f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"] if launcher else []), *options)
    run("cmake", "--build", folder, "--parallel", "2")
    return folder / pathlib.Path(source).name


def write_project(folder, sources, target, lines=()):
    """A project in C++ alone whose program has these sources (name: text)."""
    folder.mkdir()
    for name, text in sources.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "CMakeLists.txt").write_text("\n".join([
        "cmake_minimum_required(VERSION 3.25)", "project(x CXX)", *lines, "find_package(knuckle 0.2 REQUIRED)",
        f"add_executable({folder.name} {' '.join(sources)})", f"target_link_libraries({folder.name} PRIVATE {target})", ""]))
    return folder


# ---- what was installed ----


def installed_headers(prefix):
    return sorted(path.relative_to(prefix / "include") for path in (prefix / "include").rglob("*.h"))


def check_files(prefix):
    for path in prefix.rglob("*"):
        if path.is_file() and not path.is_symlink():
            assert str(PROJECT).encode() not in path.read_bytes(), f"{path} names the source tree"
    assert not list(prefix.rglob("*testing*")), "test files are installed"
    assert not list(prefix.rglob("*.a")), "static libraries are installed"
    for library in prefix.rglob("libknuckle*.so"):
        # It starts /proc/self/exe, which in a user's program is the user's.
        assert b"run_own_program" not in library.read_bytes(), f"{library} holds the module experiment"
    for training in ("knuckle-train-forest", "knuckle-train-network"):
        assert (prefix / "bin" / training).exists(), f"{training} is not installed"
    assert (prefix / "libexec/knuckle/knuckle-camera").exists()
    # Only the program that reads cameras needs their libraries.
    for library in (b"libfreenect", b"libOpenNI2"):
        assert library not in run("ldd", prefix / "bin/knuckle"), f"knuckle loads {library}"
    assert b"cannot be found" not in run(prefix / "bin/knuckle", "cameras"), "knuckle-camera is not where knuckle looks"
    # Only the program that trains networks needs LibTorch, nothing that a user of the library links.
    assert b"libtorch" not in run("ldd", prefix / "bin/knuckle"), "knuckle loads LibTorch"


def check_header_texts(prefix):
    headers = installed_headers(prefix)
    assert len(headers) > 30
    for header in headers:
        assert header.parts[1] not in PRIVATE_MODULES, f"{header} is of a private module"
        text = (prefix / "include" / header).read_text(encoding="utf-8")
        for name in re.findall(r"^ *#include [<\"]([^>\"]+)[>\"]", text, re.MULTILINE):
            assert ALLOWED_INCLUDES.match(name), f"{header} includes {name}"
        # Their memory comes from where -march says: what one side allocates the other could not free.
        assert not re.search(r"\b(Array|Matrix|Vector)X|Eigen::Dynamic", text), f"{header}: a dynamic matrix of Eigen"


def check_headers_compile(prefix, scratch):
    """Each by itself, as the package says to compile."""
    sources = {f"header_{i}.cpp": f"#include <{header}>\n" for i, header in enumerate(installed_headers(prefix))}
    sources["main.cpp"] = "int main() {}\n"
    build_project("headers_build", write_project(scratch / "headers", sources, "knuckle::knuckle"), prefix, scratch)


def layouts(prefix, scratch, arch):
    """Size and alignment of each class of the headers, as the compiler dumps them."""
    source = scratch / "layouts.cpp"
    source.write_text("".join(f"#include <{header}>\n" for header in installed_headers(prefix)), encoding="utf-8")
    flags = run("pkg-config", "--cflags", "eigen3", "fmt").decode().split()
    folder = scratch / f"layouts_{arch}"
    folder.mkdir()
    run("g++", "-std=c++20", f"-march={arch}", f"-I{prefix}/include", *flags, "-fdump-lang-class", "-c", source, "-o", "layouts.o",
        cwd=folder)
    dump = next(folder.glob("*.class")).read_text(encoding="utf-8")
    return dict(re.findall(r"^Class (knuckle::[^\n]+)\n +(size=\d+ align=\d+)", dump, re.MULTILINE))


def check_layouts(prefix, scratch):
    """A program that is compiled for another processor than the library means the same by each class."""
    if platform.machine() != "x86_64":
        return
    old, new = (layouts(prefix, scratch, arch) for arch in ("x86-64", "x86-64-v4"))
    assert len(old) > 50
    differing = {name: (old[name], new.get(name)) for name in old if old[name] != new.get(name)}
    assert not differing, differing


def check_links(prefix):
    documents = sorted((prefix / "share/doc").rglob("*.md"))
    assert len(documents) > 10
    count = 0
    for document in documents:
        prose = re.sub(r"^```.*?^```", "", document.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)\s#]+)", prose):
            if re.match(r"[a-z]+:", target):
                continue
            count += 1
            file = (document.parent / target).resolve()
            assert file.exists() and file.is_relative_to(prefix), f"{document}: {target} leads nowhere"
    assert count > 50, count


# ---- the program ----


def check_demo(prefix, scratch):
    """The body of the demo is installed too."""
    output = run(prefix / "bin/knuckle", "demo", "--out", scratch / "demo", cwd=scratch).decode()
    assert (scratch / "demo/report.html").exists(), output
    error = float(re.search(r"mean 3D error ([\d.]+) mm", output)[1])
    assert error < 25, output


def check_missing_data(prefix):
    """Without its files the program says where it looked."""
    with tempfile.TemporaryDirectory() as scratch:
        alone = pathlib.Path(scratch)
        for name in ("bin", "lib"):
            shutil.copytree(prefix / name, alone / name, symlinks=True)
        command = [alone / "bin/knuckle", "estimate", "--source", "h5:none.h5", "--out", alone / "none.txt"]
        result = subprocess.run(command, capture_output=True, check=False, env=ENVIRONMENT)
        message = result.stderr.decode()
        assert result.returncode == 1 and message.startswith("knuckle: ") and message.count("\n") == 1, message
        assert str(alone) in message and "KNUCKLE_HOME" in message and "set_data_folder" in message, message


# ---- programs of others ----


def check_depth_array(program, prefix, depth, frames, scratch):
    """Finds the same joints as `knuckle estimate` does."""
    poses = scratch / "poses.txt"
    run(prefix / "bin/knuckle", "estimate", "--source", f"h5:{frames}?count=1", "--out", poses)
    expected = numbers(poses.read_text().splitlines()[1])
    found = numbers(run(program, input=depth[0].tobytes()).decode())
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


def check_follow_hand(program, frames):
    """One hand with one id, whose fingers bend by what fingers can."""
    lines = [line.split() for line in run(program, f"h5:{frames}").decode().splitlines()]
    assert [line[:3] for line in lines] == [[str(number), "1", "right"] for number in range(3)], lines
    bent_deg = numpy.array([[float(number) for number in line[3:]] for line in lines])
    assert bent_deg.shape == (3, 5) and (bent_deg > -60).all() and (bent_deg < 300).all(), bent_deg
    assert numpy.abs(numpy.diff(bent_deg, axis=0)).max() < 60, bent_deg


OWN_DATA = """
#include <cstdio>
#include <knuckle/core/resources.h>
#include <knuckle/prepare/open_source.h>

/// own_data FOLDER: with the data folder FOLDER, the measured pixels of the demo's first frame.
int main(int, char** arguments) try {
  knuckle::set_data_folder(arguments[1]);
  const auto source = knuckle::open_source("synthetic:" + knuckle::resource_path("manifests/demo.toml").string());
  int measured = 0;
  for (const float depth_mm : source->read(0).depth_mm.pixels()) measured += depth_mm > 0;
  std::printf("%d\\n", measured);
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\\n", error.what()), 1;
}
"""


def check_own_data(prefix, scratch):
    """A program that brings Knuckle's files itself."""
    program = build_project("own_data_build", write_project(scratch / "own_data", {"main.cpp": OWN_DATA}, "knuckle::knuckle"), prefix, scratch)
    shutil.copytree(prefix / "share/knuckle", scratch / "brought")
    assert int(run(program, scratch / "brought")) > 1000
    result = subprocess.run([program, scratch / "nowhere"], capture_output=True, check=False, env=ENVIRONMENT)
    assert result.returncode == 1 and b"nowhere: set_data_folder() expects" in result.stderr, result.stderr


def check_standard(prefix, scratch):
    """Another standard than C++20 is refused in words."""
    project = write_project(scratch / "old_standard", {"main.cpp": "int main() {}\n"}, "knuckle::knuckle",
                            ["set(CMAKE_CXX_STANDARD 17)"])
    command = ["cmake", "-S", project, "-B", scratch / "old_standard_build", f"-DCMAKE_PREFIX_PATH={prefix}"]
    result = subprocess.run(command, capture_output=True, check=False, env=ENVIRONMENT)
    message = " ".join(result.stderr.decode().split())
    assert result.returncode != 0 and "need C++20, and CMAKE_CXX_STANDARD is 17" in message, message


def main(build):
    # At the same place each time, for ccache.
    scratch = build / "package_test"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    run("cmake", "--install", build, "--prefix", scratch / "installed")
    prefix = (scratch / "installed").rename(scratch / "moved")

    check_files(prefix)
    check_header_texts(prefix)
    check_links(prefix)
    check_demo(prefix, scratch)
    check_missing_data(prefix)
    check_headers_compile(prefix, scratch)
    check_layouts(prefix, scratch)
    check_standard(prefix, scratch)
    check_own_data(prefix, scratch)

    frames = scratch / "frames.h5"
    run(prefix / "bin/knuckle", "render", "--manifest", prefix / "share/knuckle/manifests/demo.toml", "--count", "3", "--out", frames)
    with h5py.File(frames) as file:
        depth = file["depth"][:].astype("float32") * numpy.float32(file.attrs.get("depth_unit_mm", 1.0))
    examples = prefix / "share/doc/knuckle/examples"
    for arch in ("", "-march=native"):
        options = [f"-DCMAKE_CXX_FLAGS={arch}"]
        check_depth_array(build_project(f"depth_array{arch}", examples / "depth_array", prefix, scratch, *options), prefix, depth, frames,
                          scratch)
        check_follow_hand(build_project(f"follow_hand{arch}", examples / "follow_hand", prefix, scratch, *options), frames)
        check_own_method(build_project(f"own_method{arch}", examples / "own_method", prefix, scratch, *options), depth, scratch)
    shutil.rmtree(scratch)


main(pathlib.Path(sys.argv[1]).resolve())
