"""Contact laws and one contact between two bodies.

The laws themselves are C++ headers (``core/contact``); this module turns their records into Python classes
and hands the physics back to the core.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, validation
from .bodies import FLOOR, Ball, Floor

RESTITUTION: Final = "restitution"


class Contact:
    """One contact of two bodies under a law.

    The law's own constants are attributes: ``stiffness`` and ``damping`` (linear), ``elastic_prefactor`` ρ and
    ``dissipative_time`` A (viscoelastic).
    """

    def __init__(self, law: Law, core: _core.Contact) -> None:
        self.law = law
        self.core = core
        names = law.record["contact_parameters"]
        self._constants: dict[str, float] = dict(zip(names, core.values(), strict=True))

    def __getattr__(self, name: str) -> float:
        constants = self.__dict__.get("_constants", {})
        if name in constants:
            return float(constants[name])
        raise AttributeError(
            f"{type(self).__name__} of a {type(self.law).__name__} has no attribute {name!r}"
        )

    def __repr__(self) -> str:
        inner = ", ".join(f"{k}={v:.6g}" for k, v in self._constants.items())
        return f"Contact({inner}, effective_mass={self.effective_mass:.6g})"

    @property
    def effective_mass(self) -> float:
        """m_i m_j/(m_i + m_j) [kg]."""
        return self.core.effective_mass

    @property
    def effective_radius(self) -> float:
        """R_i R_j/(R_i + R_j) [m]."""
        return self.core.effective_radius

    def restitution(self, speed: ArrayLike = 1.0) -> Any:
        """Coefficient of restitution of an isolated collision at ``speed`` [m/s], same shape (Eqs. 13, B3)."""
        return _over_speeds(self.core.restitution, speed)

    def duration(self, speed: ArrayLike = 1.0) -> Any:
        """Time from first touch to zero force [s] of one isolated collision at ``speed`` [m/s] (Eq. 11)."""
        return _over_speeds(self.core.duration, speed)

    def force(self, compression: ArrayLike, rate: ArrayLike = 0.0) -> Any:
        """Repulsive force [N], never below zero, at ``compression`` ξ [m] and ``rate`` dξ/dt [m/s] (Eqs. 7, B1)."""
        xi, speed = np.broadcast_arrays(_finite("compression", compression), _finite("rate", rate))
        flat = self.core.force(np.ascontiguousarray(xi.ravel()), np.ascontiguousarray(speed.ravel()))
        return _as_given(flat, xi.shape)

    def energy(self, compression: ArrayLike) -> Any:
        """Energy stored at ``compression`` ξ [m], in J."""
        xi = _finite("compression", compression)
        return _as_given(self.core.energy(np.ascontiguousarray(xi.ravel())), xi.shape)


def _finite(name: str, values: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name}: got {array[~np.isfinite(array)].flat[0]:g}, must be finite")
    return array


def _as_given(flat: NDArray[np.float64], shape: tuple[int, ...]) -> Any:
    return float(flat[0]) if shape == () else flat.reshape(shape)


def _over_speeds(function: Any, speed: ArrayLike) -> Any:
    array = _finite("speed", speed)
    if not np.all(array > 0.0):
        raise ValueError(f"speed: got {array[array <= 0.0].flat[0]:g}, must be > 0 and finite")
    return _as_given(function(np.ascontiguousarray(array.ravel())), array.shape)


class Law:
    """A contact law with the user's parameters. ``laws`` makes one subclass for each record of the core."""

    record: ClassVar[dict[str, Any]]
    parameters: Mapping[str, float]  #: as given, in the record's order
    alternative: int  #: which set of alternatives was given

    def __init__(self, **given: float | None) -> None:
        record = self.record
        common = record["common"]
        choices = record["alternatives"]
        named = {k: v for k, v in given.items() if v is not None}
        known = [p["name"] for p in common] + [p["name"] for choice in choices for p in choice]
        for name in named:
            if name not in known:
                raise ValueError(
                    f"{name}: unknown, {type(self).__name__} takes {', '.join(dict.fromkeys(known))}"
                )
        for p in common:
            if p["name"] not in named:
                raise ValueError(f"{p['name']}: missing, must be {_range_of(p)}")
        rest = set(named) - {p["name"] for p in common}
        matching = [i for i, choice in enumerate(choices) if {p["name"] for p in choice} == rest]
        if len(matching) != 1:
            wanted = " | ".join(" + ".join(p["name"] for p in choice) for choice in choices)
            got = ", ".join(sorted(rest)) if rest else "neither"
            raise ValueError(f"{wanted}: got {got}, must be exactly one of these alternatives")
        checked = {
            p["name"]: validation.number(
                p["name"],
                named[p["name"]],
                p["lowest"],
                p["highest"],
                lowest_allowed=p["lowest_allowed"],
                highest_allowed=p["highest_allowed"],
            )
            for p in [*common, *choices[matching[0]]]
        }
        self.__dict__.update(alternative=matching[0], parameters=MappingProxyType(checked))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a law does not change, replace({name}=…) makes another one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a law does not change")

    def __reduce__(self) -> tuple[Any, ...]:
        return _law, (type(self), dict(self.parameters))

    def __getattr__(self, name: str) -> float:
        parameters = self.__dict__.get("parameters", {})
        if name in parameters:
            return float(parameters[name])
        raise AttributeError(f"{type(self).__name__} has no parameter {name!r}")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.parameters.items())})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and type(self) is type(other) and self.parameters == other.parameters

    def __hash__(self) -> int:
        return hash((type(self).__name__, tuple(self.parameters.items())))

    def replace(self, **changes: float) -> Self:
        """The law with some parameters changed; naming another alternative drops the present one."""
        record = self.record
        kept = dict(self.parameters)
        for i, choice in enumerate(record["alternatives"]):
            names = {p["name"] for p in choice}
            if i != self.alternative and names & set(changes) - set(self.parameters):
                for p in record["alternatives"][self.alternative]:
                    kept.pop(p["name"], None)
        return type(self)(**(kept | changes))

    @property
    def specified_restitution(self) -> float:
        """The one ε given for all contacts, or NaN if the law was given by material constants."""
        return self.parameters.get(RESTITUTION, math.nan)

    def between(self, ball: Ball, other: Ball | Floor = FLOOR) -> Contact:
        """The contact of two bodies; ``other`` is a Ball or FLOOR."""
        for body in (ball, other):
            if not isinstance(body, Ball | Floor):
                raise ValueError(f"between: got {body!r}, must be a Ball or FLOOR")
        core = _core.make_contact(
            self.record["name"],
            self.alternative,
            list(self.parameters.values()),
            _core.effective(ball.mass, other.mass),
            _core.effective(ball.radius, other.radius),
        )
        return Contact(self, core)


