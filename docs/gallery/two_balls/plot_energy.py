r"""
Where does the energy go?
=========================

Energies of two balls of radii 2 cm and 1 cm, :math:`\varepsilon = 0.7`, during their contacts, in units of the
kinetic energy at impact. The lower ball transfers its energy to the springs and dampers of both contacts and
recovers a part of it; the upper ball leaves with more energy than it had. The dissipated energy increases even
after the end of the floor contact (shaded: contacts): when the force reaches zero, the contact is still slightly
compressed, and this elastic energy is lost inside the ball. The sum (dotted) is constant to rounding error. The
solver does not enforce this, so it is a check of the solution.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.7, gap=1e-4, radius_ratio=2)
newton = hl.newton(column)
pair, begin, end = newton.contact_times
trajectory = newton.trajectory(np.linspace(-0.1, 1.6, 1200) * end.max())
masses = np.array([ball.mass for ball in column.balls])
lower, upper = (0.5 * masses * trajectory.velocity**2).values.T
energies = ["kinetic_energy", "potential_energy", "contact_energy", "dissipated_energy"]
total = sum(trajectory[name] for name in energies)
scale = 0.5 * masses.sum() * column.impact_speed**2
print(f"energy kept to {float((total.max() - total.min()) / scale):.1e}")

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.8))
    time = 1e6 * trajectory.time
    ax.plot(time, lower / scale, label="kinetic, lower ball")
    ax.plot(time, upper / scale, label="kinetic, upper ball")
    ax.plot(time, trajectory.contact_energy / scale, label="elastic, in the contacts")
    ax.plot(time, trajectory.dissipated_energy / scale, label="dissipated so far")
    ax.plot(time, total / scale, color="black", ls=":", label="sum, with the weight")
    for start, stop in zip(begin, end, strict=True):
        ax.axvspan(1e6 * start, 1e6 * stop, color="black", alpha=0.07, lw=0)
    ax.set(
        xlim=(time[0], time[-1]),
        ylim=(0, 1.1),
        xlabel="time after the first floor touch [µs]",
    )
    ax.set_ylabel("energy / kinetic energy at impact")
    figure.legend(loc="outside right upper")
plt.show()
