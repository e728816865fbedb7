r"""
Is a lighter ball on top always better?
=======================================

For collisions, yes: the speed of the upper of two elastic balls is :math:`V(3-\mu)/(1+\mu)` with
:math:`\mu = m_2/m_1` (Eq. 5 of the paper). It approaches :math:`3V`, nine times the height, for a light ball. If the
balls touch, a light ball follows the heavy one and leaves with hardly more than :math:`V`. The best ratio depends on
the stiffness of the ball–ball contact relative to that of the floor contact: 1/2 with :math:`1.33\,V` for equal
stiffness. A softer ball–ball contact is closer to collisions, because the floor has done most of its work before the
balls begin to push each other.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

ratios = np.geomspace(1e-3, 1.0, 80)
floor = hl.LinearDashpot(stiffness=1e7, restitution=1.0)

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    for factor in (0.2, 1.0, 5.0):
        laws = [floor, floor.replace(stiffness=factor * floor.stiffness)]
        speeds = []
        for ratio in ratios:
            balls = [hl.Ball(0.1, mass=1.0), hl.Ball(0.05, mass=ratio)]
            column = hl.Column(balls, 0.0, 0.1, laws, velocities=-1.0, gravity=0.0)
            speeds.append(hl.newton(column).final_velocities[1])
        ax.semilogx(ratios, speeds, label=f"touching, $k_{{12}}/k_{{01}}$ = {factor:g}")
    ax.semilogx(
        ratios,
        (3 - ratios) / (1 + ratios),
        color="black",
        ls=(0, (5, 2)),
        label="collisions",
    )
    ax.set(
        xlabel="mass ratio $m_2/m_1$",
        ylabel="speed of the upper ball / $V$",
        xlim=(1e-3, 1),
        ylim=(0.9, 3.1),
    )
    ax.legend(loc="center left", bbox_to_anchor=(0.0, 0.6))
plt.show()
