"""Normal contact models of particle codes, read from a data file for each code in the folder ``codes``.

The force of a model is F = K ξ^p + C ξ^q dξ/dt. The file gives p and q, how the code computes K and C, whether the
force may attract, and how its input is written and read. To add a code, add a file.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache
from importlib import resources
from typing import Any, Final, Literal

from ..support import toml, validation
from .force import Force, Powers
from .formulas import DEFAULT_POISSON_RATIO, FORMULAS, SPRINGS, Numbers, Where, inverse

#: Largest number of models that a message lists.
MAX_NAMES: Final = 8
#: Four times p of the elastic force.
ELASTIC: Final = {"hooke": 4, "hertz": 6}


@dataclass(frozen=True)
class Spring:
    """K = factor · X · R^radius; ``given`` is the key in ``SPRINGS`` of the formula for X."""

    given: str
    factor: float = 1.0
    wall_factor: float | None = None  #: at a wall, if different
    radius: float = 0.0
    shortest: float = 0.0  #: √(m/K) [s] below which the code uses another spring


@dataclass(frozen=True)
class Damping:
    """C = factor · f(number) · m^mass · K^stiffness · R^radius, with f from ``FORMULAS``; q = power."""

    number: str  #: its name in the input; empty without damping
    formula: str = "given"
    factor: float = 1.0
    mass: float = 0.0
    stiffness: float = 0.0
    radius: float = 0.0
    power: float = 0.0
    tolerance: float = 1e-9  #: accuracy of ε, limited by the code's own rounding of the formula


@dataclass(frozen=True)
class Mass:
    """The mass in the code's formulas, if it is not the effective mass of the contact."""

    wall_factor: float = 1.0  #: relative to the effective mass at a wall
    number: str = ""  #: name in the input, if the user gives it
    share: float = 1.0  #: effective mass divided by that number


@dataclass(frozen=True)
class Extra:
    """A line that the code requires if a number is above or below a limit."""

    number: str
    line: str
    above: float = math.inf
    below: float = -math.inf


@dataclass(frozen=True)
class TangentialInput:
    """How a contact of a code gets friction; returned by :func:`hardlimit.convert`.

    In ``words``, {friction} is μ, {friction_angle} its angle [rad], and other numbers of the tangential model begin
    with ``tangential_``. The number ``free`` sets the tangential restitution. k_t is in proportion to it, unless it has
    a range, as Poisson's ratio ν of the normal model, whose Y/(1 − ν²) stays.
    """

    name: str  #: in the file of the code
    model: str  #: tangential model, as in ``tangential/NAME.py``
    words: dict[str, str]  #: texts of the smooth input, and what stands in their place
    free: str = ""  #: name of the number that sets β0; empty if there is none
    lowest: float = 0.0  #: of this number
    highest: float = 0.0  #: of this number
    numbers: dict[str, float] = field(default_factory=dict)  #: others, if they are not the code's defaults
    usual: bool = False  #: whether this is the default of the code


@dataclass(frozen=True)
class Input:
    """Templates of a code's input, with placeholders such as {stiffness}."""

    pair: str
    #: Settings that select the model when a script is read, with their words; none if this code's scripts are not read.
    reads: dict[str, str] = field(default_factory=dict)
    wall: str = ""
    head: str = ""
    foot: str = ""
    shared: bool = False  #: whether the lines hold for all contacts, not for one pair of types
    once: list[str] = field(default_factory=list)  #: numbers common to all contacts, if others are not
    apart: bool = False  #: whether walls have their own numbers
    extra: list[Extra] = field(default_factory=list)  #: lines for extreme numbers
    least: dict[str, float] = field(default_factory=dict)  #: lowest numbers that the code accepts
    #: Used instead of ``pair`` and ``wall`` if contacts need different numbers. {types} is the number of types,
    #: {matrix:stiffness} a number for each pair of types, {matches:stiffness} the same as triples. Each size is a type;
    #: the wall is the last.
    matrix: str = ""


@dataclass(frozen=True)
class Difference:
    """How a model differs in versions of its code that were not examined: since one version, before one, or both."""

    damping: Damping | None = None  #: if it differs
    spring: Spring | None = None  #: if it differs
    since: str = ""  #: the first version, such as ``2 Sep 2026`` or ``2023.02``
    before: str = ""  #: the first version without it
    attracts: Literal["", "always", "never", "unless"] = ""  #: if it differs
    walls: bool = False  #: whether only walls differ
    unknown: bool = False  #: whether its force was not found out


