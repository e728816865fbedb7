"""Fail if the core has become slower beside a fixed loop: ratios of one run, so that the machine's own speed drops out.

    python benchmarks/regression.py [--allowed 1.5] [--write]

The loop is NumPy's: it gathers, multiplies and takes roots of 20,000 numbers. Each engine and the loop run in turn; a
ratio is the least CPU time of the engine over that of the loop. ``ratios.toml`` has the ratios for each set of vector
kernels.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from grains import RESTITUTION, by_events, by_steps, gas, hard_spheres, law_of, rate_of
from harness import lanes

import hardlimit as hl

RATIOS = Path(__file__).with_name("ratios.toml")
REPETITIONS = 15


def fixed_loop() -> Callable[[], object]:
    random = np.random.default_rng(1)
    x, order = random.random(20_000), random.permutation(20_000)
    return lambda: [np.sqrt(x[order] * x + 1.0).sum() for _ in range(40)]


def work() -> dict[str, Callable[[], object]]:
    """The work of each engine: some milliseconds a call."""
    system = gas(2000)
    rate = rate_of(system)
    law = law_of(0.01 / rate)
    hard = hard_spheres(system, "constant", RESTITUTION)
    soft = by_events(system, law)
    steps = by_steps(system, law, 2e-4 / rate)
    column, general = (
        hl.Column.paper(),
        hl.Column(
            [hl.Ball(0.01, density=840.0)] * 5, 1e-4, 0.1, hl.LinearDashpot(stiffness=5e7, restitution=0.7)
        ),
    )
    axes = {"restitution": np.linspace(0.4, 1.0, 60), "gap": np.geomspace(1e-6, 1e-2, 60)}
    return {
        "hard_spheres": lambda: hard.advance(math.inf, 10_000),
        "newton_events": lambda: soft.advance(math.inf, 5_000),
        "newton_steps": lambda: steps.advance(steps.time + 0.01 / rate, threads=1),
        "start": lambda: hard_spheres(system, "constant", RESTITUTION),
        "sweep": lambda: hl.sweep(column, threads=1, **axes),
        "column": lambda: [hl.newton(general) for _ in range(3)],
    }


def ratios() -> dict[str, float]:
    loop, tasks = fixed_loop(), work()
    least = dict.fromkeys(["loop", *tasks], math.inf)
    for _ in range(REPETITIONS):
        for name, run in {"loop": loop, **tasks}.items():
            begun = time.process_time()
            run()
            least[name] = min(least[name], time.process_time() - begun)
    return {name: least[name] / least["loop"] for name in tasks}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--allowed", type=float, default=1.5, help="largest factor beyond the ratio in ratios.toml"
    )
    parser.add_argument("--write", action="store_true", help="put the ratios of this run into ratios.toml")
    arguments = parser.parse_args()
    kernels, measured = lanes(), ratios()
    known = tomllib.loads(RATIOS.read_text()) if RATIOS.exists() else {}
    if arguments.write:
        known[kernels] = {name: float(f"{ratio:.3g}") for name, ratio in measured.items()}
        RATIOS.write_text(
            "# CPU time over that of the fixed loop of regression.py, for each set of vector kernels.\n"
            + "".join(
                f"\n[{kind}]\n" + "".join(f"{name} = {ratio}\n" for name, ratio in sorted(of.items()))
                for kind, of in sorted(known.items())
            )
        )
    slower = 0
    for name, ratio in measured.items():
        before = known[kernels][name]
        slower += ratio > arguments.allowed * before
        print(f"{name:14} {ratio:6.3g}, before {before:6.3g}: {ratio / before:.2f} of it")
    if slower:
        print(
            f"{slower} of {len(measured)} became slower than {arguments.allowed:g} times what ratios.toml says"
        )
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
