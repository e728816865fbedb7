"""What moves, presses, shears or heats the grains in a script of LAMMPS or LIGGGHTS.

Formats: docs.lammps.org, pages fix_deform, fix_move, fix_wall_gran, region, change_box and fix_langevin; LIGGGHTS'
fix_move_mesh and fix_mesh_surface_stress_servo.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Final

from . import gravity, meshes
from .description import Bath, Direction, Motion, Note
from .formulas import NUMBER

if TYPE_CHECKING:
    from .state import Fix, State

#: A motion without oscillation, such as that of a belt or of a rotating drum.
STEADY: Final = Motion((0.0, 0.0, 0.0), 0.0)
UNKNOWN: Final = Motion()
AXES: Final = ("x", "y", "z")
TILTS: Final = ("xy", "xz", "yz")
#: Angle [°] from which grains may flow down a slope if no number is known; heaps of glass beads stand up to 20 or more.
STEEP: Final = 15.0
#: Styles of ``fix deform`` and ``change_box`` with their numbers of values.
STYLES: Final = {
    **{"final": 2, "delta": 2, "scale": 1, "vel": 1, "erate": 1, "trate": 1, "volume": 0, "wiggle": 2},
    **{"variable": 2, "pressure": 2, "pressure/mean": 2, "erate/rescale": 1},
}
TILT_STYLES: Final = {**STYLES, "final": 1, "delta": 1}
#: Boltzmann's constant of each system of units.
BOLTZMANN: Final = {
    "lj": 1.0,
    "si": 1.380649e-23,
    "cgs": 1.380649e-16,
    "micro": 1.380649e-8,
    "nano": 0.01380649,
}
#: q of the moment of inertia with which ``fix langevin`` turns grains, its rate for spins over that for velocities, and
#: the words that switch this on.
SPHERE, OF_SPINS, YES = 0.4, 10.0 / 3.0, ("yes", "on", "true")
WIGGLE: Final = re.compile(r"\s*[sc]wiggle\(([^,]*),([^,]*),([^,]*)\)\s*")
TIME: Final = re.compile(r"\btime\b")
STEPS: Final = re.compile(r"\b(?:step|elapsed)\b")
WAVE: Final = re.compile(r"\b(?:sin|cos)\(")
#: A reference to what the simulation computes, such as a force.
MEASURED: Final = re.compile(r"\b[cf]_\w+")

#: A number times a variable, a product of two differences of variables, and a place of a mesh that carries a stress.
TIMES_VARIABLE: Final = re.compile(r"([^v]+)\*(v_\w+)")
AREA: Final = re.compile(r"\((v_\w+)-(v_\w+)\)\*\((v_\w+)-(v_\w+)\)")
MESH_PLACE: Final = re.compile(r"f_(\w+)\[(\d+)\]")
MESH_AXES: Final = {"7": 0, "8": 1, "9": 2}

Driven = tuple[tuple[Note, ...], tuple[Note, ...], float | None, Bath | None]


def driven(state: State) -> Driven:
    """What presses the grains, what else drives them, the shear rate, and the thermostat that hold now."""
    pressed, others = list(state.squeezed), list[Note]()
    rates, baths = list[float](), list[Bath]()
    for fix in state.fixes.values():
        if fix.style.startswith("deform"):
            kind, rate = deformation(state, fix.words)
            changes = [" ".join([axis, style, *values]) for axis, style, values in deformed(fix.words)]
            note = Note(f"fix {fix.style} {' '.join(changes)}", None, fix.statement.quote)
            pressed += [note] * (kind == "pressed")
            others += [note] * (kind == "other")
            rates += [] if rate is None else [rate]
        elif fix.style == "lebc":
            rate = state.coefficient((*fix.words, "")[0])
            rates += [abs(rate)] if rate else []
            others += [Note("a shear of unknown rate (fix lebc)", None, fix.statement.quote)] * (rate is None)
        elif "servo" in fix.style and "torque" in fix.words:
            others.append(Note(f"a servo ({fix.style})", None, fix.statement.quote))
        elif "servo" in fix.style or (fix.style.startswith("wall/gran") and measured(state, fix.words)):
            pressed.append(Note(f"a servo ({fix.style})", None, fix.statement.quote))
        elif fix.style.startswith("wall/gran") and sheds(state, fix):
            others.append(Note("the fall down a mesh that is open below", None, fix.statement.quote))
        elif fix.style.startswith("langevin") and (thermostat := bath(state, fix)) is not None:
            baths.append(thermostat)
    if len(rates) + len(baths) > 1:
        others.append(Note("several drives"))
    return tuple(pressed), tuple(others), rates[0] if rates else None, baths[0] if baths else None


def pressure(state: State) -> float | None:
    """The pressure that barostats, walls under a force and ``fix deform`` prescribe: the mean of the stated axes.

    None without one, or if it is not known, not positive, or prescribed twice. Servos count by axis: two that face each
    other must agree.
    """
    stated = [values for fix in state.fixes.values() if (values := _pressures(state, fix))]
    servos = [_pressed_by_servo(state, *pair) for pair in state.fixes.items() if _is_servo(pair[1])]
    by_axis: dict[int, set[float | None]] = {}
    for axis, value in servos:
        by_axis.setdefault(axis, set()).add(value)
    if servos:
        stated.append([value for values in by_axis.values() for value in values])
        if -1 in by_axis or any(len(values) > 1 for values in by_axis.values()):
            return None
    if len(stated) != 1 or None in stated[0]:
        return None
    mean = math.fsum(value or 0.0 for value in stated[0]) / len(stated[0])
    return mean if mean > 0.0 and math.isfinite(mean) else None


def uniaxial(state: State) -> bool:
    """Whether servos press along one axis alone; walls or periodic sides then carry what they must."""
    servos = [_pressed_by_servo(state, *pair) for pair in state.fixes.items() if _is_servo(pair[1])]
    return len({axis for axis, _ in servos}) == 1


def _pressures(state: State, fix: Fix) -> list[float | None]:
    """The pressures at the end that ``fix deform`` or a barostat prescribes."""
    words = fix.words
    if fix.style.startswith("deform"):
        parts = [values[0] for _, style, values in deformed(words) if style.startswith("pressure") and values]
        return [state.coefficient(word) for word in parts]
    if not fix.style.startswith(("nph", "npt", "press/", "box/relax")):
        return []
    place = 1 if fix.style.startswith("box/relax") else 2
    ends = [
        words[k + place] for k, word in enumerate(words[:-place]) if word in ("iso", "aniso", "tri", *AXES)
    ]
    return [state.coefficient(word) for word in ends]


def _is_servo(fix: Fix) -> bool:
    """Whether a fix is a wall under a force."""
    return (
        fix.style.endswith("servo") and "force" in fix.words and {"axis", "target_val"} <= set(fix.words[:-1])
    )


def _pressed_by_servo(state: State, name: str, fix: Fix) -> tuple[int, float | None]:
    """The axis along which a servo presses, -1 if it is none, and its pressure.

    A force acts on the area of the mesh, if its file is there, within that of the box; one that a variable gives may be
    a pressure times an area between meshes.
    """
    words = fix.words
    last = max(
        k for k, word in enumerate(words) if word == "axis"
    )  # a mesh may be rotated about another before
    normal = [state.coefficient(word) for word in words[last + 1 :][:3]]
    along = [k for k, part in enumerate(normal) if part]
    if len(along) != 1 or None in normal or len(normal) < 3:
        return -1, None
    target = state.targets.get(name, words[words.index("target_val") + 1])
    across = [k for k in range(3) if k != along[0]]
    force = state.coefficient(target)
    if force is None:
        return along[0], _over_area(state, target, across)
    floor = math.prod(state.edges.get(AXES[k]) or math.inf for k in across)
    plate = _area_of_mesh(state, words, along[0])
    area = floor if plate is None else min(floor, plate)
    return along[0], abs(force) / area if 0.0 < area < math.inf else None


def _area_of_mesh(state: State, words: Sequence[str], along: int) -> float | None:
    """The area of a mesh as it is seen along an axis; None if its file cannot be read."""
    corners = corners_of_mesh(state, words)
    return None if corners is None else meshes.area_across(corners, along)


def corners_of_mesh(state: State, words: Sequence[str]) -> meshes.Triangles | None:
    """The corners of a mesh, scaled and turned but not moved; None if its file cannot be read."""
    name = words[words.index("file") + 1] if "file" in words[:-1] else ""
    corners = meshes.read(state.folder / name) if state.folder is not None and name else None
    scale = state.coefficient(words[words.index("scale") + 1]) if "scale" in words[:-1] else 1.0
    if corners is None or not scale:
        return None
    for at in [k for k, word in enumerate(words) if word == "rotate"]:
        numbers = [state.coefficient(word) for word in (*words[at + 2 : at + 5], *words[at + 6 : at + 7])]
        known = [number for number in numbers if number is not None]
        if len(known) < 4 or not any(known[:3]) or "angle" not in words[at + 5 : at + 6]:
            return None
        corners = meshes.rotated(corners, known[:3], known[3])
    return scale * corners


def _over_area(state: State, target: str, across: Sequence[int]) -> float | None:
    """The pressure p of a force ``p*v_area``, a product of distances of meshes or of edges of the box; else None."""
    match = TIMES_VARIABLE.fullmatch(_formula(state, target))
    area = "" if match is None else _formula(state, match[2])
    pressure = None if match is None else state.variables.number(match[1])
    if pressure is not None and area in (f"l{AXES[i]}*l{AXES[j]}" for i, j in (across, across[::-1])):
        return abs(pressure)
    sides = AREA.fullmatch(area)
    if sides is None or pressure is None:
        return None
    places = [MESH_PLACE.fullmatch(_formula(state, side)) for side in sides.groups()]
    axes = [None if place is None else MESH_AXES.get(place[2]) for place in places]
    meshes = {place[1] for place in places if place is not None}
    different = len(meshes) == 4 and all(name in state.fixes for name in meshes)
    same = axes[0] == axes[1] and axes[2] == axes[3] and {axes[0], axes[2]} == {*across}
    return abs(pressure) if different and same else None


def _formula(state: State, word: str) -> str:
    """The formula of a variable ``v_name`` of style ``equal``, without blanks; empty for other words."""
    variable = state.variables.known.get(word[2:]) if word.startswith("v_") else None
    if variable is None or variable.style != "equal":
        return ""
    return "".join(state.variables.substitute(variable.values[0]).split())


def measured(state: State, words: Sequence[str]) -> bool:
    """Whether a wall stands where a variable that depends on measured forces says."""
    known = state.variables.known
    moved = [word for part in words for region in state.parts_of(part).values() for word in region]
    names = [word[2:] for word in (*words, *moved) if word.startswith("v_")]
    return any(MEASURED.search(value) for name in names if name in known for value in known[name].values)


def bath(state: State, fix: Fix) -> Bath | None:
    """``fix langevin`` on all grains at a constant temperature, with the rate 2/damp; None for other ones.

    With ``omega yes`` it acts on spins, 10/3 times as fast, with the moment of inertia of spheres.
    """
    group, numbers = state.members(fix.group), [state.coefficient(word) for word in fix.words[:3]]
    if len(numbers) < 3 or None in numbers or not group.whole:
        return None
    start, stop, damp = (float(number) for number in numbers if number is not None)
    moving = {k for k in state.present() if not state.frozen(k)}
    every = group.types is None or group.types >= moving
    if not every or start != stop or not (start > 0.0 and damp > 0.0) or state.units not in BOLTZMANN:
        return None
    options = fix.words[4:]
    scales = [options[k + 1 : k + 3] for k, word in enumerate(options[:-2]) if word == "scale"]
    scaled = {kind: state.coefficient(by) for kind, by in scales}
    longer = {scaled.get(str(kind), 1.0) for kind in moving}
    times = longer.pop() if len(longer) == 1 and all(kind.isdecimal() for kind in scaled) else None
    if not times or times < 0.0:
        return None
    energy, rate = BOLTZMANN[state.units] * start, 2.0 / (damp * times)
    on = [value for word, value in pairwise(options) if word == "omega"]
    if not on or on[-1] not in YES:
        return Bath(energy, rate)
    factors = {state.inertia_factor(kind) for kind in moving}
    own = factors.pop() if len(factors) == 1 else SPHERE
    return Bath(energy, rate, energy, OF_SPINS * rate * SPHERE / own)


# --- the box ------------------------------------------------------------------------------------------------


def deformation(state: State, words: Sequence[str]) -> tuple[str, float | None]:
    """What ``fix deform`` does: "pressed", "other" or nothing, and the rate of a steady shear."""
    growth: dict[str, list[float | None]] = {}
    rates, kept, other = list[float | None](), False, False
    for axis, style, values in deformed(words):
        numbers = [state.coefficient(word) for word in values]
        if style.startswith("pressure"):
            return "pressed", None
        if axis in TILTS:
            rates.append(_rate(state, axis, style, numbers))
        elif style == "volume":
            kept = True
        elif style in ("wiggle", "variable"):
            other = True
        else:
            growth.setdefault(style, []).append(_growth(state, axis, style, numbers))
    changes = [change for axis in growth.values() for change in axis]
    if shrinks(growth) and not kept:
        return "pressed", None
    if other or None in rates or len(rates) > 1 or (changes and any(change != 0.0 for change in changes)):
        return "other", None
    return "", rates[0] if rates else None


def shrinks(growth: dict[str, list[float | None]]) -> bool:
    """Whether the volume falls: the sum of relative changes of one style, or any change if there are several."""
    known = [[change for change in each if change is not None] for each in growth.values()]
    if len(growth) == 1:
        return sum(known[0]) < -1e-9 * max(map(abs, known[0]), default=0.0)
    return any(change < 0.0 for each in known for change in each)


def deformed(words: Sequence[str]) -> Iterator[tuple[str, str, list[str]]]:
    """Each axis or tilt that changes, its style and its values, from ``x erate -1 xy wiggle 2 3``."""
    k = 0
    while k < len(words) - 1:
        table = STYLES if words[k] in AXES else TILT_STYLES if words[k] in TILTS else {}
        style = words[k + 1]
        if style in table:
            yield words[k], style, list(words[k + 2 : k + 2 + table[style]])
            k += 2 + table[style]
        else:
            k += 1


def _growth(state: State, axis: str, style: str, numbers: Sequence[float | None]) -> float | None:
    """A relative change of an edge, or its rate: its sign counts, and among those of one style its size."""
    known = [number for number in numbers if number is not None]
    edge = state.edges.get(axis)
    if not known or len(known) < len(numbers):
        return None
    if style == "scale":
        return math.log(known[0]) if known[0] > 0.0 else None
    if style in ("erate", "trate", "erate/rescale"):
        return known[0]
    change = known[0] if style == "vel" else known[1] - known[0]
    if style == "final":
        return None if edge is None or change <= 0.0 else math.log(change / edge)
    return change if edge is None else change / edge


def _rate(state: State, axis: str, style: str, numbers: Sequence[float | None]) -> float | None:
    """The rate of a steady shear; None if it is not one, or not known."""
    edge = state.edges.get(axis[1])
    if len(numbers) != 1 or numbers[0] is None or style not in ("erate", "erate/rescale", "vel"):
        return None
    if style == "vel":
        return None if edge is None else abs(numbers[0]) / edge or None
    return abs(numbers[0]) or None


# --- walls and grains -----------------------------------------------------------------------------------------


def of_wall(state: State, rest: Sequence[str], ends: int, rubs: bool) -> Motion | None:
    """The motion of a wall from its shape on, with so many words for its place; None if it stands still.

    A plane without friction that slides along itself counts as one that stands still.
    """
    options = list(rest[1 + ends :])
    if "wiggle" in options:
        axis, amplitude, period = (*options[options.index("wiggle") + 1 :], "", "", "")[:3]
        return oscillation(state, [amplitude if axis == name else "0" for name in AXES], period)
    regions = state.parts_of(rest[1]).values() if rest[0] == "region" and len(rest) > 1 else ()
    for words in regions:
        if "move" in words:
            at = words.index("move")
            return by_variables(state, words[at + 1 : at + 4])
    places = [word for word in rest[1 : 1 + ends] if word.startswith("v_")]
    if any(state.coefficient(word) is None for word in places):
        axis = rest[0][:1]
        return by_variables(state, [places[0] if name == axis else "NULL" for name in AXES])
    if "shear" in options and rubs:
        return steady(state, options[options.index("shear") + 2 :][:1])
    turning = [words for words in regions if "rotate" in words]
    return _drum(state, turning[0]) if rubs and turning else None


def _drum(state: State, words: Sequence[str]) -> Motion:
    """The motion of a region with ``rotate v_angle Px Py Pz Rx Ry Rz``, and the radius around a cylinder's axis."""
    at = words.index("rotate") + 1
    angle = state.variables.known.get(words[at][2:]) if at < len(words) else None
    numbers = [state.coefficient(word) for word in words[at + 1 : at + 7]]
    known = [number for number in numbers if number is not None]
    if angle is None or angle.style != "equal" or len(known) < 6:
        return STEADY
    formula = _in_time(state, state.variables.substitute(angle.values[0]))
    angles = [state.variables.number(TIME.sub(f"({time})", formula)) for time in (0.0, 1.0, 2.0)]
    size, values = math.hypot(*known[3:]), [value for value in angles if value is not None]
    if len(values) < 3 or not size or not math.isclose(values[2] - values[1], values[1] - values[0]):
        return STEADY
    vector = tuple((values[1] - values[0]) * part / size for part in known[3:])
    motion = replace(STEADY, turning=vector)
    if words[0] != "cylinder" or words[1] not in AXES or "out" in words:
        return motion
    axis = AXES.index(words[1])
    centre, along = [state.coefficient(word) for word in words[2:4]], abs(known[3 + axis]) == size
    same = along and centre == [value for k, value in enumerate(known[:3]) if k != axis]
    return replace(motion, radius=state.coefficient(words[4])) if same else motion


