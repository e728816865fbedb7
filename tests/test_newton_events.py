"""Newton's equations by events: reference boxes, columns, balances, saved states, clusters."""

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
from conftest import DATA
from hardlimit import _core

REFERENCE = json.loads((DATA / "grains.json").read_text(encoding="utf-8"))
CASES = [(kind, k) for kind in ("newton", "dilute") for k in range(len(REFERENCE[kind]))]
LAWS: list[hl.contact.Law] = [
    hl.LinearDashpot(stiffness=2000.0, restitution=0.8),
    hl.LinearDashpot(stiffness=2000.0, restitution=1.0),
    hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-5),
    hl.Tsuji(elastic_prefactor=1e5, restitution=0.7),
]


def choice(law: hl.contact.Law) -> tuple[str, int, list[float]]:
    """A law as the core takes it."""
    return law.record["name"], law.alternative, list(law.parameters.values())


def engine(
    positions: Any, velocities: Any, law: hl.contact.Law, *, radius: Any = 1e-3, density: float = 2500.0,
    box: Any, periodic: Any, gravity: Any = None, log: bool = True,
) -> Any:  # fmt: skip
    """The compiled engine with these bodies."""
    positions = np.ascontiguousarray(positions, float)
    n, d = positions.shape
    radii = np.broadcast_to(np.asarray(radius, float), (n,)).copy()
    mass = density * 4.0 / 3.0 * math.pi * radii**3
    pull = np.zeros(d) if gravity is None else gravity
    return _core.NewtonEvents(
        positions, np.ascontiguousarray(velocities, float), radii, mass, list(map(float, box)),
        list(periodic), list(map(float, pull)), choice(law), log,
    )  # fmt: skip


def contacts(run: Any) -> list[tuple[Any, ...]]:
    """All contacts so far, by their begin."""
    parts = [run.take_log(), run.open_contacts()]
    return sorted(row for part in parts for row in zip(*(c.tolist() for c in part), strict=True))


def energy(run: Any) -> float:
    seen = run.observe()
    names = ("kinetic_energy", "potential_energy", "contact_energy", "dissipated_energy")
    return float(sum(seen[name] for name in names))


def law_of(case: dict[str, Any]) -> hl.contact.Law:
    if case["law"] == "linear":
        return hl.LinearDashpot(stiffness=case["stiffness"], restitution=case["restitution"])
    names = ("youngs_modulus", "poisson_ratio", "dissipative_time")
    return hl.Viscoelastic(**{name: case[name] for name in names})


@pytest.mark.parametrize(("kind", "k"), CASES)
def test_reference_boxes(kind: str, k: int) -> None:
    """Every contact of the reference, and the state at its end."""
    case = REFERENCE[kind][k]
    run = engine(
        case["positions"], case["velocities"], law_of(case), radius=case["radius"], density=case["density"],
        box=case["box"], periodic=[b == "periodic" for b in case["boundary"]], gravity=case["gravity"],
    )  # fmt: skip
    before = energy(run)
    run.advance(case["until"])
    assert run.outcome == "ok"
    found = contacts(run)
    wanted = sorted(map(tuple, case["contacts"]))
    assert [row[2:4] for row in found] == [row[2:4] for row in wanted]
    scale = 1e-8 * case["until"] if case["law"] == "linear" else 1e-7 * case["until"]
    for row, other in zip(found, wanted, strict=True):
        assert row[0] == pytest.approx(other[0], abs=scale)
        if other[1] is None or not other[1] <= case["until"]:
            assert math.isnan(row[1])
        else:
            assert row[1] == pytest.approx(other[1], abs=scale)
    positions, velocities = run.state()
    rms = math.sqrt(np.mean(np.sum(np.square(case["velocities"]), axis=1)))
    assert np.abs(positions - case["end_positions"]).max() < case["tolerance"] * min(case["radius"])
    assert np.abs(velocities - case["end_velocities"]).max() < case["tolerance"] * rms
    assert energy(run) == pytest.approx(before, rel=1e-11)
