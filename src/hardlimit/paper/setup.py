"""The paper's columns and constants. The density is inferred; all other values are printed in the paper."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any, Final

import xarray as xr

from .._core import version
from ..column.scenario import PAPER_DENSITY, Column
from ..contact.balls import Ball
from ..contact.laws import LAWS

SOURCE: Final = "P. Müller and T. Pöschel, Phys. Rev. E 83, 041304 (2011), doi:10.1103/PhysRevE.83.041304"

#: Δh of Figs. 2, 3, 6, 7 and 8 [m]; R1/R2 of Figs. 2, 3 and 5; ε of Fig. 2.
GAP: Final = 1e-4
RADIUS_RATIO: Final = 10.0
RESTITUTION: Final = 0.7
#: Radius of the upper ball in Figs. 2 to 6 [m].
RADIUS_2: Final = 0.01
#: Speed at which ε sets the dissipative time A in Fig. 7 [m/s]. The lower ball hits the floor at √(2gH) = 3.13 m/s.
INPUT_SPEED: Final = 3.0
#: Appendix B: Young's modulus of Figs. 7 and 8 and of the inset [N/m²], Poisson's ratio, upper radius [m].
YOUNGS_MODULUS: Final = 5e7
YOUNGS_MODULUS_INSET: Final = 6e9
POISSON_RATIO: Final = 0.45
RADIUS_2_APPENDIX: Final = 0.0025


class Paper:
    """The paper's columns at one density [kg/m³], and the Dataset of each figure.

    ``progress(part)`` is called with the finished fraction of the current step, 0 to 1. ``modules`` compute the
    figures: ``FIGURES`` of the registry.
    """

    def __init__(
        self,
        density: float = PAPER_DENSITY,
        progress: Callable[[float], object] = lambda part: None,
        modules: Mapping[int, ModuleType] = {},
    ) -> None:
        self.density = density
        self.progress = progress
        self.modules = modules
        self._figures: dict[int, xr.Dataset] = {}

    def linear(self, restitution: float = RESTITUTION, **changes: Any) -> Column:
        """The column of Fig. 2; keyword arguments change it."""
        return Column.paper(restitution=restitution, density=self.density, **changes)

    def viscoelastic(self, restitution: float = RESTITUTION) -> Column:
        """Fig. 7: each contact has its own A, set by one ε at 3 m/s."""
        return self._spheres(
            YOUNGS_MODULUS, RADIUS_2_APPENDIX, restitution=restitution, impact_speed=INPUT_SPEED
        )

    def viscoelastic_inset(self, restitution: float = RESTITUTION) -> Column:
        """Inset of Fig. 7: the geometry of Fig. 3, Young's modulus matched to k."""
        return self._spheres(
            YOUNGS_MODULUS_INSET, RADIUS_2, restitution=restitution, impact_speed=INPUT_SPEED
        )

    def same_material(self, dissipative_time: float) -> Column:
        """Fig. 8: one A for both contacts."""
        return self._spheres(YOUNGS_MODULUS, RADIUS_2_APPENDIX, dissipative_time=dissipative_time)

    def _spheres(self, youngs_modulus: float, radius_2: float, **dissipation: float) -> Column:
        law = LAWS["viscoelastic"](youngs_modulus=youngs_modulus, poisson_ratio=POISSON_RATIO, **dissipation)
        return Column.paper(law=law, density=self.density, radius_2=radius_2)

    def mass_ratio(self, mu: float, gap: float = 1e-12) -> Column:
        """Elastic balls of Fig. 2's radii with m2/m1 = ``mu``, for limits of the independent-collisions model."""
        paper = self.linear(1.0)
        lower = paper.balls[0]
        upper = Ball(paper.balls[1].radius, mass=mu * lower.mass)
        return Column([lower, upper], [gap], paper.height, paper.laws[0], gravity=paper.gravity)

    def figure(self, number: int) -> xr.Dataset:
        """The Dataset of a figure, computed at the first call; attributes give origin, parameters and meaning."""
        if number not in self._figures:
            figure = self.modules[number]
            data = figure.compute(self)
            data.attrs = self.attributes(f"Fig. {number}") | {
                "title": figure.TITLE,
                "meaning": figure.meaning(data),
                "choices": data.attrs.get("choices", figure.CHOICES),
                "parameters": json.dumps(figure.parameters(self), ensure_ascii=False),
            }
            self._figures[number] = data
        return self._figures[number]

    def attributes(self, what: str) -> dict[str, str]:
        """The attributes of every data file."""
        return {
            "source_figure": f"{what} of {SOURCE}",
            "program": "hardlimit",
            "hardlimit_version": version,
            "units": "SI; every variable states its own",
        }

    def parameters(self, column: Column, *varied: str) -> dict[str, str | float]:
        """The parameters of a column by name and unit, without those that the figure varies."""
        lower, upper = column.balls
        values = {f"{name}{UNITS.get(name, '')}": value for name, value in column.laws[0].parameters.items()}
        values |= {"gap_m": column.gaps[0], "radius_1_m": lower.radius, "radius_2_m": upper.radius}
        values["height_m"] = column.height
        fixed = {name: value for name, value in values.items() if name not in varied}
        return {**fixed, "density_kg_m3": self.density, "column": repr(column)}


UNITS: Final = {
    "stiffness": "_N_m",
    "youngs_modulus": "_N_m2",
    "impact_speed": "_m_s",
    "dissipative_time": "_s",
}
