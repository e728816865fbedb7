"""Elastic hard spheres: collisions per second of CPU time, beside a peer that is given as a program.

The peer is EDMD (https://github.com/FSmallenburg/EDMD), built from its sources with its own flags, no thermostat, a
time that it will not reach and frequent output; it reads ``init.sph`` from the directory it runs in:

    sed -i 's/maxtime = .*;/maxtime = 1e9;/; s/writeinterval = .*;/writeinterval = 0.2;/' md*.c
    sed -i 's/usethermostat = 1/usethermostat = 0/' md*.c

Both start from the same positions, one after the other in each repetition, and are timed after a start-up that is left
out; the ratio is the median over the repetitions.

    python benchmarks/hard_spheres.py --peer single=path/to/md --peer cell=path/to/md --n 10000 1000000
"""

from __future__ import annotations

import argparse
import math
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from harness import publish, table

from hardlimit import _core

LINE = re.compile(r"Simtime: ([\d.]+), Collisions: (\d+)")


def start(n: int, fraction: float) -> tuple[np.ndarray, float]:
    """Positions of spheres of diameter 1, and the edge of their box."""
    edge = (n * math.pi / 6.0 / fraction) ** (1.0 / 3.0)
    return _core.grow_packing(n, 3, np.full(n, 0.5), [edge] * 3, [True] * 3, 1), edge


class Ours:
    """A run that goes on from one repetition to the next."""

    def __init__(self, position: np.ndarray, edge: float, rule: str = "constant") -> None:
        n = len(position)
        velocity = np.random.default_rng(1).standard_normal(position.shape)
        law = ("viscoelastic", 0, [1e7, 0.3, 1e-5]) if rule in ("law", "soft") else None
        restitution = math.nan if law else (1.0 if rule == "constant" else 0.999)
        duration = 1e-4 if rule == "tc" else math.nan
        velocity -= velocity.mean(axis=0)
        radius, mass = np.full(n, 0.5), np.ones(n)
        self.run = _core.HardSpheres(
            position,
            velocity,
            radius,
            mass,
            [edge] * 3,
            [True] * 3,
            [0.0] * 3,
            rule,
            restitution,
            law,
            duration,
            False,
        )
        self.run.advance(math.inf, 5 * n)

    def rate(self, seconds: float) -> float:
        """Collisions per second of CPU time, over about so many of them."""
        rows, begin = self.run.n_rows, time.process_time()
        while time.process_time() - begin < seconds:
            self.run.advance(math.inf, self.run.n_rows + 20_000)
        return (self.run.n_rows - rows) / (time.process_time() - begin)


def peer_rate(program: str, directory: Path, seconds: float) -> float:
    """The same of the peer, between two of the lines that it prints."""
    command = ["stdbuf", "-oL", str(Path(program).resolve())]
    process = subprocess.Popen(command, cwd=directory, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    points: list[tuple[float, int]] = []
    try:
        for line in process.stdout:
            found = LINE.match(line)
            if not found:
                continue
            points.append((cpu_seconds(process.pid), int(found[2])))
            if len(points) > 2 and points[-1][0] - points[1][0] > seconds:
                break
    finally:
        process.kill()
        process.wait()
    (begin, before), (end, after) = points[1], points[-1]
    return (after - before) / (end - begin)


def cpu_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def write_start(directory: Path, position: np.ndarray, edge: float) -> None:
    """EDMD's format: number, box, then type, place and radius of each, a little less lest rounding make overlaps."""
    lines = [str(len(position)), f"{edge:.12f} {edge:.12f} {edge:.12f}"]
    lines += [f"a {x:.12f} {y:.12f} {z:.12f} 0.49999999999" for x, y, z in position]
    (directory / "init.sph").write_text("\n".join(lines) + "\n")


def compare(n: int, fraction: float, peers: dict[str, str], repetitions: int, seconds: float) -> list[str]:
    position, edge = start(n, fraction)
    rates: dict[str, list[float]] = {name: [] for name in ("ours", *peers)}
    ours = Ours(position, edge)
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        write_start(directory, position, edge)
        for _ in range(repetitions):
            rates["ours"].append(ours.rate(seconds))
            for peer, program in peers.items():
                rates[peer].append(peer_rate(program, directory, seconds))
    best = max(peers, key=lambda peer: float(np.median(rates[peer])), default="ours")
    ratio = np.median(np.array(rates["ours"]) / np.array(rates[best]))
    row = [f"{n:g}", f"{fraction:g}", f"{np.median(rates['ours']):.3g}", f"{ours.run.memory / n:.0f}"]
    return [*row, best, f"{np.median(rates[best]):.3g}", f"{ratio:.2f}"]


def rules(n: int, fraction: float, repetitions: int, seconds: float) -> list[list[str]]:
    """Each rule beside the constant one."""
    position, edge = start(n, fraction)
    runs = {rule: Ours(position, edge, rule) for rule in ("constant", "tc", "law", "soft")}
    rates = {rule: np.array([run.rate(seconds) for _ in range(repetitions)]) for rule, run in runs.items()}
    return [
        [f"{n:g}", f"{fraction:g}", rule, f"{np.median(r):.3g}", f"{np.median(r / rates['constant']):.2f}"]
        for rule, r in rates.items()
    ]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--peer", action="append", default=[], metavar="NAME=PROGRAM")
    parser.add_argument("--n", type=float, nargs="+", default=[1e4])
    parser.add_argument("--fraction", type=float, nargs="+", default=[0.1, 0.3, 0.5])
    parser.add_argument("--seconds", type=float, default=2.0, help="CPU time of one measurement")
    parser.add_argument("--repetitions", type=int, default=5)
    given = parser.parse_args()
    peers = dict(item.split("=", 1) for item in given.peer)
    cases = [(int(n), fraction) for n in given.n for fraction in given.fraction]
    rows = [compare(n, fraction, peers, given.repetitions, given.seconds) for n, fraction in cases]
    head = ["spheres", "φ", "ours [1/s]", "bytes/sphere", "best peer", "peer [1/s]", "ours faster by"]
    publish("hard_spheres", table(head, rows), write=False)
    kinds = rules(int(given.n[0]), 0.3, given.repetitions, given.seconds)
    head = ["spheres", "φ", "rule", "collisions/s", "share of constant"]
    publish("hard_spheres_rules", table(head, kinds), write=False)


if __name__ == "__main__":
    main()
