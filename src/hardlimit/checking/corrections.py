"""Lines of a script with the numbers that give the restitution that was asked for, and a time step that resolves it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from ..convert import texts
from ..convert.codes import code
from ..support.formatting import digits
from .cases import FIXED, ModelForce, force_of
from .contacts import Case, CheckedContact, restitution
from .scripts import Setting
from .scripts.description import WANTED
from .scripts.formulas import NUMBER

MATRIX: Final = "peratomtypepair"  #: of LIGGGHTS, before the number of types and a row for each
#: Differences of ε from the one asked for, and errors of ε by the time step, that need no correction.
TOLERATED: Final = 5e-3
ENOUGH: Final = 1.05  #: times the accepted error
STEP: Final = {"yade": "O.dt = {}"}
DAMPING_LAW: Final = "Law2_ScGeom_MindlinPhys_Mindlin()"
DAMPED: Final = "NewtonIntegrator(damping=0)  # in O.engines, with its other arguments; ε is then {}"

Examined = Sequence[tuple[Case, CheckedContact]]


class LargestStep(NamedTuple):
    """The largest time step of a state in which contacts last, in the units of the script."""

    step: float
    reason: str  #: in words, such as "stable at 4.5 contacts per grain"


def lines(
    code: str,
    examined: Examined,
    accepted: float,
    with_step: bool = True,
    largest: LargestStep | None = None,
) -> list[str]:
    """Corrected lines; ``accepted`` is the error of ε that the time step may cause.

    ``largest``: the step of a state in which contacts last, where no error of ε matters. A numerical damping is left
    out only if the script asks for an ε below 1, and contacts have one: without it, grains may be undamped.
    """
    numbers = list(dict.fromkeys(_numbers(examined)))
    lines = dict.fromkeys(numbers)
    wanted = [case.restitution_asked for case, _ in examined if case.restitution_asked is not None]
    damped = bool(wanted and examined[-1][0].numerical_damping)
    step = STEP.get(code, "timestep {}")
    if largest is not None:
        own = [case.time_step for case, _ in examined if case.time_step is not None]
        if own and max(own) > largest.step:
            lines[f"{step.format(texts.rounded_down(largest.step))}  # {largest.reason}"] = None
    elif with_step and (
        steps := [row.time_step for _, row in examined if row.time_step and _too_long(row, accepted)]
    ):
        lines[step.format(texts.rounded_down(min(steps)))] = None
    if damped:
        numbered = any(not line.startswith("#") for line in numbers)
        then = corrected(examined, numbers) if numbered else undamped(examined)
        if then is not None and float(then.split()[-1]) < 1.0:
            lines[DAMPED.format(then)] = None
    return list(lines)


def undamped(examined: Examined) -> str | None:
    """ε without numerical damping; None if it is not known."""
    epsilons = [_undamped(case, row) for case, row in examined]
    known = [epsilon for epsilon in epsilons if epsilon is not None]
    return span(known) if known and len(known) == len(epsilons) else None


def _undamped(case: Case, row: CheckedContact) -> float | None:
    return restitution(replace(case, numerical_damping=None), row.speed)


def with_damping(case: Case) -> float | None:
    """ε that the functor's ``en`` gives with the law that has its damping; None if the contact has this law."""
    force = case.force
    if not isinstance(force, ModelForce) or force.contact.asked is None:
        return None
    contact = force.contact
    settings = {name: setting for name, setting in contact.settings.items() if name != "betan"}
    settings["en"] = replace(contact.settings["betan"], words=(repr(contact.asked),))
    damped = force_of(code("yade"), replace(contact, settings=settings, asked=None), None)
    bodies = case.first.tried(0), None if case.second is None else case.second.tried(0)
    return damped(*bodies, 1.0).collision(1.0).restitution


def corrected(examined: Examined, lines: Iterable[str]) -> str | None:
    """ε without numerical damping after these lines: as asked, but of contacts for which they have no number."""
    left = {line[2:].partition(":")[0] for line in lines if line.startswith("#")}
    pairs = [(case, row) for case, row in examined if _label(case) in left]
    others = [
        with_damping(case) or case.restitution_asked for case, _ in examined if _label(case) not in left
    ]
    values = [*others, *(_undamped(case, row) for case, row in pairs)]
    known = [value for value in values if value is not None]
    return span(known) if known else None


def span(values: Sequence[float]) -> str:
    """The smallest and the largest value in words."""
    return " to ".join(dict.fromkeys(digits(value, 3) for value in (min(values), max(values))))


def _too_long(row: CheckedContact, accepted: float) -> bool:
    """Whether the time step changes ε."""
    error = row.restitution_error_of_step
    # None: the contact does not end.
    return row.steps_per_contact is not None and (error is None or error > ENOUGH * accepted)


class Need(NamedTuple):
    """The number that a contact needs in a statement, and the statement with it; no line if it has this number."""

    case: Case
    number: str
    line: str | None


def _rounded(word: str) -> str:
    """A number without the rounding error of a mean; other words as they are."""
    return f"{float(word):.12g}" if NUMBER.fullmatch(word) else word


