"""Conversion of a restitution into the numbers of contacts and the input of particle codes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from .. import _core
from ..boxes.time_step import accepted_error
from ..contact.balls import FLOOR, Ball, Floor
from ..support import validation
from ..support.formatting import listed
from . import texts
from .codes import Code, Model, Pair, TangentialInput, Written, code, names
from .force import Force
from .formulas import Numbers
from .friction import FrictionNumbers, FrictionOfModel, Walton, friction_of_model, stiffness_ratio
from .wanted import LAWS, Wanted

#: Largest number of sizes.
MAX_BODIES: Final = 30


@dataclass(frozen=True)
class ContactNumbers:
    """One contact under our own law, which is never attractive; returned by :func:`hardlimit.convert`."""

    pair: str  #: the bodies, such as ``1 – 2`` or ``1 – wall``
    effective_mass: float  #: [kg]
    effective_radius: float  #: [m]
    stiffness: float  #: k [N/m], or K of K ξ^(3/2) [N/m^1.5]
    damping: float  #: factor of ξ^q dξ/dt: γ [N s/m] of the linear law, else [N s/m^(1 + q)]
    duration: float  #: [s]
    compression: float  #: largest [m]
    force: float  #: largest [N]
    time_step: float  #: [s], with the error ``restitution_error`` of ε; NaN if the bodies stay together
    restitution_error: float  #: error of ε by the time step
    stiffness_ratio: float | None = None  #: k_t/k_n for β0, NaN if none has it; None for smooth grains


@dataclass(frozen=True)
class ModelNumbers:
    """One contact in a model of a code; returned by :func:`hardlimit.convert`."""

    pair: str  #: the bodies, such as ``1 – 2`` or ``1 – wall``
    numbers: Numbers | None  #: for the input of the code; None if it cannot have this restitution
    restitution: float  #: ε that they produce; NaN without numbers
    usual: Numbers | None  #: the numbers that a user who does not know the code's formulas would give
    usual_restitution: float  #: ε that these produce; NaN without numbers
    time_step: float  #: [s], with the error ``restitution_error`` of ε
    restitution_error: float  #: error of ε by the time step
    friction: FrictionNumbers | None = None  #: None for smooth grains, or if the code's friction is not known


@dataclass(frozen=True)
class ModelConversion:
    """All contacts in a model of a code, and its input; returned by :func:`hardlimit.convert`."""

    code: Code  #: its name, title, version and sources
    model: Model  #: its name, title and formulas
    attraction: bool  #: whether the force attracts at the end of a contact
    contacts: tuple[ModelNumbers, ...]  #: each pair of sizes, and each size with a wall
    text: str  #: ready to paste
    friction: TangentialInput | None = None  #: how it gets friction; None if it has none

    def __repr__(self) -> str:
        pairs = ", ".join(contact.pair for contact in self.contacts)
        return f"<ModelConversion to {self.code.name} {self.model.name}: {pairs}>"


@dataclass(frozen=True)
class Conversion:
    """A restitution in the numbers of particle codes; returned by :func:`hardlimit.convert`."""

    wanted: Wanted  #: the wanted restitution and stiffness
    contacts: tuple[ContactNumbers, ...]  #: each pair of sizes, and each size with a wall
    models: tuple[ModelConversion, ...]  #: of the named code, or of all

    @property
    def text(self) -> str:
        """The input of all models, ready to paste."""
        return "\n\n".join(model.text for model in self.models)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain dictionaries, in SI units.

        Returns
        -------
        dict
        """
        return {
            "wanted": asdict(self.wanted),
            "contacts": [asdict(contact) for contact in self.contacts],
            "models": [
                {
                    "code": conversion.code.name,
                    "version": conversion.code.version,
                    "checked": conversion.code.checked,
                    "sources": conversion.code.sources,
                    "model": conversion.model.name,
                    "attraction": conversion.attraction,
                    "contacts": [asdict(contact) for contact in conversion.contacts],
                    "text": conversion.text,
                }
                for conversion in self.models
            ],
        }

    def __repr__(self) -> str:
        names = ", ".join(f"{conversion.code.name} {conversion.model.name}" for conversion in self.models)
        pairs = ", ".join(contact.pair for contact in self.contacts)
        return f"Conversion(restitution={self.wanted.restitution:g}, contacts=[{pairs}], models=[{names}])"


@dataclass(frozen=True)
class Stepping:
    """Choice of the time step: a given step, or the longest one with a given error of ε."""

    error: float
    time_step: float | None

    def of(self, force: Force, speed: float) -> tuple[float, float]:
        """The step [s] and its error of ε."""
        if self.time_step is None:
            return force.longest_step(speed, self.error), self.error
        return self.time_step, force.error_of_step(speed, self.time_step)


