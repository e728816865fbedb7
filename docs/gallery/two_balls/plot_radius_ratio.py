r"""
Where is the event-driven model valid?
======================================

Separation velocity of Newton's equations minus that of independent collisions, over :math:`\varepsilon` and the
ratio of radii, for a gap of 0.1 mm and one stiffness. White is agreement; the darker the blue, the slower the balls
actually separate. Along the dotted line the floor contact ends when the balls meet, by the paper's criterion

.. math:: \Delta h = V\left(t_{c,01} - \frac{2\beta\varepsilon}{\omega_0^2}\right).

Below it collisions are independent. Above it, a larger lower ball stays on the floor longer,
:math:`t_{c,01} \propto \sqrt{m_1/k}`, and the event-driven model is wrong by metres per second. In the grey corner the
balls have not separated when the lower one hits the floor again.
"""

import numpy as np

import hardlimit as hl
from hardlimit import plots

axes = {
    "restitution": np.linspace(0.3, 1.0, 160),
    "radius_ratio": np.linspace(1.0, 6.0, 140),
}
column = hl.Column.paper(gap=1e-4)
newton, collisions = (
    hl.sweep(column, model=model, **axes) for model in ("newton", "independent")
)


def smallest_gap(restitution, radius_ratio):
    """Smallest gap [m] for which the floor contact ends before the balls meet."""
    drop = hl.Column.paper(restitution=restitution, radius_ratio=radius_ratio)
    floor = drop.contacts[0]
    return drop.impact_speed * (
        floor.duration() - floor.damping / floor.stiffness * restitution
    )


def with_criterion(figure):
    """The map with a dotted line where this gap is 0.1 mm."""
    points = [axis[::10] for axis in axes.values()]
    gaps = [[smallest_gap(e, ratio) for e in points[0]] for ratio in points[1]]
    figure.axes[0].contour(
        *points, gaps, levels=[1e-4], colors="black", linestyles="dotted"
    )
    return figure


with_criterion(plots.difference_map(newton, collisions, "separation_velocity"))
