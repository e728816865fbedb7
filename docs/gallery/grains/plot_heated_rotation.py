r"""
How much of the heat does rotation take?
========================================

Random kicks heat the velocities of 500 rough spheres (:math:`\varepsilon = 0.9`), which rotate through collisions
only. Kinetic theory gives the ratio of the temperatures of rotation and translation (dashed),
:math:`\theta = q(1+\beta)/(1+2q-\beta)` with :math:`q = 2/5`: equal temperatures only for :math:`\beta = 1`.
It does not depend on the power, the density or :math:`\varepsilon` (:doc:`/theory`).
"""

import math

import matplotlib.pyplot as plt

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import theory

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    for beta, colour in ((1.0, "C1"), (0.5, "C0"), (-0.5, "C2")):
        gas = hl.ParticleSystem.random(
            500, 0.1, radius=1e-3, density=2500, rms_speed=0.1, rms_spin=0.0
        )
        expected = theory.gas(gas).rotating(0.9, math.inf, beta)
        gas = gas.replace(thermostat=hl.RandomKicks(power=1e-3, interval=2e-4))
        run = hl.event_driven(
            gas,
            restitution=0.9,
            friction=math.inf,
            tangential_restitution=beta,
            until=0.8,
            samples=200,
        )
        label = rf"$\beta$ = {beta:g}"
        ax.plot(run.series.time, run.series.temperature_ratio, color=colour, label=label)
        ax.axhline(expected.heated_temperature_ratio(), color=colour, ls="--", lw=1.0)
    ax.set(
        xlabel="time [s]",
        ylabel=r"temperature ratio $\theta = T_r/T$",
        xlim=(0, 0.8),
        ylim=(0, None),
    )
    ax.legend()
plt.show()
