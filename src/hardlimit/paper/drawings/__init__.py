"""The paper's figures as pictures. Only drawing: every number comes from the Dataset of the figure."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from ...plots.style import style
from .caption import write_caption
from .counts import count_maps
from .density import density
from .forces import forces
from .ratios import ratio_over_gap, ratio_over_radii
from .sequences import contacts_over_restitution, same_material, viscoelastic

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["DRAWINGS", "density", "draw"]

DRAWINGS: Final[dict[int, Callable[[Any], Figure]]] = {
    2: forces,
    3: contacts_over_restitution,
    4: count_maps,
    5: ratio_over_gap,
    6: ratio_over_radii,
    7: viscoelastic,
    8: same_material,
}


def draw(number: int, data: xr.Dataset) -> Figure:
    """The picture of one figure; below it its parameters, and a sentence for users of event-driven simulations."""
    with style():
        figure = DRAWINGS[number](data)
        write_caption(figure, data)
    return figure
