"""Timing of several methods in turn: medians of ratios, CPU time and wall time."""

from __future__ import annotations

import argparse
import functools
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

README = Path(__file__).parent / "README.md"


@dataclass
class Method:
    """``run()`` solves ``count`` points."""

    name: str
    setting: str
    run: Callable[[], object]
    count: int
    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)


def interleave(methods: Sequence[Method], repetitions: int) -> None:
    """Fill in seconds per point, taken from the second of two calls: the first one restores the method's own caches and
    memory, and compiles at the first repetition."""
    for _ in range(repetitions):
        for m in methods:
            m.run()
            cpu, wall = time.process_time(), time.perf_counter()
            m.run()
            m.wall.append((time.perf_counter() - wall) / m.count)
            m.cpu.append((time.process_time() - cpu) / m.count)


def compare(ours: Sequence[tuple[Method, Callable]], peers, points, columns, repetitions: int) -> str:
    """The table of our methods and the peers; ratios are medians over the repetitions, relative to the first method.

    ``ours`` has with each method a function that gives its counts and v'_r at ``points``, ``peers`` name, setting,
    ``run(points)`` and the number of points, ``columns`` the points for hl.newton, which is the reference.
    """
    from peers import scaled

    import hardlimit as hl

    exact = [hl.newton(c) for c in columns]
    n, v = (np.array([getattr(r, name) for r in exact]) for name in ("n_contacts", "relative_velocity"))
    speed = scaled.impact_speed(points)
    methods, at_points = [list(part) for part in zip(*ours, strict=True)]
    for name, setting, run, count in peers:
        call = functools.partial(run, points.first(count))
        methods.append(Method(name, setting, call, count))
        at_points.append(lambda call=call: ((r := call()).n_contacts, r.relative_velocity))
    interleave(methods, repetitions)
    rows = []
    for m, measure_point in zip(methods, at_points, strict=True):
        ratio = [np.median(np.array(getattr(m, k)) / getattr(methods[0], k)) for k in ("cpu", "wall")]
        equal, p50, p95 = accuracy(*measure_point(), n, v, speed)
        row = [m.name, m.setting, f"{1 / np.median(m.cpu):.3g}", f"{1 / np.median(m.wall):.3g}"]
        row += [f"{p50:.1e}", f"{p95:.1e}", f"{100 * equal:.2f} %", f"{m.count}"]
        rows.append([*row, *(f"{r:.3g}" for r in ratio)])
    head = ["method", "setting", "points/s (CPU)", "points/s (wall)", "p50 error/V", "p95 error/V"]
    return table([*head, "equal counts", "points", "ours faster by (CPU)", "(wall)"], rows)


def sweep_method(setting: str, column, at, count: int, **arguments) -> tuple[Method, Callable]:
    """A sweep on one thread as a method, and the function that gives its counts and v'_r at the indices ``at``."""
    from peers import scaled

    import hardlimit as hl

    kept = {}

    def run() -> None:
        kept["ds"] = hl.sweep(column, threads=1, variables=scaled.RESULTS, **arguments)

    def at_points():
        return kept["ds"].n_contacts.values[at], kept["ds"].relative_velocity.values[at]

    return Method("hardlimit", setting, run, count), at_points


def accuracy(n_contacts, velocity, exact_n, exact_velocity, speed) -> tuple[float, float, float]:
    """Share of points with the right count; median and 95th percentile of their errors of v'_r [impact speed]."""
    m = len(n_contacts)
    equal = np.asarray(n_contacts) == exact_n[:m]
    error = (np.abs(velocity - exact_velocity[:m]) / speed[:m])[equal]
    return float(equal.mean()), *(float(x) for x in np.percentile(error[np.isfinite(error)], [50, 95]))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def arguments(description: str, size: int, repetitions: int = 5, **flags: str) -> argparse.Namespace:
    """The command line; ``flags`` are further options, with the help of each."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--size", type=int, default=size, help="points along an axis, or in a list")
    parser.add_argument("--repetitions", type=int, default=repetitions)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/README.md")
    for name, text in flags.items():
        parser.add_argument(f"--{name}", action="store_true", help=text)
    return parser.parse_args()


def publish(name: str, text: str, write: bool) -> None:
    """Print a result; with ``write`` put it between its markers in the README."""
    text = f"{text}\n\n{conditions()}"
    print(text)
    if not write:
        return
    page = README.read_text()
    begin, end = f"<!-- {name} -->\n", f"<!-- end {name} -->"
    before, rest = page.split(begin)
    README.write_text(before + begin + "\n" + text + "\n\n" + end + rest.split(end, 1)[1])


def conditions() -> str:
    import hardlimit

    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return (
        f"{_processor()}, {cores} cores, {platform.system()}, Python {platform.python_version()}, "
        f"hardlimit {hardlimit.__version__}{_versions()}; load average {load} when printed."
    )


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if not cpuinfo.exists():
        return platform.processor() or platform.machine()
    text = cpuinfo.read_text()
    names = [line.split(":")[1].strip() for line in text.splitlines() if line.startswith("model name")]
    return f"{names[0] if names else platform.machine()} (kernels: {lanes()})"


def lanes() -> str:
    """The vector kernels in use: base, avx2 or avx512."""
    chosen_lanes = os.environ.get("HARDLIMIT_LANES")
    cpuinfo = Path("/proc/cpuinfo")
    flags = cpuinfo.read_text() if cpuinfo.exists() else ""
    return chosen_lanes or next((n for n in ("avx512", "avx2") if n in flags), "base")


def _versions() -> str:
    from importlib.metadata import PackageNotFoundError, version

    out = ""
    for name in ("numpy", "numba", "heyoka", "scipy"):
        try:
            out += f", {name} {version(name)}"
        except PackageNotFoundError:
            continue
    return out


def fresh_process(code: str) -> tuple[float, float, str]:
    """Wall and CPU seconds of a Python process that runs ``code``, and its output."""
    import resource
    import subprocess
    import sys

    before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=True,
        capture_output=True,
        text=True,
        cwd=Path(__file__).parent,
    )
    wall = time.perf_counter() - wall
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout
