"""What particle codes do with a normal contact, as data: one file for each code in ``codes``.

A model's force is F = K ξ^p + C ξ^q dξ/dt. Its file says p and q, how the code comes to K and C, whether the force may
attract, and how its input is written and read. A code is added by a file.
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
from .formulas import FORMULAS, inverse
from .readers import READERS
from .springs import DEFAULT_POISSON_RATIO, SPRINGS, Numbers, Where

#: Of models that a message lists.
MOST_NAMES: Final = 8
#: Four times p of the elastic force.
ELASTIC: Final = {"hooke": 4, "hertz": 6}


@dataclass(frozen=True)
class Spring:
    """K = factor · X · R^radius, where ``given`` (of ``SPRINGS``) says which numbers make X."""

    given: str
    factor: float = 1.0
    wall_factor: float | None = None  #: at a wall, where it is another one
    radius: float = 0.0
    shortest: float = 0.0  #: √(m/K) [s] below which the code has another spring


@dataclass(frozen=True)
class Damping:
    """C = factor · f(number) · m^mass · K^stiffness · R^radius, f one of ``FORMULAS``; q = power."""

    number: str  #: its name in the input; none where there is no damping
    formula: str = "given"
    factor: float = 1.0
    mass: float = 0.0
    stiffness: float = 0.0
    radius: float = 0.0
    power: float = 0.0
    tolerance: float = 1e-9  #: to which ε can be reached, by the code's own rounding of the formula


@dataclass(frozen=True)
class Mass:
    """The mass that enters the code's formulas, where it is not the effective one of the contact."""

    wall_factor: float = 1.0  #: of the true one, at a wall
    number: str = ""  #: name in the input, where the user hands it over
    share: float = 1.0  #: effective mass by that number


@dataclass(frozen=True)
class Extra:
    """A line that the code asks for where a number is above or below a limit of its own."""

    number: str
    line: str
    above: float = math.inf
    below: float = -math.inf


@dataclass(frozen=True)
class Input:
    """Texts with places such as {stiffness}; ``reads`` is what the code's reader finds in an input.

    Each name of ``reads`` has its words, some of them places. {unsigned:timeconst} is a number without a sign,
    {negative:stiffness} one that is negative or 0, less its sign.
    """

    reads: dict[str, str]
    pair: str
    reads_wall: dict[str, str] = field(default_factory=dict)  #: where a wall is written with other words
    wall: str = ""
    head: str = ""
    foot: str = ""
    shared: bool = False  #: whether what is written holds for all contacts, not for one pair of types
    once: list[str] = field(
        default_factory=list
    )  #: numbers of which there is only one, where others are not shared
    apart: bool = False  #: whether walls have numbers of their own beside those of balls
    extra: list[Extra] = field(default_factory=list)  #: lines for extreme numbers
    least: dict[str, float] = field(default_factory=dict)  #: below which the code refuses a number
    #: Instead of ``pair`` and ``wall``, where contacts need different numbers: {types} is their count,
    #: {matrix:stiffness} a number for each two types, {matches:stiffness} the same as triples. Each size is a type,
    #: the wall the last one.
    matrix: str = ""


