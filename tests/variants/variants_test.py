# SPDX-License-Identifier: Apache-2.0
"""Runs the program with one variant of the shared libraries and compares what comes out with the baseline's: the
generator and the forests give the same bits, a network the same joints to a thousandth of a pixel.

usage: variants_test.py BUILD_FOLDER WAY

WAY is
  rounding             no code of the generator and the forests rounds as the processor can;
  loader               glibc takes the best variant that this processor can run;
  x86-64-v3|x86-64-v4  that variant, where this processor can run it;
  old_libm             the baseline, with the functions of glibc's libm for processors without AVX2 and FMA;
  nehalem              the baseline on an emulated processor of 2008, where qemu-x86_64 is installed.
"""

import os
import pathlib
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

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import knuckle_model_file  # noqa: E402

PROJECT = pathlib.Path(__file__).resolve().parents[2]
LOADER = "/lib64/ld-linux-x86-64.so.2"
NETWORK_TOLERANCE_PX = 0.001
FRAMES = 3
# All effects of the sensors come in these.
MANIFESTS = ("test_creative", "test_kinect_v2", "train_network")


def run(command, **environment):
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, cwd=PROJECT,
                            env={**os.environ, **environment})
    assert result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"
    return result.stdout


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def supported_levels():
    """Those of the loader's levels that this processor has, the best first."""
    return re.findall(r"(x86-64-v\d) \(supported", subprocess.run([LOADER, "--help"], capture_output=True, text=True,
                                                                 check=False).stdout)


class Variant:
    """The program with the libraries of one folder alone."""

    def __init__(self, build, libraries, before=(), **environment):
        self.program = build / "bin/knuckle"
        self.libraries = libraries
        self.before = before
        self.environment = {"LD_LIBRARY_PATH": str(libraries), **environment}
        loaded = run(["ldd", self.program], **self.environment)
        assert re.search(rf"libknuckle_runtime\S* => {re.escape(str(libraries))}/", loaded), loaded

    def knuckle(self, *arguments):
        return run([*self.before, self.program, *arguments], **self.environment)


def baseline_folder(build, scratch):
    """The libraries that run everywhere, in a folder without variants below it."""
    folder = scratch / "baseline"
    folder.mkdir()
    for library in (build / "lib").glob("libknuckle*.so*"):
        (folder / library.name).symlink_to(library.resolve())
    return folder


def arrays(path):
    """All data sets of an HDF5 file by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    assert found, path
    return found


def results(variant, frames, out, manifests):
    """What one variant makes: rendered frames, forests trained and asked, and a network's joints of `frames`."""
    out.mkdir()
    made = {}
    for name in manifests:
        path = out / f"{name}.h5"
        variant.knuckle("render", "--manifest", PROJECT / f"manifests/{name}.toml", "--count", FRAMES, "--out", path)
        made[f"rendered {name}"] = arrays(path)
    frames = frames or out / f"{manifests[0]}.h5"
    source = f"h5:{frames}"
    boxes = out / "boxes.csv"
    variant.knuckle("segment", "--source", source, "--pipeline", PROJECT / "pipelines/forest_segmentation.toml", "--out", boxes)
    # Without the last column, which is a time.
    made["segmentation forest"] = [line.rsplit(",", 1)[0] for line in boxes.read_text().splitlines()]
    for name, pipeline in (("pose forest", pose_forest_pipeline(out)), ("network", PROJECT / "pipelines/default.toml")):
        poses = out / "poses.txt"
        variant.knuckle("estimate", "--source", source, "--pipeline", pipeline, "--out", poses)
        made[name] = numpy.loadtxt(poses)
    made["trained forest"] = trained_forest(variant, source, out)
    return made


def pose_forest_pipeline(out):
    """The shipped one but for mean shift, which rounds as the processor does."""
    pipeline = out / "pose_forest.toml"
    pipeline.write_text('[segmentation]\nmethod = "threshold"\n[patch]\nsize_px = 96\n[estimator]\nmethod = "forest"\n'
                        f'model = "{PROJECT}/models/pose_forest.model"\n')
    return pipeline


