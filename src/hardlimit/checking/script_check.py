"""The check of a script: the answer for all its systems."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..support import validation
from . import answer, cases, drive, dumps, findings, held, remarks, surroundings
from .options import NO_RUN, Options
from .result import CheckedStage, Finding, Verdict
from .scripts import Description, Grains, Stage
from .supplied import SCALES, completed
from .systems import System, kinds_of, systems_of
from .units import state_in_si


def _answer(
    systems: Sequence[System],
    invalidates: Sequence[Finding],
    unknown: Sequence[Finding],
    states: Sequence[dumps.State],
) -> tuple[bool | None, str]:
    """The answer for all systems: no if it is for one, yes if it is for all."""
    answers = []
    for question in dict.fromkeys(system.question for system in systems):
        same = [system for system in systems if system.question == question]
        rows = [row for system in same for row in system.rows]
        missing = tuple(dict.fromkeys(what for system in same for what in system.missing(states)))
        answers.append(answer.answer(rows, invalidates, unknown, missing, question))
    return min(answers, key=lambda pair: (False, None, True).index(pair[0]))


def _refuse_empty(script: Description) -> None:
    """Refuse a script without granular contacts, or with units that are not understood."""
    for stage in script.stages:
        if stage.units not in SCALES:
            raise ValueError(
                f"units: got {validation.shown(stage.units)}, must be one of {', '.join(SCALES)}"
            )
    if not script.unknown and not any(stage.contacts for stage in script.stages):
        others = "".join(f"; it has {note.what}" for note in script.invalidates[:1])
        raise ValueError(f"script: it has no run with granular contacts{others}")


def _stage(number: int, stage: Stage, support: drive.Support) -> CheckedStage:
    _, length, time = SCALES[stage.units]
    step, gravity = stage.time_step, stage.gravity
    return CheckedStage(
        number=number,
        command=findings.where(stage.quote),
        time_step=None if step is None else step * time,
        steps=stage.steps,
        gravity=None if gravity is None else gravity * length / time**2,
        units=stage.units,
        shaking=support.shaking,
    )


def checked_script(script: Description, options: Options, frames: Sequence[dumps.Frame] = ()) -> Verdict:
    """The verdict on a script and the frames of a dump."""
    _refuse_empty(script)
    script = completed(_with_sizes(script, frames), options.supplied)
    stages = script.stages or (NO_RUN,)
    kinds, last = kinds_of(stages), stages[-1]
    contacts, notes = cases.of_script(script, kinds[: len(script.stages)])
    states = surroundings.states(
        frames, surroundings.radii(last), last.dimension, surroundings.densities(last)
    )
    systems = list(systems_of(stages, kinds, contacts, options, states))
    rows = sorted((row for system in systems for row in system.rows), key=lambda row: row.stage)
    supports = [drive.support(stage) for stage in script.stages]
    chosen = any(system.at for system in systems)
    final = next(system for system in systems if system.last is last)
    others = " ".join(note.what for note in script.invalidates)
    runs = [stage for stage in script.stages if stage.system == last.system]
    grains = held.in_script(final, runs, frames, states, others)
    elastic = held.bounces(final, others)
    question = held.flowing(final.question, grains, bool(last.gravity))
    if elastic and grains.name == "gas" and supports and supports[-1].rests and not script.unknown:
        question = replace(question, driven=answer.BOUNCE)
    final = replace(
        final, question=replace(question, never_meet=grains.never_meet, few=grains.grains is not None)
    )
    systems = [final if system.last is last else system for system in systems]
    invalidates = [findings.of_note(note) for note in script.invalidates]
    invalidates += findings.held_together(
        grains,
        options,
        findings.lasting(script.stages, supports, rows, states, chosen, elastic or grains.never_meet),
    )
    unknown = findings.not_understood(script, last, frames, notes, invalidates)
    admissible, sentence = _answer(systems, invalidates, unknown, states)
    several = len({stage.units for stage in stages}) > 1
    _, length, time = SCALES[last.units]
    return Verdict(
        admissible=admissible,
        sentence=sentence
        + answer.steady(final.rows, final.supply, last.units == "lj")
        + held.words_of_state(grains, last.units, last.dimension),
        code=script.code,
        version=script.version,
        units=last.units,
        units_given=last.units_given,
        time_step=None if last.time_step is None else last.time_step * time,
        numerical_damping=last.numerical_damping,
        rows=tuple(rows),
        stages=tuple(_stage(k, *pair) for k, pair in enumerate(zip(script.stages, supports, strict=True), 1)),
        states=tuple(state_in_si(state, length, time) for state in states),
        checked=tuple(findings.parts_checked(rows, any(stage.gravity for stage in script.stages), states)),
        ignored=tuple(findings.ignored(script, rows)),
        invalidates=tuple(invalidates),
        unknown=tuple(unknown),
        missing=tuple(dict.fromkeys(what for system in systems for what in system.missing(states))),
        remarks=(
            *cases.of_other_versions(script, rows),
            *notes.versions,
            *dict.fromkeys(note for system in systems for note in system.remarks(several)),
            *remarks.numerically_damped(last.numerical_damping, final.examined),
            *(remarks.still_falling(runs) if runs and grains.name == "rest" else ()),
        ),
        warnings=findings.warnings(script, rows),
        corrected=tuple(
            dict.fromkeys(
                line
                for system in systems
                for line in system.corrected(script.code, several, held.step_at_rest(grains, system, last))
            )
        ),
        quantity=None if final.question.driven else final.question.quantity,
        restitution_error=options.restitution_error,
        speeds_chosen=chosen,
        state=grains,
        inferred=tuple(dict.fromkeys(number for system in systems for number in system.inferred_in_si)),
    )


def _with_sizes(script: Description, frames: Sequence[dumps.Frame]) -> Description:
    """The script with sizes and masses of a dump for types whose sizes it does not have.

    A file that it reads them from need then not be understood.
    """
    measured = dumps.sizes(frames)
    if not measured:
        return script

    def grains(kind: Grains) -> Grains:
        known = measured.get(kind.type, measured.get(""))
        if kind.radii is not None or known is None:
            return kind
        radii, masses = known
        return replace(kind, radii=radii, masses=None if kind.densities else masses or kind.masses)

    stages = [
        replace(stage, grains={name: grains(kind) for name, kind in stage.grains.items()})
        if (stage.units, stage.dimension) == (script.stages[-1].units, script.stages[-1].dimension)
        else stage
        for stage in script.stages
    ]
    unknown = [
        quote for quote in script.unknown if not quote.text.lstrip().startswith(("read_data", "read_restart"))
    ]
    return replace(script, stages=tuple(stages), unknown=tuple(unknown))
