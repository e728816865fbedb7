"""What presses the grains, and how strongly: options, a prescribed pressure, or the weight above."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from ..boxes.box import UNIT_BALL
from ..boxes.system import ParticleSystem
from ..support import validation
from ..support.formatting import digits, length, listed, quantity
from . import dumps, flows, mixture
from .at_rest import Load, Packing, most_layers, pressed, settled, weight
from .contacts import Body, Case
from .drive import Support
from .scripts import Stage
from .scripts.description import DENSEST, FEW, WALL, Contents, Lot
from .supplied import SCALES

#: Packing fractions that a bed may have, by dimension; others are not those of the grains at rest.
BEDS: Final = {3: (0.5, 0.75), 2: (0.7, 0.92)}

BY_SCRIPT: Final = "as the script says"
#: Largest mean of the three stresses over that along two axes while the third one is compressed, in cells of 500
#: spheres in YADE: dense ones (φ = 0.64) have 1.55, 1.66 and 1.83 with μ = 0.3, 0.5 and 1, a loose one (0.57, μ = 0.5)
#: 1.37.
SHEARED: Final = 1.9
#: Pressure before over that now from which grains count as unloaded.
UNLOADED: Final = 1.2
#: Volume of one layer of spheres over that of a box of their height.
LAYER: Final = 0.6
#: Fewest contacts of a grain in what is taken as a packing.
LEAST: Final = 2.0
#: Cosine of 10°, up to which a box stands upright, and the largest component of gravity across it that counts as none.
UPRIGHT, LEVEL = 0.985, 1e-9


class LoadOptions(NamedTuple):
    """The options of a check."""

    pressure: float | None = None  #: [Pa], in two dimensions [N/m]
    height: float | None = None  #: of a bed [m]

    @property
    def rests(self) -> bool:
        """Whether one of them says that grains are held together."""
        return self.pressure is not None or self.height is not None

    def in_units(self, mass: float, length: float, time: float, dimension: int) -> LoadOptions:
        """The same in units of these sizes."""
        unit = mass / (length ** (dimension - 2) * time**2)
        pressure = None if self.pressure is None else self.pressure / unit
        return LoadOptions(pressure, None if self.height is None else self.height / length)


def checked_load(pressure: object, height: object) -> LoadOptions:
    """The options of a check."""
    if pressure is not None and height is not None:
        raise ValueError("pressure | height: got both, must be at most one of them")
    return LoadOptions(
        None if pressure is None else validation.number("pressure", pressure, 0.0),
        None if height is None else validation.number("height", height, 0.0),
    )


class Around(NamedTuple):
    """What is known of the grains, in the units of the script."""

    cases: Sequence[Case]
    dimension: int
    units: str = "si"
    state: dumps.State | None = None  #: of the last frame of a dump
    bed: dumps.Bed | None = None  #: of a dump or a system
    lasting: bool | None = None  #: whether a dump shows lasting contacts; None without one
    barostat: bool = False
    piston: bool = False  #: whether a wall moved along gravity in this run or one before
    before: float = 0.0  #: largest pressure that this run or one before prescribes
    elastic: bool = False  #: whether nothing dissipates, so that no grain comes to rest
    fluid: bool = False  #: whether one drags the grains or carries a part of their weight
    kinds: tuple[mixture.Kind, ...] = ()  #: of the grains of a dump or a system
    poured: bool = False  #: whether these grains are equal, and fell from a height few at a time

    @property
    def settled(self) -> Packing:
        """As expected of such grains at rest. Grains of unknown friction count as those of 0.5."""
        return settled(_friction(self.cases, 0.5, 0.0), self.dimension, self.poured)

    @property
    def packing(self) -> Packing:
        """As measured in a dump if that is the one of a bed, else as expected."""
        expected = self.settled
        low, high = BEDS[self.dimension]
        state = self.state
        contacts = 0.0 if state is None or state.coordination is None else state.coordination
        if state is None or state.packing_fraction is None or contacts < LEAST:
            return expected
        rigid = None if self.bed is None else expected.rigid
        packing = expected._replace(coordination=contacts, rigid=rigid, counted=True)
        in_range = low <= state.packing_fraction <= high
        return packing._replace(packing_fraction=state.packing_fraction) if in_range else packing

    @property
    def speed_unit(self) -> float:
        """1 m/s."""
        _, metre, second = SCALES[self.units]
        return second / metre

    def length(self, value: float) -> str:
        """A length in words."""
        metre = SCALES[self.units][1]
        return digits(value, 3) if self.units == "lj" else length(float(f"{value * metre:.3g}"))


def load_of(
    stage: Stage, support: Support, options: LoadOptions, shear_rate: float | None, around: Around
) -> Load:
    """What holds the grains of a run together. ``shear_rate``: an option, which comes before that of the script."""
    under_pressure = (
        bool(stage.pressed) or stage.pressure is not None or options.pressure is not None or around.barostat
    )
    if options.height is not None and not stage.gravity:
        raise ValueError(f"height: got {options.height:g}, must be left out without gravity")
    falls = around.elastic or stage.contents.never_meet
    rests = (support.rests and not falls) or options.height is not None
    rate, lasting = stage.shear_rate if shear_rate is None else shear_rate, around.lasting
    if stage.gravity and support.moves and not (rests or lasting or under_pressure):
        frequency = None if support.motion is None else support.motion.frequency
        return Load("shaken", gravity=stage.gravity, shaking=support.shaking, frequency=frequency)
    if lasting is False or not (under_pressure or rests or lasting):
        return Load("gas")
    driven = rate is not None or (support.moves and support.shaking is None) or stage.contents.pours
    name = "flow" if driven else "pressed" if under_pressure or not rests else "rest"
    kinds = _kinds(stage, around.kinds)
    load = Load(
        name,
        packing=around.packing,
        kinds=kinds,
        shear_rate=rate,
        gravity=stage.gravity,
        walled_floor=stage.contents.floor if stage.contents.walled else None,
        density=_density(around, kinds, stage.contents.lots),
        shaking=support.shaking,
        layers=most_layers(stage.contents.count, around.dimension),
        highest=_height(stage) or stage.contents.height or math.inf,
        concentration=stage.contents.concentration,
        speed_unit=around.speed_unit,
    )
    load = replace(load, **_pressure(stage, options, around, under_pressure))
    if load.origin and load.concentration > 1.0:
        load = replace(load, origin=f"{load.origin}, whole clumps on single spheres")
    walls = stage.contents.without or "what moving walls add" * support.moves
    beside = ["the fluid"] * around.fluid + [walls] * bool(walls)
    if load.weight and beside:
        load = replace(load, origin=f"{load.origin}, without {listed(beside)}")
    if stage.gravity and stage.down:
        tilt = math.degrees(math.acos(min(max(map(abs, stage.down)), 1.0)))
        load = replace(load, tilt=tilt, **flows.of_stage(stage, around.cases, tilt, around.speed_unit))
    friction = _friction(around.cases, 1.0, 1.0)
    load = replace(load, uniaxial=stage.uniaxial and load.origin.startswith(BY_SCRIPT), friction=friction)
    by_script = stage.pressed or stage.pressure is not None or around.barostat
    rests = name == "rest" or load.weight or bool(stage.gravity and not by_script)
    if rests or around.dimension == 2 or around.packing != around.settled:  # that of a dump
        return load
    return replace(load, packing=pressed(friction))


def _friction(cases: Sequence[Case], unknown: float, without: float) -> float:
    """The largest coefficient of friction of the grains. ``without``: if there are no contacts between grains."""
    pairs = [case.friction.coefficient for case in cases if case.second is not None]
    return max((unknown if mu is None else mu for mu in pairs), default=without)


def poured(stage: Stage, kinds: tuple[mixture.Kind, ...]) -> bool:
    """Whether equal grains were poured. ``kinds``: of a dump."""
    return stage.contents.poured and not _kinds(stage, kinds)


def _kinds(stage: Stage, dumped: tuple[mixture.Kind, ...]) -> tuple[mixture.Kind, ...]:
    """The kinds of grains of a dump, else of what the script makes; empty if they are not known or all equal.

    Radii of one type whose numbers are not known count as uniform between its ends.
    """
    moving = {name: kind for name, kind in stage.grains.items() if not kind.frozen}
    kinds = dumped or mixture.of_lots(stage.contents.lots, moving)
    if stage.contents.concentration > 1.0:
        return ()  # the spheres of a clump have no contacts of their own
    if len(moving) != 1:
        return kinds
    ((name, only),) = moving.items()
    if not kinds and only.radii is not None:
        return mixture.uniform(name, only.radii)
    return tuple(kind._replace(type=name) for kind in kinds)


def _pressure(stage: Stage, options: LoadOptions, around: Around, pressed: bool) -> dict[str, Any]:
    """The pressure, where it comes from, whether it is a weight, and whether it is an upper bound."""
    if options.pressure is not None:
        return {"pressure": options.pressure, "origin": "given"}
    if pressed and options.height is None:
        return {} if stage.pressure is None else _prescribed(stage, stage.pressure, around)
    if stage.gravity is None or (around.piston and options.height is None):
        return {}
    gravity = stage.gravity * max(map(abs, stage.down or (1.0,)))  # across the floor of a slope
    kinds = _kinds(stage, around.kinds)
    if options.height is None and around.bed is not None:
        origin = f"below {around.length(around.bed.height)} of grains"
        bound = around.bed.walled
        return {"pressure": around.bed.mass * gravity, "origin": origin, "weight": True, "bound": bound}
    contents, phi = stage.contents.at_most, around.packing.packing_fraction
    density = _density(around, kinds, contents.lots)
    if options.height is None and less_than_a_layer(contents, around.dimension):
        if density is None or not contents.filled:
            return {}
        volume, thick = contents.filled / phi, contents.layer
        deep = heap(volume, around.dimension) if thick is None else heap(volume / thick, 2)
        pressure = weight(deep, phi * density, gravity)
        plane = "" if thick is None else " in one plane"
        origin = f"below a heap of {contents.count:.0f} grains at 45°{plane}, as they do not cover the floor"
        return {"pressure": pressure, "origin": origin, "weight": True, "bound": True, "sparse": True}
    if options.height is None and density is not None and contents.filled and contents.floor:
        count = "the grains" if contents.count is None else f"{contents.count:.0f} grains"
        pressure = weight(contents.filled / contents.floor, density, gravity)
        origin = f"below {count} on the floor of the box"
        full = _height(stage)
        if full is None or contents.filled / contents.floor <= phi * full:
            return {"pressure": pressure, "origin": origin, "weight": True, "bound": contents.walled}
    if options.height is None and contents.count is not None and contents.count <= FEW:
        return {}
    edge = _height(stage) or contents.height
    height = edge if options.height is None else options.height
    if height is None or density is None:
        return {}
    bound = options.height is None
    phi = max(phi, contents.packed) if bound and not _height(stage) else phi
    grains = f"{around.length(height)} of grains at φ = {digits(phi, 2)}"
    origin = f"a box of {grains}" if bound else f"below {grains}"
    if bound and contents.height is not None:
        twice = " with overlaps in clumps counted twice" * (phi > DENSEST)
        origin = f"{around.length(height)} {contents.height_from}, at φ = {digits(phi, 2)}{twice}"
    pressure = weight(height, phi * density, gravity)
    return {"pressure": pressure, "origin": origin, "weight": True, "bound": bound}


def _prescribed(stage: Stage, pressure: float, around: Around) -> dict[str, Any]:
    """The pressure of the script. Grains that a piston relieves keep a part of what pressed them across it before."""
    origin = BY_SCRIPT + f"; up to {SHEARED:g} times that while one axis is compressed" * stage.strained
    origin += ", until a callback changes it" * stage.pressure_changes
    if stage.contents.other_clumps:
        return {"pressure": pressure, "origin": f"{origin}, more on the spheres of a clump", "unloaded": True}
    known = {"pressure": pressure, "origin": origin}
    if not stage.uniaxial or around.before < UNLOADED * pressure:
        return known
    mass, length, time = SCALES[around.units]
    before = around.before * mass / (length * time**2)
    shown = digits(before, 3) if around.units == "lj" else quantity(before, "Pa", 3)
    origin = f"{origin}, though they may hold a part of the {shown} before"
    return known | {"origin": origin, "unloaded": True}


def less_than_a_layer(contents: Contents, dimension: int) -> bool:
    """Whether grains are too few to cover the floor."""
    contents = contents.at_most
    diameter = contents.diameter(dimension)
    if not (diameter and contents.filled and contents.floor):
        return False
    return contents.filled < LAYER * diameter * contents.floor


def heap(volume: float, dimension: int) -> float:
    """Height of a cone, in two dimensions of a triangle, with slopes of 45°; few grains rest on steeper ones."""
    return (3.0 * volume / math.pi) ** (1.0 / 3.0) if dimension == 3 else math.sqrt(volume)


def _height(stage: Stage) -> float | None:
    """The extent of the box along gravity if it stands upright; None if it does not, or is not known."""
    down = stage.down or ()
    if max(map(abs, down), default=0.0) < UPRIGHT:
        return None
    parts = [(abs(part), edge) for part, edge in zip(down, stage.edges, strict=False) if abs(part) > LEVEL]
    known = [part * edge for part, edge in parts if edge is not None]
    return math.fsum(known) if len(known) == len(parts) else None


def _own_density(body: Body, dimension: int) -> float | None:
    """Density of a grain, in two dimensions that of a disk; None if it is not known."""
    if body.mass and body.radius:
        return body.mass / (UNIT_BALL[dimension] * body.radius**dimension)
    return body.density if dimension == 3 else None


def _density(around: Around, kinds: Sequence[mixture.Kind], lots: Sequence[Lot]) -> float | None:
    """Density of the grains that move, in two dimensions that of disks; None if one is not known.

    Of grains of several types it is the mean by volume if their numbers are known, else the largest.
    """
    bodies = [body for case in around.cases for body in (case.first, case.second) if body is not None]
    moving = [body for body in bodies if not body.fixed and body.mass != math.inf]
    known = [density for body in moving if (density := _own_density(body, around.dimension))]
    if not known or len(known) < len(moving):
        return None
    if around.dimension == 2 and (mean := _of_spheres(moving, known, lots)) is not None:
        return mean
    of_type = {
        case.types[0]: body.mass / (UNIT_BALL[3] * body.radius**3)
        for case in around.cases
        for body in [case.first]
        if len({*case.types} - {WALL}) == 1 and body.mass and body.radius and body.mass != math.inf
    }
    if around.dimension != 3 or not kinds or any(kind.type not in of_type for kind in kinds):
        return max(known)
    volumes = [kind.share * kind.radius**3 for kind in kinds]
    masses = [v * (k.density or of_type[k.type]) for v, k in zip(volumes, kinds, strict=True)]
    return math.fsum(masses) / math.fsum(volumes)


def _of_spheres(moving: Sequence[Body], densities: Sequence[float], lots: Sequence[Lot]) -> float | None:
    """Mean density of disks by area, where it grows with their radius, as the mass of a sphere does; else None."""
    of_radius = [
        density / body.radius for density, body in zip(densities, moving, strict=True) if body.radius
    ]
    areas, cubes = [lot.squares for lot in lots], [lot.cubes for lot in lots]
    alike = bool(of_radius) and math.isclose(min(of_radius), max(of_radius), rel_tol=1e-9)
    if not alike or not lots or None in areas or None in cubes:
        return None
    return of_radius[0] * math.fsum(x or 0.0 for x in cubes) / math.fsum(x or 0.0 for x in areas)


def bed_of_system(system: ParticleSystem) -> dumps.Bed | None:
    """The grains of a system as a bed; the side walls of its box carry nothing known."""
    axes = np.flatnonzero(system.gravity)
    if len(axes) != 1:
        return None
    at, radius = system.positions[:, axes[0]], system.radius
    area = float(np.prod(np.delete(system.box, axes[0])))
    height = float((at + radius).max() - (at - radius).min())
    return dumps.Bed(height, float(system.mass.sum()) / area)


def contacts_of_system(system: ParticleSystem) -> tuple[float, float, float]:
    """As :func:`dumps.contacts`, between the particles of a system; those with walls are left out."""
    periodic = np.array([side != "wall" for side in system.boundary])
    return dumps.contacts(system.positions, system.radius, system.box, periodic)