def law_parameters(law: type[Law]) -> dict[str, dict[str, Any]]:
    """The records of all parameters that a law knows, by name."""
    choices = law.record["alternatives"]
    return {p["name"]: p for p in [*law.record["common"], *(p for choice in choices for p in choice)]}


def _law(kind: type[Law], parameters: dict[str, float]) -> Law:
    return kind(**parameters)


def _range_of(parameter: dict[str, Any]) -> str:
    return validation.describe_range(
        parameter["lowest"], parameter["highest"], parameter["lowest_allowed"], parameter["highest_allowed"]
    )


def make_law(record: dict[str, Any]) -> type[Law]:
    """The Python class of one registered law."""
    lines = [record["summary"], "", "Parameters", "----------"]
    alternatives = record["alternatives"]
    for p in record["common"]:
        lines += [f"{p['name']} : float [{p['unit']}]", f"    {p['meaning']}; {_range_of(p)}."]
    for i, choice in enumerate(alternatives):
        for p in choice:
            lines += [
                f"{p['name']} : float [{p['unit']}]",
                f"    {p['meaning']}; {_range_of(p)}. Alternative {i + 1} of {len(alternatives)}.",
            ]
    lines += [
        "",
        "Raises",
        "------",
        "ValueError",
        "    If a value is outside its range or not exactly one alternative is given.",
    ]
    lines += ["", f"Source: {record['source']}."]
    return type(
        record["class_name"],
        (Law,),
        {"record": record, "__doc__": "\n".join(lines), "__module__": "hardlimit"},
    )
