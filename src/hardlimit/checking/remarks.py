"""Remarks on contacts, their speeds and time steps, and what is missing."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from ..support.formatting import digits, length, listed, percent, quantity
from . import cases, corrections, drive
from .contacts import COMPRESSED, Case, CheckedContact, Surroundings
from .options import CHOSEN_SPEEDS, Options
from .scripts import Stage
from .scripts.filling import AT_MOST
from .supplied import SCALES


def _known_speeds(
    rows: Sequence[CheckedContact], speeds: Sequence[float], driven: drive.Drive | None
) -> Sequence[float]:
    """The speeds; those of the steady state if they are known for all contacts."""
    if driven is None:
        return speeds
    known = [row.speed for row in rows if row.speed is not None]
    return known if len(known) == len(rows) else ()


def _speeds_chosen(
    rows: Sequence[CheckedContact], speeds: Sequence[float], driven: drive.Drive | None, plain: bool
) -> Iterator[str]:
    """That speeds are not given but chosen, or why none are."""
    if speeds or driven:
        return
    if any(row.speed is not None for row in rows):
        yield f"No speed is given: {listed([digits(v) for v in CHOSEN_SPEEDS])} m/s were chosen."
    elif plain and any(row.radius is not None and row.model and row.duration is None for row in rows):
        yield "No speed is given, and lj units have no usual one."


def _no_speed(
    driven: drive.Drive | None, rows: Sequence[CheckedContact], gas: Surroundings, plain: bool
) -> Iterator[str]:
    """Why there is no speed of a steady state."""
    if driven is None or all(row.speed is not None for row in rows):
        return
    reason = driven.why_not(gas.dimension, gas.packing_fraction)
    if driven.moves_nothing and all(row.friction.coefficient == 0.0 for row in rows):
        reason = reason or "spins of grains without friction move nothing"
    if any((row.restitution or 0.0) > 1.0 - drive.ELASTIC for row in rows if row.speed is None):
        reason = reason or "elastic grains have no steady state, they heat for ever"
    if driven.shear_rate is not None and any(
        row.restitution < drive.LEAST_IN_SHEAR for row in rows if row.restitution is not None
    ):
        reason = reason or f"kinetic theory of shear is that of ε from {drive.LEAST_IN_SHEAR:g} on"
    reason = (
        reason or "sizes or masses are not known, or the restitution is outside the range of kinetic theory"
    )
    yield f"No speed from {driven.words(plain)}: {reason}."


def still_falling(runs: Sequence[Stage]) -> Iterator[str]:
    """That the runs of a system end while most grains fall from where they are inserted."""
    last = runs[-1]
    times = [
        math.nan if run.steps is None or run.time_step is None else run.steps * run.time_step for run in runs
    ]
    falls = [speed for speed in last.contents.speeds if speed.height and AT_MOST not in speed.source]
    if not falls or not last.gravity:
        return
    fall, lasted, gravity = max(falls, key=lambda speed: speed.height or 0.0), math.fsum(times), last.gravity
    height = fall.height or 0.0
    start = math.sqrt(max(fall.value**2 - 2.0 * gravity * height, 0.0))
    fallen = start * lasted + 0.5 * gravity * lasted**2
    if fallen < 0.5 * height:
        _, metre, second = SCALES[last.units]
        plain = last.units == "lj"
        shown = [digits(x, 2) if plain else length(float(f"{x * metre:.2g}")) for x in (fallen, height)]
        time = digits(lasted, 2) if plain else quantity(lasted * second, "s", 2)
        yield f"The runs end after {time}, while grains still fall: {shown[0]} of up to {shown[1]}."


def missing(
    rows: Sequence[CheckedContact], gas: Surroundings, speeds: Sequence[float], driven: drive.Drive | None
) -> tuple[str, ...]:
    """What is not known, in words; no speeds of a steady state that the rest would give."""
    pairs = [row for row in rows if row.types[1] != cases.WALL]
    missing = []
    if gas.packing_fraction is None:
        missing.append("packing")
    if any(row.radius is None for row in rows):
        missing.append("sizes")
    elif any(row.density is None for row in pairs):
        missing.append("masses")
    if not _known_speeds(rows, speeds, driven) and not (driven and missing):
        missing.insert(0, "speeds")
    return tuple(missing)


def on_contacts(
    examined: Sequence[tuple[Case, CheckedContact]],
    newest: Sequence[CheckedContact],
    options: Options,
    gas: Surroundings,
    speeds: Sequence[float],
    at: str,
    plain: bool,
) -> Iterator[str]:
    """All remarks on contacts and their speeds. ``newest``: those of the last run, which what is not known concerns."""
    rows = [row for _, row in examined]
    yield from dict.fromkeys(_notes(examined, options.restitution_error, at))
    yield from _no_speed(options.drive, newest, gas, plain)
    yield from _speeds_chosen(rows, speeds, options.drive, plain)


def _notes(examined: Sequence[tuple[Case, CheckedContact]], accepted: float, at: str = "") -> Iterator[str]:
    """Remarks on numbers that do not mean what they seem to; ``at``: the chosen speed of the largest ones."""
    groups: dict[tuple[Any, ...], list[tuple[Case, CheckedContact]]] = {}
    for case, row in examined:
        groups.setdefault((case.stage, case.model), []).append((case, row))
    for (_, model), members in groups.items():
        epsilons = [row.restitution for _, row in members if row.restitution is not None]
        force = members[0][0].force
        if not isinstance(force, cases.ModelForce) or not epsilons:
            continue
        low, high = min(epsilons), max(epsilons)
        if force.model.damping.formula == "given" and high - low > 0.01:
            yield (
                f"The script gives a damping, not a restitution; with {model} it gives ε from {low:.3g} to {high:.3g}, "
                "not one ε."
            )
        wanted = [case.restitution_asked for case, _ in members if case.restitution_asked is not None]
        if wanted and any(abs(e - a) > corrections.TOLERATED for e, a in zip(epsilons, wanted, strict=False)):
            yield "ε given differs from ε asked."
    rows = [row for _, row in examined]
    error = max((row.restitution_error_of_step or 0.0 for row in rows), default=0.0)
    endless = any(row.steps_per_contact is not None and row.restitution_error_of_step is None for row in rows)
    overlap = max((row.largest_overlap or 0.0 for row in rows), default=0.0)
    if any(row.error and row.radius != row.other_radius for row in rows):
        yield "Unequal grains: the error is that of equal ones of their mean size, with a wider bar."
    if overlap > COMPRESSED:
        yield f"Overlaps reach {percent(overlap)} of the radius{at}; contact laws hold up to {percent(COMPRESSED)}."
    if endless or error > 1.0:
        yield "The time step is too long: contacts do not end, or gain energy."
    elif error > corrections.ENOUGH * accepted:
        yield f"The time step changes ε by up to {error:.2g}{at}."


def numerically_damped(
    damping: float | None, examined: Sequence[tuple[Case, CheckedContact]]
) -> Iterator[str]:
    if damping:
        without = corrections.undamped(examined)
        then = "" if without is None else f"; without it, ε is {without}"
        yield f"ε includes NewtonIntegrator's damping of {damping:g} (centre of mass at rest{then})."