def trained_forest(variant, source, out):
    config = out / "train.toml"
    config.write_text(f'source = "{source}"\n[pixels]\nshare = 1.0\n[forest]\ntrees = 1\nmax_depth = 8\n'
                      'splits_per_node = 200\noffsets_per_node = 64\nmemory_gb = 1.0\n')
    variant.knuckle("train", "segmentation-forest", "--config", config, "--out", out / "forest.model")
    return knuckle_model_file.read(out / "forest.model", "knuckle-forest", 2)[1]


def assert_alike(expected, found):
    """Every result to the bit, but the network's, whose loops round as the processor does."""
    assert expected.keys() == found.keys()
    for name, value in expected.items():
        if name == "network":
            error = numpy.nanmax(numpy.abs(value - found[name]).reshape(len(value), -1, 3)[:, :, :2])
            assert (numpy.isnan(value) == numpy.isnan(found[name])).all(), "the network finds other hands"
            print(f"network: joints differ by at most {error:.4f} px")
            assert error <= NETWORK_TOLERANCE_PX, f"the network's joints differ by {error} px"
        elif isinstance(value, dict):
            assert value.keys() == found[name].keys(), name
            for key, array in value.items():
                assert array.tobytes() == found[name][key].tobytes(), f"{name}: {key} differs"
        else:
            assert numpy.array_equal(value, found[name]), f"{name} differs: {value} against {found[name]}"
        print(f"{name}: alike")


def check_loader(build):
    chosen = next((level for level in supported_levels() if (build / "lib/glibc-hwcaps" / level).is_dir()), None)
    folder = build / "lib/glibc-hwcaps" / chosen if chosen else build / "lib"
    loaded = run(["ldd", build / "bin/knuckle"])
    for library in ("libknuckle", "libknuckle_runtime"):
        assert re.search(rf"{library}\.so\S* => {re.escape(str(folder))}/", loaded), f"{library} not of {folder}:\n{loaded}"


def check_rounding(build):
    """Neither multiplies and adds in one step, nor calls functions of libm that do where the processor can."""
    elementary = "sin cos sincos tan exp exp2 expm1 log log2 log10 log1p pow atan atan2 acos asin hypot cbrt fma".split()
    for module in ("core", "camera", "hand", "forest", "patch", "refine", "synth"):
        library = build / f"lib/libknuckle_{module}.a"
        fused = re.findall(r"\bvfn?m(?:add|sub)\w*", run(["objdump", "-d", "--no-show-raw-insn", library]))
        assert not fused, f"knuckle_{module} has {len(fused)} fused multiply-adds"
        called = set(re.findall(r"U (\w+)", run(["nm", "-u", library])))
        called &= {name + kind for name in elementary for kind in ("", "f")}
        assert not called, f"knuckle_{module} calls {called}: core/portable_math.h has functions that round alike everywhere"


def variant_of(way, build, baseline):
    """What `way` names, where it can run here."""
    if way == "old_libm":
        return Variant(build, baseline, GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable")
    if way == "nehalem":
        emulator = shutil.which("qemu-x86_64") or skip("qemu-x86_64 is not installed (the package qemu-user)")
        return Variant(build, baseline, before=(emulator, "-cpu", "Nehalem"))
    if way not in supported_levels():
        skip(f"this processor cannot run {way}")
    return Variant(build, build / "lib/glibc-hwcaps" / way)


def main(build, way):
    checks = {"rounding": check_rounding, "loader": check_loader}
    if way in checks:
        checks[way](build)
        return
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        baseline = baseline_folder(build, scratch)
        # An emulated processor is slow: one sensor does.
        manifests = MANIFESTS[:1] if way == "nehalem" else MANIFESTS
        other = variant_of(way, build, baseline)
        expected = results(Variant(build, baseline), None, scratch / "expected", manifests)
        frames = scratch / f"expected/{manifests[0]}.h5"
        assert_alike(expected, results(other, frames, scratch / "found", manifests))


main(pathlib.Path(sys.argv[1]).resolve(), sys.argv[2])
