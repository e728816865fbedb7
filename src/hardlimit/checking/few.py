"""Numbers of single contacts: of one or two grains at their impact, of a gas at a supposed packing and speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from ..convert.force import AdhesiveForce
from .at_rest import GrainState, Springs, springs_of, stable_step
from .contacts import Case, Surroundings, collision_of

#: Packing fraction of a gas whose own is not known.
SUPPOSED_PACKING: Final = 0.1


def with_contact(
    state: GrainState,
    cases: Sequence[Case],
    count: float,
    speed: float,
    time_step: float | None,
    chosen: bool,
) -> GrainState:
    """The state with the numbers of its deepest contact at an impact speed, in the units of the cases.

    Contacts of unknown sizes, masses or forces are left out. ``chosen``: whether the speed is none of the script.
    """
    walls = [case for case in cases if case.second is None]
    cases = walls if count == 1 and walls else cases
    contacts = []
    for case in cases:
        bodies = [body for body in (case.first, case.second) if body is not None]
        if case.force is None or any(body.radius is None or body.mass is None for body in bodies):
            continue
        force = case.force(case.first.tried(0), None if case.second is None else case.second.tried(0), speed)
        if not isinstance(force, AdhesiveForce):
            collision = collision_of(force, speed, case.numerical_damping)
            smaller = min(body.radius or 0.0 for body in bodies)
            contacts.append((collision.compression / smaller, collision, case))
    if not contacts or len(contacts) < len(cases):
        return state
    overlap, collision, _ = max(contacts, key=lambda contact: contact[0])
    steps = [isolated_step(case, each.compression) for _, each, case in contacts]
    longest = None if None in steps else min(step for step in steps if step is not None)
    return GrainState(
        state.name,
        shaking=state.shaking,
        grains=int(count),
        impact_speed=speed,
        speed_is_chosen=chosen,
        restitution=collision.restitution,
        duration=collision.duration,
        overlap=overlap,
        largest_stable_step=longest,
        step_share=None if longest is None or time_step is None else time_step / longest,
    )


def isolated_step(case: Case, overlap: float) -> float | None:
    """Longest stable time step of a contact without others at its largest overlap; None if its friction is not known.

    The modes of two spheres: k_n/m with the reduced mass along the normal, k_t (1 + 1/q)/m along the surfaces.
    """
    springs = springs_of(case, overlap)
    if springs is None:
        return None
    bodies = [body for body in (case.first, case.second) if body is not None]
    inverse = sum(0.0 if body.fixed else 1.0 / body.mass for body in bodies if body.mass is not None)
    inertia = min(body.inertia_factor for body in bodies)

    def largest(stiffened: Springs) -> float:
        return inverse * max(stiffened.normal, stiffened.tangential * (1.0 + 1.0 / inertia))

    return stable_step(lambda step: largest(springs.stiffened(step)))


def in_gas(
    state: GrainState, cases: Sequence[Case], gas: Surroundings, speed: float, chosen: bool
) -> GrainState:
    """The state of a gas with the largest t_c ν at this mean impact speed, at a supposed packing if it has none."""
    packing = SUPPOSED_PACKING if gas.packing_fraction is None else gas.packing_fraction
    around = replace(gas, packing_fraction=packing)
    numbers = []
    for case in cases:
        second = case.second
        if case.force is None or second is None or case.first.radius is None or second.radius is None:
            continue
        if case.first.mass is None or second.mass is None:
            continue
        force = case.force(case.first.tried(0), second.tried(0), speed)
        if not isinstance(force, AdhesiveForce):
            duration = collision_of(force, speed, case.numerical_damping).duration
            numbers.append(duration * around.collision_rate(speed, case.first.radius + second.radius))
    if not numbers or not math.isfinite(max(numbers)):
        return state
    return replace(
        state,
        supposed_tc_nu=max(numbers),
        packing_fraction=packing,
        impact_speed=speed,
        speed_is_chosen=chosen,
    )
