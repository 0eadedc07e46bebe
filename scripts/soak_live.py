# SPDX-License-Identifier: Apache-2.0
"""The parts of scripts/soak.py that follow hands live: one server that runs on, and one that records and is killed and begun again. Clients
come and go at both: some read, some slowly, some nothing, some leave in the middle of a request."""
import json
import random
import re
import shutil
import signal
import socket
import threading
import time
import urllib.parse

from soak_place import LONGEST_S, Started

RATE = 20
SMALLEST_FRAME = 1000  # bytes of a recording that has one


class Reader(threading.Thread):
    """Takes records as lines, as they come."""

    def __init__(self, address, bytes_per_second=None):
        super().__init__(daemon=True)
        parts = urllib.parse.urlsplit(address)
        self.socket = socket.create_connection((parts.hostname, parts.port), timeout=LONGEST_S)
        self.socket.sendall(f"GET /api/records.jsonl HTTP/1.0\r\nHost: {parts.netloc}\r\n\r\n".encode())
        self.bytes_per_second = bytes_per_second
        self.lines, self.rest, self.longest_pause = [], b"", 0.0
        self.keeps = 1 << 30
        self.start()

    def run(self):
        last = time.monotonic()
        try:
            while data := self.socket.recv(1 << 10 if self.bytes_per_second else 1 << 16):
                self.longest_pause = max(self.longest_pause, time.monotonic() - last)
                last = time.monotonic()
                *lines, self.rest = (self.rest + data).split(b"\n")
                self.lines = (self.lines + [line for line in lines if line.startswith(b"{")])[-self.keeps:]
                if self.bytes_per_second:
                    time.sleep(len(data) / self.bytes_per_second)
        except OSError:
            pass

    def close(self):
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.socket.close()


class Guests(threading.Thread):
    """Clients that come and go."""

    def __init__(self, place, who, address):
        super().__init__(daemon=True)
        self.place, self.who, self.address = place, who, address
        self.chance = random.Random(f"{place.seed} {who} guests")
        self.staying = []
        self.is_over = threading.Event()
        self.start()

    def run(self):
        while not self.is_over.wait(self.chance.uniform(0.1, 1.5)):
            try:
                self.come()
            except OSError:
                continue  # the server was killed: its own part says whether it may have ended
            self.place.log.count(self.who, "clients")
            while len(self.staying) > 5:
                self.staying.pop(self.chance.randrange(len(self.staying))).close()
        for one in self.staying:
            one.close()

    def come(self):
        kind = self.chance.choice(("quick", "slow", "silent", "frames", "rude"))
        if kind == "quick":
            self.staying.append(Reader(self.address))
        elif kind == "slow":
            self.staying.append(Reader(self.address, bytes_per_second=2000))
        else:
            self.staying.append(self.silent({"silent": "/api/records.jsonl", "frames": "/api/frames", "rude": None}[kind]))

    def silent(self, path):
        """One that asks, or half asks, and reads nothing."""
        parts = urllib.parse.urlsplit(self.address)
        one = socket.create_connection((parts.hostname, parts.port), timeout=LONGEST_S)
        upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: c29hayBvZiBhbGwgb2Y=\r\n"
        request = f"GET {path} HTTP/1.1\r\nHost: {parts.netloc}\r\n{upgrade if path == '/api/frames' else ''}\r\n"
        one.sendall(request.encode() if path else b"GET /api/frames HTTP/1.1\r\nUpgr")
        return one

    def leave(self):
        self.is_over.set()
        self.join()


class LiveOn:
    """A server that runs on through all of it."""

    who = "live-on"

    def __init__(self, place, source):
        self.place, self.source = place, source

    def begin(self):
        pass

    def run(self):
        run = Started(self.place, self.who, ["live", "--source", f"h5:{self.source}?rate={RATE}&loop=1", "--view", "0", "--threads", "1"])
        address = run.wait_for_line(r"view: (http://\S+/)\n")
        if not address:
            self.place.log.broken(self.who, f"does not serve: {run.said()}")
            return
        reader = Reader(address)
        reader.keeps = 2000
        guests = Guests(self.place, self.who, address)
        while not self.place.calm.wait(5.0):
            self.check(run, reader)
        guests.leave()
        run.kill(signal.SIGINT)
        if run.end(LONGEST_S):
            self.place.log.say(self.who, run.out.strip())
        self.place.log.count(self.who, "rounds")
        self.place.log.say(self.who, f"the longest pause between two records was {reader.longest_pause:.1f} s")

    def check(self, run, reader):
        if run.process.poll() is not None:
            self.place.log.broken(self.who, f"ended with status {run.process.returncode}: {run.said()}")
            self.place.calm.wait()
        frames = [json.loads(line)["frame"] for line in reader.lines]
        if frames != sorted(set(frames)):
            self.place.log.broken(self.who, "records come twice, or not in the order of their frames")
        if reader.longest_pause > LONGEST_S / 10 or not reader.is_alive():
            self.place.log.broken(self.who, f"a client that reads got nothing for {reader.longest_pause:.0f} s, or was let go")
            self.place.calm.wait()


