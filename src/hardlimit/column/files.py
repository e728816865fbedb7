"""Read and write columns as TOML files, and change their parameters by name, for the command line.

A file has the top-level keys ``height``, ``gravity``, ``gaps`` and ``velocities``, one table ``[[balls]]`` per ball,
bottom first (``radius``, and ``density`` or ``mass``), and one ``[law]`` (``name`` and its parameters) or one
``[[laws]]`` per contact, the floor's first. With ``cradle = true`` there is no floor, no height and no gravity (a
``gravity`` of 0 may be written). A quantity is a number in SI units or a text with a unit, such as ``"1 mm"``.

All functions raise a ValueError with a one-line message for invalid input; :func:`read` names the file.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeVar

from ..contact.balls import Ball
from ..contact.contact import Law, law_parameters
from ..contact.laws import LAWS
from ..support import saving, toml, validation
from .scenario import STANDARD_GRAVITY, Column

T = TypeVar("T")


@dataclass(frozen=True)
class Scenario:
    """The parameters of a column, which may be changed one by one before they are checked together."""

    balls: tuple[Ball, ...]
    gaps: tuple[float, ...]
    laws: tuple[Law, ...]
    height: float
    velocities: tuple[float, ...]
    gravity: float
    cradle: bool = False

    def column(self) -> Column:
        """The column."""
        law: Law | Sequence[Law] = self.laws[0] if len(set(self.laws)) == 1 else self.laws
        gaps = _repeated(self.gaps, len(self.balls) - 1)
        velocities = _repeated(self.velocities, len(self.balls))
        if self.cradle:
            return Column.cradle(self.balls, velocities, law, gaps)
        return Column(self.balls, gaps, self.height, law, velocities, self.gravity)


def _repeated(values: tuple[float, ...], count: int) -> list[float]:
    """A single value ``count`` times, several values as they are."""
    return list(values) * count if len(values) == 1 else list(values)


def of_column(column: Column) -> Scenario:
    """The parameters of a column."""
    c = column
    return Scenario(
        balls=c.balls,
        gaps=c.gaps,
        laws=c.laws,
        height=c.height,
        velocities=c.velocities,
        gravity=c.gravity,
        cradle=not c.floor,
    )


# --- TOML ---------------------------------------------------------------------------------------------------


def read(path: str | Path) -> Column:
    """The column that a TOML file describes."""
    return prefixed(f"{path}: ", read_with(path)[0].column)


def read_with(path: str | Path, *other: str) -> tuple[Scenario, dict[str, Any]]:
    """The scenario in a TOML file, and the entries named in ``other``, unchecked."""
    content = toml.read(path)
    extra = {name: content.pop(name) for name in other if name in content}
    return prefixed(f"{path}: ", lambda: from_mapping(content)), extra


def loads(text: str) -> Column:
    """The column described by a text in TOML; the inverse of :func:`dumps`."""
    return from_mapping(toml.parse(text)).column()


def dumps(column: Column) -> str:
    """The column as a text in TOML, every number to the last digit."""
    lines = ["# A column for `hardlimit drop`; lengths in m, masses in kg, times in s.", ""]
    if column.floor:
        lines += [f"height = {column.height!r}", f"gravity = {column.gravity!r}"]
    else:
        lines.append("cradle = true")
    lines.append(f"gaps = {list(column.gaps)!r}")
    if not column.floor or any(column.velocities):
        lines.append(f"velocities = {list(column.velocities)!r}")
    for ball in column.balls:
        mass = f"{ball.given} = {getattr(ball, ball.given)!r}"
        lines += ["", "[[balls]]", f"radius = {ball.radius!r}", mass]
    laws = column.laws[:1] if len(set(column.laws)) == 1 else column.laws
    for law in laws:
        lines += ["", "[law]" if len(laws) == 1 else "[[laws]]", f'name = "{law.record["name"]}"']
        lines += [f"{name} = {value!r}" for name, value in law.parameters.items()]
    return "\n".join([*lines, ""])


def write(column: Column, path: str | Path) -> Path:
    """Write the column as a TOML file."""
    return saving.write(path, dumps(column).encode())


def from_mapping(content: Mapping[str, Any]) -> Scenario:
    """The scenario in a mapping with the keys of the TOML file."""
    scenario = toml.table("", content, COLUMN)
    if not scenario.get("balls"):
        raise ValueError("balls: missing, must be one table [[balls]] for each ball")
    n = len(scenario["balls"])
    cradle = scenario.get("cradle", False)
    if cradle:
        for name in ("height", "gravity"):
            if name in scenario and (name, scenario[name]) != ("gravity", 0.0):
                other = "0 or " if name == "gravity" else ""
                raise ValueError(f"{name}: got {scenario[name]!r}, must be {other}left out for a cradle")
    elif "height" not in scenario:
        raise ValueError("height: missing, must be the height [m] of the lowest centre at release")
    elif "gaps" not in scenario and n > 1:
        raise ValueError(f"gaps: missing, must be a list of {n - 1}")
    laws = [scenario["law"]] if "law" in scenario else scenario.get("laws")
    if not laws or ("law" in scenario and "laws" in scenario):
        count = "both" if laws else "neither"
        raise ValueError(f"law | laws: got {count}, must be one [law], or one [[laws]] for each contact")
    gaps, gravity = scenario.get("gaps", 0.0), scenario.get("gravity", STANDARD_GRAVITY)
    return Scenario(
        balls=tuple(scenario["balls"]),
        gaps=validation.numbers("gaps", gaps, n - 1, lowest=0.0, lowest_allowed=True),
        laws=tuple(laws),
        height=0.0 if cradle else validation.number("height", scenario["height"]),
        velocities=validation.numbers("velocities", scenario.get("velocities", 0.0), n),
        gravity=validation.number("gravity", gravity, 0.0, lowest_allowed=True),
        cradle=cradle,
    )


def _ball(name: str, content: Any) -> Ball:
    """Check the table of a ball."""
    kinds = {"radius": toml.quantity("m"), "density": toml.quantity("kg/m3"), "mass": toml.quantity("kg")}
    values = toml.table(name, content, kinds)
    if "radius" not in values:
        raise ValueError(f"{name}.radius: missing, must be given")
    return prefixed(f"{name}.", lambda: Ball(**values))


def law_table(name: str, content: Any) -> Law:
    """Check the table of a law."""
    kind = None
    if isinstance(content, dict):
        if "name" not in content:
            raise ValueError(f"{name}.name: missing, must be one of {', '.join(LAWS)}")
        kind = law_class(content["name"], f"{name}.name")
    records = {} if kind is None else law_parameters(kind)
    kinds = {"name": toml.text} | {key: toml.quantity(record["unit"]) for key, record in records.items()}
    values = toml.table(name, content, kinds)
    return prefixed(f"{name}.", lambda: LAWS[values.pop("name")](**values))


#: The keys of a file of a column.
COLUMN: Final[Mapping[str, toml.Kind]] = {
    "balls": toml.list_of(_ball),
    "cradle": validation.flag,
    "height": toml.quantity("m"),
    "gravity": toml.quantity("m/s2"),
    "gaps": toml.one_or_list_of(toml.quantity("m")),
    "velocities": toml.one_or_list_of(toml.quantity("m/s")),
    "law": law_table,
    "laws": toml.list_of(law_table),
}


def law_class(name: Any, parameter: str = "law") -> type[Law]:
    """The law with a name such as ``linear``."""
    return LAWS[validation.one_of(parameter, name, list(LAWS))]


def prefixed(where: str, make: Callable[[], T]) -> T:
    """``make()``; if it raises a ValueError, ``where`` is put before the message."""
    try:
        return make()
    except ValueError as error:
        raise ValueError(f"{where}{error}") from None


# --- changes ------------------------------------------------------------------------------------------------


def changed_law(present: Law | None, name: str | None, parameters: Mapping[str, float]) -> Law:
    """The present law with other parameters, or another law: the one named, or the first that has the parameters."""
    kind = None if present is None else type(present)
    wanted = law_class(name) if name is not None else _law_with(kind, parameters)
    if present is not None and wanted is kind:
        return present.replace(**parameters)
    return wanted(**parameters)


def _law_with(present: type[Law] | None, names: Collection[str]) -> type[Law]:
    """The first law that has parameters of these names, beginning with the present one."""
    laws = [law for law in (present, *LAWS.values()) if law is not None]
    for law in laws:
        if set(names) <= law_parameters(law).keys():
            return law
    known = law_parameters(laws[0])
    unknown = next(name for name in names if name not in known)
    law = laws[0].record["name"]
    raise ValueError(f"{unknown}: unknown for the law {law}, must be one of {', '.join(known)}")


def with_law(scenario: Scenario, name: str | None, parameters: Mapping[str, float]) -> Scenario:
    """Another law, or other parameters of the present laws; see :func:`changed_law`."""
    first = scenario.laws[0]
    changed = changed_law(first, name, parameters)
    if type(changed) is not type(first):
        return replace(scenario, laws=(changed,))
    return replace(scenario, laws=tuple(law.replace(**parameters) for law in scenario.laws))


def with_balls(
    scenario: Scenario,
    *,
    radii: Sequence[float] = (),
    radius_1: float | None = None,
    radius_2: float | None = None,
    radius_ratio: float | None = None,
    densities: Sequence[float] = (),
    masses: Sequence[float] = (),
) -> Scenario:
    """Other radii, densities or masses; one density is that of all balls.

    ``radii`` replaces all radii and may change the number of balls. ``radius_ratio`` R1/R2 changes the lowest radius.
    """
    single = any(value is not None for value in (radius_1, radius_2, radius_ratio))
    for names, both in (
        ("density | mass", densities and masses),
        ("radius_ratio | radius_1", radius_1 is not None and radius_ratio is not None),
        ("radius | radius_1, radius_2, radius_ratio", radii and single),
    ):
        if both:
            raise ValueError(f"{names}: got both, must be at most one of them")
    sizes = [validation.number(f"radius[{i}]", r, 0.0) for i, r in enumerate(radii)]
    sizes = sizes or [ball.radius for ball in scenario.balls]
    for name, value in (("radius_2", radius_2), ("radius_ratio", radius_ratio)):
        if value is not None and len(sizes) < 2:
            raise ValueError(f"{name}: got {value:.16g}, must be left out for a column of one ball")
    if radius_1 is not None:
        sizes[0] = validation.number("radius_1", radius_1, 0.0)
    if radius_2 is not None:
        sizes[1] = validation.number("radius_2", radius_2, 0.0)
    if radius_ratio is not None:
        ratio = validation.number("radius_ratio", radius_ratio, 0.0)
        sizes[0] = validation.number("radius_ratio × radius_2", ratio * sizes[1], 0.0)
    return replace(scenario, balls=tuple(_made_of(scenario.balls, sizes, densities, masses)))


def _made_of(
    balls: tuple[Ball, ...], sizes: list[float], densities: Sequence[float], masses: Sequence[float]
) -> list[Ball]:
    """Balls of these radii with the densities or masses given, or with the densities of the present balls."""
    if densities:
        values = densities[0] if len(densities) == 1 else densities
        rho = validation.numbers("density", values, len(sizes), lowest=0.0)
        return [Ball(r, density=d) for r, d in zip(sizes, rho, strict=True)]
    if masses:
        m = validation.numbers("mass", masses, len(sizes), lowest=0.0)
        return [Ball(r, mass=value) for r, value in zip(sizes, m, strict=True)]
    if len(sizes) == len(balls):
        return [ball.resized(r) for ball, r in zip(balls, sizes, strict=True)]
    if len({ball.density for ball in balls}) > 1:
        raise ValueError(f"density: missing, must be one or {len(sizes)} when the number of balls changes")
    return [Ball(r, density=balls[0].density) for r in sizes]


def with_motion(
    scenario: Scenario,
    *,
    gaps: Sequence[float] = (),
    velocities: Sequence[float] = (),
    height: float | None = None,
    gravity: float | None = None,
) -> Scenario:
    """Other gaps, velocities at release, height or gravity; one gap or velocity is that of all balls."""
    for name, value in (("height", height), ("gravity", gravity)):
        if scenario.cradle and value is not None:
            raise ValueError(f"{name}: got {value:.16g}, must be left out for a cradle")
    n = len(scenario.balls)
    if gaps and n == 1:
        raise ValueError(f"gap: got {gaps[0]:.16g}, must be left out for a column of one ball")
    return replace(
        scenario,
        gaps=_fitting("gap", gaps, scenario.gaps, n - 1),
        velocities=_fitting("velocity", velocities, scenario.velocities, n),
        height=scenario.height if height is None else height,
        gravity=scenario.gravity if gravity is None else gravity,
    )


def _fitting(name: str, values: Sequence[float], present: tuple[float, ...], count: int) -> tuple[float, ...]:
    """The given values, or the present ones, which are repeated for more balls if they are equal."""
    if values:
        limits = {"lowest": 0.0, "lowest_allowed": True} if name == "gap" else {}
        return validation.numbers(name, values[0] if len(values) == 1 else values, count, **limits)
    if len(present) != count and len(set(present)) == 1:
        return present[:1] * count
    return present
