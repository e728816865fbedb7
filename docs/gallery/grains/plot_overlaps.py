r"""
How often do three grains touch?
================================

A rule for hard spheres assumes that contacts are pairwise. Under Newton's equations some contacts share a grain
with another contact while they last. The picture shows the fraction of these contacts over :math:`t_c\,\nu`,
the duration of a contact times the collision rate of a grain. If small, it is about :math:`3\,t_c\nu` (dotted),
almost independent of the packing fraction. This product, not the stiffness or the density alone, decides
whether an event-driven simulation can be trusted; 0.01 is a common limit. 300 spheres, :math:`\varepsilon =
0.95`, linear dashpot.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots
from hardlimit.boxes import theory

wanted = np.geomspace(3e-3, 0.2, 6)
unit = hl.LinearDashpot(stiffness=1.0, restitution=0.95)
grain = hl.Ball(radius=1e-3, density=2500)

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    for fraction in (0.05, 0.2, 0.4):
        gas = hl.ParticleSystem.random(
            n=300, packing_fraction=fraction, radius=1e-3, density=2500, rms_speed=1.0
        )
        gas = hl.event_driven(gas, restitution=1.0, max_collisions=3000, samples=1).system
        rate = float(theory.gas(gas).collision_rate(gas.granular_temperature))
        shares = []
        for tc_nu in wanted:
            law = unit.replace(
                stiffness=(unit.between(grain, grain).duration() * rate / tc_nu) ** 2
            )
            run = hl.molecular_dynamics(
                gas, law=law, until=8 / rate, engine="events", samples=1
            )
            shares.append(run.overlapped_share)
        ax.loglog(wanted, shares, "o-", ms=4, label=rf"$\varphi$ = {fraction:g}")
    ax.loglog(wanted, 3 * wanted, ":", color="black", label=r"$3\,t_c\nu$")
    ax.set(
        xlabel=r"$t_c\nu$ of the start (Enskog)", ylabel="share of overlapping contacts"
    )
    ax.legend()
plt.show()
