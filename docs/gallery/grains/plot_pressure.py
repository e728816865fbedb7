r"""
What is the pressure of hard spheres?
=====================================

The compressibility :math:`Z = p/(n\,m\,T)` of elastic spheres over the packing fraction, from the momentum
exchanged in collisions. The line is the equation of state of Carnahan & Starling, J. Chem. Phys. 51, 635
(1969), :math:`Z = (1+\varphi+\varphi^2-\varphi^3)/(1-\varphi)^3`. The lower panel shows the difference from it;
error bars are the spread of five parts of a run. Even 500 spheres with 120 collisions each give the pressure to
about one per cent.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

n, phi = 500, np.array([0.05, 0.1, 0.2, 0.3, 0.4, 0.45])
compressibility, error = [], []
for fraction in phi:
    gas = hl.ParticleSystem.random(
        n=n, packing_fraction=fraction, radius=1e-3, density=2500, rms_speed=1.0
    )
    gas = hl.event_driven(gas, restitution=1.0, max_collisions=20 * n, samples=1).system
    run = hl.event_driven(gas, restitution=1.0, max_collisions=60 * n, samples=100)
    series = run.series.isel(time=slice(1, None))
    ideal = gas.mass.sum() / np.prod(gas.box) * gas.granular_temperature
    parts = [
        part.mean() for part in np.array_split(series.pressure.values[:-1] / ideal, 5)
    ]
    compressibility.append(np.mean(parts))
    error.append(np.std(parts) / np.sqrt(4))


def carnahan_starling(phi):
    return (1 + phi + phi**2 - phi**3) / (1 - phi) ** 3


with plots.style():
    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.0, 4.4), sharex=True, height_ratios=(2, 1)
    )
    line = np.linspace(0, 0.48, 100)
    upper.plot(
        line, carnahan_starling(line), color="black", lw=0.9, label="Carnahan & Starling"
    )
    upper.errorbar(
        phi, compressibility, error, fmt="o", ms=4, label="event-driven, 500 spheres"
    )
    upper.set(ylabel=r"$Z = p/(n\,m\,T)$", xlim=(0, 0.48), ylim=(0, None))
    upper.legend(loc="upper left")
    expected = carnahan_starling(phi)
    lower.axhline(0.0, color="black", lw=0.9)
    lower.errorbar(
        phi,
        100 * (compressibility / expected - 1),
        100 * np.array(error) / expected,
        fmt="o",
        ms=4,
    )
    lower.set(xlabel=r"packing fraction $\varphi$", ylabel="difference [%]", ylim=(-2, 2))
    figure.align_ylabels()
plt.show()
