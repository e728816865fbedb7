"""``hl.convert_back``: the restitution that a contact in an input of a code really has."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from ..contact.balls import Ball, Floor
from ..convert.codes import Code, Model
from ..convert.codes import code as code_of
from ..convert.conversion import pair_of, stepping_of
from ..convert.force import MAX_SPEED, MIN_SPEED, AdhesiveForce, Force
from ..convert.formulas import Numbers
from ..support import validation
from ..support.units import SYSTEMS
from .cases import ModelForce, energy_density, force_of, friction_of
from .contacts import KnownBody, collision_of
from .friction import SMOOTH, CheckedFriction, FrictionLaw, contact_of, numbers
from .friction import friction_of as checked_friction
from .scripts import CODES, ContactSettings, Stage, read_text
from .scripts.description import WALL
from .scripts.statements import refusal
from .scripts.yade_stages import NUMERICAL_DAMPING

#: Relative difference of two forces from rounding.
ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Obtained:
    """The contact that an input of a code really produces; returned by :func:`hardlimit.convert_back`."""

    code: Code  #: its name, title, version and sources
    model: Model  #: its name, title and formulas
    attraction: bool  #: whether the force attracts at the end of a contact
    numbers: Numbers  #: as read, in SI units
    numerical_damping: float  #: damping of the integrator, as a fraction of every force
    restitution: float  #: 0 if the bodies stay together
    duration: float  #: [s]
    compression: float  #: largest [m]
    force: float  #: largest [N]
    time_step: float  #: [s]; NaN if the bodies stay together
    restitution_error: float  #: error of ε by the time step
    notes: tuple[str, ...]  #: remarks
    friction: CheckedFriction = SMOOTH  #: what friction does: β over angles, and β0 in a gas

    def __repr__(self) -> str:
        return f"<Obtained from {self.code.name} {self.model.name}: restitution {self.restitution:.6g}>"

    def to_dict(self) -> dict[str, Any]:
        """Everything as a plain dictionary, in SI units.

        Returns
        -------
        dict
        """
        plain = asdict(replace(self, code=None, model=None))  # type: ignore[arg-type]
        named = {"code": self.code.name, "version": self.code.version, "model": self.model.name}
        return {**plain, **named, "friction": self.friction.to_dict()}


def convert_back(
    text: str,
    ball: Ball,
    other: Ball | Floor | None = None,
    *,
    code: str,
    model: str | None = None,
    speed: float = 1.0,
    restitution_error: float | None = None,
    time_step: float | None = None,
    contact: str | None = None,
) -> Obtained:
    """Compute the restitution that an input of a code really produces.

    ``restitution_error`` and ``time_step`` are those of :func:`convert`.

    Parameters
    ----------
    text : str
        Lines of input, such as ``convert(…).text``.
    ball : Ball
    other : Ball or FLOOR, optional
        The other body; by default another ``ball``.
    code : str
        "lammps", "liggghts" or "yade".
    model : str, optional
        Name of the contact model; by default it is found in the input.
    speed : float [m/s]
        Impact speed.
    contact : str, optional
        Selects a contact if the input has several with different forces: ``"1-2"`` or ``"1-wall"`` by types, or
        ``"1-floor"`` by the name of a wall, as listed in the error message. Types of YADE are materials by their
        labels, or by their numbers from 1.

    Returns
    -------
    Obtained

    Raises
    ------
    ValueError
        If a value is outside its range, the input has no model of the code or several, a statement that affects a
        contact is not understood (quoted with its line), or contacts have different forces and none is selected.

    Notes
    -----
    A force that never attracts ends the contact early: Schwager & Pöschel, Granular Matter 9, 465 (2007). The text is
    read as by :func:`check`, at its last run; nothing in it is executed. A part of a script is enough, such as the
    lines that :func:`convert` writes, and is in SI units unless it sets others. YADE's numerical damping d multiplies
    decelerating forces by 1 + d and accelerating forces by 1 − d; an elastic contact then gives √((1 − d)/(1 + d)).

    Examples
    --------
    >>> line = "hooke 1e4 0.7 damping coeff_restitution limit_damping"
    >>> found = hl.convert_back(line, hl.Ball(1e-3, density=2500.0), code="lammps")
    >>> round(found.restitution, 4)
    0.7182
    """
    source = code_of(validation.one_of("code", code, CODES))
    second = ball if other is None else other
    wall = pair_of(ball, second, 1, 1).wall
    if not isinstance(text, str):
        raise ValueError(f"input: got {validation.shown(text)}, must be a text")
    if contact is not None and not isinstance(contact, str):
        raise ValueError(f"contact: got {validation.shown(contact)}, must be a name such as '1-2'")
    v = validation.number("speed", speed, MIN_SPEED, MAX_SPEED)
    stepping = stepping_of(restitution_error, time_step)
    models = source.models if model is None else [source.model(model)]
    bodies = KnownBody(ball.radius, ball.mass), None if wall else KnownBody(second.radius, second.mass)
    stage, version = _last_stage(text, source, contact)
    contacts, damping = _selected(stage, source, wall, contact), stage.numerical_damping
    units = stage.units if stage.units in SYSTEMS else "si"
    forms = [_form(settings, source, models, version or source.version, units) for _, settings in contacts]
    names = [name for name, _ in contacts]
    try:
        force = _only_force([form(*bodies, v) for form in forms], names, contact)
        step, error = stepping.of(force, v)
        frictions = [
            _friction(friction_of(source, settings, form), force, bodies, v, step, stage.dimension)
            for (_, settings), form in zip(contacts, forms, strict=True)
        ]
        collision = collision_of(force, v, damping)
        notes = [*_notes(source, damping, force, v)]
        newest = None if version else force_of(source, contacts[0][1], None, models, units)
        if newest and newest.model != forms[0].model:
            changed = collision_of(newest(*bodies, v), v, damping).restitution
            notes.append(f"since {source.title} {newest.others[0][0]}, ε = {changed:.4g}")
    except (OverflowError, ZeroDivisionError):
        written = ", ".join(f"{name} {value:.6g}" for name, value in forms[0].numbers.items())
        raise ValueError(
            f"input: got {written}, must give a compression and a duration within the range of double precision"
        ) from None
    return Obtained(
        code=source,
        model=forms[0].model,
        attraction=forms[0].attraction,
        numbers=forms[0].numbers,
        numerical_damping=damping or 0.0,
        restitution=collision.restitution,
        duration=collision.duration,
        compression=collision.compression,
        force=collision.force,
        time_step=step,
        restitution_error=error,
        notes=tuple(notes),
        friction=_only_friction(frictions, names, contact),
    )


def _last_stage(text: str, source: Code, contact: str | None) -> tuple[Stage, str | None]:
    """The last run with contacts, and the version that a log states. Ranges of types include those of ``contact``."""
    types = [int(word) for word in re.findall(r"\d{1,6}", contact or "") if source.name == "lammps"]
    try:
        script = read_text(
            text.removeprefix("\ufeff"), code=source.name, types_seen=max(types, default=0), part=True
        )
    except ValueError as error:
        message = str(error).partition(": give them with --var")[0]
        raise ValueError(message.replace("script: ", "input: ", 1)) from None
    if script.refused:
        raise ValueError(script.refused[0])
    stages = [stage for stage in script.stages if stage.contacts]
    if not stages:
        raise ValueError(f"input: has no granular contacts of {source.title}")
    stage = stages[-1]
    if stage.units_given and stage.units not in SYSTEMS:
        known = ", ".join(SYSTEMS)
        raise ValueError(
            f"input: got units {stage.units}, must be units {known}, which can be converted to SI"
        )
    return stage, script.version


def _selected(
    stage: Stage, source: Code, wall: bool, wanted: str | None
) -> list[tuple[str, ContactSettings]]:
    """The selected contacts with their names, such as ``1-2``, or ``1-floor`` for a wall of that name."""
    named = [
        (_name(contact, contact.wall or contact.types[1], source), contact) for contact in stage.contacts
    ]
    fitting = [(name, contact) for name, contact in named if (contact.types[1] == WALL) == wall]
    if not fitting:
        kind = "a ball and a wall" if wall else "balls"
        raise ValueError(f"input: got no contact of {kind}, only {named[0][0]}")
    if wanted is None:
        return fitting
    ends = [end.replace(" ", "") for end in wanted.replace("–", "-").split("-")]
    orders = {"-".join(ends), "-".join(reversed(ends))}
    selected = [(name, contact) for name, contact in fitting if name.replace(" ", "") in orders]
    if wall and not selected:
        selected = [pair for pair in fitting if _name(pair[1], WALL, source).replace(" ", "") in orders]
    if not selected:
        choices = ", ".join(dict.fromkeys(name for name, _ in fitting))
        raise ValueError(f"contact: got {validation.shown(wanted)}, must be one of {choices}")
    return selected


def _name(contact: ContactSettings, second: str, source: Code) -> str:
    """The name of a contact with a second body. Materials of YADE count from 1."""
    ends = (contact.types[0], second)
    return "-".join(str(int(end) + 1) if source.name == "yade" and end.isdecimal() else end for end in ends)


def _form(
    contact: ContactSettings, source: Code, models: Sequence[Model], version: str | None, units: str
) -> ModelForce:
    """The force of a contact, with its numbers in SI units."""
    if contact.adhesion and energy_density(contact) is None:
        quote = contact.quotes[0]
        raise refusal(quote.line, quote.text, f"be without {contact.adhesion}")
    return force_of(source, contact, version, models, units)


def _only_force(forces: Sequence[Force], names: Sequence[str], wanted: str | None) -> Force:
    """The force of all contacts."""
    if not all(_alike(force, forces[0]) for force in forces):
        raise _several(names, wanted, "forces")
    return forces[0]


def _friction(
    law: FrictionLaw,
    force: Force,
    bodies: tuple[KnownBody, KnownBody | None],
    speed: float,
    time_step: float,
    dimension: int,
) -> CheckedFriction:
    """What the friction of a contact does at this speed."""
    results: dict[str, Any] = {}
    if law.coefficient and law.terms is not None and not isinstance(force, AdhesiveForce):
        contact = contact_of(law.terms, force, bodies, speed)
        step = None if math.isnan(time_step) else time_step
        results = numbers(contact, force, speed, step, dimension)
    return checked_friction(law, results)


def _only_friction(
    frictions: Sequence[CheckedFriction], names: Sequence[str], wanted: str | None
) -> CheckedFriction:
    """The friction of all contacts."""
    if any(friction != frictions[0] for friction in frictions):
        raise _several(names, wanted, "friction")
    return frictions[0]


def _several(names: Sequence[str], wanted: str | None, what: str) -> ValueError:
    got = "missing" if wanted is None else f"got {validation.shown(wanted)}"
    choices = ", ".join(dict.fromkeys(names))
    return ValueError(f"contact: {got}, must be one of {choices}, which have different {what} in the input")


def _alike(force: Force, other: Force) -> bool:
    """Whether two forces differ by rounding only."""
    names = ("stiffness", "damping", "energy_density")
    pairs = [(getattr(force, name, 0.0), getattr(other, name, 0.0)) for name in names]
    return force.powers == other.powers and all(math.isclose(a, b, rel_tol=ROUNDING) for a, b in pairs)


def _notes(source: Code, damping: float | None, force: Force, speed: float) -> Iterator[str]:
    """Remarks on numerical damping, for a code that has one."""
    if source.name != "yade":
        return
    if damping is None:
        default = force.numerically_damped(speed, NUMERICAL_DAMPING).restitution
        yield (
            f"without NewtonIntegrator in the input, its damping is taken as 0; its default, {NUMERICAL_DAMPING}, "
            f"gives ε = {default:.4g}"
        )
    elif damping > 0.0:
        yield (
            f"NewtonIntegrator's damping of {damping:g} acts on each body separately: this ε holds at a "
            "wall, or for two bodies whose common centre of mass is at rest"
        )
