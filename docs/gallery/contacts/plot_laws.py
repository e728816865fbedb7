r"""
Does a faster ball lose more?
=============================

This depends on the law and distinguishes laws in an experiment. A glass-like ball of radius 5 mm hits a floor; each
law has :math:`\varepsilon = 0.9` at 1 m/s. The restitution of the linear dashpot (Eq. 7 of the paper) and of Tsuji's
law is the same at every speed; their lines coincide. For viscoelastic spheres (Eqs. B1–B3) it decreases with speed,
:math:`1 - \varepsilon \propto v^{1/5}` for small :math:`v`: slow collisions are nearly elastic. Plastic flow, which
dominates in real glass and metal at higher speeds, is not included in any of them.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

ball = hl.Ball(radius=5e-3, density=2500)
speed = np.geomspace(1e-4, 10.0, 200)
laws = {
    "linear dashpot": hl.LinearDashpot(stiffness=1e7, restitution=0.9),
    "viscoelastic spheres": hl.Viscoelastic(
        youngs_modulus=6e10, poisson_ratio=0.25, restitution=0.9, impact_speed=1.0
    ),
    "Tsuji": hl.Tsuji(youngs_modulus=6e10, poisson_ratio=0.25, restitution=0.9),
}

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.4))
    for (name, law), line in zip(laws.items(), ("-", "-", (0, (5, 4))), strict=True):
        ax.semilogx(speed, law.between(ball).restitution(speed), ls=line, label=name)
    ax.set(
        xlabel="speed of impact [m/s]",
        ylabel=r"coefficient of restitution $\varepsilon$",
        xlim=(1e-4, 10),
    )
    ax.set_ylim(0.82, 1.0)
    ax.legend(loc="lower left")
plt.show()
