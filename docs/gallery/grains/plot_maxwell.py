r"""
How soon do speeds follow Maxwell?
==================================

All spheres of an elastic gas start with the same speed, in random directions. After only two or three
collisions per sphere, one component of the velocity is distributed as in equilibrium (line, a normal
distribution of variance :math:`T`), although collisions only conserve momentum and energy. 8000 spheres,
:math:`\varphi = 0.1`.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

n = 8000
gas = hl.ParticleSystem.random(
    n=n, packing_fraction=0.1, radius=1e-3, density=2500, rms_speed=1.0
)
gas = gas.replace(
    velocities=gas.velocities / np.linalg.norm(gas.velocities, axis=1)[:, None]
)
edges = np.linspace(-2, 2, 41)

with plots.style():
    figure, axes = plt.subplots(1, 3, figsize=(7.0, 2.8), sharey=True)
    for ax, collisions in zip(axes, (0, 1, 3), strict=True):
        run = hl.event_driven(
            gas, restitution=1.0, max_collisions=collisions * n // 2, samples=1
        )
        after = run.system
        share, _ = np.histogram(after.velocities, edges, density=True)
        ax.stairs(share, edges, fill=True, color="C5")
        temperature = after.granular_temperature
        ax.plot(
            edges,
            np.exp(-(edges**2) / (2 * temperature)) / np.sqrt(2 * np.pi * temperature),
            color="black",
        )
        ax.set(
            title=f"{collisions} collisions of each"
            if collisions != 1
            else "1 collision of each",
            xlim=(-2, 2),
        )
        ax.set_xlabel("velocity component [m/s]")
    axes[0].set_ylabel("probability density [s/m]")
plt.show()
