"""Jobs of ``hardlimit gas`` and ``gas compare``: start, law, run and outputs, from a job file and options."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import hardlimit as hl

from ..boxes import files as box_files
from ..boxes.box import BOUNDARIES
from ..boxes.files import FORMATS
from ..boxes.files.completion import UNITS
from ..boxes.hard_spheres import expected_duration
from ..boxes.rules import PARAMETERS, RULES
from ..boxes.theory import Gas
from ..boxes.walls import AXES, LARGEST, WAVEFORMS
from ..column import files as columns
from ..support import toml, units, validation
from ..support.formatting import listed
from .job import Entry, changed, table_of
from .options import (
    FRICTION_UNITS,
    film,
    picture,
    take_friction_values,
    take_law,
    with_friction,
    writable,
)

#: The default start: glass beads.
GLASS_BEADS: Final = {"n": 1000, "packing_fraction": 0.3, "radius": 1e-3, "density": 2500.0, "rms_speed": 1.0}
RESTITUTION: Final = 0.9
#: The option, and the key of a table, for μ.
FRICTION: Final = "friction"
#: Collisions per particle, at the initial rate, in a run whose end is not given.
COLLISIONS: Final = 20


def entry_of(function: Any, name: str, text: str, unit: str | None = None, **more: Any) -> Entry:
    """The entry of an argument of a function. Its help ends with the default; that of a start is a glass bead."""
    value = GLASS_BEADS.get(name, inspect.signature(function).parameters[name].default)
    shown = f"{value:g}" if isinstance(value, float) else value
    return Entry(name, f"{text}  [default: {shown}]", unit, **more)


_start = partial(entry_of, hl.ParticleSystem.random)
_run = partial(entry_of, hl.event_driven)


#: Entries of the table [random]: a random start, or changes of the box if the start is from a file.
START: Final = (
    _start("n", "Number of particles.", kind=int),
    _start("packing_fraction", "Fraction of the box that particles fill.", "1"),
    _start("radius", "Radius [m]; give it twice for the limits of a uniform distribution.", "m", many=True),
    _start("density", "Density [kg/m³].", "kg/m3"),
    _start("rms_speed", "Root mean square of the initial speeds [m/s].", "m/s"),
    Entry(
        "rms_spin",
        "Root mean square of the initial angular velocities [rad/s], or equal: as much energy for each axis of "
        "rotation as for each of motion.  [default: no spin]",
        "rad/s",
        word="equal",
    ),
    Entry(
        "inertia_factor",
        "Moment of inertia of the particles over m R².  [default: 0.4 for spheres, 0.5 for disks]",
        "1",
    ),
    _start("dimension", "Dimension: 3 for spheres, 2 for disks.", kind=int),
    _start("seed", "Seed of the random start; the same seed gives the same start.", kind=int),
    _start("boundary", f"Boundary: {' | '.join(BOUNDARIES)}; repeat it for each axis.", many=True),
    _start("gravity", "Gravity [m/s²], down the last axis; repeat it for a vector.", "m/s2", many=True),
    Entry("shake", "Shake a wall: AMPLITUDE:FREQUENCY, such as 0.5mm:50Hz.", metavar="AMPLITUDE:FREQUENCY"),
    Entry("wall", "The wall to shake: x- | x+ | y- … z+.  [default: the lower one of the last axis]"),
    Entry("waveform", f"How it moves: {' | '.join(WAVEFORMS)}.  [default: sine]"),
    Entry(
        "shear",
        "Shear the box at this rate [1/s]: flow along x, gradient along y or the axis with the boundary lees-edwards.",
        "1/s",
    ),
    Entry("heat", "Heat the grains by random kicks of this total power [W].", "W"),
    Entry("heat_spins", "Heat the spins of grains that rub, in the same way [W].", "W"),
    Entry("frame", "Index of the frame of FILE.  [default: the last one]", kind=int),
    Entry("units", f"Units of FILE: {' | '.join(UNITS)}.  [default: those that it names, or si]"),
    Entry(
        "allowed_overlap",
        "Largest accepted overlap of grains in FILE, relative to the sum of their radii.  [default: rounding errors]",
        "1",
    ),
)
OF_SHAKING: Final = ("shake", "wall", "waveform")
OF_HEATING: Final = ("heat", "heat_spins")
OF_THE_BOX: Final = ("boundary", "gravity", *OF_SHAKING, "shear", *OF_HEATING)
#: How a file is read, and what it may lack.
OF_READING: Final = ("frame", "units", "allowed_overlap")
#: Arguments of ``ParticleSystem.read``.
READ: Final = (*OF_READING, "radius", "density", "inertia_factor", "boundary", "gravity")
#: What may be given with a start from a file.
OF_A_FILE: Final = (*OF_THE_BOX, *READ)
#: Options that stand for arguments of Python in messages.
ALIASES: Final = {
    **dict.fromkeys(("path", "file"), "FILE"),
    **dict.fromkeys(("walls", "amplitude", "frequency"), "--shake"),
    **{"shear_rate": "--shear", "thermostat": "--heat", "rotational": "--heat-spins"},
    **{"folder": "--write-input", "molecular_dynamics": "--engine auto"},
}
#: Interval between the kicks of a heated gas, in mean times between two collisions of a particle.
KICK_INTERVAL: Final = 0.1


def _parameter(name: str, unit: str) -> Entry:
    """A parameter of a collision rule."""
    rules = " and ".join(rule.name for rule in RULES.values() if name in rule.parameters)
    return Entry(name, f"{name.replace('_', ' ').capitalize()} of the rule {rules} [{unit}].", unit=unit)


SAMPLES: Final = _run("samples", "Number of equal time intervals between samples.", kind=int)
UNTIL: Final = Entry(
    "until", f"End of the run [s].  [default: about {COLLISIONS} collisions per particle]", "s"
)
#: Entries of the table [event_driven], which also has the restitution of all collisions.
RUN: Final = (
    Entry("rule", f"Collision rule: {' | '.join(RULES)}.  [default: constant, or law with a contact law]"),
    *(_parameter(name, unit) for name, unit in PARAMETERS.items()),
    Entry(
        "tangential_restitution",
        "Tangential restitution β of collisions that do not slide, with --friction and without a contact law.",
        unit="1",
    ),
    UNTIL,
    Entry("max_collisions", "Number of collisions after which the run ends.", kind=int),
    SAMPLES,
    Entry(
        "checkpoint",
        "Checkpoint for --resume, written at intervals, at Ctrl-C and at SIGTERM.",
        metavar="FILE",
    ),
    _run("checkpoint_every", "Wall-clock time between checkpoints [s].", "s"),
)
#: Entries of the table [output].
OUTPUT: Final = (
    Entry(
        "out",
        "Trajectory (xyz; gsd with the extra hardlimit[files]); with --resume, the same file goes on.",
        metavar="FILE",
    ),
    Entry("save", "Series, collisions or contacts, and final state as NetCDF.", metavar="FILE.nc"),
    Entry("plot", "Temperature, rate and pressure over time, with theory (png, pdf, …).", metavar="FILE"),
    Entry(
        "animate", "Film (gif; mp4 with the extra hardlimit[film]); spheres in cross section.", metavar="FILE"
    ),
)
#: Entries of the table [event_driven] that make the rule for all collisions, with the tangential restitution.
CONSTANT: Final = ("restitution", "friction")


def law_table(name: str, content: Any) -> hl.Law:
    """Check the table of a law, which may have friction, by the names of the options."""
    own, rubbing = content, {}
    if isinstance(content, dict):
        rubbing = {key: content[key] for key in content if key in FRICTION_UNITS}
        own = {key: content[key] for key in content if key not in rubbing}
    law = columns.law_table(name, own)
    kinds = {key: toml.text if unit is None else toml.quantity(unit) for key, unit in FRICTION_UNITS.items()}
    values = toml.table(name, rubbing, kinds)
    return columns.prefixed(f"{name}.", lambda: with_friction(law, values))


#: The keys of a job file.
KINDS: Final[Mapping[str, toml.Kind]] = {
    "start": toml.text,
    "random": table_of(START),
    "law": law_table,
    "event_driven": table_of(RUN, {name: toml.quantity("1") for name in CONSTANT}),
    "output": table_of(OUTPUT),
}


def read(file: str | None) -> dict[str, Any]:
    """The tables of a job file; a file of particles is the start of an empty job."""
    if file is None:
        return {}
    ending = Path(file).suffix.lower()
    if ending != ".toml" and box_files.is_readable(file):
        return {"start": file}
    if ending != ".toml":
        raise ValueError(
            f"FILE: got {validation.shown(file)}, must end in {listed(['.toml', *FORMATS], 'or')}, or be a "
            "text dump of LAMMPS or LIGGGHTS"
        )
    content = toml.read(file)
    tables = columns.prefixed(f"{file}: ", lambda: toml.table("", content, KINDS))
    if "start" in tables:
        if tables.get("random", {}).keys() - set(OF_A_FILE):
            raise ValueError(f"{file}: start | random: got both, must be at most one of them")
        tables["start"] = str(Path(file).parent / tables["start"])
    return tables


@dataclass(frozen=True)
class GasJob:
    """A simulation of a box of grains, as given by a job file and options."""

    file: str | None  #: particles to start from; None for a random start
    random: dict[str, Any]  #: arguments of ``ParticleSystem.random``, or changes of the box of a file
    law: hl.Law | None  #: of the job file
    constant: dict[str, Any]  #: restitution and friction of the job file, for all collisions
    law_option: tuple[str | None, dict[str, Any]]  #: name and parameters of the law in the options
    friction: dict[str, Any]  #: options of friction
    run: dict[str, Any]  #: arguments of the solver
    outputs: dict[str, Path | None]  #: "out", "save", "plot" and "animate"

    def start(self, **changes: Any) -> hl.ParticleSystem:
        """The start, from a file or at random; ``changes`` are arguments of a random one."""
        settings = {name: single(value) for name, value in self.random.items()} | changes
        powers, rate = [settings.pop(name, None) for name in OF_HEATING], settings.pop("shear", None)
        shaken: dict[str, str] = {name: settings.pop(name) for name in OF_SHAKING if name in settings}
        if self.file is None:
            for name in OF_READING:
                if name in settings:
                    shown = validation.shown(settings[name])
                    raise ValueError(f"{name}: got {shown}, must be left out without a start from a file")
            arguments = GLASS_BEADS | settings
            d, sides = arguments.get("dimension", 3), arguments.get("boundary")
            arguments |= moving_walls(shaken, d, sides)
            arguments |= shear(rate, sides, arguments.get("boundary", ["periodic"] * d))
            return heated(hl.ParticleSystem.random(**arguments, progress=not changes), *powers)
        for name in settings:
            if name not in OF_A_FILE:
                raise ValueError(f"{name}: must be left out with a start from a file")
        return heated(self._read(settings, shaken, rate), *powers)

    def _read(
        self, settings: dict[str, Any], shaken: dict[str, str], rate: float | None
    ) -> hl.ParticleSystem:
        """The start from the file. Walls around its grains, gravity and shear may be those of the options."""
        assert self.file is not None
        reading: dict[str, Any] = {name: settings[name] for name in READ if name in settings}
        if rate is not None and box_files.is_tilted(self.file):
            reading["shear_rate"], rate = rate, None  # the flow is that of the file
        system = hl.ParticleSystem.read(self.file, **reading)
        changes = moving_walls(shaken, system.dimension, system.boundary)
        changes |= shear(rate, settings.get("boundary"), system.boundary)
        if not changes:
            return system
        changed_box = system.replace(**changes, allowed_overlap=system.largest_overlap)
        if rate is not None:  # the flow changes, velocities relative to it do not
            flow = [box.domain.mean_flow(system.positions) for box in (changed_box, system)]
            changed_box = changed_box.replace(velocities=system.velocities + flow[0] - flow[1])
        return changed_box

    def contact_law(self) -> hl.Law | None:
        """The law of the job file, changed by the options; None if there is neither."""
        name, parameters = self.law_option
        if name is None and not parameters and self.law is None:
            return None
        return with_friction(columns.changed_law(self.law, name, parameters), self.friction)

    def rule(self) -> dict[str, Any]:
        """The argument ``law``, or those of a constant rule, of :func:`hardlimit.event_driven`."""
        name, parameters = self.law_option
        for key in self.constant:
            if self.law is not None:
                raise ValueError(f"law | event_driven.{key}: got both, must be exactly one of them")
        if name is not None or self.law is not None or parameters.keys() - {"restitution"}:
            self._refuse_friction_of_rule()
            return {"law": self.contact_law()}
        for key, value in self.friction.items():
            if key != FRICTION:
                shown = validation.shown(value)
                raise ValueError(f"{key}: got {shown}, must be left out without a contact law")
        coefficient = {key: value for key, value in self.friction.items() if key == FRICTION}
        return {"restitution": RESTITUTION} | self.constant | parameters | coefficient

    def _refuse_friction_of_rule(self) -> None:
        """Refuse friction of the constant rule in a job file whose options give a law."""
        if FRICTION in self.constant:
            raise ValueError(
                "event_driven.friction: must be left out with a contact law, whose friction --friction gives"
            )


def make_job(file: str | None, params: dict[str, Any]) -> GasJob:
    """The job of a file, or of glass beads without a file, changed by the options, which are taken out of
    ``params``."""
    law, friction = take_law(params), take_friction_values(params)
    tables = read(file)
    run = changed(tables.get("event_driven", {}), RUN, params)
    if "checkpoint_every" in run and "checkpoint" not in run:
        raise ValueError("checkpoint_every: must be left out without --checkpoint")
    return GasJob(
        file=tables.get("start"),
        random=changed(tables.get("random", {}), START, params),
        law=tables.get("law"),
        constant={name: run.pop(name) for name in CONSTANT if name in run},
        law_option=law,
        friction=friction,
        run=run,
        outputs=checked_outputs(changed(tables.get("output", {}), OUTPUT, params)),
    )


def checked_outputs(values: Mapping[str, Any]) -> dict[str, Path | None]:
    """The files to write, checked before anything is computed."""
    trajectories = [ending for ending, kind in FORMATS.items() if kind is not FORMATS[".data"]]
    return {
        "out": writable("out", values.get("out"), *trajectories),
        "save": writable("save", values.get("save"), ".nc"),
        "plot": picture("plot", values.get("plot")),
        "animate": film("animate", values.get("animate")),
    }


def moving_walls(shaken: Mapping[str, str], dimension: int, boundary: Any) -> dict[str, Any]:
    """The arguments ``walls`` and, if it is not given, ``boundary`` of a system with a wall that is shaken."""
    if not shaken:
        return {}
    if "shake" not in shaken:
        raise ValueError(f"{next(iter(shaken))}: must be left out without --shake")
    amplitude, colon, frequency = shaken["shake"].partition(":")
    if not colon:
        raise ValueError(
            f"shake: got {validation.shown(shaken['shake'])}, must be an amplitude and a frequency, such as 0.5mm:50Hz"
        )
    wall = hl.MovingWall(
        units.number("shake", amplitude, "m"),
        units.number("shake", frequency, "Hz"),
        shaken.get("waveform", "sine"),
    )
    axes = AXES[:dimension]
    name = shaken.get("wall", axes[-1] + "-")
    validation.one_of("wall", name, [axis + end for axis in axes for end in "-+"])
    settings: dict[str, Any] = {"walls": {name: wall}}
    if boundary is None:
        settings["boundary"] = ["wall" if axis == name[0] else "periodic" for axis in axes]
    return settings


def shear(rate: float | None, boundary: Any, sides: Any) -> dict[str, Any]:
    """The arguments ``shear_rate`` and ``boundary`` of a sheared system.

    ``boundary`` is the boundary in options and job, ``sides`` the one of the system without shear, for each axis.
    """
    if rate is None:
        return {}
    validation.number("shear", rate, -LARGEST, highest=LARGEST, lowest_allowed=True)
    if "lees-edwards" in (sides if boundary is None else boundary):
        return {"shear_rate": rate}
    if boundary is not None:
        shown = boundary if isinstance(boundary, str) else ", ".join(boundary)
        raise ValueError(f"shear: got the boundary {shown}, must be one with lees-edwards, or left out")
    if list(sides[:2]) != ["periodic", "periodic"]:
        walls = listed([axis for axis, side in zip(AXES, sides, strict=False) if side == "wall"], "and")
        raise ValueError(f"shear: got walls along {walls}, must be none along x and y, flow and gradient")
    return {"shear_rate": rate, "boundary": [sides[0], "lees-edwards", *sides[2:]]}


def heated(
    system: hl.ParticleSystem, power: float | None, spinning: float | None = None
) -> hl.ParticleSystem:
    """The system with a thermostat of these powers [W], which kicks often compared with the time between collisions.

    Enskog's rate is that at the larger of the initial temperature and the one at which collisions of ε = 0 dissipate
    these powers.
    """
    powers = {"heat": power, "heat_spins": spinning}
    checked = {
        name: validation.number(name, value, 0.0, highest=LARGEST)
        for name, value in powers.items()
        if value is not None
    }
    if not checked:
        return system
    gas = Gas(system.n, float(system.radius.mean()), 1.0, system.domain.volume, system.dimension)
    steady = (2.0 * sum(checked.values()) / (float(system.mass.sum()) * float(gas.collision_rate(1.0)))) ** (
        2.0 / 3.0
    )
    rate = float(gas.collision_rate(max(system.granular_temperature, steady)))
    return system.replace(
        thermostat=hl.RandomKicks(
            checked.get("heat", 0.0), KICK_INTERVAL / rate, rotational=checked.get("heat_spins")
        )
    )


def single(value: Any) -> Any:
    """The member of a list of length one, any other value unchanged. (Options that may be repeated give lists.)"""
    return value[0] if isinstance(value, list | tuple) and len(value) == 1 else value


def default_end(system: hl.ParticleSystem) -> float:
    """The time [s], rounded, in which each particle collides about 20 times at the initial rate."""
    return float(f"{expected_duration(system, COLLISIONS * system.n // 2):.2g}")
