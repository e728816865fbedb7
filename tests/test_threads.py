"""Threads: those that cannot be started, those that fail, Ctrl-C, and the end of the interpreter."""

import subprocess
import sys

import pytest


def run(program: str) -> subprocess.CompletedProcess[str]:
    """The program in an interpreter of its own, so that nothing it does to the process matters here."""
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )


SWEEP = """
import numpy as np
import hardlimit as hl
column = hl.Column.paper(restitution=0.7)
restitution = np.linspace(0.5, 1.0, 5000)
ds = hl.sweep(column, restitution=restitution, threads=1)
"""


@pytest.mark.parametrize("spare", [2, 60])
def test_threads_that_cannot_be_started_are_done_without(spare: int) -> None:
    """A thread needs 8 MB of addresses for its stack: with 2 MB left none can be started, with 60 MB a few."""
    done = run(
        SWEEP
        + f"""
import resource
with open("/proc/self/statm") as statm:
    used = int(statm.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + {spare} * 2**20,) * 2)
few = hl.sweep(column, restitution=restitution, threads=64)
print(np.array_equal(ds.t_end, few.t_end), np.array_equal(ds.n_contacts, few.n_contacts))
"""
    )
    assert (done.returncode, done.stdout) == (0, "True True\n"), done.stderr
