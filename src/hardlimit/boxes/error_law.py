"""``hl.error_law``: the error of event-driven cooling, proportional to t_c ν.

In a cooling gas the relative error of d√(E(0)/E)/dt of hard spheres, compared with Newton's equations at the same
energy E, is a(φ, ε) t_c ν. E is the energy not yet dissipated, kinetic and stored in contacts.
docs/error_law.md derives and measures a; core/boxes/common/error_law.hpp has the formulas and the notation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..contact.friction import Friction
from ..support import validation
from ..support.formatting import listed
from . import frictional_error, sheared_error, spins
from .contacts import mean_contact
from .rules import RULES
from .system import ParticleSystem
from .theory import FLUID

#: Rules of collision whose error is known.
KNOWN_RULES: Final = tuple(rule.name for rule in RULES.values() if rule.error)
#: Largest packing fraction of disordered particles, by dimension.
DENSEST: Final = {2: 0.84, 3: 0.64}
#: Ranges in which the law was measured, by dimension.
MEASURED_PACKING: Final = {d: _core.error_law_measured[d - 2][:2] for d in DENSEST}
MEASURED_RESTITUTION: Final = {d: _core.error_law_measured[d - 2][2] for d in DENSEST}
#: The same for Hertz' laws: smallest and largest packing fraction, smallest restitution.
MEASURED_HERTZ: Final = {d: _core.error_law_measured_hertz[d - 2] for d in DENSEST}
#: Largest t_c ν at which the law was measured.
MEASURED_TC_NU: Final = _core.error_law_measured_tc_nu
#: From this ε on the theory has no free parameter.
NEARLY_ELASTIC: Final = _core.error_law_nearly_elastic

#: Coefficient of friction below which its effect is in proportion to it: contacts that slide take long to compute.
WEAK: Final = 0.05
#: b in the term −b (1 − ε²)/D of the coefficient, for linear springs and by which it falls with their exponent q, as in
#: core/boxes/common/error_law.hpp.
DELAYED: Final = 0.87
DELAYED_SLOPE: Final = 1.03

#: The friction of smooth grains.
SMOOTH: Final = Friction(0.0, stiffness_ratio=2.0 / 7.0, damping_ratio=0.0)

#: Steps to the steady energy under the rule tc.
FIXED_POINT_STEPS: Final = 60


class Fluid(NamedTuple):
    """Structure of the hard-sphere fluid at a packing fraction."""

    dimension: int
    packing_fraction: float
    contact_value: float  #: χ
    growth: float  #: D φ χ'/χ
    slope: float  #: s = −g'(d⁺) d/χ
    density: float  #: D 2^D φ χ: t_c ν for particles whose mean greatest compression is the diameter


def fluid(dimension: int, phi: float) -> Fluid:
    return Fluid(dimension, phi, *_core.hard_sphere_fluid(dimension, phi))


class Exponents(NamedTuple):
    """Exponents of a contact law at small compressions: U ∝ ξ^q, C ∝ ξ^c."""

    energy: float  #: q
    damping: float  #: c

    @classmethod
    def of(cls, powers: tuple[int, int]) -> Exponents:
        """Those of a force K ξ^p + C ξ^q dξ/dt, from 4p and 4q."""
        return cls(0.25 * powers[0] + 1.0, 0.25 * powers[1])

    @property
    def mean_compression(self) -> float:
        """M, the mean of ξ over C e^{−U/mT}, over the range of the repulsion ∫ e^{−U/mT} dξ; 2/π for linear springs."""
        q, c = self
        compression: float = math.gamma((c + 2) / q) / (math.gamma((c + 1) / q) * math.gamma(1 + 1 / q))
        return compression

    @property
    def mean_duration(self) -> float:
        """Mean of t_c over collisions, divided by t_c at the mean impact speed √(πT); t_c ∝ v^{2/q − 1}.

        The impact speeds have the density ∝ v e^{−v²/4T}.
        """
        p = 2.0 / self.energy - 1.0
        return math.gamma(1.0 + 0.5 * p) / float((0.25 * math.pi) ** (0.5 * p))


#: Powers of the contact forces that were measured (``Exponents.of``): linear, Tsuji's and viscoelastic.
MEASURED_POWERS: Final = ((4, 0), (6, 1), (6, 2))
LINEAR_POWERS: Final = MEASURED_POWERS[0]
LINEAR, *HERTZ = map(Exponents.of, MEASURED_POWERS)


def exponents(law: Law) -> Exponents:
    """The exponents of a law; without damping, those of the same law with damping."""
    return Exponents.of(law.record["powers"])


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


class ShearedErrors(NamedTuple):
    """Relative errors in steady shear at equal shear rate; made by ``ErrorLaw.sheared_errors``."""

    temperature: float  #: of the granular temperature
    stress: float  #: of shear stress, apparent viscosity and dissipation


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
    constant at φ = 0.2, ε = 0.9: error of the cooling 0.63 t_c ν (± 0.03), 1 % at
    t_c ν = 0.016
    """

    packing_fraction: float  #: φ
    restitution: float  #: ε
    dimension: int  #: 2 or 3
    rule: str  #: name of the rule
    coefficient: float  #: a, the error over t_c ν for t_c ν → 0
    coefficient_error: float  #: its standard error
    source: str  #: "theory", "measured" or "both"
    extrapolated: str  #: which argument is outside the measured range, in words; empty if none is
    decay: float = field(default=0.0, repr=False)  #: 2k of the rule tc; 0 for other rules
    stored: float = field(default=math.nan, repr=False)  #: share of elastic energy at ε → 1, per t_c ν
    delay: float = field(default=math.nan, repr=False)  #: mean t_c over t_c at the mean impact speed, over D
    friction: Friction | None = None  #: of the contacts; None: smooth
    offset: float = 0.0  #: error at t_c ν = 0, of the rule constant with friction
    offset_error: float = field(default=0.0, repr=False)  #: its standard error
    smooth_error: float = 0.0  #: error of event-driven cooling of translation without the friction, in theory
    temperature_ratio: float = math.nan  #: T_r/T, mean of 3 to 9 collisions of each in theory; NaN if smooth
    smooth: ErrorLaw | None = field(default=None, repr=False)  #: that without the friction
    heated_change: float = field(
        default=math.nan, repr=False
    )  #: by friction, of ln T of a heated gas per t_c ν
    _setting: frictional_error.Setting | None = field(
        default=None, repr=False
    )  #: the grains with friction, at least WEAK

    def error(self, tc_nu: float) -> float:
        """Relative error of the cooling: a t_c ν; for the rule tc (1 + (a + 2k) t_c ν) e^{−2k t_c ν} − 1.

        With an ``offset`` o, (1 + o)(1 + a t_c ν) − 1.

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
        return (1.0 + self.offset) * (1.0 + self._values.error(_tc_nu(tc_nu))) - 1.0

    def error_bar(self, tc_nu: float) -> float:
        """Standard error of :meth:`ErrorLaw.error`. Above the largest measured t_c ν, 0.3, it grows with the excess.

        Argument and errors as for :meth:`ErrorLaw.error`.
        """
        return math.hypot(self._values.error_bar(_tc_nu(tc_nu)), self.offset_error)

    def heated_error(self, tc_nu: float) -> float:
        """Relative error of the granular temperature in the steady state at equal heating power.

        T of the hard spheres over that under Newton's equations, less 1; NaN where t_c ν is so large that the expansion
        leaves no kinetic energy. With friction it is that of spheres with linear springs under the rule law whose
        velocities are heated by white noise, and NaN for others. :doc:`/driven_gases` derives it, and :doc:`/results`
        measures that of smooth particles.

        Notes
        -----
        Hard spheres of the energy E dissipate 1 + e times as much as a cooling gas under Newton's equations with the
        same energy not yet dissipated, and both grow as E^(3/2). In a steady state, Newton's gas also holds the energy
        that contacts in progress will still dissipate, for t_c/2 on average, a share (1 − ε²) t_c ν/(2D), which a
        cooling gas has lost before. A share (1 − (1 − ε²)/2) t_c ν/(Dq) is stored in contacts (elastic energy ∝ ξ^q)
        and is no kinetic energy. The rule tc dissipates less at a higher temperature: its factor e^(−2k t_c ν) holds at
        its own temperature.

        Argument and errors as for :meth:`ErrorLaw.error`, with t_c ν in the steady state under Newton's equations.
        """
        x = _tc_nu(tc_nu)
        if self.smooth is not None:
            rubbed = 1.0 + self.heated_change * x
            return (1.0 + self.smooth.heated_error(x)) * rubbed - 1.0 if rubbed > 0.0 else math.nan
        slower = 1.0 + (self.coefficient + self.decay) * x
        if not slower > 0.0:
            return math.nan
        root = 1.0  # √(E of the rule/E under Newton's equations)
        for _ in range(FIXED_POINT_STEPS):
            root = (math.exp(min(self.decay * x * root, 50.0)) / slower) ** (1.0 / 3.0)
        return root**2 / self._kinetic_share(x) - 1.0

    def sheared_errors(self, tc_nu: float) -> ShearedErrors:
        """Relative errors of granular temperature and shear stress in steady shear at equal shear rate.

        Hard spheres over Newton's equations, less 1, for spheres with linear springs and a constant ε; with friction
        under the rule law.
        :doc:`/driven_gases` derives them and :doc:`/results` measures them.

        Parameters
        ----------
        tc_nu : float
            t_c ν in the steady state under Newton's equations, at least 0.

        Returns
        -------
        ShearedErrors
            Of temperature and stress; NaN where t_c ν is so large that the expansion leaves no kinetic energy.

        Raises
        ------
        ValueError
            If it is negative or not finite, or for disks, other contact laws, the rules tc and soft, with friction the
            rule constant, and φ above 0.49.

        Notes
        -----
        Shear works η γ̇² per volume. With η ∝ √T and the dissipation ∝ T^(3/2) of hard spheres, their temperature is
        (1 + e_η)/(1 + e_Γ) times that under Newton's equations, where e are the errors of viscosity and dissipation at
        equal kinetic temperature. e_Γ is that of :meth:`ErrorLaw.heated_error`; e_η follows from means over contacts,
        which last under Newton's equations.

        Examples
        --------
        >>> law = hl.error_law(packing_fraction=0.3, restitution=0.9)
        >>> f"stress {law.sheared_errors(0.1).stress:.1%}"
        'stress 5.3%'
        """
        x = _tc_nu(tc_nu)
        if reason := self.no_shear():
            accepted = f"spheres up to φ = {FLUID[3]:g} with linear springs and a constant ε"
            raise ValueError(f"sheared_errors: got {reason}, must be {accepted}")
        heated = self.heated_error(x)
        if not heated > -1.0:
            return ShearedErrors(math.nan, math.nan)
        dissipating = (1.0 + heated) ** -1.5
        viscosity = self._viscosity_ratio(x, 1.0 / dissipating)
        temperature = viscosity / dissipating
        return ShearedErrors(temperature - 1.0, viscosity * math.sqrt(temperature) - 1.0)

    def _viscosity_ratio(self, x: float, dissipation: float) -> float:
        """Of hard spheres over Newton's equations at equal temperature, where the dissipation of these is that of hard
        spheres times ``dissipation``; NaN if it is not known."""
        gas = fluid(3, self.packing_fraction)
        fluid_of = {"density": gas.density, "slope": gas.slope, "growth": gas.growth, "tc_nu": x}
        setting, weight = self._setting, _weight(self.friction)
        parts = []  # share, contacts, loss of a collision
        if weight < 1.0:
            sliding = frictional_error.Setting(3, self.restitution, SMOOTH, 0.0, spins.SOLID[3])
            parts.append((1.0 - weight, sliding, 1.0 - self.restitution**2))
        if setting is not None and weight > 0.0:
            state = frictional_error.heated_state(setting, 1.0 + (LINEAR.damping + 1.0) / LINEAR.energy)
            if state is None:
                return math.nan
            balance, theta = state
            rubbing = setting._replace(theta=theta)
            parts.append((weight, rubbing, -float(balance.collision(theta)[0])))
        return sum(
            share
            * sheared_error.viscosity_ratio(
                sheared_error.flowing(contacts), **fluid_of, loss=loss, dissipation=dissipation
            )
            for share, contacts, loss in parts
        )

    def _kinetic_share(self, x: float) -> float:
        """Kinetic energy under Newton's equations over that which contacts will not dissipate; NaN if one is none."""
        half_lost = 0.5 * (1.0 - self.restitution**2)
        kinetic, kept = 1.0 - (1.0 - half_lost) * self.stored * x, 1.0 - half_lost * self.delay * x
        return kinetic / kept if kinetic > 0.0 and kept > 0.0 else math.nan

    def outside_driven(self, sheared: bool) -> str:
        """How this is outside what was measured of sheared or of heated gases, in words; empty if it is inside.

        :meta private:
        """
        if self._setting is None:
            return self.extrapolated
        return self._setting.outside_driven(self.packing_fraction, sheared)

    def no_shear(self) -> str:
        """Why the errors under shear are not known; empty if they are.

        :meta private:
        """
        if self.dimension != 3:
            return "disks"
        if RULES[self.rule].error != "constant":
            return f"the rule {self.rule}"
        if self.friction is not None and self.rule != "law":
            return f"the rule {self.rule} with friction"
        linear = LINEAR.mean_duration / 3.0
        if not np.allclose((self.stored, self.delay), (linear / LINEAR.energy, linear), rtol=1e-6):
            return "another contact law"
        return f"φ = {self.packing_fraction:g}" if self.packing_fraction > FLUID[3] else ""

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
        limit = validation.number("error", error, 0.0, 1.0, highest_allowed=True)
        if self.offset == 0.0:
            return self._values.largest_tc_nu(limit)
        if abs(self.offset) > limit:
            return 0.0
        slope = abs((1.0 + self.offset) * self.coefficient)
        room = limit - math.copysign(self.offset, self.offset * self.coefficient)
        return min(room / slope, MEASURED_TC_NU) if slope > 0.0 else MEASURED_TC_NU

    def delta_over_d(self, tc_nu: float) -> float:
        """δ/d, the mean greatest compression of undamped linear contacts over the diameter: t_c ν/(D 2^D φ χ).

        Argument and errors as for :meth:`ErrorLaw.error`.
        """
        return _tc_nu(tc_nu) / fluid(self.dimension, self.packing_fraction).density

    @property
    def _values(self) -> _core.ErrorLaw:
        return _core.ErrorLaw(self.coefficient, self.coefficient_error, self.decay)

    def __str__(self) -> str:
        size = f"{self.coefficient:.2g} t_c ν (± {self.coefficient_error:.1g})"
        limit = f"1 % at t_c ν = {self.largest_tc_nu():.2g}"
        beyond = f"; {self.extrapolated}" if self.extrapolated else ""
        where = f"{self.rule} at φ = {self.packing_fraction:g}, ε = {self.restitution:g}"
        if self.friction is not None:
            where += f", μ = {self.friction.coefficient:g}"
        if self.offset != 0.0:
            size = f"{self.offset:.2g} + {size}"
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
    friction: Friction | None = None,
    temperature_ratio: float = 1.0,
    inertia_factor: float | None = None,
) -> ErrorLaw:
    """The error that an event-driven simulation of a cooling gas makes, in proportion to t_c ν.

    The law holds for equal spheres or disks without lasting contacts, with t_c ν up to 0.3 and the compressions that
    contact laws allow. t_c ν is the value at the instant: it falls while the gas cools. With friction, E contains the
    rotation, and the hard spheres have the friction of the law: the rule law, or constant with the β0 of
    :meth:`Contact.effective_tangential_restitution`.

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
        As for :func:`event_driven`; with friction constant or law. If ε of the contact law depends on the speed, the
        rule constant has a further error, which does not vanish with t_c ν and is not contained here.
    law : Law, optional
        Contact law under Newton's equations; only the exponents of its elastic and damping forces, and its friction,
        matter. Default: the linear dashpot. If t_c depends on the speed, as in Hertz' law, t_c ν is taken at the mean
        impact speed √(πT).
    friction : Friction, optional
        Of this law, with ratios of stiffness and damping; by default that of ``law``.
    temperature_ratio : float
        T_r/T at the start of a gas with friction, in [0, 5]. The coefficient is the mean over 3 to 9 collisions of each
        particle.
    inertia_factor : float, optional
        q in the moment of inertia q m R², by default that of solid spheres or disks. It matters with friction only.

    Returns
    -------
    ErrorLaw
        Outside the range of the measurements its text and ``extrapolated`` say so, and its error is larger. They are
        0.02 ≤ φ ≤ 0.5, ε ≥ 0.4 for spheres and 0.05 ≤ φ ≤ 0.7, ε ≥ 0.6 for disks with linear springs; 0.05 ≤ φ ≤ 0.5,
        ε ≥ 0.6 and 0.4 ≤ φ ≤ 0.6, ε ≥ 0.8 for Tsuji's and viscoelastic contacts; with friction 0.02 ≤ φ ≤ 0.5,
        0.7 ≤ ε ≤ 0.99, μ ≤ 1, 1 ≤ (m_n/m_t) k_t/k_n ≤ 3.5, and γ_t up to γ_n, with linear springs; with Hertz' laws and
        Mindlin's springs, three points.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the error is not known with this friction: without a tangential spring,
        for other rules, and far outside the measured range.

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
    >>> rubbing = hl.error_law(
    ...     packing_fraction=0.2, restitution=0.9, rule="law", friction=hl.Friction(0.5)
    ... )
    >>> f"{rubbing.coefficient:.1f}"
    '0.2'
    """
    dim = validation.whole("dimension", dimension, 2, 3)
    phi = validation.number("packing_fraction", packing_fraction, 0.0, DENSEST[dim], highest_allowed=True)
    epsilon = validation.number(
        "restitution", restitution, 0.0, 1.0, lowest_allowed=True, highest_allowed=True
    )
    name = validation.one_of("rule", rule, KNOWN_RULES)
    if law is not None and not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be a contact law such as LinearDashpot")
    smooth = of_exponents(dim, phi, epsilon, name, LINEAR if law is None else exponents(law))
    rubs = frictional_error.friction_of(law, friction)
    if rubs is None or rubs.coefficient == 0.0:
        return smooth
    theta = validation.number(
        "temperature_ratio", temperature_ratio, 0.0, 5.0, lowest_allowed=True, highest_allowed=True
    )
    q = float(spins.checked_factor(inertia_factor, 1, dim)[0])
    return with_friction(smooth, rubs, theta, q, LINEAR_POWERS if law is None else law.record["powers"])


