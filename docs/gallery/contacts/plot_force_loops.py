r"""
What does a contact law look like?
==================================

Force over compression in an impact on a floor at 1 m/s with :math:`\varepsilon = 0.6`; the area between a loop and the
axis is the dissipated energy. The force of the dashpot starts with a jump to :math:`\gamma v`. All three laws are
clipped at zero force, because dry bodies do not attract: at the dot the ball separates from the floor, although the
bodies have not yet recovered their shape.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

ball = hl.Ball(radius=0.01, density=1000)
laws = {
    "linear dashpot": hl.LinearDashpot(stiffness=2e4, restitution=0.6),
    "viscoelastic spheres": hl.Viscoelastic(
        youngs_modulus=1e7, poisson_ratio=0.4, restitution=0.6, impact_speed=1.0
    ),
    "Tsuji": hl.Tsuji(youngs_modulus=1e7, poisson_ratio=0.4, restitution=0.6),
}

with plots.style():
    figure, axes = plt.subplots(1, 3, figsize=(7.0, 2.9), sharey=True)
    for ax, (name, law), colour in zip(
        axes, laws.items(), ("C0", "C1", "C2"), strict=True
    ):
        impact = hl.newton(
            hl.Column([ball], [], 0.01 + 1e-6, law, velocities=-1.0, gravity=0.0)
        )
        path = impact.trajectory(impact.t_end * np.linspace(1e-6, 1.0, 400))
        compression = 1e3 * (ball.radius - path.position[:, 0])
        ax.plot(compression, path.force[:, 0], color=colour)
        ax.plot(compression[-1], 0.0, "o", ms=5, color=colour, clip_on=False, zorder=3)
        ax.set_title(name)
        ax.set(xlabel="compression [mm]", xlim=(0, None), ylim=(0, None))
    axes[0].set_ylabel("force [N]")
plt.show()
