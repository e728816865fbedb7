r"""
How small must the time step be?
================================

Error of the restitution over the number of time steps per contact, for a linear dashpot of :math:`\varepsilon = 0.7`
with the input that makes each code exact in the limit. LAMMPS, like all codes of the gallery page on 0.7, evaluates
the damping with velocities of half a step before: the error is of first order, half a per cent for the usual 50 steps
per contact. The engine ``"steps"`` of this package uses velocities of the same time, and its error is of second order.
The dotted lines have slopes 1 and 2. Both curves show the largest error over the position of the first touch between
two steps.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

grain = hl.Ball(radius=1e-3, density=2500)
law = hl.LinearDashpot(stiffness=1e5, restitution=0.7)
duration = law.between(grain, grain).duration()
steps = np.geomspace(10, 1000, 13)


def of_lammps(n):
    conversion = hl.convert(
        grain,
        restitution=0.7,
        stiffness=1e5,
        wall=False,
        code="lammps",
        model="hooke-restitution",
        time_step=duration / n,
    )
    return conversion.models[0].contacts[0].restitution_error


def of_steps(n, phases=20):
    """Largest error over impacts whose touch is at different fractions of a step."""
    step, worst = duration / n, 0.0
    for gap in 2e-5 + 2.0 * step * np.arange(phases) / phases:
        at = np.array([[0.01, 0.01], [0.01 + 2e-3 + gap, 0.01]])
        pair = hl.ParticleSystem(
            at, [[1.0, 0.0], [-1.0, 0.0]], radius=1e-3, density=2500, box=0.02
        )
        end = hl.molecular_dynamics(
            pair,
            law=law,
            until=gap + 3 * duration,
            engine="steps",
            time_step=step,
            samples=1,
        )
        speeds = end.system.velocities[:, 0]
        worst = max(worst, abs((speeds[1] - speeds[0]) / 2.0 - 0.7))
    return worst


with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.8))
    lammps, ours = ([error(n) for n in steps] for error in (of_lammps, of_steps))
    ax.loglog(steps, lammps, "o-", ms=4, label="LAMMPS: damping half a step late")
    ax.loglog(steps, ours, "s-", ms=4, label='engine="steps"')
    ax.loglog(steps, lammps[-1] * steps[-1] / steps, ":", color="black", lw=0.9)
    ax.loglog(steps, ours[-1] * (steps[-1] / steps) ** 2, ":", color="black", lw=0.9)
    ax.set(xlabel="time steps per contact", ylabel=r"error of $\varepsilon$")
    ax.legend(loc="lower left")
plt.show()