def steady(state: State, words: Sequence[str]) -> Motion:
    """A steady motion with the components of its velocity, which need not be known."""
    parts = [0.0 if word == "NULL" else state.coefficient(word) for word in words]
    known = [part for part in parts if part is not None]
    if not known or len(known) < len(parts):
        return STEADY
    return replace(STEADY, velocity=math.hypot(*known), course=tuple(known) if len(known) == 3 else None)


def by_variables(state: State, words: Sequence[str]) -> Motion | None:
    """The motion of what variables displace along each axis; an oscillation if they are one sine or cosine of time."""
    parts = dict[str, tuple[str, str]]()
    for axis, word in zip(AXES, words, strict=False):
        if not word.startswith("v_") or state.coefficient(word) is not None:
            continue
        variable = state.variables.known.get(word[2:])
        if variable is None or variable.style != "equal":
            return UNKNOWN
        formula = state.variables.substitute(variable.values[0])
        if match := WIGGLE.fullmatch(formula):
            parts[axis] = str(state.variables.number(match[2])), str(state.variables.number(match[3]))
        elif part := _wave(state, formula):
            parts[axis] = part
        else:
            return UNKNOWN
    periods = {period for _, period in parts.values()}
    if not parts:
        return None
    if len(periods) > 1:
        return UNKNOWN
    return oscillation(state, [parts.get(axis, ("0", ""))[0] for axis in AXES], periods.pop())


