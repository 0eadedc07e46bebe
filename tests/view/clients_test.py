# SPDX-License-Identifier: Apache-2.0
"""The clients of examples/live_clients print the tips that stand in the records.

usage: clients_test.py KNUCKLE LIVE_CLIENT
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

from live_program import LONGEST_S, PROJECT, Live, skip_without_server

CLIENTS = PROJECT / "examples/live_clients"


def tips_of(records):
    """Frame to (side, x, y, z)."""
    tips = {}
    for line in records.read_text().splitlines():
        record = json.loads(line)
        for hand in record["hands"]:
            tips[record["frame"]] = (hand["side"], *hand["landmarks_mm"]["index_tip"])
    return tips


def check(name, lines, tips):
    frames = []
    for line in lines:
        frame, side, *tip = line.split()
        frames.append(int(frame))
        expected = tips[int(frame)]
        assert side == expected[0], f"{name}: {line}, expected {expected}"
        assert all(abs(float(a) - b) < 1e-3 for a, b in zip(tip, expected[1:], strict=True)), f"{name}: {line}, expected {expected}"
    assert len(frames) >= 5, f"{name}: only {len(frames)} lines"
    assert frames == [frame for frame in tips if frame >= frames[0]], f"{name}: has missed some of the records"


def main():
    skip_without_server()
    commands = {"C++": [sys.argv[2]], "Python": [sys.executable, CLIENTS / "index_tip.py"]}
    if shutil.which("node"):
        commands["JavaScript"] = ["node", CLIENTS / "index_tip.mjs"]
    with tempfile.TemporaryDirectory() as folder:
        records = pathlib.Path(folder) / "records.jsonl"
        with Live("--records", str(records)) as live:
            runs = {name: subprocess.Popen([*command, live.address], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                    for name, command in commands.items()}
            firsts = {name: run.stdout.readline() for name, run in runs.items()}
            time.sleep(1.0)  # twenty frames
            status, _, errors = live.end()
            assert status == 0, errors
            tips = tips_of(records)
            for name, run in runs.items():
                rest, faults = run.communicate(timeout=LONGEST_S)
                assert run.returncode == 0, f"{name}: {faults}"
                check(name, [firsts[name], *rest.splitlines()], tips)
    print("passed:", *commands)


if __name__ == "__main__":
    main()