class LiveRounds:
    """Plays a set to its end, with records and a recording on the small disk; or is killed, and the recording is finished."""

    who = "live"

    def __init__(self, place, source, frames):
        self.place, self.source, self.frames = place, source, frames
        self.chance = random.Random(f"{place.seed} {self.who}")
        self.whole = place.folder / "whole" / self.who

    def arguments(self, folder):
        return ["live", "--source", f"h5:{self.source}?rate={RATE}", "--record", folder / "take.h5", "--records", folder / "records.jsonl", "--view",
                "0", "--threads", "1"]

    def begin(self):
        self.whole.mkdir(parents=True)
        self.place.undisturbed(self.who, self.arguments(self.whole))

    def run(self):
        rounds = 0
        while not self.place.calm.is_set():
            rounds += 1
            folder = self.place.disk.folder / f"{self.who}-{rounds}"
            try:
                folder.mkdir()
            except OSError:
                time.sleep(0.5)
                continue
            self.play(folder, rounds)
            shutil.rmtree(folder)

    def play(self, folder, rounds):
        run = Started(self.place, self.who, self.arguments(folder))
        killer = self.killer_of(run)
        address = run.wait_for_line(r"view: (http://\S+/)\n")
        reader, guests = None, None
        try:
            reader = Reader(address) if address else None
            guests = Guests(self.place, self.who, address) if address else None
        except OSError:  # killed meanwhile
            pass
        is_done = run.end(LONGEST_S + self.frames / RATE)
        if guests:
            guests.leave()
        if reader:
            reader.join(10)
        if killer:
            killer.cancel()
        if run.sent:
            self.place.log.count(self.who, "kills")
        self.place.log.count(self.who, "rounds")
        if is_done:
            self.compare_whole(folder, rounds, run)
        else:
            self.finish(folder)
        self.compare_records(folder, rounds, reader, is_done)
        self.compare_recording(folder, rounds)

    def killer_of(self, run):
        if self.place.calm.is_set() or self.chance.random() < 0.4:
            return None
        which = signal.SIGKILL if self.chance.random() < 0.7 else signal.SIGTERM
        killer = threading.Timer(self.chance.uniform(0.0, self.frames / RATE), run.kill, [which])
        killer.start()
        return killer

    def finish(self, folder):
        """What was stopped is made a set, where a frame was written."""
        rest = folder / "take.h5.partial"
        if rest.exists() and rest.stat().st_size > SMALLEST_FRAME:
            self.place.retried("record-finish", ["record", "--finish", folder / "take.h5", "--threads", "1"])

    def compare_whole(self, folder, rounds, run):
        """All frames that came are recorded."""
        came = re.search(r"(\d+) frames came, (\d+) passed over", run.out)
        self.place.log.count(self.who, "frames passed over", int(came[2]))
        if (folder / "take.h5").exists() and self.count_in(folder / "take.h5") != int(came[1]):
            self.broken(rounds, f"of {came[1]} frames {self.count_in(folder / 'take.h5')} were recorded")
        if not run.sent and int(came[1]) != self.frames:
            self.broken(rounds, f"{came[1]} frames came of {self.frames}")

    def count_in(self, file):
        said = self.place.retried("inspect", ["inspect", "--source", f"h5:{file}"])
        return int(re.search(r"frames +(\d+)", said)[1]) if said else -1

    def compare_recording(self, folder, rounds):
        """The bytes of a recording of as many frames that nobody disturbed."""
        if not (folder / "take.h5").exists():
            return
        self.place.log.count(self.who, "comparisons")
        count = self.count_in(folder / "take.h5")
        expected = self.whole / "take.h5"
        if count != self.frames:
            expected = self.place.folder / "expected.h5"
            expected.unlink(missing_ok=True)
            self.place.undisturbed("record", ["record", "--source", f"h5:{self.source}?count={count}&rate={RATE}", "--out", expected])
        if (folder / "take.h5").read_bytes() != expected.read_bytes():
            self.place.log.count(self.who, "differences")
            self.broken(rounds, f"a recording of {count} frames is another than undisturbed")
            shutil.copy(folder / "take.h5", self.place.folder / f"{self.who}-{rounds}-take.h5")

    def compare_records(self, folder, rounds, reader, is_done):
        """A client's lines are those of the file; and up to the first frame that was passed over they are those of the undisturbed run."""
        path = folder / "records.jsonl"
        if is_done and not path.exists():
            self.broken(rounds, "records.jsonl is lost")
        if not path.exists():
            path = folder / "records.jsonl.partial"
        lines = path.read_bytes().split(b"\n")[:-1] if path.exists() else []
        strangers = set(reader.lines if reader else []) - set(lines)
        if len(strangers) > (0 if is_done else 1):  # one may be on its way to the disk
            self.broken(rounds, f"a client got {len(strangers)} records that are not in the file")
        whole = [self.timeless(line) for line in (self.whole / "records.jsonl").read_bytes().splitlines()]
        alike = 0
        for number, (line, expected) in enumerate(zip(lines, whole, strict=False)):
            ours = self.timeless(line)
            if ours["frame"] != number or expected["frame"] != number:
                break
            if ours != expected:
                self.place.log.count(self.who, "differences")
                self.broken(rounds, f"the record of frame {number} is another than undisturbed")
                break
            alike += 1
        self.place.log.count(self.who, "records compared", alike)

    @staticmethod
    def timeless(line):
        record = json.loads(line)
        record.pop("latency_ms")
        return record

    def broken(self, rounds, what):
        self.place.log.broken(self.who, f"round {rounds}: {what}")
