"""Plots and films of results. These modules only draw; all numbers come from results.

All pictures share a style (:func:`style`), a palette for colour-blind readers, and a colour for each number of contacts
(:func:`count_colours`).
"""

from .contacts import restitution_obtained, restitution_over_speed, tangential_restitution
from .fidelity import fidelity
from .fit import fit
from .forces import forces
from .gas import gas
from .heights import drop, heights
from .impact import impact
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
    "impact",
    "restitution_obtained",
    "restitution_over_speed",
    "save",
    "stack",
    "style",
    "sweep_map",
    "tangential_restitution",
]
