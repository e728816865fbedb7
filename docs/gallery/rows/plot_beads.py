r"""
Does a column of beads come to rest?
====================================

Ten equal beads in a column hit a floor, without gravity. Hard spheres lose all relative motion in a finite time if
:math:`N(1-\varepsilon)` exceeds a critical value: *inelastic collapse* (Bernu & Mazighi, J. Phys. A 23, 5745 (1990);
tick). With contacts of finite duration the beads push each other at the same time, and the column bounces as a
whole, however large the dissipation: *detachment* (Luding et al., Phys. Rev. E 50, 4113 (1994)). The plot shows the
speed of the centre of mass after the impact relative to that before. :doc:`/beads` has more sizes and gaps.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

n, bead = 10, hl.Ball(1e-3, density=2500)
losses = np.linspace(0.0, 5.0, 31)


def bounce(model, loss):
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0 - loss / n)
    gap = law.between(bead).duration()  # a bead at 1 m/s moves so far during a contact
    column = hl.Column(
        [bead] * n, gap, bead.radius + gap, law, velocities=-1.0, gravity=0.0
    )
    result = model(column, until=100.0)
    return 0.0 if "collapse" in result.outcome else result.velocities.mean()


critical = n * (1.0 - np.tan(np.pi / 4 * (1.0 - 1.0 / n)) ** 2)
with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.4))
    ax.plot(
        losses,
        [bounce(hl.newton, x) for x in losses],
        "o-",
        ms=3,
        label="Newton’s equations",
    )
    ax.plot(
        losses,
        [bounce(hl.independent, x) for x in losses],
        "s--",
        ms=3,
        label="collisions",
    )
    ax.plot(
        critical,
        0.0,
        "|",
        ms=14,
        mew=2,
        color="black",
        clip_on=False,
        label="collapse, theory",
    )
    ax.set(
        xlabel=r"$N(1-\varepsilon)$",
        ylabel="speed of the centre of mass",
        xlim=(0, 5),
        ylim=(0, 1),
    )
    ax.legend()
plt.show()
