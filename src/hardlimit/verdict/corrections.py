"""Lines of a script with the numbers that give the restitution that was asked for, and a time step that resolves it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Final

from ..convert import texts
from ..scripts import Setting
from ..scripts.formulas import NUMBER
from .cases import FIXED, WALL, ModelForce
from .contacts import Case, CheckedContact

#: Differences of ε from the one asked for, and errors of ε by the time step, that need no correction.
TOLERATED: Final = 5e-3
ENOUGH: Final = 1.05e-3
STEP: Final = {"yade": "O.dt = {}"}
DAMPING_LAW: Final = "Law2_ScGeom_MindlinPhys_Mindlin()"
DAMPED: Final = "NewtonIntegrator(damping=0)  # in O.engines, with its other arguments"


def lines(code: str, examined: Sequence[tuple[Case, CheckedContact]], step_factor: float) -> list[str]:
    """Corrected lines; ``step_factor`` is the script's unit of time in seconds."""
    found = dict.fromkeys(_numbers(examined))
    steps = [row.time_step for _, row in examined if row.time_step and _too_long(row)]
    if steps:
        found[STEP.get(code, "timestep {}").format(texts.rounded_down(min(steps) / step_factor))] = None
    if examined and examined[-1][0].numerical_damping:
        found[DAMPED] = None
    return list(found)


def _too_long(row: CheckedContact) -> bool:
    """Whether the time step changes ε."""
    error = row.restitution_error_of_step
    return row.steps_per_contact is not None and (
        error is None or error > ENOUGH
    )  # None: the contact does not end


def _numbers(examined: Sequence[tuple[Case, CheckedContact]]) -> Iterator[str]:
    """The lines whose number gives another ε than the one asked for."""
    # For each number in a statement: each number that some contacts need, with these contacts and the corrected line.
    needed: dict[tuple[str, ...], dict[str, tuple[dict[str, None], str | None]]] = {}
    for case, row in examined:
        asked, force, pair = case.restitution_asked, case.force, "–".join(case.types)
        if asked is None or not isinstance(force, ModelForce) or row.restitution is None or row.adhesive:
            continue
        if force.contact.asked is not None:
            yield f"{DAMPING_LAW}  # in place of {force.contact.settings['betan'].text}"
            continue
        if case.wall == FIXED:
            pair += f" {FIXED}"
        bodies = case.first.tried(0), None if case.second is None else case.second.tried(0)
        name = force.model.damping.number
        setting, place = _place(force, name, case.types[1] == WALL)
        new, line = setting.words[place], None
        made = force(*bodies, 1.0)
        if abs(made.collision(1.0).restitution - asked) > TOLERATED:
            numbers = force.written(*bodies, 1.0).numbers(made.stiffness, asked)
            if numbers is None:
                yield f"# {pair}: this model cannot have ε = {asked:g}"
                continue
            new = f"{numbers[name]:.6g}"
            line = (
                replaced(setting, place, new)
                or f"# {name} {new} in place of {setting.words[place]}: {setting.text}"
            )
        contacts, _ = needed.setdefault((setting.text, *setting.words), {}).setdefault(new, ({}, line))
        contacts[pair] = None
    for numbers_of in needed.values():
        for new, (contacts, line) in numbers_of.items():
            others = [f"{', '.join(pairs)} needs {n}" for n, (pairs, _) in numbers_of.items() if n != new]
            if line is not None:
                yield f"{line}  # {', '.join(contacts)}; {'; '.join(others)}" if others else line


def _place(force: ModelForce, name: str, wall: bool) -> tuple[Setting, int]:
    """The setting that has a number, and which of its words it is."""
    given = force.model.input
    for setting, words in (given.reads_wall if wall and given.reads_wall else given.reads).items():
        for k, word in enumerate(words.split()):
            if word.strip("{}").rpartition(":")[2] == name:
                return force.contact.settings[setting], k
    raise AssertionError(name)


def replaced(setting: Setting, place: int, new: str) -> str | None:
    """The statement with another number; None if it stands there as a variable or cannot be told from others."""
    text = setting.text.strip()
    words = r"\s+".join(f"({re.escape(word)})" for word in setting.words)
    matches = list(re.finditer(rf"(?<!\S){words}(?!\S)", text))
    spans = [match.span(place + 1) for match in matches]
    if len(setting.words) == 1:
        spans = [
            m.span()
            for m in re.finditer(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])", text)
            if _equal(m[0], setting.words[0])
        ]
    if len(spans) != 1:
        return None
    first, last = spans[0]
    return text[:first] + new + text[last:]


def _equal(word: str, other: str) -> bool:
    return NUMBER.fullmatch(other) is not None and math.isclose(float(word), float(other), rel_tol=1e-12)
