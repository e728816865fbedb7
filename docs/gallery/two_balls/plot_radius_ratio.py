r"""
Where can the event-driven model be used?
=========================================

Separation velocity by Newton's equations minus that by independent collisions, over :math:`\varepsilon` and the
ratio of the radii, for a gap of 0.1 mm and one stiffness. White means agreement. The darker the blue, the
slower the balls separate under Newton's equations. Along the dotted line the floor contact ends when the balls
meet, by the paper's criterion

.. math:: \Delta h = V\left(t_{c,01} - \frac{2\beta\varepsilon}{\omega_0^2}\right).

Below it collisions are independent. Above it, a larger lower ball stays on the floor for longer,
:math:`t_{c,01} \propto \sqrt{m_1/k}`, and the event-driven model is wrong by metres per second. In the grey
corner the balls have not separated when the lower one meets the floor again.
"""

import numpy as np

import hardlimit as hl
from hardlimit import plots

axes = {"restitution": np.linspace(0.3, 1.0, 160), "radius_ratio": np.linspace(1.0, 6.0, 140)}
column = hl.Column.paper(gap=1e-4)
newton, collisions = (hl.sweep(column, model=model, **axes) for model in ("newton", "independent"))


def smallest_gap(restitution, radius_ratio):
    """Gap [m] from which on the floor contact is over before the balls meet."""
    drop = hl.Column.paper(restitution=restitution, radius_ratio=radius_ratio)
    floor = drop.contacts[0]
    return drop.impact_speed * (floor.duration() - floor.damping / floor.stiffness * restitution)


def with_criterion(figure):
    """The map, and where that gap is 0.1 mm."""
    points = [axis[::10] for axis in axes.values()]
    gaps = [[smallest_gap(e, ratio) for e in points[0]] for ratio in points[1]]
    figure.axes[0].contour(*points, gaps, levels=[1e-4], colors="black", linestyles="dotted")
    return figure


with_criterion(plots.difference_map(newton, collisions, "separation_velocity"))
