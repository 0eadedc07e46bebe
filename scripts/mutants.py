#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes small changes of behaviour, one at a time, and prints which of them no test notices.

The changes are listed in scripts/mutants/*.toml, one table [[change]] each:

    file   the source file
    old    text that occurs in it exactly once
    new    what takes its place
    tests  optional: modules whose test programs should notice; unless given, those of the file's folder

--guards takes instead every guard of the library: each condition behind which an error is raised.

Everything happens in a copy of the working tree (uncommitted changes included) with a build folder of its own. Only the
test programs that a change names are built and run, until the first test that fails, quick tests first. Changes that only
take a condition away (`if (false && (...))`) are compiled in together, and an environment variable says which of them
holds; the others are compiled one at a time. A change that does not compile, and one whose old text is gone, are faults of
the list. Exit status: 0 where all were noticed, 1 where not, 2 for a wrong list.
"""
import argparse
import collections
import contextlib
import dataclasses
import itertools
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib

from mutant_guards import all_guards, tests_of

ROOT = pathlib.Path(__file__).resolve().parent.parent
LISTS = ROOT / "scripts" / "mutants"
NEVER = "false && ("  # of a change that takes a condition away
SWITCH_NAME = "KNUCKLE_MUTANT"
SWITCH_FILE = "mutants.h"
SWITCH = """#pragma once
#include <cstdlib>
namespace mutants {
inline bool stays(int guard) {
  static const char* const gone = std::getenv("SWITCH_NAME");
  static const int number = gone == nullptr ? -1 : std::atoi(gone);
  return guard != number;
}
}  // namespace mutants
""".replace("SWITCH_NAME", SWITCH_NAME)
SLOW_S = 0.2  # a test that takes longer runs after the quick ones


@dataclasses.dataclass
class Change:
    name: str  # LIST:NUMBER
    file: str
    old: str
    new: str
    tests: list

    def fault(self):
        path = ROOT / self.file
        if not path.is_file():
            return f"{self.file} does not exist"
        count = path.read_text().count(self.old)
        if count != 1:
            return f"the old text occurs {count} times in {self.file}, expected once: {self.old!r}"
        return "old and new text are the same" if self.old == self.new else ""

    def takes_condition_away(self):
        return NEVER in self.new and bare(self.new.replace(NEVER, "", 1)) == bare(self.old)


def bare(text):
    return re.sub(r"[\s()]", "", text)


def read_list(path):
    changes = []
    for number, row in enumerate(tomllib.loads(path.read_text())["change"], 1):
        unknown = set(row) - {"file", "old", "new", "tests"}
        if unknown:
            sys.exit(f"{path}: unknown key {sorted(unknown)}")
        tests = row.get("tests") or tests_of(row["file"])
        changes.append(Change(f"{path.stem}:{number}", row["file"], row["old"], row["new"], tests))
    return changes


class Workshop:
    """The copy of the tree, and its build folder."""

    def __init__(self, folder, jobs, options):
        self.source = folder
        self.build = folder / "build" / "release"  # where a compiler's cache expects it
        self.options = options
        self.jobs = jobs
        self.seconds = {}  # of each test program without a change
        self.slow = {}  # the names of its slow tests
        self.copy_tree()
        self.configure()

    def copy_tree(self):
        self.source.mkdir(parents=True, exist_ok=True)
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True,
                                capture_output=True, text=True).stdout.splitlines()
        wanted = {name for name in listed if (ROOT / name).is_file()}
        for top in {pathlib.PurePath(name).parts[0] for name in wanted}:
            for old in (self.source / top).rglob("*"):
                if old.is_file() and str(old.relative_to(self.source)) not in wanted:
                    old.unlink()
        for name in wanted:
            self.restore(name)
        bodies = self.source / "third_party"
        if (ROOT / "third_party").exists() and not bodies.exists():
            bodies.symlink_to((ROOT / "third_party").resolve())

    def restore(self, name):
        """The file as it is in the tree; left alone where it already is, so that nothing is compiled in vain."""
        target = self.source / name
        if target.is_file() and target.read_bytes() == (ROOT / name).read_bytes():
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target)  # with a new time: ninja goes by times

    def configure(self):
        if not (self.build / "build.ninja").is_file():
            subprocess.run(["cmake", "--preset", "release", "--log-level=WARNING", *self.options], cwd=self.source,
                           check=True, stdout=subprocess.DEVNULL)

    def compiles(self, modules):
        targets = [f"knuckle_{module}_test" for module in modules]
        done = subprocess.run(["ninja", "-C", self.build, "-j", str(self.jobs), *targets], capture_output=True, text=True)
        self.log = done.stdout
        return done.returncode == 0

    def program(self, module, longest_s, tests="*", guard=None, report=os.devnull):
        """The finished process of a module's tests of which the names fit; the guard of this number is gone."""
        data = os.environ.get("KNUCKLE_SHARED_DATA", str(ROOT.parent / "shared" / "data"))
        environment = {**os.environ, "KNUCKLE_SHARED_DATA": data, "GTEST_FILTER": tests, "GTEST_OUTPUT": f"json:{report}",
                       **({} if guard is None else {SWITCH_NAME: str(guard)})}
        command = [self.build / "bin" / f"knuckle_{module}_test", "--gtest_fail_fast", "--gtest_color=no"]
        return run_to_its_end(command, longest_s, self.source, environment)

    def failing_test(self, module, guard=None):
        """The first test that fails, quick ones first; "" where none does."""
        slow = ":".join(self.slow[module])
        for tests in [f"*-{slow}", slow] if slow else ["*"]:
            longest_s = 30 + 5 * self.seconds[module]
            try:
                done = self.program(module, longest_s, tests, guard)
            except subprocess.TimeoutExpired:
                return f"{module}: longer than {longest_s:.0f} s"
            if done.returncode != 0:
                return f"{module}/{name_of_failed(done)}"
        return ""

    def prepare(self, modules):
        """All tests must pass before the first change; which of them are slow is kept."""
        if not self.compiles(modules):
            sys.exit(f"the tree without a change does not compile:\n{self.log[-3000:]}")
        for module in modules:
            report = self.build / f"{module}_tests.json"
            start = time.monotonic()
            done = self.program(module, 1200, report=report)
            if done.returncode != 0:
                sys.exit(f"without a change {module}/{name_of_failed(done)} fails")
            self.seconds[module] = time.monotonic() - start
            suites = json.loads(report.read_text())["testsuites"]
            self.slow[module] = [f"{suite['name']}.{test['name']}" for suite in suites for test in suite["testsuite"]
                                 if float(test["time"].rstrip("s")) > SLOW_S]

    def put_switches(self, changes):
        """Compiles in changes that take a condition away, each behind its number; gives those that found a place."""
        (self.source / SWITCH_FILE).write_text(SWITCH)
        texts = {change.file: (ROOT / change.file).read_text() for change in changes}
        placed = {}
        for number, change in enumerate(changes):
            if texts[change.file].count(change.old) == 1:  # another one may have changed the same line
                switched = change.new.replace(NEVER, f"mutants::stays({number}) && (", 1)
                texts[change.file] = texts[change.file].replace(change.old, switched)
                placed[number] = change
        for file, text in texts.items():
            up = "../" * file.count("/")
            written = f'#include "{up}{SWITCH_FILE}"\n{text}'
            if (self.source / file).read_text() != written:
                (self.source / file).write_text(written)
        return placed

    def outcome(self, change, guard=None):
        """("noticed", by what) or ("UNNOTICED", ""), of what is compiled."""
        for module in change.tests:
            if failed := self.failing_test(module, guard):
                return "noticed", failed
        return "UNNOTICED", ""

    def outcomes_together(self, changes):
        if not changes:
            return
        placed = self.put_switches(changes)
        self.prepare(modules_of(changes))
        for number, change in placed.items():
            yield change, *self.outcome(change, number)
        for file in {change.file for change in changes}:
            self.restore(file)
        yield from self.outcomes_alone([change for change in changes if change not in placed.values()])

    def outcomes_alone(self, changes):
        if not changes:
            return
        self.prepare(modules_of(changes))
        for change in changes:
            path = self.source / change.file
            path.write_text(path.read_text().replace(change.old, change.new))
            if self.compiles(change.tests):
                yield change, *self.outcome(change)
            else:
                errors = [line for line in self.log.splitlines() if " error: " in line]
                yield change, "broken", f"does not compile: {errors[0] if errors else self.log[-300:]}"
            self.restore(change.file)


def run_to_its_end(command, longest_s, folder, environment):
    """The finished process. What it started and left behind, as a test that fails does, ends with it."""
    with tempfile.TemporaryFile() as output:  # a pipe would stay open as long as what was left behind
        process = subprocess.Popen(command, cwd=folder, stdout=output, stderr=subprocess.DEVNULL, env=environment,
                                   start_new_session=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        try:
            process.wait(longest_s)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        output.seek(0)
        return subprocess.CompletedProcess(command, process.returncode, output.read())


def name_of_failed(process):
    failed = re.search(r"\[  FAILED  \] (\S+?)(,| \()", process.stdout.decode(errors="replace"))
    return failed.group(1) if failed else f"status {process.returncode}"


def modules_of(changes):
    return sorted({module for change in changes for module in change.tests})


def guards():
    return [Change(f"guard:{number}", *guard) for number, guard in enumerate(all_guards(ROOT), 1)]


def chosen_changes(arguments):
    lists = arguments.lists or sorted(LISTS.glob("*.toml"))
    changes = guards() if arguments.guards else [change for path in lists for change in read_list(pathlib.Path(path))]
    if arguments.only:
        changes = [c for c in changes if re.search(arguments.only, f"{c.name} {c.file} {c.old} {c.new}")]
    part, parts = (int(number) for number in arguments.part.split("/"))
    return changes[part * len(changes) // parts:(part + 1) * len(changes) // parts]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lists", nargs="*", help="lists of changes; unless given, all of scripts/mutants")
    parser.add_argument("--guards", action="store_true", help="every condition behind which an error is raised")
    parser.add_argument("--only", help="a regular expression that name, file, old or new text must match")
    parser.add_argument("--part", default="0/1", help="I/N: the I-th (from 0) of N parts")
    parser.add_argument("--check", action="store_true", help="only say whether each change can still be made")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--cmake", action="append", default=[], help="an option for cmake, as in --cmake=-DX=ON")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build" / "mutants", help="for copy and build")
    arguments = parser.parse_args()

    changes = chosen_changes(arguments)
    faults = [f"{change.name}: {change.fault()}" for change in changes if change.fault()]
    print("\n".join(faults + [f"{len(changes)} changes, {len(faults)} of them cannot be made"]), flush=True)
    if arguments.check or faults:
        return 2 if faults else 0

    workshop = Workshop(arguments.folder, arguments.jobs, arguments.cmake)
    together = [change for change in changes if change.takes_condition_away()]
    alone = [change for change in changes if not change.takes_condition_away()]
    counts = collections.Counter({"noticed": 0, "UNNOTICED": 0, "broken": 0})
    for change, kind, text in itertools.chain(workshop.outcomes_together(together), workshop.outcomes_alone(alone)):
        counts[kind] += 1
        print(f"{kind:9} {change.name:14} {change.file}: {change.new.strip().splitlines()[:1]} {text}", flush=True)
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return 2 if counts["broken"] else 1 if counts["UNNOTICED"] else 0


if __name__ == "__main__":
    sys.exit(main())
