"""What a sweep computes: a column, the parameters that vary, and along which dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core, models, validation
from ..column.scenario import Column
from ..contact import Law

if TYPE_CHECKING:
    import xarray as xr

#: Names of the models, each in the place of its number in the core.
MODELS: Final = tuple(models.MODELS)

#: Local error of a step of the viscoelastic law's vector kernel, in units of the impact.
TOLERANCE: Final = 2.0**-32

#: Parameters of the column in the order of the core's ``Parameters``; the law's follow, floor and pair.
GEOMETRY: Final = (
    "radius_1",
    "radius_2",
    "radius_ratio",
    "matter_1",
    "matter_2",
    "gap",
    "height",
    "velocity_1",
    "velocity_2",
    "gravity",
)

#: Swept name → (places in GEOMETRY, unit, meaning, range).
_POSITIVE: Final[dict[str, Any]] = {"lowest": 0.0}
_NOT_NEGATIVE: Final[dict[str, Any]] = {"lowest": 0.0, "lowest_allowed": True}
SWEEPABLE: Final[dict[str, tuple[tuple[str, ...], str, str, dict[str, Any]]]] = {
    "gap": (("gap",), "m", "gap between the balls Δh", _NOT_NEGATIVE),
    "radius_ratio": (("radius_ratio",), "1", "R1/R2 (changes the lower radius)", _POSITIVE),
    "radius_1": (("radius_1",), "m", "radius of the lower ball R1", _POSITIVE),
    "radius_2": (("radius_2",), "m", "radius of the upper ball R2", _POSITIVE),
    "density": (("matter_1", "matter_2"), "kg/m3", "density of both balls", _POSITIVE),
    "density_1": (("matter_1",), "kg/m3", "density of the lower ball", _POSITIVE),
    "density_2": (("matter_2",), "kg/m3", "density of the upper ball", _POSITIVE),
    "mass_1": (("matter_1",), "kg", "mass of the lower ball m1", _POSITIVE),
    "mass_2": (("matter_2",), "kg", "mass of the upper ball m2", _POSITIVE),
    "height": (("height",), "m", "height of the lower centre at release z1(0)", _POSITIVE),
    "velocity_1": (("velocity_1",), "m/s", "velocity of the lower ball at release", {}),
    "velocity_2": (("velocity_2",), "m/s", "velocity of the upper ball at release", {}),
    "velocity": (("velocity_1", "velocity_2"), "m/s", "velocity of both balls at release", {}),
    "gravity": (("gravity",), "m/s2", "gravity g", _NOT_NEGATIVE),
}

#: Result variable → (dtype, unit, meaning).
VARIABLES: Final[dict[str, tuple[str, str, str]]] = {
    "n_contacts": ("uint8", "1", "ball–ball contacts of the sequence"),
    "relative_velocity": ("float64", "m/s", "v2 − v1 at t_f"),
    "separation_velocity": ("float64", "m/s", "v2 − v1 once no force acts"),
    "effective_restitution": (
        "float64",
        "1",
        "ε of the independent-collisions model with the same v2 − v1 at t_f",
    ),
    "restitution_ratio": ("float64", "1", "effective over specified coefficient of restitution"),
    "t_end": ("float64", "s", "t_f, end of the last ball–ball contact of the sequence"),
    "t_floor_end": ("float64", "s", "first release from the floor"),
    "outcome": ("uint8", "1", "how the computation ended, 0 = ok"),
}
DEFAULT_VARIABLES: Final = tuple(name for name in VARIABLES if name != "t_floor_end")

Chunk = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Plan:
    """A sweep without its results; pickles, so that it can be computed anywhere.

    ``values[i]`` and ``strides[i]`` give parameter i of the core: value index (point // stride) % size, points
    counted in C order over ``shape``.
    """

    model: str
    law: str
    alternative: int
    density_1: bool
    density_2: bool
    restitution_at: int
    values: tuple[NDArray[np.float64], ...]
    strides: tuple[int, ...]
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    #: name, dimension (None: a single number), values, unit, meaning
    coordinates: tuple[tuple[str, str | None, NDArray[np.float64], str, str], ...]
    variables: tuple[str, ...]
    column: str
    #: None where every result is exact
    tolerance: float | None = None

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def compute(
        self,
        first: int,
        count: int,
        threads: int,
        progress: Callable[[int], object] | None = None,
        out: Chunk | None = None,
    ) -> Chunk:
        """Points ``first`` … ``first + count − 1`` as flat arrays; the same bits whoever computes them."""
        if out is None:
            out = {name: np.empty(count, VARIABLES[name][0]) for name in self.variables}
        large = _core.run_map(
            self.law,
            MODELS.index(self.model),
            self.alternative,
            self.density_1,
            self.density_2,
            self.restitution_at,
            list(self.values),
            list(self.strides),
            first,
            count,
            threads,
            math.nan if self.tolerance is None else self.tolerance,
            out,
            progress,
        )
        if large:  # more contacts than a byte holds: the whole variable takes a wider type
            out["n_contacts"] = out["n_contacts"].astype(np.uint32)
            for point, n in large:
                out["n_contacts"][point] = n
        return out

    def dataset(self, flat: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The results of all points as a labelled Dataset."""
        import xarray as xr

        data = {
            name: (self.dims, flat[name].reshape(self.shape), variable_attributes(name))
            for name in self.variables
        }
        return xr.Dataset(data, self.labels(), {**self.attributes(), **attributes})

    def labels(self) -> dict[str, Any]:
        """Coordinates in the form xarray takes; a single number has no dimension."""
        return {
            name: (() if dim is None else dim, v[0] if dim is None else v, {"units": unit, "long_name": text})
            for name, dim, v, unit, text in self.coordinates
        }

    def attributes(self) -> dict[str, Any]:
        """What was computed, for the attributes of a Dataset."""
        how = {} if self.tolerance is None else {"tolerance": self.tolerance}
        return {"model": self.model, "column": self.column, **how, "hardlimit_version": _core.version}


def variable_attributes(name: str) -> dict[str, Any]:
    """CF attributes of a result variable."""
    _, unit, text = VARIABLES[name]
    attributes: dict[str, Any] = {"units": unit, "long_name": text}
    if name == "outcome":
        names = _core.outcome_names
        attributes["flag_values"] = np.arange(len(names), dtype=np.uint8)
        attributes["flag_meanings"] = " ".join(names)
    return attributes


def make_plan(
    column: Column,
    model: str,
    variables: Sequence[str] | None,
    swept: Mapping[str, Any],
    tolerance: float | None = None,
) -> Plan:
    """Check a sweep and lay it out.

    Raises
    ------
    ValueError
        For an unknown name, a value outside its range, or a column that is not two balls on a floor.
    """
    if model not in MODELS:
        raise ValueError(f"model: got {model!r}, must be one of {', '.join(MODELS)}")
    if not isinstance(column, Column) or not column.floor or len(column.balls) != 2:
        raise ValueError("column: must be two balls on a floor to be swept")
    kept = DEFAULT_VARIABLES if variables is None else tuple(dict.fromkeys(variables))
    for name in kept:
        if name not in VARIABLES:
            raise ValueError(f"variables: got {name!r}, must be among {', '.join(VARIABLES)}")
    if not kept:
        raise ValueError("variables: got none, must name at least one")
    laws = tuple(_with_alternative(law, swept) for law in column.laws)
    if not models.MODELS[model].applies(column):
        raise ValueError("model: got 'adiabatic', must be newton or independent unless the law is linear")
    integrated = model == "newton" and laws[0][0].record["name"] != "linear"
    return _lay_out(column, model, kept, laws, swept, _tolerance(tolerance, integrated))


def _tolerance(tolerance: float | None, integrated: bool) -> float | None:
    if tolerance is None:
        return TOLERANCE if integrated else None
    if not integrated:
        need = "must not be given unless the law is viscoelastic and the model newton: the others are exact"
        raise ValueError(f"tolerance: got {tolerance!r}, {need}")
    return validation.number("tolerance", tolerance, 1e-13, 1e-6, lowest_allowed=True, highest_allowed=True)


def _with_alternative(law: Law, swept: Mapping[str, Any]) -> tuple[Law, int]:
    """The law and the alternative the swept names ask for."""
    for i, choice in enumerate(law.record["alternatives"]):
        names = [p["name"] for p in choice]
        other = {p["name"] for c in law.record["alternatives"] for p in c} - set(names)
        if any(n in swept for n in names) and not any(n in swept for n in other):
            for n in names:
                if n not in swept and n not in law.parameters:
                    raise ValueError(f"{n}: missing, must be swept or given when {', '.join(names)} are")
            return law, i
    return law, law.alternative


def _lay_out(
    column: Column,
    model: str,
    variables: tuple[str, ...],
    laws: Sequence[tuple[Law, int]],
    swept: Mapping[str, Any],
    tolerance: float | None,
) -> Plan:
    record = laws[0][0].record
    if len({alternative for _, alternative in laws}) > 1:
        raise ValueError("law: the laws of the two contacts must be given by the same parameters")
    alternative = laws[0][1]
    lower, upper = column.balls
    fixed = {
        "radius_1": lower.radius,
        "radius_2": upper.radius,
        "radius_ratio": math.nan,
        "matter_1": getattr(lower, lower.given),
        "matter_2": getattr(upper, upper.given),
        "gap": column.gaps[0],
        "height": column.height,
        "velocity_1": column.velocities[0],
        "velocity_2": column.velocities[1],
        "gravity": column.gravity,
    }
    given = [lower.given, upper.given]
    law_parameters = [*record["common"], *record["alternatives"][alternative]]
    names = [p["name"] for p in law_parameters]
    places = {name: [GEOMETRY.index(place) for place in entry[0]] for name, entry in SWEEPABLE.items()}
    pair_at = len(GEOMETRY) + _core.max_law_parameters
    values = [np.array([fixed[name]]) for name in GEOMETRY]
    values += [np.array([math.nan])] * (_core.sweep_parameters - len(values))
    for start, (law, _) in zip((len(GEOMETRY), pair_at), laws, strict=True):
        for i, name in enumerate(names):
            values[start + i] = np.array([law.parameters.get(name, math.nan)])
    for i, name in enumerate(names):
        places[name] = [len(GEOMETRY) + i, pair_at + i]
    ranges = {name: (entry[1], entry[2], entry[3]) for name, entry in SWEEPABLE.items()}
    for p in law_parameters:
        limits = {k: p[k] for k in ("lowest", "highest", "lowest_allowed", "highest_allowed")}
        ranges[p["name"]] = (p["unit"], p["meaning"], limits)

    dims: dict[str, int] = {}
    coordinates = []
    dim_of: dict[int, str] = {}
    taken: dict[int, str] = {}
    for name, array in swept.items():
        if name not in ranges:
            raise ValueError(f"{name}: unknown, a sweep takes {', '.join(ranges)}")
        unit, meaning, limits = ranges[name]
        checked, dim = _axis_values(name, array, limits)
        if dim is not None and dims.setdefault(dim, len(checked)) != len(checked):
            raise ValueError(f"{name}: got {len(checked)} values, must be {dims[dim]} like dimension {dim!r}")
        coordinates.append((name, dim, checked, unit, meaning))
        _mark_matter(name, given)
        for place in places[name]:
            if place in taken:
                raise ValueError(f"{name} | {taken[place]}: got both, must be at most one of them")
            taken[place] = name
            values[place] = checked
            if dim is not None:
                dim_of[place] = dim
    _forbid_together(swept, "radius_ratio", "radius_1")
    _check_dimensions({name: dim for name, dim, *_ in coordinates if dim is not None})
    shape = tuple(dims.values())
    stride_of = {dim: math.prod(shape[i + 1 :]) for i, dim in enumerate(dims)}
    return Plan(
        model=model,
        law=record["name"],
        alternative=alternative,
        density_1=given[0] == "density",
        density_2=given[1] == "density",
        restitution_at=names.index("restitution") if "restitution" in names else -1,
        values=tuple(np.ascontiguousarray(v, dtype=np.float64) for v in values),
        strides=tuple(stride_of[dim_of[i]] if i in dim_of else 1 for i in range(len(values))),
        dims=tuple(dims),
        shape=shape,
        coordinates=tuple(coordinates),
        variables=variables,
        column=repr(column),
        tolerance=tolerance,
    )


def _mark_matter(name: str, given: list[str]) -> None:
    kind, _, which = name.partition("_")
    if kind in ("density", "mass"):
        for i in range(2):
            if which in ("", str(i + 1)):
                given[i] = kind


def _forbid_together(swept: Mapping[str, Any], a: str, b: str) -> None:
    if a in swept and b in swept:
        raise ValueError(f"{a} | {b}: got both, must be at most one of them")


def _check_dimensions(dim_of: Mapping[str, str]) -> None:
    """A dimension may bear the name of what is swept along it, but of nothing else in the Dataset."""
    for name, dim in dim_of.items():
        if dim in VARIABLES or dim_of.get(dim, dim) != dim:
            raise ValueError(f"{name}: got dimension {dim!r}, must be another name, that one is taken")


def _axis_values(name: str, array: Any, limits: dict[str, Any]) -> tuple[NDArray[np.float64], str | None]:
    """Values of one swept parameter, checked, and its dimension (None: a single number)."""
    dims = getattr(array, "dims", None)
    try:
        checked = np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: got {array!r}, must be a number or an array of numbers") from None
    if checked.ndim > 1:
        raise ValueError(f"{name}: got {checked.ndim} dimensions, must be a number or one-dimensional")
    if checked.ndim == 0:
        return np.array([validation.number(name, float(checked), **limits)]), None
    if checked.size == 0:
        raise ValueError(f"{name}: got an empty array, must hold at least one value")
    for extreme in (checked.min(), checked.max()):  # NaN comes through both
        validation.number(name, float(extreme), **limits)
    return np.ascontiguousarray(checked), name if dims is None else str(dims[0])