@dataclass(frozen=True)
class Model:
    """One contact model of a code; made by :func:`hardlimit.convert`.

    Examples
    --------
    >>> found = hl.convert(
    ...     hl.Ball(1e-3, density=2500.0), restitution=0.7, stiffness=1e4, code="yade"
    ... )
    >>> [one.model.name for one in found.models]
    ['viscel', 'viscel-tc-en', 'viscel-young-en']
    >>> found.models[0].model.elastic, found.models[0].model.attracts
    ('hooke', 'never')
    """

    name: str  #: as in ``hardlimit.convert(model=…)``
    title: str  #: as the code's users know it
    elastic: Literal["hooke", "hertz"]  #: the elastic force, linear or Hertz
    attracts: Literal["always", "never", "unless"]  #: at the end of a contact
    spring: Spring  #: how the elastic force follows from the input
    damping: Damping  #: how the damping follows from it
    input: Input  #: how it is written and read
    keyword: str = ""  #: which keeps the force from attracting, where ``attracts`` is "unless"
    mass: Mass = Mass()  #: that enters the formulas, where it is not the effective one
    note: str = ""  #: what to know of it
    checked: Literal["", "source"] = ""  #: where it was checked less than its code

    def unit(self, name: str) -> tuple[float, float, float]:
        """Powers of mass, length and time in the unit of one of its numbers.

        :meta private:
        """
        p, q = 0.25 * ELASTIC[self.elastic], self.damping.power
        if name == self.damping.number and self.damping.formula == "given":
            rule = self.damping
            of_stiffness = rule.stiffness
            return (
                1.0 - rule.mass - of_stiffness,
                -q - of_stiffness * (1.0 - p) - rule.radius,
                -1.0 + 2.0 * of_stiffness,
            )
        given = {"youngs_modulus": (1.0, -1.0, -2.0), "characteristic_speed": (0.0, 1.0, -1.0)}
        stiffness = (1.0, 1.0 - p - self.spring.radius, -2.0)
        return {**given, "stiffness": stiffness}.get(name, (0.0, 0.0, 0.0))

    def powers(self, attraction: bool) -> Powers:
        """p, q, and whether the force attracts: as the code is, or, where it leaves the choice, as wanted.

        :meta private:
        """
        free = {"always": True, "never": False, "unless": attraction}[self.attracts]
        return Powers(ELASTIC[self.elastic], round(4.0 * self.damping.power), free)


@dataclass(frozen=True)
class Code:
    """A particle code, as its file in ``hardlimit/convert/codes`` describes it; made by :func:`hardlimit.convert`.

    Examples
    --------
    >>> found = hl.convert(
    ...     hl.Ball(1e-3, density=2500.0), restitution=0.7, stiffness=1e4, code="yade"
    ... )
    >>> code = found.models[0].code
    >>> code.title, code.version, code.checked
    ('YADE', '2023.02a (Debian)', 'run')
    >>> code.model("viscel").title
    'ViscElMat(kn, cn)'
    """

    name: str  #: as in ``hardlimit.convert(code=…)``
    title: str  #: its name
    version: str  #: that was looked at
    sources: list[str]  #: of the formulas
    checked: Literal["run", "source"]  #: whether its numbers were compared with runs, or only with its source
    walls: str  #: the effective mass at a wall, in words
    scheme: Literal["half step"]  #: damping at the velocity of half a step before
    models: list[Model]  #: its contact models
    reader: str = "c++"  #: how its input is read, one of ``READERS``
    defaults: dict[str, str] = field(default_factory=dict)  #: what an input sets that does not say so
    sticky: list[str] = field(default_factory=list)  #: what would make bodies stick, which is not read
    least_inertia: float = 0.0  #: moment of inertia [kg m²] that a ball must exceed
    comment: str = "#"  #: begins a comment of its input
    comment_end: str = ""  #: ends it, where the end of the line does not

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
            If there is none.
        """
        by_name = {model.name: model for model in self.models}
        like = name if isinstance(name, str) else ""
        if like not in by_name:
            raise ValueError(
                f"model: got {validation.shown(name)}, must be one of {listed(list(by_name), like)}"
            )
        return by_name[like]


def listed(names: Sequence[str], like: str = "") -> str:
    """Names for a message: all, or of many the closest, which is told."""
    if len(names) <= MOST_NAMES:
        return ", ".join(names)
    closest = difflib.get_close_matches(like, names, MOST_NAMES, 0.0) if like else names[:MOST_NAMES]
    return ", ".join([*closest, f"… ({len(names)} in all)"])


#: Tables within tables.
INNER: Final[dict[str, Any]] = {
    "models": Model,
    "spring": Spring,
    "damping": Damping,
    "mass": Mass,
    "input": Input,
    "extra": Extra,
}
FOLDER: Final = resources.files(__package__) / "codes"


@dataclass(frozen=True)
class Pair:
    """Two bodies as a code's formulas see them."""

    name: str
    mass: float  #: effective [kg]
    radius: float  #: effective [m]
    wall: bool
    first: int = 1  #: numbers of the bodies, from 1
    second: int = 1