@dataclass(frozen=True)
class Model:
    """One contact model of a code; returned by :func:`hardlimit.convert`."""

    name: str  #: as in ``hardlimit.convert(model=…)``
    title: str  #: as the code's users know it
    elastic: Literal["hooke", "hertz"]  #: the elastic force, linear or Hertz
    attracts: Literal["always", "never", "unless"]  #: at the end of a contact
    spring: Spring  #: how the elastic force follows from the input
    damping: Damping  #: how the damping follows from it
    input: Input  #: how it is written and read
    keyword: str = ""  #: prevents attraction, if ``attracts`` is "unless"
    mass: Mass = Mass()  #: in the formulas, if it is not the effective mass
    note: str = ""  #: remark on the model
    checked: Literal["", "source"] = ""  #: if it was checked less thoroughly than its code
    friction: list[str] = field(default_factory=list)  #: ways to give it friction, by preference
    difference: list[Difference] = field(default_factory=list)  #: in other versions of the code

    def unit(self, name: str) -> tuple[float, float, float]:
        """Powers of mass, length and time in the unit of a number.

        :meta private:
        """
        p, q = 0.25 * ELASTIC[self.elastic], self.damping.power
        if name == self.damping.number and self.damping.formula == "given":
            rule = self.damping
            power = rule.stiffness
            return 1.0 - rule.mass - power, -q - power * (1.0 - p) - rule.radius, -1.0 + 2.0 * power
        powers = {"youngs_modulus": (1.0, -1.0, -2.0), "characteristic_speed": (0.0, 1.0, -1.0)}
        stiffness = (1.0, 1.0 - p - self.spring.radius, -2.0)
        return {**powers, "stiffness": stiffness}.get(name, (0.0, 0.0, 0.0))

    def powers(self, attraction: bool) -> Powers:
        """p, q, and whether the force attracts; ``attraction`` decides if the code has the option.

        :meta private:
        """
        free = {"always": True, "never": False, "unless": attraction}[self.attracts]
        return Powers(ELASTIC[self.elastic], round(4.0 * self.damping.power), free)


@dataclass(frozen=True)
class Code:
    """A particle code as described by its file in the folder ``codes``; returned by :func:`hardlimit.convert`."""

    name: str  #: as in ``hardlimit.convert(code=…)``
    title: str  #: full name
    version: str  #: version that was examined
    sources: list[str]  #: sources of the formulas
    checked: Literal["run", "source"]  #: whether its numbers were compared with runs or only with its source
    walls: str  #: description of the effective mass at a wall
    scheme: Literal["half step"]  #: the damping uses the velocity of half a step before
    models: list[Model]  #: its contact models
    friction: list[TangentialInput] = field(default_factory=list)  #: ways to give contacts friction
    least_inertia: float = 0.0  #: moment of inertia [kg m²] that a ball must exceed
    comment: str = "#"  #: begins a comment of its input
    comment_end: str = ""  #: ends a comment, if not the end of the line

    def model(self, name: str) -> Model:
        """The model of this name.

        Parameters
        ----------
        name : str

        Returns
        -------
        Model

        Raises
        ------
        ValueError
            If there is no such model.
        """
        by_name = {model.name: model for model in self.models}
        like = name if isinstance(name, str) else ""
        if like not in by_name:
            raise ValueError(
                f"model: got {validation.shown(name)}, must be one of {listed(list(by_name), like)}"
            )
        return by_name[like]


def listed(names: Sequence[str], like: str = "") -> str:
    """Names for a message: all, or the closest of many."""
    if len(names) <= MAX_NAMES:
        return ", ".join(names)
    closest = difflib.get_close_matches(like, names, MAX_NAMES, 0.0) if like else names[:MAX_NAMES]
    return ", ".join([*closest, f"… ({len(names)} in all)"])


#: Tables within tables.
INNER: Final[dict[str, Any]] = {
    "models": Model,
    "spring": Spring,
    "damping": Damping,
    "friction": TangentialInput,
    "difference": Difference,
    "mass": Mass,
    "input": Input,
    "extra": Extra,
}
FOLDER: Final = resources.files(__package__) / "codes"


@dataclass(frozen=True)
class Pair:
    """A contact of two bodies, with the quantities in a code's formulas."""

    name: str
    mass: float  #: effective [kg]
    radius: float  #: effective [m]
    wall: bool
    first: int = 1  #: numbers of the bodies, from 1
    second: int = 1
    #: Mass [kg] in the code's formulas if the code does not know that a body is fixed; None for the usual one.
    formula_mass: float | None = None


