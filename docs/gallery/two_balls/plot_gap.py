r"""
How wide must the gap be for independent collisions?
====================================================

Rebound height of the small ball over the initial gap, for three coefficients of restitution. At the right the large
ball has left the floor before the small one arrives, and independent collisions (dashed) are right. The dotted line
is the paper's limit for :math:`\varepsilon = 0.9`,

.. math:: \Delta h > V\left(t_{c,01} - \frac{2\beta\varepsilon}{\omega_0^2}\right),

the distance by which the balls approach each other during the floor contact. It is 2.5 mm for these soft balls and
proportional to :math:`k^{-1/2}`. At the left the balls hit each other several times during the floor contact. The
rebound has a maximum for each number of contacts, and the small ball hardly returns to its initial height.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

gap = np.geomspace(1e-6, 2e-2, 700)

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.8))
    for restitution in (1.0, 0.9, 0.7):
        column = hl.Column.paper(restitution=restitution)
        tops = [
            hl.sweep(
                column, model=model, gap=gap, variables=["rebound_height"]
            ).rebound_height.isel(ball=1)
            for model in ("newton", "independent")
        ]
        (line,) = ax.plot(1e3 * gap, tops[0], label=rf"$\varepsilon$ = {restitution:g}")
        ax.plot(1e3 * gap, tops[1], color=line.get_color(), ls=(0, (5, 2)), lw=1.0)
    column = hl.Column.paper(restitution=0.9)
    floor = column.contacts[0]
    limit = column.impact_speed * (
        floor.duration() - floor.damping / floor.stiffness * 0.9
    )  # 2β/ω0² = γ/k
    ax.axvline(1e3 * limit, color="black", ls=":")
    ax.set(
        xscale="log",
        xlim=(1e-3, 20),
        ylim=(0, None),
        xlabel=r"initial gap $\Delta h$ [mm]",
    )
    ax.set_ylabel("maximum height of the small ball [m]")
    ax.legend(loc="center left", bbox_to_anchor=(0.0, 0.57))
print(f"limit: {1e3 * limit:.3f} mm")
plt.show()