@dataclass(frozen=True)
class Written:
    """A model in one contact: what the code makes of its numbers, and the numbers for a force that is wanted."""

    model: Model
    pair: Pair
    speed: float
    attraction: bool = False
    poisson_ratio: float = DEFAULT_POISSON_RATIO

    @cached_property
    def powers(self) -> Powers:
        """Of the force."""
        return self.model.powers(self.attraction)

    def force(self, numbers: Mapping[str, float]) -> Force:
        """The force that the code makes of these numbers."""
        damping = self.model.damping
        number = numbers.get(damping.number, 0.0)
        mass = self._mass(numbers)
        where = self._where(mass, number)
        spring = SPRINGS[self.model.spring.given].value(numbers, where)
        stiffness = spring * self._spring_factor()
        ratio = FORMULAS[damping.formula](number)
        return Force(self.powers, stiffness, ratio * self._damping_scale(mass, stiffness), self.pair.mass)

    def numbers(self, stiffness: float, restitution: float) -> Numbers | None:
        """The numbers with which K is ``stiffness`` and ε is ``restitution``; None if the model cannot have that ε."""
        mass = self._mass({})
        force = Force.with_restitution(self.powers, stiffness, self.pair.mass, restitution, self.speed)
        damping = self.model.damping
        number = inverse(damping.formula, force.damping / self._damping_scale(mass, stiffness))
        return None if number is None else self._all_numbers(stiffness, number)

    def usual_numbers(self, stiffness: float, restitution: float) -> Numbers | None:
        """The numbers that one would take who does not know the code; None where there is no usual way.

        The wanted restitution as it is, or for a coefficient the damping of the formula in common use.
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
        found = spring.numbers(stiffness / self._spring_factor(), self._where(mass, number))
        if found is None or mass < self.model.spring.shortest**2 * stiffness:
            return None
        if self.model.damping.formula == "none":
            return {name: float(f"{value:.12g}") for name, value in found.items()}
        if self.model.mass.number:
            found[self.model.mass.number] = mass / self.model.mass.share
        found[self.model.damping.number] = number
        found = {name: float(f"{value:.12g}") for name, value in found.items()}  # as they are written
        least = self.model.input.least
        return found if all(value >= least.get(name, -math.inf) for name, value in found.items()) else None

    def _mass(self, numbers: Mapping[str, float]) -> float:
        """As the code's formulas have it."""
        rule = self.model.mass
        if rule.number and rule.number in numbers:
            return rule.share * numbers[rule.number]
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
    """Of all codes, in alphabetical order: those of their files."""
    return sorted(f.name.removesuffix(".toml") for f in FOLDER.iterdir() if f.name.endswith(".toml"))


def code(name: Any) -> Code:
    """The code of this name.

    Raises
    ------
    ValueError
        If there is none.
    """
    return _read(validation.one_of("code", name, names()))


@lru_cache
def _read(name: str) -> Code:
    """The code that a file describes, which names nothing that is not there."""
    content = toml.parse((FOLDER / f"{name}.toml").read_text("utf-8"))
    _refuse_unknown(name, content, Code)
    found = toml.convert(content, Code, f"{name}: ")
    for model in found.models:
        validation.one_of(f"{name}.{model.name}.spring.given", model.spring.given, list(SPRINGS))
        validation.one_of(f"{name}.{model.name}.damping.formula", model.damping.formula, list(FORMULAS))
    validation.one_of(f"{name}.reader", found.reader, list(READERS))
    return found


def _refuse_unknown(where: str, content: Any, kind: Any) -> None:
    """Refuse keys that a table of a file must not have."""
    if isinstance(content, list):
        for part in content:
            _refuse_unknown(where, part, kind)
    elif isinstance(content, dict):
        known = {one.name: INNER.get(one.name) for one in fields(kind)}
        for key, part in content.items():
            validation.one_of(where, key, list(known))
            if known[key] is not None:
                _refuse_unknown(f"{where}.{key}", part, known[key])
