"""Findings: what events cannot follow, what is not understood, what is ignored, checked and warned of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Final

from ..boxes.error_law import MEASURED_TC_NU
from ..support.formatting import digits
from . import cases, drive, dumps, friction_words
from .at_rest import GrainState
from .contacts import CheckedContact
from .loads import less_than_a_layer
from .options import Options
from .result import Finding
from .scripts import Description, Note, Quote, Stage

#: In the note on walls and springs that versions of LAMMPS have without friction.
ERROR_OF_VERSIONS: Final = "PR 5007"
RESTS: Final = "grains rest on each other under gravity"
SPARSE: Final = "grains, too few to cover the floor, come to rest under gravity"
RESTS_ON_WALLS: Final = "grains come to rest on walls under gravity"
RESTS_OR_FLOWS: Final = "grains rest or flow in lasting contact under gravity"
FEW_REST: Final[dict[float | None, str]] = {
    1.0: "the grain rests or rolls in lasting contact under gravity",
    2.0: "the two grains rest or roll in lasting contact under gravity",
}


def lasting(
    stages: Sequence[Stage],
    supports: Sequence[drive.Support],
    rows: Sequence[CheckedContact],
    states: Sequence[dumps.State],
    chosen: bool = False,
    elastic: bool = False,
) -> Iterator[Finding]:
    """Contacts that last: grains that rest under gravity or are pressed, and grains that do not separate.

    ``chosen``: speeds are not given; a contact is then overdamped if it is at all speeds. ``elastic``: nothing
    dissipates in the last run.
    """
    lasting = contacts_last(rows, states)
    if lasting:
        coordination = states[-1].coordination
        yield Finding(f"grains have {coordination:.2g} contacts on average in the dump, so contacts last")
    elif lasting is None:
        pressed = [note for stage in stages for note in stage.pressed]
        if pressed:
            what = f"grains are pressed together ({pressed[0].what})"
            yield of_note(pressed[0])._replace(what=what)
        # What is at rest before it is shaken does not decide.
        ends = {stage.system: support for stage, support in zip(stages, supports, strict=True)}
        shaken = {system for system, end in ends.items() if end.moves and not end.rests}
        resting = (
            (stage, support)
            for stage, support in zip(stages, supports, strict=True)
            if support.rests and stage.system not in shaken and not elastic
        )
        walls_only = all(row.types[1] == cases.WALL for row in rows)
        for stage, support in islice(resting, 1):
            still = not support.moves and support.shaking is None
            sparse = still and less_than_a_layer(stages[-1].contents, stage.dimension)
            otherwise = RESTS_ON_WALLS if walls_only else SPARSE if sparse else RESTS
            yield Finding(rest(support, stage.contents.count, otherwise), None, where(stage.quote))
    overdamped: dict[tuple[str, str], list[bool]] = {}
    for row in rows:
        overdamped.setdefault(row.types, []).append(row.restitution == 0.0 and not row.adhesive)
    for types, each in overdamped.items():
        if all(each) if chosen else any(each):
            yield Finding("overdamped contacts", types)


def contacts_last(rows: Sequence[CheckedContact], states: Sequence[dumps.State]) -> bool | None:
    """Whether grains have more contacts in the last frame of a dump than collisions make; None if it is not known."""
    coordination = states[-1].coordination if states else None
    if coordination is None:
        return None
    longest = max((row.tc_nu or 0.0 for row in rows), default=0.0)
    return coordination > 0.1 + 2.0 * min(longest, MEASURED_TC_NU)


def held_together(grains: GrainState, options: Options, lasting: Iterable[Finding]) -> Iterator[Finding]:
    """Findings of lasting contacts: that which options state first, and no rest in a flow that may be collisional."""
    findings = list(lasting)
    if grains.may_separate:
        rest = (RESTS, RESTS_ON_WALLS, SPARSE, *FEW_REST.values())
        findings = [finding for finding in findings if not finding.what.startswith(rest)]
    elif options.load.rests and grains.name != "gas" and all(finding.types for finding in findings):
        how = "flow in lasting contact" if grains.name == "flow" else "are pressed together"
        yield Finding(RESTS if grains.name == "rest" else f"grains {how}")
    slides = grains.slope_inertial_number
    surely = grains.may_slide if slides is None else slides[0] > 0.0
    moves = RESTS_OR_FLOWS if grains.name == "flow" or surely else RESTS
    for finding in findings:
        sparse = finding.what.replace(SPARSE, RESTS if moves == RESTS_OR_FLOWS else SPARSE)
        yield finding._replace(what=sparse.replace(RESTS, moves))


def rest(support: drive.Support, count: float | None, otherwise: str) -> str:
    """That so many grains rest, in words for more than a few, and how strongly their support is shaken."""
    shaking = "" if support.shaking is None else f" (Γ = A ω²/g = {digits(support.shaking, 3)})"
    return f"{FEW_REST.get(count, otherwise)}{shaking}"


def not_understood(
    script: Description,
    last: Stage,
    frames: Sequence[dumps.Frame],
    notes: cases.Remarks,
    invalidates: Sequence[Finding],
) -> list[Finding]:
    """Statements, types of a dump and contacts that are not understood."""
    taken = {types for finding in invalidates if (types := finding.types)}
    unknown = [Finding(quote.text.strip(), None, where(quote)) for quote in script.unknown]
    unknown += [
        Finding(f"grains of type {name} are in the dump, but not in the script")
        for name in sorted({name for frame in frames for name in frame.types or () if name.isdecimal()})
        if name not in last.grains
    ]
    if all(finding.types is not None for finding in invalidates):
        unknown += _not_modelled(
            [contact for contact in notes.not_modelled if not any({*contact.types} & {*t} for t in taken)]
        )
    return unknown


def ignored(script: Description, rows: Sequence[CheckedContact]) -> Iterator[Finding]:
    """What is in the script beside the contacts; their tangential forces unless all are understood."""
    rubbing = (row.friction for row in rows if row.friction.coefficient != 0.0)
    understood = all(known.limit is not None or known.other_versions for known in rubbing)
    for note in script.ignored:
        if not (understood and note.what.startswith("tangential")):
            yield of_note(note)


def warnings(script: Description, rows: Sequence[CheckedContact]) -> tuple[Finding, ...]:
    """First what other versions of the code do, then what the script says, then what follows from numbers."""
    notes = sorted(script.warnings, key=lambda note: ERROR_OF_VERSIONS not in note.what)
    read = [of_note(note)._replace(minor=friction_words.is_minor(note.what, rows)) for note in notes]
    said = " ".join(finding.what for finding in read)
    repeated = [words for words in friction_words.OF_READERS if words in said]
    others = [trap for trap in traps(rows) if not any(words in trap.what for words in repeated)]
    return (*_findings(friction_words.versions, rows, own=True), *read, *others)


def traps(rows: Sequence[CheckedContact]) -> Iterator[Finding]:
    """What the friction of contacts does that is rarely meant."""
    for trap in friction_words.TRAPS:
        yield from _findings(trap, rows)


def _findings(
    trap: Callable[[CheckedContact], str], rows: Sequence[CheckedContact], own: bool = False
) -> Iterator[Finding]:
    """A trap for each pair of types that falls into it, in its ``own`` words or those of the first."""
    texts = {row.types: text for row in rows if row.friction.coefficient != 0.0 and (text := trap(row))}
    for types, text in texts.items():
        yield Finding(text if own else next(iter(texts.values())), types)


def _not_modelled(contacts: Sequence[cases.NotModelled]) -> Iterator[Finding]:
    """Each statement that no model describes, with the types of its contacts."""
    for why, quote in dict.fromkeys((contact.why, contact.quote) for contact in contacts):
        same = [contact.types for contact in contacts if (contact.why, contact.quote) == (why, quote)]
        pairs = ["–".join(types) for types in same]
        text = f"{', '.join(pairs[:3])}{' …' * (len(pairs) > 3)}: {why}"
        kinds = tuple(dict.fromkeys(name for types in same for name in types))
        yield Finding(why, kinds, text if quote is None else f"{where(quote)} ({text})")


def of_note(note: Note) -> Finding:
    """What a reader of scripts noted, with its line."""
    return Finding(note.what, note.types, "" if note.quote is None else where(note.quote))


def where(quote: Quote) -> str:
    """A statement with its line."""
    file = f"{Path(quote.file).name}, " if quote.file else ""
    part = f" ({quote.part} is not known)" if quote.part else ""
    return f"{file}line {quote.line}: {' '.join(quote.text.split())}{part}"


def parts_checked(
    rows: Sequence[CheckedContact], gravity: bool, states: Sequence[dumps.State]
) -> Iterator[Finding]:
    """The parts of a simulation that were checked."""
    if any(row.restitution is not None and row.types[1] != cases.WALL for row in rows):
        yield Finding("normal contact")
    if any(row.friction.tangential_restitution for row in rows):
        yield Finding("friction")
    if any(row.steps_per_contact is not None for row in rows):
        yield Finding("time step")
    if any(row.restitution is not None and row.types[1] == cases.WALL for row in rows):
        yield Finding("walls")
    if gravity:
        yield Finding("gravity")
    if states:
        yield Finding(f"dump of {len(states)} frame{'s' if len(states) > 1 else ''}")
