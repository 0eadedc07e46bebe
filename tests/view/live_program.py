# SPDX-License-Identifier: Apache-2.0
"""Runs `knuckle live --view` for tests, and talks to it by plain sockets."""
import base64
import json
import os
import pathlib
import re
import resource
import signal
import socket
import struct
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parents[2]
SOURCE = "synthetic:manifests/demo.toml?rate=20&loop=1"
LONGEST_S = 60


def program():
    return sys.argv[1]


def skip_without_server():
    info = json.loads(subprocess.run([program(), "info", "--json"], capture_output=True, check=True, text=True).stdout)
    if info["view"] != "live --view":
        print("skipped: built without Boost")
        sys.exit(77)


class Live:
    """A running program; `with` ends it."""

    def __init__(self, *arguments, source=SOURCE, port="0", most_kb=None):
        def prepare():
            signal.signal(signal.SIGINT, signal.default_int_handler)
            if most_kb:  # files may grow no longer, as on a full disk
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_kb << 10, most_kb << 10))

        self.process = subprocess.Popen([program(), "live", "--source", source, "--view", port, *arguments], cwd=PROJECT,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        preexec_fn=prepare)
        line = self.process.stderr.readline()
        found = re.fullmatch(r"view: (http://([^:/]+):(\d+)/(?:\?token=([0-9a-f]{32}))?)\n", line)
        if not found:
            self.process.kill()
            raise AssertionError(f"no address: {line}{self.process.stderr.read()}")
        self.address, self.host, self.token = found[1], found[2], found[4]
        self.port = int(found[3])
        self.sockets = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for opened in self.sockets:
            opened.close()
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def end(self, with_signal=signal.SIGINT):
        """Ends it as Ctrl-C does, or waits; returns its status, output and errors."""
        if with_signal:
            self.process.send_signal(with_signal)
        out, errors = self.process.communicate(timeout=LONGEST_S)
        return self.process.returncode, out, errors

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def memory_kb(self):
        return int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{self.process.pid}/status").read_text())[1])

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=LONGEST_S)

    def ask(self, method, path, body="", **fields):
        """Status, fields and body of the answer to a request."""
        fields = {"Host": f"localhost:{self.port}", "Connection": "close", **fields}
        if body:
            fields["Content-Length"] = len(body)
        head = "".join(f"{name}: {value}\r\n" for name, value in fields.items())
        with self.connect() as connection:
            connection.sendall(f"{method} {path} HTTP/1.1\r\n{head}\r\n{body}".encode())
            answer = b"".join(iter(lambda: connection.recv(65536), b""))
        head, _, content = answer.partition(b"\r\n\r\n")
        first, *lines = head.decode().split("\r\n")
        return int(first.split()[1]), {line.split(": ")[0].lower(): line.split(": ")[1] for line in lines}, content


class Socket:
    """A WebSocket of /api/records or /api/frames."""

    def __init__(self, live, path, **fields):
        self.connection = live.connect()
        self.stream = self.connection.makefile("rb")
        live.sockets.append(self)
        fields = {"Host": f"localhost:{live.port}", "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                  "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(), **fields}
        head = "".join(f"{name}: {value}\r\n" for name, value in fields.items())
        self.connection.sendall(f"GET {path} HTTP/1.1\r\n{head}\r\n".encode())
        self.status = int(self.stream.readline().split()[1])
        while self.stream.readline() not in (b"\r\n", b""):
            pass

    def message(self):
        """The next message, or None at the end."""
        head = self.stream.read(2)
        if len(head) < 2 or head[0] & 15 == 8:
            return None
        size = head[1]
        if size >= 126:
            size = struct.unpack(">H" if size == 126 else ">Q", self.stream.read(2 if size == 126 else 8))[0]
        return self.stream.read(size)

    def frame(self):
        """Header and depth of a message of /api/frames."""
        message = self.message()
        size = struct.unpack_from("<I", message)[0]
        header = json.loads(message[4:4 + size])
        return header, memoryview(message)[4 + size:].cast("H")

    def close(self):
        self.stream.close()
        self.connection.close()