def _numbers(examined: Examined) -> Iterator[str]:
    """The lines whose number gives another ε than the one asked for.

    A line says in a comment for which ε it is, so that the next check reads it as the one asked for.
    """
    needed: dict[tuple[str, ...], list[Need]] = {}
    for case, row in examined:
        wanted, force = case.restitution_asked, case.force
        if wanted is None or not isinstance(force, ModelForce) or row.restitution is None or row.adhesive:
            continue
        if force.contact.asked is not None:
            law = f"{DAMPING_LAW}  # in place of {force.contact.settings['betan'].text}"
            obtained = with_damping(case)
            off = obtained is not None and abs(obtained - wanted) > TOLERATED
            yield f"{law}; en={wanted:g} then gives ε = {digits(obtained or 0.0, 3)}" if off else law
            continue
        bodies = case.first.tried(0), None if case.second is None else case.second.tried(0)
        name = force.model.damping.number
        setting, place = _place(force, name)
        new, line = setting.words[place], None
        pair_force = force(*bodies, 1.0)
        if abs(pair_force.collision(1.0).restitution - wanted) > TOLERATED:
            numbers = force.written(*bodies, 1.0).numbers(pair_force.stiffness, wanted)
            if numbers is None:
                yield f"# {_label(case)}: this model cannot have ε = {wanted:g}"
                continue
            new = f"{numbers[name]:.6g}"
            if wanted < 1.0 and (float(new) >= 1.0 if name == "restitution" else float(new) <= 0.0):
                own = digits(pair_force.collision(1.0).restitution, 3)
                yield (
                    f"# {_label(case)}: for ε = {wanted:g}, {name} would be {new}, which removes all damping; "
                    f"its ε is {own}"
                )
                continue
            line = (
                replaced(setting, place, new)
                or f"# {name} {new} in place of {_rounded(setting.words[place])}: {setting.text}"
            )
        needed.setdefault((setting.text, *setting.words), []).append(Need(case, new, line))
    statements: dict[str, list[tuple[tuple[str, ...], list[Need]]]] = {}
    for (text, *words), needs in needed.items():
        statements.setdefault(text, []).append((tuple(words), needs))
    for text, settings in statements.items():
        restitutions = {need.case.restitution_asked for _, needs in settings for need in needs}
        is_said = len(restitutions) == 1 and not WANTED.search(text)
        comment = f"  # for a restitution of {restitutions.pop():g}" if is_said else ""
        if MATRIX in text and all(len({need.number for need in needs}) == 1 for _, needs in settings):
            yield from _matrix(text, {words[0]: needs[0] for words, needs in settings}, comment)
        else:
            for _, needs in settings:
                yield from _corrected(needs, comment)


def _matrix(text: str, needs: Mapping[str, Need], comment: str) -> Iterator[str]:
    """The line of a matrix over types with all numbers that contacts need; none if they have them."""
    if all(need.line is None for need in needs.values()):
        return
    head, name, tail = text.partition(MATRIX)
    kept = WANTED.search(tail)
    count, *values = (tail if kept is None else tail[: kept.start()]).split()
    new = [
        next((need.number for word, need in needs.items() if word == value or _equal(value, word)), None)
        for value in values
    ]
    if None in new:  # of a contact that is not known, or of two walls
        comment = ""
    line = " ".join(number or value for number, value in zip(new, values, strict=True))
    yield f"{head}{name} {count} {line}{comment if kept is None else '  ' + kept[0]}"


def _corrected(needs: Sequence[Need], comment: str) -> Iterator[str]:
    """A line for each number that contacts need in one statement; which contacts, if they need several."""
    numbers: dict[str, dict[str, None]] = {}
    for pair in dict.fromkeys(_label(need.case) for need in needs):
        members = [need for need in needs if _label(need.case) == pair]
        several = len({member.number for member in members}) > 1
        runs = len({member.case.stage for member in members}) > 1
        for member in members:
            numbers.setdefault(member.number, {})[_label(member.case, several, runs)] = None
    for number, contacts in numbers.items():
        line = next((need.line for need in needs if need.number == number and need.line), None)
        others = [
            f"{', '.join(labels)} need{'s' * (len(labels) == 1)} {n}"
            for n, labels in numbers.items()
            if n != number
        ]
        if line is not None:
            alone = line if line.startswith("#") else line + comment
            yield f"{line}  # {', '.join(contacts)}; {'; '.join(others)}" if others else alone


def _label(case: Case, full: bool = False, run: bool = False) -> str:
    """The types of a contact; if ``full``, its wall and its radii in the script's unit, and its ``run``."""
    pair = "–".join(case.types) + (f" {FIXED}" if case.wall == FIXED else "")
    if not full:
        return pair
    radii = [
        body.radius for body in (case.first, case.second) if body is not None and body.radius is not None
    ]
    sizes = ", ".join(dict.fromkeys(map(digits, radii)))
    wall = f" {case.wall}" if case.wall not in (None, FIXED) else ""
    return f"{pair}{wall}{f' R {sizes}' if sizes else ''}{f' in run {case.stage}' if run else ''}"


def _place(force: ModelForce, name: str) -> tuple[Setting, int]:
    """The setting that has a number, and which of its words it is."""
    for setting, words in force.model.input.reads.items():
        for k, word in enumerate(words.split()):
            if word == f"{{{name}}}":
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
    """Whether two words, which may be quoted, are the same number."""
    bare = [either.strip("\"'") for either in (word, other)]
    return all(map(NUMBER.fullmatch, bare)) and math.isclose(*map(float, bare), rel_tol=1e-12)
