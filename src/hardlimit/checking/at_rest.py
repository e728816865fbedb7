"""Grains that rest on each other or are pressed together: pressure, overlap, stiffness number, longest stable step.

**Force.** A pressure p is carried by mean contact forces ⟨F⟩ = π d² p/(φ z) between spheres, π d p/(φ z) between
disks, of the packing fraction φ and the coordination z: Love's and Weber's stress Σ F l/(D V) with l = d and N z/2
contacts (Andreotti, Forterre & Pouliquen, Granular Media, 2013). Grains of several sizes: ``mixture.py``.

**Stiffness number.** κ_p = k/(p d) of linear springs, (E*/p)^(2/3) of Hertz' contacts, 1/E* = Σ (1 − ν²)/E: d/δ of a
contact under the force p d² but for a factor of about one. Grains are usually called rigid from 10⁴ on: Roux & Combe,
C. R. Physique 3, 131 (2002); da Cruz, Emam, Prochnow, Roux & Chevoir, Phys. Rev. E 72, 021309 (2005).

**Inertial number.** I = γ̇ d √(ρ/p), ρ of the grains: usually quasi-static below 10⁻³, dense flow up to 0.1, collisional
above (GDR MiDi, Eur. Phys. J. E 14, 341 (2004); da Cruz et al. 2005).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
import scipy

from ..boxes.box import UNIT_BALL
from ..convert.force import AdhesiveForce, Force
from . import mixture
from .contacts import AGREEMENT, Body, Case, restitution_of
from .scripts.motion import STEEP

#: Stiffness number from which grains count as rigid.
RIGID: Final = 1e4
#: Inertial number below which flow is quasi-static (GDR MiDi, Eur. Phys. J. E 14, 341 (2004)).
QUASI_STATIC: Final = 1e-3
#: Contacts of a flow last twice as long as a collision on average at I = (a + b (1 − ε)) (κ_p/10⁴)^−c: boxes of spheres
#: sheared by our own steps (studies/lasting_contacts.nc), κ_p from 1500 on. Stiffer grains separate in slower flow.
SEPARATING: Final = (0.09, 0.92, 0.2)
SEPARATED_FROM: Final = 2.0
#: This I over that of μ from 0.3 to 0.7, for grains of other friction.
FRICTION_SHARE: Final = {0.1: 0.8, 0.3: 1.0, 0.7: 1.0, 1.0: 0.6}
LEAST_RESTITUTION, SOFTEST_FLOW = 0.5, 1.5e3
#: κ_p of flows of which it is not known: stiffer than most.
STIFF_FLOW: Final = 1e6
#: Impact speeds [m/s] between which ε is that of a flow.
FLOW_SPEEDS: Final = (1e-3, 1.0)
#: Acceleration [m/s²] under which grains rest that are given by numbers.
GRAVITY: Final = 9.81
#: Largest force of a contact over the mean at the same pressure, of linear springs (docs/hard_enough.md).
LARGEST_FORCE: Final = 4.0
#: Four times the power of Hertz' force.
HERTZ: Final = 6
#: Mean overlap of Hertz' contacts over that under the mean force: 0.91 to 0.94 in beds of κ_p from 1e2 to 1e4
#: (docs/hard_enough.md), since forces are unequal.
HERTZ_SPREAD: Final = 0.92
#: κ_p down to which settled and pressed packings were measured; softer ones count as these. Grains that fall overlap by
#: more than any law describes from about 50 on, pressed ones at 18 by 8 % of R on average and 20 % at most.
SETTLED_FROM, PRESSED_FROM = 100.0, 17.0
#: Packing fraction and coordination of spheres over those of rigid ones, less one: the first times κ_p, the second
#: times √κ_p, with and without friction.
EXCESS: Final = {
    ("settled", True): (5.6, 2.7),
    ("settled", False): (4.6, 1.9),
    ("pressed", True): (3.4, 3.0),
    ("pressed", False): (3.5, 1.9),
}
#: Share of the longest stable step that is safe: frequencies of beds differ by 5 %, and contacts form later.
SAFE_SHARE: Final = 0.5
#: Layers of grains below which numbers are given if neither pressure nor height is known; fewer for few grains, which
#: make a column this many times as high as wide.
LAYERS: Final = 100
SLENDER: Final = 10.0
#: Froude number from which on a drum throws its grains (cataracting: Mellmann, Powder Technol. 118, 251 (2001)).
THROWN: Final = 0.1
#: Froude number from which on blades that turn about gravity throw grains.
STIRRED: Final = 1.0
#: Radius over the diameter of grains of the narrowest drum.
NARROWEST: Final = 2.0
#: The part of the contact duration that is usually taken as the time step.
USUAL_STEP: Final = 50.0


class Packing(NamedTuple):
    """A packing of grains at rest."""

    packing_fraction: float
    coordination: float
    stress_share: float = 1.0  #: mean of the normal stresses over that along gravity
    rigid: float | None = None  #: φ z of rigid grains, if the packing is not that of all grains in a dump
    softer: float = (
        3.1  #: (φ z of spheres over that of rigid ones − 1) √κ_p; settled: with friction and without
    )
    soft: float | None = None  #: the same slope over 1/√κ_p below κ_p = 10³, if it is another one
    wider: float = mixture.WIDER  #: increase of φ z over the width of the sizes ...
    widest: float = math.inf  #: ... up to this width
    prepared: tuple[float, float] | None = None  #: least and largest φ z over this one, by preparation
    uncertain: float = 0.0  #: relative error of ``stress_share``
    softest: float = SETTLED_FROM  #: least κ_p at which it was measured
    #: Increase of φ times κ_p, and of the coordination times √κ_p, over those of rigid spheres with friction.
    excess: tuple[float, float] = EXCESS["settled", True]
    counted: bool = False  #: whether the coordination is that of a dump

    def carrying(self, kappa: float, dimension: int, width: float = 0.0) -> float:
        """φ z of the grains that carry the pressure, at a stiffness number and a width of the sizes."""
        if self.rigid is None:
            return self.packing_fraction * self.coordination
        softness, hard = 1.0 / math.sqrt(max(kappa, self.softest)), 1.0 / math.sqrt(SOFTER)
        slope = self.softer if self.soft is None else self.soft
        softer = self.softer * min(softness, hard) + slope * max(softness - hard, 0.0)
        wider = self.wider * min(width, self.widest)
        return self.rigid * (1.0 + softer * (dimension == 3)) * (1.0 + wider)

    def softened(self, kappa: float) -> Packing:
        """With the packing fraction and the coordination of spheres at this stiffness number; they are hard here."""
        if self.counted:
            return self
        (denser, more), soft = self.excess, max(kappa, self.softest)
        fraction = self.packing_fraction * (1.0 + denser / soft)
        more_contacts = max((1.0 + more / math.sqrt(soft)) / (1.0 + more / math.sqrt(RIGID)), 1.0)
        return self._replace(packing_fraction=fraction, coordination=self.coordination * more_contacts)


#: Settled spheres by friction: φ, z, mean of the normal stresses over that along gravity, φ z of rigid ones, and how
#: φ z grows with softness; frictions above 1 have the numbers of the last one (studies/packings.nc, κ_p from 1e2 on).
SETTLED: Final = {
    0.0: (0.63, 6.0, 0.96, 3.76, 3.1),
    0.1: (0.61, 5.5, 0.90, 3.20, 3.1),
    0.3: (0.59, 5.0, 0.80, 2.83, 3.1),
    0.5: (0.59, 4.7, 0.80, 2.66, 3.1),
    1.0: (0.59, 4.6, 0.79, 2.60, 3.1),
}
#: φ, z, share of the stresses and φ z of equal spheres that were poured over those of grains that fell little, at most
#: those without friction: μ = 0.5, heights of 12 to 35 diameters, ε from 0.5 to 0.93 (docs/hard_enough.md).
POURED: Final = (1.05, 1.085, 1.13, 1.16)
#: Settled disks with and without friction: isostatic or a little more, with the shares of spheres.
DISKS: Final = {True: Packing(0.80, 3.5, 0.80, 2.80), False: Packing(0.83, 4.0, 0.96, 3.32)}
#: Spheres that are pressed together without gravity, by friction: φ, z, φ z of rigid ones, and how φ z grows with
#: softness down to κ_p = 10³ and below it; frictions above 1 have the numbers of the last one
#: (studies/pressed_cells.nc, κ_p from 18 to 1e5). With much friction a tenth of the hard ones carry nothing.
PRESSED: Final = {
    0.0: (0.63, 6.0, 3.66, 3.1, 3.1),
    0.1: (0.61, 5.2, 3.05, 3.5, 3.3),
    0.3: (0.59, 4.7, 2.48, 5.0, 3.8),
    0.5: (0.59, 4.5, 2.16, 6.0, 4.9),
    1.0: (0.58, 4.4, 2.02, 7.5, 5.1),
}
#: Least and largest φ z over these, by the first packing fraction, rate, damping and tangential springs.
PREPARED: Final = (0.92, 1.09)
#: Mean of the normal stresses over that of a piston, by friction: at a stiffness number of 10³ and more under it,
#: and its decrease in a decade below (studies/pistons.nc). Without friction it is that of settled beds.
UNIAXIAL: Final = {
    0.0: (0.96, 0.0),
    0.1: (0.84, 0.045),
    0.3: (0.80, 0.095),
    0.5: (0.775, 0.1),
    1.0: (0.765, 0.11),
}
#: Its relative error, by rate, size and law, and the least stiffness number at which it was measured.
UNIAXIAL_ERROR, UNIAXIAL_TO = 0.1, 17.0
#: Least one of softer grains, below this κ_p: cells and triaxial boxes that YADE compresses at κ_p from 50 to 500 have
#: 0.85 to 1.
SOFTER, LEAST_OF_SOFTER = 1e3, 0.85
#: Decrease of φ z over the standard deviation of the radii in units of their mean, and the largest that was measured:
#: small grains between large ones carry nothing.
NARROWER, MEASURED_WIDTH = 0.5, 0.2 / math.sqrt(3.0)
#: Largest m ω²/k_n of smooth spheres, and q m ω²/(2/3 k_t) of spheres that turn: value at z = 0 and slope, from the
#: contact networks of these beds. Of disks, those of six neighbours, which no packing of equal ones exceeds.
MOVED: Final = {3: (3.8, 0.38), 2: (6.0, 0.0)}
TURNED: Final = {3: (8.0, 1.23), 2: (12.0, 0.0)}
#: Mean of the normal stresses over that along gravity in settled beds of unequal spheres with friction: 0.82 to 0.97.
UNEQUAL_SHARE: Final = 0.86
#: Mean overlap at the floor between side walls over that of a wide bed, less one, times the width over the diameter, at
#: most: packings are looser at walls, and their stresses more alike. In 18 boxes in LAMMPS, 4 to 14 diameters wide
#: (μ = 0.5, ε = 0.5), it was 2.4 or less. The second is where the contacts that carry the pressure were counted.
BESIDE_WALLS, BESIDE_WALLS_COUNTED = 2.4, 1.0
#: Standard deviations by which the springs to the neighbours of the fastest grains exceed the mean.
SPREAD: Final = 1.3
#: Share of the tangential springs in the motion of grains, which mostly roll; power of the mean over both motions.
DRAGGED, MIXED = 0.5, 10.0


def settled(friction: float, dimension: int = 3, poured: bool = False) -> Packing:
    """Grains with this coefficient of friction that have come to rest under gravity; ``poured``: from a height."""
    if dimension == 2:
        return DISKS[friction > 0.0]
    values = [np.interp(friction, list(SETTLED), column) for column in zip(*SETTLED.values(), strict=True)]
    if poured:
        raised = np.minimum(np.multiply(values[:4], POURED), SETTLED[0.0][:4])
        values[:4] = np.maximum(values[:4], raised)
    fraction, contacts, share, rigid, softer = map(float, values)
    return Packing(fraction, contacts, share, rigid, softer, excess=EXCESS["settled", friction > 0.0])


def pressed(friction: float) -> Packing:
    """Spheres with this coefficient of friction that are pressed together without gravity."""
    fraction, contacts, rigid, softer, soft = (
        float(np.interp(friction, list(PRESSED), column)) for column in zip(*PRESSED.values(), strict=True)
    )
    return Packing(
        fraction,
        contacts,
        rigid=rigid,
        softer=softer,
        soft=soft,
        softest=PRESSED_FROM,
        excess=EXCESS["pressed", friction > 0.0],
        wider=-NARROWER,
        widest=MEASURED_WIDTH,
        prepared=PREPARED if friction > 0.0 else None,
    )


# --- formulas -------------------------------------------------------------------------------------------------


def most_layers(count: float | None, dimension: int) -> int:
    """Layers of so many grains in a slender column, at most 100; None: their number is not known."""
    if count is None:
        return LAYERS
    layers = float((SLENDER ** (dimension - 1) * count) ** (1.0 / dimension))
    return max(1, math.ceil(min(LAYERS, layers)))


def under_piston(friction: float, kappa: float) -> float:
    """Mean of the normal stresses over that of a piston, at the stiffness number under the latter."""
    share, decrease = (
        float(np.interp(friction, list(UNIAXIAL), column)) for column in zip(*UNIAXIAL.values(), strict=True)
    )
    return share - decrease * math.log10(SOFTER / min(max(kappa, UNIAXIAL_TO), SOFTER))


def mean_force(pressure: float, diameter: float, carrying: float, dimension: int) -> float:
    """Mean contact force [N] of equal grains under a pressure [Pa]; in two dimensions [N/m]. ``carrying``: φ z."""
    return math.pi * diameter ** (dimension - 1) * pressure / carrying


def compression(force: Force, load: float) -> float:
    """Mean overlap [m] under a mean static force [N]."""
    spread = HERTZ_SPREAD if force.powers.elastic == HERTZ else 1.0
    return float(spread * (load / force.stiffness) ** (4.0 / force.powers.elastic))


def stiffness_number(force: Force, pressure: float, first: float, second: float, dimension: int) -> float:
    """κ_p of grains with these radii [m]; (K d^P/(p d^(D−1)))^(1/P) for other powers P than those above."""
    diameter, power = first + second, 0.25 * force.powers.elastic
    stress = pressure * diameter ** (dimension - 3)
    if force.powers.elastic == HERTZ:
        modulus = 0.75 * force.stiffness / math.sqrt(first * second / diameter)
        return float((modulus / stress) ** (2.0 / 3.0))
    return float((force.stiffness * diameter ** (power - 2.0) / stress) ** (1.0 / power))


def inertial_number(shear_rate: float, diameter: float, density: float, pressure: float) -> float:
    """I = γ̇ d √(ρ/p)."""
    return abs(shear_rate) * diameter * math.sqrt(density / pressure)


def collisional_from(restitution: float, kappa: float | None, friction: float | None) -> float:
    """Inertial number above which contacts last less than twice as long as a collision, on average.

    Outside the measured ranges it is that of their ends, of larger κ_p that of the formula, rather too low; of unknown
    κ_p or friction a low one.
    """
    elastic, dissipative, power = SEPARATING
    loss = 1.0 - max(restitution, LEAST_RESTITUTION)
    shares = list(FRICTION_SHARE.values())
    share = min(shares) if friction is None else float(np.interp(friction, list(FRICTION_SHARE), shares))
    border = (elastic + dissipative * loss) * (max(kappa or STIFF_FLOW, SOFTEST_FLOW) / RIGID) ** -power
    return float(share * border)


def separating(cases: Sequence[Case], kappa: float | None, speed_unit: float) -> float:
    """:func:`collisional_from` of grains with these contacts: the lowest of their frictions."""
    frictions = {case.friction.coefficient for case in cases if case.second is not None} or {None}
    return min(collisional_from(bounciest(cases, speed_unit), kappa, friction) for friction in frictions)


def bounciest(cases: Sequence[Case], speed_unit: float) -> float:
    """Largest ε of the contacts between grains; 1 if one is not known. ``speed_unit``: 1 m/s in their units."""
    pairs = [case for case in cases if case.second is not None]
    if not pairs or any(case.force is None for case in pairs):
        return 1.0
    return max(restitution_of(case, speed * speed_unit) for case in pairs for speed in FLOW_SPEEDS)


def regime(inertial: float, border: float) -> str:
    """The regime of a flow with this inertial number, which is collisional from the border on."""
    if inertial < min(QUASI_STATIC, border):
        return "quasi-static"
    return "dense" if inertial < border else "collisional"


def shaking_strength(shaking: float, gravity: float, frequency: float, diameter: float) -> float:
    """S = (A ω)²/(g d) of a floor with Γ = A ω²/g and the angular frequency ω (Eshuis et al. 2007)."""
    return (shaking * gravity / frequency) ** 2 / (gravity * diameter)


def weight(height: float, density: float, gravity: float) -> float:
    """Pressure [Pa] at the bottom of a bed of this height [m] and bulk density [kg/m³]; in two dimensions [N/m]."""
    return density * gravity * height


def largest_eigenvalue(
    springs: Springs, mass: float, coordination: float, inertia: float, dimension: int
) -> float:
    """Largest ω² [1/s²] of the contact network of equal grains with these springs, all contacts sticking.

    One grain between fixed neighbours in all directions has z k_n/(D m), and turning z k_t (1 − 1/D) D'/(q m) with
    D' = 1 of spheres, 2 of disks. The highest modes are those around grains with the most neighbours, so that their
    frequencies grow slowly with z: :data:`MOVED`, :data:`TURNED`, within 3 % of the beds for k_t/k_n from 0 to 1.5.
    """
    (moved, more), (turned, faster) = MOVED[dimension], TURNED[dimension]
    normal = (moved + more * coordination) * (springs.normal + DRAGGED * springs.tangential)
    turning = (turned + faster * coordination) * (1.0 if dimension == 2 else 2.0 / 3.0)
    tangential = 0.0 if math.isinf(inertia) else turning * springs.tangential / inertia
    largest = max(normal, tangential)
    if not largest > 0.0:
        return 0.0
    mixed = (normal / largest) ** MIXED + (tangential / largest) ** MIXED
    return float(largest * mixed ** (1.0 / MIXED) / mass)


class Springs(NamedTuple):
    """Springs and dashpots of a contact at its compression."""

    normal: float  #: k_n [N/m]
    tangential: float = 0.0  #: k_t [N/m]; 0 without friction
    normal_damping: float = 0.0  #: γ_n [N s/m]
    tangential_damping: float = 0.0  #: γ_t [N s/m]

    def stiffened(self, step: float) -> Springs:
        """The undamped springs with the same stability at this time step, k + 2 γ/h."""
        return Springs(
            self.normal + 2.0 * self.normal_damping / step,
            self.tangential + 2.0 * self.tangential_damping / step,
        )


def stable_step(eigenvalue: Callable[[float], float]) -> float:
    """Longest stable time step [s] of velocity Verlet, h² λ(h) = 4; infinite without springs.

    λ(h) is the largest eigenvalue with the springs k + 2 γ/h. With the damping force at the velocity half a step
    earlier, as in LAMMPS, LIGGGHTS and YADE, a motion that changes sign at each step has det(4 M − 2 h C − h² K) = 0,
    with mass, damping and stiffness; for one oscillator it is h ω = 2 (√(1 + ζ²) − ζ). h = 2/√λ(h) has one solution,
    since h² λ grows with h.
    """
    if eigenvalue(math.inf) > 0.0:
        highest = 2.0 / math.sqrt(eigenvalue(math.inf))
    elif eigenvalue(1.0) > 0.0:  # dashpots alone: λ(h) = λ(1)/h
        return 4.0 / eigenvalue(1.0)
    else:
        return math.inf

    def excess(share: float) -> float:  # of the highest step, since brentq's tolerance is absolute, too
        step = share * highest
        return step * math.sqrt(eigenvalue(step)) - 2.0

    lowest = 1.0
    while excess(lowest) > 0.0:
        lowest *= 0.5
    return (
        highest if lowest == 1.0 else highest * float(scipy.optimize.brentq(excess, lowest, 1.0, rtol=1e-9))
    )


# --- contacts ---------------------------------------------------------------------------------------------------


def springs_of(case: Case, overlap: float) -> Springs | None:
    """The springs of a contact of known bodies at an overlap; None if its tangential force is not known."""
    assert case.force is not None
    bodies = case.first.tried(0), None if case.second is None else case.second.tried(0)
    force = case.force(*bodies, 1.0)
    p, q = 0.25 * force.powers.elastic, 0.25 * force.powers.damping
    normal, damping = p * force.stiffness * overlap ** (p - 1.0), force.damping * overlap**q
    if case.friction.coefficient == 0.0:
        return Springs(normal, 0.0, damping)
    make_terms = case.friction.terms or case.friction.sticking
    if make_terms is None:
        return None
    terms = make_terms(*bodies, 1.0)
    tangential = terms.stiffness * overlap ** (0.25 * terms.stiffness_power)
    return Springs(normal, tangential, damping, terms.damping * overlap ** (0.25 * terms.damping_power))


@dataclass(frozen=True)
class Loaded:
    """A contact of two grains, or of a grain and a wall, under a pressure, in the units of its case."""

    case: Case
    force: Force
    pressure: float | None
    packing: Packing
    dimension: int

    @property
    def radii(self) -> tuple[float, float]:
        """Of both grains; at a wall twice that of the grain."""
        first, second = self.case.first, self.case.second or self.case.first
        assert first.radius is not None and second.radius is not None
        return first.radius, second.radius

    @property
    def compression(self) -> float | None:
        """Mean overlap; None if it is not known."""
        if self.pressure is None:
            return None
        stress = self.pressure * self.packing.stress_share
        carrying = self.packing.carrying(self.mean_stiffness_number or 0.0, self.dimension)
        return compression(self.force, mean_force(stress, sum(self.radii), carrying, self.dimension))

    @property
    def stiffness_number(self) -> float | None:
        """κ_p under the pressure of which this contact has its share."""
        if self.pressure is None:
            return None
        return stiffness_number(self.force, self.pressure, *self.radii, self.dimension)

    @property
    def mean_stiffness_number(self) -> float | None:
        """κ_p under the mean of the normal stresses."""
        if self.pressure is None:
            return None
        stress = self.pressure * self.packing.stress_share
        return stiffness_number(self.force, stress, *self.radii, self.dimension)

    @property
    def springs(self) -> Springs | None:
        """The springs at the mean overlap; None if they are not known."""
        overlap = self.compression
        if overlap is None:
            return springs_of(self.case, 1.0) if self.linear else None
        return springs_of(self.case, overlap)

    @property
    def linear(self) -> bool:
        """Whether its springs and dashpots are known and the same at each overlap."""
        powers, terms = self.force.powers, springs_of(self.case, 1.0)
        constant = (powers.elastic, powers.damping) == (4, 0) and terms == springs_of(self.case, 0.5)
        return constant and terms is not None

    def eigenvalue(self, springs: Springs) -> float:
        """Largest ω² [1/s²] of a packing with these contacts, or of a grain that touches only this wall."""
        bodies = [body for body in (self.case.first, self.case.second) if body is not None]
        mass = min(body.mass for body in bodies if body.mass is not None)
        inertia = min(body.inertia_factor for body in bodies)
        if self.case.second is None:
            turned = 0.0 if math.isinf(inertia) else springs.tangential * (1.0 + 1.0 / inertia)
            return max(springs.normal, turned) / mass
        return largest_eigenvalue(springs, mass, self.packing.coordination, inertia, self.dimension)


def loaded(cases: Sequence[Case], pressure: float | None, packing: Packing, dimension: int) -> list[Loaded]:
    """The contacts whose sizes, masses and forces are known, without those that stick."""
    contacts = []
    for case in cases:
        bodies = [body for body in (case.first, case.second) if body is not None]
        if case.force is None or any(body.radius is None or body.mass is None for body in bodies):
            continue
        force = case.force(case.first.tried(0), None if case.second is None else case.second.tried(0), 1.0)
        if not isinstance(force, AdhesiveForce):
            contacts.append(Loaded(case, force, pressure, packing, dimension))
    return contacts


def softened(contacts: Sequence[Loaded]) -> list[Loaded]:
    """The contacts in a packing of spheres as soft as they are; as they are without pressure, and of disks."""
    kappas = [contact.mean_stiffness_number for contact in contacts if contact.case.second is not None]
    known = [kappa for kappa in kappas if kappa is not None]
    if not known or contacts[0].dimension != 3:
        return list(contacts)
    packing = contacts[0].packing.softened(min(known))
    return [replace(contact, packing=packing) for contact in contacts]


@dataclass(frozen=True)
class Mixed:
    """Grains of several kinds: the contact of each two kinds under their share of the pressure."""

    kinds: Sequence[mixture.Kind]
    pairs: Sequence[Sequence[Loaded]]
    kappa: float  #: of the softest pair under the mean of the normal stresses

    @property
    def overlaps(self) -> np.ndarray:
        """Mean overlap of the contacts between each two kinds."""
        contact = self.pairs[0][0]
        assert contact.pressure is not None
        shares = mixture.pairs(self.kinds)
        stress = contact.pressure * contact.packing.stress_share
        carrying = contact.packing.carrying(self.kappa, contact.dimension, shares.width)
        load = mixture.mean_force(self.kinds, stress, carrying)
        loads = load * shares.forces
        return np.array(
            [
                [compression(pair.force, f) for pair, f in zip(*row, strict=True)]
                for row in zip(self.pairs, loads, strict=True)
            ]
        )

    @property
    def overlap(self) -> float:
        """Mean overlap over the smaller radius, of all contacts."""
        smaller = np.array([[min(pair.radii) for pair in row] for row in self.pairs])
        return float((mixture.pairs(self.kinds).contacts * self.overlaps / smaller).sum())

    @property
    def springs(self) -> list[list[Springs]] | None:
        """Of the contacts between each two kinds; None if they are not known."""
        rows = [
            [springs_of(pair.case, overlap) for pair, overlap in zip(*row, strict=True)]
            for row in zip(self.pairs, self.overlaps, strict=True)
        ]
        known = [[springs for springs in row if springs is not None] for row in rows]
        return known if all(len(row) == len(self.kinds) for row in known) else None

    def eigenvalue(self, rows: Sequence[Sequence[Springs]]) -> float:
        """Largest ω² [1/s²]: around grains of the kind with the fastest motion.

        Springs to heavier grains count less, up to half. The neighbours of the fastest ones differ from the mean by a
        standard deviation and more: 1 to 13 % below the step of beds up to radii of 1:3 (studies/mixtures.nc).
        """
        shares, largest = mixture.pairs(self.kinds), 0.0
        ends = shares.contacts.sum(axis=0)
        for k, row in enumerate(rows):
            bodies = [pair.case.first for pair in self.pairs[k]], [pair.case.second for pair in self.pairs[k]]
            own = np.array([body.mass for body in bodies[0] if body is not None])
            others = np.array([body.mass for body in bodies[1] if body is not None])
            weights = 0.5 * (1.0 + own / others)
            normal, tangential = (
                _mean_and_spread(weights * [getattr(springs, name) for springs in row], ends)
                for name in ("normal", "tangential")
            )
            z = self.pairs[k][k].packing.coordination * float(shares.neighbours[k])
            inertia = min(body.inertia_factor for part in bodies for body in part if body is not None)
            springs = Springs(normal, tangential)
            largest = max(largest, largest_eigenvalue(springs, float(own[0]), z, inertia, 3))
        return largest


def _mean_and_spread(values: np.ndarray, weights: np.ndarray) -> float:
    """Mean, and above it the spread of what the neighbours of the fastest grains may be."""
    mean = float(values @ weights)
    return mean + SPREAD * math.sqrt(max(float((values - mean) ** 2 @ weights), 0.0))


def mixed(contacts: Sequence[Loaded], kinds: Sequence[mixture.Kind]) -> Mixed | None:
    """The contacts of kinds of spheres from those of their types; None if they or their pressure are not known."""
    types = {frozenset(pair.case.types): pair for pair in reversed(contacts) if pair.case.second is not None}
    if not kinds or not contacts or contacts[0].dimension != 3 or contacts[0].pressure is None:
        return None
    rows = []
    for kind in kinds:
        pairs = [types.get(frozenset((kind.type, other.type))) for other in kinds]
        row = [
            _between(pair, kind, other) for pair, other in zip(pairs, kinds, strict=True) if pair is not None
        ]
        if len(row) < len(kinds):
            return None
        rows.append(row)
    kappa = min(pair.mean_stiffness_number or 0.0 for row in rows for pair in row)
    return Mixed(kinds, rows, kappa)


def _between(pair: Loaded, first: mixture.Kind, second: mixture.Kind) -> Loaded:
    """The contact of two kinds."""
    case = pair.case
    bodies = [case.first, case.second]
    if case.types[0] != first.type:
        bodies.reverse()
    sized = [
        _sized(body, kind) for body, kind in zip(bodies, (first, second), strict=True) if body is not None
    ]
    known = replace(case, types=(first.type, second.type), first=sized[0], second=sized[1])
    assert case.force is not None
    return replace(pair, case=known, force=case.force(sized[0].tried(0), sized[1].tried(0), 1.0))


def _sized(body: Body, kind: mixture.Kind) -> Body:
    """A grain of the size of its kind."""
    assert body.radius is not None and body.mass is not None
    density = kind.density or body.density or body.mass / (UNIT_BALL[3] * body.radius**3)
    return replace(body, radius=kind.radius, mass=density * UNIT_BALL[3] * kind.radius**3, density=density)


def largest_stable_step(contacts: Sequence[Loaded], mix: Mixed | None = None) -> float | None:
    """Longest stable time step of a packing with these contacts; None if it is not known.

    A wall whose contacts are stiffer than those of grains counts beside half of the network: its grain is held by them.
    Without the kinds in ``mix`` the lightest grains count as a packing of their own, with the stiffest contacts.
    """
    each = [(contact, contact.springs) for contact in contacts]
    known = [(contact, springs) for contact, springs in each if springs is not None]
    pairs = [(contact, springs) for contact, springs in known if contact.case.second is not None]
    walls = [(contact, springs) for contact, springs in known if contact.case.second is None]
    if not pairs or len(known) < len(each):
        return None

    of_kinds = None if mix is None else mix.springs

    def eigenvalue(step: float) -> float:
        if mix is not None and of_kinds is not None:
            network = mix.eigenvalue([[springs.stiffened(step) for springs in row] for row in of_kinds])
        else:
            network = max(contact.eigenvalue(springs.stiffened(step)) for contact, springs in pairs)
        beside = max((contact.eigenvalue(springs.stiffened(step)) for contact, springs in walls), default=0.0)
        return max(network, 0.5 * network + beside)

    longest = stable_step(eigenvalue)
    return longest if math.isfinite(longest) else None


def rigid_up_to(contacts: Sequence[Loaded]) -> float | None:
    """Largest pressure under which κ_p of all contacts is at least that of rigid grains: κ_p ∝ p^(−1/P)."""
    each = [(contact, replace(contact, pressure=1.0).stiffness_number) for contact in contacts]
    limits = [
        (kappa / RIGID) ** (0.25 * contact.force.powers.elastic)
        for contact, kappa in each
        if kappa is not None
    ]
    return min(limits, default=None)


def of_any_size(
    state: GrainState, cases: Sequence[Case], pressure: float | None, packing: Packing, dimension: int
) -> GrainState:
    """The state of grains of unknown sizes with the numbers that are the same for all, as with given moduli."""
    tries = []
    for k in range(3):
        contacts = loaded([_tried(case, k) for case in cases], pressure, packing, dimension)
        if not _pairs(contacts):
            return state
        if pressure is None:
            tries.append(replace(state, pressure_for_rigid=rigid_up_to(_pairs(contacts))))
        else:
            tries.append(_softened(state, contacts))
    for name in ("pressure_for_rigid", "stiffness_number", "overlap"):
        values = [getattr(each, name) for each in tries]
        if None not in values and max(values) > (1.0 + AGREEMENT) * min(values):
            return state
    return tries[0]


def _tried(case: Case, k: int) -> Case:
    """A contact with trial values in place of unknown sizes and masses."""

    def known(body: Body) -> Body:
        trial = body.tried(k)
        mass = trial.mass if body.mass is None else body.mass
        return replace(body, radius=trial.radius, mass=mass)

    return replace(case, first=known(case.first), second=case.second and known(case.second))


# --- the state --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Load:
    """What a script, a dump or options say of the pressure on grains; in the units of the script."""

    name: str  #: "rest", "pressed", "flow", "shaken" or "gas"
    pressure: float | None = None
    origin: str = ""  #: of the pressure, in words
    weight: bool = False  #: whether it is the weight above, not the mean of the normal stresses
    bound: bool = False  #: whether it is at most this
    walled_floor: float | None = None  #: area of the floor between side walls, in two dimensions its width
    unloaded: bool = False  #: whether it is at least this, as after a run that prescribed more
    sparse: bool = False  #: whether grains are too few to cover the floor, and may lie beside each other
    uniaxial: bool = False  #: whether it is the stress along one axis, and nothing prescribes the others
    friction: float = 0.0  #: largest coefficient of the grains
    packing: Packing | None = None  #: as measured in a dump, or given
    kinds: tuple[mixture.Kind, ...] = ()  #: of the grains, if they are known and differ
    shear_rate: float | None = None
    gravity: float | None = None
    density: float | None = None  #: largest one of the grains
    shaking: float | None = None  #: Γ
    frequency: float | None = None  #: angular, of the shaking
    tilt: float | None = None  #: angle [°] between gravity and the nearest axis
    slope_inertial_number: tuple[float, float] | None = None  #: of a deep layer at this tilt
    rest_angle: float | None = None  #: [°] below which such a layer comes to rest
    froude_number: float | None = None  #: of a drum
    centrifuging_radius: float | None = None  #: of a drum of Froude number 1
    mixer_froude_number: float | None = None  #: of what turns about gravity, at the side of the box
    layers: int = LAYERS  #: below which numbers are given if the pressure is not known
    highest: float = math.inf  #: height of the box, which they do not exceed
    speed_unit: float = 1.0  #: 1 m/s
    concentration: float = 1.0  #: force on a sphere of a clump over that on a sphere like it

    @property
    def on_contacts(self) -> float | None:
        """The pressure under which spheres have the forces of these contacts."""
        return None if self.pressure is None else self.concentration * self.pressure


@dataclass(frozen=True)
class GrainState:
    """How grains are held together, or kept in motion; returned by :func:`hardlimit.check`. None: not known.

    In SI units, or in ``lj`` units as in the script. In two dimensions pressures are forces per length.
    """

    name: str  #: "rest", "pressed", "flow", "shaken", or "gas" if nothing holds them together
    pressure: float | None = None  #: p [Pa]; at rest under gravity at the bottom
    pressure_from: str | None = None  #: where it comes from, in words
    pressure_is_bound: bool = False  #: whether p is at most this: a box full of grains, or walls beside them
    pressure_is_least: bool = False  #: whether grains may still hold a part of a larger one of a run before
    packing_fraction: float | None = None  #: φ that was used, measured or expected
    coordination: float | None = None  #: contacts of a grain that were used, measured or expected
    overlap: float | None = None  #: δ/R, mean overlap of contacts over the smaller radius
    overlap_range: tuple[float, float] | None = None  #: δ/R of pressed grains, by how they were compressed
    smooth_overlap: float | None = None  #: δ/R if these were pressed together before they got their friction
    overlap_of: str | None = None  #: "all contacts", or "the softest contacts" if the kinds are not known
    deepest_overlap: float | None = None  #: δ/R of the deepest contacts of equal grains
    stiffness_number: float | None = None  #: κ_p
    packing_excess: float | None = None  #: φ of such beds with friction over that of rigid ones, less one
    coordination_excess: float | None = None  #: the same of the number of contacts
    measured_from: float | None = None  #: least κ_p of measured packings, if that of these grains is less
    stiffness: str | None = None  #: name of the number that sets the stiffness
    stiffness_for_rigid: float | None = None  #: its value at κ_p = 10⁴, in the unit of the script
    stiffness_unit: str | None = None  #: this unit; empty in lj units
    pressure_for_rigid: float | None = None  #: [Pa] up to which κ_p is at least 10⁴, if p is not known
    height_for_rigid: float | None = None  #: [m] of a bed with this pressure at its bottom
    layers: int | None = None  #: if p is not known: 100, or fewer of few grains or in a low box
    layers_height: float | None = None  #: [m] of these layers
    layers_fill: bool = False  #: whether they are fewer because they fill the box
    layers_stiffness_number: float | None = None  #: κ_p below them
    layers_overlap: float | None = None  #: δ/R below them
    largest_stable_step: float | None = None  #: longest stable time step [s]
    step_is_supposed: bool = False  #: whether it is that below these layers, or for rigid grains
    step_is_bound: bool = False  #: whether it is a bound, as p is, on the other side
    step_share: float | None = None  #: the time step over it
    grains: int | None = None  #: one or two, or 0 that meet walls only: numbers of an impact
    never_meet: bool = False  #: whether no grain meets another or a wall, so that t_c ν = 0
    supposed_tc_nu: float | None = None  #: t_c ν of a gas of which φ or the speed is supposed
    tc_nu_is_bound: bool = False  #: whether it is at most this, as in a stream into open space
    impact_speed: float | None = None  #: [m/s] of this impact
    speed_is_chosen: bool = False  #: whether no speed is known
    restitution: float | None = None  #: ε of this impact
    duration: float | None = None  #: [s] of its contact
    inertial_number: float | None = None  #: I = γ̇ d √(ρ/p)
    inertial_number_needs: tuple[str, ...] = ()  #: of a flow, the options that it lacks
    largest_inertial_number: float | None = None  #: that below one layer of grains, if p has only a bound
    regime: str | None = None  #: "quasi-static", "dense" or "collisional"; None if p below its bound decides
    collisional_from: float | None = None  #: I where contacts last twice as long as a collision
    shaking: float | None = None  #: Γ = A ω²/g
    shaking_strength: float | None = None  #: S = (A ω)²/(g d)
    tilt: float | None = None  #: angle [°] between gravity and the nearest axis, as in chutes
    slope_inertial_number: tuple[float, float] | None = None  #: range of I of a deep layer at this tilt
    rest_angle: float | None = None  #: [°] below which such a layer comes to rest
    froude_number: float | None = None  #: Fr = ω²R/g of a drum
    rolling_radius: float | None = None  #: 0.01 g/ω² [m], with Fr = 0.01, if such a drum holds grains
    centrifuging_radius: float | None = None  #: g/ω² [m], with Fr = 1, of a drum of unknown radius
    mixer_froude_number: float | None = None  #: ω²R/g of blades that turn about gravity, at the box's side

    @property
    def may_separate(self) -> bool:
        """Whether grains flow so fast, or may flow so fast down a slope, that their contacts are not said to last.

        :meta private:
        """
        border, slope = self.collisional_from, self.slope_inertial_number
        if self.froude_number is not None and self.froude_number >= THROWN:
            return True
        if self.inertial_number is not None:
            return self.regime in (None, "collisional")
        if (self.mixer_froude_number or 0.0) >= STIRRED:
            return True
        return border is not None and slope is not None and slope[1] >= border

    @property
    def may_slide(self) -> bool:
        """Whether grains may flow down a slope of this angle, as deep layers do.

        :meta private:
        """
        slope = self.slope_inertial_number
        return slope[1] > 0.0 if slope is not None else (self.tilt or 0.0) >= STEEP

    def to_dict(self) -> dict[str, Any]:
        """As plain values.

        :meta private:
        """
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}


GAS: Final = GrainState("gas")


def grain_state(cases: Sequence[Case], load: Load, time_step: float | None, dimension: int) -> GrainState:
    """The state of grains with these contacts, in the units of their cases."""
    moving = [case for case in cases if case.second is None or math.isfinite(case.first.mass or 1.0)]
    state = _held_together(moving, load, time_step, dimension)
    if state.inertial_number is None and state.slope_inertial_number is None:
        return state
    kappa, inertial, bound = state.stiffness_number, state.inertial_number, state.pressure_is_bound
    border = separating(moving, None if bound and inertial is None else kappa, load.speed_unit)
    if inertial is None:
        return replace(state, collisional_from=border)
    if not bound:
        return replace(state, collisional_from=border, regime=regime(inertial, border))
    layer = grain_state(cases, _below_a_layer(load, moving, state, dimension), time_step, dimension)
    agree = regime(inertial, border) == layer.regime
    return replace(
        state,
        largest_inertial_number=layer.inertial_number,
        collisional_from=layer.collisional_from,
        regime=layer.regime if agree else None,
    )


def _of_repulsion(moving: Sequence[Case], load: Load, packing: Packing, dimension: int) -> float | None:
    """κ_p of adhesive grains without their adhesion, which adds to the overlap; None if it is not known of all."""
    pairs = [case for case in moving if case.second is not None]
    bare = [replace(case, force=case.repulsion) for case in pairs if case.repulsion is not None]
    known = [each.stiffness_number for each in loaded(bare, load.pressure, packing, dimension)]
    numbers = [number for number in known if number is not None]
    return min(numbers) if numbers and len(numbers) == len(pairs) else None


def _below_a_layer(load: Load, cases: Sequence[Case], state: GrainState, dimension: int) -> Load:
    """The least pressure in a bed, below one layer of grains: there I is largest and the collisional border lowest."""
    diameter, density = _grain(cases, load.kinds, dimension)
    assert state.pressure and diameter and density and load.gravity
    across = load.gravity * math.cos(math.radians(load.tilt or 0.0))
    least = weight(diameter, (state.packing_fraction or 0.0) * density, across)
    return replace(load, pressure=min(least, state.pressure), bound=False)


def _held_together(moving: Sequence[Case], load: Load, time_step: float | None, dimension: int) -> GrainState:
    """The state of grains whose contacts have these cases, without the regime of its flow."""
    diameter, density = _grain(moving, load.kinds, dimension)
    if load.name == "shaken" and load.shaking is not None:
        strength = None
        if load.shaking and load.gravity and load.frequency and diameter:
            strength = shaking_strength(load.shaking, load.gravity, load.frequency, diameter)
        return GrainState("shaken", shaking=load.shaking, shaking_strength=strength)
    if load.name == "gas":
        return GAS
    rough = any(case.friction.coefficient != 0.0 for case in moving)
    bed = load.packing or settled(0.5 if rough else 0.0, dimension)
    if rough and dimension == 3 and len({kind.radius for kind in load.kinds}) > 1:
        bed = bed._replace(stress_share=UNEQUAL_SHARE)
    if rough and load.bound and load.walled_floor and diameter:
        excess = BESIDE_WALLS_COUNTED if bed.rigid is None else BESIDE_WALLS
        width = load.walled_floor ** (1.0 / (dimension - 1))
        bed = bed._replace(stress_share=bed.stress_share * (1.0 + excess * diameter / width))
    packing = bed if load.weight else bed._replace(stress_share=1.0)
    contacts = loaded(moving, load.on_contacts, packing, dimension)
    if load.uniaxial and not load.weight:
        axial = min((pair.stiffness_number or math.inf for pair in _pairs(contacts)), default=math.inf)
        share = under_piston(load.friction, axial)
        packing = packing._replace(stress_share=share, uncertain=UNIAXIAL_ERROR)
        contacts = loaded(moving, load.on_contacts, packing, dimension)
    contacts = softened(contacts)
    packing = contacts[0].packing if contacts else packing
    mix = mixed(contacts, load.kinds)
    longest = largest_stable_step(contacts, mix) if len(contacts) == len(moving) else None
    inertial, lacking = None, tuple[str, ...]()
    if load.shear_rate is not None and load.pressure and diameter and density:
        inertial = inertial_number(load.shear_rate, diameter, density, load.pressure)
    elif load.name == "flow":
        lacking = _lacking(load, moving)
    state = GrainState(
        name=load.name,
        pressure=load.pressure,
        pressure_from=load.origin or None,
        pressure_is_bound=load.bound,
        pressure_is_least=load.unloaded,
        packing_fraction=packing.packing_fraction,
        coordination=packing.coordination,
        largest_stable_step=longest,
        inertial_number=inertial,
        inertial_number_needs=lacking,
        shaking=load.shaking,
        tilt=load.tilt,
        slope_inertial_number=load.slope_inertial_number,
        rest_angle=load.rest_angle,
        froude_number=load.froude_number,
        rolling_radius=_rolling_radius(load, diameter),
        centrifuging_radius=load.centrifuging_radius,
        mixer_froude_number=load.mixer_froude_number,
    )
    if (
        load.pressure is not None
        and not _pairs(contacts)
        and (repulsion := _of_repulsion(moving, load, packing, dimension))
    ):
        return replace(state, stiffness_number=repulsion)
    if not contacts:
        return of_any_size(state, moving, load.on_contacts, packing, dimension)
    if load.pressure is None:
        state = _supposed(state, load, bed, contacts, diameter, len(moving))
    if longest := state.largest_stable_step:
        unsure = (load.bound or load.unloaded) and not all(contact.linear for contact in contacts)
        used = None if time_step is None else time_step / longest
        state = replace(state, step_is_bound=unsure or load.sparse, step_share=used)
    if load.pressure is None or not _pairs(contacts):
        return state
    state = _softened(state, contacts, mix)
    kappa = state.stiffness_number or 0.0
    if dimension == 3 and kappa < packing.softest:
        return replace(state, measured_from=packing.softest)
    if dimension == 2 or not rough:
        return state
    denser, more = packing.excess
    return replace(state, packing_excess=denser / kappa, coordination_excess=more / math.sqrt(kappa))


def _rolling_radius(load: Load, diameter: float | None) -> float | None:
    """Radius up to which a drum rolls; None without one, and if it has no room for grains of this diameter."""
    radius = 0.01 * (load.centrifuging_radius or 0.0)
    return radius if radius >= NARROWEST * (diameter or 0.0) and radius > 0.0 else None


def _supposed(
    state: GrainState,
    load: Load,
    packing: Packing,
    contacts: Sequence[Loaded],
    diameter: float | None,
    number: int,
) -> GrainState:
    """The state with its numbers up to the pressure for rigid grains, and under gravity below so many layers of grains.

    ``number``: of all contacts, of which those with known numbers are given.
    """
    border, pressure = rigid_up_to(_pairs(contacts)), None
    if border is not None:
        border /= load.concentration
        pressure = load.concentration * border
    state, under = replace(state, pressure_for_rigid=border), list(contacts)
    if load.gravity and load.density and load.name != "pressed" and border is not None and diameter:
        heavy = weight(1.0, packing.packing_fraction * load.density, load.gravity)
        layers = max(1, min(load.layers, math.ceil(min(load.highest / diameter, LAYERS))))
        pressure = load.concentration * heavy * layers * diameter
        under = softened([replace(contact, packing=packing, pressure=pressure) for contact in contacts])
        below = _softened(state, under, mixed(under, load.kinds))
        state = replace(
            state,
            height_for_rigid=border / heavy,
            layers=layers,
            layers_height=layers * diameter,
            layers_fill=layers < load.layers,
            layers_stiffness_number=below.stiffness_number,
            layers_overlap=below.overlap,
        )
    if state.largest_stable_step is not None or pressure is None or len(contacts) < number:
        return state
    under = [replace(contact, pressure=pressure) for contact in under]
    longest = largest_stable_step(under, mixed(under, load.kinds))
    return replace(state, largest_stable_step=longest, step_is_supposed=longest is not None)


def _pairs(contacts: Sequence[Loaded]) -> list[Loaded]:
    """Those between grains."""
    return [contact for contact in contacts if contact.case.second is not None]


def _softened(state: GrainState, contacts: Sequence[Loaded], mix: Mixed | None = None) -> GrainState:
    """The state with the numbers of its softest contact, and the mean overlap of all kinds if they are known."""
    pairs = _pairs(contacts)
    numbers = [pair.stiffness_number or 0.0 for pair in pairs]
    least = min(numbers) * (1.0 + AGREEMENT)  # which all disks with one spring have
    softest = [pair for pair, number in zip(pairs, numbers, strict=True) if number <= least]
    contact = max(softest, key=lambda pair: (pair.compression or 0.0) / min(pair.radii))
    differ = len(softest) < len(pairs) or len({pair.radii for pair in pairs}) > 1
    kappa, overlap, spring = contact.stiffness_number, contact.compression, contact.case.spring
    assert kappa is not None and overlap is not None
    deepest = LARGEST_FORCE ** (4.0 / contact.force.powers.elastic)
    rigid = None
    if spring is not None:
        _, value, power = spring
        rigid = value * (RIGID / kappa) ** (0.25 * contact.force.powers.elastic / power)
    mean = overlap / min(contact.radii) if mix is None else mix.overlap
    return replace(
        state,
        overlap=mean,
        **_prepared(mean, contact, kappa),
        overlap_of="the softest contacts" if mix is None and differ else "all contacts",
        deepest_overlap=None if mix is not None or differ else overlap / min(contact.radii) * deepest,
        stiffness_number=kappa,
        stiffness=None if spring is None else spring[0],
        stiffness_for_rigid=rigid,
    )


def _lacking(load: Load, moving: Sequence[Case]) -> tuple[str, ...]:
    """The options that give the inertial number of a flow."""
    sized = [case.first for case in moving if case.first.radius]
    known = {
        "shear": load.shear_rate is not None,
        "pressure": bool(load.pressure),
        "radius": bool(sized),
        "density": any(body.mass for body in sized)
        or (not sized and any(case.first.density for case in moving)),
    }
    return tuple(name for name, is_known in known.items() if not is_known)


def _prepared(overlap: float, contact: Loaded, kappa: float) -> dict[str, Any]:
    """The overlaps of pressed grains that were compressed in other ways than that of this mean overlap."""
    packing, power = contact.packing, 4.0 / contact.force.powers.elastic
    if packing.prepared is None or contact.dimension != 3:
        return {}
    least, most = packing.prepared
    least = min(least, LEAST_OF_SOFTER) if kappa < SOFTER else least
    least, most = least / (1.0 + packing.uncertain), most / (1.0 - packing.uncertain)
    smooth = packing.carrying(kappa, 3) / pressed(0.0).carrying(kappa, 3)
    return {
        "overlap_range": (overlap * most**-power, overlap * least**-power),
        "smooth_overlap": overlap * smooth**power,
    }


def _grain(
    cases: Sequence[Case], kinds: Sequence[mixture.Kind], dimension: int
) -> tuple[float | None, float | None]:
    """Mean diameter and density of the grains that move, the latter in two dimensions that of disks.

    The diameter is the mean by number if the kinds are known, else that of the ends of the types.
    """
    bodies = {
        (name, body.radius, body.mass)
        for case in cases
        for name, body in zip(case.types, (case.first, case.second), strict=True)
        if body is not None and body.radius and body.mass and math.isfinite(body.mass) and not body.fixed
    }
    if not bodies:
        return None, None
    radius = math.fsum(radius for _, radius, _ in bodies) / len(bodies)
    if kinds:
        radius = math.fsum(kind.share * kind.radius for kind in kinds) / math.fsum(
            kind.share for kind in kinds
        )
    densities = [mass / (UNIT_BALL[dimension] * radius**dimension) for _, radius, mass in bodies]
    return 2.0 * radius, math.fsum(densities) / len(densities)
