r"""
A superball, and a grain that hardly feels friction
===================================================

Both follow from one number, which is often left to a default: the ratio :math:`k_t/k_n` of the stiffnesses. Solid
spheres with a linear spring, :math:`\varepsilon = 1`, over the angle of impact divided by :math:`\kappa\mu`,
:math:`\kappa = 7/2`. The tangential spring oscillates :math:`\sqrt\rho` times as fast as the normal one,
:math:`\rho = \kappa k_t/k_n`.
With the default of LAMMPS, :math:`k_t = 2k_n/7`, both end together: :math:`\beta = 1`, the surface velocity is
reversed. With :math:`k_t = k_n` the spring has swung back when the contact ends: :math:`\beta \approx -1`, as
without friction. Grains that slide throughout share one line. Ratios of elastic spheres, :math:`2(1-\nu)/(2-\nu)`,
lie between 2/3 and 1 (:doc:`/friction`).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

mu, kappa = 0.1, 3.5
ball = hl.Ball(radius=1e-3, density=2500)
psi = np.linspace(0.0, 3.0, 301)
with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 4.2))
    for rho in (1.0, 2.88, 3.15, 3.5):
        friction = hl.Friction(mu, stiffness_ratio=rho / kappa)
        law = hl.LinearDashpot(stiffness=1e5, restitution=1.0, friction=friction)
        contact = law.between(ball, ball)
        beta = contact.tangential_restitution(np.arctan(kappa * mu * psi))
        ax.plot(psi, beta, label=rf"$\rho = {rho:g}$, $k_t = {rho / kappa:.3g}\,k_n$")
    ax.plot(
        psi[psi > 1.0],
        -1.0 + 2.0 / psi[psi > 1.0],
        "k:",
        lw=1.2,
        label="sliding throughout",
    )
    ax.axhline(0.0, color="0.6", lw=0.8)
    ax.set(
        xlabel=r"$\tan\gamma/(\kappa\mu)$",
        ylabel=r"tangential restitution $\beta$",
        ylim=(-1.05, 1.1),
    )
    ax.legend()
plt.show()