def _in_time(state: State, formula: str) -> str:
    """A formula of steps as one of time."""
    return STEPS.sub(f"(time/{state.step_now()!r})", formula)


def _wave(state: State, formula: str) -> tuple[str, str] | None:
    """Amplitude and period of c + A sin(ω t + φ), written with one sine or cosine of ``time``, or of steps."""
    in_time = _in_time(state, formula)
    waves = list(WAVE.finditer(in_time))
    if len(waves) != 1 or not TIME.search(in_time):
        return None
    start = waves[0].end()
    depths = accumulate((letter == "(") - (letter == ")") for letter in in_time[start:])
    length = next((k for k, depth in enumerate(depths) if depth < 0), None)

    def at(text: str, time: float) -> float:
        value = state.variables.number(TIME.sub(f"({time!r})", text))
        return math.nan if value is None else value

    phases = [at(in_time[start:][:length], time) for time in (0.0, 1.0, 2.0)]
    omega = abs(phases[1] - phases[0])
    if not (omega > 0.0 and math.isclose(abs(phases[2] - phases[0]), 2.0 * omega, rel_tol=1e-9)):
        return None
    quarter = 0.5 * math.pi / omega
    first, second, third, fourth, fifth = (at(in_time, k * quarter) for k in range(5))
    size = 0.5 * math.hypot(first - third, second - fourth)
    close = {"rel_tol": 1e-9, "abs_tol": 1e-9 * size}
    middle, between = 0.5 * (first + third), at(in_time, 0.5 * quarter)
    wave = middle + math.sqrt(0.5) * (first - middle + second - middle)
    same = ((fifth, first), (second + fourth, first + third), (between, wave))
    return (str(size), str(4.0 * quarter)) if all(math.isclose(a, b, **close) for a, b in same) else None


