"""The state of grains that are held together, in SI units: at rest, pressed, flowing, shaken; and of few grains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..support.formatting import digits
from . import answer, at_rest, corrections, drive, dumps, few, findings, loads, state_words, surroundings
from .at_rest import GrainState
from .contacts import CheckedContact
from .options import CHOSEN_SPEEDS, Options
from .scripts import Stage
from .scripts.clumps import STYLE as MULTISPHERE
from .scripts.description import FEW
from .stated import SUPPOSED
from .supplied import SCALES
from .systems import System
from .units import unit_of


def in_script(
    final: System,
    runs: Sequence[Stage],
    frames: Sequence[dumps.Frame],
    states: Sequence[dumps.State],
    others: str,
) -> GrainState:
    """How the grains of the last of some runs are held together, in SI units.

    ``others``: what else acts on them, in words.
    """
    stage = final.last
    examined = {id(case): case for case, _ in final.examined}
    newest = max((case.stage for case in examined.values()), default=0)
    fixed = [name for name, kind in stage.grains.items() if kind.frozen]
    bed = None
    if frames and stage.down:
        bed = dumps.bed(
            frames[-1],
            surroundings.radii(stage),
            surroundings.densities(stage),
            stage.down,
            stage.dimension,
            fixed,
        )
    kinds = dumps.kinds(frames[-1], surroundings.radii(stage), fixed) if frames else ()
    around = loads.Around(
        cases=[case for case in examined.values() if case.stage == newest],
        dimension=stage.dimension,
        units=stage.units,
        state=states[-1] if states else None,
        kinds=kinds,
        poured=loads.poured(stage, kinds),
        bed=bed,
        lasting=findings.contacts_last([row for _, row in final.examined], states),
        barostat="barostat" in others,
        piston=any(drive.presses(run) for run in runs),
        before=max((run.pressure or 0.0 for run in runs), default=0.0),
        elastic=bounces(final, others),
        fluid=any(words in others for words in ("fluid", "buoyancy")),
    )
    grains = _contact_of_few(state_of(stage, drive.support(stage), final.options, around), final, around)
    clumped = MULTISPHERE in others or stage.contents.concentration > 1.0
    if clumped:  # whose arms and moments of inertia are not those of the sphere that stands for them
        grains = replace(grains, largest_stable_step=None, step_share=None)
    return grains


def bounces(final: System, others: str) -> bool:
    """Whether nothing dissipates in the last run, so that no grain comes to rest.

    One grain or two go on to bounce where they rub as well: friction takes nothing from head-on collisions.
    """
    newest = max((row.stage for row in final.rows), default=0)
    rows = [row for row in final.rows if row.stage == newest]
    count = final.last.contents.count
    few = count is not None and count <= FEW
    elastic = (1.0 - drive.ELASTIC < (row.restitution or 0.0) <= 1.0 + drive.ELASTIC for row in rows)
    return bool(rows) and not others and all(elastic) and (few or not any(map(rubs, rows)))


def rubs(row: CheckedContact) -> bool:
    """Whether a contact has friction, or one that is not known."""
    return row.friction.coefficient != 0.0


def _contact_of_few(grains: GrainState, final: System, around: loads.Around) -> GrainState:
    """The state of few grains, or of a gas of unknown packing or speed, with numbers of contacts, in SI units."""
    stage, loaded = final.last, final.options.load.rests or final.options.drive
    count, (_, length, time) = stage.contents.count, SCALES[stage.units]
    many = count is None or count > FEW
    falls = many or count == 1 or bool(stage.gravity)  # two others are asked for an impact
    overruled = loaded or around.state is not None or (final.options.speeds and not many)
    if falls and stage.contents.never_meet and grains.name == "gas" and not overruled:
        return replace(grains, never_meet=True)
    stated_speeds = [number.value for number in final.inferred if number.what == "speed"]
    speeds = final.options.speeds or tuple(stated_speeds)
    pressed = grains.name == "pressed"
    known = loaded or (pressed and grains.pressure is not None) or around.state is not None
    if many and around.cases and all(case.second is None for case in around.cases):
        count = 0.0  # none meets another one
    shaken = grains.name == "shaken" and grains.shaking is not None
    if known or shaken or (not speeds and stage.units == "lj"):
        return grains
    speed = max(speeds, default=CHOSEN_SPEEDS[-1] * time / length)
    if count is not None and 0 <= count <= FEW:
        usual = not final.options.speeds and any(number.source == SUPPOSED for number in final.inferred)
        state = few.with_contact(grains, around.cases, count, speed, stage.time_step, usual or not speeds)
        if pressed:  # no impact makes its overlap
            state = replace(
                grains,
                impact_speed=state.impact_speed,
                speed_is_chosen=state.speed_is_chosen,
                largest_stable_step=state.largest_stable_step,
                step_share=state.step_share,
            )
    elif grains.name == "gas" and not any(row.tc_nu for row in final.rows):
        gas, stream = final.gas, stage.contents.stream
        bound = stream is not None and gas.packing_fraction is None and not final.options.speeds
        gas = replace(gas, packing_fraction=stream) if bound else gas
        state = few.in_gas(grains, around.cases, gas, speed, not speeds)
        state = replace(state, tc_nu_is_bound=bound and state.supposed_tc_nu is not None)
    else:
        return grains
    if state.impact_speed is None:
        return state
    longest = state.largest_stable_step
    return replace(
        state,
        impact_speed=state.impact_speed * length / time,
        duration=state.duration and state.duration * time,
        largest_stable_step=None if longest is None else longest * time,
    )


def flowing(question: answer.Question, grains: GrainState, gravity: bool) -> answer.Question:
    """A flow under gravity that is collisional, or may be so, is driven, but no homogeneous gas."""
    if grains.name == "gas" and question.quantity == "stress":
        return replace(question, may_be_dense=True)
    if not (grains.may_separate and gravity):
        return question
    where = "a flow under gravity in"
    if grains.inertial_number is None:
        where = "a slope on" if grains.froude_number is None else "a drum in"
        where = where if grains.mixer_froude_number is None else "a mixer in"
    known = grains.regime == "collisional"
    how = "a collisional flow under gravity" if known else f"{where} which contacts may not last"
    return replace(question, driven=how)


def step_at_rest(grains: GrainState, system: System, last: Stage) -> corrections.LargestStep | None:
    """A safe time step of grains in lasting contact in the units of their run; None for other systems than the last."""
    longest = grains.largest_stable_step
    if longest is None or grains.regime == "collisional" or system.last is not last:
        return None
    share, contacts = at_rest.SAFE_SHARE, grains.coordination
    step = share * longest / SCALES[last.units][2]
    packing = "" if contacts is None else f" at {digits(contacts, 2)} contacts per grain"
    return corrections.LargestStep(step, f"{share:g} of the longest stable one{packing}")


def state_of(stage: Stage, support: drive.Support, options: Options, around: loads.Around) -> GrainState:
    """How grains are held together, in SI units; ``options`` are in the units of the run."""
    rate = None if options.drive is None else options.drive.shear_rate
    load = loads.load_of(stage, support, options.load, rate, around)
    state = at_rest.grain_state(around.cases, load, stage.time_step, around.dimension)
    mass, length, time = SCALES[stage.units]
    unit = mass / (length ** (around.dimension - 2) * time**2)
    sizes = {"largest_stable_step": time, "pressure": unit, "pressure_for_rigid": unit}
    sizes |= dict.fromkeys(
        ("height_for_rigid", "layers_height", "rolling_radius", "centrifuging_radius"), length
    )
    known = {name: getattr(state, name) for name in sizes}
    springs = [
        case.spring_powers for case in around.cases if case.spring and case.spring[0] == state.stiffness
    ]
    return replace(
        state,
        stiffness_unit=unit_of(springs[0], stage.units) if springs else None,
        **{name: value * sizes[name] for name, value in known.items() if value is not None},
    )


def words_of_state(state: GrainState, units: str, dimension: int = 3) -> str:
    """The sentence on how grains are held together, after a blank."""
    text = state_words.sentence(state, units == "lj", dimension)
    return f" {text}" if text else ""
