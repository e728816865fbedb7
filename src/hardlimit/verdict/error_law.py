"""``hl.error_law``: the error of event-driven cooling, proportional to t_c ν.

In a cooling gas the relative error of d√(E(0)/E)/dt of hard spheres, compared with Newton's equations at the same
energy E, is a(φ, ε) t_c ν. E is the energy not yet dissipated, kinetic and stored in contacts.
docs/error_law.md derives and measures a.

Notation: d diameter, D dimension, T = ⟨v_x²⟩, χ(φ) = g(d⁺) pair correlation at contact, s = −g'(d⁺) d/χ,
x = 1 − ε², U(ξ) ∝ ξ^q elastic energy, C(ξ) ∝ ξ^c damping (force C dξ/dt), and ν = D 2^D φ χ √(T/π)/d, Enskog's rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from ..boxes.contacts import mean_contact
from ..boxes.rules import RULES
from ..boxes.system import ParticleSystem
from ..contact.balls import Ball
from ..contact.contact import Law
from ..support import validation

#: Largest packing fraction of disordered particles, by dimension.
DENSEST: Final = {2: 0.84, 3: 0.64}
#: Ranges in which the law was measured, by dimension.
MEASURED_PACKING: Final = {2: (0.05, 0.7), 3: (0.02, 0.5)}
MEASURED_RESTITUTION: Final = {2: 0.6, 3: 0.4}
#: Largest t_c ν at which the law was measured.
MEASURED_TC_NU: Final = 0.3
#: Coefficients of :func:`correlations`, by dimension.
CORRELATIONS: Final = {2: (2.35, 5.2, -5.65, -0.36, 2.2), 3: (1.78, 0.34, -7.27, 5.0, 0.0)}
#: Relative standard error of a by dimension: for ε → 1, its growth with x, and what is added at the largest measured φ.
UNCERTAINTY: Final = {2: (0.02, 0.25, 0.15), 3: (0.015, 0.1, 0.04)}
#: From this ε on the theory has no free parameter.
NEARLY_ELASTIC: Final = 0.99


class Fluid(NamedTuple):
    """Structure of the hard-sphere fluid at a packing fraction."""

    dimension: int
    packing_fraction: float
    contact_value: float  #: χ
    growth: float  #: D φ χ'/χ
    slope: float  #: s = −g'(d⁺) d/χ

    @property
    def density(self) -> float:
        """D 2^D φ χ: t_c ν for particles whose mean greatest compression is the diameter."""
        return float(self.dimension * 2**self.dimension) * self.packing_fraction * self.contact_value


def fluid(dimension: int, phi: float) -> Fluid:
    """χ of Carnahan & Starling (spheres) and Henderson (disks).

    s of spheres is a fit to snapshots of hard spheres, whose first factor is that of Percus and Yevick; Percus and
    Yevick's s itself is less than half of the measured one at φ = 0.5. s of disks has the exact slope 2.205 φ at φ → 0
    and is 1.45 ± 0.2, 3.25 ± 0.13, 6.95 ± 0.17 in snapshots at φ = 0.3, 0.5, 0.65.
    """
    free = 1.0 - phi
    if dimension == 3:
        chi, growth = (1.0 - 0.5 * phi) / free**3, 3.0 / free - 0.5 / (1.0 - 0.5 * phi)
        slope = 9.0 * phi * (1.0 + phi) / (2.0 - phi) * (1.0 + 2.9 * phi**2 + 3.4 * phi**3)
    else:
        chi, growth = (1.0 - 0.4375 * phi) / free**2, 2.0 / free - 0.4375 / (1.0 - 0.4375 * phi)
        slope = 2.205 * phi * (1.0 + 1.05 * phi) / free
    return Fluid(dimension, phi, chi, dimension * phi * growth, slope)


class Exponents(NamedTuple):
    """Exponents of a contact law at small compressions: U ∝ ξ^q, C ∝ ξ^c."""

    energy: float  #: q
    damping: float  #: c

    @property
    def mean_compression(self) -> float:
        """M, the mean of ξ over C e^{−U/mT}, over the range of the repulsion ∫ e^{−U/mT} dξ; 2/π for linear springs."""
        q, c = self
        found: float = math.gamma((c + 2) / q) / (math.gamma((c + 1) / q) * math.gamma(1 + 1 / q))
        return found

    @property
    def mean_duration(self) -> float:
        """Mean of t_c over collisions, divided by t_c at the mean impact speed √(πT); t_c ∝ v^{2/q − 1}.

        The impact speeds have the density ∝ v e^{−v²/4T}.
        """
        p = 2.0 / self.energy - 1.0
        return math.gamma(1.0 + 0.5 * p) / float((0.25 * math.pi) ** (0.5 * p))


LINEAR: Final = Exponents(2.0, 0.0)


def exponents(law: Law) -> Exponents:
    """The exponents of a law, from its elastic energy and its damping at two small compressions.

    A law without damping gets c = q − 2, that of a damping in proportion to the stiffness.
    """
    contact = law.between(Ball(1e-2, density=2500.0), Ball(1e-2, density=2500.0))
    depths, rate = (1e-6, 2e-6), 1e3
    low, high = (float(contact.energy(depth)) for depth in depths)
    q = math.log2(high / low)
    low, high = (float(contact.force(depth, rate)) - float(contact.force(depth)) for depth in depths)
    return Exponents(q, math.log2(high / low) if low > 0.0 else q - 2.0)


class Softness(NamedTuple):
    """Contacts of a gas at the mean impact speed √(πT). NaN for particles at rest."""

    duration: float  #: t_c [s]
    restitution: float  #: ε
    delta_over_d: float  #: δ/d, greatest compression over the diameter


def softness(law: Law, system: ParticleSystem, temperature: Any) -> Softness:
    """The contact of two particles of mean mass and radius at the mean impact speed at these temperatures [m²/s²].

    For linear springs, whose compression is proportional to the speed, δ/d is the mean over all contacts.
    """
    speed = math.sqrt(math.pi) * float(np.sqrt(np.maximum(temperature, 0.0)).mean())
    if not 0.0 < speed < math.inf:
        return Softness(math.nan, math.nan, math.nan)
    contact, at = mean_contact(system, law), np.array([speed])
    duration, restitution, depth = (
        float(of(at)[0]) for of in (contact.duration, contact.restitution, contact.compression)
    )
    return Softness(duration, restitution, depth / (2.0 * float(system.radius.mean())))


# --- theory -------------------------------------------------------------------------------------------------


def nearly_elastic(gas: Fluid, law: Exponents = LINEAR) -> float:
    """a for ε → 1, per mean t_c ν. Exact to first order in t_c ν.

    a = [1 + (c + 1)/q]/(Dq) + [(D − 1)M + s(1 − M) + Dφχ'/χ]/(D 2^D φ χ). The first term: particles are slower by the
    energy that contacts store. The others: an oblique contact turns its normal and ends early; the neighbours press a
    touching pair together; soft spheres exclude less volume.
    """
    (q, c), m, dimension = law, law.mean_compression, gas.dimension
    stored = (1.0 + (c + 1.0) / q) / (dimension * q)
    return stored + ((dimension - 1) * m + gas.slope * (1.0 - m) + gas.growth) / gas.density


def inelastic(gas: Fluid, x: float) -> float:
    """a of the linear law at x = 1 − ε², without correlations of the velocities.

    (3/4 − 0.87x)/D + {(D − 1)(2/π)c + f[(1 − 2/π)s + Dφχ'/χ]}/(D 2^D φ χ). c is the effect of damping on the turn of
    the normal, a fit to isolated contacts. 0.87 and f contain third particles that touch one of a pair in contact.
    """
    m, dimension = LINEAR.mean_compression, gas.dimension
    turn = 1.0 - 0.05 * x - 0.08 * x**3
    third = 1.0 + (0.07 * x + 0.26 * x**3 if dimension == 3 else 0.09 * x)
    shape = (dimension - 1) * m * turn + third * ((1.0 - m) * gas.slope + gas.growth)
    return (0.75 - 0.87 * x) / dimension + shape / gas.density


def correlations(gas: Fluid, x: float) -> float:
    """h: cooling of hard spheres over Enskog's, 3 to 9 collisions per particle after an elastic equilibrium.

    A fit to the measured values, within 0.012 (spheres) and 0.015 (disks) rms. h falls as the velocities of neighbours
    become correlated. The last coefficient is the error of Henderson's χ of dense disks.
    """
    phi, square = gas.packing_fraction, x * x
    first, second, third, fourth, fifth = CORRELATIONS[gas.dimension]
    slowed = phi * square * (first + second * square + (third + fourth * square) * phi * phi)
    return 1.0 / (1.0 + slowed + fifth * phi**8)


def elastic_by_tc(gas: Fluid) -> float:
    """k for ε → 1: under the rule tc the cooling falls as e^{−2k t_c ν}, as collisions soon after others are elastic.

    1.123 is the value of independent collisions of spheres: the collision rate of the partners, weighted by the loss,
    over ν. It is the first term of the cooling of Luding & Goldshtein, Granular Matter 5, 159 (2003),
    exp(−1.268X + …) with X = √π t_c ν. The second term, a fit: the partner shields a particle from third ones. At
    finite ε the measured k is h² times this. Disks have the same k within the errors.
    """
    return 1.123 - 0.083 * (gas.slope + gas.growth) / (12.0 * gas.packing_fraction * gas.contact_value)


def left_by_soft(gas: Fluid, x: float) -> float:
    """a of the rule soft, a fit without a theory: the rule ignores third particles and the energy in contacts."""
    return (1.0 - x * x) * (0.07 + 0.14 / (1.0 + gas.packing_fraction / 0.06))


# --- the result ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ErrorLaw:
    """Error of event-driven cooling in proportion to t_c ν; made by :func:`error_law`.

    The error is (rate of √(E(0)/E) of the hard spheres)/(the same under Newton's equations) − 1 at equal energies E.
    It is positive if hard spheres cool too fast.

    Notes
    -----
    Derived and measured in :doc:`/error_law`. The effect of the rule tc: Luding & Goldshtein, Granular
    Matter 5, 159 (2003).

    Examples
    --------
    >>> law = hl.error_law(packing_fraction=0.2, restitution=0.9)
    >>> print(law)
    constant at φ = 0.2, ε = 0.9: error of the cooling 0.63 t_c ν (± 0.02), 1 % at
    t_c ν = 0.016
    """

    packing_fraction: float  #: φ
    restitution: float  #: ε
    dimension: int  #: 2 or 3
    rule: str  #: "constant", "law", "tc" or "soft"
    coefficient: float  #: a, the error over t_c ν for t_c ν → 0
    coefficient_error: float  #: its standard error
    source: str  #: "theory", "measured" or "both"
    extrapolated: str  #: which argument is outside the measured range, in words; empty if none is
    decay: float = field(default=0.0, repr=False)  #: 2k of the rule tc; 0 for other rules

    def error(self, tc_nu: float) -> float:
        """Relative error of the cooling: a t_c ν; for the rule tc (1 + (a + 2k) t_c ν) e^{−2k t_c ν} − 1.

        Parameters
        ----------
        tc_nu : float
            t_c ν at this instant, at least 0: contact duration at the mean impact speed √(πT) times Enskog's rate.

        Returns
        -------
        float

        Raises
        ------
        ValueError
            If it is negative or not finite.
        """
        at = _tc_nu(tc_nu)
        return (1.0 + (self.coefficient + self.decay) * at) * math.exp(-self.decay * at) - 1.0

    def error_bar(self, tc_nu: float) -> float:
        """Standard error of :meth:`ErrorLaw.error`. Above the largest measured t_c ν, 0.3, it grows with the excess.

        Argument and errors as for :meth:`ErrorLaw.error`.
        """
        at = _tc_nu(tc_nu)
        beyond = max(0.0, at / MEASURED_TC_NU - 1.0)
        return math.hypot(self.coefficient_error * at, beyond * self.error(at))

    def largest_tc_nu(self, error: float = 0.01) -> float:
        """The largest t_c ν up to which the size of the error is at most ``error``; at most 0.3, the largest measured.

        Parameters
        ----------
        error : float
            In (0, 1].

        Returns
        -------
        float

        Raises
        ------
        ValueError
            If ``error`` is outside its range.
        """
        from scipy.optimize import brentq

        limit = validation.number("error", error, 0.0, 1.0, highest_allowed=True)
        steps = 300
        for i in range(steps):  # the first crossing; under the rule tc the error may turn back
            low, high = MEASURED_TC_NU * i / steps, MEASURED_TC_NU * (i + 1) / steps
            if abs(self.error(high)) > limit:
                return float(brentq(lambda at: abs(self.error(at)) - limit, low, high, xtol=1e-16))
        return MEASURED_TC_NU

    def delta_over_d(self, tc_nu: float) -> float:
        """δ/d, the mean greatest compression of undamped linear contacts over the diameter: t_c ν/(D 2^D φ χ).

        Argument and errors as for :meth:`ErrorLaw.error`.
        """
        return _tc_nu(tc_nu) / fluid(self.dimension, self.packing_fraction).density

    def __str__(self) -> str:
        size = f"{self.coefficient:.2g} t_c ν (± {self.coefficient_error:.1g})"
        limit = f"1 % at t_c ν = {self.largest_tc_nu():.2g}"
        beyond = f"; {self.extrapolated}" if self.extrapolated else ""
        where = f"{self.rule} at φ = {self.packing_fraction:g}, ε = {self.restitution:g}"
        return f"{where}: error of the cooling {size}, {limit}{beyond}"


def _tc_nu(value: Any) -> float:
    return validation.number("tc_nu", value, 0.0, lowest_allowed=True)


def error_law(
    *,
    packing_fraction: float,
    restitution: float,
    dimension: int = 3,
    rule: str = "constant",
    law: Law | None = None,
) -> ErrorLaw:
    """The error that an event-driven simulation of a cooling gas makes, in proportion to t_c ν.

    The law holds for equal smooth spheres or disks without lasting contacts, with t_c ν up to 0.3 and the compressions
    that contact laws allow. t_c ν is the value at the instant: it falls while the gas cools.

    Parameters
    ----------
    packing_fraction : float
        φ, up to 0.64 for spheres and 0.84 for disks.
    restitution : float
        ε, in [0, 1]; at 1 the limit of weak damping. If it depends on the speed, its value at the mean impact speed
        √(πT).
    dimension : int
        3 for spheres, 2 for disks.
    rule : {"constant", "law", "tc", "soft"}
        As for :func:`event_driven`. If ε of the contact law depends on the speed, the rule constant has a further
        error, which does not vanish with t_c ν and is not contained here.
    law : Law, optional
        Contact law under Newton's equations; only the exponents of its elastic and damping forces matter. Default: the
        linear dashpot. If t_c depends on the speed, as in Hertz' law, t_c ν is taken at the mean impact speed √(πT).

    Returns
    -------
    ErrorLaw
        Outside the range of the measurements (spheres: 0.02 ≤ φ ≤ 0.5, ε ≥ 0.4; disks: 0.05 ≤ φ ≤ 0.7, ε ≥ 0.6) it says
        so, and its error is larger.

    Raises
    ------
    ValueError
        If an argument is outside its range.

    Notes
    -----
    For ε → 1 the coefficient follows from equilibrium averages, without a free parameter; its dependence on ε is partly
    derived and partly measured (:doc:`/error_law`). Berzi & Jenkins, Soft Matter 11, 4799 (2015), correct
    kinetic theory for the contact duration by one constant.

    Examples
    --------
    >>> law = hl.error_law(packing_fraction=0.2, restitution=0.99)
    >>> f"{law.coefficient:.2f}"
    '0.68'
    """
    dim = validation.whole("dimension", dimension, 2, 3)
    phi = validation.number("packing_fraction", packing_fraction, 0.0, DENSEST[dim], highest_allowed=True)
    epsilon = validation.number(
        "restitution", restitution, 0.0, 1.0, lowest_allowed=True, highest_allowed=True
    )
    name = validation.one_of("rule", rule, tuple(RULES))
    if law is not None and not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    powers = LINEAR if law is None else exponents(law)
    gas, x = fluid(dim, phi), 1.0 - epsilon**2
    h, decay = correlations(gas, x), 0.0
    value = nearly_elastic(gas, powers) + inelastic(gas, x) - inelastic(gas, 0.0)
    value *= h * powers.mean_duration
    error, source = _uncertainty(gas, x) * abs(value), "theory" if epsilon >= NEARLY_ELASTIC else "both"
    if name == "tc":
        decay = 2.0 * elastic_by_tc(gas) * h * h
        value -= decay
        error = math.hypot(error, _uncertainty(gas, x) * decay)
    elif name == "soft":
        value = left_by_soft(gas, x)
        error, source = 0.03 + 0.5 * value * x, "measured"
    beyond = _outside(dim, phi, epsilon)
    return ErrorLaw(
        phi, epsilon, dim, name, value, error * _widened(dim, phi, epsilon), source, beyond, decay
    )


def _uncertainty(gas: Fluid, x: float) -> float:
    """Relative standard error of a inside the range of the measurements."""
    elastic, grows, dense = UNCERTAINTY[gas.dimension]
    filled = gas.packing_fraction / MEASURED_PACKING[gas.dimension][1]
    return math.hypot(elastic + grows * x, dense * filled**6)


def _outside(dimension: int, phi: float, epsilon: float) -> str:
    """Which arguments are outside the range of the measurements, in words."""
    (thin, dense), least = MEASURED_PACKING[dimension], MEASURED_RESTITUTION[dimension]
    found = []
    if not thin <= phi <= dense:
        found.append(f"the packing fraction {phi:.3g} is outside the measured range {thin:g} to {dense:g}")
    if epsilon < least:
        found.append(f"the restitution {epsilon:.3g} is below the measured range from {least:g} on")
    return " and ".join(found)


def _widened(dimension: int, phi: float, epsilon: float) -> float:
    """Factor by which the error grows outside the range of the measurements; 1 inside."""
    (thin, dense), least = MEASURED_PACKING[dimension], MEASURED_RESTITUTION[dimension]
    far = (
        max(0.0, math.log(thin / phi)) + 10.0 * max(0.0, phi / dense - 1.0) + 10.0 * max(0.0, least - epsilon)
    )
    return 1.0 + far
