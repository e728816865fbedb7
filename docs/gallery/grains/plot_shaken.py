r"""
How high do shaken grains fly?
==============================

A floor vibrates under 300 spheres, 1 mm at 50 Hz, ten times the acceleration of gravity. The mean profile is the
same for hard spheres under the rule tc and under Newton's equations, because contacts are short (:doc:`/shake`).
The grains are densest above the floor, where they cannot stay.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

floor = hl.MovingWall(amplitude=1e-3, frequency=50.0)
box = hl.ParticleSystem.random(
    n=300,
    packing_fraction=0.04,
    radius=1e-3,
    density=2500,
    rms_speed=0.3,
    boundary=["periodic", "periodic", "wall"],
    gravity=9.81,
    walls={"z-": floor},
)
edges = np.linspace(0.0, 0.035, 36)


def profile(time, system):
    return {"spheres": np.histogram(system.positions[:, 2], edges)[0]}


law = hl.LinearDashpot(stiffness=3e4, restitution=0.9)
options = {"until": 1.0, "samples": 791, "observe": profile}  # samples at all phases
hard = hl.event_driven(box, restitution=0.9, rule="tc", contact_duration=5e-6, **options)
soft = hl.molecular_dynamics(box, law=law, engine="events", **options)

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    volume = box.box[0] * box.box[1] * (edges[1] - edges[0])
    for run, look, name in ((soft, "k-", "Newton's equations"), (hard, "o", "rule tc")):
        late = run.series.spheres.sel(time=slice(0.3, None)).mean("time")
        fraction = late * 4 / 3 * np.pi * box.radius[0] ** 3 / volume
        ax.plot(1e3 * (edges[1:] + edges[:-1]) / 2, fraction, look, ms=4, label=name)
    ax.set(
        xlabel="height [mm]",
        ylabel=r"packing fraction $\varphi$",
        xlim=(0, 35),
        ylim=(0, None),
    )
    ax.legend()
plt.show()
