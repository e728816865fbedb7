"""What theory says of a homogeneous gas of equal hard spheres or disks.

All of it holds for a fluid without walls, gravity or a mean flow: spheres below φ = 0.49, where freezing sets in, and
disks below 0.70. Temperatures T are in m²/s² as everywhere here: the mean square of one velocity component.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .. import validation
from .system import ParticleSystem

Floats = NDArray[np.float64]

#: Packing fraction at which the fluid ends, by dimension: spheres freeze (Hoover & Ree 1968), disks become hexatic
#: (Bernard & Krauth 2011).
FLUID: Final = {2: 0.70, 3: 0.49}


@dataclass(frozen=True)
class Gas:
    """A gas of equal spheres (``dimension`` 3) or disks (2): ``n`` of them in a box of ``volume`` [m³, m²]."""

    n: int
    radius: float  #: [m]
    mass: float  #: [kg]
    volume: float  #: of the box [m³], in 2-D its area [m²]
    dimension: int

    @property
    def packing_fraction(self) -> float:
        """φ."""
        ball = math.pi * self.radius**2 if self.dimension == 2 else 4.0 / 3.0 * math.pi * self.radius**3
        return self.n * ball / self.volume

    @property
    def contact_value(self) -> float:
        """χ, the pair distribution at contact.

        Spheres: (1 − φ/2)/(1 − φ)³ (Carnahan & Starling, J. Chem. Phys. 51, 635 (1969)), below 0.3 % off in the
        fluid. Disks: (1 − 7φ/16)/(1 − φ)² (Henderson, Mol. Phys. 30, 971 (1975)), below 1 % off up to φ = 0.6.
        """
        phi = self.packing_fraction
        if self.dimension == 2:
            return (1.0 - 7.0 / 16.0 * phi) / (1.0 - phi) ** 2
        return (1.0 - 0.5 * phi) / (1.0 - phi) ** 3

    def collision_rate(self, temperature: Floats | float) -> Floats:
        """Enskog's rate ν of one particle [1/s]: 4√π n σ² χ √T, of disks 2√π n σ χ √T, σ = 2R.

        Source: Chapman & Cowling, The Mathematical Theory of Non-uniform Gases. Exact but for the error of χ in an
        elastic gas; in a granular one as long as velocities stay close to Maxwell's and places uncorrelated.
        """
        sigma, density = 2.0 * self.radius, self.n / self.volume
        cross_section = 2.0 * sigma if self.dimension == 2 else 4.0 * sigma**2
        return math.sqrt(math.pi) * density * cross_section * self.contact_value * np.sqrt(temperature)

    @property
    def mean_free_path(self) -> float:
        """Mean speed over collision rate [m]: 1/(√2 π n σ² χ), of disks 1/(2√2 n σ χ).

        Not to be mixed up with √T/ν, which Lue, J. Chem. Phys. 122, 044513 (2005) tabulates.
        """
        mean_speed = math.sqrt(0.5 * math.pi) if self.dimension == 2 else math.sqrt(8.0 / math.pi)
        return mean_speed / float(self.collision_rate(1.0))

    def pressure(self, temperature: Floats | float, restitution: float = 1.0) -> Floats:
        """p [Pa], of disks [N/m]: n m T (1 + 2^(d−1) φ χ (1 + ε)/2).

        For ε = 1 that is Carnahan & Starling's equation in 3-D, within 0.3 % of simulations, and Henderson's in 2-D,
        within 1 % up to φ = 0.6. The factor (1 + ε)/2: Jenkins & Richman, Arch. Rat. Mech. Anal. 87, 355 (1985).
        """
        collisional = 2.0 ** (self.dimension - 1) * self.packing_fraction * self.contact_value
        excess = collisional * 0.5 * (1.0 + restitution)
        return self.n / self.volume * self.mass * (1.0 + excess) * np.asarray(temperature)

    def cooling(self, time: Floats, temperature: float, restitution: float) -> Floats:
        """Haff's law: T(t) = T(0)/(1 + (1 − ε²) ν(0) t/(2d))², from dT/dt = −(1 − ε²) ν T/d.

        Source: Haff, J. Fluid Mech. 134, 401 (1983). It holds while the gas stays homogeneous: clusters grow sooner
        in large, dense and dissipative systems. The fourth cumulant of the velocities, some per cent, is left out.
        """
        rate = float(self.collision_rate(temperature))
        return temperature / (1.0 + (1.0 - restitution**2) * rate * time / (2.0 * self.dimension)) ** 2


def gas(system: ParticleSystem) -> Gas:
    """The gas that a system is.

    Raises
    ------
    ValueError
        If theory here does not apply to it; says why.
    """
    reason = why_not(system)
    if reason is not None:
        raise ValueError(
            f"system: {reason}, must be a gas of equal particles in a periodic box without gravity"
        )
    return Gas(
        system.n,
        float(system.radius[0]),
        float(system.mass[0]),
        float(np.prod(system.box)),
        system.dimension,
    )


def why_not(system: ParticleSystem) -> str | None:
    """What keeps the formulas from holding for a system; None where they hold."""
    if not isinstance(system, ParticleSystem):
        return f"got {validation.shown(system)}"
    if len(system.boundary) != system.boundary.count("periodic"):
        return "it has walls"
    if system.gravity.any():
        return "it has gravity"
    if np.ptp(system.radius) or np.ptp(system.mass):
        return "its particles differ"
    if system.packing_fraction > FLUID[system.dimension]:
        return f"its packing fraction {system.packing_fraction:.4g} is above {FLUID[system.dimension]} and no fluid’s"
    return None
