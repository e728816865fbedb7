"""The gas around contacts, and the contacts at their impact speeds in it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from . import cases, drive, dumps
from .contacts import AGREEMENT, Case, CheckedContact, Surroundings, examine
from .expectation import checked_packing_fraction
from .options import Options
from .scripts import Stage


def frames(options: Options) -> list[dumps.Frame]:
    """The frames of the dump, if there is one."""
    return [] if options.dump is None else dumps.read(options.dump)


def states(
    frames: Sequence[dumps.Frame],
    radii: Mapping[str, float],
    dimension: int,
    densities: Mapping[str, float],
) -> tuple[dumps.State, ...]:
    """What each frame of a dump shows."""
    return tuple(dumps.state(frame, radii, dimension, densities) for frame in frames)


def _busiest(states: Sequence[dumps.State]) -> dumps.State | None:
    """The frame with the largest temperature, in which t_c ν is largest; the last if there are no velocities."""
    return max(states, key=lambda state: (state.temperature or 0.0, state.step), default=None)


def gas(
    options: Options, states: Sequence[dumps.State], dimension: int
) -> tuple[Surroundings, tuple[float, ...]]:
    """The gas, and the impact speeds at which contacts are examined; options come before the dump."""
    state = _busiest(states)
    phi = options.packing_fraction
    if phi is not None:
        phi = checked_packing_fraction(phi, dimension)
    elif state is not None and state.packing_fraction is not None:
        phi = min(state.packing_fraction, 0.99)
    measured = state is not None and bool(state.temperature) and not options.speeds and options.drive is None
    gas = Surroundings(
        dimension,
        phi,
        state.mean_speed if measured and state else None,
        state.mean_diameter if measured and state else None,
        restitution_error=options.restitution_error,
    )
    return gas, options.speeds or (state.speeds if state and options.drive is None else ())


def examined(
    contacts: Sequence[Case],
    gas: Surroundings,
    speeds: Sequence[float],
    driven: drive.Drive | None,
    purpose: drive.Drive | None,
    chosen: Sequence[float] = (),
) -> list[tuple[Case, CheckedContact]]:
    """Each contact at each speed. Normal impact speeds at a wall are 1/√2 of those of grains in a gas.

    ``driven``: what determines the speed. ``purpose``: what the box is run for. ``chosen``: speeds for contacts that
    depend on the speed if there is none.
    """
    at_wall = math.sqrt(0.5) if gas.mean_speed is not None or driven is not None else 1.0
    between = [case for case in contacts if case.second is not None]
    bodies = [body for case in between for body in (case.first, case.second) if body and not body.fixed]
    gas = replace(
        gas,
        frictions=tuple({case.friction.coefficient for case in between}),
        inertia_factors=tuple({body.inertia_factor for body in bodies}),
    )
    rows = []
    for case in contacts:
        at, where = speeds, gas
        grain = None if purpose is None else purpose.gas(case, gas.dimension, gas.packing_fraction)
        if purpose is not None and grain is not None:
            share = None if purpose.bath is None else partial(purpose.heat_share, grain)
            missing = partial(purpose.without_friction, case, grain)
            where = replace(gas, heat_share=share, without_friction=missing, heats_spins=purpose.heats_spins)
        steady = None if driven is None else driven.steady(case, gas.dimension, gas.packing_fraction)
        if driven is not None:
            at = () if steady is None else (steady.speed,)
            where = replace(where, mean_speed=None if steady is None else steady.speed)
        values = [v * (at_wall if case.second is None else 1.0) for v in at]
        each = examine(case, values or [None], where)
        if not values and chosen and (each[0].duration is None or each[0].restitution is None):
            at_chosen = examine(case, chosen, where)
            each = at_chosen if _differ(at_chosen) else each
        ratio = None if steady is None else steady.temperature_ratio
        rows += [(case, replace(row, temperature_ratio=ratio)) for row in each]
    return rows


def _differ(rows: Sequence[CheckedContact]) -> bool:
    """Whether a contact at several speeds has more than one ε, or durations and overlaps, which depend on them."""
    known = [row.restitution for row in rows if row.restitution is not None]
    same = len(known) == len(rows) and max(known) - min(known) < AGREEMENT
    return not same or any(row.duration is not None for row in rows)


def radii(stage: Stage) -> dict[str, float]:
    """The radius of each type with one size."""
    return {
        name: grains.radii[0]
        for name, grains in stage.grains.items()
        if grains.radii is not None and grains.radii[0] == grains.radii[1]
    }


def densities(stage: Stage) -> dict[str, float]:
    """The density of each type whose density is known and the same for all its grains."""
    bodies = {name: [cases.body(grains, end) for end in (0, 1)] for name, grains in stage.grains.items()}
    return {
        name: ends[0].density
        for name, ends in bodies.items()
        if ends[0].density is not None and ends[0].density == ends[1].density
    }
