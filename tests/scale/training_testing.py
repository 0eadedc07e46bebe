# SPDX-License-Identifier: Apache-2.0
"""What tests of trainings share: a folder to train in, the program as a process, how it ended, and the smallest network."""
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time

PROJECT = pathlib.Path(__file__).resolve().parents[2]
LONGEST_S = 500  # that a process or what it waits for may take
GROUP_VARIABLES = ("RANK", "WORLD_SIZE", "MASTER_ADDR", "MASTER_PORT", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID")
SMALL_NETWORK = """
[network]
convention = 'icg20'
architecture = 'dense'
stem_channels = 4
quarter_channels = 8
eighth_channels = 8
sixteenth_channels = 8
head_channels = 8
"""


class Place:
    """A folder for configurations and models, and the program that trains."""

    def __init__(self, program, folder):
        self.program = program
        self.folder = folder
        (folder / "tmp").mkdir()

    def environment(self, **variables):
        """This process's, but for what it says of a group of workers; temporary files lie in the folder."""
        own = {name: value for name, value in os.environ.items() if name not in GROUP_VARIABLES}
        return {**own, "TMPDIR": str(self.folder / "tmp"), **variables}

    def start(self, command, *, longest_file=None, **variables):
        """Starts a command. A write beyond `longest_file` bytes fails, as on a full disk."""
        limited = {} if longest_file is None else {
            "restore_signals": False,  # SIGXFSZ stays ignored, as Python has it
            "preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (longest_file, longest_file)),
        }
        return subprocess.Popen(command, cwd=PROJECT, env=self.environment(**variables), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True, **limited)

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()

    def wait_for(self, name, process):
        """Until the process has written that file."""
        end = time.monotonic() + LONGEST_S
        while not (self.folder / name).exists():
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < end, f"no {name}"
            time.sleep(0.01)

    def wait_for_checkpoint(self, out, process):
        self.wait_for(f"{out}.checkpoint", process)


def ended(process):
    """Waits for its end: its exit status, what it printed, the lines that name an error, and all of standard error."""
    out, errors = process.communicate(timeout=LONGEST_S)
    lines = [line for line in errors.splitlines() if line.startswith("knuckle:")]
    return process.returncode, out, lines, errors


def succeeded(process):
    status, out, _, errors = ended(process)
    assert status == 0, errors
    return out


def failed_with(process, *parts):
    """Asserts that it failed with one line of errors, which has all the parts."""
    status, _, lines, errors = ended(process)
    assert status == 1 and len(lines) == 1, (status, errors)
    assert all(part in lines[0] for part in parts), (parts, lines)


def run_case(place, *cases):
    """Runs the case that the command line names, CASE PROGRAM, in a folder of its own: a `place(program, folder)`."""
    name, program = sys.argv[1:]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, and hand that on
    with tempfile.TemporaryDirectory() as folder:
        {case.__name__: case for case in cases}[name](place(pathlib.Path(program).resolve(), pathlib.Path(folder)))
