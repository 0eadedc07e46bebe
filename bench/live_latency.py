#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plays a source to `knuckle live --view` with clients, and says how long frames took and what it cost.

Of the clients one reads nothing, the others read records as lines. With --page a Chromium shows the page as well, WebGL
drawn in software unless the machine has a graphics processor. With --come-and-go clients connect and leave all the time,
each of another kind: they read lines or nothing, or leave in the middle of a request. With --record all raw frames are
kept, and counted. Prints a JSON object; exits with 1 where a frame has no record, or was not recorded.

Times are worth something on an idle machine alone.
"""
import argparse
import json
import pathlib
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse

PROJECT = pathlib.Path(__file__).resolve().parent.parent
PAGE = PROJECT / "bench" / "live_page.mjs"


class Client:
    """One that reads, or one that does not."""

    def __init__(self, address, reads):
        parts = urllib.parse.urlsplit(address)
        self.socket = socket.create_connection((parts.hostname, parts.port), timeout=60)
        self.socket.sendall(f"GET /api/records.jsonl HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n".encode())
        self.lines = 0
        if reads:
            threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        try:
            while data := self.socket.recv(1 << 16):
                self.lines += data.count(b"\n{")
        except OSError:
            pass

    def close(self):
        self.socket.close()


class ComingAndGoing(threading.Thread):
    """Clients that stay for a moment."""

    def __init__(self, address, per_second):
        super().__init__(daemon=True)
        self.address, self.pause_s, self.count, self.ends = address, 1.0 / per_second, 0, False

    def run(self):
        chance = random.Random(1)
        staying = []
        while not self.ends:
            try:
                staying.append(Client(self.address, reads=chance.random() < 0.7))
                self.count += 1
                if chance.random() < 0.2:
                    rude = socket.create_connection(staying[-1].socket.getpeername(), timeout=10)
                    rude.sendall(b"GET /api/frames HTTP/1.1\r\nUpgrade")
                    rude.close()
            except OSError as error:
                print(f"a client could not connect: {error}", file=sys.stderr)
            while len(staying) > 3:
                staying.pop(chance.randrange(len(staying))).close()
            time.sleep(self.pause_s * (0.5 + chance.random()))
        for client in staying:
            client.close()


class Watch(threading.Thread):
    """Memory [MB] and descriptors of a process, each second."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.folder = pathlib.Path(f"/proc/{pid}")
        self.memory, self.descriptors = [], []

    def run(self):
        while True:
            try:
                status = (self.folder / "status").read_text()
                descriptors = len(list((self.folder / "fd").iterdir()))
            except OSError:
                return
            resident = [line for line in status.splitlines() if line.startswith("VmRSS:")]
            if resident:
                self.memory.append(int(resident[0].split()[1]) / 1024)
                self.descriptors.append(descriptors)
            time.sleep(1.0)


def percentile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def most_by_tenth(values):
    """Of the first, second, ... tenth of the run: whether it grows is seen at a glance."""
    return [round(max(values[len(values) * i // 10: len(values) * (i + 1) // 10], default=0), 1) for i in range(10)]


def settled(values):
    """Those after the first tenth, in which buffers are still taken."""
    return values[len(values) // 10:] or values


def run(arguments, folder):
    records = folder / "records.jsonl"
    command = [arguments.program, "live", "--source", arguments.source, "--records", records, "--view", "0"]
    for name in ("pipeline", "frames", "seconds"):
        if value := getattr(arguments, name):
            command += [f"--{name}", str(value)]
    if arguments.record:
        command += ["--record", arguments.record]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    log = []
    while not (log and log[-1].startswith("view: ")):
        line = program.stderr.readline()
        if not line:
            sys.exit("".join(log))
        log.append(line)
    address = log[-1].split()[1]
    watch = Watch(program.pid)
    watch.start()
    rest = threading.Thread(target=lambda: log.extend(program.stderr), daemon=True)
    rest.start()
    clients = [Client(address, reads=i > 0) for i in range(arguments.clients)]
    guests = ComingAndGoing(address, arguments.come_and_go) if arguments.come_and_go else None
    if guests:
        guests.start()
    page = None
    if arguments.page:
        page = subprocess.Popen(["node", PAGE, address], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    start = time.monotonic()
    log_of_end = program.stdout.read()
    program.wait()
    seconds = time.monotonic() - start
    if guests:
        guests.ends = True
    rest.join(10)
    log.append(log_of_end)
    shown = json.loads(page.communicate("")[0]) if page else None
    return program.returncode, [json.loads(line) for line in records.open()], watch, clients, guests, shown, seconds, log


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", help="a stream, as `knuckle live --source` takes it: 'h5:set.h5?rate=30'")
    parser.add_argument("--program", default=str(PROJECT / "build/release/bin/knuckle"))
    parser.add_argument("--pipeline", default="")
    parser.add_argument("--frames", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=0)
    parser.add_argument("--clients", type=int, default=4)
    parser.add_argument("--come-and-go", type=float, default=0, help="clients a second")
    parser.add_argument("--record", default="", help="keep all raw frames there")
    parser.add_argument("--page", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        status, records, watch, clients, guests, shown, seconds, log = run(arguments, pathlib.Path(folder))
    latency = [record["latency_ms"] for record in records]
    arrived = records[-1]["frame"] + 1 if records else 0
    result = {
        "status": status,
        "seconds": round(seconds, 1),
        "frames_arrived": arrived,
        "frames_without_record": arrived - len(records),
        "frames_with_a_hand": sum(bool(record["hands"]) for record in records),
        "latency_ms": {"median": round(statistics.median(latency), 2), "p95": round(percentile(latency, 0.95), 2),
                       "p99": round(percentile(latency, 0.99), 2), "most": round(max(latency), 2)},
        "memory_mb": {"first": round(settled(watch.memory)[0], 1), "last": round(watch.memory[-1], 1),
                      "least": round(min(settled(watch.memory)), 1), "most": round(max(settled(watch.memory)), 1),
                      "most_by_tenth": most_by_tenth(watch.memory)},
        "descriptors": {"least": min(settled(watch.descriptors)), "most": max(settled(watch.descriptors)),
                        "last": watch.descriptors[-1]},
        "lines_read": [client.lines for client in clients],
        "clients_that_came": guests.count if guests else 0,
        "page": shown,
        "said": [line.strip() for line in log[1:]],
    }
    print(json.dumps(result, indent=2))
    return 0 if status == 0 and arrived == len(records) else 1


if __name__ == "__main__":
    sys.exit(main())
