"""The check of a script, a text, a system or a ball: contacts, dump, findings and the answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..boxes.box import UNIT_BALL
from ..boxes.system import ParticleSystem
from ..boxes.time_step import accepted_error
from ..contact.balls import Ball
from ..contact.contact import Law
from ..convert.force import MAX_SPEED, MIN_SPEED
from ..support import validation
from . import answer, at_rest, cases, drive, dumps, findings, held, loads, mixture, remarks, surroundings
from .options import CHOSEN_SPEEDS, NO_RUN, NO_SUPPORT, Options
from .result import Finding, Verdict
from .script_check import checked_script
from .scripts import Stage
from .scripts import read as read_script
from .supplied import supplied
from .units import contact_in_si


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
        frames = surroundings.frames(options)
        seen = dumps.largest_type(frames)
        script = read_script(source, code=code, version=version, variables=options.variables, types_seen=seen)
        return checked_script(script, options, frames)
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
    resting = [Finding(findings.rest(support, system.n, findings.RESTS))] * support.rests
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
    dumped = surroundings.states(surroundings.frames(options), radii, dimension, densities)
    question = replace(question, dumped=bool(dumped))
    gas, speeds = surroundings.gas(options, dumped or states, dimension)
    gas = replace(gas, quantity=question.quantity)
    chosen = () if speeds or options.drive else CHOSEN_SPEEDS
    examined = surroundings.examined(
        contacts, gas, speeds, options.drive, options.drive or question.purpose, chosen
    )
    rows = [contact_in_si(*pair, "si") for pair in examined]
    at = "" if speeds or options.drive or all(row.speed is None for row in rows) else " at 1 m/s"
    around = loads.Around(
        cases=contacts,
        dimension=dimension,
        state=next(reversed(dumped or states), None),
        bed=bed,
        kinds=kinds,
        lasting=findings.contacts_last(rows, dumped),
    )
    grains = held.state_of(replace(stage, time_step=step), support, options, around)
    question = held.flowing(question, grains, stage.gravity is not None)
    invalidates = [
        *findings.held_together(
            grains, options, [*resting, *findings.lasting((), (), rows, dumped, bool(at))]
        )
    ]
    missing = remarks.missing(rows, gas, speeds, options.drive)
    decisive = [row for row in rows if not supposed or row.types[1] != "wall"]
    admissible, sentence = answer.answer(decisive, invalidates, (), missing, question)
    rubs = supposed and any(row.friction.coefficient for row in rows)
    return Verdict(
        admissible=admissible,
        sentence=sentence
        + " This holds far from walls that rub." * (rubs and admissible is True)
        + answer.steady(rows, options.drive, False)
        + held.words_of_state(grains, "si", dimension),
        code=None,
        version=None,
        units="si",
        units_given=True,
        time_step=step,
        numerical_damping=None,
        rows=tuple(rows),
        stages=(),
        states=dumped or states,
        checked=tuple(findings.parts_checked(rows, False, dumped)),
        ignored=(),
        invalidates=tuple(invalidates),
        unknown=(),
        missing=missing,
        remarks=tuple(remarks.on_contacts(examined, rows, options, gas, speeds, at, False)),
        warnings=tuple(findings.traps(rows)),
        corrected=(),
        quantity=None if question.driven else question.quantity,
        restitution_error=options.restitution_error,
        speeds_chosen=bool(at),
        state=grains,
    )