def converted(
    balls: Any,
    wanted: Wanted,
    wall: bool,
    named: Any,
    model: Any,
    attraction: bool,
    restitution_error: Any,
    time_step: Any,
) -> Conversion:
    """As :func:`hardlimit.convert`."""
    pairs = _pairs(balls, validation.flag("wall", wall))
    attracts = validation.flag("attraction", attraction)
    stepping = stepping_of(restitution_error, time_step)
    forces = [wanted.force(pair.mass, pair.radius) for pair in pairs]
    chosen = _chosen(named, model, wanted.law)
    listed = (balls,) if isinstance(balls, Ball) else tuple(balls)
    if named is not None:
        for ball in listed:
            _refuse_light(chosen[0][0], ball)
    chosen = [choice for choice in chosen if not any(_too_light(choice[0], ball) for ball in listed)]
    return Conversion(
        wanted,
        tuple(_contact(pair, force, wanted, stepping) for pair, force in zip(pairs, forces, strict=True)),
        tuple(_in_model(*choice, pairs, forces, wanted, attracts, stepping) for choice in chosen),
    )


def _refuse_light(source: Code, body: Any) -> None:
    """Refuse a ball that is too light for the code."""
    if isinstance(body, Ball) and _too_light(source, body):
        inertia = 0.4 * body.mass * body.radius**2
        raise ValueError(
            f"radius | mass: got a ball with a moment of inertia of {inertia:.3g} kg m², must be > "
            f"{source.least_inertia:g} kg m² in {source.title}, which refuses lighter bodies: use other units there"
        )


def _too_light(source: Code, ball: Ball) -> bool:
    return min(ball.mass, 0.4 * ball.mass * ball.radius**2) <= source.least_inertia


def _pairs(balls: Any, wall: bool) -> list[Pair]:
    """All contacts, those of balls first."""
    listed = (balls,) if isinstance(balls, Ball) else validation.instances("balls", balls, Ball, "Ball")
    if not 1 <= len(listed) <= MAX_BODIES:
        raise ValueError(f"balls: got {len(listed)}, must be 1 to {MAX_BODIES}")
    pairs = [
        pair_of(ball, listed[j], i + 1, j + 1) for i, ball in enumerate(listed) for j in range(i, len(listed))
    ]
    return pairs + [pair_of(ball, FLOOR, i + 1, i + 1) for i, ball in enumerate(listed)] * bool(wall)


def pair_of(ball: Any, other: Any, i: int, j: int) -> Pair:
    if not isinstance(ball, Ball):
        raise ValueError(f"ball: got {validation.shown(ball)}, must be a Ball")
    if not isinstance(other, Ball | Floor):
        raise ValueError(f"other: got {validation.shown(other)}, must be a Ball or FLOOR")
    at_wall = isinstance(other, Floor)
    name = f"{i} – wall" if at_wall else f"{i} – {j}"
    mass, radius = _core.effective(ball.mass, other.mass), _core.effective(ball.radius, other.radius)
    return Pair(name, mass, radius, at_wall, i, j)


def stepping_of(error: Any, time_step: Any) -> Stepping:
    if error is not None and time_step is not None:
        raise ValueError("restitution_error | time_step: got both, must be at most one of them")
    if time_step is not None:
        return Stepping(math.nan, validation.number("time_step", time_step, 0.0))
    return Stepping(accepted_error(error), None)


def _chosen(name: Any, model: Any, law: str) -> list[tuple[Code, Model]]:
    """The selected models: one by its name, or those with the powers of the law, of which there may be none."""
    powers = LAWS[law]
    if name is None and model is not None:
        raise ValueError("code: missing, must be given beside model")
    if name is not None and model is not None:
        source = code(name)
        selected = source.model(model)
        if selected.powers(False).elastic != powers.elastic:
            raise ValueError(
                f"model: got {model!r}, must have the elastic force of the law, not {selected.elastic}"
            )
        return [(source, selected)]
    only = None if name is None else code(name)
    fitting = (powers.elastic, powers.damping)
    matching = [
        (source, m)
        for source in map(code, names())
        for m in source.models
        if (m.powers(False).elastic, m.powers(False).damping) == fitting and m.damping.formula != "none"
    ]
    chosen = [(source, m) for source, m in matching if only in (None, source)]
    if name is not None and not chosen:
        if not matching:
            raise ValueError(f"law: got {law!r}, which no code has, must be another law, or code left out")
        known = ", ".join(dict.fromkeys(source.name for source, _ in matching))
        raise ValueError(f"code: got {name!r}, which has no model of this law, must be one of {known}")
    return chosen


