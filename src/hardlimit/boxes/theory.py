"""Kinetic theory of a homogeneous gas of equal hard spheres or disks.

The formulas hold for a fluid without walls or gravity, at rest or uniformly sheared (:meth:`Gas.sheared_temperature`):
spheres below freezing at φ = 0.49, disks below 0.70. The temperature T [m²/s²] is the mean square of one velocity
component, the rotational temperature T_r [m²/s²] that of one component of the spin times I/m.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from ..contact import maxwellian
from ..contact.balls import Ball
from ..contact.contact import Law
from ..contact.maxwellian import Means
from ..support import validation
from . import spins, steady_shear
from .box import LARGEST, UNIT_BALL, Floats
from .system import ParticleSystem

#: Largest packing fraction of the fluid, by dimension: spheres freeze (Hoover & Ree 1968), disks become hexatic
#: (Bernard & Krauth 2011).
FLUID: Final = {2: 0.70, 3: 0.49}

MAX_PARTICLES: Final = 2**62
#: Number of collisions per particle after which a random start is in equilibrium. At packing fractions of 0.3 and 0.4
#: the rate of 1000 elastic spheres was 2.0 and 1.2 times Enskog's during the first quarter of a collision per particle,
#: and within 5 % of it after three.
RELAXED: Final = 3
#: Temperature ratios θ among which those of steady states are searched, and the relative precision of these.
RATIOS: Final = np.geomspace(1e-12, 1e12, 97)
PRECISION: Final = 1e-12
#: tan γ at which β is tabulated for a sheared gas.
TANGENTS: Final = np.exp(np.linspace(-12.0, 12.0, 601))


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
    inertia_factor : float, optional
        q in the moment of inertia q m R², in [1e-6, 1]; by default 2/5 for spheres, 1/2 for disks.

    Raises
    ------
    ValueError
        If a value is not positive and finite, the dimension is neither 2 nor 3, or the inertia factor is outside its
        range.
    """

    n: int
    radius: float  #: [m]
    mass: float  #: [kg]
    volume: float  #: volume of the box [m³], in 2-D its area [m²]
    dimension: int
    inertia_factor: float = None  # type: ignore[assignment]  #: q in the moment of inertia q m R²

    def __post_init__(self) -> None:
        checked: dict[str, float] = {
            "n": validation.whole("n", self.n, 1, MAX_PARTICLES),
            "dimension": validation.whole("dimension", self.dimension, 2, 3),
        }
        checked |= {
            name: validation.number(name, getattr(self, name), 0.0) for name in ("radius", "mass", "volume")
        }
        q = self.inertia_factor
        if q is None:
            q = float(spins.solid(1, self.dimension)[0])
        limits: dict[str, Any] = {"lowest_allowed": True, "highest_allowed": True}
        checked["inertia_factor"] = validation.number(
            "inertia_factor", q, spins.SMALLEST, spins.HIGHEST, **limits
        )
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
        a2 = _heated_cumulant(e, self.dimension)
        lost = 0.5 * (1.0 - e * e) * self.n * self.mass * float(self.collision_rate(1.0))
        return float((watts / (lost * (1.0 + 3.0 / 16.0 * a2))) ** (2.0 / 3.0))

    def sheared_temperature(self, shear_rate: float, restitution: float) -> float:
        """Granular temperature T [m²/s²] of spheres in steady simple shear: the work of the shear stress is dissipated.

        T = (σ γ̇)² f₂/f₅ with the diameter σ, η = (1 + ε)/2, f₅ = (48/√π) η(1 − η) φ²χ and
        f₂ = 5√π/(96 η(2 − η)) · (1 + (8/5)ηφχ)(1/χ + (8/5)η(3η − 2)φ) + (8/(5√π)) η φ²χ.
        Source: Lun, Savage, Jeffrey & Chepurniy, J. Fluid Mech. 140, 223 (1984). Valid for nearly elastic spheres in a
        fluid, ε ≥ 0.8: at this order all normal stresses are equal. :meth:`RotatingGas.sheared_state` has them, and T
        at larger shear.

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
        rate = validation.number("shear_rate", shear_rate, 0.0, LARGEST, lowest_allowed=True)
        e = validation.number("restitution", restitution, 0.5, 1.0, lowest_allowed=True)
        eta, phi, chi = 0.5 * (1.0 + e), self.packing_fraction, self.contact_value
        root = math.sqrt(math.pi)
        kinetic = 5.0 * root / (96.0 * eta * (2.0 - eta)) * (1.0 + 1.6 * eta * phi * chi)
        kinetic *= 1.0 / chi + 1.6 * eta * (3.0 * eta - 2.0) * phi
        f2 = kinetic + 1.6 / root * eta * phi * phi * chi
        f5 = 48.0 / root * eta * (1.0 - eta) * phi * phi * chi
        return (2.0 * self.radius * rate) ** 2 * f2 / f5

    def rotating(
        self,
        restitution: float | None = None,
        friction: float | None = None,
        tangential_restitution: float | Callable[[Floats], Floats] | None = None,
        *,
        law: Law | None = None,
        speed: float = 1.0,
    ) -> RotatingGas:
        """The gas of rough or frictional particles, whose collisions exchange energy of translation and rotation.

        Parameters
        ----------
        restitution : float
            ε, in [0, 1]. Give exactly one of ``restitution`` and ``law``.
        friction : float, optional
            Coefficient of friction μ ≥ 0: 1 + β is at most (1 + 1/q) μ (1 + ε)/tan γ at the angle of impact γ.
            ``math.inf`` unless given: rough particles, which never slide.
        tangential_restitution : float or callable
            β of collisions that do not slide, in [−1, 1]; or a function that returns β at each tan γ of an array, then
            without ``friction``.
        law : Law
            Its contacts give ε and β(tan γ), in the limit of a fixed normal.
        speed : float, default 1 [m/s]
            Impact speed at which the law gives ε and β; contacts of linear laws do not depend on it.

        Raises
        ------
        ValueError
            If an argument is missing or outside its range, or two exclude each other.

        Notes
        -----
        Source of the rule: Walton, in Particulate Two-Phase Flow (1993), p. 884.

        Examples
        --------
        >>> gas = hl.boxes.theory.Gas(1000, 1e-3, 1e-5, 2e-5, 3)
        >>> rough = gas.rotating(0.9, float("inf"), 0.5)
        >>> round(rough.cooling_states()[0].temperature_ratio, 4)
        0.8671
        """
        if validation.exactly_one(restitution=restitution, law=law) == "law":
            for name, value in (("friction", friction), ("tangential_restitution", tangential_restitution)):
                if value is not None:
                    shown = validation.shown(value)
                    raise ValueError(
                        f"{name}: got {shown}, must be left out with a law, whose friction= says it"
                    )
            return _of_law(self, law, speed)
        e = validation.number("restitution", restitution, 0.0, 1.0, lowest_allowed=True, highest_allowed=True)
        return _of_rule(self, e, friction, tangential_restitution)

    def critical_friction(
        self, restitution: float, tangential_restitution: float, temperature_ratio: float = 1.0
    ) -> float:
        """Coefficient of friction μ_c below which a cooling gas keeps its rotation: T_r/T grows without bound.

        Above it T_r/T tends to that of one of the :meth:`RotatingGas.cooling_states`; in theory at any start if
        μ > √((1 − ε)/(1 + ε)), since the sliding of fast spins then heats translation more than collisions cool it.

        Parameters
        ----------
        restitution : float
            ε, in [0, 1].
        tangential_restitution : float
            β of collisions that do not slide, in (−1, 1].
        temperature_ratio : float, default 1
            T_r/T at the start, ≥ 0.

        Raises
        ------
        ValueError
            If a value is outside its range.

        Notes
        -----
        Source: Walton's rule (1993) for Maxwellian velocities; located by halving, to 1e-9. The bound is the limit of
        dT/dt = (ν/d)[μ²(1 + ε)² − (1 − ε²)] T for θ → ∞.
        """
        e = _restitution(restitution)
        limits: dict[str, Any] = {"lowest_allowed": False, "highest_allowed": True}
        beta = validation.number("tangential_restitution", tangential_restitution, -1.0, 1.0, **limits)
        start = validation.number("temperature_ratio", temperature_ratio, 0.0, lowest_allowed=True)
        low, high = 0.0, math.sqrt((1.0 - e) / (1.0 + e))
        while high - low > 1e-9:
            middle = 0.5 * (low + high)
            gas_of = _of_rule(self, e, middle, beta)
            low, high = (low, middle) if gas_of.has_limit(start) else (middle, high)
        return high


class MeanCollision(NamedTuple):
    """Means over the collisions of a rotating gas; returned by :meth:`RotatingGas.mean_collision`.

    g_t is the tangential velocity of the surfaces.
    """

    exchange: float  #: ⟨(1 + β) g_t²⟩/T
    squared_exchange: float  #: ⟨(1 + β)² g_t²⟩/T
    sliding_share: float  #: share of sliding collisions; NaN if β is a function or has no spring
    energy_change: float  #: change of the energy of translation and rotation over m T
    rotational_energy_change: float  #: change of the rotational energy over m T


class CoolingState(NamedTuple):
    """A steady temperature ratio of a cooling gas; returned by :meth:`RotatingGas.cooling_states`."""

    temperature_ratio: float  #: θ = T_r/T
    is_stable: bool  #: whether ratios close to it tend to it
    rate: float  #: d ln T/d(ν t), that of T_r too
    sliding_share: float  #: share of sliding collisions; NaN if β is a function or has no spring


class Heat(NamedTuple):
    """What a thermostat does to a temperature: dT/dt = supplied − rate T.

    :meta private:
    """

    supplied: float = 0.0  #: [m²/s³]
    rate: float = 0.0  #: of its drag [1/s]


class HeatedState(NamedTuple):
    """The steady state of a heated gas.

    :meta private:
    """

    temperature: float  #: T [m²/s²]
    temperature_ratio: float  #: θ = T_r/T


class ShearedState(NamedTuple):
    """The steady state of a sheared gas; returned by :meth:`RotatingGas.sheared_state`."""

    temperature: float  #: T [m²/s²]
    temperature_ratio: float  #: θ = T_r/T of the spins about their mean; NaN without friction
    pressure_tensor: Floats  #: (3, 3) [Pa]; the flow is along x, its gradient along y


#: Heat of a thermostat that leaves spins alone.
NO_HEAT: Final = Heat()


@dataclass(frozen=True)
class RotatingGas:
    """A homogeneous gas of particles that rotate; returned by :meth:`Gas.rotating`.

    T = ⟨v_x²⟩ and T_r = (I/m)⟨ω_x²⟩ [m²/s²]; θ = T_r/T is the temperature ratio. Velocities and spins are taken as
    Maxwellian and uncorrelated, which makes θ 1 to 5 % too large at ε = 0.9.

    Notes
    -----
    Rough particles: Huthmann & Zippelius, Phys. Rev. E 56, R6275 (1997). Friction: Herbst, Huthmann & Zippelius,
    Granular Matter 2, 211 (2000).
    """

    gas: Gas  #: the same without rotation
    restitution: float  #: ε
    _means: Callable[[float], Means] = field(repr=False)  #: of (1 + β) g_t² and (1 + β)² g_t² by the ratio λ
    _grip: Callable[[Floats], Floats] = field(repr=False)  #: 1 + β at each tan γ

    def mean_collision(self, temperature_ratio: float) -> MeanCollision:
        """Means over the collisions at a temperature ratio θ.

        Per collision the energy changes by ΔE = −(1 − ε²) − [q/(4(1 + q))](2M₁ − M₂) and that of rotation by
        ΔE_r = (q/4)[−2pM₁/(1 + q) + M₂/(1 + q)²], in units of m T, with M_k = ⟨(1 + β)^k g_t²⟩/T, λ = 1 + θ/q and
        p = (θ/q)/λ, the share of rotation in g_t².

        Parameters
        ----------
        temperature_ratio : float
            θ ≥ 0.

        Raises
        ------
        ValueError
            If θ is negative or not finite, or β is not a finite number at each angle.

        Notes
        -----
        Source: the collision rule, with g_t² χ²-distributed with d − 1 degrees of freedom, as for rough particles in
        Huthmann & Zippelius (1997).
        """
        theta = validation.number("temperature_ratio", temperature_ratio, 0.0, lowest_allowed=True)
        q, e = self.gas.inertia_factor, self.restitution
        ratio = 1.0 + theta / q
        first, second, share = self._means(ratio)
        scale = 2.0 * (self.gas.dimension - 1) * ratio  # ⟨g_t²⟩/T
        m1, m2 = scale * first, scale * second
        energy = -(1.0 - e * e) - 0.25 * q / (1.0 + q) * (2.0 * m1 - m2)
        rotation = 0.25 * q / (1.0 + q) * (m2 / (1.0 + q) - 2.0 * theta / q / ratio * m1)
        return MeanCollision(m1, m2, share, energy, rotation)

    def rates(self, temperature_ratio: float) -> tuple[float, float]:
        """dT/d(ν t)/T and dT_r/d(ν t)/T at a temperature ratio θ.

        They are (ΔE − ΔE_r)/d and ΔE_r/d_r, with d_r = 3 axes of rotation for spheres and 1 for disks. For rough
        particles (constant β) dT/dt = −(ν/d){[(1 − ε²) + 2(d − 1)η(1 − η)] T − 2(d − 1)(η²/q) T_r} and
        dT_r/dt = (2(d − 1)ν/d_r){(η²/q) T − (η/q)(1 − η/q) T_r}, η = q(1 + β)/(2(1 + q)).

        Parameters
        ----------
        temperature_ratio : float
            θ ≥ 0.

        Raises
        ------
        ValueError
            As for :meth:`mean_collision`.

        Notes
        -----
        Source: Huthmann & Zippelius (1997).
        """
        mean = self.mean_collision(temperature_ratio)
        rotation = mean.rotational_energy_change
        axes = spins.AXES_OF_ROTATION[self.gas.dimension]
        return (mean.energy_change - rotation) / self.gas.dimension, rotation / axes

    def cooling_states(self) -> tuple[CoolingState, ...]:
        """The temperature ratios that a cooling gas keeps, in ascending order, where T and T_r decay at one rate.

        Rough spheres have one, θ = h + √(1 + h²), h = (1 + q)/(2q(1 + β)) [(1 + q)(1 − ε²)/(1 + β) − (1 − q)(1 − β)]
        (Huthmann & Zippelius 1997). With friction there may be a second, unstable one, beyond which T_r/T grows without
        bound, or none at all (Herbst, Huthmann & Zippelius 2000). With friction a state lasts for tens of collisions of
        each particle, until a few that keep their spins hold most of the rotational energy (:doc:`/theory`). Ratios are
        searched from 1e-12 to 1e12.

        Raises
        ------
        ValueError
            If β is not a finite number at each angle.
        """
        theta = self._roots(self._drift)
        return tuple(self._state(ratio) for ratio in theta)

    def heated_temperature_ratio(self) -> float:
        """θ of a gas heated by white noise on its velocities: rotation gains from collisions as much as it loses.

        q(1 + β)/(1 + 2q − β) for rough particles (constant β). NaN if rotation gains or loses at any θ.

        Raises
        ------
        ValueError
            If β is not a finite number at each angle.

        Notes
        -----
        Source of the theory for heated disks: Herbst, Cafiero, Zippelius, Herrmann & Luding, Phys. Fluids 17, 107102
        (2005).
        """
        theta = self._roots(lambda ratio: self.rates(ratio)[1] / ratio)
        return theta[0] if theta else math.nan

    def heated_temperature(self, power: float) -> float:
        """T [m²/s²] of a gas heated by white noise on its velocities: its dissipation equals the power.

        (ν/2) N m T (−ΔE) = power at :meth:`heated_temperature_ratio`, where the loss along the normal, 1 − ε², has the
        factor 1 + 3a₂/16 of :meth:`Gas.heated_temperature`, which this is for smooth particles.

        Parameters
        ----------
        power : float [W]
            Of all particles together, at least 0.

        Raises
        ------
        ValueError
            If the power is outside its range, β is not a finite number at each angle, or nothing is dissipated.

        Notes
        -----
        As for :meth:`heated_temperature_ratio`.
        """
        watts = validation.number("power", power, 0.0, lowest_allowed=True)
        theta, e = self.heated_temperature_ratio(), self.restitution
        mean = self.mean_collision(0.0 if math.isnan(theta) else theta)
        lost = -mean.energy_change + 3.0 / 16.0 * _heated_cumulant(e, self.gas.dimension) * (1.0 - e * e)
        if not lost > PRECISION:
            raise ValueError("restitution: collisions dissipate nothing, must be those of a gas that cools")
        lost *= 0.5 * self.gas.n * self.gas.mass * float(self.gas.collision_rate(1.0))
        return float((watts / lost) ** (2.0 / 3.0))

    def sheared_state(self, shear_rate: float) -> ShearedState:
        """The steady state of spheres in simple shear: temperature, spins and stresses, normal ones included.

        Collisions keep all second moments of the velocities, the mean spin and the rotational energy as they are.
        Velocities are Gaussian with any second moments, and the relative velocity of a pair is also that of the flow
        across a diameter, to all orders in the shear rate.

        Parameters
        ----------
        shear_rate : float [1/s]
            γ̇ of a flow along x with its gradient along y, > 0.

        Raises
        ------
        ValueError
            If the shear rate is outside its range, the particles are disks or fill the box, β is not a finite number at
            each angle, nothing is dissipated, or no steady state is found.

        Notes
        -----
        Source of the theory, for smooth disks: Jenkins & Richman, J. Fluid Mech. 192, 313 (1988). T of hard
        spheres differed by −5 to +4 % in 16 gases with friction and by 0 to +8 % in 6 without (:doc:`/driven_gases`).

        Examples
        --------
        >>> gas = hl.boxes.theory.Gas(1000, 1e-3, 1e-5, 2e-5, 3)
        >>> state = gas.rotating(0.9, 0.5, 0.4).sheared_state(100.0)
        >>> macroscopic = -state.pressure_tensor[0, 1] / state.pressure_tensor[1, 1]
        >>> f"T_r/T = {state.temperature_ratio:.2f}, friction of the flow {macroscopic:.2f}"
        'T_r/T = 0.40, friction of the flow 0.60'
        """
        if self.gas.dimension != 3:
            raise ValueError("shear_rate: the theory is that of spheres, not of disks")
        if not self.gas.packing_fraction < 1.0:
            raise ValueError(f"volume: got {self.gas.volume:.6g}, must be more than that of the particles")
        flow = validation.number("shear_rate", shear_rate, 0.0, LARGEST)
        ratio = self.heated_temperature_ratio()
        near = ratio if ratio > 0.0 else float(RATIOS[0])  # not NaN; θ for a start
        loss = -self.mean_collision(near).energy_change
        if not loss > PRECISION:
            raise ValueError("restitution: collisions dissipate nothing, must be those of a gas that cools")
        n, diameter = self.gas.n / self.gas.volume, 2.0 * self.gas.radius
        # Contacts of a law take longer than all else.
        grip = interpolated(TANGENTS, self._grip(TANGENTS))
        rule = steady_shear.Rule(self.restitution, grip, self.gas.inertia_factor)
        try:
            state = steady_shear.steady(n * diameter**3 * self.gas.contact_value, rule, loss, near)
        except ArithmeticError:
            raise ValueError(
                f"restitution: got {self.restitution:.6g}, with which no steady shear was found at φ = "
                f"{self.gas.packing_fraction:.3g}, must dissipate more"
            ) from None
        unit = (diameter * flow) ** 2
        return ShearedState(
            temperature=unit * state.temperature,
            temperature_ratio=state.temperature_ratio,
            pressure_tensor=n * self.gas.mass * unit * state.pressure,
        )

    def sheared_temperature(self, shear_rate: float) -> float:
        """T [m²/s²] of spheres in steady simple shear, that of :meth:`sheared_state`; 0 at rest.

        Parameters
        ----------
        shear_rate : float [1/s]
            γ̇, at least 0.

        Raises
        ------
        ValueError
            As for :meth:`sheared_state`.
        """
        rate = validation.number("shear_rate", shear_rate, 0.0, LARGEST, lowest_allowed=True)
        return rate * rate * self.sheared_state(1.0).temperature

    def heated_state(self, translation: Heat, rotation: Heat = NO_HEAT) -> HeatedState | None:
        """The steady state of a gas whose velocities and spins are heated; None if there is none.

        Both temperatures gain from the thermostat what :meth:`rates` takes. For each θ the balance of the whole energy
        gives T, and that of rotation decides on θ. Without drag the loss along the normal has the factor
        1 + 3a₂/16, as in :meth:`heated_temperature`.

        :meta private:
        """
        from scipy import optimize

        d, axes, e = self.gas.dimension, spins.AXES_OF_ROTATION[self.gas.dimension], self.restitution
        supplied = d * translation.supplied + axes * rotation.supplied
        unit = float(self.gas.collision_rate(1.0))
        further = 0.0 if translation.rate else 3.0 / 16.0 * _heated_cumulant(e, d) * (1.0 - e * e)

        def temperature(theta: float) -> float:
            loss = further - self.mean_collision(theta).energy_change
            drag = d * translation.rate + axes * rotation.rate * theta
            if loss > PRECISION:
                root = float(np.cbrt(supplied / (loss * unit)))  # √T without drag
                root *= root_with_drag(drag * root * root / supplied)
                return root * root
            return supplied / drag if loss > -PRECISION and drag > 0.0 else math.nan

        def excess(logarithm: float) -> float:
            """What rotation gains, over what is supplied in all."""
            theta = math.exp(logarithm)
            t = temperature(theta)
            gained = self.rates(theta)[1] * unit * t * math.sqrt(t)
            gained += rotation.supplied - rotation.rate * theta * t
            return gained / supplied

        if not 0.0 < supplied < math.inf:
            return None
        low, high = (math.log(float(RATIOS[end])) for end in (0, -1))
        first, last = excess(low), excess(high)
        if first > 0.0 > last:
            theta = math.exp(optimize.brentq(excess, low, high, xtol=PRECISION))
        elif first <= 0.0:  # friction too weak to turn them
            theta = 0.0
        else:
            return None
        t = temperature(theta)
        return HeatedState(t, theta) if 0.0 < t < math.inf else None

    def cooling(
        self, time: Floats | float, temperature: float, rotational_temperature: float
    ) -> tuple[Floats, Floats]:
        """T and T_r [m²/s²] of a cooling gas, from :meth:`rates` with Enskog's collision rate.

        Parameters
        ----------
        time : number or array [s]
            At least 0.
        temperature : float [m²/s²]
            T at the start, > 0.
        rotational_temperature : float [m²/s²]
            T_r at the start, ≥ 0.

        Returns
        -------
        tuple of two arrays
            T and T_r, of the shape of ``time``.

        Raises
        ------
        ValueError
            If a value is outside its range, or β is not a finite number at each angle.

        Notes
        -----
        Source: Luding, Huthmann, McNamara & Zippelius, Phys. Rev. E 58, 3416 (1998). Integrated to a relative error of
        about 1e-8.
        """
        after = _not_negative("time", time)
        start = validation.number("temperature", temperature, 0.0)
        spinning = validation.number(
            "rotational_temperature", rotational_temperature, 0.0, lowest_allowed=True
        )
        times, order = np.unique(after.ravel() * float(self.gas.collision_rate(start)), return_inverse=True)

        def derivative(_: float, state: Floats) -> Floats:
            logarithm, theta = state.tolist()
            translation, rotation = self.rates(max(theta, 0.0))
            return math.exp(0.5 * logarithm) * np.array([translation, rotation - theta * translation])

        states = np.array([[0.0], [spinning / start]])
        if times.size and times[-1] > 0.0:
            from scipy import integrate  # which other runs must not wait for

            span = (0.0, float(times[-1]))
            precision = {"rtol": 1e-9, "atol": 1e-12, "method": "DOP853"}
            states = integrate.solve_ivp(derivative, span, states[:, 0], t_eval=times, **precision).y
        translational = start * np.exp(states[0])
        shape = after.shape
        return translational[order].reshape(shape), (translational * states[1])[order].reshape(shape)

    def has_limit(self, temperature_ratio: float) -> bool:
        """Whether θ of a cooling gas that starts at this ratio tends to a finite one.

        :meta private:
        """
        if self._drift(max(temperature_ratio, float(RATIOS[0]))) <= 0.0:
            return True
        return any(ratio >= temperature_ratio for ratio in self._roots(self._drift))

    def _drift(self, theta: float) -> float:
        """d ln θ/d(ν t) of a cooling gas."""
        translation, rotation = self.rates(theta)
        return rotation / theta - translation

    def _roots(self, function: Callable[[float], float]) -> list[float]:
        """The temperature ratios at which a function of them is 0, in ascending order."""
        from scipy import optimize

        def of_logarithm(x: float) -> float:
            return function(math.exp(x))

        grid = np.log(RATIOS)
        values = np.array([of_logarithm(x) for x in grid.tolist()])
        lowest = 1 + np.flatnonzero(
            (np.diff(values)[:-1] < 0.0) & (np.diff(values)[1:] > 0.0) & (values[1:-1] > 0.0)
        )
        dips = [  # in which two roots may hide
            optimize.minimize_scalar(
                of_logarithm, bounds=(grid[i - 1], grid[i + 1]), method="bounded", options={"xatol": 1e-9}
            )
            for i in lowest
        ]
        grid = np.concatenate([grid, [dip.x for dip in dips]])
        values = np.concatenate([values, [dip.fun for dip in dips]])
        order = np.argsort(grid)
        grid, values = grid[order], values[order]
        return [
            math.exp(optimize.brentq(of_logarithm, grid[i], grid[i + 1], xtol=PRECISION))
            for i in np.flatnonzero((values[:-1] > 0.0) != (values[1:] > 0.0))
        ]

    def _state(self, theta: float) -> CoolingState:
        translation, _ = self.rates(theta)
        stable = self._drift(theta * 1.000001) < self._drift(theta / 1.000001)
        return CoolingState(theta, stable, translation, self.mean_collision(theta).sliding_share)


def _of_rule(gas_of: Gas, e: float, friction: Any, tangential_restitution: Any) -> RotatingGas:
    """The gas under the constant rule, or with a function β(tan γ)."""
    if callable(tangential_restitution):
        if friction is not None:
            shown = validation.shown(friction)
            raise ValueError(
                f"friction | tangential_restitution: got {shown} and a function, must be a function alone"
            )
        beta = partial(_checked_restitution, tangential_restitution)
        return RotatingGas(
            gas_of,
            e,
            lambda ratio: maxwellian.means(beta, ratio, gas_of.dimension),
            lambda tangents: 1.0 + beta(tangents),
        )
    if tangential_restitution is None:
        raise ValueError("tangential_restitution: missing, must be in [-1, 1] or a function of tan γ")
    limits: dict[str, Any] = {"lowest_allowed": True, "highest_allowed": True}
    beta0 = validation.number("tangential_restitution", tangential_restitution, -1.0, 1.0, **limits)
    mu = math.inf
    if friction is not None and not (isinstance(friction, float) and friction == math.inf):
        mu = validation.number("friction", friction, 0.0, lowest_allowed=True, highest_allowed=True)
    slope = (1.0 + 1.0 / gas_of.inertia_factor) * mu * (1.0 + e)
    return RotatingGas(
        gas_of,
        e,
        lambda ratio: maxwellian.walton_means(1.0 + beta0, slope, ratio, gas_of.dimension),
        lambda tangents: np.minimum(1.0 + beta0, slope / tangents),
    )


def _of_law(gas_of: Gas, law: Any, speed: Any) -> RotatingGas:
    """The gas whose contacts have ε and β of a law at one impact speed."""
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law")
    impact_speed = validation.number("speed", speed, 0.0)
    ball = Ball(gas_of.radius, mass=gas_of.mass, inertia_factor=gas_of.inertia_factor)
    contact = law.between(ball, ball)
    e = contact.restitution(impact_speed)
    beyond = math.nan if law.friction is None else math.tan(contact.slides_beyond(impact_speed))

    def beta(tangents: Floats) -> Floats:
        return contact.tangential_restitution(np.arctan(tangents), impact_speed)

    checked = partial(_checked_restitution, beta)
    return RotatingGas(
        gas_of,
        e,
        lambda ratio: maxwellian.means(checked, ratio, gas_of.dimension, beyond),
        lambda tangents: 1.0 + checked(tangents),
    )


def tabulated(gas_of: Gas, e: float, tangents: Floats, beta: Floats) -> RotatingGas:
    """The gas with β at many tan γ, whose logarithms are equally spaced, to about 1e-4: quicker than any function."""
    return RotatingGas(
        gas_of,
        e,
        lambda ratio: maxwellian.table_means(tangents, beta, ratio, gas_of.dimension),
        interpolated(tangents, 1.0 + beta),
    )


def interpolated(tangents: Floats, values: Floats) -> Callable[[Floats], Floats]:
    """The function of tan γ through a table, linear in its logarithm."""
    logarithms = np.log(tangents)
    return lambda at: np.interp(np.log(at), logarithms, values)


def root_with_drag(drag: float) -> float:
    """y in y³ + drag y² = 1; NaN if the drag is not finite."""
    from scipy import optimize

    if not drag < math.inf:
        return math.nan
    start = min(1.0, drag**-0.5) if drag > 0.0 else 1.0
    root = optimize.newton(
        lambda y: y**3 + drag * y * y - 1.0,
        start,
        lambda y: 3.0 * y * y + 2.0 * drag * y,
        tol=PRECISION * start,
    )
    return float(root)


def _checked_restitution(function: Callable[[Floats], Floats], tangents: Floats) -> Floats:
    """β at each tan γ."""
    beta = np.asarray(function(tangents), dtype=float)
    if beta.shape != tangents.shape or not np.isfinite(beta).all():
        raise ValueError(
            "tangential_restitution: got no finite number at some tan γ, must return β at each of an array"
        )
    return beta


def _not_negative(name: str, values: Floats | float) -> Floats:
    most = 1e201  # more than the temperature of any speeds up to box.LARGEST
    limits: dict[str, Any] = {"lowest": 0.0, "lowest_allowed": True, "highest": most, "highest_allowed": True}
    return validation.array(name, values, **limits, ndim=None, empty_allowed=True)


def _heated_cumulant(e: float, d: int) -> float:
    """a₂ of the velocities of a gas heated by white noise (van Noije & Ernst 1998)."""
    below = 73.0 + 56.0 * d - 24.0 * d * e - 105.0 * e + 30.0 * (1.0 - e) * e * e
    return 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / below


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
    factor = None if system.inertia_factor is None else float(system.inertia_factor[0])
    return Gas(system.n, radius, mass, system.domain.volume, system.dimension, factor)  # type: ignore[arg-type]


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
    factor = 0.0 if system.inertia_factor is None else np.ptp(system.inertia_factor)
    if np.ptp(system.radius) or np.ptp(system.mass) or factor:
        return "its particles differ"
    if system.packing_fraction > FLUID[system.dimension]:
        return f"its packing fraction {system.packing_fraction:.4g} is above {FLUID[system.dimension]}, that of a fluid"
    return None
