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
    missed = sorted({frame for frame in tips if frame >= frames[0]} - set(frames))
    assert not missed and frames == sorted(frames), f"{name}: of the records to {max(tips)} it has missed {missed}"


def wait_for_lines(path, count):
    """Until there are so many more."""
    before = path.read_text().count("\n")
    end = time.monotonic() + LONGEST_S
    while path.read_text().count("\n") < before + count:
        assert time.monotonic() < end, f"{path.name}: nothing comes"
        time.sleep(0.05)


def main():
    skip_without_server()
    commands = {"C++": [sys.argv[2]], "Python": [sys.executable, CLIENTS / "index_tip.py"]}
    if shutil.which("node"):
        commands["JavaScript"] = ["node", CLIENTS / "index_tip.mjs"]
    with tempfile.TemporaryDirectory() as folder:
        records = pathlib.Path(folder) / "records.jsonl"
        with Live("--records", str(records)) as live:
            outs = {name: pathlib.Path(folder) / name for name in commands}
            runs = {name: subprocess.Popen([*command, live.address], stdout=outs[name].open("w"), stderr=subprocess.PIPE, text=True)
                    for name, command in commands.items()}
            for out in outs.values():
                wait_for_lines(out, 1)
            wait_for_lines(pathlib.Path(f"{records}.partial"), 20)
            status, _, errors = live.end()
            assert status == 0, errors
            tips = tips_of(records)
            for name, run in runs.items():
                _, faults = run.communicate(timeout=LONGEST_S)
                assert run.returncode == 0, f"{name}: {faults}"
                check(name, outs[name].read_text().splitlines(), tips)
    print("passed:", *commands)


if __name__ == "__main__":
    main()
