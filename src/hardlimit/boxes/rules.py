"""Collision rules of hard spheres: a record for each, and the choice of the rule of a run."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, NamedTuple

from .. import _core
from ..contact.contact import Law
from ..contact.friction import Friction
from ..contact.laws import LAWS
from ..support import validation
from .contacts import checked_law, rubs


class Rule(NamedTuple):
    """A collision rule, from its record in the core."""

    name: str  #: as in ``rule=`` and in the core
    takes: tuple[str, ...]  #: the arguments that may give the restitution, exactly one of them
    meaning: str  #: the effect of a collision
    assumes: str  #: the condition under which the rule is right
    source: str
    counts: tuple[str, ...]  #: attributes of a result that count how often the rule did something special
    share: str  #: what the last of these, a share of the collisions, means
    knows_duration: bool  #: whether it knows the duration of contacts
    error: str  #: the rule of the law of the error with the same error; empty if that is not known
    parameters: Mapping[str, str]  #: units of its own parameters by name; their values are ≥ 0

    @property
    def has_constant_restitution(self) -> bool:
        """Whether ε cannot depend on the speed."""
        return self.takes == ("restitution",)


def _rule(record: Mapping[str, Any]) -> Rule:
    same = ("name", "meaning", "assumes", "source", "counts", "share", "knows_duration", "error")
    return Rule(
        **{name: record[name] for name in same},
        takes=tuple(argument for argument in ("restitution", "law") if record[argument]),
        parameters={parameter["name"]: parameter["unit"] for parameter in record["parameters"]},
    )


#: The default rule for each argument.
DEFAULTS: Final = {"restitution": "constant", "law": "law"}
#: Rules by name, the defaults first.
RULES: Final = {
    record["name"]: _rule(record)
    for record in sorted(_core.rules, key=lambda record: record["name"] not in DEFAULTS.values())
}
#: Units of the parameters of all rules by their names, which are arguments of :func:`hardlimit.event_driven`.
PARAMETERS: Final = {name: unit for rule in RULES.values() for name, unit in rule.parameters.items()}


def law_entry(law: Law | None) -> list[Any] | None:
    """Name, parameters and friction of a law, for a JSON file."""
    if law is None:
        return None
    rubbing = [] if law.friction is None else [asdict(law.friction)]
    return [law.record["name"], dict(law.parameters), *rubbing]


def law_from(entry: Sequence[Any] | None) -> Any:
    """The law from :func:`law_entry`."""
    if entry is None:
        return None
    name, parameters, *rubbing = entry
    friction = {"friction": Friction(**rubbing[0])} if rubbing else {}
    return LAWS[name](**parameters, **friction)


@dataclass(frozen=True)
class Settings:
    """The collision rule of a run and its parameters; made by :func:`hardlimit.event_driven`."""

    rule: str  #: name of the rule
    restitution: float | None  #: constant ε, or None if a law gives ε
    law: Law | None  #: contact law that gives ε, or None
    parameters: Mapping[str, float]  #: those of the rule, in the order of its record
    friction: float | None = None  #: coefficient of friction μ; None without, and if a law gives it
    tangential_restitution: float | None = None  #: β without sliding; None without ``friction``

    @property
    def contact_duration(self) -> float | None:
        """t_c of the rule tc [s]; None for other rules."""
        return self.parameters.get("contact_duration")

    @property
    def has_friction(self) -> bool:
        """Whether collisions change spins."""
        return bool(self.friction) or (self.law is not None and rubs(self.law))

    def report(self, of_law: Callable[[Law], str] = repr) -> str:
        """One line for a table or an attribute, such as ``tc, restitution 0.8, contact duration 1e-05 s``.

        :meta private:
        """
        parts = [self.rule]
        parts += [] if self.restitution is None else [f"restitution {self.restitution:g}"]
        if self.friction is not None:
            parts.append(
                f"friction {self.friction:g}, tangential restitution {self.tangential_restitution:g}"
            )
        parts += [] if self.law is None else [of_law(self.law)]
        for name, value in self.parameters.items():
            unit = "" if PARAMETERS[name] == "1" else f" {PARAMETERS[name]}"
            parts.append(f"{name.replace('_', ' ')} {value:g}{unit}")
        return ", ".join(parts)

    def entry(self) -> dict[str, Any]:
        """For a JSON file; None for a parameter of another rule.

        :meta private:
        """
        return {
            "rule": self.rule,
            "restitution": self.restitution,
            "law": law_entry(self.law),
            **{name: self.parameters.get(name) for name in PARAMETERS},
            "friction": self.friction,
            "tangential_restitution": self.tangential_restitution,
        }

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any]) -> Settings:
        """The settings from :meth:`entry`.

        :meta private:
        """
        others = {name: value for name, value in entry.items() if name not in PARAMETERS}
        parameters = {name: entry[name] for name in RULES[entry["rule"]].parameters}
        return cls(**{**others, "law": law_from(entry["law"])}, parameters=parameters)


def checked_settings(
    law: Any = None,
    restitution: Any = None,
    rule: Any = None,
    friction: Any = None,
    tangential_restitution: Any = None,
    **parameters: Any,
) -> Settings:
    """The rule of a run, from arguments of :func:`hardlimit.event_driven`; ``parameters`` are those of all rules."""
    for name in parameters:
        if name not in PARAMETERS:
            raise TypeError(f"event_driven() got an unexpected keyword argument {name!r}")
    parameter = validation.exactly_one(law=law, restitution=restitution)
    if parameter == "law":
        checked_law(law)
    allowed = [record.name for record in RULES.values() if parameter in record.takes]
    chosen = DEFAULTS[parameter] if rule is None else validation.one_of("rule", rule, sorted(RULES))
    if chosen not in allowed:
        raise ValueError(f"rule: got {rule!r}, must be one of {', '.join(allowed)} with {parameter}")
    if parameter == "restitution":
        limits = {"lowest_allowed": True, "highest_allowed": True}
        restitution = validation.number("restitution", restitution, 0.0, 1.0, **limits)
    own = _checked_parameters(chosen, parameters)
    return Settings(
        chosen, restitution, law, own, *_checked_friction(parameter, friction, tangential_restitution)
    )


def _checked_parameters(rule: str, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Those of the rule; the others must be None."""
    own = {}
    for name in RULES[rule].parameters:
        if parameters.get(name) is None:
            raise ValueError(f"{name}: missing, must be >= 0 for the rule {rule}")
        own[name] = validation.number(name, parameters[name], 0.0, lowest_allowed=True)
    for name, value in parameters.items():
        if value is not None and name not in own:
            raise ValueError(f"{name}: got {validation.shown(value)}, must be left out for the rule {rule}")
    return own


def _checked_friction(
    parameter: str, friction: Any, tangential_restitution: Any
) -> tuple[float | None, float | None]:
    """μ and β of a run with a constant restitution."""
    both = {"friction": friction, "tangential_restitution": tangential_restitution}
    if parameter == "law":
        for name, value in both.items():
            if value is not None:
                shown = validation.shown(value)
                raise ValueError(f"{name}: got {shown}, must be left out with a law, whose friction= says it")
        return None, None
    missing = [name for name, value in both.items() if value is None]
    if len(missing) == 2:
        return None, None
    if missing:
        raise ValueError(
            f"{missing[0]}: missing, must be given with {next(n for n in both if n not in missing)}="
        )
    limits = {"lowest_allowed": True, "highest_allowed": True}
    coefficient = math.inf
    if not (isinstance(friction, float) and friction == math.inf):
        coefficient = validation.number("friction", friction, 0.0, lowest_allowed=True, highest_allowed=True)
    return coefficient, validation.number(
        "tangential_restitution", tangential_restitution, -1.0, 1.0, **limits
    )
