"""A column as a TOML file, and a column changed by named parameters: what the command line reads and writes.

The file has the top-level keys ``height`` and ``gravity``, ``gaps``, ``velocities``, one ``[[balls]]`` table
for each ball, bottom first (``radius``, and ``density`` or ``mass``), and one ``[law]`` (``name`` and its
parameters) or one ``[[laws]]`` for each contact, the floor's first. ``cradle = true`` leaves out floor,
height and gravity (which may stand there as 0).
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeVar

from .. import validation
from ..bodies import Ball
from ..contact import Law
from ..laws import LAWS
from .scenario import STANDARD_GRAVITY, Column

KEYS: Final = ("cradle", "height", "gravity", "gaps", "velocities", "balls", "law", "laws")
BALL_KEYS: Final = ("radius", "density", "mass")

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
    try:
        content = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not valid TOML: not a text in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not valid TOML: {error}") from None
    extra = {name: content.pop(name) for name in other if name in content}
    try:
        return from_mapping(content), extra
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def loads(text: str) -> Column:
    """The column described by a text in TOML; the inverse of :func:`dumps`.

    Raises
    ------
    ValueError
        If it is not TOML, has an unknown key or a bad value.
    """
    return from_mapping(tomllib.loads(text)).column()


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
    ValueError
        If the file cannot be written.
    """
    target = Path(path)
    try:
        target.write_text(dumps(column), encoding="utf-8")
    except OSError as error:
        raise ValueError(f"{path}: cannot be written: {error.strerror or error}") from None
    return target


def from_mapping(content: Mapping[str, Any]) -> Scenario:
    """The scenario in a mapping with the keys of the TOML file.

    Raises
    ------
    ValueError
        For an unknown or missing key and for a value outside its range.
    """
    _refuse_unknown("", content, KEYS)
    cradle = content.get("cradle", False)
    if not isinstance(cradle, bool):
        raise ValueError(f"cradle: got {cradle!r}, must be true or false")
    if cradle:
        _refuse_unknown("", content, [key for key in KEYS if key != "height"], " for a cradle")
        if content.get("gravity", 0) != 0:
            raise ValueError(f"gravity: got {content['gravity']!r}, must be 0 or left out for a cradle")
    balls = tuple(_ball(i, table) for i, table in enumerate(_tables("balls", content.get("balls"))))
    height = content.get("height")
    if height is None and not cradle:
        raise ValueError("height: missing, must be the height [m] of the lowest centre at release")
    if "gaps" not in content and not cradle:
        raise ValueError(f"gaps: missing, must be a list of {len(balls) - 1}")
    n = len(balls)
    return Scenario(
        balls=balls,
        gaps=validation.numbers("gaps", content.get("gaps", 0.0), n - 1, lowest=0.0, lowest_allowed=True),
        laws=_laws(content),
        height=0.0 if cradle else validation.number("height", height),
        velocities=validation.numbers("velocities", content.get("velocities", 0.0), n),
        gravity=validation.number(
            "gravity", content.get("gravity", STANDARD_GRAVITY), 0.0, lowest_allowed=True
        ),
        cradle=cradle,
    )


def _refuse_unknown(where: str, table: Mapping[str, Any], known: Collection[str], in_what: str = "") -> None:
    for key in table:
        if key not in known:
            raise ValueError(f"{where}{key}: unknown{in_what}, must be one of {', '.join(known)}")


def _tables(name: str, value: Any) -> list[Mapping[str, Any]]:
    if value is None:
        raise ValueError(f"{name}: missing, must be two or more [[{name}]] tables")
    if not isinstance(value, list) or not all(isinstance(table, Mapping) for table in value):
        raise ValueError(f"{name}: got {value!r}, must be [[{name}]] tables")
    return value


def _ball(i: int, table: Mapping[str, Any]) -> Ball:
    _refuse_unknown(f"balls[{i}].", table, BALL_KEYS)
    if "radius" not in table:
        raise ValueError(f"balls[{i}].radius: missing, must be > 0 and finite")
    return prefixed(f"balls[{i}].", lambda: Ball(**table))


def _laws(content: Mapping[str, Any]) -> tuple[Law, ...]:
    if ("law" in content) == ("laws" in content):
        count = "both" if "law" in content else "neither"
        raise ValueError(f"law | laws: got {count}, must be one [law] or one [[laws]] for each contact")
    if "laws" in content:
        return tuple(_law(f"laws[{i}].", t) for i, t in enumerate(_tables("laws", content["laws"])))
    if not isinstance(content["law"], Mapping):
        raise ValueError(f"law: got {content['law']!r}, must be a [law] table")
    return (_law("law.", content["law"]),)


def _law(where: str, table: Mapping[str, Any]) -> Law:
    parameters = dict(table)
    kind = law_class(parameters.pop("name", None), f"{where}name")
    return prefixed(where, lambda: kind(**parameters))


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
    wanted = law_class(name) if name is not None else _law_with(kind, parameters)
    if wanted is not kind:
        return replace(scenario, laws=(wanted(**parameters),))
    return replace(scenario, laws=tuple(law.replace(**parameters) for law in scenario.laws))


def law_parameters(law: type[Law]) -> dict[str, dict[str, Any]]:
    """The records of all parameters that a law knows, by name."""
    choices = law.record["alternatives"]
    return {p["name"]: p for p in [*law.record["common"], *(p for choice in choices for p in choice)]}


def _law_with(present: type[Law] | None, names: Collection[str]) -> type[Law]:
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
    if radius_1 is not None:
        sizes[0] = validation.number("radius_1", radius_1, 0.0)
    if radius_2 is not None:
        sizes[1] = validation.number("radius_2", radius_2, 0.0)
    if radius_ratio is not None:
        sizes[0] = validation.number("radius_ratio", radius_ratio, 0.0) * sizes[1]
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
