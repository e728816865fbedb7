r"""
How high is an atmosphere of marbles?
=====================================

Elastic spheres in a tall box under gravity, between a floor and a ceiling. The density of an ideal gas of
temperature :math:`T` would decrease as :math:`e^{-gz/T}`, the barometric formula (dashed). Spheres have a
finite volume and push each other up. Hydrostatics, :math:`\mathrm{d}p/\mathrm{d}z = -n m g`, with the equation
of state of Carnahan & Starling, gives the solid line. It holds from a few radii above the floor on. Directly at
the floor the centres form layers, which an equation of state does not describe. 600 spheres of radius 1 mm,
mean of 200 snapshots.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

radius, g, box = 1e-3, 9.81, [0.02, 0.02, 0.12]
lattice = np.stack(np.meshgrid(range(8), range(8), range(10), indexing="ij"), -1).reshape(
    -1, 3
)[:600]
gas = hl.ParticleSystem(
    positions=(lattice + 0.5) * 2.4e-3,
    velocities=np.random.default_rng(0).normal(0.0, 0.45, lattice.shape),
    radius=radius,
    density=2500,
    box=box,
    boundary=["periodic", "periodic", "wall"],
    gravity=g,
)
gas = hl.event_driven(gas, restitution=1.0, until=1.0, samples=1).system

edges = np.linspace(0.0, box[2], 121)


def look(time, system):
    counts, _ = np.histogram(system.positions[:, 2], edges)
    return {"spheres": counts, "temperature": system.granular_temperature}


series = hl.event_driven(
    gas, restitution=1.0, until=4.0, samples=200, observe=look
).series
counts, temperature = series.spheres.mean("time").values, float(series.temperature.mean())

volume = 4 / 3 * np.pi * radius**3
middle = 0.5 * (edges[1:] + edges[:-1])
fraction = counts * volume / (box[0] * box[1] * np.diff(edges))
barometric = np.exp(-g * middle / temperature)


def falling(bottom):
    """φ over the height from dφ/dz = −φ g/(T d(φ Z)/dφ) with Carnahan & Starling's Z."""
    phi, at, steps = [], bottom, 20
    for _ in middle:
        phi.append(at)
        for _ in range(steps):
            slope = (1 + 4 * at + 4 * at**2 - 4 * at**3 + at**4) / (1 - at) ** 4
            at -= (middle[1] - middle[0]) / steps * at * g / (temperature * slope)
    return np.array(phi)


low, high = 0.0, 0.6  # the packing fraction at the floor with which no sphere is missing
for _ in range(40):
    bottom = 0.5 * (low + high)
    low, high = (
        (bottom, high) if falling(bottom).sum() < fraction.sum() else (low, bottom)
    )

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.8))
    ax.semilogy(1e3 * middle, fraction, ".", label="event-driven, 600 spheres")
    ax.plot(
        1e3 * middle,
        falling(bottom),
        color="black",
        label="hydrostatics, Carnahan & Starling",
    )
    ax.plot(
        1e3 * middle,
        barometric * fraction.sum() / barometric.sum(),
        "k--",
        lw=1.0,
        label="barometric formula",
    )
    ax.set(
        xlabel="height [mm]",
        ylabel=r"packing fraction $\varphi$",
        xlim=(0, 110),
        ylim=(1e-3, 1),
    )
    ax.legend(loc="upper right")
print(f"T = {temperature:.3f} m²/s², T/g = {1e3 * temperature / g:.1f} mm")
plt.show()