def oscillation(state: State, amplitudes: Sequence[str], period: str) -> Motion:
    """The motion of what oscillates with these amplitudes; its numbers may be unknown."""
    sizes = [0.0 if word == "NULL" else state.coefficient(word) for word in amplitudes]
    time = state.coefficient(period)
    known = [size for size in sizes if size is not None]
    if len(known) < 3 or not time or not math.isfinite(time):
        return UNKNOWN
    return Motion(tuple(known), 2.0 * math.pi / abs(time))


def of_grains(state: State, kind: int) -> Motion | None:
    """The motion of grains that ``fix move`` displaces."""
    for fix in state.fixes.values():
        if fix.style == "move" and kind in state.within(state.members(fix.group)):
            style, *words = (*fix.words, "")
            if style == "wiggle":
                return oscillation(state, words[:3], (*words[3:], "")[0])
            if style == "linear":
                return steady(state, words[:3])
            return (by_variables(state, words[:3]) or UNKNOWN) if style == "variable" else STEADY
    return None


def of_mesh(state: State, name: str) -> Motion | None:
    """The motion of a mesh of LIGGGHTS, the fastest if there are several."""
    motions = [
        _of_mesh(state, fix.words)
        for fix in state.fixes.values()
        if fix.style.startswith("move/mesh") and "mesh" in fix.words[:-1]
        if fix.words[fix.words.index("mesh") + 1] == name
    ]
    return strongest(motions, gravity.down(state))


