"""The numbers of the friction of one contact of a check."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol

import numpy as np

from .. import _core
from ..contact import frictional_contact
from ..contact.friction import LIMITS, FrictionTerms
from ..contact.frictional_contact import ANGLES
from ..contact.impact import FrictionalContact
from ..convert.force import Force
from ..convert.friction import error_of_step

#: Solid spheres: I = q m R².
SPHERE: Final = 2.0 / 5.0
#: The angle [rad] at which other versions of a code are compared.
OBLIQUE: Final = np.array(ANGLES[9:10])


class RigidBody(Protocol):
    """A body that may spin."""

    @property
    def mass(self) -> float:
        """[kg]; infinite if it does not move."""

    @property
    def inertia_factor(self) -> float:
        """I/(m R²)."""


#: The terms of two bodies, the second of which is None at a wall, at a speed; and β at :data:`OBLIQUE`.
MakeTerms = Callable[[Any, Any, float], FrictionTerms]
MakeRestitution = Callable[[Any, Any, float], float]


class FrictionLaw(NamedTuple):
    """The friction of the contacts of two types."""

    coefficient: float | None = 0.0  #: of sliding friction; None if not known
    model: str | None = None  #: tangential model, as the script or our laws name it
    terms: MakeTerms | None = None  #: None if they are not known
    not_known: str | None = None  #: why
    others: tuple[tuple[str, MakeRestitution], ...] = ()  #: in other versions of the code
    sticking: MakeTerms | None = None  #: those that hold until the surfaces slip, where no others are known


@dataclass(frozen=True)
class CheckedFriction:
    """The friction of a contact; returned by :func:`hardlimit.check`. None stands for what is not known."""

    coefficient: float | None = 0.0  #: μ of sliding friction; 0 for smooth grains
    model: str | None = None  #: tangential model, by its name in the script or in :class:`Friction`
    stiffness_ratio: float | None = None  #: k_t over the stiffness dF/dξ, at the largest compression
    damping_ratio: float | None = None  #: tangential over normal damping, there
    limit: str | None = None  #: what μ F_n limits: "total" or "spring"
    sticks_below: float | None = None  #: angle of impact [rad] below which they do not slip on approach
    slides_beyond: float | None = None  #: angle [rad] beyond which they do not stick on separation
    tangential_restitution: tuple[tuple[float, float], ...] = ()  #: angle [rad] and β; 0 is the limit
    effective_tangential_restitution: float | None = None  #: β0 of the constant rule in a gas
    half_period: float | None = None  #: of the tangential spring, over the duration of the contact
    steps_per_half_period: int | None = None  #: whole time steps
    tangential_restitution_error_of_step: float | None = None  #: error of β by the time step
    not_known: str | None = None  #: why numbers are not known
    other_versions: tuple[tuple[str, float], ...] = ()  #: versions of the code in words, and β at 45° there
    changed_by_attraction: float | None = None  #: largest difference of β from that without attraction
    changed_by_limit: float | None = None  #: largest difference of β from that of the limit "total"

    def to_dict(self) -> dict[str, Any]:
        """As plain values.

        :meta private:
        """
        named = {name: getattr(self, name) for name in self.__dataclass_fields__}
        pairs = {
            name: [list(pair) for pair in named[name]]
            for name in ("tangential_restitution", "other_versions")
        }
        return {**named, **pairs}


#: Contacts without friction.
SMOOTH_LAW, SMOOTH = FrictionLaw(), CheckedFriction()
#: Names of the numbers of a contact that are results, but the table of β.
RESULTS: Final = (
    *("stiffness_ratio", "damping_ratio", "sticks_below", "slides_beyond"),
    *("effective_tangential_restitution", "half_period", "steps_per_half_period"),
    *("tangential_restitution_error_of_step", "changed_by_attraction", "changed_by_limit"),
)


def contact_of(
    make: MakeTerms, force: Force, bodies: tuple[RigidBody, RigidBody | None], speed: float
) -> FrictionalContact:
    """The contact of two bodies, the second of which is None at a wall."""
    first, second = bodies
    inverse = _core.inverse_tangential_mass(
        first.mass,
        first.inertia_factor,
        math.inf if second is None else second.mass,
        SPHERE if second is None else second.inertia_factor,
    )
    coefficients, terms = (force.stiffness, force.damping), make(first, second, speed)
    return FrictionalContact(force.powers.arguments, coefficients, force.effective_mass, 1.0 / inverse, terms)


def numbers(
    contact: FrictionalContact, force: Force, speed: float, time_step: float | None, dimension: int
) -> dict[str, Any]:
    """All results, and β by the number of its angle; those that do not exist are infinite or NaN, or are missing."""
    own = frictional_contact.in_own_units(contact, speed)
    collision = Force(force.powers, 1.0, own.coefficients[1], 1.0).collision(1.0)
    results, half_period = ratios(own, collision.compression), frictional_contact.half_period(own, 1.0)
    if not collision.restitution > 0.0:
        return results
    results["half_period"] = half_period
    if frictional_contact.is_too_stiff(own):
        return results
    results["sticks_below"], results["slides_beyond"] = frictional_contact.borders(own, 1.0)
    results |= {f"β {k}": beta for k, (_, beta) in enumerate(frictional_contact.table(own, 1.0))}
    results |= _changes(own)
    effective = frictional_contact.effective_restitution(own, 1.0, dimension)
    results["effective_tangential_restitution"] = effective
    if time_step is not None:
        step = time_step / force.scales(speed)[1]
        results["steps_per_half_period"] = half_period * collision.duration / step
        results["tangential_restitution_error_of_step"] = error_of_step(own, step)
    return results


def _changes(own: FrictionalContact) -> dict[str, float]:
    """How much the conventions of a code change β at any angle of the table."""
    elastic, damped, _ = own.powers
    others = {
        "changed_by_attraction": own._replace(powers=(elastic, damped, False)),
        "changed_by_limit": own._replace(terms=own.terms._replace(limit=LIMITS.index("total"))),
    }
    tables = {name: frictional_contact.table(contact, 1.0) for name, contact in others.items()}
    usual = frictional_contact.table(own, 1.0)
    return {
        name: max(
            (abs(here - there) for (_, here), (_, there) in zip(usual, table, strict=False)), default=0.0
        )
        for name, table in tables.items()
    }


def ratios(own: FrictionalContact, compression: float) -> dict[str, Any]:
    """Tangential over normal stiffness and damping at a compression."""
    terms, (elastic, damped, _) = own.terms, own.powers
    p, q = 0.25 * elastic, 0.25 * damped
    stiffness = terms.stiffness * compression ** (0.25 * terms.stiffness_power)
    damping = terms.damping * compression ** (0.25 * terms.damping_power)
    normal = own.coefficients[1] * compression**q
    return {
        "limit": LIMITS[terms.limit],
        "stiffness_ratio": stiffness / (p * compression ** (p - 1.0)),
        "damping_ratio": damping / normal if normal > 0.0 else 0.0 if damping == 0.0 else None,
    }


def friction_of(law: FrictionLaw, results: Mapping[str, Any]) -> CheckedFriction:
    """The friction of a contact from those of its results that are known."""
    known = {
        name: value
        for name, value in results.items()
        if isinstance(value, str) or math.isfinite(value or 0.0)
    }
    steps = known.get("steps_per_half_period")
    fields: dict[str, Any] = {name: known.get(name) for name in (*RESULTS, "limit")}
    fields["steps_per_half_period"] = None if steps is None else math.floor(steps)
    table = [(angle, known.get(f"β {k}")) for k, angle in enumerate(ANGLES)]
    others = [(when, known.get(f"other {when}")) for when, _ in law.others]
    return CheckedFriction(
        coefficient=law.coefficient,
        model=law.model,
        not_known=law.not_known,
        tangential_restitution=tuple((angle, beta) for angle, beta in table if beta is not None),
        other_versions=tuple((when, beta) for when, beta in others if beta is not None),
        **fields,
    )
