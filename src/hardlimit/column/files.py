"""A column as a TOML file, and a column changed by named parameters: what the command line reads and writes.

The file has the top-level keys ``height`` and ``gravity``, ``gaps``, ``velocities``, one ``[[balls]]`` table
for each ball, bottom first (``radius``, and ``density`` or ``mass``), and one ``[law]`` (``name`` and its
parameters) or one ``[[laws]]`` for each contact, the floor's first. ``cradle = true`` leaves out floor,
height and gravity (which may stand there as 0). A quantity is a number in SI units or a text with its unit,
such as ``"1 mm"``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..contact.balls import Ball
from ..contact.contact import Law, law_parameters
from ..contact.laws import LAWS
from ..support import saving, toml, units, validation
from .scenario import STANDARD_GRAVITY, Column

if TYPE_CHECKING:
    from msgspec import Struct

T = TypeVar("T")


@dataclass(frozen=True)
class Scenario:
    """The parameters of a column before they are checked together, so that they can be changed one by one."""

    balls: tuple[Ball, ...]
    gaps: tuple[float, ...]
    laws: tuple[Law, ...]
    height: float
    velocities: tuple[float, ...]
    gravity: float
    cradle: bool = False

    def column(self) -> Column:
        """The column, checked.

        Raises
        ------
        ValueError
            If the parameters do not make a column.
        """
        law: Law | Sequence[Law] = self.laws[0] if len(set(self.laws)) == 1 else self.laws
        gaps = _one_for_all(self.gaps, len(self.balls) - 1)
        velocities = _one_for_all(self.velocities, len(self.balls))
        if self.cradle:
            return Column.cradle(self.balls, velocities, law, gaps)
        return Column(self.balls, gaps, self.height, law, velocities, self.gravity)


def _one_for_all(values: tuple[float, ...], count: int) -> list[float]:
    return list(values) * count if len(values) == 1 else list(values)


def of_column(column: Column) -> Scenario:
    """The parameters of a column."""
    return Scenario(
        column.balls,
        column.gaps,
        column.laws,
        column.height,
        column.velocities,
        column.gravity,
        not column.floor,
    )


# --- TOML ---------------------------------------------------------------------------------------------------


def read(path: str | Path) -> Column:
    """The column that a TOML file describes.

    Raises
    ------
    ValueError
        If the file cannot be read, is not TOML, has an unknown key or a bad value; names the file.
    """
    return prefixed(f"{path}: ", read_with(path)[0].column)


def read_with(path: str | Path, *other: str) -> tuple[Scenario, dict[str, Any]]:
    """The scenario in a TOML file, and its top-level entries named in ``other`` as they stand."""
    content = toml.read(path)
    extra = {name: content.pop(name) for name in other if name in content}
    return prefixed(f"{path}: ", lambda: from_mapping(content)), extra


def loads(text: str) -> Column:
    """The column described by a text in TOML; the inverse of :func:`dumps`.

    Raises
    ------
    ValueError
        If it is not TOML, has an unknown key or a bad value.
    """
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
        lines += [
            "",
            "[[balls]]",
            f"radius = {ball.radius!r}",
            f"{ball.given} = {getattr(ball, ball.given)!r}",
        ]
    laws = column.laws[:1] if len(set(column.laws)) == 1 else column.laws
    for law in laws:
        lines += ["", "[law]" if len(laws) == 1 else "[[laws]]", f'name = "{law.record["name"]}"']
        lines += [f"{name} = {value!r}" for name, value in law.parameters.items()]
    return "\n".join([*lines, ""])


def write(column: Column, path: str | Path) -> Path:
    """Write the column as a TOML file.

    Raises
    ------
    OSError
        If the file cannot be written; names it.
    """
    return saving.write(path, dumps(column).encode())


def from_mapping(content: Mapping[str, Any]) -> Scenario:
    """The scenario in a mapping with the keys of the TOML file.

    Raises
    ------
    ValueError
        For an unknown or missing key, a value of another type and one outside its range.
    """
    from .schema import ColumnTable

    table = toml.convert(content, ColumnTable)
    balls = tuple(_ball(i, ball) for i, ball in enumerate(table.balls))
    laws = _laws(table)
    n = len(balls)
    if table.cradle:
        _check_cradle(table)
    elif table.height is None:
        raise ValueError("height: missing, must be the height [m] of the lowest centre at release")
    elif table.gaps is None and n > 1:
        raise ValueError(f"gaps: missing, must be a list of {n - 1}")
    gravity = STANDARD_GRAVITY if table.gravity is None else _quantity("gravity", table.gravity, "m/s2")
    return Scenario(
        balls=balls,
        gaps=_quantities("gaps", table.gaps, "m", n - 1, lowest=0.0, lowest_allowed=True),
        laws=laws,
        height=0.0 if table.cradle else validation.number("height", _quantity("height", table.height, "m")),
        velocities=_quantities("velocities", table.velocities, "m/s", n),
        gravity=validation.number("gravity", gravity, 0.0, lowest_allowed=True),
        cradle=table.cradle,
    )


def _check_cradle(table: Any) -> None:
    if table.height is not None:
        raise ValueError(f"height: got {table.height!r}, must be left out for a cradle")
    if table.gravity is not None and _quantity("gravity", table.gravity, "m/s2") != 0.0:
        raise ValueError(f"gravity: got {table.gravity!r}, must be 0 or left out for a cradle")


def _quantity(name: str, value: float | str, unit: str) -> float:
    """The number, or the one that a text gives with its unit."""
    return units.with_unit(name, value, unit) if isinstance(value, str) else value


def _quantities(name: str, values: Any, unit: str, count: int, **limits: Any) -> tuple[float, ...]:
    """``count`` numbers; one value stands for all of them, none at all means 0."""
    if isinstance(values, list):
        numbers: Any = [_quantity(f"{name}[{i}]", value, unit) for i, value in enumerate(values)]
    else:
        numbers = 0.0 if values is None else _quantity(name, values, unit)
    return validation.numbers(name, numbers, count, **limits)


def _given(table: Struct, where: str, units_of: Mapping[str, str]) -> dict[str, float]:
    """The entries of a table that are given, as numbers."""
    entries = {name: getattr(table, name) for name in units_of}
    return {
        name: _quantity(f"{where}{name}", value, units_of[name])
        for name, value in entries.items()
        if value is not None
    }


def _ball(i: int, table: Any) -> Ball:
    given = _given(table, f"balls[{i}].", {"radius": "m", "density": "kg/m3", "mass": "kg"})
    return prefixed(f"balls[{i}].", lambda: Ball(**given))


def _laws(table: Any) -> tuple[Law, ...]:
    if (table.law is None) == (table.laws is None):
        count = "neither" if table.law is None else "both"
        raise ValueError(f"law | laws: got {count}, must be one [law] or one [[laws]] for each contact")
    if table.law is not None:
        return (law_from_table("law.", table.law),)
    return tuple(law_from_table(f"laws[{i}].", one) for i, one in enumerate(table.laws))


def law_from_table(where: str, table: Struct) -> Law:
    """The law that a table describes; ``where`` stands before its keys in messages.

    Raises
    ------
    ValueError
        If its parameters do not make a law.
    """
    kind = LAWS[str(table.__struct_config__.tag)]
    units_of = {name: record["unit"] for name, record in law_parameters(kind).items()}
    given = _given(table, where, units_of)
    return prefixed(where, lambda: kind(**given))


def law_class(name: Any, parameter: str = "law") -> type[Law]:
    """The law with a name such as ``linear``.

    Raises
    ------
    ValueError
        If there is none.
    """
    if not isinstance(name, str) or name not in LAWS:
        raise ValueError(f"{parameter}: got {name!r}, must be one of {', '.join(LAWS)}")
    return LAWS[name]


def prefixed(where: str, make: Callable[[], T]) -> T:
    """``make()``, with ``where`` put before the message if it refuses its input."""
    try:
        return make()
    except ValueError as error:
        raise ValueError(f"{where}{error}") from None


# --- changes ------------------------------------------------------------------------------------------------


def with_law(scenario: Scenario, name: str | None, parameters: Mapping[str, float]) -> Scenario:
    """Another law, or other parameters of the present one.

    Without ``name`` the parameters decide: those of another law only mean that law.
    """
    kind = type(scenario.laws[0]) if scenario.laws else None
    wanted = law_class(name) if name is not None else law_with(kind, parameters)
    if wanted is not kind:
        return replace(scenario, laws=(wanted(**parameters),))
    return replace(scenario, laws=tuple(law.replace(**parameters) for law in scenario.laws))


def law_with(present: type[Law] | None, names: Collection[str]) -> type[Law]:
    """The law that takes parameters of these names, the present one first.

    Raises
    ------
    ValueError
        If there is none.
    """
    laws = [law for law in (present, *LAWS.values()) if law is not None]
    for law in laws:
        if set(names) <= law_parameters(law).keys():
            return law
    known = law_parameters(laws[0])
    strange = next(name for name in names if name not in known)
    law = laws[0].record["name"]
    raise ValueError(f"{strange}: unknown for the law {law}, must be one of {', '.join(known)}")


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
    """Other radii, densities or masses. One density stands for all balls.

    ``radii`` replaces all radii and may change the number of balls; ``radius_ratio`` R1/R2 sets the lowest.
    """
    if densities and masses:
        raise ValueError("density | mass: got both, must be at most one of them")
    if radius_1 is not None and radius_ratio is not None:
        raise ValueError("radius_ratio | radius_1: got both, must be at most one of them")
    if radii and not all(value is None for value in (radius_1, radius_2, radius_ratio)):
        raise ValueError("radius | radius_1, radius_2, radius_ratio: got both, must be at most one of them")
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
    """Balls of these sizes: of the densities or masses given, else of what the present ones are made of."""
    if densities:
        values = densities[0] if len(densities) == 1 else densities
        rho = validation.numbers("density", values, len(sizes), lowest=0.0)
        return [Ball(r, density=d) for r, d in zip(sizes, rho, strict=True)]
    if masses:
        m = validation.numbers("mass", masses, len(sizes), lowest=0.0)
        return [Ball(r, mass=value) for r, value in zip(sizes, m, strict=True)]
    if len(sizes) == len(balls):
        return [ball.resized(r) for ball, r in zip(balls, sizes, strict=True)]
    kinds = {ball.density for ball in balls}
    if len(kinds) > 1:
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
    """Other gaps, velocities at release (one stands for all), height or gravity."""
    if scenario.cradle and height is not None:
        raise ValueError("height: a cradle has none, must be left out")
    if scenario.cradle and gravity is not None:
        raise ValueError("gravity: a cradle has none, must be left out")
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


def _fitting(name: str, given: Sequence[float], present: tuple[float, ...], count: int) -> tuple[float, ...]:
    """The values given, or those present, which may stretch to more balls if they are all the same."""
    if given:
        limits = {"lowest": 0.0, "lowest_allowed": True} if name == "gap" else {}
        return validation.numbers(name, given[0] if len(given) == 1 else given, count, **limits)
    if len(present) != count and len(set(present)) == 1:
        return present[:1] * count
    return present
