"""Timing side by side: every method once per repetition, medians of ratios, CPU time beside wall time."""

from __future__ import annotations

import argparse
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
    """``run(points)`` solves the first ``count`` random points; ours solves the whole map."""

    name: str
    setting: str
    run: Callable[[], object]
    count: int
    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)


def interleave(methods: Sequence[Method], repetitions: int) -> None:
    """Fill in seconds per point: of the second of two calls, so that a method finds caches, memory and, the first
    time, compiled code as it left them itself and not as another one did."""
    for _ in range(repetitions):
        for m in methods:
            m.run()
            cpu, wall = time.process_time(), time.perf_counter()
            m.run()
            m.wall.append((time.perf_counter() - wall) / m.count)
            m.cpu.append((time.process_time() - cpu) / m.count)


@dataclass(frozen=True)
class Accuracy:
    equal_counts: float
    p50: float
    p95: float


def accuracy(n_contacts, velocity, exact_n, exact_velocity, speed) -> Accuracy:
    """Errors of v'_r in units of the impact speed over the points whose contact count is right."""
    m = len(n_contacts)
    equal = np.asarray(n_contacts) == exact_n[:m]
    error = (np.abs(velocity - exact_velocity[:m]) / speed[:m])[equal]
    error = error[np.isfinite(error)]
    return Accuracy(float(equal.mean()), *(float(x) for x in np.percentile(error, [50, 95])))


def comparison(methods: Sequence[Method], accuracies: Sequence[Accuracy]) -> str:
    """The table; ratios are medians over the repetitions of this method to the first."""
    rows = []
    ours = methods[0]
    for m, a in zip(methods, accuracies, strict=True):
        ratio = [np.median(np.array(getattr(m, k)) / np.array(getattr(ours, k))) for k in ("cpu", "wall")]
        rows.append(
            [
                m.name,
                m.setting,
                f"{1 / np.median(m.cpu):.3g}",
                f"{1 / np.median(m.wall):.3g}",
                f"{a.p50:.1e}",
                f"{a.p95:.1e}",
                f"{100 * a.equal_counts:.2f} %",
                f"{m.count}",
                f"{ratio[0]:.3g}",
                f"{ratio[1]:.3g}",
            ]
        )
    return table(
        [
            "method",
            "setting",
            "points/s (CPU)",
            "points/s (wall)",
            "p50 error/V",
            "p95 error/V",
            "equal counts",
            "points",
            "ours faster by (CPU)",
            "(wall)",
        ],
        rows,
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def arguments(description: str, size: int, repetitions: int = 5) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--size", type=int, default=size, help="points along an axis, or in a list")
    parser.add_argument("--repetitions", type=int, default=repetitions)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/README.md")
    return parser.parse_args()


def publish(name: str, text: str, write: bool) -> None:
    """Print a result, and put it between its markers in the README when asked."""
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
    widest = next((n for flag, n in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in text), "SSE2")
    return f"{names[0] if names else platform.machine()} ({widest})"


def _versions() -> str:
    from importlib.metadata import PackageNotFoundError, version

    out = ""
    for name in ("numpy", "numba", "heyoka", "scipy"):
        try:
            out += f", {name} {version(name)}"
        except PackageNotFoundError:
            continue
    return out


def fresh_process(code: str, environment: dict[str, str] | None = None) -> tuple[float, float, str]:
    """Wall and CPU seconds of a Python process that runs ``code``, and what it printed."""
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
        env={**os.environ, **(environment or {})},
    )
    wall = time.perf_counter() - wall
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout
