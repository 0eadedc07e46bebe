# SPDX-License-Identifier: Apache-2.0
"""Two machines joined by a cable, as name spaces of this one: each with network, and small disks, of its own."""
import contextlib
import os
import shutil
import subprocess
import sys
import time

SKIPPED = 77
INSIDE = "KNUCKLE_TEST_MACHINES"
ADDRESSES = ("10.83.0.1", "10.83.0.2")
CABLE = "cable"
OTHER_END_S = 20


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def enter_first_machine():
    """Begins this program again on the first machine, which is gone with it."""
    if INSIDE in os.environ:
        return
    if not all(map(shutil.which, ("unshare", "nsenter", "ip"))):
        skip("unshare, nsenter or ip is missing")
    for options in (["--net", "--mount"], ["--user", "--map-root-user", "--net", "--mount"]):
        way = ["unshare", *options]
        if subprocess.run([*way, "ip", "link", "add", CABLE, "type", "veth"], capture_output=True, check=False).returncode == 0:
            os.environ[INSIDE] = "first"
            os.execvp(way[0], [*way, sys.executable, *sys.argv])
    skip("this user may make no networks here: `unshare --net` or `ip link add` fails")


def run(*command):
    subprocess.run(command, check=True)


class Machines:
    """The first machine, on which this program runs, and a second one, a process of whose name spaces is known."""

    def __init__(self, second):
        self.enter_second = ["nsenter", "--net", "--mount", "--target", str(second)]

    def on(self, machine, command):
        """The command as it is begun from here to run on machine 0 or 1."""
        return [*(self.enter_second if machine else []), *command]

    @contextlib.contextmanager
    def small_disk(self, machine, folder, kilobytes):
        """A disk of that size at a new folder; the other machine sees an empty folder."""
        folder.mkdir()
        run(*self.on(machine, ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]))
        try:
            yield folder
        finally:
            run(*self.on(machine, ["umount", "--lazy", str(folder)]))

    def cut(self):
        """What is sent is lost, and nobody is told, as behind a switch whose other cable is pulled: frames go to a card that is not there."""
        self._neighbours("replace", "lladdr", "02:00:00:00:00:99", "nud", "permanent")

    def slow_down(self, megabits):
        """From now on the cable carries so many per second each way."""
        for machine in (0, 1):
            run(*self.on(machine, ["tc", "qdisc", "replace", "dev", CABLE, "root", "tbf", "rate", f"{megabits}mbit", "burst", "1mb", "latency", "50ms"]))

    def mend(self):
        self._neighbours("del")

    def _neighbours(self, what, *how):
        for machine in (0, 1):
            run(*self.on(machine, ["ip", "neigh", what, ADDRESSES[1 - machine], *how, "dev", CABLE]))


@contextlib.contextmanager
def two_machines():
    """Asks for `enter_first_machine` before."""
    with subprocess.Popen(["unshare", "--net", "--mount", "cat"], stdin=subprocess.PIPE) as second:
        own = os.readlink("/proc/self/ns/net")
        end = time.monotonic() + OTHER_END_S
        while os.readlink(f"/proc/{second.pid}/ns/net") == own:
            assert time.monotonic() < end, "no second machine"
            time.sleep(0.01)
        machines = Machines(second.pid)
        run("ip", "link", "add", CABLE, "type", "veth", "peer", "name", CABLE, "netns", str(second.pid))
        for machine in (0, 1):
            for words in (["link", "set", "lo", "up"], ["addr", "add", f"{ADDRESSES[machine]}/24", "dev", CABLE],
                          ["link", "set", CABLE, "up"]):
                run(*machines.on(machine, ["ip", *words]))
        yield machines
        second.stdin.close()
