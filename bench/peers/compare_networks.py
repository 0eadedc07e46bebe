#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The same networks by Knuckle, ONNX Runtime, OpenCV and LibTorch: one thread, a patch at a time, in one run.

    bench/peers/compare_networks.py [--build build/release] [--rounds 7] [--looks 40] MODEL.pt...

Engines take turns, so that what slows the machine slows all of them. Prints the table of docs/performance.md: the median over the rounds
of each round's fastest tenth, and how often Knuckle would have been ready meanwhile. An engine that is missing is left out, and named.
"""
import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

PEERS = pathlib.Path(__file__).resolve().parent
MISSING = 77


def command_of(engine, build, model, onnx, looks):
    if engine == "ONNX Runtime":
        return ["node", PEERS / "onnx_runtime.cjs", onnx, str(looks)]
    return [build / "bin/knuckle_network_peer", engine.lower(), model, onnx, str(looks)]


def fastest_tenth(command):
    """Mean of the fastest tenth of the looks [ms]; None where the engine is missing."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    except FileNotFoundError:
        return None
    if done.returncode == MISSING:
        return None
    if done.returncode != 0:
        sys.exit(done.stderr.strip())
    times = sorted(float(line) for line in done.stdout.split())
    return statistics.mean(times[:max(1, len(times) // 10)])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--looks", type=int, default=40)
    arguments = parser.parse_args()
    engines = ["Knuckle", "ONNX Runtime", "OpenCV", "LibTorch"]
    print("| network | " + " | ".join(f"{engine} [ms]" for engine in engines) + " |\n|---|" + "---|" * len(engines))
    with tempfile.TemporaryDirectory() as folder:
        for model in arguments.models:
            onnx = pathlib.Path(folder) / (model.stem + ".onnx")
            subprocess.run([arguments.build / "bin/knuckle", "export", "--model", model, "--out", onnx], check=True,
                           stdout=subprocess.DEVNULL)
            times = {engine: [] for engine in engines}
            for _ in range(arguments.rounds):
                for engine in engines:
                    times[engine].append(fastest_tenth(command_of(engine, arguments.build, model, onnx, arguments.looks)))
            own = statistics.median(times["Knuckle"])
            cells = []
            for engine in engines:
                if None in times[engine]:
                    cells.append("missing")
                    continue
                ratio = statistics.median(time / base for time, base in zip(times[engine], times["Knuckle"]))
                cells.append(f"{own:.2f}" if engine == "Knuckle" else f"{statistics.median(times[engine]):.2f} ({ratio:.2f} times)")
            print(f"| `{model.stem}` | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
