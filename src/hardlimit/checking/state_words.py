"""The number of grains that rest, are pressed, flow or are shaken, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..contact import compression
from ..support.formatting import digits, length, listed, percent, quantity
from . import flows
from .answer import stiffness
from .at_rest import LAYERS, QUASI_STATIC, RIGID, THROWN, USUAL_STEP, GrainState
from .result import Verdict
from .scripts.motion import STEEP

#: What is known of shaken columns: studies/shaken_column.nc.
BEADS = "in a shaken column of N beads all models agree up to about N(1 − ε) = 1"
VERBS = {
    "shaken": "Grains rest under",
    "rest": "Grains rest under",
    "pressed": "Grains are under",
    "flow": "Grains flow under",
}


def sentence(state: GrainState, plain: bool, dimension: int) -> str:
    """The sentence after the answer, in at most about 260 letters; empty for a gas. ``plain``: in ``lj`` units."""
    if state.grains is not None:
        return " ".join(f"{part}." for part in (_few(state, plain), _step(state, plain)) if part)
    if state.supposed_tc_nu is not None and state.tc_nu_is_bound:
        at = f"φ ≤ {digits(state.packing_fraction or 0.0, 2)} at its face, which grains leave beside others with up to"
        return (
            f"In the stream t_c ν is at most {digits(state.supposed_tc_nu, 2)}: {at} {_speed(state, plain)}."
        )
    if state.supposed_tc_nu is not None:
        at = f"φ = {digits(state.packing_fraction or 0.0, 2)} and {_speed(state, plain)}"
        return f"With {at} (not both are known) t_c ν would be {digits(state.supposed_tc_nu, 2)}."
    if state.name == "gas":
        return ""
    if state.name == "shaken" and state.shaking is not None:
        strength = state.shaking_strength
        shown = "" if strength is None else f"; S = (Aω)²/(g d) = {digits(strength, 2)}"
        return f"Grains leave a floor with Γ > 1{shown}: {BEADS}."
    parts = [_softness(state, plain, dimension)]
    if state.inertial_number is not None:
        parts.append(_inertial(state))
    elif state.name == "flow":
        parts.append(_needed(state))
        parts.insert(0, _drum(state, plain))
    elif state.name == "rest" and ((state.tilt or 0.0) >= STEEP or state.may_slide):
        parts.insert(0, _slope(state))
    if state.regime != "collisional":
        parts.append(_step(state, plain))
    return " ".join(f"{part}." for part in parts if part)


def _needed(state: GrainState) -> str:
    """The options that would give the inertial number of a flow."""
    options = [f"--{name}" for name in state.inertial_number_needs]
    options = ["--shear (of the flowing layer)" if name == "--shear" else name for name in options]
    return f"{listed(options)} {'gives' if len(options) == 1 else 'give'} the inertial number"


def _inertial(state: GrainState) -> str:
    """The inertial number, if the pressure has only a bound up to that below one layer of grains, and the regime."""
    text = f"I = γ̇ d √(ρ/p) = {digits(state.inertial_number or 0.0, 2)}"
    if state.largest_inertial_number is not None:
        text += f" to {digits(state.largest_inertial_number, 2)} (below one layer of grains)"
    border = digits(state.collisional_from or 0.0, 2)
    if state.regime is None:
        return f"{text}; contacts last below I = {border}; --pressure gives its own"
    return f"{text}: {state.regime} flow" + f" (collisional from {border})" * (state.regime == "dense")


def _flows(state: GrainState) -> bool:
    """Whether grains flow too fast for the contacts of a packing at rest, or may do so."""
    return state.inertial_number is not None and state.regime != "quasi-static"


def _slope(state: GrainState) -> str:
    """How a deep layer flows down a slope."""
    tilted = f"Gravity is tilted by {digits(state.tilt or 0.0, 2)}°"
    if state.slope_inertial_number is None or state.rest_angle is None:
        return f"{tilted}: if they flow, --shear gives I = γ̇ d √(ρ/p)"
    low, high = state.slope_inertial_number
    border = f"; contacts last below I = {digits(state.collisional_from or 0.0, 2)}" * state.may_separate
    deep, rests = f"{tilted}: on a rough base a deep layer", f"rests below {digits(state.rest_angle, 2)}°"
    if high == 0.0:
        return f"{deep} {rests}"
    if not math.isfinite(high):
        fast = "gets faster and faster, or" if not math.isfinite(low) else "may get faster and faster, or"
        return (
            f"{deep} {fast} flows with I > {digits(low if math.isfinite(low) else flows.FASTEST, 2)}{border}"
        )
    numbers = f"I = {digits(low, 2)} to {digits(high, 2)}" if low else f"I up to {digits(high, 2)}, or rests"
    flows_with = f"{deep} flows with {numbers}, on a flat one it may slide faster"
    return f"{flows_with}{border}; it {rests}; --shear gives its own I"


def _drum(state: GrainState, plain: bool) -> str:
    """How a drum moves its grains."""
    if state.froude_number is not None:
        froude = state.froude_number
        return f"The drum turns with Fr = ω²R/g = {digits(froude, 2)}: {flows.way_of(froude)}"
    if state.mixer_froude_number is not None:
        at = f"Fr = ω²R/g = {digits(state.mixer_froude_number, 2)} at the side of the box"
        return f"What turns about gravity has {at}; it throws grains from about 1 on"
    if state.centrifuging_radius is None:
        return ""
    radii = (state.rolling_radius or 0.0, THROWN * state.centrifuging_radius, state.centrifuging_radius)
    rolls, throws, whirls = (digits(x, 2) if plain else length(float(f"{x:.2g}")) for x in radii)
    if state.rolling_radius is None:
        return f"A drum that turns so throws its grains from R = {throws} on (Fr = ω²R/g = 0.1)"
    rolling = f"In a drum that turns so grains roll up to R = {rolls} (Fr = ω²R/g = 0.01)"
    return f"{rolling}, are thrown from {throws} on (0.1), and turn with it from {whirls} on (1)"


def _speed(state: GrainState, plain: bool) -> str:
    return digits(state.impact_speed or 0.0, 2) + " m/s" * (not plain)


def _pressure(value: float, plain: bool, dimension: int, figures: int) -> str:
    return digits(value, figures) if plain else quantity(value, "N/m" if dimension == 2 else "Pa", figures)


def _few(state: GrainState, plain: bool) -> str:
    """The contact of one or two grains at its impact."""
    at, duration = _speed(state, plain), state.duration or 0.0
    lasts = digits(duration, 2) if plain else quantity(duration, "s", 2)
    supposed = " (supposed; --speed gives another)" * state.speed_is_chosen
    which = {0: "Grains meet walls", 1: "One grain", 2: "Two grains"}[state.grains or 0]
    numbers = f"ε = {digits(state.restitution or 0.0, 2)}, the force lasts {lasts}"
    return f"{which} only: at {at}{supposed} {numbers}, overlap {percent(state.overlap or 0.0)} of R"


def _softness(state: GrainState, plain: bool, dimension: int) -> str:
    """Pressure, κ_p, overlap, and the stiffness at the border of rigid grains."""
    if state.pressure is None:
        options = "--pressure or --height" if state.name == "rest" else "--pressure"
        return _border(state, plain, dimension, options)
    least, most = (" ≥", "at most ") if state.pressure_is_bound else (" =", "")
    least, most = (" ≤", "at least ") if state.pressure_is_least else (least, most)
    shown = f"{'p = ' * plain}{_pressure(state.pressure, plain, dimension, 3)}"
    verb = VERBS["pressed" if state.may_slide else state.name]
    text = f"{verb} {most}{shown}{f' ({state.pressure_from})' * bool(state.pressure_from)}"
    kappa = state.stiffness_number
    if kappa is None or state.regime == "collisional":
        return text
    text += f": κ_p{least} {digits(kappa, 2)}"
    if state.overlap is None:
        return f"{text} without the adhesion, which adds to the overlap; rigid from κ_p = 1e4 on"
    if _too_deep(state):
        text += ", softer than contact laws describe" * (not state.pressure_is_bound)
    elif not (_flows(state) or state.may_slide):  # flows have fewer contacts and larger overlaps
        overlap = percent(state.overlap or 0.0)
        if state.overlap_range is not None and state.pressure_is_least:
            overlap = percent(state.overlap_range[0])
        elif state.overlap_range is not None and not most and not overlap.startswith("less"):
            low, high = map(percent, state.overlap_range)
            overlap = f"{low.removesuffix(' %')} to {high}"
        text += f", overlap {'' if overlap.startswith('less') else most}{overlap} of R"
    if state.stiffness is None or state.stiffness_for_rigid is None:
        return f"{text}; rigid from κ_p = 1e4 on"
    value = f"{digits(state.stiffness_for_rigid, 2)} {state.stiffness_unit or ''}".rstrip()
    bound = " or less" if state.pressure_is_bound else " or more" if state.pressure_is_least else ""
    needed = f"{stiffness(state.stiffness)} of {value}{bound}"
    return f"{text}; {'still rigid (1e4) at' if kappa >= RIGID else 'rigid grains (1e4) take'} {needed}"


def _too_deep(state: GrainState) -> bool:
    """Whether the overlap is larger than any that contact laws describe."""
    return (state.overlap or 0.0) > compression.DEEPEST


def _border(state: GrainState, plain: bool, dimension: int, options: str) -> str:
    """What is known without the pressure: numbers below some layers, and up to where grains are rigid."""
    border, depth, layers = state.pressure_for_rigid, state.height_for_rigid, state.layers_height
    if border is None:
        return f"Give {options} to know how soft they are"
    if depth is None or layers is None:
        limit = _pressure(border, plain, dimension, 2)
        return f"Grains are rigid (κ_p ≥ 1e4) up to p = {limit}; {options} gives their own κ_p"
    heights = [digits(x, 2) if plain else length(float(f"{x:.2g}")) for x in (layers, depth)]
    kappa, overlap = digits(state.layers_stiffness_number or 0.0, 2), percent(state.layers_overlap or 0.0)
    number = state.layers or LAYERS
    few = ", as in a slender column" if number < LAYERS else ""
    few = ", as high as the box" if state.layers_fill else few
    below = f"Below {number} layers ({heights[0]}{few}) κ_p = {kappa}, overlap {overlap} of R"
    rigid = (
        f"rigid (1e4) below {heights[1]}" if depth >= layers / number else "not rigid (1e4) below one layer"
    )
    return f"{below}; {rigid}; {options} gives their own"


def _step(state: GrainState, plain: bool) -> str:
    """The longest stable step, and that of the script over it."""
    longest = state.largest_stable_step
    if longest is None:
        return ""
    limit = digits(longest, 2) if plain else quantity(longest, "s", 2)
    if state.step_is_supposed:
        limit += " up to this pressure" if state.layers_height is None else f" below {state.layers} layers"
    if state.step_share is None:
        return f"Steps are stable below {limit}"
    ends = ("at most ", "at least ") if state.step_is_bound else ("", "")
    share, longest_one = ends[::-1] if state.pressure_is_least else ends
    return f"The step is {share}{digits(state.step_share, 2)} of the longest stable one, {longest_one}{limit}"


def details(verdict: Verdict) -> Iterator[str]:
    """The numbers behind the sentence."""
    state, plain = verdict.state, verdict.units == "lj"
    if state.coordination is not None:
        packing = f"φ = {digits(state.packing_fraction or 0.0, 3)}, {digits(state.coordination, 3)} contacts per grain"
        yield f"Packing at rest: {packing}."
    if _too_deep(state):
        pass
    elif (_flows(state) or state.may_slide) and state.overlap is not None:
        rest = f"{percent(state.overlap)} of R"
        yield f"At rest the overlap would be {rest}; in dense flow fewer contacts carry, and it is 1 to 8 times that."
    elif state.deepest_overlap is not None:
        deepest = percent(state.deepest_overlap)
        yield f"The overlap is the mean of all contacts at this pressure; the deepest are about {deepest} of R."
    elif state.overlap_of == "the softest contacts":
        yield "The overlap is that of the softest contacts: it is not known how many grains of each kind there are."
    elif state.overlap is not None:
        yield "The overlap is the mean of all contacts at this pressure, over the smaller radius of both grains."
    if state.overlap_range is not None and state.smooth_overlap is not None and not _flows(state):
        smooth = f"those compressed before they got it overlap by about {percent(state.smooth_overlap)} of R"
        yield f"The range is that of ways to compress grains with their friction; {smooth}."
    if state.packing_excess is not None and state.coordination_excess is not None:
        denser, more = percent(state.packing_excess), percent(state.coordination_excess)
        yield f"Packings of such grains are {denser} denser than those of rigid ones and have {more} more contacts."
    if state.measured_from is not None and state.overlap is not None:
        yield f"Packings were measured from κ_p = {digits(state.measured_from, 3)} on; contacts are as many as there."
    rows = [row for row in verdict.rows if row.stage == max((r.stage for r in verdict.rows), default=1)]
    usual = [row.duration / USUAL_STEP for row in rows if row.duration]
    rayleigh = [row.rayleigh_time for row in rows if row.rayleigh_time]
    if state.largest_stable_step is not None and usual:

        def time(value: float) -> str:
            return digits(value, 3) if plain else quantity(value, "s", 3)

        beside = f", Rayleigh's time {time(min(rayleigh))}" if rayleigh else ""
        yield f"Longest stable step at rest {time(state.largest_stable_step)}; t_c/50 is {time(min(usual))}{beside}."
    if state.inertial_number is not None:
        border = digits(state.collisional_from or 0.0, 2)
        lasting = "where contacts last less than twice as long as a collision, on average"
        yield f"Flow: quasi-static up to I = {QUASI_STATIC:g}, collisional above {border}, {lasting}."