@dataclass(frozen=True)
class Written:
    """A model applied to one contact: the force for given numbers of the input, and the numbers for a given force."""

    model: Model
    pair: Pair
    speed: float
    attraction: bool = False
    poisson_ratio: float = DEFAULT_POISSON_RATIO

    @cached_property
    def powers(self) -> Powers:
        """Powers of the force."""
        return self.model.powers(self.attraction)

    def force(self, numbers: Mapping[str, float]) -> Force:
        """The force for these numbers."""
        damping = self.model.damping
        number = numbers.get(damping.number, 0.0)
        mass = self._mass(numbers)
        where = self._where(mass, number)
        spring = SPRINGS[self.model.spring.given].value(numbers, where)
        stiffness = spring * self._spring_factor()
        ratio = FORMULAS[damping.formula](number)
        return Force(self.powers, stiffness, ratio * self._damping_scale(mass, stiffness), self.pair.mass)

    def numbers(self, stiffness: float, restitution: float) -> Numbers | None:
        """The numbers for K = ``stiffness`` and ε = ``restitution``; None if the model cannot have this ε."""
        mass = self._mass({})
        force = Force.with_restitution(self.powers, stiffness, self.pair.mass, restitution, self.speed)
        damping = self.model.damping
        number = inverse(damping.formula, force.damping / self._damping_scale(mass, stiffness))
        return None if number is None else self._all_numbers(stiffness, number)

    def usual_numbers(self, stiffness: float, restitution: float) -> Numbers | None:
        """The numbers that a user who does not know the code's formulas would give; None if there are none.

        They are the wanted restitution itself, or for a damping coefficient the value of the formula in common use.
        """
        damping = self.model.damping
        if damping.formula == "none":
            return None
        if damping.formula != "given":
            return self._all_numbers(stiffness, restitution)
        factor = {(4, 0): 2.0, (6, 1): 5.0**0.5}.get((self.powers.elastic, self.powers.damping))
        if factor is None:
            return None
        usual = factor * FORMULAS["usual"](restitution) * (self.pair.mass * stiffness) ** 0.5
        return self._all_numbers(stiffness, usual / self._damping_scale(self._mass({}), stiffness))

    def _all_numbers(self, stiffness: float, number: float) -> Numbers | None:
        mass = self._mass({})
        spring = SPRINGS[self.model.spring.given]
        numbers = spring.numbers(stiffness / self._spring_factor(), self._where(mass, number))
        if numbers is None or mass < self.model.spring.shortest**2 * stiffness:
            return None
        if self.model.damping.formula == "none":
            return {name: float(f"{value:.12g}") for name, value in numbers.items()}
        if self.model.mass.number:
            numbers[self.model.mass.number] = mass / self.model.mass.share
        numbers[self.model.damping.number] = number
        numbers = {name: float(f"{value:.12g}") for name, value in numbers.items()}  # as they are written
        least = self.model.input.least
        return (
            numbers if all(value >= least.get(name, -math.inf) for name, value in numbers.items()) else None
        )

    def _mass(self, numbers: Mapping[str, float]) -> float:
        """The mass in the code's formulas."""
        rule = self.model.mass
        if rule.number and rule.number in numbers:
            return rule.share * numbers[rule.number]
        if self.pair.formula_mass is not None:
            return self.pair.formula_mass
        return self.pair.mass * (rule.wall_factor if self.pair.wall else 1.0)

    def _where(self, mass: float, number: float) -> Where:
        return Where(mass, self.pair.radius, self.speed, number, self.poisson_ratio)

    def _spring_factor(self) -> float:
        spring = self.model.spring
        at_wall = spring.factor if spring.wall_factor is None else spring.wall_factor
        factor = at_wall if self.pair.wall else spring.factor
        return float(factor * self.pair.radius**spring.radius)

    def _damping_scale(self, mass: float, stiffness: float) -> float:
        rule = self.model.damping
        powers = mass**rule.mass * stiffness**rule.stiffness * self.pair.radius**rule.radius
        return float(rule.factor * powers)


@lru_cache(maxsize=1)
def names() -> list[str]:
    """Names of all codes in alphabetical order."""
    return sorted(f.name.removesuffix(".toml") for f in FOLDER.iterdir() if f.name.endswith(".toml"))


def code(name: Any) -> Code:
    """The code of this name.

    Raises
    ------
    ValueError
        If there is no such code.
    """
    return _read(validation.one_of("code", name, names()))


@lru_cache
def _read(name: str) -> Code:
    """Read and check the file of a code."""
    content = toml.parse((FOLDER / f"{name}.toml").read_text("utf-8"))
    _refuse_unknown(name, content, Code)
    source = toml.convert(content, Code, f"{name}: ")
    for model in source.models:
        validation.one_of(f"{name}.{model.name}.spring.given", model.spring.given, list(SPRINGS))
        validation.one_of(f"{name}.{model.name}.damping.formula", model.damping.formula, list(FORMULAS))
    return source


def _refuse_unknown(where: str, content: Any, kind: Any) -> None:
    """Refuse unknown keys of a table in a file."""
    if isinstance(content, list):
        for part in content:
            _refuse_unknown(where, part, kind)
    elif isinstance(content, dict):
        known = {entry.name: INNER.get(entry.name) for entry in fields(kind)}
        for key, part in content.items():
            validation.one_of(where, key, list(known))
            if known[key] is not None:
                _refuse_unknown(f"{where}.{key}", part, known[key])
