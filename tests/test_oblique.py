"""Oblique soft impact: the force of a contact, integrated in the plane by SciPy, turns the contact normal as known."""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hardlimit as hl

PATH = Path(__file__).parent / "data" / "oblique_rotation.csv"
ROWS = list(csv.DictReader(PATH.read_text(encoding="utf-8").splitlines()))


def contact_of(law: str, duration: float) -> hl.Contact:
    """Two spheres of diameter 1 and reduced mass 1 whose elastic head-on impact at speed 1 lasts ``duration``."""
    ball = hl.Ball(0.5, mass=2.0)
    if law == "linear":
        return hl.LinearDashpot(stiffness=(np.pi / duration) ** 2, restitution=1.0).between(ball, ball)
    poisson = 0.3
    prefactor = (3.218065459719 / duration) ** 2.5  # t_c = 3.218… k^(−2/5) v^(−1/5)
    modulus = prefactor * 3.0 * (1.0 - poisson**2) / (2.0 * np.sqrt(0.25))
    elastic = hl.Viscoelastic(youngs_modulus=modulus, poisson_ratio=poisson, dissipative_time=0.0)
    return elastic.between(ball, ball)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(list(row.values())[:3]))
def test_normal_turns(row: dict[str, str]) -> None:
    law, duration, angle, rotation, length = row.values()
    duration, angle = float(duration), np.radians(float(angle))
    contact = contact_of(law, duration)
    np.testing.assert_allclose(contact.duration(1.0), duration, rtol=1e-11)

    def motion(t: float, y: np.ndarray) -> list[float]:
        distance = np.hypot(y[0], y[1])
        push = contact.force(1.0 - distance) / contact.effective_mass / distance
        return [y[2], y[3], push * y[0], push * y[1]]

    def apart(t: float, y: np.ndarray) -> float:
        return np.hypot(y[0], y[1]) - 1.0

    apart.terminal, apart.direction = True, 1.0
    start = [1.0, 0.0, -np.cos(angle), np.sin(angle)]
    run = solve_ivp(
        motion,
        (0, 5 * duration),
        start,
        "DOP853",
        events=apart,
        rtol=1e-12,
        atol=1e-15,
        max_step=duration / 50,
    )
    end = run.y_events[0][-1]
    np.testing.assert_allclose(np.degrees(np.arctan2(end[1], end[0])), float(rotation), rtol=1e-8)
    np.testing.assert_allclose(run.t_events[0][-1] / duration, float(length), rtol=1e-8)
