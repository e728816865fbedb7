"""The user's function ``observe``, which is called at each sample of a run; its values are checked and collected."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support import validation
from .observables import OBSERVABLES, RESERVED
from .system import ParticleSystem

#: f(t, system) with t [s] returns numbers or arrays of numbers by name.
Observe = Callable[[float, ParticleSystem], Mapping[str, Any]]
Values = dict[str, NDArray[Any]]


def checked_function(observe: Any) -> Observe | None:
    """The function, checked to be callable, or None."""
    if observe is not None and not callable(observe):
        raise ValueError(f"observe: got {validation.shown(observe)}, must be a function of time and system")
    return observe  # type: ignore[no-any-return]


def call(observe: Observe, time: float, system: ParticleSystem, before: Values | None) -> Values:
    """The values of the function as arrays; ``before`` has those of the previous sample."""
    returned = observe(time, system)
    at = f"observe: at {time:.6g} s"
    if not isinstance(returned, Mapping):
        raise ValueError(f"{at} got {validation.shown(returned)}, must return a mapping of names to numbers")
    found = {name: _array(at, name, value) for name, value in returned.items()}
    if before is None:
        _refuse_clashes(at, found)
    elif found.keys() != before.keys():
        names, expected = (", ".join(map(validation.shown, each)) or "none" for each in (found, before))
        raise ValueError(f"{at} got the names {names}, must be those of the previous sample: {expected}")
    else:
        for name, array in found.items():
            shape = before[name].shape
            if array.shape != shape:
                raise ValueError(
                    f"{at} got {name!r} of shape {array.shape}, must be {shape} as at the previous sample"
                )
        found = {name: found[name] for name in before}
    return found


def _array(at: str, name: Any, value: Any) -> NDArray[Any]:
    if not isinstance(name, str) or not name:
        raise ValueError(f"{at} got the name {validation.shown(name)}, must be a non-empty text")
    try:
        array = np.array(value)  # a copy, because the function may reuse its array
    except Exception:  # a failing conversion may raise anything
        array = np.array(None)
    if array.dtype.kind not in "buif":
        raise ValueError(f"{at} got {validation.shown(value)} for {name!r}, must be a number or numbers")
    return array


def dims(name: str, array: NDArray[Any]) -> list[str]:
    """Names of the dimensions of a value in a Dataset: name_0, name_1, …"""
    return [f"{name}_{i}" for i in range(array.ndim)]


def _refuse_clashes(at: str, values: Values) -> None:
    taken = {*OBSERVABLES, *RESERVED}
    for name, array in values.items():
        clashes = taken & {name, *dims(name, array)}
        if clashes:
            shown = validation.shown(name)
            raise ValueError(
                f"{at} got the name {shown}, must be another one: {min(clashes)!r} is in the series already"
            )
        taken |= {name, *dims(name, array)}


def collected(values: Sequence[Values]) -> Values:
    """Stack the values of all samples: one array for each name."""
    return {name: np.stack([one[name] for one in values]) for name in (values[0] if values else ())}


def variables(values: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    return {name: (["time", *dims(name, array[0])], array.copy()) for name, array in values.items()}


def split(values: Values, n: int) -> Iterable[Values]:
    """The values of each of ``n`` samples: the inverse of :func:`collected`."""
    return [{name: array[k] for name, array in values.items()} for k in range(n)]
