"""The plan of a sweep: the column, the swept parameters and their dimensions, without results."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..column import models
from ..column.scenario import Column
from ..contact.contact import RESTITUTION, Law
from ..support import validation
from .axes import Axes
from .computation import Coordinate, Report, Values, Variable
from .parameters import Parameter, contact_name, geometry, of_law
from .variables import BALL, OF_BALL, OF_TWO_BALLS, VARIABLES, default_variables

#: Names of the models in the order of the core.
MODELS: Final = tuple(models.MODELS)

#: Local error of a step of the vector kernel of the viscoelastic law, in units of the impact.
KERNEL_TOLERANCE: Final = 2.0**-32

#: Local error of a step of the general solver, as for ``hl.newton``.
GENERAL_TOLERANCE: Final = 1e-14


@dataclass(frozen=True)
class Plan:
    """A sweep without its results, a picklable ``computation.Computation``.

    Entry i of the row of numbers of a point (see ``parameters``) is ``values[i][(point // strides[i]) % size]``, with
    points numbered in C order over ``shape``.
    """

    model: str
    law: str
    alternative: int
    #: Whether each ball is given by its density rather than its mass.
    densities: tuple[bool, ...]
    restitution_at: int
    values: tuple[NDArray[np.float64], ...]
    strides: tuple[int, ...]
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: tuple[Coordinate, ...]
    variables: tuple[str, ...]
    column: str
    integrated: bool
    #: Local error of a step; None if all results are exact
    tolerance: float | None = None
    #: Local error of a step for the variables from the general solver
    general_tolerance: float = GENERAL_TOLERANCE

    @property
    def balls(self) -> int:
        """Number of balls."""
        return len(self.densities)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def results(self) -> dict[str, Variable]:
        """The variables, those per ball with the number of balls."""
        variables = {name: VARIABLES[name] for name in self.variables}
        return {k: dataclasses.replace(v, shape=(self.balls,)) if v.dims else v for k, v in variables.items()}

    def attributes(self) -> dict[str, Any]:
        """Attributes of the Dataset."""
        how = {} if self.tolerance is None else {"tolerance": self.tolerance}
        return {"model": self.model, "column": self.column, **how, "hardlimit_version": _core.version}

    def fingerprint(self) -> str:
        """Hash of everything that a result or coordinate depends on."""
        named = [(c.name, c.dim, str(c.values.dtype)) for c in self.coordinates]
        how = (self.law, self.alternative, self.densities, self.restitution_at, self.general_tolerance)
        layout = (self.strides, self.dims, self.shape, self.variables, named)
        digest = hashlib.sha256(repr((self.attributes(), how, layout)).encode())
        for values in (*self.values, *(c.values for c in self.coordinates)):
            digest.update(values.size.to_bytes(8, "little"))
            digest.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
        return digest.hexdigest()

    def part(self, box: tuple[slice, ...]) -> Plan:
        """A box of points, with only the values that they need and without coordinates."""
        shape = tuple(s.stop - s.start for s in box)
        values, strides = list(self.values), list(self.strides)
        for dim, some in enumerate(box):
            along = (self.shape[dim], math.prod(self.shape[dim + 1 :]))
            for i, (v, stride) in enumerate(zip(self.values, self.strides, strict=True)):
                if len(v) > 1 and (len(v), stride) == along:
                    values[i], strides[i] = v[some], math.prod(shape[dim + 1 :])
        return dataclasses.replace(
            self, values=tuple(values), strides=tuple(strides), shape=shape, coordinates=()
        )

    def at(self, points: NDArray[np.int64]) -> Plan:
        """A list of points."""
        values = zip(self.values, self.strides, strict=True)
        return dataclasses.replace(
            self,
            values=tuple(v[(points // stride) % len(v)] if len(v) > 1 else v for v, stride in values),
            strides=(1,) * len(self.values),
            dims=("point",),
            shape=points.shape,
            coordinates=(),
        )

    def compute(self, first: int, count: int, threads: int, progress: Report | None = None) -> Values:
        """Points ``first`` … ``first + count − 1`` as flat arrays; the bits do not depend on the range or the threads.

        Vector kernels solve two balls. A second pass with the solver of single columns computes the values per ball,
        and all variables of other columns.
        """
        alone = [name for name in self.variables if name in OF_BALL or self.balls != 2]
        kernel = [name for name in self.variables if name not in alone]
        passes = [p for p in ((self._through_kernel, kernel), (self._one_by_one, alone)) if p[1]]
        values: Values = {}
        for i, (solve, names) in enumerate(passes):
            values |= solve(names, first, count, threads, _part_of(progress, i, len(passes), count))
        return {name: values[name] for name in self.variables}

    def _job(self, first: int, count: int, threads: int, progress: Report | None) -> dict[str, Any]:
        """The arguments that both passes through the core share."""
        return {
            "law": self.law,
            "model": MODELS.index(self.model),
            "alternative": self.alternative,
            "values": list(self.values),
            "strides": list(self.strides),
            "first": first,
            "count": count,
            "threads": threads,
            "progress": progress,
        }

    def _through_kernel(
        self, names: Sequence[str], first: int, count: int, threads: int, progress: Report | None
    ) -> Values:
        out: Values = {name: np.empty(count, VARIABLES[name].dtype) for name in names}
        lower, upper = self.densities
        large = _core.run_map(
            **self._job(first, count, threads, progress),
            density_1=lower,
            density_2=upper,
            restitution_at=self.restitution_at,
            tolerance=math.nan if self.tolerance is None else self.tolerance,
            out=out,
        )
        if large:  # more than 255 contacts somewhere
            out["n_contacts"] = out["n_contacts"].astype(np.uint32)
            for point, n in large:
                out["n_contacts"][point] = n
        return out

    def _one_by_one(
        self, names: Sequence[str], first: int, count: int, threads: int, progress: Report | None
    ) -> Values:
        out: Values = {}
        for name in names:
            variable = self.results[name]
            out[name] = np.empty((count, *variable.shape), variable.stored or variable.dtype)
        _core.run_columns(
            **self._job(first, count, threads, progress),
            density=list(self.densities),
            tolerance=self.general_tolerance,
            out={name: values.reshape(-1) for name, values in out.items()},
        )
        if "n_contacts" in out and out["n_contacts"].max(initial=0) <= 255:
            out["n_contacts"] = out["n_contacts"].astype(np.uint8)
        return out


def _part_of(progress: Report | None, part: int, parts: int, count: int) -> Report | None:
    """Progress of one of several passes over the same points."""
    if progress is None or parts == 1:
        return progress
    return lambda done: progress((part * count + done) // parts)


# --- from the arguments of hl.sweep -------------------------------------------------------------------------


def make_plan(
    column: Column,
    model: str,
    variables: Iterable[str] | None,
    swept: Mapping[str, Any],
    tolerance: float | None = None,
) -> Plan:
    """Make the plan of a sweep from the arguments of ``hl.sweep``.

    Raises a ValueError for an unknown name, a value outside its range, or a column that cannot be swept.
    """
    if not isinstance(column, Column) or not column.floor:
        raise ValueError(f"column: got {validation.shown(column)}, must be a column of balls on a floor")
    balls, record = len(column.balls), column.laws[0].record
    _check_model(model, column)
    kept = _kept(variables, balls)
    alternative = _alternative(column.laws, swept)
    known = geometry(balls) | of_law(record, alternative, balls)
    axes = Axes(swept, known)
    taken = _taken(known[name] for name in swept)
    densities, fixed = _numbers(column, alternative, taken)
    values, strides = _vary(fixed, taken, axes)
    _require_parameters(column, alternative, values)
    exact = model != "newton" or column.solvable_exactly
    in_kernel = balls == 2 and _core.has_kernel(record["name"], MODELS.index(model))
    names = [p["name"] for p in [*record["common"], *record["alternatives"][alternative]]]
    per_ball = any(VARIABLES[name].dims for name in kept)
    label = Coordinate(BALL, BALL, np.arange(1, balls + 1), "1", "ball, 1 = lowest")
    return Plan(
        model=model,
        law=record["name"],
        alternative=alternative,
        densities=densities,
        restitution_at=names.index(RESTITUTION) if RESTITUTION in names else -1,
        values=values,
        strides=strides,
        dims=tuple(axes.sizes),
        shape=tuple(axes.sizes.values()),
        coordinates=(*axes.coordinates, label) if per_ball else tuple(axes.coordinates),
        variables=kept,
        column=repr(column),
        integrated=not exact,
        tolerance=_tolerance(tolerance, exact, in_kernel),
        general_tolerance=GENERAL_TOLERANCE if tolerance is None else float(tolerance),
    )


def _check_model(name: Any, column: Column) -> None:
    model = models.MODELS[validation.one_of("model", name, MODELS)]
    if not model.applies(column):
        others = " or ".join(n for n, m in models.MODELS.items() if m.applies(column))
        raise ValueError(f"model: got {name!r}, must be {others} unless the column is {model.needs}")


def _kept(variables: Iterable[str] | None, balls: int) -> tuple[str, ...]:
    """The requested variables."""
    if variables is None:
        return default_variables(balls)
    single = isinstance(variables, str) or getattr(variables, "ndim", 1) == 0  # an array without dimensions
    if single or not isinstance(variables, Iterable):
        raise ValueError(f"variables: got {validation.shown(variables)}, must be a list of names")
    kept = []
    for name in variables:
        if not isinstance(name, str) or name not in VARIABLES:
            raise ValueError(f"variables: got {validation.shown(name)}, must be among {', '.join(VARIABLES)}")
        if name in OF_TWO_BALLS and balls != 2:
            others = ", ".join(n for n in VARIABLES if n not in OF_TWO_BALLS)
            raise ValueError(f"variables: got {name!r} for {balls} balls, must be among {others}")
        kept.append(name)
    if not kept:
        raise ValueError("variables: got none, must name at least one")
    return tuple(dict.fromkeys(kept))


def _tolerance(tolerance: Any, exact: bool, in_kernel: bool) -> float | None:
    """Local error of a step, of the kernel or the general solver; None if all results are exact."""
    if exact:
        if tolerance is None:
            return None
        need = "must not be given unless the model is newton and the points are integrated: these are exact"
        raise ValueError(f"tolerance: got {validation.shown(tolerance)}, {need}")
    if tolerance is None:
        return KERNEL_TOLERANCE if in_kernel else GENERAL_TOLERANCE
    limits = (1e-13, 1e-6) if in_kernel else (1e-15, 1e-2)
    return validation.number("tolerance", tolerance, *limits, lowest_allowed=True, highest_allowed=True)


def _alternative(laws: Sequence[Law], swept: Mapping[str, Any]) -> int:
    """Number of the law's set of parameters: the one with the swept names, otherwise that of the column."""
    contacts = ["", *(f"_{contact_name(i)}" for i in range(len(laws)))]
    choices = [{p["name"] for p in choice} for choice in laws[0].record["alternatives"]]
    chosen = {name for name in set().union(*choices) if any(name + contact in swept for contact in contacts)}
    for i, names in enumerate(choices):
        if chosen and chosen <= names:
            return i
    if len({law.alternative for law in laws}) > 1:
        raise ValueError("law: got laws given by different parameters, must be given by the same ones")
    return laws[0].alternative


def _taken(swept: Iterable[Parameter]) -> dict[int, Parameter]:
    """The swept parameter that determines each number of the row; two for one number are refused."""
    claimed: dict[int, Parameter] = {}
    for parameter in swept:
        for index in (*parameter.indices, *parameter.overrides):
            if index in claimed:
                names = f"{parameter.name} | {claimed[index].name}"
                raise ValueError(f"{names}: got both, must be at most one of them")
            claimed[index] = parameter
    return {index: p for index, p in claimed.items() if index not in p.overrides}


def _numbers(
    column: Column, alternative: int, taken: Mapping[int, Parameter]
) -> tuple[tuple[bool, ...], list[float]]:
    """The row of numbers of the column itself; NaN for parameters that its law does not have."""
    balls = len(column.balls)
    index = {row["name"]: row["first"] for row in _core.swept_parameters(balls)}
    kinds = [
        taken[at].kind if (at := index["density"] + i) in taken else ball.given
        for i, ball in enumerate(column.balls)
    ]
    row = [math.nan] * _core.law_place(balls, balls)
    for i, ball in enumerate(column.balls):
        row[index["radius"] + i] = ball.radius
        row[index["density"] + i] = ball.density if kinds[i] == "density" else ball.mass
        row[index["velocity"] + i] = column.velocities[i]
    for i, gap in enumerate(column.gaps):
        row[index["gap"] + i] = gap
    row[index["height"]], row[index["gravity"]] = column.height, column.gravity
    for contact, law in enumerate(column.laws):
        for p in of_law(law.record, alternative, balls).values():
            if p.name == p.kind:
                row[p.indices[contact]] = law.parameters.get(p.name, math.nan)
    return tuple(kind == "density" for kind in kinds), row


def _vary(
    fixed: Sequence[float], taken: Mapping[int, Parameter], axes: Axes
) -> tuple[tuple[NDArray[np.float64], ...], tuple[int, ...]]:
    """Values and strides of every number of the row; numbers of one parameter share their values."""
    swept = {c.name: c for c in axes.coordinates}
    stride = axes.strides()
    values, strides = [], []
    for index, number in enumerate(fixed):
        coordinate = swept[taken[index].name] if index in taken else None
        values.append(np.array([number]) if coordinate is None else coordinate.values)
        strides.append(1 if coordinate is None or coordinate.dim is None else stride[coordinate.dim])
    return tuple(values), tuple(strides)


def _require_parameters(column: Column, alternative: int, values: Sequence[NDArray[np.float64]]) -> None:
    """Refuse a law with a parameter that is neither swept nor given for all contacts."""
    record, balls = column.laws[0].record, len(column.balls)
    choice = [p["name"] for p in record["alternatives"][alternative]]
    for p in of_law(record, alternative, balls).values():
        if p.name == p.kind and any(np.isnan(values[index][0]) for index in p.indices):
            need = f"must be swept or given for every contact when {', '.join(choice)} are"
            raise ValueError(f"{p.name}: missing, {need}")