def with_friction(
    smooth: ErrorLaw, friction: Friction, theta: float, q: float, powers: tuple[int, int]
) -> ErrorLaw:
    """The law of the error with this friction, from that of smooth particles.

    ``theta``: T_r/T at the start. ``q``: inertia factor. ``powers``: four times those of the normal force. Raises
    ValueError where it is not known.
    """
    dim, epsilon, law = smooth.dimension, smooth.restitution, Exponents.of(powers)
    setting = frictional_error.Setting(dim, epsilon, friction, theta, q, (powers[0], powers[1]))
    if reason := setting.not_known() or _rule_not_known(smooth.rule):
        raise ValueError(f"friction: {reason}")
    weak = _weight(friction)
    strong = setting._replace(friction=replace(friction, coefficient=max(friction.coefficient, WEAK)))
    delayed = DELAYED - DELAYED_SLOPE * (law.energy - LINEAR.energy)
    terms = frictional_error.terms(strong, *law, delayed)
    gas, x = fluid(dim, smooth.packing_fraction), 1.0 - epsilon**2
    third = frictional_error.third_particles(dim, smooth.packing_fraction, terms.spring)
    stored = (1.0 + (law.damping + 1.0) / law.energy) / law.energy
    energy = terms.energy - (stored - delayed * x) / dim
    turn = (terms.turn - (dim - 1) * law.mean_compression) / gas.density
    pressure = gas.slope * (terms.pressure + law.mean_compression) / gas.density
    scale = weak * law.mean_duration * _correlations(smooth)
    change = scale * (energy + turn + pressure - third)
    bar = weak * frictional_error.bar(x, turn, pressure, third)
    # What friction was measured at comes before what smooth grains were.
    smoothly = _outside(dim, smooth.packing_fraction, 1.0 if "ε" in setting.beyond() else epsilon, law)
    wider = 1.0 + setting.distance()
    constant = smooth.rule == "constant"
    if constant and math.isnan(terms.offset):
        raise ValueError(
            "friction: got one for which no β0 stands in a gas, must be another for the rule constant"
        )
    return replace(
        smooth,
        coefficient=smooth.coefficient + change,
        coefficient_error=math.hypot(smooth.coefficient_error, bar) * wider,
        source="both",
        extrapolated=listed(smoothly + setting.outside()),
        friction=friction,
        offset=weak * terms.offset if constant else 0.0,
        offset_error=weak * math.hypot(0.003, 0.5 * terms.offset) if constant else 0.0,
        smooth_error=weak * terms.smooth_error,
        temperature_ratio=terms.temperature_ratio,
        smooth=smooth,
        heated_change=scale * _heated_change(smooth, strong, law, delayed),
        _setting=strong,
    )


