"""Points of the two-ball problem in SI units, and in the scaled units of the peers.

State: floor gap u, ball–ball gap w, their rates p and q. Linear law, time 1/ω12, speed V (ω12² = k/m_eff):
  u'' = −G + f01 − κ f12,   w'' = f12 − f01,   f01 = κ max(0, −u − d1 p),   f12 = max(0, −w − d2 q)
with κ = m_eff/m1, d2 = 2 β/ω0, d1 = d2/√κ. Viscoelastic law, time k12^{−2/5} V^{−1/5}:
  f01 = k1 max(0, √ξ (ξ − c1 p)), ξ = −u,   f12 = max(0, √ξ (ξ − c2 q)), ξ = −w,   c = (3/2) A.
Either force is zero while gap + d·rate >= 0 (d → c), gap > 0 included. Start: u = 0, p = −1, w = δ, q = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

import hardlimit as hl

GRAVITY = 9.81
DENSITY = 840.0
HEIGHT = 0.6


@dataclass(frozen=True)
class Points:
    """Independent points as arrays of equal length."""

    restitution: np.ndarray
    gap: np.ndarray
    radius_1: np.ndarray
    radius_2: np.ndarray
    stiffness: np.ndarray | None = None
    elastic: np.ndarray | None = None  # [n, 2] ρ of the floor contact and of the pair
    dissipative_time: np.ndarray | None = None  # [n, 2] A of the floor contact and of the pair

    def __len__(self) -> int:
        return len(self.gap)

    def first(self, n: int) -> Points:
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        return replace(self, **{k: v[:n] for k, v in values.items() if v is not None})


@dataclass(frozen=True)
class Results:
    """Results of a peer in SI units."""

    n_contacts: np.ndarray
    relative_velocity: np.ndarray
    separation_velocity: np.ndarray
    t_end: np.ndarray

    @staticmethod
    def of(scaled: np.ndarray, speed: np.ndarray, rate: np.ndarray) -> Results:
        """From rows n, v'_r, separation velocity, t_f in scaled units."""
        n, vr, separation, t_end = scaled.T
        return Results(n.astype(int), vr * speed, separation * speed, t_end / rate)


#: Variables of hl.sweep that the peers compute as well.
RESULTS = [f.name for f in fields(Results)]


def masses(points: Points) -> tuple[np.ndarray, np.ndarray]:
    return tuple(4.0 / 3.0 * np.pi * DENSITY * r**3 for r in (points.radius_1, points.radius_2))


def impact_speed(points: Points) -> np.ndarray:
    return np.sqrt(2.0 * GRAVITY * (HEIGHT - points.radius_1))


def damping_ratio(restitution: np.ndarray) -> np.ndarray:
    """β/ω0 of the clipped linear dashpot: ε = exp(−(π − 2φ) tan φ), β/ω0 = sin φ, for ε > exp(−2)."""
    target = -np.log(restitution)
    phi = target / np.pi
    for _ in range(30):
        tan = np.tan(phi)
        change = ((np.pi - 2.0 * phi) * tan - target) / ((np.pi - 2.0 * phi) * (1.0 + tan * tan) - 2.0 * tan)
        phi = phi - change
        if np.all(np.abs(change) < 1e-15):
            break
    return np.sin(phi)


def linear(points: Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows κ, d1, d2, G, δ; speed V and rate ω12."""
    m1, m2 = masses(points)
    speed = impact_speed(points)
    rate = np.sqrt(points.stiffness * (m1 + m2) / (m1 * m2))
    kappa = m2 / (m1 + m2)
    d2 = 2.0 * damping_ratio(points.restitution)
    rows = (kappa, d2 / np.sqrt(kappa), d2, GRAVITY / (speed * rate), points.gap * rate / speed)
    return np.ascontiguousarray(np.stack(rows, axis=1)), speed, rate


def viscoelastic(points: Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows κ, c1, c2, G, δ, k1; speed V and rate k12^{2/5} V^{1/5}."""
    m1, m2 = masses(points)
    speed = impact_speed(points)
    k12 = points.elastic[:, 1] * (m1 + m2) / (m1 * m2)
    rate = k12**0.4 * speed**0.2
    c1, c2 = (1.5 * points.dissipative_time * rate[:, None]).T
    k1 = points.elastic[:, 0] / m1 / k12
    rows = (m2 / (m1 + m2), c1, c2, GRAVITY / (speed * rate), points.gap * rate / speed, k1)
    return np.ascontiguousarray(np.stack(rows, axis=1)), speed, rate


def column_linear(points: Points, i: int) -> hl.Column:
    """A point as a column for hl.newton."""
    return hl.Column.paper(
        restitution=points.restitution[i],
        gap=points.gap[i],
        radius_1=points.radius_1[i],
        radius_2=points.radius_2[i],
        stiffness=points.stiffness[i],
    )
