"""Candidates of a fit: a law with its free parameters and the fixed values of the others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from ..contact.balls import FLOOR, Ball, Floor
from ..contact.contact import RESTITUTION, Law, check_parameter, law_parameters
from ..contact.laws import LAWS
from ..support import validation

Floats = NDArray[np.float64]

#: Values of parameters on which the data do not depend, by unit.
NEUTRAL: Final = {"N/m": 1e6, "Pa": 1e9, "N/m^1.5": 1e9, "N s/m": 1.0, "s": 1e-6}
#: Range of the starting grid of a positive parameter in powers of ten, by unit.
DECADES: Final = {"N/m": (1, 12), "Pa": (3, 13), "N/m^1.5": (2, 14), "N s/m": (-6, 6), "s": (-12, 0)}
DEFAULT_DECADES: Final = (-6, 6)
#: Default of Poisson's ratio. Contacts depend on Y/(1 − ν²) only.
DEFAULT_POISSON_RATIO: Final = 0.3
POISSON_RATIO: Final = "poisson_ratio"
IMPACT_SPEED: Final = "impact_speed"
#: Lower limit of a fitted coefficient of restitution.
LEAST_RESTITUTION: Final = 1e-3
#: Degree of the polynomial of ε in ln v, and its margin beyond the data.
DEGREE: Final = 20
MARGIN: Final = 0.05
#: Ball for fits of ε alone, which do not depend on it.
ANY_BALL: Final = Ball(0.01, density=1000.0)


@dataclass(frozen=True)
class Free:
    """A free parameter: its range, and whether the fit varies its logarithm."""

    name: str
    unit: str
    lowest: float
    highest: float
    logarithmic: bool

    def inner(self, value: float) -> float:
        """The variable of the fit for a value of the parameter."""
        return math.log(value) if self.logarithmic else value

    def outer(self, variable: float) -> float:
        """The value of the parameter for a variable of the fit."""
        return math.exp(variable) if self.logarithmic else variable

    @property
    def limits(self) -> tuple[float, float]:
        """Limits of the fitted variable."""
        if self.logarithmic:
            return -690.0, 690.0  # within the range of a double
        return self.lowest, self.highest

    def grid(self) -> Floats:
        """Values of the starting grid."""
        if not self.logarithmic:
            return np.linspace(self.lowest, self.highest, 17)[1:-1]
        low, high = DECADES.get(self.unit, DEFAULT_DECADES)
        return np.logspace(low, high, 2 * (high - low) + 1)


@dataclass(frozen=True)
class Candidate:
    """A law and a model of collisions with free parameters."""

    law: type[Law]
    model: str  #: "newton" or "independent"
    free: tuple[Free, ...]
    constants: Mapping[str, float]  #: values of the other parameters
    notes: tuple[str, ...]  #: parameters held at a value, and why; one sentence each
    ball: Ball
    other: Ball | Floor
    alike: tuple[str, ...] = ()  #: laws with a constant ε, which impacts cannot distinguish

    @property
    def name(self) -> str:
        """Name in tables."""
        if self.model != "newton":
            return "collisions with one ε"
        return f"one ε ({', '.join(self.alike)})" if self.alike else str(self.law.record["name"])

    def made(self, values: Sequence[float]) -> Law:
        """The law with these values of the free parameters."""
        values_of_law = dict(self.constants) | {p.name: v for p, v in zip(self.free, values, strict=True)}
        return self.law(
            **{name: values_of_law[name] for name in law_parameters(self.law) if name in values_of_law}
        )

    def curve(self, law: Law, slowest: float, fastest: float) -> Chebyshev:
        """ε of one impact as a polynomial in ln v between these speeds [m/s], with an error below 1e-9."""
        contact = law.between(self.ball, self.other)
        ends = [math.log(slowest) - MARGIN, math.log(fastest) + MARGIN]
        return Chebyshev.interpolate(
            lambda x: np.asarray(contact.restitution(np.exp(x))), DEGREE, domain=ends
        )


def candidate(
    law: str | type[Law],
    kind: str,
    reference_speed: float,
    fixed: Mapping[str, float],
    free: Sequence[str] | None,
    ball: Ball | None,
    other: Ball | Floor,
    model: str = "newton",
) -> Candidate:
    """Choose the set of parameters of the law, and which of them are free.

    Of the sets with all given names, one with ``restitution`` is preferred, because impacts measure ε. The remaining
    parameters are free for rebounds, one of them for impacts.

    Raises a ValueError if no set of parameters of the law has all the names, or none is left free.
    """
    chosen = _law(law)
    known = law_parameters(chosen)
    names = set(fixed) | set(free or ())
    for name in names:
        if name not in known:
            raise ValueError(
                f"fixed | free: got {name}, must be parameters of {chosen.__name__}: {', '.join(known)}"
            )
    values = {name: check_parameter(known[name], value) for name, value in fixed.items()}
    both = sorted(set(values) & set(free or ()))
    if both:
        raise ValueError(f"fixed | free: got {both[0]} in both, must be in at most one of them")
    parameters = _alternative(chosen, names)
    wanted = _free_names(parameters, kind, values, free)
    if not wanted:
        raise ValueError(f"fixed | free: got no free parameter, must leave one of {chosen.__name__}")
    constants, notes = _held(parameters, kind, wanted, values, reference_speed)
    if kind == "impacts" and ball is None and wanted != [RESTITUTION]:
        raise ValueError(f"ball: missing, must be given to fit {', '.join(wanted)}")
    variables = tuple(_variable(known[name]) for name in wanted)
    constant = [name for name, law_class in LAWS.items() if _has_constant_restitution(law_class)]
    alike = tuple(constant) if kind == "impacts" and _has_constant_restitution(chosen) else ()
    return Candidate(
        law=chosen,
        model=model,
        free=variables,
        constants=constants,
        notes=notes,
        ball=ball or ANY_BALL,
        other=other,
        alike=alike,
    )


def _has_constant_restitution(law: type[Law]) -> bool:
    """Whether the law has a parameter ε that does not depend on speed."""
    parameters = law_parameters(law)
    return RESTITUTION in parameters and IMPACT_SPEED not in parameters


def _law(law: Any) -> type[Law]:
    if isinstance(law, type) and issubclass(law, Law) and law in LAWS.values():
        return law
    name = law.__name__ if isinstance(law, type) else law
    return LAWS[validation.one_of("law", name, tuple(LAWS))]


def _alternative(law: type[Law], names: set[str]) -> dict[str, Any]:
    """The records of the chosen set of parameters, by name."""
    common = {p["name"]: p for p in law.record["common"]}
    choices = [common | {p["name"]: p for p in choice} for choice in law.record["alternatives"]]
    able = [choice for choice in choices if names <= set(choice)]
    if not able:
        raise ValueError(
            f"fixed | free: got {', '.join(sorted(names))}, must be of one set of parameters of {law.__name__}: "
            + " | ".join(", ".join(choice) for choice in choices)
        )
    # With both elastic constants given, the dissipative parameter is fitted instead of ε.
    elastic = {"youngs_modulus", POISSON_RATIO} <= names
    preferred = (choice for choice in able if (RESTITUTION in choice) != elastic)
    return next(preferred, None) or next((choice for choice in able if RESTITUTION in choice), able[0])


def _free_names(
    parameters: Mapping[str, Any], kind: str, fixed: Mapping[str, float], free: Sequence[str] | None
) -> list[str]:
    if free is not None:
        return [name for name in parameters if name in free]
    left = [name for name in parameters if name not in fixed and name not in (POISSON_RATIO, IMPACT_SPEED)]
    if kind == "impacts":
        return [RESTITUTION] if RESTITUTION in left else left[-1:]
    return left


def _held(
    parameters: Mapping[str, Any],
    kind: str,
    wanted: Sequence[str],
    fixed: Mapping[str, float],
    reference_speed: float,
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Values of the parameters that are not free, and a sentence for each that was not given."""
    constants, notes = dict(fixed), []
    for name, record in parameters.items():
        if name in wanted or name in fixed:
            continue
        if name == IMPACT_SPEED:
            constants[name] = reference_speed
            notes.append(f"restitution is that at {reference_speed:g} m/s (impact_speed)")
        elif name == POISSON_RATIO:
            constants[name] = DEFAULT_POISSON_RATIO
            notes.append(
                f"poisson_ratio held at {DEFAULT_POISSON_RATIO:g}: only Y/(1 − ν²) enters a contact"
                if kind == "rebounds"
                else "poisson_ratio has no effect on the data"
            )
        else:
            constants[name] = NEUTRAL.get(record["unit"], 1.0)
            notes.append(
                f"{name} has no effect on the data"
                if wanted == [RESTITUTION] and kind == "impacts"
                else f"{name} held at {constants[name]:g} {record['unit']}"
            )
    return constants, tuple(notes)