def _weight(friction: Friction | None) -> float:
    """Share that the terms of friction have of those at WEAK, below which they are in proportion to μ; 1 above."""
    return 0.0 if friction is None else min(friction.coefficient / WEAK, 1.0)


def _heated_change(
    smooth: ErrorLaw, setting: frictional_error.Setting, law: Exponents, delayed: float
) -> float:
    """By how much friction changes ln(T of hard spheres/T) of a heated gas over t_c ν, without correlations; NaN where
    it was not measured."""
    dim, phi, x = smooth.dimension, smooth.packing_fraction, 1.0 - smooth.restitution**2
    if dim != 3 or setting.powers != LINEAR_POWERS or smooth.rule != "law":
        return math.nan
    terms = frictional_error.heated_terms(setting._replace(theta=0.0), *law, delayed)
    if terms is None:
        return math.nan
    gas = fluid(dim, phi)
    turn = (terms.turn + (dim - 1) * law.mean_compression) / gas.density
    pressure = gas.slope * (terms.pressure - law.mean_compression) / gas.density
    third = frictional_error.third_particles(dim, phi, terms.spring)
    without = ((2.0 / 3.0 * delayed - 0.5) - 0.5 / law.energy) * x / dim
    return 2.0 / 3.0 * (turn + pressure + third) + terms.energy - without


