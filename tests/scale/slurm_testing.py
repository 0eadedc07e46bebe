# SPDX-License-Identifier: Apache-2.0
"""A Slurm of a test's own on this machine."""
import contextlib
import pathlib
import subprocess
import sys

SKIPPED = 77
SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/slurm/local_cluster.sh"


@contextlib.contextmanager
def local_slurm(folder):
    """Starts Slurm in that folder and gives the variables by which commands find it; ends it, with all its jobs, at the end. It
    lives as long as a pipe of ours is open: it ends with this process, however that ends. The test is skipped where this machine
    cannot have one."""
    possible = subprocess.run([SCRIPT, "check"], capture_output=True, text=True, check=False)
    if possible.returncode != 0:
        print(f"skipped: {possible.stderr.strip()}")
        sys.exit(SKIPPED)
    with subprocess.Popen([SCRIPT, "run", folder, "sh", "-c", "echo up; exec cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as cluster:
        try:
            assert cluster.stdout.readline() == "up\n", cluster.communicate()[1]
            yield {"SLURM_CONF": str(folder / "slurm.conf")}
        finally:
            cluster.communicate()  # closes the pipe
