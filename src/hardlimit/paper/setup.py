"""The paper's columns. The density is inferred; everything else is a value of a caption or a sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from ..column.scenario import PAPER_DENSITY, Column
from ..contact.balls import Ball
from ..contact.laws import LAWS

#: Δh of Figs. 2, 3, 6, 7 and 8 [m], and R1/R2 of Figs. 2, 3 and 5.
GAP: Final = 1e-4
RADIUS_RATIO: Final = 10.0
#: ε of Figs. 2, 5 and 6.
RESTITUTION_2: Final = 0.7
RESTITUTION_5: Final = 0.9
RESTITUTION_6: Final = 0.8
#: Speed at which ε sets the dissipative time A in Fig. 7 [m/s]. The drop itself gives √(2gH) = 3.13 m/s.
INPUT_SPEED: Final = 3.0
#: Appendix B: Young's modulus of Figs. 7 and 8 and of the inset [N/m²], Poisson's ratio, upper radius [m].
YOUNGS_MODULUS: Final = 5e7
YOUNGS_MODULUS_INSET: Final = 6e9
POISSON_RATIO: Final = 0.45
RADIUS_2_APPENDIX: Final = 0.0025


@dataclass(frozen=True)
class Setup:
    """Columns of the paper at one density [kg/m³]."""

    density: float = PAPER_DENSITY

    def linear(self, restitution: float = RESTITUTION_2, **changes: Any) -> Column:
        """The drop of Fig. 2 with changes."""
        return Column.paper(restitution=restitution, density=self.density, **changes)

    def viscoelastic(self, restitution: float, **changes: Any) -> Column:
        """Fig. 7: each contact has its own A, set by one ε at 3 m/s."""
        law = LAWS["viscoelastic"](
            youngs_modulus=YOUNGS_MODULUS,
            poisson_ratio=POISSON_RATIO,
            restitution=restitution,
            impact_speed=INPUT_SPEED,
        )
        return Column.paper(law=law, density=self.density, **{"radius_2": RADIUS_2_APPENDIX, **changes})

    def viscoelastic_inset(self, restitution: float) -> Column:
        """Inset of Fig. 7: the geometry of Fig. 3, Young's modulus matched to k."""
        law = LAWS["viscoelastic"](
            youngs_modulus=YOUNGS_MODULUS_INSET,
            poisson_ratio=POISSON_RATIO,
            restitution=restitution,
            impact_speed=INPUT_SPEED,
        )
        return Column.paper(law=law, density=self.density)

    def same_material(self, dissipative_time: float) -> Column:
        """Fig. 8: one A for both contacts."""
        law = LAWS["viscoelastic"](
            youngs_modulus=YOUNGS_MODULUS, poisson_ratio=POISSON_RATIO, dissipative_time=dissipative_time
        )
        return Column.paper(law=law, density=self.density, radius_2=RADIUS_2_APPENDIX)

    def mass_ratio(self, mu: float, restitution: float = 1.0, gap: float = 1e-12) -> Column:
        """Two balls of Fig. 2's radii with m2/m1 = ``mu``, for limits of the independent-collisions model."""
        paper = self.linear(restitution)
        lower = paper.balls[0]
        upper = Ball(paper.balls[1].radius, mass=mu * lower.mass)
        return Column([lower, upper], [gap], paper.height, paper.laws[0], gravity=paper.gravity)
