"""The command ``set`` of LAMMPS and LIGGGHTS: other types, sizes and masses of grains (docs.lammps.org/set.html)."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Final

from . import free_fall
from .groups import MAX_TYPES, Group
from .population import Batch
from .statements import Statement

if TYPE_CHECKING:
    from .state import State

MAX_NUMBER: Final = 10**9  #: of a grain
#: Keywords of ``set`` that change sizes or masses, and types.
SET_KEYWORDS: Final = ("diameter", "density", "density/disc", "mass", "shape")
TYPE_KEYWORDS: Final = ("type", "type/fraction", "type/ratio", "type/subset")
#: Keywords of ``set`` in LAMMPS and LIGGGHTS, by the number of their values.
SET_WORDS: Final = {
    1: """
type diameter density density/disc mass mol x y z vx vy vz omegax omegay omegaz inertiax inertiay inertiaz charge
quat/random length tri theta theta/random volume temperature bond angle dihedral improper rheo/rho rheo/status
sph/e sph/cv sph/rho meso/e meso/cv meso/rho epsilon dpd/theta edpd/temp edpd/cv
meso_e meso_cv meso_rho sphkernel add until
""",
    2: "dipole/random spin/random spin/atom/random cc blockiness roundness aspect_ratio",
    3: "type/fraction type/ratio type/subset shape dipole angmom omega image spin",
    4: "quat quat_direct spin/atom",
}
SET_COUNTS: Final = {word: count for count, words in SET_WORDS.items() for word in words.split()}
VELOCITY: Final = ("vx", "vy", "vz")
#: Properties that ``fix property/atom`` defines.
CUSTOM: Final = re.compile(r"[id]2?_\w+")


def read(state: State, statement: Statement) -> None:
    """Change grains as a command ``set`` says."""
    words = statement.words
    if len(words) < 4:
        state.unknown[statement.quote] = None
        return
    style, name = words[1], words[2]
    if style == "type":
        chosen = Group(frozenset(state.types_of(name)), True)
    elif style == "group":
        chosen = state.members(name)
    else:
        chosen = Group(None, style == "atom" and name == "*")
    atoms = _atoms_of(name) if style == "atom" else None
    changes: list[Callable[[Batch], Batch]] = []
    velocity: dict[str, float | None] = dict.fromkeys(VELOCITY, 0.0)
    k = 3
    while k < len(words):
        word, values = words[k], words[k + 1 :]
        if word.startswith("property/atom"):  # a property of its own with all its values
            break
        if not (count := SET_COUNTS.get(word, 1 if CUSTOM.match(word) else 0)) or len(values) < count:
            state.quote_with(statement, f"{word} is not understood")
            break
        if word in velocity:
            velocity[word] = state.coefficient(values[0])
        if word in ("x", "y", "z") or velocity.get(word, 0.0) != 0.0:
            state.filling.launches.append(free_fall.UNKNOWN)
        if word in TYPE_KEYWORDS:
            _set_type(state, statement, chosen, word, values[:count], atoms)
        elif word in SET_KEYWORDS:
            value = None if word == "shape" else _number(state, statement, values[0])
            if value is None or value < 0.0:
                state.unknown[statement.quote] = None
                value = None
            changes.append(state.changed(word, value))
            if word in ("diameter", "shape"):
                _resized(state)
                radius = None if value is None or word == "shape" else 0.5 * value
                whole = chosen.whole and atoms is None
                state.filling.census.change(state.within(chosen), whole, radius)
        k += 1 + count
    if any(velocity.values()):
        every = style == "atom" and name == "*"
        key = name if style == "group" else "all" if every else f"{style} {name}"
        state.filling.drifts = {**state.filling.drifts, key: tuple(velocity.values())}
    if None in velocity.values():
        state.filling.velocities_known = False
    state.last = statement
    state.population.change(
        state.within(chosen),
        chosen.whole,
        lambda batch: reduce(lambda now, change: change(now), changes, batch),
        atoms,
        chosen.types is None and chosen.whole and atoms is None,
    )


def _resized(state: State) -> None:
    """Grains that were inserted at least their diameters apart may overlap with others."""
    if any(launch.place is None and launch.spacing == math.inf for launch in state.filling.launches):
        state.filling.launches.append(free_fall.UNKNOWN)


def _set_type(
    state: State, statement: Statement, chosen: Group, word: str, values: Sequence[str], atoms: range | None
) -> None:
    """Another type for grains: ``type T``, ``type/fraction T share seed``, or a number of grains."""
    kind = state.type_of(values[0])
    share = 1.0 if word == "type" else None
    if word == "type/subset":
        share = 0.0 if values[1] == "0" else None
    elif word != "type":
        share = state.number(statement, values[1])
    if not 1 <= kind <= MAX_TYPES or not 0.0 <= (0.5 if share is None else share) <= 1.0:
        state.elsewhere(statement)
    elif share == 1.0 and not state.population.elsewhere and set(state.within(chosen)) <= {kind}:
        return  # they have this type
    elif share != 0.0:
        whole = share == 1.0
        known = share if chosen.whole and atoms is None else None
        state.filling.census.convert(state.within(chosen), kind, known)
        state.population.convert(state.within(chosen), chosen.whole and whole, kind, atoms if whole else None)


def _number(state: State, statement: Statement, word: str) -> float | None:
    """A number of ``set``; None if it differs from grain to grain."""
    return state.variables.of(word[2:]) if word.startswith("v_") else state.number(statement, word)


def _atoms_of(word: str) -> range | None:
    """Numbers of grains within ``2``, ``2*``, ``*3`` or ``1*3``; None if it is not of this form."""
    low, star, high = word.partition("*")
    if not all(end.isdecimal() and len(end) < 10 for end in (low, high) if end) or word == "*" or not word:
        return None
    last = int(high) if high else MAX_NUMBER if star else int(low)
    return range(int(low or 1), last + 1)
