"""Table of the variables that a sweep can compute."""

from __future__ import annotations

from typing import Final

from .. import _core
from .computation import Variable

BALL: Final = "ball"

#: One value per point.
OF_POINT: Final = {
    "n_contacts": Variable(
        "uint8", "1", "ball–ball contacts of the sequence", stored="uint32", not_computed=2**32 - 1
    ),
    "relative_velocity": Variable("float64", "m/s", "v2 − v1 at t_f"),
    "separation_velocity": Variable("float64", "m/s", "v2 − v1 once no force acts"),
    "effective_restitution": Variable(
        "float64", "1", "ε of the independent-collisions model with the same v2 − v1 at t_f"
    ),
    "restitution_ratio": Variable("float64", "1", "effective over specified coefficient of restitution"),
    "t_end": Variable("float64", "s", "t_f, end of the last ball–ball contact of the sequence"),
    "t_floor_end": Variable("float64", "s", "first release from the floor"),
    "outcome": Variable(
        "uint8", "1", "how the computation ended, 0 = ok", flags=tuple(_core.outcome_names), not_computed=255
    ),
}

#: One value per ball.
OF_BALL: Final = {
    "rebound_height": Variable(
        "float64", "m", "greatest height of the centre between the first and the next floor contact", (BALL,)
    ),
    "final_velocity": Variable("float64", "m/s", "velocity at the end of the sequence, upwards", (BALL,)),
}

VARIABLES: Final = OF_POINT | OF_BALL

#: Defined for two balls only.
OF_TWO_BALLS: Final = tuple(name for name in OF_POINT if "velocity" in name or "restitution" in name)


def default_variables(balls: int) -> tuple[str, ...]:
    """The variables that a sweep computes if none are requested."""
    if balls == 2:
        return tuple(name for name in OF_POINT if name != "t_floor_end")
    return ("n_contacts", "rebound_height", "final_velocity", "t_end", "outcome")
