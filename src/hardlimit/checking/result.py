"""The answer of :func:`hardlimit.check`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from ..boxes.error_law import KNOWN_RULES
from ..boxes.time_step import DEFAULT_ERROR
from ..support import html
from ..support.formatting import digits
from .at_rest import GAS, GrainState
from .contacts import CheckedContact
from .dumps import State

if TYPE_CHECKING:
    import xarray as xr

#: The question that a verdict answers.
QUESTION = "May an event-driven simulation replace this?"
#: Fields of a contact that are numbers, with their units.
NUMBERS = {
    "radius": "m",
    "other_radius": "m",
    "density": "kg/m3",
    "restitution_asked": "1",
    "restitution": "1",
    "speed": "m/s",
    "duration": "s",
    "steps_per_contact": "1",
    "restitution_error_of_step": "1",
    "time_step": "s",
    "rayleigh_time": "s",
    "p_wave_time": "s",
    "largest_overlap": "1",
    "tc_nu": "1",
    "delta_over_d": "1",
    "heated_error": "1",
    "heated_error_bar": "1",
    "sheared_error": "1",
    "sheared_error_bar": "1",
    "frictionless_error": "1",
    "smooth_error": "1",
    "temperature_ratio": "1",
    "softening": "1",
    "softened_overlap": "1",
}
#: Numbers of the friction of a contact in the Dataset: their fields, and their units.
FRICTION = {
    "friction": ("coefficient", "1"),
    "tangential_stiffness_ratio": ("stiffness_ratio", "1"),
    "tangential_damping_ratio": ("damping_ratio", "1"),
    "sticks_below": ("sticks_below", "rad"),
    "slides_beyond": ("slides_beyond", "rad"),
    "effective_tangential_restitution": ("effective_tangential_restitution", "1"),
    "tangential_half_period": ("half_period", "1"),
    "steps_per_half_period": ("steps_per_half_period", "1"),
    "tangential_restitution_error_of_step": ("tangential_restitution_error_of_step", "1"),
}


class Finding(NamedTuple):
    """Something in a script, and the types of grains that it concerns; returned by :func:`hardlimit.check`."""

    what: str  #: in a few words
    types: tuple[str, ...] | None = None  #: None for all
    where: str = ""  #: quoted with its line
    minor: bool = False  #: a warning of what changes β by less than 0.02 in these contacts

    def to_dict(self) -> dict[str, Any]:
        """As plain values.

        :meta private:
        """
        return {"what": self.what, "types": typed(self.types), "where": self.where or None}


class Inferred(NamedTuple):
    """A number that follows from what a script says; returned by :func:`hardlimit.check`."""

    what: str  #: "speed" or "packing fraction"
    value: float  #: in SI units; of a script in ``lj`` units, as there
    unit: str  #: of the value; empty without one
    source: str  #: where it comes from, in words
    decides: bool  #: whether the answer depends on it; if not, it is an estimate for the numbers of contacts

    def __str__(self) -> str:
        number = f"{digits(self.value, 3)} {self.unit}".rstrip()
        return f"{self.what[0].upper()}{self.what[1:]} {number}: {self.source}."


class CheckedStage(NamedTuple):
    """A run of a script; returned by :func:`hardlimit.check`."""

    number: int  #: from 1
    command: str  #: quoted with its line
    time_step: float | None  #: [s]
    steps: int | None  #: number of steps
    gravity: float | None  #: [m/s²]
    units: str  #: in which the script gives its numbers
    shaking: float | None  #: Γ = A ω²/g of what holds the grains


@dataclass(frozen=True)
class Verdict:
    """Whether an event-driven simulation may replace a simulation, and what that one does; returned by :func:`check`.

    Numbers are in SI units, those of runs in ``lj`` units as they are there. None stands for what is not known.
    """

    admissible: bool | None  #: None if it cannot be said
    sentence: str  #: the answer, with the number that decides
    code: str | None  #: None without a script
    version: str | None  #: as it is given, or as a log states it
    units: str  #: of the last run
    units_given: bool  #: False if they are the code's default
    time_step: float | None  #: of the last run [s]
    numerical_damping: float | None  #: of the last run
    rows: tuple[CheckedContact, ...]  #: one for each contact, size and speed
    stages: tuple[CheckedStage, ...]  #: the runs of the script
    states: tuple[State, ...]  #: of the frames of the dump
    checked: tuple[Finding, ...]  #: what the answer is based on
    ignored: tuple[Finding, ...]  #: head-on restitution stands
    invalidates: tuple[Finding, ...]  #: not possible in an event-driven simulation
    unknown: tuple[Finding, ...]  #: statements that were not understood, quoted
    missing: tuple[str, ...]  #: what would have to be known for an answer
    remarks: tuple[str, ...]  #: on ε, the time step and versions of the code
    warnings: tuple[Finding, ...]  #: what friction does that is rarely meant
    corrected: tuple[str, ...]  #: lines for the script, ready to paste
    quantity: str | None = "cooling"  #: whose error decides: also "temperature", "stress"; None without law
    restitution_error: float = DEFAULT_ERROR  #: of ε, that the corrected time step causes
    speeds_chosen: bool = False  #: whether the speeds of the contacts are examples, because none is given
    state: GrainState = GAS  #: how grains are held together, at the last run
    question: str = QUESTION  #: that the sentence answers
    inferred: tuple[Inferred, ...] = ()  #: what follows from the script, and is not given beside it

    @cached_property
    def contacts(self) -> xr.Dataset:
        """The contacts along one dimension; NaN stands for what is not known. ``error`` is that of cooling [1]."""
        import xarray as xr

        def column(name: str) -> list[float]:
            return _numbers(getattr(row, name) for row in self.rows)

        plain = [self.has_plain(row) for row in self.rows]

        def unit(name: str) -> str:
            return "1" if all(plain) else f"{name}, 1 where units are lj" if any(plain) else name

        variables = {name: ("contact", column(name), {"units": unit(u)}) for name, u in NUMBERS.items()}
        variables |= {
            name: ("contact", _numbers(getattr(row.friction, field) for row in self.rows), {"units": u})
            for name, (field, u) in FRICTION.items()
        }
        pairs = [[row.error.get(rule, (math.nan, math.nan)) for rule in KNOWN_RULES] for row in self.rows]
        texts = {
            "types": ["–".join(row.types) for row in self.rows],
            "wall": [row.wall or "" for row in self.rows],
            "model": [row.model or "" for row in self.rows],
        }
        return xr.Dataset(
            {
                **variables,
                "clipped": ("contact", column("clipped")),
                "stage": ("contact", [row.stage for row in self.rows]),
                "error": (("contact", "rule"), [[value for value, _ in pair] for pair in pairs]),
                "error_bar": (("contact", "rule"), [[bar for _, bar in pair] for pair in pairs]),
            }
            if self.rows
            else {},
            coords={**{name: ("contact", text) for name, text in texts.items()}, "rule": list(KNOWN_RULES)},
            attrs={"sentence": self.sentence, "code": self.code or "", "units": self.units},
        )

    def has_plain(self, row: CheckedContact) -> bool:
        """Whether the numbers of a contact are in ``lj`` units.

        :meta private:
        """
        return bool(self.stages) and self.stages[row.stage - 1].units == "lj"

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain values, as ``hardlimit check --json`` prints it.

        Returns
        -------
        dict
        """
        return {
            "code": self.code,
            "version": self.version,
            "units": self.units,
            "time_step": self.time_step,
            "contacts": [_contact(row) for row in self.rows],
            "numerical_damping": self.numerical_damping,
            "stages": [stage._asdict() for stage in self.stages],
            "dump": [_state(state) for state in self.states],
            "checked": [finding.to_dict() for finding in self.checked],
            "ignored": [finding.to_dict() for finding in self.ignored],
            "invalidates": [finding.to_dict() for finding in self.invalidates],
            "unknown": [finding.where or finding.what for finding in self.unknown],
            "missing": list(self.missing),
            "remarks": list(self.remarks),
            "warnings": [finding.to_dict() for finding in self.warnings],
            "corrected": list(self.corrected),
            "quantity": self.quantity,
            "restitution_error": self.restitution_error,
            "speeds_chosen": self.speeds_chosen,
            "state": self.state.to_dict(),
            "inferred": [number._asdict() for number in self.inferred],
            "admissible": self.admissible,
            "question": self.question,
            "sentence": self.sentence,
        }

    def __str__(self) -> str:
        return f"{self.question} {self.sentence}"

    def __repr__(self) -> str:
        return f"<Verdict: {self.sentence}>"

    def _repr_html_(self) -> str:
        head = ["contact", "speed", "ε", "duration", "t_c ν"]
        rows = [
            ["–".join(row.types), *(digits(math.nan if v is None else v, 4) for v in _shown(row))]
            for row in self.rows
        ]
        return html.table("Check of the contacts", head, rows, self.sentence)


def _numbers(values: Iterable[float | None]) -> list[float]:
    return [math.nan if value is None else float(value) for value in values]


def _shown(row: CheckedContact) -> Sequence[float | None]:
    return row.speed, row.restitution, row.duration, row.tc_nu


def typed(types: Sequence[str] | None) -> list[int | str] | None:
    """Types for JSON: numbers where they are numbers."""
    return None if types is None else [int(name) if name.isdecimal() else name for name in types]


def _contact(row: CheckedContact) -> dict[str, Any]:
    plain = {name: getattr(row, name) for name in NUMBERS}
    return {
        "types": typed(row.types),
        "stage": row.stage,
        "wall": row.wall,
        "model": row.model,
        "clipped": row.clipped,
        **plain,
        "friction": row.friction.to_dict(),
        "rule": row.rule,
        "extrapolated": row.extrapolated,
        "other_versions": [version._asdict() for version in row.other_versions],
        "error": {rule: list(pair) for rule, pair in row.error.items()},
    }


def _state(state: State) -> dict[str, Any]:
    named = {name: getattr(state, name) for name in State.__dataclass_fields__}
    return {**named, "impact_speeds": list(state.speeds)}
