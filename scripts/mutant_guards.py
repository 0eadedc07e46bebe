# SPDX-License-Identifier: Apache-2.0
"""Finds the guards of the sources: conditions of which the next statement is an error."""
import pathlib
import re

ERROR = re.compile(r"\s*\{?\s*(?:throw\b|(?:[\w.]+(?:\(\))?(?:\.|->))?(?:fail|damaged|fault|fail_at|too_new)\()")
OF_WHOLE_PROGRAMS = ("cli", "experiment", "workers")  # tested above all by whole programs
TESTS = {  # of folders whose test programs are not named like the module; the first that fits
    "data/readers": ["readers", "writers"],
    "data/writers": ["writers"],
    "data": ["data", "readers", "writers"],
    "storage/hdf5": ["hdf5", "readers"],
    "storage": ["storage", "forest"],
    "stream/process": ["camera_program"],
    "stream": ["stream", "camera_program"],
    "net/layers": ["layers", "net"],
    "net/onnx": ["onnx", "net"],
    "pipeline": ["pipeline", "track"],
}


def closing(text, opened):
    """The place behind the bracket that closes the one before `opened`."""
    depth = 1
    while depth:
        depth += {"(": 1, ")": -1}.get(text[opened], 0)
        opened += 1
    return opened


def unique(text, start, end):
    """text[start:end], made longer by what follows until it occurs once; empty where no line can tell it from others."""
    while text.count(text[start:end]) > 1:
        following = text.find("\n", end + 1)
        if following < 0 or following - start > 400:
            return ""
        end = following
    return text[start:end]


def guards_of(text):
    """(old, new) of each guard; new is never true. A condition that declares a name stays: what follows needs the name."""
    for match in re.finditer(r"\bif \(", text):
        end = closing(text, match.end())
        condition = text[match.end():end - 1]
        if re.match(r"(const )?auto\b|const ", condition) or ";" in condition or not ERROR.match(text[end:end + 80]):
            continue
        if old := unique(text, match.start(), end):
            yield old, old.replace(f"if ({condition})", f"if (false && ({condition}))", 1)


def tests_of(file):
    folder = str(pathlib.PurePath(file).relative_to("src/knuckle").parent)
    fitting = [tests for name, tests in TESTS.items() if f"{folder}/".startswith(f"{name}/")]
    return fitting[0] if fitting else [folder.split("/")[0]]


def all_guards(root):
    """(file, old, new, tests) of each guard of the library, in the order of the files."""
    for path in sorted((root / "src" / "knuckle").rglob("*")):
        file = str(path.relative_to(root))
        if path.suffix not in (".cpp", ".h") or "test" in path.stem or file.split("/")[2] in OF_WHOLE_PROGRAMS:
            continue
        for old, new in guards_of(path.read_text()):
            yield file, old, new, tests_of(file)
