"""Numbers that are given beside a script: they fill what it does not state, and a time step replaces its own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from ..support import validation
from ..support.units import SYSTEMS
from .scripts import Description, Grains, Stage

#: Units of mass, length and time in SI; ``lj`` stays as it is.
SCALES: Final = {**SYSTEMS, "lj": (1.0, 1.0, 1.0)}
#: Statements that read sizes from a file.
FROM_FILES: Final = ("read_data", "read_restart", "ymport.", ".load(", ".fromFile(")


@dataclass(frozen=True)
class Supplied:
    """What is given beside a script, in SI units, or as in the script if it is in ``lj`` units."""

    radius: float | None = None
    density: float | None = None
    mass: float | None = None
    time_step: float | None = None


NOTHING: Final = Supplied()


def supplied(**numbers: Any) -> Supplied:
    """Checked numbers."""
    if numbers.get("density") is not None and numbers.get("mass") is not None:
        raise ValueError("density | mass: got both, must be at most one")
    return Supplied(
        **{
            name: None if value is None else validation.number(name, value, 0.0)
            for name, value in numbers.items()
        }
    )


def completed(script: Description, numbers: Supplied) -> Description:
    """The script with the sizes, masses and the time step that are numbers.

    A file that it reads sizes from need then not be understood. A ValueError if it has these numbers of all grains.
    """
    for name in ("radius", "density", "mass"):
        value = getattr(numbers, name)
        if value is not None and not any(lacks(kind, name) for kind in all_grains(script)):
            raise ValueError(f"{name}: got {value:g}, must be left out: the script states that of all grains")
    stages = [_stage(stage, numbers) for stage in script.stages]
    unknown = script.unknown
    if numbers.radius is not None:
        unknown = tuple(quote for quote in unknown if not any(word in quote.text for word in FROM_FILES))
    return replace(script, stages=tuple(stages), unknown=unknown)


def all_grains(script: Description) -> list[Grains]:
    """The grains of all types at all runs."""
    return [kind for stage in script.stages for kind in stage.grains.values()]


def lacks(kind: Grains, name: str) -> bool:
    """Whether the radius, or the density or mass, of grains is not known."""
    return kind.radii is None if name == "radius" else kind.densities is None and kind.masses is None


def _stage(stage: Stage, numbers: Supplied) -> Stage:
    mass, length, time = SCALES[stage.units]
    values = {
        "radius": None if numbers.radius is None else numbers.radius / length,
        "density": None if numbers.density is None else numbers.density * length**3 / mass,
        "mass": None if numbers.mass is None else numbers.mass / mass,
    }
    names = {"radius": "radii", "density": "densities", "mass": "masses"}

    def grains(kind: Grains) -> Grains:
        ends: dict[str, Any] = {
            names[name]: (value, value)
            for name, value in values.items()
            if value is not None and lacks(kind, name)
        }
        return replace(kind, **ends, fixed=kind.fixed and grains(kind.fixed))

    filled = replace(stage, grains={name: grains(kind) for name, kind in stage.grains.items()})
    if numbers.time_step is None:
        return filled
    return replace(filled, time_step=numbers.time_step / time, time_step_given=True)
