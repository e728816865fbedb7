"""Measurements in boxes of grains: structure, velocities, spins, diffusion, error bars of steady states.

A function of a state takes a ``ParticleSystem`` and returns a labelled xarray object. ``observe={"rdf": measure.rdf}``
of a run calls it at each sample. A function of a run takes its result or a variable of its ``series``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .motion import diffusion, msd, paths
from .pairs import coordination, rdf
from .rotation import a02, a11, alignment
from .stability import largest_stable_time_step
from .steadiness import Steady, contact_value, steady
from .stress import antisymmetric_stress, pressure_tensor
from .velocities import a2, granular_temperature, profiles

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Steady",
    "a02",
    "a2",
    "a11",
    "alignment",
    "antisymmetric_stress",
    "contact_value",
    "coordination",
    "diffusion",
    "granular_temperature",
    "largest_stable_time_step",
    "msd",
    "paths",
    "plot",
    "pressure_tensor",
    "profiles",
    "rdf",
    "steady",
]


def plot(measured: Any) -> Figure:
    """Plot a measurement.

    A quantity over one coordinate is a line, over ``time`` and another coordinate a map; a Dataset has a panel for each
    of its variables, a pressure tensor bars of its parts. Colours are those of Okabe & Ito (2008).

    Parameters
    ----------
    measured : DataArray, Dataset or Steady
        Result of a function of ``hl.measure``, or a variable of the series of a run.

    Raises
    ------
    ValueError
        If it is none of these, or has no coordinate to plot it over.
    """
    from ..plots import measured as pictures

    return pictures.measured(measured)