def sheds(state: State, wall: Fix) -> bool:
    """Whether a wall of LIGGGHTS is the only one and a mesh off which grains slide wherever they land."""
    walls = [fix for fix in state.fixes.values() if fix.style.startswith("wall/gran")]
    names = wall.words[wall.words.index("meshes") + 1 :] if "meshes" in wall.words else ()
    count = wall.words[wall.words.index("n_meshes") + 1] if "n_meshes" in wall.words[:-1] else ""
    down, mesh = gravity.down(state), state.fixes.get((*names, "")[0])
    if len(walls) > 1 or count != "1" or down is None or mesh is None:
        return False
    if of_mesh(state, names[0]) is not None or of_surface(state, names[0]) is not None:
        return False
    corners = corners_of_mesh(state, mesh.words)
    return corners is not None and meshes.sheds(corners, down, STEEP)


def of_surface(state: State, name: str) -> Motion | None:
    """The motion of the surface of a mesh of LIGGGHTS that itself stands still, as that of a conveyor belt."""
    words = state.fixes[name].words if name in state.fixes else ()
    if "surface_vel" in words:
        at = words.index("surface_vel") + 1
        motion = replace(steady(state, words[at : at + 3]), course=None)
        return None if motion.velocity == 0.0 else motion
    return STEADY if "surface_ang_vel" in words else None


