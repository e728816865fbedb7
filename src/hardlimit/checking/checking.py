"""The check of a script, a text, a system or a ball: contacts, dump, findings and the answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..boxes.box import UNIT_BALL
from ..boxes.error_law import MEASURED_TC_NU
from ..boxes.system import ParticleSystem
from ..boxes.time_step import DEFAULT_ERROR, accepted_error
from ..contact.balls import Ball
from ..contact.contact import Law
from ..convert.force import MAX_SPEED, MIN_SPEED
from ..support import validation
from ..support.formatting import digits, listed, percent
from . import (
    answer,
    at_rest,
    cases,
    corrections,
    drive,
    dumps,
    few,
    friction_words,
    loads,
    mixture,
    state_words,
    stated,
)
from .at_rest import GrainState
from .contacts import COMPRESSED, Case, CheckedContact, Surroundings, examine
from .expectation import checked_packing_fraction
from .result import CheckedStage, Finding, Inferred, Verdict
from .scripts import Bath, Description, Grains, Note, Quote, Stage
from .scripts import read as read_script
from .scripts.clumps import STYLE as MULTISPHERE
from .scripts.description import FEW
from .supplied import NOTHING, SCALES, Supplied, completed, supplied

NO_RUN: Final = Stage(
    quote=Quote("", 0, ""),
    time_step=None,
    time_step_given=False,
    steps=None,
    contacts=(),
    grains={},
    gravity=None,
    numerical_damping=None,
)
NO_LOAD, NO_SUPPORT = loads.LoadOptions(), drive.Support(False, False)
#: In the note on walls and springs that versions of LAMMPS have without friction.
ERROR_OF_VERSIONS: Final = "PR 5007"
RESTS: Final = "grains rest on each other under gravity"
RESTS_OR_FLOWS: Final = "grains rest or flow in lasting contact under gravity"
FEW_REST: Final[dict[float | None, str]] = {
    1.0: "the grain comes to rest under gravity",
    2.0: "the two grains come to rest under gravity",
}
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
class Options:
    """The options of a check, in SI units or in those of a script in ``lj`` units."""

    dump: Path | None
    speeds: tuple[float, ...]
    packing_fraction: float | None
    variables: Mapping[str, str]
    drive: drive.Drive | None = None
    restitution_error: float = DEFAULT_ERROR
    load: loads.LoadOptions = NO_LOAD
    supplied: Supplied = NOTHING


def check(
    source: str | Path | ParticleSystem | Ball,
    *,
    code: str | None = None,
    dump: str | Path | None = None,
    speed: float | tuple[float, float] | None = None,
    variables: Mapping[str, str | float] = {},
    packing_fraction: float | None = None,
    law: Law | None = None,
    time_step: float | None = None,
    dimension: int | None = None,
    power: float | None = None,
    shear_rate: float | None = None,
    restitution_error: float | None = None,
    pressure: float | None = None,
    height: float | None = None,
    version: str | None = None,
    radius: float | None = None,
    density: float | None = None,
    mass: float | None = None,
) -> Verdict:
    """Check what the contacts of a simulation really do, and whether an event-driven simulation may replace it.

    Parameters
    ----------
    source : path, str, ParticleSystem or Ball
        Script or log of LAMMPS, LIGGGHTS or YADE, or its text; nothing in it is executed. Or a system, or one of many
        equal balls, under ``law``.
    code : str, optional
        "lammps", "liggghts" or "yade"; found in the script by default.
    dump : path, optional
        Text dump of LAMMPS or LIGGGHTS, also .gz. It gives the packing fraction, the impact speeds at 10, 50 and 90 %,
        and the share of lasting contacts. With several frames, the hottest one decides.
    speed : float or (float, float) [m/s]
        Mean impact speed √(πT), or its lowest and highest value; in ``lj`` units as in the script. It comes before the
        dump's.
    variables : mapping
        Variables of the script by name, as on the command line of its code.
    packing_fraction : float, optional
        φ of the grains. It comes before the dump's.
    law : Law, optional
        Contact law of a system or a ball.
    time_step : float [s], optional
        Time step under which a ball or a system is simulated; in place of that of a script.
    dimension : int, optional
        For a ball: 3 for spheres, the default, or 2 for disks; solid ones have ``inertia_factor=0.5``.
    power : float [W], optional
        Heating power of each grain, instead of ``speed``; as in the script if it is in ``lj`` units. The speed is that
        of the steady state, in which collisions dissipate this power. A system with a thermostat has its own.
    shear_rate : float [1/s], optional
        Rate of simple shear, instead of ``speed``. The speed is that of the steady state, in which collisions dissipate
        the work of the shear stress. Spheres with ε of at least 0.5.
    restitution_error : float, optional
        Error of ε that a time step may cause, 0.001 by default: that of the corrected lines.
    pressure : float [Pa], optional
        Pressure on grains that are held together; as in the script if it is in ``lj`` units, in two dimensions a force
        per length [N/m]. It comes before what the script says.
    height : float [m], optional
        Height of a bed that rests under gravity, instead of ``pressure``: the number is that at its bottom.
    version : str, optional
        Version of the script's code, such as "22Jul2025", "3.8.0" or "2023.02a"; it comes before that of a log.
    radius : float [m], optional
        Radius of the grains of whose size the script says nothing; as in the script if it is in ``lj`` units.
    density : float [kg/m³], optional
        Density of the grains of whose mass the script says nothing.
    mass : float [kg], optional
        Their mass, instead of ``density``.

    Returns
    -------
    Verdict
        ``.admissible`` is True if event-driven cooling (of a heated gas, the temperature; of a sheared one, the shear
        stress) is right within 1 %, False if it is not or if something cannot be simulated by events, such as cohesion
        or grains at rest or under pressure, and None if it cannot be said, as for an unknown packing fraction.

    Raises
    ------
    ValueError
        If the script is not granular or cannot be resolved, the dump cannot be read, or a value is outside its range.
    FileNotFoundError
        If there is no script or dump of this name.

    Notes
    -----
    The error is that of :func:`error_law` at Enskog's collision rate (Chapman & Cowling, The Mathematical Theory of
    Non-uniform Gases, 1970), as for a gas of equal grains of each pair's mean diameter. A force that never attracts
    ends a contact early: Schwager & Pöschel, Granular Matter 9, 465 (2007). The error of ε by the time step is that of
    the code's integration in an isolated contact. Rayleigh time: Thornton & Randall, Micromechanics of Granular
    Materials (1988). Steady temperatures: van Noije & Ernst, Granular Matter 1, 57 (1998) for heating (within 3 % of
    simulations for φ ≤ 0.1; where hard spheres are correlated, T is up to 30 % higher), with friction that of
    :class:`hardlimit.boxes.theory.RotatingGas`; Lun et al., J. Fluid Mech. 140, 223 (1984) for shear.

    Examples
    --------
    >>> bead = hl.Ball(1e-3, density=2500.0)
    >>> soft = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    >>> print(hl.check(bead, law=soft, speed=0.3, packing_fraction=0.3))
    May an event-driven simulation replace this? No: event-driven cools 9.6 ± 0.5 %
    too fast at t_c ν = 0.19, δ/d = 0.01 (grains 1–1); 1 % takes a stiffness of
    1.1e5 N/m instead of 1e3.
    """
    if not isinstance(source, str | Path | ParticleSystem | Ball):
        raise ValueError(
            f"source: got {validation.shown(source)}, must be a path, a text, a ParticleSystem or a Ball"
        )
    if not isinstance(variables, Mapping):
        raise ValueError(f"variables: got {validation.shown(variables)}, must be values by name")
    speeds = _speeds(speed)
    options = Options(
        None if dump is None else validation.path("dump", dump),
        speeds,
        packing_fraction,
        {str(name): str(value) for name, value in variables.items()},
        drive.checked_drive(power, shear_rate, speeds),
        accepted_error(restitution_error),
        loads.checked_load(pressure, height),
        supplied(radius=radius, density=density, mass=mass, time_step=time_step),
    )
    if isinstance(source, str | Path):
        _refuse({"law": law, "dimension": dimension}, "with a script, which sets it")
        frames = _frames(options)
        seen = dumps.largest_type(frames)
        script = read_script(source, code=code, version=version, variables=options.variables, types_seen=seen)
        return _of_script(script, options, frames)
    _refuse({"code": code, "version": version, "variables": dict(variables) or None}, "without a script")
    _refuse({"radius": radius, "density": density, "mass": mass}, "without a script")
    return _of_bodies(source, law, options, time_step, dimension)


def _refuse(options: Mapping[str, object], why: str) -> None:
    """Refuse options that must be left out."""
    for name, value in options.items():
        if value is not None:
            raise ValueError(f"{name}: got {validation.shown(value)}, must be left out {why}")


def _of_bodies(
    source: ParticleSystem | Ball, law: Any, options: Options, time_step: Any, dimension: Any
) -> Verdict:
    """A system or a ball under one of our laws."""
    if not isinstance(law, Law):
        raise ValueError(f"law: got {validation.shown(law)}, must be the contact law, such as LinearDashpot")
    if not law.record["power_law"]:
        raise ValueError(f"law: got {law!r}, must be one whose force is K ξ^p + C ξ^q dξ/dt")
    step = None if time_step is None else validation.number("time_step", time_step, 0.0)
    if isinstance(source, ParticleSystem):
        if dimension not in (None, source.dimension):
            raise ValueError(f"dimension: got {dimension}, must be left out with a system")
        return _of_system(source, law, options, step)
    d = 3 if dimension is None else validation.whole("dimension", dimension, 2, 3)
    gravity = None if options.load.height is None else at_rest.GRAVITY
    return _of_law([source], law, options, step, replace(NO_RUN, dimension=d, gravity=gravity), walls=True)


def _speeds(speed: Any) -> tuple[float, ...]:
    """One speed or the ends of a range."""
    if speed is None:
        return ()
    if validation.is_number(speed):
        return (validation.number("speed", speed, MIN_SPEED, MAX_SPEED),)
    low, high = validation.numbers("speed", speed, 2, lowest=MIN_SPEED, highest=MAX_SPEED)
    if low > high:
        raise ValueError(f"speed: got {low:g} to {high:g}, must be the lowest and then the highest speed")
    return tuple(dict.fromkeys((low, high)))


# --- surroundings ---------------------------------------------------------------------------------------------


def _frames(options: Options) -> list[dumps.Frame]:
    return [] if options.dump is None else dumps.read(options.dump)


def _states(
    frames: Sequence[dumps.Frame],
    radii: Mapping[str, float],
    dimension: int,
    densities: Mapping[str, float],
) -> tuple[dumps.State, ...]:
    return tuple(dumps.state(frame, radii, dimension, densities) for frame in frames)


def _busiest(states: Sequence[dumps.State]) -> dumps.State | None:
    """The frame with the largest temperature, in which t_c ν is largest; the last if there are no velocities."""
    return max(states, key=lambda state: (state.temperature or 0.0, state.step), default=None)


def _surroundings(
    options: Options, states: Sequence[dumps.State], dimension: int
) -> tuple[Surroundings, tuple[float, ...]]:
    """The gas, and the impact speeds at which contacts are examined; options come before the dump."""
    state = _busiest(states)
    phi = options.packing_fraction
    if phi is not None:
        phi = checked_packing_fraction(phi, dimension)
    elif state is not None and state.packing_fraction is not None:
        phi = min(state.packing_fraction, 0.99)
    measured = state is not None and bool(state.temperature) and not options.speeds and options.drive is None
    gas = Surroundings(
        dimension,
        phi,
        state.mean_speed if measured and state else None,
        state.mean_diameter if measured and state else None,
        restitution_error=options.restitution_error,
    )
    return gas, options.speeds or (state.speeds if state and options.drive is None else ())


def _examined(
    contacts: Sequence[Case],
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
    at_wall = math.sqrt(0.5) if gas.mean_speed is not None or driven is not None else 1.0
    between = [case for case in contacts if case.second is not None]
    bodies = [body for case in between for body in (case.first, case.second) if body and not body.fixed]
    gas = replace(
        gas,
        frictions=tuple({case.friction.coefficient for case in between}),
        inertia_factors=tuple({body.inertia_factor for body in bodies}),
    )
    rows = []
    for case in contacts:
        at, where = speeds, gas
        grain = None if purpose is None else purpose.gas(case, gas.dimension, gas.packing_fraction)
        if purpose is not None and grain is not None:
            share = None if purpose.bath is None else partial(purpose.heat_share, grain)
            missing = partial(purpose.without_friction, case, grain)
            where = replace(gas, heat_share=share, without_friction=missing, heats_spins=purpose.heats_spins)
        steady = None if driven is None else driven.steady(case, gas.dimension, gas.packing_fraction)
        if driven is not None:
            at = () if steady is None else (steady.speed,)
            where = replace(where, mean_speed=None if steady is None else steady.speed)
        values = [v * (at_wall if case.second is None else 1.0) for v in at]
        each = examine(case, values or [None], where)
        if not values and (each[0].duration is None or each[0].restitution is None):
            each = examine(case, chosen, where) if chosen else each
        ratio = None if steady is None else steady.temperature_ratio
        rows += [(case, replace(row, temperature_ratio=ratio)) for row in each]
    return rows


# --- scripts --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class System:
    """The contacts of all runs of the same kind (see :func:`_kinds`), in the same units."""

    last: Stage  #: its last run
    supply: drive.Drive | None  #: what determines the speed, in SI units
    options: Options
    gas: Surroundings
    speeds: tuple[float, ...]
    examined: Sequence[tuple[Case, CheckedContact]]
    question: answer.Question
    inferred: tuple[Inferred, ...] = ()  #: what follows from the script, in its units

    @property
    def rows(self) -> list[CheckedContact]:
        """The contacts in SI units."""
        return [_in_si(case, row, self.last.units) for case, row in self.examined]

    @property
    def inferred_in_si(self) -> Iterator[Inferred]:
        """What follows from the script, in SI units."""
        _, length, time = SCALES[self.last.units]
        for number in self.inferred:
            yield number._replace(value=number.value * length / time) if number.what == "speed" else number

    @property
    def at(self) -> str:
        """The chosen speed of the largest numbers; empty if speeds are given, or nothing depends on them."""
        estimated = any(number.what == "speed" for number in self.inferred)
        known = self.speeds or self.options.drive or all(row.speed is None for _, row in self.examined)
        known = known or estimated
        return "" if known else " at 1 m/s"

    def missing(self, states: Sequence[dumps.State]) -> tuple[str, ...]:
        """What is not known, in words."""
        if self.question.never_meet:
            return ()
        rows = [row for _, row in self.examined]
        return _missing(rows, self.gas, self.speeds, self.options.drive)

    def remarks(self, several: bool) -> Iterator[str]:
        """Remarks on the contacts, which name their units if the script has several."""
        plain = self.last.units == "lj"
        speeds = self.speeds or tuple(number.value for number in self.inferred if number.what == "speed")
        for note in _remarks(self.examined, self.options, self.gas, speeds, self.at, plain):
            yield f"In {self.last.units} units: {note}" if several else note

    def corrected(
        self, code: str, several: bool, largest: corrections.LargestStep | None = None
    ) -> Iterator[str]:
        """Corrected lines, which name their units if the script has several.

        ``largest``: the longest time step of a state in which contacts last.
        """
        accepted = self.options.restitution_error
        for line in corrections.lines(code, self.examined, accepted, not self.at, largest):
            yield f"{line}{';' if '#' in line else '  #'} {self.last.units} units" if several else line


#: Units, dimension, shear rate, bath, and other drives in words.
Kind = tuple[str, int, float | None, Bath | None, str]


def _kinds(stages: Sequence[Stage]) -> list[Kind]:
    """The kind of system of each stage, which decides what it is judged by: that of the last run before ``clear``."""
    last = {stage.system: stage for stage in stages}
    ends = (last[stage.system] for stage in stages)
    return [
        (end.units, end.dimension, end.shear_rate, end.bath, drive.words_of(end, drive.support(end)))
        for end in ends
    ]


def _systems(
    stages: Sequence[Stage],
    kinds: Sequence[Kind],
    contacts: Sequence[Case],
    options: Options,
    states: Sequence[dumps.State],
) -> Iterator[System]:
    """The systems of a script. A dump is one of the last."""
    for kind in dict.fromkeys(kinds):
        own = [case for case in contacts if kinds[case.stage - 1] == kind]
        runs = [stage for stage, other in zip(stages, kinds, strict=True) if other == kind]
        yield _system(runs, own, options, states if kind == kinds[-1] else ())


def _system(
    runs: Sequence[Stage], contacts: Sequence[Case], options: Options, states: Sequence[dumps.State]
) -> System:
    """The system of some runs."""
    last = runs[-1]
    scales = _, length, time = SCALES[last.units]
    plain = last.units == "lj"
    purpose = options.drive or drive.of_stage(last, *scales)
    measured = options.speeds or any(state.temperature for state in states)
    supply = options.drive if measured else purpose
    drive_option = "" if options.drive is None else options.drive.option
    driven, purpose = (source and source.in_units(*scales) for source in (supply, purpose))
    options = replace(
        options,
        speeds=tuple(v * time / length for v in options.speeds),
        drive=driven,
        load=options.load.in_units(*scales, last.dimension),
    )
    gas, speeds = _surroundings(options, states, last.dimension)
    gas = replace(gas, quantity="cooling" if purpose is None else purpose.quantity)
    packing = stated.packing_fraction(last) if gas.packing_fraction is None else None
    if packing is not None:
        gas = replace(gas, packing_fraction=packing.value)
    speed = None if speeds or driven else stated.speed(runs)
    at = speeds if speed is None else (speed.value,)
    chosen = () if plain or at or driven else tuple(v * time / length for v in CHOSEN_SPEEDS)
    examined = _examined(contacts, gas, at, driven, purpose, chosen)
    support = drive.support(last)
    moving = (kind.radii[1] for kind in last.grains.values() if kind.radii and not kind.frozen)
    largest = max(moving, default=None)
    option = (
        "" if plain else drive.option_of(support, last.gravity or 0.0, largest, last.dimension, length, time)
    )
    heats_spins = purpose is not None and purpose.heats_spins
    question = answer.Question(
        gas.quantity,
        bool(states),
        drive.words_of(last, support),
        option,
        heats_spins=heats_spins,
        drive_option=drive_option,
    )
    return System(
        last=last,
        supply=supply,
        options=options,
        gas=gas,
        speeds=at if speed is not None and speed.decides else speeds,
        examined=examined,
        question=question,
        inferred=tuple(number for number in (packing, speed) if number is not None),
    )


def _answer(
    systems: Sequence[System],
    invalidates: Sequence[Finding],
    unknown: Sequence[Finding],
    states: Sequence[dumps.State],
) -> tuple[bool | None, str]:
    """The answer for all systems: no if it is for one, yes if it is for all."""
    answers = []
    for question in dict.fromkeys(system.question for system in systems):
        same = [system for system in systems if system.question == question]
        rows = [row for system in same for row in system.rows]
        missing = tuple(dict.fromkeys(what for system in same for what in system.missing(states)))
        answers.append(answer.answer(rows, invalidates, unknown, missing, question))
    return min(answers, key=lambda pair: (False, None, True).index(pair[0]))


def _refuse_empty(script: Description) -> None:
    """Refuse a script without granular contacts, or with units that are not understood."""
    for stage in script.stages:
        if stage.units not in SCALES:
            raise ValueError(
                f"units: got {validation.shown(stage.units)}, must be one of {', '.join(SCALES)}"
            )
    if not script.unknown and not any(stage.contacts for stage in script.stages):
        others = "".join(f"; it has {note.what}" for note in script.invalidates[:1])
        raise ValueError(f"script: it has no run with granular contacts{others}")


def _of_script(script: Description, options: Options, frames: Sequence[dumps.Frame] = ()) -> Verdict:
    _refuse_empty(script)
    script = completed(_with_sizes(script, frames), options.supplied)
    stages = script.stages or (NO_RUN,)
    kinds, last = _kinds(stages), stages[-1]
    contacts, remarks = cases.of_script(script, kinds[: len(script.stages)])
    states = _states(frames, _radii(last), last.dimension, _densities(last))
    systems = list(_systems(stages, kinds, contacts, options, states))
    rows = sorted((row for system in systems for row in system.rows), key=lambda row: row.stage)
    supports = [drive.support(stage) for stage in script.stages]
    chosen = any(system.at for system in systems)
    final = next(system for system in systems if system.last is last)
    others = " ".join(note.what for note in script.invalidates)
    grains = _held_in_script(final, frames, states, others)
    question = _flowing(final.question, grains, bool(last.gravity))
    final = replace(final, question=replace(question, never_meet=grains.never_meet))
    systems = [final if system.last is last else system for system in systems]
    invalidates = [_finding(note) for note in script.invalidates]
    invalidates += _held_together(grains, options, _lasting(script.stages, supports, rows, states, chosen))
    unknown = _not_understood(script, last, frames, remarks, invalidates)
    admissible, sentence = _answer(systems, invalidates, unknown, states)
    several = len({stage.units for stage in stages}) > 1
    _, length, time = SCALES[last.units]
    return Verdict(
        admissible=admissible,
        sentence=sentence
        + answer.steady(final.rows, final.supply, last.units == "lj")
        + _words_of_state(grains, last.units, last.dimension),
        code=script.code,
        version=script.version,
        units=last.units,
        units_given=last.units_given,
        time_step=None if last.time_step is None else last.time_step * time,
        numerical_damping=last.numerical_damping,
        rows=tuple(rows),
        stages=tuple(_stage(k, *pair) for k, pair in enumerate(zip(script.stages, supports, strict=True), 1)),
        states=tuple(_state_in_si(state, length, time) for state in states),
        checked=tuple(_checked(rows, any(stage.gravity for stage in script.stages), states)),
        ignored=tuple(_ignored(script, rows)),
        invalidates=tuple(invalidates),
        unknown=tuple(unknown),
        missing=tuple(dict.fromkeys(what for system in systems for what in system.missing(states))),
        remarks=(
            *cases.of_other_versions(script, rows),
            *remarks.versions,
            *dict.fromkeys(note for system in systems for note in system.remarks(several)),
            *_numerically_damped(last.numerical_damping, final.examined),
        ),
        warnings=_warnings(script, rows),
        corrected=tuple(
            dict.fromkeys(
                line
                for system in systems
                for line in system.corrected(script.code, several, _step_at_rest(grains, system, last))
            )
        ),
        quantity=None if final.question.driven else final.question.quantity,
        restitution_error=options.restitution_error,
        speeds_chosen=chosen,
        state=grains,
        inferred=tuple(dict.fromkeys(number for system in systems for number in system.inferred_in_si)),
    )


def _not_understood(
    script: Description,
    last: Stage,
    frames: Sequence[dumps.Frame],
    remarks: cases.Remarks,
    invalidates: Sequence[Finding],
) -> list[Finding]:
    """Statements, types of a dump and contacts that are not understood."""
    taken = {types for finding in invalidates if (types := finding.types)}
    unknown = [Finding(quote.text.strip(), None, _where(quote)) for quote in script.unknown]
    unknown += [
        Finding(f"grains of type {name} are in the dump, but not in the script")
        for name in sorted({name for frame in frames for name in frame.types or () if name.isdecimal()})
        if name not in last.grains
    ]
    if all(finding.types is not None for finding in invalidates):
        unknown += _not_modelled(
            [contact for contact in remarks.not_modelled if not any({*contact.types} & {*t} for t in taken)]
        )
    return unknown


def _with_sizes(script: Description, frames: Sequence[dumps.Frame]) -> Description:
    """The script with sizes and masses of a dump for types whose sizes it does not have.

    A file that it reads them from need then not be understood.
    """
    measured = dumps.sizes(frames)
    if not measured:
        return script

    def grains(kind: Grains) -> Grains:
        known = measured.get(kind.type, measured.get(""))
        if kind.radii is not None or known is None:
            return kind
        radii, masses = known
        return replace(kind, radii=radii, masses=None if kind.densities else masses or kind.masses)

    stages = [
        replace(stage, grains={name: grains(kind) for name, kind in stage.grains.items()})
        if (stage.units, stage.dimension) == (script.stages[-1].units, script.stages[-1].dimension)
        else stage
        for stage in script.stages
    ]
    unknown = [
        quote for quote in script.unknown if not quote.text.lstrip().startswith(("read_data", "read_restart"))
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
    supports: Sequence[drive.Support],
    rows: Sequence[CheckedContact],
    states: Sequence[dumps.State],
    chosen: bool = False,
) -> Iterator[Finding]:
    """Contacts that last: grains that rest under gravity or are pressed, and grains that do not separate.

    ``chosen``: speeds are not given; a contact is then overdamped if it is at all speeds.
    """
    lasting = _contacts_last(rows, states)
    if lasting:
        coordination = states[-1].coordination
        yield Finding(f"grains have {coordination:.2g} contacts on average in the dump, so contacts last")
    elif lasting is None:
        pressed = [note for stage in stages for note in stage.pressed]
        if pressed:
            what = f"grains are pressed together ({pressed[0].what})"
            yield _finding(pressed[0])._replace(what=what)
        # What is at rest before it is shaken does not decide.
        ends = {stage.system: support for stage, support in zip(stages, supports, strict=True)}
        shaken = {system for system, end in ends.items() if end.moves and not end.rests}
        resting = (
            (stage, support)
            for stage, support in zip(stages, supports, strict=True)
            if support.rests and stage.system not in shaken
        )
        for stage, support in islice(resting, 1):
            yield Finding(_rest(support, stage.contents.count), None, _where(stage.quote))
    overdamped: dict[tuple[str, str], list[bool]] = {}
    for row in rows:
        overdamped.setdefault(row.types, []).append(row.restitution == 0.0 and not row.adhesive)
    for types, each in overdamped.items():
        if all(each) if chosen else any(each):
            yield Finding("overdamped contacts", types)


def _contacts_last(rows: Sequence[CheckedContact], states: Sequence[dumps.State]) -> bool | None:
    """Whether grains have more contacts in the last frame of a dump than collisions make; None if it is not known."""
    coordination = states[-1].coordination if states else None
    if coordination is None:
        return None
    longest = max((row.tc_nu or 0.0 for row in rows), default=0.0)
    return coordination > 0.1 + 2.0 * min(longest, MEASURED_TC_NU)


def _held_together(grains: GrainState, options: Options, lasting: Iterable[Finding]) -> Iterator[Finding]:
    """Findings of lasting contacts: that which options state first, and no rest in a flow that may be collisional."""
    findings = list(lasting)
    if grains.may_separate:
        rest = (RESTS, *FEW_REST.values())
        findings = [finding for finding in findings if not finding.what.startswith(rest)]
    elif options.load.rests and grains.name != "gas" and all(finding.types for finding in findings):
        how = "flow in lasting contact" if grains.name == "flow" else "are pressed together"
        yield Finding(RESTS if grains.name == "rest" else f"grains {how}")
    slides = grains.slope_inertial_number is not None and grains.slope_inertial_number[0] > 0.0
    moves = RESTS_OR_FLOWS if grains.name == "flow" or slides else RESTS
    for finding in findings:
        yield finding._replace(what=finding.what.replace(RESTS, moves))


def _rest(support: drive.Support, count: float | None) -> str:
    """That so many grains rest, and how strongly their support is shaken; one or two rest on walls."""
    shaking = "" if support.shaking is None else f" (Γ = A ω²/g = {digits(support.shaking, 3)})"
    return f"{FEW_REST.get(count, RESTS)}{shaking}"


def _ignored(script: Description, rows: Sequence[CheckedContact]) -> Iterator[Finding]:
    """What is in the script beside the contacts; their tangential forces unless all are understood."""
    rubbing = (row.friction for row in rows if row.friction.coefficient != 0.0)
    understood = all(known.limit is not None or known.other_versions for known in rubbing)
    for note in script.ignored:
        if not (understood and note.what.startswith("tangential")):
            yield _finding(note)


def _warnings(script: Description, rows: Sequence[CheckedContact]) -> tuple[Finding, ...]:
    """First what other versions of the code do, then what the script says, then what follows from numbers."""
    notes = sorted(script.warnings, key=lambda note: ERROR_OF_VERSIONS not in note.what)
    read = [_finding(note)._replace(minor=friction_words.is_minor(note.what, rows)) for note in notes]
    said = " ".join(finding.what for finding in read)
    repeated = [words for words in friction_words.OF_READERS if words in said]
    others = [trap for trap in _traps(rows) if not any(words in trap.what for words in repeated)]
    return (*_findings(friction_words.versions, rows, own=True), *read, *others)


def _traps(rows: Sequence[CheckedContact]) -> Iterator[Finding]:
    """What the friction of contacts does that is rarely meant."""
    for trap in friction_words.TRAPS:
        yield from _findings(trap, rows)


def _findings(
    trap: Callable[[CheckedContact], str], rows: Sequence[CheckedContact], own: bool = False
) -> Iterator[Finding]:
    """A trap for each pair of types that falls into it, in its ``own`` words or those of the first."""
    texts = {row.types: text for row in rows if row.friction.coefficient != 0.0 and (text := trap(row))}
    for types, text in texts.items():
        yield Finding(text if own else next(iter(texts.values())), types)


def _not_modelled(contacts: Sequence[cases.NotModelled]) -> Iterator[Finding]:
    """Each statement that no model describes, with the types of its contacts."""
    for why, quote in dict.fromkeys((contact.why, contact.quote) for contact in contacts):
        same = [contact.types for contact in contacts if (contact.why, contact.quote) == (why, quote)]
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
    if any(row.friction.tangential_restitution for row in rows):
        yield Finding("friction")
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
    known = [row.speed for row in rows if row.speed is not None]
    return known if len(known) == len(rows) else ()


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
    if driven.moves_nothing and all(row.friction.coefficient == 0.0 for row in rows):
        reason = reason or "spins of grains without friction move nothing"
    if any((row.restitution or 0.0) > 1.0 - drive.ELASTIC for row in rows if row.speed is None):
        reason = reason or "elastic grains have no steady state, they heat for ever"
    if driven.shear_rate is not None and any(
        row.restitution < drive.LEAST_IN_SHEAR for row in rows if row.restitution is not None
    ):
        reason = reason or f"kinetic theory of shear is that of ε from {drive.LEAST_IN_SHEAR:g} on"
    reason = (
        reason or "sizes or masses are not known, or the restitution is outside the range of kinetic theory"
    )
    yield f"No speed from {driven.words(plain)}: {reason}."


def _missing(
    rows: Sequence[CheckedContact], gas: Surroundings, speeds: Sequence[float], driven: drive.Drive | None
) -> tuple[str, ...]:
    """What is not known, in words; no speeds of a steady state that the rest would give."""
    pairs = [row for row in rows if row.types[1] != cases.WALL]
    missing = []
    if gas.packing_fraction is None:
        missing.append("packing")
    if any(row.radius is None for row in rows):
        missing.append("sizes")
    elif any(row.density is None for row in pairs):
        missing.append("masses")
    if not _known_speeds(rows, speeds, driven) and not (driven and missing):
        missing.insert(0, "speeds")
    return tuple(missing)


def _remarks(
    examined: Sequence[tuple[Case, CheckedContact]],
    options: Options,
    gas: Surroundings,
    speeds: Sequence[float],
    at: str,
    plain: bool,
) -> Iterator[str]:
    """All remarks on contacts and their speeds."""
    rows = [row for _, row in examined]
    yield from dict.fromkeys(_notes(examined, options.restitution_error, at))
    yield from _no_speed(options.drive, rows, gas, plain)
    yield from _speeds_chosen(rows, speeds, options.drive, plain)


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
        wanted = [case.restitution_asked for case, _ in members if case.restitution_asked is not None]
        if wanted and any(abs(e - a) > corrections.TOLERATED for e, a in zip(epsilons, wanted, strict=False)):
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
    others = [
        version._replace(duration=version.duration and version.duration * scales[2])
        for version in row.other_versions
    ]
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


def _stage(number: int, stage: Stage, support: drive.Support) -> CheckedStage:
    _, length, time = SCALES[stage.units]
    step, gravity = stage.time_step, stage.gravity
    return CheckedStage(
        number=number,
        command=_where(stage.quote),
        time_step=None if step is None else step * time,
        steps=stage.steps,
        gravity=None if gravity is None else gravity * length / time**2,
        units=stage.units,
        shaking=support.shaking,
    )


def _held_in_script(
    final: System, frames: Sequence[dumps.Frame], states: Sequence[dumps.State], others: str
) -> GrainState:
    """How the grains of the last run are held together, in SI units. ``others``: what else acts on them, in words."""
    stage = final.last
    examined = {id(case): case for case, _ in final.examined}
    newest = max((case.stage for case in examined.values()), default=0)
    fixed = [name for name, kind in stage.grains.items() if kind.frozen]
    bed = None
    if frames and stage.down:
        bed = dumps.bed(frames[-1], _radii(stage), _densities(stage), stage.down, stage.dimension, fixed)
    around = loads.Around(
        cases=[case for case in examined.values() if case.stage == newest],
        dimension=stage.dimension,
        units=stage.units,
        state=states[-1] if states else None,
        kinds=dumps.kinds(frames[-1], _radii(stage), fixed) if frames else (),
        bed=bed,
        lasting=_contacts_last([row for _, row in final.examined], states),
        barostat="barostat" in others,
        fluid=any(words in others for words in ("fluid", "buoyancy")),
    )
    grains = _contact_of_few(_held(stage, drive.support(stage), final.options, around), final, around)
    if (
        MULTISPHERE in others
    ):  # whose arms and moments of inertia are not those of the sphere that stands for them
        grains = replace(grains, largest_stable_step=None, step_share=None)
    return grains


def _contact_of_few(grains: GrainState, final: System, around: loads.Around) -> GrainState:
    """The state of few grains, or of a gas of unknown packing or speed, with numbers of contacts, in SI units."""
    stage, loaded = final.last, final.options.load.rests or final.options.drive
    count, (_, length, time) = stage.contents.count, SCALES[stage.units]
    many = count is None or count > FEW
    if many and stage.contents.never_meet and grains.name == "gas" and around.state is None and not loaded:
        return replace(grains, never_meet=True)
    stated_speeds = [number.value for number in final.inferred if number.what == "speed"]
    speeds = final.options.speeds or tuple(stated_speeds)
    prescribed = grains.name == "pressed" and grains.pressure is not None
    if many and around.cases and all(case.second is None for case in around.cases):
        count = 0.0  # none meets another one
    shaken = grains.name == "shaken" and grains.shaking is not None
    if loaded or prescribed or shaken or around.state is not None or (not speeds and stage.units == "lj"):
        return grains
    speed = max(speeds, default=CHOSEN_SPEEDS[-1] * time / length)
    if count is not None and 0 <= count <= FEW:
        state = few.with_contact(grains, around.cases, count, speed, stage.time_step, not speeds)
    elif grains.name == "gas" and not any(row.tc_nu for row in final.rows):
        state = few.in_gas(grains, around.cases, final.gas, speed, not speeds)
    else:
        return grains
    if state.impact_speed is None:
        return state
    longest = state.largest_stable_step
    return replace(
        state,
        impact_speed=state.impact_speed * length / time,
        duration=state.duration and state.duration * time,
        largest_stable_step=None if longest is None else longest * time,
    )


def _flowing(question: answer.Question, grains: GrainState, gravity: bool) -> answer.Question:
    """A flow under gravity that is collisional, or may be so, is driven, but no homogeneous gas."""
    if grains.name == "gas" and question.quantity == "stress":
        return replace(question, may_be_dense=True)
    if not (grains.may_separate and gravity):
        return question
    where = "a slope on" if grains.inertial_number is None else "a flow under gravity in"
    known = grains.regime == "collisional"
    how = "a collisional flow under gravity" if known else f"{where} which contacts may not last"
    return replace(question, driven=how)


def _step_at_rest(grains: GrainState, system: System, last: Stage) -> corrections.LargestStep | None:
    """A safe time step of grains in lasting contact in the units of their run; None for other systems than the last."""
    longest = grains.largest_stable_step
    if longest is None or grains.regime == "collisional" or system.last is not last:
        return None
    share, contacts = at_rest.SAFE_SHARE, digits(grains.coordination or 0.0, 2)
    step = share * longest / SCALES[last.units][2]
    return corrections.LargestStep(
        step, f"{share:g} of the longest stable one at {contacts} contacts per grain"
    )


def _held(stage: Stage, support: drive.Support, options: Options, around: loads.Around) -> GrainState:
    """How grains are held together, in SI units; ``options`` are in the units of the run."""
    rate = None if options.drive is None else options.drive.shear_rate
    load = loads.load_of(stage, support, options.load, rate, around)
    state = at_rest.grain_state(around.cases, load, stage.time_step, around.dimension)
    mass, length, time = SCALES[stage.units]
    unit = mass / (length ** (around.dimension - 2) * time**2)
    sizes = {"largest_stable_step": time, "pressure": unit, "pressure_for_rigid": unit}
    sizes |= dict.fromkeys(("height_for_rigid", "layers_height", "centrifuging_radius"), length)
    known = {name: getattr(state, name) for name in sizes}
    springs = [
        case.spring_powers for case in around.cases if case.spring and case.spring[0] == state.stiffness
    ]
    return replace(
        state,
        stiffness_unit=_unit(springs[0], stage.units) if springs else None,
        **{name: value * sizes[name] for name, value in known.items() if value is not None},
    )


def _words_of_state(state: GrainState, units: str, dimension: int = 3) -> str:
    """The sentence on how grains are held together, after a blank."""
    text = state_words.sentence(state, units == "lj", dimension)
    return f" {text}" if text else ""


# --- systems and numbers --------------------------------------------------------------------------------------


def _of_system(system: ParticleSystem, law: Law, options: Options, step: float | None) -> Verdict:
    walls = "wall" in system.boundary
    temperature, support = system.granular_temperature, drive.support_of_system(system)
    overlap, coordination, several = loads.contacts_of_system(system) if support.rests else (None, None, None)
    state = dumps.State(
        step=0,
        grains=system.n,
        packing_fraction=system.packing_fraction,
        temperature=temperature,
        mean_diameter=2.0 * float(system.radius.mean()),
        largest_overlap=overlap,
        coordination=coordination,
        in_several_contacts=several,
    )
    resting = [Finding(_rest(support, system.n))] * support.rests
    densities = system.mass / (UNIT_BALL[system.dimension] * system.radius**system.dimension)
    in_system = drive.of_system(system)
    if options.drive is None and not options.speeds and not system._walls_move:
        options = replace(options, drive=in_system)
    purpose = options.drive or in_system
    driven = drive.words_of(None, support) if options.drive is None else ""
    quantity = "cooling" if purpose is None else purpose.quantity
    pull = float(np.linalg.norm(system.gravity))
    question = answer.Question(
        quantity,
        False,
        driven,
        drive.option_of(support, pull, float(system.radius.max()), system.dimension, 1.0, 1.0),
        purpose,
        purpose is not None and purpose.heats_spins,
    )
    stage = replace(
        NO_RUN, gravity=pull or None, shear_rate=abs(system.shear_rate) or None, dimension=system.dimension
    )
    return _of_law(
        balls=cases.sizes(system),
        law=law,
        options=options,
        step=step,
        stage=stage,
        walls=walls,
        states=(state,),
        resting=resting,
        question=question,
        support=support,
        bed=loads.bed_of_system(system),
        kinds=mixture.of_grains(["1"] * system.n, system.radius, densities),
    )


def _of_law(
    balls: Sequence[Ball],
    law: Law,
    options: Options,
    step: float | None,
    stage: Stage,
    walls: bool,
    states: tuple[dumps.State, ...] = (),
    resting: Sequence[Finding] = (),
    question: answer.Question | None = None,
    support: drive.Support = NO_SUPPORT,
    bed: dumps.Bed | None = None,
    kinds: tuple[mixture.Kind, ...] = (),
) -> Verdict:
    supposed = question is None  # a ball, and a wall that need not be there
    if question is None:
        source = options.drive
        question = (
            answer.Question(source.quantity, drive_option=source.option) if source else answer.Question()
        )
    contacts = cases.of_law(balls, law, walls, step)
    radii = {str(k): ball.radius for k, ball in enumerate(balls, 1)}
    densities = {str(k): ball.density for k, ball in enumerate(balls, 1)}
    dimension = stage.dimension
    dumped = _states(_frames(options), radii, dimension, densities)
    question = replace(question, dumped=bool(dumped))
    gas, speeds = _surroundings(options, dumped or states, dimension)
    gas = replace(gas, quantity=question.quantity)
    chosen = () if speeds or options.drive else CHOSEN_SPEEDS
    examined = _examined(contacts, gas, speeds, options.drive, options.drive or question.purpose, chosen)
    rows = [_in_si(*pair, "si") for pair in examined]
    at = "" if speeds or options.drive or all(row.speed is None for row in rows) else " at 1 m/s"
    around = loads.Around(
        cases=contacts,
        dimension=dimension,
        state=next(reversed(dumped or states), None),
        bed=bed,
        kinds=kinds,
        lasting=_contacts_last(rows, dumped),
    )
    grains = _held(replace(stage, time_step=step), support, options, around)
    question = _flowing(question, grains, stage.gravity is not None)
    invalidates = [*_held_together(grains, options, [*resting, *_lasting((), (), rows, dumped, bool(at))])]
    missing = _missing(rows, gas, speeds, options.drive)
    decisive = [row for row in rows if not supposed or row.types[1] != "wall"]
    admissible, sentence = answer.answer(decisive, invalidates, (), missing, question)
    rubs = supposed and any(row.friction.coefficient for row in rows)
    return Verdict(
        admissible=admissible,
        sentence=sentence
        + " This holds far from walls that rub." * (rubs and admissible is True)
        + answer.steady(rows, options.drive, False)
        + _words_of_state(grains, "si", dimension),
        code=None,
        version=None,
        units="si",
        units_given=True,
        time_step=step,
        numerical_damping=None,
        rows=tuple(rows),
        stages=(),
        states=dumped or states,
        checked=tuple(_checked(rows, False, dumped)),
        ignored=(),
        invalidates=tuple(invalidates),
        unknown=(),
        missing=missing,
        remarks=tuple(_remarks(examined, options, gas, speeds, at, False)),
        warnings=tuple(_traps(rows)),
        corrected=(),
        quantity=None if question.driven else question.quantity,
        restitution_error=options.restitution_error,
        speeds_chosen=bool(at),
        state=grains,
    )
