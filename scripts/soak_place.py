# SPDX-License-Identifier: Apache-2.0
"""What all parts of scripts/soak.py share: the log, the small disk, memory of processes, and the rules of how a program may end."""
import collections
import os
import pathlib
import re
import signal
import statistics
import subprocess
import threading
import time

PROPER_LINE = r"knuckle: |warning: |view: |annotate: |step \d|[a-z -]+: \d+ of \d+ "  # errors, warnings, addresses, progress
LONGEST_S = 300.0  # that a program may take to end once it is asked to


class Log:
    """Lines with the time since the start, in a file and on standard output; and how often things happened."""

    def __init__(self, path):
        self.file = path.open("w")
        self.begin = time.monotonic()
        self.counts = collections.Counter()
        self.faults = []
        self.lock = threading.Lock()

    def say(self, who, text):
        with self.lock:
            line = f"{time.monotonic() - self.begin:8.1f} s  {who}: {text}"
            self.file.write(line + "\n")
            self.file.flush()
            print(line, flush=True)

    def count(self, who, what, times=1):
        with self.lock:
            self.counts[who, what] += times

    def broken(self, who, text):
        self.say(who, f"BROKEN RULE: {text}")
        self.faults.append(f"{who}: {text}")


class SmallDisk:
    """A tmpfs in a name space of our own, so that it goes with us however we end; and the ballast that fills it."""

    def __init__(self, folder, megabytes):
        self.folder = folder
        folder.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "soak", folder], capture_output=True, text=True, check=False)
        self.why_not = done.stderr.strip()
        self.times_full = []  # (begin, end); the last may still be full

    def is_mounted(self):
        return self.folder.is_mount()

    def free_bytes(self):
        state = os.statvfs(self.folder)
        return state.f_bavail * state.f_frsize

    def used_bytes(self):
        state = os.statvfs(self.folder)
        return (state.f_blocks - state.f_bfree) * state.f_frsize

    def fill(self, seconds, is_over):
        """Keeps the disk full, also where something gives room back meanwhile."""
        ballast = self.folder / "ballast"
        piece = bytes(1 << 16)
        end = time.monotonic() + seconds
        self.times_full.append((time.monotonic(), float("inf")))
        with ballast.open("wb", buffering=0) as file:
            while time.monotonic() < end and not is_over():
                try:
                    file.write(piece)
                except OSError:
                    time.sleep(0.02)
        ballast.unlink()
        self.times_full[-1] = (self.times_full[-1][0], time.monotonic())

    def was_full(self, begin, end):
        return any(begin <= last and first <= end for first, last in self.times_full)


class Memory(threading.Thread):
    """RssAnon [MB] and descriptors of the program of each part, about once a second."""

    def __init__(self):
        super().__init__(daemon=True)
        self.programs = {}
        self.samples = collections.defaultdict(list)  # who -> (time, MB, descriptors)

    def run(self):
        while True:
            for who, pid in list(self.programs.items()):
                try:
                    status = pathlib.Path(f"/proc/{pid}/status").read_text()
                    descriptors = len(os.listdir(f"/proc/{pid}/fd"))
                except OSError:
                    continue
                if found := re.search(r"RssAnon:\s+(\d+)", status):
                    self.samples[who].append((time.monotonic(), int(found[1]) / 1024, descriptors))
            time.sleep(1.0)

    def between(self, who, first, last):
        """Samples of a part of the time, 0 to 1, since the first one."""
        samples = self.samples[who]
        begin, length = samples[0][0], samples[-1][0] - samples[0][0]
        return [(mb, descriptors) for at, mb, descriptors in samples if begin + first * length <= at <= begin + last * length]

    def around(self, who, share):
        """Median [MB] of a tenth of the time, around a moment."""
        first = min(max(share - 0.05, 0.0), 0.9)
        return statistics.median(mb for mb, _ in self.between(who, first, first + 0.1) or [self.samples[who][-1][1:]])

    def peak(self, who, first, last):
        return max((mb for mb, _ in self.between(who, first, last)), default=0.0)


