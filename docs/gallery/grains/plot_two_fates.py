r"""
Do grains stop spinning when they cool?
=======================================

It depends on friction. A thousand spheres (:math:`\varepsilon = 0.9`, :math:`\beta_0 = 0.5`) start with equal
temperatures of translation and rotation. With :math:`\mu = 0.5` both decay at one rate, in the ratio of kinetic
theory (dashed). With :math:`\mu = 0.05` translation cools so fast that the weak friction of ever slower collisions
no longer stops the spins: rotation survives, as theory says below :math:`\mu_c = 0.103` (Herbst, Huthmann &
Zippelius, Granular Matter 2, 211 (2000)).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import theory

gas = hl.ParticleSystem.random(
    1000, 0.05, radius=1e-3, density=2500, rms_speed=1.0, rms_spin="equal"
)
times = np.geomspace(1e-3, 30.0, 40)
start = gas.granular_temperature

with plots.style():
    figure, axes = plt.subplots(
        1, 2, figsize=(7.0, 3.6), sharey=True, layout="constrained"
    )
    for ax, mu in zip(axes, (0.5, 0.05), strict=True):
        expected = theory.gas(gas).rotating(0.9, mu, 0.5).cooling(times, start, start)
        run, now = [], gas
        for time in np.diff(times, prepend=0.0):
            now = hl.event_driven(
                now,
                restitution=0.9,
                friction=mu,
                tangential_restitution=0.5,
                until=time,
                samples=1,
            ).system
            run.append((now.granular_temperature, now.rotational_temperature))
        for i, (name, colour) in enumerate((("translation", "C0"), ("rotation", "C1"))):
            ax.loglog(
                times, np.array(run)[:, i], "os"[i], ms=3.5, color=colour, label=name
            )
            ax.plot(times, expected[i], color=colour, ls="--")
        ax.set(title=rf"$\mu$ = {mu:g}", xlabel="time [s]")
    axes[0].set_ylabel("temperature [m²/s²]")
    axes[0].legend()
plt.show()
