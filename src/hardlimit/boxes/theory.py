"""Kinetic theory of a homogeneous gas of equal hard spheres or disks.

The formulas hold for a fluid without walls or gravity, at rest or uniformly sheared (:meth:`Gas.sheared_temperature`):
spheres below freezing at φ = 0.49, disks below 0.70. The temperature T [m²/s²] is the mean square of one velocity
component.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ..support import validation
from .box import UNIT_BALL, Floats
from .system import ParticleSystem

#: Largest packing fraction of the fluid, by dimension: spheres freeze (Hoover & Ree 1968), disks become hexatic
#: (Bernard & Krauth 2011).
FLUID: Final = {2: 0.70, 3: 0.49}

MAX_PARTICLES: Final = 2**62
#: Number of collisions per particle after which a random start is in equilibrium. At packing fractions of 0.3 and 0.4
#: the rate of 1000 elastic spheres was 2.0 and 1.2 times Enskog's during the first quarter of a collision per particle,
#: and within 5 % of it after three.
RELAXED: Final = 3


@dataclass(frozen=True)
class Gas:
    """A homogeneous gas of equal spheres (``dimension`` 3) or disks (2) in a box.

    :func:`gas` makes one from a system.

    Parameters
    ----------
    n : int
        Number of particles.
    radius : float [m]
    mass : float [kg]
    volume : float [m³]
        Volume of the box, in 2-D its area [m²].
    dimension : int
        2 or 3.

    Raises
    ------
    ValueError
        If a value is not positive and finite, or the dimension is neither 2 nor 3.
    """

    n: int
    radius: float  #: [m]
    mass: float  #: [kg]
    volume: float  #: volume of the box [m³], in 2-D its area [m²]
    dimension: int

    def __post_init__(self) -> None:
        checked: dict[str, float] = {
            "n": validation.whole("n", self.n, 1, MAX_PARTICLES),
            "dimension": validation.whole("dimension", self.dimension, 2, 3),
        }
        checked |= {
            name: validation.number(name, getattr(self, name), 0.0) for name in ("radius", "mass", "volume")
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def packing_fraction(self) -> float:
        """Fraction φ of the box that the particles fill, by volume in 3-D and by area in 2-D."""
        return self.n * (UNIT_BALL[self.dimension] * self.radius**self.dimension) / self.volume

    @property
    def contact_value(self) -> float:
        """Pair correlation function at contact, χ.

        Spheres: (1 − φ/2)/(1 − φ)³ (Carnahan & Starling, J. Chem. Phys. 51, 635 (1969)), with an error below 0.3 % in
        the fluid. Disks: (1 − 7φ/16)/(1 − φ)² (Henderson, Mol. Phys. 30, 971 (1975)), with an error below 1 % up to
        φ = 0.6.
        """
        phi = self.packing_fraction
        if self.dimension == 2:
            return (1.0 - 7.0 / 16.0 * phi) / (1.0 - phi) ** 2
        return (1.0 - 0.5 * phi) / (1.0 - phi) ** 3

    def collision_rate(self, temperature: Floats | float) -> Floats:
        """Enskog's collision rate ν of one particle [1/s]: 4√π n σ² χ √T for spheres, 2√π n σ χ √T for disks, σ = 2R.

        Source: Chapman & Cowling, The Mathematical Theory of Non-uniform Gases (1970). In an elastic gas the only error
        is that of χ. In a granular gas the formula holds while velocities are nearly Maxwellian and positions are
        uncorrelated.

        Parameters
        ----------
        temperature : number or array [m²/s²]
            At least 0.

        Raises
        ------
        ValueError
            If a temperature is negative or not finite.
        """
        at = _not_negative("temperature", temperature)
        sigma, density = 2.0 * self.radius, self.n / self.volume
        cross_section = 2.0 * sigma if self.dimension == 2 else 4.0 * sigma**2
        return math.sqrt(math.pi) * density * cross_section * self.contact_value * np.sqrt(at)

    @property
    def mean_free_path(self) -> float:
        """Mean free path [m], mean speed over collision rate: 1/(√2 π n σ² χ) for spheres, 1/(2√2 n σ χ) for disks.

        Lue, J. Chem. Phys. 122, 044513 (2005) tabulates √T/ν instead.
        """
        mean_speed = math.sqrt(0.5 * math.pi) if self.dimension == 2 else math.sqrt(8.0 / math.pi)
        return mean_speed / float(self.collision_rate(1.0))

    def pressure(self, temperature: Floats | float, restitution: float = 1.0) -> Floats:
        """Pressure p = n m T (1 + 2^(d−1) φ χ (1 + ε)/2) [Pa; disks N/m].

        For ε = 1 this is Carnahan & Starling's equation in 3-D, within 0.3 % of simulations, and Henderson's in 2-D,
        within 1 % up to φ = 0.6. Source of the factor (1 + ε)/2: Jenkins & Richman, Arch. Rat. Mech. Anal. 87, 355
        (1985).

        Parameters
        ----------
        temperature : number or array [m²/s²]
            At least 0.
        restitution : float
            ε, in [0, 1].

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        collisional = 2.0 ** (self.dimension - 1) * self.packing_fraction * self.contact_value
        excess = collisional * 0.5 * (1.0 + _restitution(restitution))
        return self.n / self.volume * self.mass * (1.0 + excess) * _not_negative("temperature", temperature)

    def cooling(self, time: Floats | float, temperature: float, restitution: float) -> Floats:
        """Haff's law: T(t) = T(0)/(1 + (1 − ε²) ν(0) t/(2d))², from dT/dt = −(1 − ε²) ν T/d.

        Source: Haff, J. Fluid Mech. 134, 401 (1983). The law holds while the gas is homogeneous; clusters grow sooner
        in large, dense and dissipative systems. The fourth cumulant of the velocities, a few per cent, is neglected.

        Parameters
        ----------
        time : number or array [s]
        temperature : float [m²/s²]
            T(0), at least 0.
        restitution : float
            ε, in [0, 1].

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        start = validation.number("temperature", temperature, 0.0, lowest_allowed=True)
        after = _not_negative("time", time)
        lost = (1.0 - _restitution(restitution) ** 2) * float(self.collision_rate(start))
        return start / (1.0 + lost * after / (2.0 * self.dimension)) ** 2

    def heated_temperature(self, power: float, restitution: float) -> float:
        """Granular temperature T [m²/s²] of a gas heated by white noise: its dissipation equals the power.

        (1 − ε²) ν N m T/2 · (1 + 3a₂/16) = power, with Enskog's ν ∝ √T and the fourth cumulant
        a₂ = 16(1 − ε)(1 − 2ε²)/(73 + 56d − 24dε − 105ε + 30(1 − ε)ε²). Source: van Noije & Ernst, Granular Matter 1, 57
        (1998). Simulated temperatures of hard spheres differ by less than 3 % for ε ≥ 0.4 and φ ≤ 0.1; in dense gases
        correlations of the velocities raise T further.

        Parameters
        ----------
        power : float [W]
            Of all particles together, at least 0.
        restitution : float
            ε, in [0, 1).

        Raises
        ------
        ValueError
            If a value is outside its range.
        """
        watts = validation.number("power", power, 0.0, lowest_allowed=True)
        e = validation.number("restitution", restitution, 0.0, 1.0, lowest_allowed=True)
        d = self.dimension
        below = 73.0 + 56.0 * d - 24.0 * d * e - 105.0 * e + 30.0 * (1.0 - e) * e * e
        a2 = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / below
        lost = 0.5 * (1.0 - e * e) * self.n * self.mass * float(self.collision_rate(1.0))
        return float((watts / (lost * (1.0 + 3.0 / 16.0 * a2))) ** (2.0 / 3.0))

    def sheared_temperature(self, shear_rate: float, restitution: float) -> float:
        """Granular temperature T [m²/s²] of spheres in steady simple shear: the work of the shear stress is dissipated.

        T = (σ γ̇)² f₂/f₅ with the diameter σ, η = (1 + ε)/2, f₅ = (48/√π) η(1 − η) φ²χ and
        f₂ = 5√π/(96 η(2 − η)) · (1 + (8/5)ηφχ)(1/χ + (8/5)η(3η − 2)φ) + (8/(5√π)) η φ²χ.
        Source: Lun, Savage, Jeffrey & Chepurniy, J. Fluid Mech. 140, 223 (1984). Valid for nearly elastic spheres in a
        fluid, ε ≥ 0.8: at this order all normal stresses are equal.

        Parameters
        ----------
        shear_rate : float [1/s]
            γ̇, at least 0.
        restitution : float
            ε, in [0.5, 1).

        Raises
        ------
        ValueError
            If a value is outside its range, or the particles are disks.
        """
        if self.dimension != 3:
            raise ValueError("shear_rate: the theory is that of spheres, not of disks")
        rate = validation.number("shear_rate", shear_rate, 0.0, lowest_allowed=True)
        e = validation.number("restitution", restitution, 0.5, 1.0, lowest_allowed=True)
        eta, phi, chi = 0.5 * (1.0 + e), self.packing_fraction, self.contact_value
        root = math.sqrt(math.pi)
        kinetic = 5.0 * root / (96.0 * eta * (2.0 - eta)) * (1.0 + 1.6 * eta * phi * chi)
        kinetic *= 1.0 / chi + 1.6 * eta * (3.0 * eta - 2.0) * phi
        f2 = kinetic + 1.6 / root * eta * phi * phi * chi
        f5 = 48.0 / root * eta * (1.0 - eta) * phi * phi * chi
        return (2.0 * self.radius * rate) ** 2 * f2 / f5


def _not_negative(name: str, values: Floats | float) -> Floats:
    most = 1e201  # more than the temperature of any speeds up to box.LARGEST
    limits: dict[str, Any] = {"lowest": 0.0, "lowest_allowed": True, "highest": most, "highest_allowed": True}
    return validation.array(name, values, **limits, ndim=None, empty_allowed=True)


def _restitution(value: float) -> float:
    return validation.number("restitution", value, 0.0, 1.0, lowest_allowed=True, highest_allowed=True)


def gas(system: ParticleSystem) -> Gas:
    """The gas of equal particles in a system.

    The theory holds for a fluid: spheres freeze at φ = 0.49 (Hoover & Ree 1968), disks become hexatic at 0.70 (Bernard
    & Krauth 2011).

    Parameters
    ----------
    system : ParticleSystem

    Raises
    ------
    ValueError
        If the theory does not apply to this system; says why.
    """
    reason = why_not(system)
    if reason is not None:
        raise ValueError(
            f"system: {reason}, must be a gas of equal particles in a periodic box without gravity"
        )
    radius, mass = float(system.radius[0]), float(system.mass[0])
    return Gas(system.n, radius, mass, system.domain.volume, system.dimension)


def why_not(system: ParticleSystem) -> str | None:
    """The reason why the theory does not apply to a system; None if it applies."""
    if not isinstance(system, ParticleSystem):
        return f"got {validation.shown(system)}"
    if "wall" in system.boundary:
        return "it has walls"
    if "lees-edwards" in system.boundary:
        return "it is sheared"
    if system.gravity.any():
        return "it has gravity"
    if system.thermostat is not None:
        return "it has a thermostat"
    if np.ptp(system.radius) or np.ptp(system.mass):
        return "its particles differ"
    if system.packing_fraction > FLUID[system.dimension]:
        return f"its packing fraction {system.packing_fraction:.4g} is above {FLUID[system.dimension]}, that of a fluid"
    return None
