"""The check of a script, a text, a system or a ball: contacts, dump, findings and the answer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from ..boxes.system import ParticleSystem
from ..boxes.time_step import DEFAULT_ERROR, accepted_error
from ..contact.balls import Ball
from ..contact.contact import Law
from ..convert.codes import code
from ..convert.force import MAX_SPEED, MIN_SPEED
from ..support import validation
from ..support.formatting import digits, listed, percent
from ..support.units import SYSTEMS
from . import answer, cases, corrections, drive, dumps
from .contacts import Case, CheckedContact, Surroundings, examine
from .expectation import checked_packing_fraction
from .result import CheckedStage, Finding, Verdict
from .scripts import Description, Grains, Note, Quote, Stage
from .scripts import read as read_script

#: Units of mass, length and time in SI; ``lj`` stays as it is.
SCALES: Final = {**SYSTEMS, "lj": (1.0, 1.0, 1.0)}
NO_RUN: Final = Stage(Quote("", 0, ""), None, False, None, (), {}, None, None)
#: Largest overlap over the radius that contact laws describe.
COMPRESSED: Final = 0.05
#: Impact speeds [m/s] at which contacts are shown if no speed is given and they depend on it.
CHOSEN_SPEEDS: Final = (0.01, 0.1, 1.0)
#: Units of force and length of each system of units.
UNIT_NAMES: Final = {"si": ("N", "m"), "cgs": ("dyn", "cm"), "micro": ("nN", "µm"), "nano": ("pN", "nm")}
#: Powers of mass, length and time in the numbers of a contact.
POWERS: Final = {
    "radius": (0, 1, 0),
    "other_radius": (0, 1, 0),
    "density": (1, -3, 0),
    "speed": (0, 1, -1),
    "duration": (0, 0, 1),
    "time_step": (0, 0, 1),
    "rayleigh_time": (0, 0, 1),
    "p_wave_time": (0, 0, 1),
}


@dataclass(frozen=True)
class Given:
    """The options of a check, in SI units or in those of a script in ``lj`` units."""

    dump: Path | None
    speeds: tuple[float, ...]
    packing_fraction: float | None
    variables: Mapping[str, str]
    drive: drive.Drive | None = None
    restitution_error: float = DEFAULT_ERROR


def checked(
    source: Any,
    code: Any,
    dump: Any,
    speed: Any,
    variables: Any,
    packing_fraction: Any,
    law: Any,
    time_step: Any,
    dimension: Any,
    power: Any,
    shear_rate: Any,
    restitution_error: Any,
) -> Verdict:
    """As :func:`hardlimit.check`."""
    if not isinstance(source, str | Path | ParticleSystem | Ball):
        raise ValueError(
            f"source: got {validation.shown(source)}, must be a path, a text, a ParticleSystem or a Ball"
        )
    if not isinstance(variables, Mapping):
        raise ValueError(f"variables: got {validation.shown(variables)}, must be values by name")
    speeds = _speeds(speed)
    given = Given(
        None if dump is None else validation.path("dump", dump),
        speeds,
        packing_fraction,
        {str(name): str(value) for name, value in variables.items()},
        drive.checked_drive(power, shear_rate, speeds),
        accepted_error(restitution_error),
    )
    if isinstance(source, str | Path):
        for name, value in (("law", law), ("time_step", time_step), ("dimension", dimension)):
            if value is not None:
                raise ValueError(
                    f"{name}: got {validation.shown(value)}, must be left out with a script, which sets it"
                )
        frames = _frames(given)
        seen = dumps.largest_type(frames)
        return _of_script(
            read_script(source, code=code, variables=given.variables, types_seen=seen), given, frames
        )
    for name, value in (("code", code), ("variables", dict(variables) or None)):
        if value is not None:
            raise ValueError(f"{name}: got {validation.shown(value)}, must be left out without a script")
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be the contact law, such as LinearDashpot")
    if not law.record["power_law"]:
        raise ValueError(f"law: got {law!r}, must be one whose force is K ξ^p + C ξ^q dξ/dt")
    step = None if time_step is None else validation.number("time_step", time_step, 0.0)
    if isinstance(source, ParticleSystem):
        if dimension not in (None, source.dimension):
            raise ValueError(f"dimension: got {dimension}, must be left out with a system")
        return _of_system(source, law, given, step)
    d = 3 if dimension is None else validation.whole("dimension", dimension, 2, 3)
    return _of_law([source], law, given, step, d, walls=True)


def _speeds(given: Any) -> tuple[float, ...]:
    """One speed or the ends of a range."""
    if given is None:
        return ()
    if validation.is_number(given):
        return (validation.number("speed", given, MIN_SPEED, MAX_SPEED),)
    low, high = validation.numbers("speed", given, 2, lowest=MIN_SPEED, highest=MAX_SPEED)
    if low > high:
        raise ValueError(f"speed: got {low:g} to {high:g}, must be the lowest and then the highest speed")
    return tuple(dict.fromkeys((low, high)))


# --- surroundings ---------------------------------------------------------------------------------------------


def _frames(given: Given) -> list[dumps.Frame]:
    return [] if given.dump is None else dumps.read(given.dump)


def _states(
    frames: Sequence[dumps.Frame],
    radii: Mapping[str, float],
    dimension: int,
    densities: Mapping[str, float],
) -> tuple[dumps.State, ...]:
    return tuple(dumps.state(frame, radii, dimension, densities) for frame in frames)


def _busiest(states: Sequence[dumps.State]) -> dumps.State | None:
    """The frame with the largest temperature, in which t_c ν is largest; the last if there are no velocities."""
    return max(states, key=lambda one: (one.temperature or 0.0, one.step), default=None)


def _surroundings(
    given: Given, states: Sequence[dumps.State], dimension: int
) -> tuple[Surroundings, tuple[float, ...]]:
    """The gas, and the impact speeds at which contacts are examined; options come before the dump."""
    state = _busiest(states)
    phi = given.packing_fraction
    if phi is not None:
        phi = checked_packing_fraction(phi, dimension)
    elif state is not None and state.packing_fraction is not None:
        phi = min(state.packing_fraction, 0.99)
    measured = state is not None and bool(state.temperature) and not given.speeds and given.drive is None
    gas = Surroundings(
        dimension,
        phi,
        state.mean_speed if measured and state else None,
        state.mean_diameter if measured and state else None,
        restitution_error=given.restitution_error,
    )
    return gas, given.speeds or (state.speeds if state and given.drive is None else ())


def _examined(
    found: Sequence[Case],
    gas: Surroundings,
    speeds: Sequence[float],
    driven: drive.Drive | None,
    purpose: drive.Drive | None,
    chosen: Sequence[float] = (),
) -> list[tuple[Case, CheckedContact]]:
    """Each contact at each speed. Normal impact speeds at a wall are 1/√2 of those of grains in a gas.

    ``driven``: what determines the speed. ``purpose``: what the box is run for. ``chosen``: speeds for contacts that
    depend on the speed if there is none.
    """
    share = math.sqrt(0.5) if gas.mean_speed is not None or driven is not None else 1.0
    gas = replace(gas, rubs=any(one.friction != 0.0 for one in found if one.second is not None))
    rows = []
    for case in found:
        at, where = speeds, gas
        one = None if purpose is None else purpose.gas(case, gas.dimension, gas.packing_fraction)
        if purpose is not None and purpose.bath is not None and one is not None:
            where = replace(gas, heat_share=partial(purpose.heat_share, one))
        if driven is not None:
            steady = driven.speed(case, gas.dimension, gas.packing_fraction)
            at, where = () if steady is None else (steady,), replace(where, mean_speed=steady)
        values = [v * (share if case.second is None else 1.0) for v in at]
        each = examine(case, values or [None], where)
        if not values and (each[0].duration is None or each[0].restitution is None):
            each = examine(case, chosen, where) if chosen else each
        rows += [(case, row) for row in each]
    return rows


# --- scripts --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class System:
    """The contacts of all runs with the same units and dimension, in these units."""

    last: Stage  #: its last run
    asked: drive.Drive | None  #: what determines the speed, in SI units
    given: Given
    gas: Surroundings
    speeds: tuple[float, ...]
    examined: Sequence[tuple[Case, CheckedContact]]
    question: answer.Question

    @property
    def rows(self) -> list[CheckedContact]:
        """The contacts in SI units."""
        return [_in_si(case, row, self.last.units) for case, row in self.examined]

    @property
    def at(self) -> str:
        """The chosen speed of the largest numbers; empty if speeds are given, or nothing depends on them."""
        known = self.speeds or self.given.drive or all(row.speed is None for _, row in self.examined)
        return "" if known else " at 1 m/s"

    def missing(self, states: Sequence[dumps.State]) -> tuple[str, ...]:
        """What is not known, in words."""
        rows = [row for _, row in self.examined]
        return _missing(rows, self.gas, _known_speeds(rows, self.speeds, self.given.drive), states)

    def remarks(self, several: bool) -> Iterator[str]:
        """Remarks on the contacts, which name their units if the script has several."""
        plain = self.last.units == "lj"
        for note in _remarks(self.examined, self.given, self.gas, self.speeds, self.at, plain):
            yield f"In {self.last.units} units: {note}" if several else note

    def corrected(self, code: str, several: bool) -> Iterator[str]:
        """Corrected lines, which name their units if the script has several."""
        for line in corrections.lines(code, self.examined, self.given.restitution_error, not self.at):
            yield f"{line}{';' if '#' in line else '  #'} {self.last.units} units" if several else line


def _kind(stage: Stage) -> tuple[str, int]:
    """What the runs of a system share."""
    return stage.units, stage.dimension


def _systems(
    script: Description, found: Sequence[Case], given: Given, states: Sequence[dumps.State]
) -> Iterator[System]:
    """The systems of a script. A dump is one of the last."""
    stages = script.stages or (NO_RUN,)
    for kind, last in {_kind(stage): stage for stage in stages}.items():
        own = [case for case in found if _kind(stages[case.stage - 1]) == kind]
        yield _system(last, own, given, states if kind == _kind(stages[-1]) else ())


def _system(last: Stage, found: Sequence[Case], given: Given, states: Sequence[dumps.State]) -> System:
    """The system that ends with a run."""
    scales = _, length, time = SCALES[last.units]
    plain = last.units == "lj"
    purpose = given.drive or drive.of_stage(last, *scales)
    measured = given.speeds or any(one.temperature for one in states)
    asked = given.drive if measured else purpose
    driven, purpose = (one and one.in_units(*scales) for one in (asked, purpose))
    given = replace(given, speeds=tuple(v * time / length for v in given.speeds), drive=driven)
    gas, speeds = _surroundings(given, states, last.dimension)
    gas = replace(gas, quantity="cooling" if purpose is None else purpose.quantity)
    chosen = () if plain or speeds or driven else tuple(v * time / length for v in CHOSEN_SPEEDS)
    examined = _examined(found, gas, speeds, driven, purpose, chosen)
    held = drive.support(last)
    option = "" if plain else drive.option_of(held, length, time)
    question = answer.Question(gas.quantity, bool(states), drive.words_of(last, held), option)
    return System(last, asked, given, gas, speeds, examined, question)


def _answer(
    systems: Sequence[System],
    invalidates: Sequence[Finding],
    unknown: Sequence[Finding],
    states: Sequence[dumps.State],
) -> tuple[bool | None, str]:
    """The answer for all systems: no if it is for one, yes if it is for all."""
    answers = []
    for question in dict.fromkeys(one.question for one in systems):
        same = [one for one in systems if one.question == question]
        rows = [row for one in same for row in one.rows]
        missing = tuple(dict.fromkeys(what for one in same for what in one.missing(states)))
        answers.append(answer.answer(rows, invalidates, unknown, missing, question))
    return min(answers, key=lambda one: (False, None, True).index(one[0]))


def _of_script(script: Description, given: Given, frames: Sequence[dumps.Frame] = ()) -> Verdict:
    for stage in script.stages:
        if stage.units not in SCALES:
            raise ValueError(
                f"units: got {validation.shown(stage.units)}, must be one of {', '.join(SCALES)}"
            )
    if not script.unknown and not any(stage.contacts for stage in script.stages):
        others = "".join(f"; it has {note.what}" for note in script.invalidates[:1])
        raise ValueError(f"script: it has no run with granular contacts{others}")
    script = _with_sizes(script, frames)
    found, remarks = cases.of_script(script)
    last = script.stages[-1] if script.stages else NO_RUN
    states = _states(frames, _radii(last), last.dimension, _densities(last))
    systems = list(_systems(script, found, given, states))
    rows = sorted((row for one in systems for row in one.rows), key=lambda row: row.stage)
    held = [drive.support(stage) for stage in script.stages]
    chosen = any(one.at for one in systems)
    invalidates = [_finding(note) for note in script.invalidates]
    invalidates += _lasting(script.stages, held, rows, states, chosen)
    unknown = _not_understood(script, last, frames, remarks, invalidates)
    admissible, sentence = _answer(systems, invalidates, unknown, states)
    final = next(one for one in systems if _kind(one.last) == _kind(last))
    _, length, time = SCALES[last.units]

    def plain(row: CheckedContact) -> bool:
        return script.stages[row.stage - 1].units == "lj"

    return Verdict(
        admissible,
        sentence + answer.steady(final.rows, final.asked, last.units == "lj"),
        script.code,
        script.version,
        last.units,
        last.units_given,
        None if last.time_step is None else last.time_step * time,
        last.numerical_damping,
        tuple(rows),
        tuple(_stage(k, *pair) for k, pair in enumerate(zip(script.stages, held, strict=True), 1)),
        tuple(_state_in_si(one, length, time) for one in states),
        tuple(_checked(rows, any(stage.gravity for stage in script.stages), states)),
        tuple(_finding(note) for note in script.ignored),
        tuple(invalidates),
        tuple(unknown),
        tuple(dict.fromkeys(what for one in systems for what in one.missing(states))),
        (
            *cases.of_other_versions(code(script.code).title, rows, plain),
            *remarks.versions,
            *dict.fromkeys(note for one in systems for note in one.remarks(len(systems) > 1)),
            *_numerically_damped(last.numerical_damping, final.examined),
        ),
        tuple(line for one in systems for line in one.corrected(script.code, len(systems) > 1)),
        None if final.question.driven else final.question.quantity,
        given.restitution_error,
        chosen,
    )


def _not_understood(
    script: Description,
    last: Stage,
    frames: Sequence[dumps.Frame],
    remarks: cases.Remarks,
    invalidates: Sequence[Finding],
) -> list[Finding]:
    """Statements, types of a dump and contacts that are not understood."""
    taken = {types for one in invalidates if (types := one.types)}
    unknown = [Finding(quote.text.strip(), None, _where(quote)) for quote in script.unknown]
    unknown += [
        Finding(f"grains of type {name} are in the dump, but not in the script")
        for name in sorted({name for frame in frames for name in frame.types or () if name.isdecimal()})
        if name not in last.grains
    ]
    if all(one.types is not None for one in invalidates):
        unknown += _not_modelled(
            [one for one in remarks.not_modelled if not any({*one.types} & {*t} for t in taken)]
        )
    return unknown


def _with_sizes(script: Description, frames: Sequence[dumps.Frame]) -> Description:
    """The script with sizes and masses of a dump for types whose sizes it does not have.

    A file that it reads them from need then not be understood.
    """
    measured = dumps.sizes(frames)
    if not measured:
        return script

    def grains(one: Grains) -> Grains:
        known = measured.get(one.type, measured.get(""))
        if one.radii is not None or known is None:
            return one
        radii, masses = known
        return replace(one, radii=radii, masses=None if one.densities else masses or one.masses)

    stages = [
        replace(stage, grains={name: grains(one) for name, one in stage.grains.items()})
        if _kind(stage) == _kind(script.stages[-1])
        else stage
        for stage in script.stages
    ]
    unknown = [
        one for one in script.unknown if not one.text.lstrip().startswith(("read_data", "read_restart"))
    ]
    return replace(script, stages=tuple(stages), unknown=tuple(unknown))


def _radii(stage: Stage) -> dict[str, float]:
    """The radius of each type with one size."""
    return {
        name: grains.radii[0]
        for name, grains in stage.grains.items()
        if grains.radii is not None and grains.radii[0] == grains.radii[1]
    }


def _densities(stage: Stage) -> dict[str, float]:
    """The density of each type whose density is known and the same for all its grains."""
    bodies = {name: [cases.body(grains, end) for end in (0, 1)] for name, grains in stage.grains.items()}
    return {
        name: ends[0].density
        for name, ends in bodies.items()
        if ends[0].density is not None and ends[0].density == ends[1].density
    }


def _lasting(
    stages: Sequence[Stage],
    held: Sequence[drive.Support],
    rows: Sequence[CheckedContact],
    states: Sequence[dumps.State],
    chosen: bool = False,
) -> Iterator[Finding]:
    """Contacts that last: grains that rest under gravity or are pressed, and grains that do not separate.

    ``chosen``: speeds are not given; a contact is then overdamped if it is at all speeds.
    """
    coordination = states[-1].coordination if states else None
    if coordination is not None:
        allowed = 0.1 + 2.0 * max((row.tc_nu or 0.0 for row in rows), default=0.0)
        if coordination > allowed:
            yield Finding(f"grains have {coordination:.2g} contacts on average in the dump, so contacts last")
    else:
        pressed = [note for stage in stages for note in stage.pressed]
        if pressed:
            what = f"grains are pressed together ({pressed[0].what})"
            yield _finding(pressed[0])._replace(what=what)
        # What is at rest before it is shaken does not decide.
        shaken = bool(held) and held[-1].moves and not held[-1].rests
        resting = [(stage, one) for stage, one in zip(stages, held, strict=True) if one.rests]
        for stage, one in () if shaken else resting[:1]:
            yield Finding(_rest(one), None, _where(stage.quote))
    overdamped: dict[tuple[str, str], list[bool]] = {}
    for row in rows:
        overdamped.setdefault(row.types, []).append(row.restitution == 0.0 and not row.adhesive)
    for types, each in overdamped.items():
        if all(each) if chosen else any(each):
            yield Finding("overdamped contacts", types)


def _rest(held: drive.Support) -> str:
    """That grains rest, and how strongly their support is shaken."""
    shaking = "" if held.shaking is None else f" (Γ = A ω²/g = {digits(held.shaking, 3)})"
    return f"grains rest on each other under gravity{shaking}"


def _not_modelled(contacts: Sequence[cases.NotModelled]) -> Iterator[Finding]:
    """Each statement that no model describes, with the types of its contacts."""
    for why, quote in dict.fromkeys((one.why, one.quote) for one in contacts):
        same = [one.types for one in contacts if (one.why, one.quote) == (why, quote)]
        pairs = ["–".join(types) for types in same]
        text = f"{', '.join(pairs[:3])}{' …' * (len(pairs) > 3)}: {why}"
        kinds = tuple(dict.fromkeys(name for types in same for name in types))
        yield Finding(why, kinds, text if quote is None else f"{_where(quote)} ({text})")


def _finding(note: Note) -> Finding:
    return Finding(note.what, note.types, "" if note.quote is None else _where(note.quote))


def _where(quote: Quote) -> str:
    """A statement with its line."""
    file = f"{Path(quote.file).name}, " if quote.file else ""
    part = f" ({quote.part} is not known)" if quote.part else ""
    return f"{file}line {quote.line}: {' '.join(quote.text.split())}{part}"


def _checked(
    rows: Sequence[CheckedContact], gravity: bool, states: Sequence[dumps.State]
) -> Iterator[Finding]:
    if any(row.restitution is not None and row.types[1] != cases.WALL for row in rows):
        yield Finding("normal contact")
    if any(row.steps_per_contact is not None for row in rows):
        yield Finding("time step")
    if any(row.restitution is not None and row.types[1] == cases.WALL for row in rows):
        yield Finding("walls")
    if gravity:
        yield Finding("gravity")
    if states:
        yield Finding(f"dump of {len(states)} frame{'s' if len(states) > 1 else ''}")


def _known_speeds(
    rows: Sequence[CheckedContact], speeds: Sequence[float], driven: drive.Drive | None
) -> Sequence[float]:
    """The speeds; those of the steady state if they are known for all contacts."""
    if driven is None:
        return speeds
    found = [row.speed for row in rows if row.speed is not None]
    return found if len(found) == len(rows) else ()


def _speeds_chosen(
    rows: Sequence[CheckedContact], speeds: Sequence[float], driven: drive.Drive | None, plain: bool
) -> Iterator[str]:
    """That speeds are not given but chosen, or why none are."""
    if speeds or driven:
        return
    if any(row.speed is not None for row in rows):
        yield f"No speed is given: {listed([digits(v) for v in CHOSEN_SPEEDS])} m/s were chosen."
    elif plain and any(row.radius is not None and row.model and row.duration is None for row in rows):
        yield "No speed is given, and lj units have no usual one."


def _no_speed(
    driven: drive.Drive | None, rows: Sequence[CheckedContact], gas: Surroundings, plain: bool
) -> Iterator[str]:
    """Why there is no speed of a steady state."""
    if driven is None or all(row.speed is not None for row in rows):
        return
    reason = driven.why_not(gas.dimension, gas.packing_fraction)
    if any((row.restitution or 0.0) > 1.0 - drive.ELASTIC for row in rows if row.speed is None):
        reason = reason or "elastic grains have no steady state, they heat for ever"
    reason = (
        reason or "sizes or masses are not known, or the restitution is outside the range of kinetic theory"
    )
    yield f"No speed from {driven.words(plain)}: {reason}."


def _missing(
    rows: Sequence[CheckedContact], gas: Surroundings, speeds: Sequence[float], states: Sequence[dumps.State]
) -> tuple[str, ...]:
    """What is not known, in words."""
    pairs = [row for row in rows if row.types[1] != cases.WALL]
    found = []
    if not speeds:
        found.append("speeds")
    if gas.packing_fraction is None:
        found.append("packing")
    if any(row.radius is None for row in rows):
        found.append("sizes")
    elif any(row.density is None for row in pairs):
        found.append("masses")
    return tuple(found)


def _remarks(
    examined: Sequence[tuple[Case, CheckedContact]],
    given: Given,
    gas: Surroundings,
    speeds: Sequence[float],
    at: str,
    plain: bool,
) -> Iterator[str]:
    """All remarks on contacts and their speeds."""
    rows = [row for _, row in examined]
    yield from dict.fromkeys(_notes(examined, given.restitution_error, at))
    yield from _no_speed(given.drive, rows, gas, plain)
    yield from _speeds_chosen(rows, speeds, given.drive, plain)


def _notes(examined: Sequence[tuple[Case, CheckedContact]], accepted: float, at: str = "") -> Iterator[str]:
    """Remarks on numbers that do not mean what they seem to; ``at``: the chosen speed of the largest ones."""
    groups: dict[tuple[Any, ...], list[tuple[Case, CheckedContact]]] = {}
    for case, row in examined:
        groups.setdefault((case.stage, case.model), []).append((case, row))
    for (_, model), members in groups.items():
        epsilons = [row.restitution for _, row in members if row.restitution is not None]
        force = members[0][0].force
        if not isinstance(force, cases.ModelForce) or not epsilons:
            continue
        low, high = min(epsilons), max(epsilons)
        if force.model.damping.formula == "given" and high - low > 0.01:
            yield (
                f"The script gives a damping, not a restitution; with {model} it gives ε from {low:.3g} to {high:.3g}, "
                "not one ε."
            )
        asked = [case.restitution_asked for case, _ in members if case.restitution_asked is not None]
        if asked and any(abs(e - a) > corrections.TOLERATED for e, a in zip(epsilons, asked, strict=False)):
            yield "ε given differs from ε asked."
    rows = [row for _, row in examined]
    error = max((row.restitution_error_of_step or 0.0 for row in rows), default=0.0)
    endless = any(row.steps_per_contact is not None and row.restitution_error_of_step is None for row in rows)
    overlap = max((row.largest_overlap or 0.0 for row in rows), default=0.0)
    if any(row.error and row.radius != row.other_radius for row in rows):
        yield "Unequal grains: the error is that of equal ones of their mean size, with a wider bar."
    if overlap > COMPRESSED:
        yield f"Overlaps reach {percent(overlap)} of the radius{at}; contact laws hold up to {percent(COMPRESSED)}."
    if endless or error > 1.0:
        yield "The time step is too long: contacts do not end, or gain energy."
    elif error > corrections.ENOUGH * accepted:
        yield f"The time step changes ε by up to {error:.2g}{at}."


def _numerically_damped(
    damping: float | None, examined: Sequence[tuple[Case, CheckedContact]]
) -> Iterator[str]:
    if damping:
        without = corrections.undamped(examined)
        then = "" if without is None else f"; without it, ε is {without}"
        yield f"ε includes NewtonIntegrator's damping of {damping:g} (centre of mass at rest{then})."


def _in_si(case: Case, row: CheckedContact, units: str) -> CheckedContact:
    scales = SCALES[units]
    changed: dict[str, Any] = {"stiffness_unit": _unit(case.spring_powers, units)}
    for name, powers in POWERS.items():
        if (value := getattr(row, name)) is not None:
            changed[name] = value * math.prod(s**p for s, p in zip(scales, powers, strict=True))
    others = [one._replace(duration=one.duration and one.duration * scales[2]) for one in row.other_versions]
    return replace(row, **changed, other_versions=tuple(others))


def _unit(powers: tuple[float, float, float] | None, units: str) -> str:
    """The unit of a stiffness or a modulus; empty in lj units."""
    if powers is None or units not in UNIT_NAMES or (powers[0], powers[2]) != (1.0, -2.0):
        return ""
    force, length = UNIT_NAMES[units]
    power = 1.0 - powers[1]
    if units == "si" and power == 2.0:
        return "Pa"
    return f"{force}/{length}{'' if power == 1.0 else f'^{power:g}'}"


def _state_in_si(state: dumps.State, length: float, time: float) -> dumps.State:
    t, d = state.temperature, state.mean_diameter
    return replace(
        state,
        temperature=None if t is None else t * (length / time) ** 2,
        mean_diameter=None if d is None else d * length,
    )


def _stage(number: int, stage: Stage, held: drive.Support) -> CheckedStage:
    _, length, time = SCALES[stage.units]
    step, gravity = stage.time_step, stage.gravity
    return CheckedStage(
        number,
        _where(stage.quote),
        None if step is None else step * time,
        stage.steps,
        None if gravity is None else gravity * length / time**2,
        stage.units,
        held.shaking,
    )


# --- systems and numbers --------------------------------------------------------------------------------------


def _of_system(system: ParticleSystem, law: Law, given: Given, step: float | None) -> Verdict:
    walls = "wall" in system.boundary
    temperature = system.granular_temperature
    state = dumps.State(
        0, system.n, system.packing_fraction, temperature, 2.0 * float(system.radius.mean()), None, None, None
    )
    held = drive.support_of_system(system)
    resting = [Finding(_rest(held))] * held.rests
    in_system = drive.of_system(system)
    if given.drive is None and not given.speeds and not system._walls_move:
        given = replace(given, drive=in_system)
    purpose = given.drive or in_system
    driven = drive.words_of(None, held) if given.drive is None else ""
    quantity = "cooling" if purpose is None else purpose.quantity
    question = answer.Question(quantity, False, driven, drive.option_of(held, 1.0, 1.0), purpose)
    return _of_law(
        cases.sizes(system), law, given, step, system.dimension, walls, (state,), resting, question
    )


def _of_law(
    balls: Sequence[Ball],
    law: Law,
    given: Given,
    step: float | None,
    dimension: int,
    walls: bool,
    states: tuple[dumps.State, ...] = (),
    resting: Sequence[Finding] = (),
    question: answer.Question | None = None,
) -> Verdict:
    if question is None:
        question = answer.Question("cooling" if given.drive is None else given.drive.quantity)
    found = cases.of_law(balls, law, walls, step)
    radii = {str(k): ball.radius for k, ball in enumerate(balls, 1)}
    densities = {str(k): ball.density for k, ball in enumerate(balls, 1)}
    dumped = _states(_frames(given), radii, dimension, densities)
    question = replace(question, dumped=bool(dumped))
    gas, speeds = _surroundings(given, dumped or states, dimension)
    gas = replace(gas, quantity=question.quantity)
    chosen = () if speeds or given.drive else CHOSEN_SPEEDS
    examined = _examined(found, gas, speeds, given.drive, given.drive or question.purpose, chosen)
    rows = [_in_si(*pair, "si") for pair in examined]
    at = "" if speeds or given.drive or all(row.speed is None for row in rows) else " at 1 m/s"
    invalidates = [*resting, *_lasting((), (), rows, dumped, bool(at))]
    missing = _missing(rows, gas, _known_speeds(rows, speeds, given.drive), dumped)
    admissible, sentence = answer.answer(rows, invalidates, (), missing, question)
    return Verdict(
        admissible,
        sentence + answer.steady(rows, given.drive, False),
        None,
        None,
        "si",
        True,
        step,
        None,
        tuple(rows),
        (),
        dumped or states,
        tuple(_checked(rows, False, dumped)),
        (),
        tuple(invalidates),
        (),
        missing,
        tuple(_remarks(examined, given, gas, speeds, at, False)),
        (),
        None if question.driven else question.quantity,
        given.restitution_error,
        bool(at),
    )