def strongest(motions: Sequence[Motion | None], down: Direction | None = None) -> Motion | None:
    """An unknown motion, or that of the greatest acceleration along gravity, then along any direction; of steady ones
    that which sinks fastest."""

    def order(motion: Motion) -> tuple[float, float, float]:
        return acceleration(motion, down), acceleration(motion), sinking(motion, down)

    return max((motion for motion in motions if motion is not None), key=order, default=None)


def sinking(motion: Motion, down: Direction | None) -> float:
    """The component of a steady motion along gravity; 0 if it is not known."""
    return sum(v * g for v, g in zip(motion.course or (), down or (), strict=False))


def acceleration(motion: Motion, down: Direction | None = None) -> float:
    """Greatest acceleration A ω² of an oscillation, along a direction if it is given; infinite if it is not known."""
    if motion.amplitude is None or motion.frequency is None:
        return math.inf
    if down is None:
        size = math.hypot(*motion.amplitude)
    else:
        size = abs(sum(a * b for a, b in zip(motion.amplitude, down, strict=True)))
    return size * motion.frequency**2


def _of_mesh(state: State, words: Sequence[str]) -> Motion:
    """The words of ``fix move/mesh``."""

    def after(name: str, count: int) -> list[str]:
        at = words.index(name) + 1 if name in words else len(words)
        return [*words[at : at + count], *[""] * count][:count]

    if "wiggle" in words:
        return oscillation(state, after("amplitude", 3), after("period", 1)[0])
    if "viblin" in words:
        order = after("order", 1)[0]
        count = int(order) if order.isdecimal() and len(order) < 3 else 0
        axis = [state.coefficient(word) for word in after("axis", 3)]
        size = math.hypot(*(x or 0.0 for x in axis))
        parts = list(zip(after("amplitude", count), after("period", count), strict=True))
        if None in axis or not size or not parts:
            return UNKNOWN
        waves = [
            oscillation(state, [repr(float(amount) * (a or 0.0) / size) for a in axis], period)
            for amount, period in parts
            if NUMBER.fullmatch(amount)
        ]
        return strongest(waves) or UNKNOWN
    if "linear" in words:
        return steady(state, [word for word in after("linear", 3) if word])
    if "rotate" in words:
        axis = [state.coefficient(word) for word in after("axis", 3)]
        period, known = state.coefficient(after("period", 1)[0]), [part for part in axis if part is not None]
        if period and len(known) == 3 and any(known):
            rate = 2.0 * math.pi / period / math.hypot(*known)
            return replace(STEADY, turning=tuple(rate * part for part in known))
    return STEADY if {"rotate", "rotate/variable"} & set(words) else UNKNOWN