class Started:
    """A running program, and whether it ended as it may."""

    def __init__(self, place, who, arguments):
        self.place, self.who, self.arguments = place, who, [str(one) for one in arguments]
        self.begin = time.monotonic()
        self.sent = None  # the signal that we sent
        self.may_die = False  # of it: the program does not watch for it yet, or cannot
        self.errors = place.folder / "errors" / who
        self.errors.unlink(missing_ok=True)  # a worker of the program before, which was killed, may still write there
        with self.errors.open("w") as errors:
            self.process = subprocess.Popen([place.program, *self.arguments], cwd=place.project, env=place.environment, stdout=subprocess.PIPE,
                                            stderr=errors, text=True)
        place.memory.programs[who] = self.process.pid

    def said(self):
        return self.errors.read_text(errors="replace")

    def kill(self, which):
        """The first signal counts."""
        if self.process.poll() is None and not self.sent:
            self.sent = which
            self.may_die = not self.watches_for(which)
            self.process.send_signal(which)

    def watches_for(self, which):
        try:
            status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        except OSError:
            return False
        caught = re.search(r"SigCgt:\s+([0-9a-f]+)", status)
        return bool(caught and int(caught[1], 16) >> (which - 1) & 1)

    def wait_for_line(self, pattern):
        """What it says on standard error; nothing where it ends before."""
        end = time.monotonic() + LONGEST_S
        while time.monotonic() < end:
            has_ended = self.process.poll() is not None
            if found := re.search(pattern, self.said()):
                return found[1]
            if has_ended:
                break
            time.sleep(0.02)
        return None

    def end(self, seconds=None):
        """Waits for its end, kills it where it has none, and judges it. True: all was done."""
        try:
            self.out, _ = self.process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            self.broken("does not end")
            self.process.kill()
            self.out, _ = self.process.communicate()
            return False
        finally:
            self.place.memory.programs.pop(self.who, None)
        return self.judge(self.process.returncode)

    def broken(self, what):
        self.place.log.broken(self.who, f"`{' '.join(self.arguments)}` {what}; it said {self.said()[-600:]!r}")

    def judge(self, status):
        lines = self.said().splitlines()
        errors = [line for line in lines if line.startswith("knuckle: ")]
        foreign = [line for line in lines if not re.match(PROPER_LINE, line)]
        if foreign:
            self.broken(f"said what is neither an error nor a warning: {foreign[0]!r}")
        if status == 0:
            if errors:
                self.broken("ended with status 0 and an error")
            return True
        if self.sent and status == -self.sent:
            if not self.may_die:
                self.broken("did not end cleanly when it was asked to")
        elif status != 1:
            self.broken(f"ended with status {status}")
        elif len(errors) != 1:
            self.broken(f"ended with {len(errors)} lines of errors")
        elif self.sent == signal.SIGTERM and re.search("interrupted|nothing was recorded", errors[0]):
            self.place.log.count(self.who, "interrupted")
        elif self.place.disk.was_full(self.begin, time.monotonic()) and self.names_the_disk(errors[0]):
            self.place.log.count(self.who, "ended by the full disk")
        else:
            self.broken("failed")
        return False

    @staticmethod
    def names_the_disk(line):
        return re.search(r"No space|disk|cannot (be )?(writ|ma[dk]e|read back)", line)


class Place:
    """Where the soak runs, with what all its parts use."""

    def __init__(self, project, program, folder, disk_mb, seed, minutes):
        self.project, self.program, self.folder, self.seed, self.minutes = project, program, folder, seed, minutes
        (folder / "errors").mkdir()
        self.log = Log(folder / "soak.log")
        self.memory = Memory()
        self.disk = SmallDisk(folder / "disk", disk_mb)
        (folder / "tmp").mkdir()
        self.environment = {**os.environ, "TMPDIR": str(folder / "tmp")}
        self.calm = threading.Event()  # no more kills, no more ballast: what was begun is finished

    def kill_all(self):
        """What still runs where the soak itself is ended early."""
        for pid in self.memory.programs.values():
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass

    def undisturbed(self, who, arguments):
        """Runs a program to its end; nothing is supposed to go wrong. Its output."""
        run = Started(self, who, arguments)
        if not run.end(LONGEST_S):
            raise RuntimeError(f"{who}: {run.said()}")
        return run.out

    def retried(self, who, arguments):
        """Runs a program until it ends well: a full disk may hinder it for a while. None: it never does."""
        while True:
            run = Started(self, who, arguments)
            if run.end(LONGEST_S):
                return run.out
            if self.log.faults and self.log.faults[-1].startswith(f"{who}: "):
                return None
            time.sleep(1.0)
