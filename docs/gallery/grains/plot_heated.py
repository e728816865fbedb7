r"""
Which temperature does a heated gas have?
=========================================

Random kicks with a constant power heat 500 spheres, collisions cool them. In the steady state both are equal;
kinetic theory gives the temperature (dashed: van Noije & Ernst, Granular Matter 1, 57 (1998)). The more elastic the
spheres, the hotter the gas and the longer it takes (:doc:`/shake`).
"""

import matplotlib.pyplot as plt

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import theory

power = 1e-3  # [W], of the whole gas

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    for restitution, colour in ((0.95, "C1"), (0.8, "C0"), (0.6, "C2")):
        gas = hl.ParticleSystem.random(
            500, 0.1, radius=1e-3, density=2500, rms_speed=0.05
        )
        steady = theory.gas(gas).heated_temperature(power, restitution)
        gas = gas.replace(thermostat=hl.RandomKicks(power=power, interval=2e-4))
        run = hl.event_driven(gas, restitution=restitution, until=0.8, samples=200)
        label = rf"$\varepsilon$ = {restitution:g}"
        ax.plot(
            run.series.time, run.series.granular_temperature, color=colour, label=label
        )
        ax.axhline(steady, color=colour, ls="--", lw=1.0)
    ax.set(
        xlabel="time [s]",
        ylabel="granular temperature [m²/s²]",
        xlim=(0, 0.8),
        ylim=(0, None),
    )
    ax.legend()
plt.show()
