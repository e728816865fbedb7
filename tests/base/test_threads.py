"""Threads: failure to start, Ctrl-C during a computation, and interpreter shutdown."""

import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import hardlimit as hl
from conftest import output_of, slow


def run(program: str) -> subprocess.CompletedProcess[str]:
    """Runs a program in a separate interpreter, so that it cannot affect this process."""
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )


SWEEP = """
import numpy as np
import hardlimit as hl
column = hl.Column.paper(restitution=0.7)
restitution = np.linspace(0.5, 1.0, 2000)
ds = hl.sweep(column, restitution=restitution, threads=1)
"""


@pytest.mark.parametrize("spare", [2, slow(60)])
def test_threads_that_cannot_be_started_are_done_without(spare: int) -> None:
    """A thread needs 8 MB of address space for its stack: with 2 MB left none can start, with 60 MB a few."""
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


SOLVES = {
    "exact": "hl.newton(elastic, until=1e5)",
    "adiabatic": "hl.adiabatic(elastic, until=1e5)",
    "general": "hl.newton(elastic, until=2e4, method='general')",
    "independent": "hl.independent(tall, until=4e4)",
    "trajectory": "result.trajectory(times)",
    "restitution": "soft.restitution(times[::3])",
}


@pytest.mark.parametrize("which", [which if which == "exact" else slow(which) for which in SOLVES])
def test_signals_are_handled_while_a_solver_works(which: str) -> None:
    """A timer signal every 10 ms: if signals were handled only when the solver returns, the handler would run once."""
    done = run(
        f"""
import signal
import numpy as np
import hardlimit as hl
elastic = hl.Column.paper(restitution=1.0)
tall = hl.Column([hl.Ball(0.01, mass=1.0)] * 200, [0.1] * 199, 0.5, hl.LinearDashpot(stiffness=1e6, restitution=1.0))
soft = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, dissipative_time=1e-6).between(hl.Ball(0.01, mass=1.0))
times = np.linspace(0.001, 1.0, 100_000)
result = hl.newton(elastic, until=1.0)
calls = 0
def count(number, frame):
    global calls
    calls += 1
signal.signal(signal.SIGALRM, count)
signal.setitimer(signal.ITIMER_REAL, 0.01, 0.01)
{SOLVES[which]}
heard = calls
signal.setitimer(signal.ITIMER_REAL, 0.0)
print(heard > 1)
"""
    )
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


def test_ctrl_c_ends_a_solve_that_would_take_hours() -> None:
    done = run(
        """
import signal
import hardlimit as hl
balls = [hl.Ball(0.01, mass=0.01)] * 1000
row = hl.Column.cradle(balls, [1.0] + [0.0] * 999, hl.LinearDashpot(stiffness=1e6, restitution=0.9), gaps=1e-3)
signal.signal(signal.SIGALRM, signal.default_int_handler)
signal.setitimer(signal.ITIMER_REAL, 0.05)
try:
    hl.newton(row, until=1e3)
except KeyboardInterrupt:
    print("interrupted")
"""
    )
    assert (done.returncode, done.stdout) == (0, "interrupted\n"), done.stderr


GAS = hl.ParticleSystem.random(300, 0.4, 1e-3, 2500.0, 0.3, thermostat=hl.RandomKicks(1e-3, 1e-4))
SOFT = hl.LinearDashpot(stiffness=1e5, restitution=0.8)
TALL = hl.Column(
    [hl.Ball(0.01, mass=1.0)] * 6, [0.01] * 5, 0.5, hl.LinearDashpot(stiffness=1e6, restitution=0.9)
)
#: Calls that take tenths of a second: of each kind of function that looks for signals, with a function of the user.
LONG: dict[str, Callable[[Callable[..., Any]], object]] = {
    "random start": lambda f: hl.ParticleSystem.random(4000, 0.6, 1e-3, 2500.0, 0.3, progress=f),
    "random disks": lambda f: hl.ParticleSystem.random(
        4000, 0.8, (1e-3, 2e-3), 2500.0, 0.3, dimension=2, progress=f
    ),
    "hard spheres": lambda f: hl.event_driven(GAS, restitution=0.9, until=0.1, log=True, progress=f),
    "events": lambda f: hl.molecular_dynamics(GAS, law=SOFT, until=0.05, engine="events", progress=f),
    "steps": lambda f: hl.molecular_dynamics(GAS, law=SOFT, until=0.05, engine="steps", progress=f),
    "sweep": lambda f: hl.sweep(TALL, restitution=np.linspace(0.5, 0.9, 8), progress=f),
    "column": lambda f: hl.newton(TALL, until=200.0, method="general"),
    "fidelity": lambda f: hl.fidelity(
        GAS.replace(thermostat=None), law=SOFT, until=0.01, samples=4, replicas=2, progress=f
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("which", LONG)
def test_ctrl_c_at_random_moments_is_a_keyboard_interrupt(which: str) -> None:
    """Nothing else comes out, such as a SystemError: no Python code runs while an exception is pending."""
    call, chance = partial(LONG[which], lambda *told: sum(told)), random.Random(which)
    call()  # imports modules
    begun = time.monotonic()
    call()
    duration, ended = time.monotonic() - begun, 0
    former = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for _ in range(5):
            try:
                signal.setitimer(signal.ITIMER_REAL, max(1e-3, 0.9 * chance.random() * duration))
                call()
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            except KeyboardInterrupt:
                ended += 1
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, former)
    assert ended > 0


def test_the_interpreter_ends_while_daemon_threads_solve() -> None:
    done = run(
        """
import threading
import hardlimit as hl
balls = [hl.Ball(0.01, mass=0.01)] * 20
column = hl.Column(balls, [1e-4] * 19, 0.5, hl.LinearDashpot(stiffness=1e7, restitution=0.99))
working = threading.Semaphore(0)
def solve():
    while True:
        hl.newton(column, until=0.005)
        working.release()
for _ in range(2):
    threading.Thread(target=solve, daemon=True).start()
for _ in range(2):
    working.acquire()
print("end")
"""
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "end\n", "")


def test_threads_may_share_a_fresh_result() -> None:
    """The dissipated energy is computed on first use, here by four threads at once."""
    column = hl.Column.paper(restitution=0.5)
    times = np.linspace(-0.1, 0.0008, 40)
    expected = hl.newton(column).trajectory(times).dissipated_energy.values
    together = threading.Barrier(4)

    def ask(result: hl.Result) -> NDArray[np.float64]:
        core = result._core
        together.wait()
        dissipated: NDArray[np.float64] = core.sample(times)[6]
        return dissipated

    with ThreadPoolExecutor(4) as pool:
        for _ in range(500):
            fresh = hl.newton(column)
            for values in pool.map(ask, [fresh] * 4):
                np.testing.assert_array_equal(values, expected)


@pytest.mark.slow
def test_a_point_of_a_map_and_the_first_sum_of_energies_can_be_given_up(tmp_path: Path) -> None:
    """Each computation stops at the third check of its Stop and makes no fourth one."""
    said = output_of("base/stop.cpp", tmp_path, "-O0")
    assert said.split("\n") == ["exact passed", "general passed", "dissipated passed", ""]
