r"""
What does Newton's cradle really do?
====================================

Five equal steel balls hang in a row and touch; one arrives with unit speed. Textbook collisions, one after another,
pass its velocity on to the last ball (dots at the right). Under Newton's equations all balls push each other at the
same time, and the pulse depends on the law: a row of Hertz contacts (:math:`F \propto \xi^{3/2}`) ejects the last ball
with 0.989 of the speed, a row of linear springs with only 0.942. The other balls move as well, and the first ball
bounces back a little. The final velocities agree with independent values to eight digits (:doc:`/stacks`).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

ball = hl.Ball(radius=0.01, density=7850)
laws = {
    "Hertz": hl.Viscoelastic(
        youngs_modulus=2.1e11, poisson_ratio=0.3, dissipative_time=0.0
    ),
    "linear springs": hl.LinearDashpot(stiffness=2e7, restitution=1.0),
}

with plots.style():
    figure, axes = plt.subplots(1, 2, figsize=(7.0, 3.6), sharey=True)
    for ax, (name, law) in zip(axes, laws.items(), strict=True):
        cradle = hl.Column.cradle([ball] * 5, [1.0, 0.0, 0.0, 0.0, 0.0], law)
        newton = hl.newton(cradle)
        path = newton.trajectory(
            np.linspace(0.0, 1.05 * newton.contact_times[2].max(), 500)
        )
        ax.set_prop_cycle(None)
        collisions = hl.independent(cradle).final_velocities
        for i in range(5):
            ax.plot(
                1e6 * path.time, path.velocity[:, i], color=f"C{i}", label=f"ball {i + 1}"
            )
        ax.plot(
            [1.03e6 * float(path.time[-1])] * 5,
            collisions,
            "o",
            ms=4,
            color="black",
            zorder=3,
            clip_on=False,
        )
        ax.set(
            title=name,
            xlabel="time after the first touch [µs]",
            xlim=(0, 1.03e6 * float(path.time[-1])),
        )
        print(name, newton.final_velocities.round(4))
    axes[0].set_ylabel("velocity / that of the first ball")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
plt.show()
