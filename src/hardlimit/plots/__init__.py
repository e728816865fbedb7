"""Pictures of results. Only drawing: every number comes from a result.

All pictures share one style (:func:`style`), one palette that colour-blind readers can tell apart, and one
colour for each number of contacts (:func:`count_colours`), so that pictures can be compared with each other.
This module gathers what may be called; each subject has a module of its own.
"""

from .contacts import restitution_obtained, restitution_over_speed
from .drop import drop
from .fidelity import fidelity
from .fit import fit
from .forces import forces
from .gas import gas
from .heights import heights
from .maps import count_map, difference_map, sweep_map
from .stack import stack
from .style import count_colours, save, style

__all__ = [
    "count_colours",
    "count_map",
    "difference_map",
    "drop",
    "fidelity",
    "fit",
    "forces",
    "gas",
    "heights",
    "restitution_obtained",
    "restitution_over_speed",
    "save",
    "stack",
    "style",
    "sweep_map",
]
