"""Means over the collisions of a gas: what a rule or a contact with friction does to Maxwellian velocities and spins.

The components of the surface velocity g of a pair are normal distributed, those along the surfaces with a variance λ
times that along the normal. Collisions occur in proportion to g_n. Then tan γ = √λ tan α with u = sin²α, where u is
uniform for spheres and has the density 1/(2√u) for disks, whose g_t has one component. In means of g_t² the density is
2u or 3√u/2. λ = 1 + θ/q with the temperature ratio θ of rotation and translation and the inertia factor q.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Numbers that stand for infinity: a slope K of Coulomb's limit, and its square over λ(1 + β0)².
STEEPEST: Final = 1e150
LARGEST: Final = 1e300
#: Ends of the first panels of α in an adaptive quadrature: grains may stick near 0 only, or slide near π/2 only, and β
#: may be unknown at 0 and at π/2. Points in each, relative precision, and how often panels are halved.
NEAR: Final = np.array([1e-9, *0.25 ** np.arange(12.0, 0.0, -1.0)])
PANELS: Final = 0.5 * math.pi * np.array([*NEAR, 0.4, 0.55, *(1.0 - NEAR[::-1])])
POINTS: Final = 10
PRECISION: Final = 1e-11
HALVINGS: Final = 40


class Means(NamedTuple):
    """Means over collisions, over the mean of g_t²; of the last over all collisions."""

    first: float  #: of (1 + β) g_t²
    second: float  #: of (1 + β)² g_t²
    sliding_share: float  #: share of the collisions that slide; NaN if this is unknown


def density(u: Floats, dimension: int) -> Floats:
    """The density of u in means of g_t²."""
    return 2.0 * u if dimension == 3 else 1.5 * np.sqrt(u)


def sticking_parts(c: float, dimension: int) -> tuple[float, float]:
    """Integrals of the density, and of the density over tan α, over collisions with tan² α < c."""
    stuck = c / (1.0 + c)
    if dimension == 2:
        return stuck**1.5, -math.expm1(-1.5 * math.log1p(c))
    from scipy import special  # which a drop must not wait for

    return stuck * stuck, 0.25 * math.pi * float(special.betainc(1.5, 1.5, stuck))


def _sliding_parts(c: float, dimension: int) -> tuple[float, float]:
    """Integrals of the density over tan α and over tan² α, over collisions with tan² α > c."""
    slid = 1.0 / (1.0 + c)
    if dimension == 2:
        root = math.sqrt(c * slid)
        return slid**1.5, (slid / (1.0 + root)) ** 2 * (2.0 + root)
    from scipy import special

    return 0.25 * math.pi * float(special.betainc(1.5, 1.5, slid)), slid * slid


def sliding_share(tangent: float, variance_ratio: float, dimension: int) -> float:
    """Share of the collisions with tan γ above ``tangent``."""
    if math.isinf(tangent):
        return 0.0
    c = min((tangent / math.sqrt(variance_ratio)) ** 2, LARGEST) if tangent < STEEPEST else LARGEST
    slid = 1.0 / (1.0 + c)
    return slid if dimension == 3 else slid / (1.0 + math.sqrt(c * slid))


def walton_means(one_plus_beta: float, slope: float, variance_ratio: float, dimension: int) -> Means:
    """Means under the rule 1 + β = min(1 + β0, K/tan γ).

    Parameters
    ----------
    one_plus_beta : float
        1 + β0.
    slope : float
        K = (m_n/m_t) μ (1 + ε), 0 to infinity.
    variance_ratio : float
        λ.
    dimension : int
        3 for spheres, 2 for disks.

    Notes
    -----
    Rule: Walton, in Particulate Two-Phase Flow (1993), p. 884. With c = [K/(1 + β0)]²/λ collisions of spheres slide at
    u > c/(1 + c).
    """
    if one_plus_beta == 0.0:
        return Means(0.0, 0.0, 0.0)
    k = min(slope, STEEPEST)
    c = min((k / one_plus_beta) ** 2 / variance_ratio, LARGEST) if k / one_plus_beta < STEEPEST else LARGEST
    stuck, _ = sticking_parts(c, dimension)
    first, second = _sliding_parts(c, dimension)
    scaled = k / math.sqrt(variance_ratio)
    return Means(
        one_plus_beta * stuck + scaled * first,
        one_plus_beta**2 * stuck + scaled * (scaled * second),
        sliding_share(slope / one_plus_beta, variance_ratio, dimension),
    )


def means(
    beta: Callable[[Floats], Floats], variance_ratio: float, dimension: int, slides_beyond: float = math.nan
) -> Means:
    """Means for any β(tan γ), by Lobatto quadrature on panels that are halved until their sum no longer changes.

    Points at both ends of a panel see a kink that lies between an end and the next point.

    Parameters
    ----------
    beta : callable
        β at each tan γ of an array.
    variance_ratio : float
        λ.
    dimension : int
        3 for spheres, 2 for disks.
    slides_beyond : float, optional
        tan γ beyond which collisions slide.
    """
    root = math.sqrt(variance_ratio)
    highest = np.polynomial.Legendre.basis(POINTS - 1)
    nodes = np.array([-1.0, *highest.deriv().roots().real, 1.0])
    weights = 2.0 / (POINTS * (POINTS - 1) * highest(nodes) ** 2)

    def integrals(edges: Floats) -> Floats:
        """Both means over each panel."""
        half = 0.5 * (edges[:, 1:] - edges[:, :1])
        alpha = edges[:, :1] + half * (1.0 + nodes)
        mass = density(np.sin(alpha) ** 2, dimension) * np.sin(2.0 * alpha) * half * weights
        change = 1.0 + beta(root * np.tan(alpha).ravel()).reshape(alpha.shape)
        return np.stack([np.sum(mass * change, axis=1), np.sum(mass * change * change, axis=1)])

    panels = np.stack([PANELS[:-1], PANELS[1:]], axis=1)
    coarse, total = integrals(panels), np.zeros(2)
    tolerance = PRECISION * np.abs(coarse).sum(axis=1, keepdims=True) + np.finfo(float).tiny
    for _ in range(HALVINGS):
        middle = panels.mean(axis=1)
        halves = np.stack([panels[:, 0], middle, middle, panels[:, 1]], axis=1).reshape(-1, 2)
        fine = integrals(halves)
        sums = fine.reshape(2, -1, 2).sum(axis=2)
        open_ = (np.abs(sums - coarse) > tolerance).any(axis=0)
        total += sums[:, ~open_].sum(axis=1)
        panels, coarse = halves[np.repeat(open_, 2)], fine[:, np.repeat(open_, 2)]
        if not open_.any():
            break
    first, second = (total + coarse.sum(axis=1)).tolist()
    share = math.nan if math.isnan(slides_beyond) else sliding_share(slides_beyond, variance_ratio, dimension)
    return Means(first, second, share)


def table_means(tangents: Floats, beta: Floats, variance_ratio: float, dimension: int) -> Means:
    """Means for β at each of many tan γ, whose logarithms are equally spaced and reach beyond all that matter.

    The rule of midpoints: a thousandth of the time of :func:`means`, with an error of about 1e-4 by kinks of β.
    """
    u = tangents**2 / (variance_ratio + tangents**2)
    spacing = math.log(tangents[-1] / tangents[0]) / (len(tangents) - 1)
    mass = density(u, dimension) * 2.0 * u * (1.0 - u) * spacing
    change = mass * (1.0 + beta)
    return Means(float(change.sum()), float(change @ (1.0 + beta)), math.nan)
