"""One material with the elastic contact of two."""

from __future__ import annotations


def one_material(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    """Young's modulus and Poisson's ratio of one material with the effective modulus E* of two.

    1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂, and E* = E/(2 (1 − ν²)) of one material; ν is the mean.
    """
    effective = 1.0 / sum((1.0 - ratio**2) / modulus for modulus, ratio in (first, second))
    ratio = 0.5 * (first[1] + second[1])
    return 2.0 * (1.0 - ratio**2) * effective, ratio
