"""Hard spheres: collisions per second of CPU time, beside a peer program; the cost of rules, sizes, walls and cooling.

The peer is EDMD (https://github.com/FSmallenburg/EDMD), built from its sources with its own flags, without thermostat,
with an end that it never reaches and frequent output. It reads ``init.sph`` from its working directory:

    sed -i 's/maxtime = .*;/maxtime = 1e9;/; s/writeinterval = .*;/writeinterval = 0.2;/' md*.c
    sed -i 's/usethermostat = 1/usethermostat = 0/' md*.c

Both start from the same positions and run in turn in each repetition; the start-up is not timed. The ratio is the
median over the repetitions.

    python benchmarks/hard_spheres.py --peer single=path/to/md --peer cell=path/to/md --n 10000
    python benchmarks/hard_spheres.py --peer cell=path/to/md --n 1000000 --tables rates --repetitions 1

With a million spheres the peer takes minutes to its first line. The tables of rules and cooling use the first N only.
Rules are compared at the same state: each measurement starts from the same spheres and times ten collisions of each. A
gas that loses energy would otherwise be measured with dense regions and more crossings of cells per collision.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from grains import hard_spheres
from harness import publish, table

import hardlimit as hl

TABLES = ("rates", "kinds", "cooling")
LINE = re.compile(r"Simtime: ([\d.]+), Collisions: (\d+)")


def start(n: int, fraction: float, **other: Any) -> hl.ParticleSystem:
    """Random spheres, by default of diameter 1 and mass 1."""
    settings = {"radius": 0.5, "density": 6.0 / math.pi, "rms_speed": math.sqrt(3.0), "seed": 1} | other
    return hl.ParticleSystem.random(n, fraction, **settings)


class Ours:
    """A run that continues from one repetition to the next."""

    def __init__(
        self, system: hl.ParticleSystem, rule: str = "constant", restitution: float = 1.0, **friction: float
    ) -> None:
        law = ("viscoelastic", 0, [1e8, 0.3, 1e-5], None) if rule in ("law", "soft") else None
        if law:
            restitution = math.nan
        duration = 1e-4 if rule == "tc" else math.nan
        self.run = hard_spheres(system, rule, restitution, law, duration, **friction)

    def warm_up(self) -> Ours:
        self.run.advance(math.inf, 5 * len(self.run.state()[0]))
        return self

    def rate(self, seconds: float) -> float:
        """Collisions per second of CPU time, over about ``seconds``."""
        rows, begin = self.run.n_contacts, time.process_time()
        while time.process_time() - begin < seconds:
            self.advance(20_000)
        return (self.run.n_contacts - rows) / (time.process_time() - begin)

    def rate_from_start(self) -> float:
        """The same over ten collisions of each sphere, after the first two."""
        n = len(self.run.state()[0])
        self.advance(n)
        begin = time.process_time()
        self.advance(5 * n)
        return 5 * n / (time.process_time() - begin)

    def advance(self, collisions: int) -> None:
        self.run.advance(math.inf, collisions)
        if self.run.outcome != "ok":
            raise SystemExit(f"the run has ended: {self.run.outcome} after {self.run.n_contacts} collisions")


def peer_rate(program: str, directory: Path, seconds: float) -> float:
    """The same for the peer, between two of the lines that it prints."""
    command = ["stdbuf", "-oL", str(Path(program).resolve())]
    process = subprocess.Popen(command, cwd=directory, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    points: list[tuple[float, int]] = []
    try:
        for line in process.stdout:
            match = LINE.match(line)
            if not match:
                continue
            points.append((cpu_seconds(process.pid), int(match[2])))
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
    """EDMD's format: number, box, then type, position and radius, reduced to avoid overlaps from rounding."""
    lines = [str(len(position)), f"{edge:.12f} {edge:.12f} {edge:.12f}"]
    lines += [f"a {x:.12f} {y:.12f} {z:.12f} 0.49999999999" for x, y, z in position]
    (directory / "init.sph").write_text("\n".join(lines) + "\n")