def _contact(pair: Pair, force: Force, wanted: Wanted, stepping: Stepping) -> ContactNumbers:
    collision = force.collision(wanted.speed)
    step, error = stepping.of(force, wanted.speed)
    walton = wanted.walton
    ratio = None if walton is None else stiffness_ratio(force, wanted.speed, walton)
    return ContactNumbers(
        pair=pair.name,
        effective_mass=pair.mass,
        effective_radius=pair.radius,
        stiffness=force.stiffness,
        damping=force.damping,
        duration=collision.duration,
        compression=collision.compression,
        force=collision.force,
        time_step=step,
        restitution_error=error,
        stiffness_ratio=ratio,
    )


def _in_model(
    source: Code,
    model: Model,
    pairs: Sequence[Pair],
    forces: Sequence[Force],
    wanted: Wanted,
    attraction: bool,
    stepping: Stepping,
) -> ModelConversion:
    contacts = [
        (Written(model, pair, wanted.speed, attraction, wanted.poisson_ratio), force.stiffness)
        for pair, force in zip(pairs, forces, strict=True)
    ]
    rows = [_row(*contact, wanted, stepping) for contact in contacts]
    writable = [k for k, row in enumerate(rows) if row.numbers is not None]
    friction = None
    if wanted.walton is not None and model.friction and writable:
        friction = friction_of_model(
            source, model, [contacts[k] for k in writable], wanted.restitution, wanted.walton
        )
        for k, normal, row in zip(writable, friction.normal, friction.rows, strict=True):
            rows[k] = replace(rows[k], numbers=normal or rows[k].numbers, friction=row)
    text = _text(source, model, [(pairs[k], rows[k]) for k in writable], wanted, attraction, friction)
    return ModelConversion(
        source,
        model,
        model.powers(attraction).attracts,
        tuple(rows),
        text,
        None if friction is None else friction.way,
    )


def _text(
    source: Code,
    model: Model,
    rows: Sequence[tuple[Pair, ModelNumbers]],
    wanted: Wanted,
    attraction: bool,
    friction: FrictionOfModel | None,
) -> str:
    """The input of contacts that have numbers; a comment if they cannot have the wanted friction."""
    if not rows:
        return ""
    way = None if friction is None else friction.way
    if wanted.walton is not None and way is None:
        return texts.comment(
            source,
            f"{source.title} {model.name}: {refused_friction([row for _, row in rows], wanted.walton)}",
        )
    step = min(row.time_step for _, row in rows)
    contacts = [(pair, {**(row.numbers or {}), **placeholders(row.friction, wanted)}) for pair, row in rows]
    return texts.written(source, model, contacts, attraction, step, way)


def placeholders(friction: FrictionNumbers | None, wanted: Wanted) -> Numbers:
    """The numbers of friction by their placeholders in the input."""
    if friction is None or friction.numbers is None or wanted.walton is None:
        return {}
    named = {f"tangential_{name}": value for name, value in friction.numbers.items()}
    mu = wanted.walton.coefficient
    return {**named, "friction": mu, "friction_angle": math.atan(mu)}


def refused_friction(rows: Sequence[ModelNumbers], walton: Walton) -> str:
    """Why contacts have no input with friction."""
    if any(row.friction is None for row in rows):
        return "how this code computes friction is not known here"
    possible = [(row.pair, row.friction.reachable) for row in rows if row.friction is not None]
    beta = walton.tangential_restitution
    outside = [pair for pair in possible if not any(low <= beta <= high for low, high in pair[1])]
    name, ranges = (outside or possible)[0]
    texts_of = [f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}" for low, high in ranges]
    if not ranges:
        return f"no tangential restitution stands for the friction of {name} in a gas"
    return f"no numbers give {name} a tangential restitution of {beta:g}, only {listed(texts_of, 'or')}"


def _row(written: Written, stiffness: float, wanted: Wanted, stepping: Stepping) -> ModelNumbers:
    try:
        return _numbers(written, stiffness, wanted, stepping)
    except (OverflowError, ZeroDivisionError):  # beyond double precision
        return ModelNumbers(
            pair=written.pair.name,
            numbers=None,
            restitution=math.nan,
            usual=None,
            usual_restitution=math.nan,
            time_step=math.nan,
            restitution_error=math.nan,
        )


def _numbers(written: Written, stiffness: float, wanted: Wanted, stepping: Stepping) -> ModelNumbers:
    numbers = written.numbers(stiffness, wanted.restitution)
    usual = written.usual_numbers(stiffness, wanted.restitution)
    obtained, step, error = math.nan, math.nan, math.nan
    if numbers is not None:
        force = written.force(numbers)
        obtained = force.collision(wanted.speed).restitution
        step, error = stepping.of(force, wanted.speed)
    usually = math.nan if usual is None else written.force(usual).collision(wanted.speed).restitution
    return ModelNumbers(
        pair=written.pair.name,
        numbers=numbers,
        restitution=obtained,
        usual=usual,
        usual_restitution=usually,
        time_step=step,
        restitution_error=error,
    )
