"""The user's functions ``observe``, called at each sample of a run; their values are checked and collected."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support import validation
from .box import AXES
from .observables import OBSERVABLES, components
from .system import ParticleSystem

#: f(t, system) with t [s] returns numbers, arrays of numbers or DataArrays by name.
Function = Callable[[float, ParticleSystem], Mapping[str, Any]]
#: Functions of the system by the name of what they return.
Named = Mapping[str, Callable[[ParticleSystem], Any]]
#: What a user may give.
Observe = Function | Named | Sequence[Function | Named]
Parts = tuple[Function | Named, ...]


class Variable(NamedTuple):
    """An array with its labels; xarray accepts it as a variable of a Dataset."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: Mapping[str, Any] = {}


class Observed(NamedTuple):
    """The values of one sample, or stacked over ``time`` those of a run."""

    data: Mapping[str, Variable] = {}
    coordinates: Mapping[str, Variable] = {}


def checked_functions(observe: Any) -> Parts | None:
    """The functions, checked to be callable, or None."""
    if observe is None:
        return None
    alone = callable(observe) or isinstance(observe, Mapping)
    parts = (observe,) if alone else observe
    if isinstance(parts, Sequence) and not isinstance(parts, str | bytes) and all(map(_is_part, parts)):
        return tuple(parts)
    raise ValueError(
        f"observe: got {validation.shown(observe)}, must be a function of time and system, functions of the system by "
        "name, or a sequence of these"
    )


def _is_part(functions: Any) -> bool:
    if isinstance(functions, Mapping):
        return all(isinstance(name, str) and name and callable(f) for name, f in functions.items())
    return callable(functions)


def call(parts: Parts, time: float, system: ParticleSystem, before: Observed | None) -> Observed:
    """The values of the functions as arrays; ``before`` has those of the previous sample."""
    at = f"observe: at {time:.6g} s"
    data: dict[str, Variable] = {}
    known = {"axis": _labels("axis", AXES[: system.dimension])}
    known["component"] = _labels("component", components(system.dimension))
    coordinates = dict(known)
    for name, value in _returned(parts, at, time, system):
        if name in data:
            raise ValueError(f"{at} got the name {validation.shown(name)} twice, must be different names")
        data[name] = _variable(at, name, value)
        for key, labels in _coordinates(at, name, value):
            if not _same(coordinates.setdefault(key, labels), labels):
                raise ValueError(
                    f"{at} got other values of the coordinate {key!r} with {name!r}, must be the same"
                )
    observed = Observed(data, {key: value for key, value in coordinates.items() if key not in known})
    if before is None:
        _refuse_clashes(at, observed, known)
        return observed
    return _as_before(at, observed, before)


def _labels(dim: str, names: Sequence[str]) -> Variable:
    return Variable((dim,), np.array(names))


def _same(variable: Variable, other: Variable) -> bool:
    return variable.dims == other.dims and np.array_equal(variable.values, other.values)


def _returned(parts: Parts, at: str, time: float, system: ParticleSystem) -> Iterator[tuple[Any, Any]]:
    """Name and value of all that the functions return."""
    for part in parts:
        if isinstance(part, Mapping):
            for name, function in part.items():
                value = function(system)
                if isinstance(value, Mapping):  # also a Dataset
                    yield from ((f"{name}_{key}", item) for key, item in value.items())
                else:
                    yield name, value
        else:
            returned = part(time, system)
            if not isinstance(returned, Mapping):
                raise ValueError(
                    f"{at} got {validation.shown(returned)}, must return a mapping of names to numbers"
                )
            yield from returned.items()


def _is_labelled(value: Any) -> bool:
    """Whether the value is a DataArray; xarray is not imported for that."""
    return hasattr(value, "dims") and hasattr(value, "coords")


def _variable(at: str, name: Any, value: Any) -> Variable:
    if not isinstance(name, str) or not name:
        raise ValueError(f"{at} got the name {validation.shown(name)}, must be a non-empty text")
    try:
        array = np.array(value)  # a copy, because the function may reuse its array
    except Exception:  # a failing conversion may raise anything
        array = np.array(None)
    if array.dtype.kind not in "buif":
        raise ValueError(f"{at} got {validation.shown(value)} for {name!r}, must be a number or numbers")
    if _is_labelled(value):
        return Variable(tuple(map(str, value.dims)), array, _attributes(value))
    return Variable(tuple(f"{name}_{i}" for i in range(array.ndim)), array)


def _attributes(value: Any) -> dict[str, Any]:
    """The attributes that a checkpoint can hold."""
    return {
        str(key): attribute
        for key, attribute in value.attrs.items()
        if isinstance(attribute, str | int | float)
    }


def _coordinates(at: str, name: str, value: Any) -> Iterator[tuple[str, Variable]]:
    """The coordinates of a DataArray, except single numbers."""
    for key, coordinate in value.coords.items() if _is_labelled(value) else ():
        array = np.array(coordinate.values)
        array = array.astype(str) if array.dtype.kind == "O" else array
        if array.dtype.kind not in "buifU":
            raise ValueError(f"{at} got the coordinate {key!r} with {name!r}, must have numbers or words")
        if coordinate.dims:
            yield str(key), Variable(tuple(map(str, coordinate.dims)), array, _attributes(coordinate))


