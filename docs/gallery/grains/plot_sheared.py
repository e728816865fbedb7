r"""
How hot does a sheared gas become?
==================================

Shear heats a gas until collisions dissipate the work of the shear stress. From a cold and from a hot start, 500
spheres in a Lees–Edwards box reach the same granular temperature, that of the theory of Lun et al., J. Fluid Mech.
140, 223 (1984) (dashed). Time is counted in strains (:doc:`/shear`).
"""

import matplotlib.pyplot as plt

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes.theory import Gas

rate, sides = 60.0, ("periodic", "lees-edwards", "periodic")

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    for speed, name in ((0.1, "cold start"), (1.0, "hot start")):
        gas = hl.ParticleSystem.random(
            500, 0.2, 1e-3, 2500, speed, boundary=sides, shear_rate=rate
        )
        run = hl.event_driven(gas, restitution=0.8, until=20.0 / rate, samples=200)
        ax.semilogy(rate * run.series.time, run.series.granular_temperature, label=name)
    theory = Gas(gas.n, 1e-3, float(gas.mass[0]), gas.domain.volume, 3)
    ax.axhline(
        theory.sheared_temperature(rate, 0.8), color="black", ls="--", label="Lun et al."
    )
    ax.set(
        xlabel=r"strain $\dot\gamma t$",
        ylabel="granular temperature [m²/s²]",
        xlim=(0, 20),
    )
    ax.legend()
plt.show()