def _rule_not_known(rule: str) -> str:
    """Why nothing is known of a rule with friction; empty if it is."""
    return "" if RULES[rule].error == "constant" else f"got it with the rule {rule}, must be constant or law"


def _correlations(smooth: ErrorLaw) -> float:
    """h of docs/error_law.md over its value for ε = 1: the measured decay of the rule tc has the factor h²."""
    decays = [
        of_exponents(smooth.dimension, smooth.packing_fraction, e, "tc", LINEAR).decay
        for e in (smooth.restitution, 1.0)
    ]
    return math.sqrt(decays[0] / decays[1])


def of_exponents(dim: int, phi: float, epsilon: float, name: str, powers: Exponents) -> ErrorLaw:
    """The law of the error for a contact force with these exponents, from checked arguments."""
    same = RULES[name].error
    law = _core.error_law(
        dimension=dim,
        packing_fraction=phi,
        restitution=epsilon,
        rule=same,
        **powers._asdict(),
        mean_compression=powers.mean_compression,
        mean_duration=powers.mean_duration,
    )
    source = "measured" if same == "soft" else "theory" if epsilon >= NEARLY_ELASTIC else "both"
    delay = powers.mean_duration / dim
    return ErrorLaw(
        packing_fraction=phi,
        restitution=epsilon,
        dimension=dim,
        rule=name,
        coefficient=law.coefficient,
        coefficient_error=law.coefficient_error,
        source=source,
        extrapolated=listed(_outside(dim, phi, epsilon, powers)),
        decay=law.decay,
        stored=delay / powers.energy,
        delay=delay,
    )


def _outside(dimension: int, phi: float, epsilon: float, powers: Exponents) -> list[str]:
    """Which arguments are outside the range of the measurements, in words."""
    (thin, dense), least = MEASURED_PACKING[dimension], MEASURED_RESTITUTION[dimension]
    outside = []
    if not np.allclose(powers, LINEAR, atol=1e-3):
        thin, dense, least = MEASURED_HERTZ[dimension]
        if not any(np.allclose(powers, known, atol=1e-3) for known in HERTZ):
            outside.append(
                f"laws with U ∝ ξ^{powers.energy:.3g}, C ∝ ξ^{powers.damping:.3g} were not measured"
            )
    if not thin <= phi <= dense:
        outside.append(f"the packing fraction {phi:.3g} is outside the measured range {thin:g} to {dense:g}")
    if epsilon < least:
        outside.append(f"the restitution {epsilon:.3g} is below the measured range from {least:g} on")
    return outside