def _variable(record: Mapping[str, Any]) -> Free:
    bounded, lowest = math.isfinite(record["highest"]), record["lowest"]
    lowest = LEAST_RESTITUTION if bounded and lowest == 0.0 else lowest
    return Free(record["name"], record["unit"], lowest, record["highest"], not bounded)


def rivals(
    chosen: Candidate, kind: str, reference_speed: float, fixed: Mapping[str, float]
) -> list[Candidate]:
    """The other laws, and for rebounds independent collisions with one ε.

    For impacts all laws with a constant ε are one candidate.
    """
    candidates: list[Candidate] = []
    for law in LAWS.values():
        if law is chosen.law or any(law.record["name"] in rival.alike for rival in (chosen, *candidates)):
            continue
        common = {p["name"] for p in law.record["common"]}
        shared = {k: v for k, v in fixed.items() if k == POISSON_RATIO and k in common}
        candidates.append(
            candidate(
                law=law,
                kind=kind,
                reference_speed=reference_speed,
                fixed=shared,
                free=None,
                ball=chosen.ball,
                other=chosen.other,
            )
        )
    if kind == "rebounds":
        linear, constants = LAWS["linear"], {"stiffness": NEUTRAL["N/m"]}
        candidates.append(
            candidate(
                law=linear,
                kind=kind,
                reference_speed=reference_speed,
                fixed=constants,
                free=None,
                ball=chosen.ball,
                other=FLOOR,
                model="independent",
            )
        )
    return candidates