def compare(n: int, fraction: float, peers: dict[str, str], repetitions: int, seconds: float) -> list[str]:
    system = start(n, fraction)
    rates: dict[str, list[float]] = {name: [] for name in ("ours", *peers)}
    ours = Ours(system).warm_up()
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        write_start(directory, system.positions, float(system.box[0]))
        for _ in range(repetitions):
            rates["ours"].append(ours.rate(seconds))
            for peer, program in peers.items():
                rates[peer].append(peer_rate(program, directory, seconds))
    best = max(peers, key=lambda peer: float(np.median(rates[peer])), default="ours")
    ratio = np.median(np.array(rates["ours"]) / np.array(rates[best]))
    row = [f"{n:g}", f"{fraction:g}", f"{np.median(rates['ours']):.3g}", f"{ours.run.memory / n:.0f}"]
    return [*row, best, f"{np.median(rates[best]):.3g}", f"{ratio:.2f}"]


def kinds(n: int, fraction: float, repetitions: int) -> list[list[str]]:
    """Each rule, friction, unequal spheres, and a box with a floor, relative to equal elastic spheres."""
    equal = start(n, fraction)
    unequal = start(n, fraction, radius=np.random.default_rng(2).uniform(0.25, 0.75, n))
    height = (n * math.pi / 6.0 / fraction) ** (1.0 / 3.0)
    heavy = start(n, fraction, boundary=("periodic", "periodic", "wall"), gravity=(0.0, 0.0, -1.0 / height))
    runs: dict[str, Callable[[], Ours]] = {
        "constant": lambda: Ours(equal),
        "tc": lambda: Ours(equal, "tc", 0.999),
        "law": lambda: Ours(equal, "law"),
        "soft": lambda: Ours(equal, "soft"),
        "friction": lambda: Ours(equal, friction=0.5, tangential_restitution=0.3),
        "rough, elastic": lambda: Ours(equal, friction=math.inf, tangential_restitution=1.0),
        "sizes 1 to 3": lambda: Ours(unequal),
        "walls and gravity": lambda: Ours(heavy),
    }
    measured = [[run().rate_from_start() for run in runs.values()] for _ in range(repetitions)]
    rates = dict(zip(runs, np.array(measured).T, strict=True))
    return [
        [f"{n:g}", f"{fraction:g}", kind, f"{np.median(r):.3g}", f"{np.median(r / rates['constant']):.2f}"]
        for kind, r in rates.items()
    ]


def cooling(n: int, restitution: float) -> list[str]:
    """CPU time per collision of a dilute gas that cools to 1e-8 of its temperature: at the start and at the end."""
    run = Ours(start(n, 0.1), restitution=restitution).run

    def temperature() -> float:
        return float(np.mean(np.asarray(run.state()[1]) ** 2))

    begin, costs = temperature(), []
    while temperature() > 1e-8 * begin:
        rows, before = run.n_contacts, time.process_time()
        run.advance(math.inf, 10 * n)
        costs.append((time.process_time() - before) / (run.n_contacts - rows))
    first, last = np.median(costs[:5]), np.median(costs[-5:])
    collisions = f"{run.n_contacts / n:.0f}"
    return [f"{n:g}", f"{restitution:g}", collisions, f"{1e6 * first:.2f}", f"{last / first:.2f}"]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--peer", action="append", default=[], metavar="NAME=PROGRAM")
    parser.add_argument("--n", type=float, nargs="+", default=[1e4])
    parser.add_argument("--fraction", type=float, nargs="+", default=[0.1, 0.3, 0.5])
    parser.add_argument("--seconds", type=float, default=2.0, help="CPU time of one measurement")
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--tables", nargs="+", choices=TABLES, default=list(TABLES))
    arguments = parser.parse_args()
    peers = dict(item.split("=", 1) for item in arguments.peer)
    n = int(arguments.n[0])
    if "rates" in arguments.tables:
        cases = [(int(n), fraction) for n in arguments.n for fraction in arguments.fraction]
        rows = [
            compare(n, fraction, peers, arguments.repetitions, arguments.seconds) for n, fraction in cases
        ]
        head = ["spheres", "φ", "ours [1/s]", "bytes/sphere", "best peer", "peer [1/s]", "ours faster by"]
        publish("hard_spheres", table(head, rows), write=False)
    if "kinds" in arguments.tables:
        head = ["spheres", "φ", "kind", "collisions/s", "share of constant"]
        rows = [row for fraction in arguments.fraction for row in kinds(n, fraction, arguments.repetitions)]
        publish("hard_spheres_kinds", table(head, rows), write=False)
    if "cooling" in arguments.tables:
        head = ["spheres", "ε", "collisions/sphere", "at the start [µs]", "end/start"]
        publish("hard_spheres_cooling", table(head, [cooling(n, e) for e in (0.9, 0.95)]), write=False)


if __name__ == "__main__":
    main()
