r"""
What does my script really do?
==============================

A LAMMPS script asks for :math:`\varepsilon = 0.7`. :func:`hardlimit.check` reads it without running it: between
grains the force is cut off at zero by ``limit_damping``, which gives 0.718, and at the wall it is not. Bands are
the error by the time step, the dotted line is the script's (:doc:`/check`).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

SCRIPT = """
units           si
atom_style      sphere
boundary        p p f
region          box block 0 0.04 0 0.04 0 0.026 units box
create_box      1 box
create_atoms    1 random 2000 7 box overlap 0.002 maxtry 500
set             type 1 diameter 0.002 density 2500
pair_style      granular
pair_coeff      * * hooke 1e4 0.7 damping coeff_restitution limit_damping
fix             walls all wall/gran granular hooke 1e4 0.7 damping coeff_restitution &
                zplane 0 0.026
fix             move all nve/sphere
timestep        {step}
run             1000
"""
verdict = hl.check(SCRIPT.format(step=5e-6), speed=0.5, packing_fraction=0.2)
print(verdict)

steps = np.geomspace(3e-7, 2e-5, 12)
rows = [hl.check(SCRIPT.format(step=step), speed=0.5).contacts for step in steps]

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    for k, name in enumerate(verdict.contacts.types.values):
        epsilon = np.array([row.restitution.values[k] for row in rows])
        error = np.array([row.restitution_error_of_step.values[k] for row in rows])
        ax.plot(1e6 * steps, epsilon, label=name)
        ax.fill_between(1e6 * steps, epsilon - error, epsilon + error, alpha=0.25)
    ax.axhline(0.7, color="black", ls="--", lw=1.0, label="asked")
    ax.axvline(5.0, color="black", ls=":", lw=1.0)
    ax.set(xscale="log", xlabel="time step [µs]", ylabel=r"$\varepsilon$")
    ax.legend()
plt.show()
