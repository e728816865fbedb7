"""From what a file has to the arguments of a system: its units, what it lacks, and walls around its grains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ...support import validation
from ...support.formatting import listed
from ...support.units import SYSTEMS
from .. import spins
from ..box import AXES, LENGTHS, Box, Vector, checked_boundary, checked_gravity
from .frame import Floats, Found, boundary_of, wraps_of

#: Units of mass, length and time [SI] by their names in LAMMPS; numbers in lj stay as they are.
UNITS: Final = {"lj": (1.0, 1.0, 1.0), **SYSTEMS}
#: Exponents of mass, length and time of each argument.
DIMENSIONS: Final = {
    **dict.fromkeys(("positions", "unfolded", "radius", "box", "shear_displacement"), (0, 1, 0)),
    **{"velocities": (0, 1, -1), "gravity": (0, 1, -2), "mass": (1, 0, 0), "density": (1, -3, 0)},
    **dict.fromkeys(("angular_velocities", "shear_rate"), (0, 0, -1)),
    **{"angular_momenta": (1, 2, -1)},
}
#: Largest overlap over the radius that counts as rounding of a file.
COARSEST: Final = 1e-2

#: A shear rate differs from the slope of the velocities by more than this many standard errors and by more than half.
SIGMAS: Final = 5.0
LEAST_FOR_A_SLOPE: Final = 10

#: One number for all particles, one for each, or one for each type.
OfTypes = float | ArrayLike | Mapping[Any, float]


@dataclass(frozen=True)
class Options:
    """Arguments of :meth:`ParticleSystem.read`."""

    units: str | None = None
    velocities: ArrayLike | None = None
    radius: OfTypes | None = None
    density: OfTypes | None = None
    boundary: str | Sequence[str] | None = None
    gravity: Vector | None = None
    shear_rate: float | None = None
    inertia_factor: float | ArrayLike | None = None


def completed(content: Found, options: Options) -> tuple[dict[str, Any], float]:
    """The arguments of a system in SI units, and the rounding error of distances over the smallest radius."""
    scale = _units(content.units, options.units)
    arguments = {name: _in_si(name, value, scale) for name, value in content.arguments.items()}
    n, d = arguments["positions"].shape
    if options.velocities is not None and validation.is_number(options.velocities):
        options = replace(options, velocities=np.full((n, d), options.velocities, float))
    for name, other in (("velocities", ""), ("radius", ""), ("density", "mass")):
        _fill(arguments, name, other, getattr(options, name), content.types)
    _turn(arguments, options.inertia_factor, n, d)
    sides = None if options.boundary is None else checked_boundary(options.boundary, d)
    _bound(arguments, content, sides, options.shear_rate, scale)
    if options.gravity is not None:
        arguments["gravity"] = checked_gravity(options.gravity, d)
    radius = validation.each("radius", arguments["radius"], n, **LENGTHS)
    if not content.is_folded:
        _fold(arguments)
    if content.tilt is not None:
        _check_flow(arguments)
    if sides is not None:
        _surround(arguments, sides, radius)
    error = content.rounding * float(scale[1])
    return arguments, min(2.0 * error / float(radius.min()), COARSEST)


def _units(named: str | None, wanted: Any) -> tuple[Decimal, ...]:
    """Units of mass, length and time in SI."""
    for name in (named, wanted):
        if name is not None and name not in UNITS:
            raise ValueError(f"units: got {validation.shown(name)}, must be {listed([*UNITS], 'or')}")
    if named is not None and wanted not in (None, named):
        raise ValueError(
            f"units: got {validation.shown(wanted)}, must be left out: the file is in {named} units"
        )
    return tuple(Decimal(repr(factor)) for factor in UNITS[named or wanted or "si"])


def _in_si(name: str, value: Any, scale: Sequence[Decimal]) -> Any:
    """Numbers times a power of ten, rounded once."""
    unit = Decimal(1)
    for factor, exponent in zip(scale, DIMENSIONS.get(name, (0, 0, 0)), strict=True):
        unit *= factor**exponent
    if unit == 1:
        return value
    return value / float(1 / unit) if unit < 1 else value * float(unit)


def _fill(arguments: dict[str, Any], name: str, other: str, value: Any, types: list[str] | None) -> None:
    """Put a value into the arguments that lack it; ``other`` makes it needless."""
    present = name in arguments or other in arguments
    if value is None and not present:
        raise ValueError(f"{name}: missing in the file; {name}= gives it")
    if value is None:
        return
    if present:
        has = name if name in arguments else other
        raise ValueError(
            f"{name}: got {validation.shown(value)}, must be left out: the file has a {has} for each particle"
        )
    if isinstance(value, Mapping):
        of_type = {str(kind): validation.number(f"{name}[{kind!r}]", x, 0.0) for kind, x in value.items()}
        missing = [kind for kind in dict.fromkeys(types or [""]) if kind not in of_type]
        if missing:
            raise ValueError(
                f"{name}: got no value for type {missing[0] or 'of the particles'}, must have one for each"
            )
        arguments[name] = np.array([of_type[kind] for kind in types or []])
        return
    arguments[name] = value


def _turn(arguments: dict[str, Any], factor: Any, n: int, d: int) -> None:
    """Moments of inertia, and angular velocities from angular momenta."""
    if factor is not None and "inertia_factor" in arguments:
        raise ValueError(f"inertia_factor: got {validation.shown(factor)}, must be left out: the file has it")
    if factor is not None:
        arguments["inertia_factor"] = factor
    momenta = arguments.pop("angular_momenta", None)
    if momenta is None:
        return
    q = spins.checked_factor(arguments.get("inertia_factor"), n, d)
    radius = validation.each("radius", arguments["radius"], n, **LENGTHS)
    mass = arguments.get("mass")
    if mass is None:
        mass = 4.0 / 3.0 * np.pi * radius**3 * validation.each("density", arguments["density"], n, lowest=0.0)
    inertia = q * validation.each("mass", mass, n, lowest=0.0) * radius**2
    arguments["angular_velocities"] = momenta / (inertia if d == 2 else inertia[:, None])


def _bound(
    arguments: dict[str, Any],
    content: Found,
    wanted: tuple[str, ...] | None,
    rate: Any,
    scale: Sequence[Decimal],
) -> None:
    """The boundary of the file: periodic sides and walls, or that of Lees and Edwards for a box that tilts."""
    d = arguments["positions"].shape[1]
    if content.sides is not None:
        for name, side, want in zip(AXES, content.sides, wanted or (None,) * d, strict=False):
            if side.strip("pf") and want != "wall":
                raise ValueError(
                    f"boundary: got the sides {side} along {name}, where the box shrinks to its particles, must be pp "
                    "or ff; boundary= puts walls around them"
                )
        arguments |= boundary_of(wraps_of(content.sides))
    if content.tilt is None:
        if rate is not None:
            raise ValueError(
                f"shear_rate: got {validation.shown(rate)}, must be left out: the box does not tilt"
            )
        return
    if rate is None:
        raise ValueError("shear_rate: missing for a box that tilts; shear_rate= gives it, 0 if it is at rest")
    xy, xz, yz = (float(tilt) * float(scale[1]) for tilt in content.tilt)
    axis = 2 if xz else 1
    wraps = [side != "wall" for side in arguments.get("boundary", ("periodic",) * d)]
    if (xy and xz) or yz or not (wraps[0] and wraps[axis]):
        raise ValueError(
            f"box: got tilts xy, xz, yz of {xy:g}, {xz:g}, {yz:g} m, must be xy or xz alone, along periodic axes: a "
            "flow along x"
        )
    edge = float(arguments["box"][0])
    arguments |= boundary_of(wraps, (axis, validation.number("shear_rate", rate), (xy or xz) % edge))


def _fold(arguments: dict[str, Any]) -> None:
    """Put positions into the box through its periodic sides."""
    d = arguments["positions"].shape[1]
    box = Box(
        np.asarray(arguments["box"], float),
        arguments.get("boundary", ("periodic",) * d),
        np.zeros(d),
        shear_rate=arguments.get("shear_rate", 0.0),
        shear_displacement=arguments.get("shear_displacement", 0.0),
    )
    outside = {name: arguments[name].copy() for name in ("positions", "velocities")}
    walls = [side == "wall" for side in box.boundary]
    box.fold(outside["positions"], outside["velocities"])
    outside["positions"][:, walls] = arguments["positions"][:, walls]
    arguments |= outside


def _check_flow(arguments: dict[str, Any]) -> None:
    """Refuse velocities without the flow of a sheared box, such as those of ``fix deform … remap x``.

    The slope of v_x over the gradient is judged by its standard error.
    """
    rate, axis = arguments["shear_rate"], arguments["boundary"].index("lees-edwards")
    y, v = arguments["positions"][:, axis], arguments["velocities"][:, 0]
    y, v = y - y.mean(), v - v.mean()
    square = float(y @ y)
    if len(y) < LEAST_FOR_A_SLOPE or square == 0.0:
        return
    slope = float(y @ v) / square
    error = float(np.sqrt(np.sum((v - slope * y) ** 2) / (len(y) - 2) / square))
    if abs(slope - rate) > max(SIGMAS * error, 0.5 * abs(rate)):
        raise ValueError(
            f"shear_rate: got {rate:.16g}, must be near the slope of the velocities in the laboratory, "
            f"{slope:.4g} ± {error:.1g} 1/s"
        )


def _surround(arguments: dict[str, Any], sides: tuple[str, ...], radius: Floats) -> None:
    """Put another boundary around particles. Walls stand at the sides of the box, or farther out, where the outermost
    particles end."""
    positions, box = arguments["positions"].copy(), np.array(arguments["box"], float)
    for k, side in enumerate(sides):
        if side == "wall":
            low = min(0.0, float((positions[:, k] - radius).min()))
            high = max(float(box[k]), float((positions[:, k] + radius).max()))
            positions[:, k] -= low
            box[k] = high - low
    if "lees-edwards" not in sides:
        arguments.pop("shear_rate", None), arguments.pop("shear_displacement", None)
    arguments |= {"positions": positions, "box": box, "boundary": sides}
