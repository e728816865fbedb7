"""The figures' data, each computed once when it is first asked for."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import ModuleType
from typing import Final

import xarray as xr

from .._core import version
from ..column.scenario import Column
from . import figure2, figure3, figure4, figure5, figure6, figure7, figure8
from .setup import RESTITUTION_2, RESTITUTION_5, RESTITUTION_6, Setup

FIGURES: Final[dict[int, ModuleType]] = {
    2: figure2,
    3: figure3,
    4: figure4,
    5: figure5,
    6: figure6,
    7: figure7,
    8: figure8,
}

SOURCE: Final = "P. Müller and T. Pöschel, Phys. Rev. E 83, 041304 (2011), doi:10.1103/PhysRevE.83.041304"


class Data:
    """The Datasets of the figures at one density."""

    def __init__(self, setup: Setup, progress: Callable[[float], object] = lambda part: None) -> None:
        self.setup = setup
        self.progress = progress
        self._figures: dict[int, xr.Dataset] = {}

    def figure(self, number: int) -> xr.Dataset:
        """The Dataset of one figure, with its origin, parameters and meaning as attributes."""
        if number not in self._figures:
            module = FIGURES[number]
            more = {"progress": self.progress} if number == 4 else {}
            data: xr.Dataset = module.compute(self.setup, **more)
            choices = data.attrs.get("choices", module.CHOICES)
            data.attrs = self.attributes(f"Fig. {number}") | {
                "title": module.TITLE,
                "meaning": module.meaning(data),
                "choices": choices,
                "parameters": json.dumps(self._parameters(number), ensure_ascii=False),
            }
            self._figures[number] = data
        return self._figures[number]

    def attributes(self, what: str) -> dict[str, str]:
        """Attributes that every data file carries."""
        return {
            "source_figure": f"{what} of {SOURCE}",
            "program": "hardlimit",
            "hardlimit_version": version,
            "units": "SI; every variable states its own",
        }

    def _parameters(self, number: int) -> dict[str, str | float]:
        """The column behind a figure: its numbers but for what the figure varies, and as an expression."""
        setup = self.setup
        column, varied = {
            3: (setup.linear(), ("restitution",)),
            4: (setup.linear(), ("restitution", "gap_m", "radius_1_m")),
            5: (setup.linear(RESTITUTION_5), ("gap_m",)),
            6: (setup.linear(RESTITUTION_6), ("radius_1_m",)),
            7: (setup.viscoelastic(RESTITUTION_2), ("restitution",)),
            8: (setup.same_material(1e-6), ("dissipative_time_s",)),
        }.get(number, (setup.linear(), ()))
        fixed = {name: value for name, value in parameters_of(column).items() if name not in varied}
        found: dict[str, str | float] = {**fixed, "density_kg_m3": setup.density, "column": repr(column)}
        if number == 7:
            found["column_inset"] = repr(setup.viscoelastic_inset(RESTITUTION_2))
        return found


def parameters_of(column: Column) -> dict[str, float]:
    """The numbers that describe one of the paper's columns, by name and unit."""
    lower, upper = column.balls
    law = {f"{name}{_UNITS.get(name, '')}": value for name, value in column.laws[0].parameters.items()}
    geometry = {"gap_m": column.gaps[0], "radius_1_m": lower.radius, "radius_2_m": upper.radius}
    return {**law, **geometry, "height_m": column.height}


_UNITS: Final = {
    "stiffness": "_N_m",
    "youngs_modulus": "_N_m2",
    "impact_speed": "_m_s",
    "dissipative_time": "_s",
}
