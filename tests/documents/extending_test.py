# SPDX-License-Identifier: Apache-2.0
"""docs/extending.md: its code is that of examples/own_method, and the changes that it makes to Knuckle work: they are applied
to a copy, built, and the program that comes out finds a hand with the new methods.

usage: extending_test.py BUILD_FOLDER        (package/install builds and runs the example itself)
"""
import array
import json
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

from documents import PROJECT, SKIPPED, blocks_of

PAGE = PROJECT / "docs/extending.md"
EXAMPLE = PROJECT / "examples/own_method"
# Where the page says that the example's files go.
PLACES = {"ball_segmenter.h": "segment", "pointing_estimator.h": "estimate", "raw_depth_source.h": "data"}
TIP = (150, 100, 400.0)  # column, row, depth of the point that the made-up finger shows


def check_code():
    sources = {path.name: path.read_text(encoding="utf-8") for path in EXAMPLE.iterdir()}
    quoted = set()
    for block in blocks_of(PAGE, "cpp"):
        found = [name for name, text in sources.items() if block.text in text]
        assert found, f"{block.place}: this code is not in examples/own_method"
        quoted.update(found)
    assert quoted == {*PLACES, "main.cpp"}, f"the page quotes {quoted}"


def apply_change(tree, block):
    """A block whose first line is ` // FILE`; ` ...` parts places of the file. Each place must be there exactly once."""
    first, *lines = block.text.rstrip("\n").split("\n")
    path = tree / first.removeprefix(" // ")
    text = path.read_text(encoding="utf-8")
    for place in "\n".join(lines).split("\n ...\n"):
        old = "\n".join(line[1:] for line in place.split("\n") if line[:1] != "+")
        new = "\n".join(line[1:] for line in place.split("\n") if line[:1] != "-")
        assert text.count(old) == 1, f"{block.place}: {first} has {text.count(old)} places like\n{old}"
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


def run(command, **options):
    result = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert result.returncode == 0, f"{command}\n{result.stdout}\n{result.stderr}"
    return result.stdout


def changed_tree(folder):
    """A copy of the sources with the example in it; and the files that the page changes."""
    tree = folder / "tree"
    shutil.copytree(PROJECT / "src", tree / "src")
    for name, module in PLACES.items():
        text = (EXAMPLE / name).read_text(encoding="utf-8")
        text = text.replace("namespace own {", "namespace knuckle {")
        (tree / "src/knuckle" / module / name).write_text(text, encoding="utf-8")
    return tree, [apply_change(tree, block) for block in blocks_of(PAGE, "diff")]


def includes(group, source):
    """Whether this is one of CMake's files that name the sources of a group, and this source is among them."""
    return group.name.startswith("unity_") and f'"{source}"' in group.read_text(encoding="utf-8")


def compiled(source, tree, build, folder):
    """The object of a changed file, or of the group that it is compiled in, as the project's build does, but without optimising."""
    original = str(PROJECT / source.relative_to(tree))
    commands = json.loads((build / "compile_commands.json").read_text(encoding="utf-8"))
    command = next(
        entry for entry in commands if entry["file"] == original or includes(pathlib.Path(entry["file"]), original)
    )
    words = shlex.split(command["command"].replace(str(PROJECT / "src"), str(tree / "src")))
    if command["file"] != original:
        source = folder / f"group_of_{source.name}"
        group = pathlib.Path(command["file"]).read_text(encoding="utf-8")
        source.write_text(group.replace(str(PROJECT / "src"), str(tree / "src")), encoding="utf-8")
        words[words.index(command["file"])] = str(source)
    target = folder / f"{source.stem}.o"
    words[words.index("-o") + 1] = str(target)
    run([*words, "-O0"], cwd=command["directory"])
    return str(target)


def link_command(target, build):
    """The words of the command that links a program."""
    last = run(["ninja", "-C", str(build), "-t", "commands", target]).strip().split("\n")[-1]
    words = shlex.split(last)
    words = words[words.index("&&") + 1:]
    return words[:words.index("&&")]


def linked(objects, build, folder):
    """The program, with these objects in place of the library's: linked with the static libraries, as the benchmarks are."""
    words = link_command("bin/knuckle", build)
    program = str(folder / "knuckle")
    words[words.index("-o") + 1] = program
    own = words[:next(i for i, word in enumerate(words) if "libknuckle" in word and ".so" in word)]
    libraries = link_command("bin/knuckle_bench", build)
    first_library = next(i for i, word in enumerate(libraries) if word.endswith(".a"))
    run([*own, *objects, *libraries[first_library:]], cwd=build)
    return program


def write_depth(path):
    """A plate 450 mm away with a thick finger that points at the camera, and the same seen from 50 mm farther."""
    depth = array.array("f", bytes(4 * 320 * 240 * 2))
    for frame, farther in enumerate((0.0, 50.0)):
        for row in range(90, 130):
            for column in range(130, 190):
                is_finger = abs(column - TIP[0]) < 10 and abs(row - TIP[1]) < 10
                depth[(frame * 240 + row) * 320 + column] = farther + (TIP[2] + 2 if is_finger else 450.0)
        depth[(frame * 240 + TIP[1]) * 320 + TIP[0]] = TIP[2] + farther
    path.write_bytes(depth.tobytes())


def check_program(program, folder):
    kinds = json.loads(run([program, "info", "--json"]))
    assert "ball" in kinds["segmenters"] and "pointing" in kinds["estimators"] and "raw" in kinds["sources"], kinds
    pipeline = next(block for block in blocks_of(PAGE, "toml"))
    (folder / "own.toml").write_text(pipeline.text, encoding="utf-8")
    write_depth(folder / "depth.f32")
    run([program, "estimate", "--source", "raw:depth.f32", "--pipeline", "own.toml", "--out", "poses.txt"], cwd=folder)
    name, *lines = (folder / "poses.txt").read_text(encoding="utf-8").splitlines()
    assert name == "# convention: pointing2", name
    for line, farther in zip(lines, (0.0, 50.0), strict=True):
        tip = [float(word) for word in line.split()][3:]
        error = max(abs(tip[0] - TIP[0]), abs(tip[1] - TIP[1]), abs(tip[2] - TIP[2] - farther))
        assert error < 2.0, f"the tip is found at {tip}"


def main(build):
    check_code()
    if not (build / "build.ninja").exists():
        print("skipped: the changes are built with Ninja, which this build folder does not use")
        return SKIPPED
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        tree, changed = changed_tree(folder)
        assert len(changed) == 3
        program = linked([compiled(source, tree, build, folder) for source in changed], build, folder)
        check_program(program, folder)
    return 0


sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