def _refuse_clashes(at: str, observed: Observed, known: Mapping[str, Variable]) -> None:
    """Refuse names that the series has already, and dimensions of two lengths."""
    lengths = {name: len(variable.values) for name, variable in known.items()}
    for name, variable in [*observed.data.items(), *observed.coordinates.items()]:
        for dim, length in zip(variable.dims, variable.values.shape, strict=True):
            if lengths.setdefault(dim, length) != length:
                raise ValueError(
                    f"{at} got {length} values of {name!r} along {dim!r}, must be {lengths[dim]}"
                )
    taken = {"time", "wall", *OBSERVABLES}
    dims = {name: {*variable.dims} - known.keys() for name, variable in observed.data.items()}
    labels = {*observed.coordinates}.union(*dims.values())
    for name in observed.data:
        clashes = ({name} & (taken | known.keys() | labels)) or (dims[name] & taken)
        if clashes:
            raise ValueError(
                f"{at} got the name {validation.shown(name)}, must be another one: {min(clashes)!r} is in the series "
                "already"
            )
    if clashes := taken & {*observed.coordinates}:
        raise ValueError(
            f"{at} got the coordinate {min(clashes)!r}, which is in the series already: rename it"
        )


def _as_before(at: str, observed: Observed, before: Observed) -> Observed:
    """The values in the order of the previous sample; refuses other names, shapes and coordinates."""
    if observed.data.keys() != before.data.keys():
        names, expected = (
            ", ".join(map(validation.shown, values.data)) or "none" for values in (observed, before)
        )
        raise ValueError(f"{at} got the names {names}, must be those of the previous sample: {expected}")
    for name, old in before.data.items():
        shape, expected_shape = observed.data[name].values.shape, old.values.shape
        if shape != expected_shape:
            raise ValueError(
                f"{at} got {name!r} of shape {shape}, must be {expected_shape} as at the previous sample"
            )
        if observed.data[name].dims != old.dims:
            raise ValueError(
                f"{at} got {name!r} over {observed.data[name].dims}, must be {old.dims} as before"
            )
    same = observed.coordinates.keys() == before.coordinates.keys()
    for key, labels in before.coordinates.items():
        if not (same and _same(labels, observed.coordinates[key])):
            raise ValueError(
                f"{at} got other values of the coordinate {key!r}, must be those of the previous sample"
            )
    data = {name: old._replace(values=observed.data[name].values) for name, old in before.data.items()}
    return Observed(data, before.coordinates)


# --- the values of all samples ------------------------------------------------------------------------------


def collected(values: Sequence[Mapping[str, Any]]) -> dict[str, NDArray[Any]]:
    """Stack the values of all samples: one array for each name."""
    return {name: np.array([sample[name] for sample in values]) for name in (values[0] if values else ())}


def joined(samples: Sequence[Observed]) -> Observed:
    """The values of all samples, stacked over ``time``."""
    if not samples:
        return NOTHING
    stacked = collected([{name: each.values for name, each in sample.data.items()} for sample in samples])
    data = {
        name: Variable(("time", *variable.dims), stacked[name], variable.attrs)
        for name, variable in samples[0].data.items()
    }
    return Observed(data, samples[0].coordinates)


def separated(values: Observed, n: int) -> list[Observed]:
    """The values of each of ``n`` samples: the inverse of :func:`joined`."""
    return [
        Observed(
            {
                name: Variable(variable.dims[1:], variable.values[k], variable.attrs)
                for name, variable in values.data.items()
            },
            values.coordinates,
        )
        for k in range(n)
    ]


def saved(values: Observed) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Entries of the header of a checkpoint, and its arrays."""
    header = {
        part: [
            [name, variable.dims, dict(variable.attrs)] for name, variable in getattr(values, part).items()
        ]
        for part in Observed._fields
    }
    arrays = {
        f"observed_{part}_{i}": variable.values
        for part in Observed._fields
        for i, variable in enumerate(getattr(values, part).values())
    }
    return {"observed": header}, arrays


def loaded(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Observed:
    """The inverse of :func:`saved`."""
    parts = (
        {
            name: Variable(tuple(dims), arrays[f"observed_{part}_{i}"], attrs)
            for i, (name, dims, attrs) in enumerate(header["observed"][part])
        }
        for part in Observed._fields
    )
    return Observed(*parts)


def variables(values: Observed) -> tuple[dict[str, Any], dict[str, Any]]:
    """The data variables and coordinates for an xarray Dataset."""
    data, coordinates = (
        {
            name: (variable.dims, variable.values.copy(), dict(variable.attrs))
            for name, variable in part.items()
        }
        for part in values
    )
    return data, coordinates


NOTHING: Final = Observed()
