r"""
How long does a collision take?
===============================

A collision may be treated as instantaneous if it is short compared with the time to the next one. With a linear
spring the duration is :math:`t_c \approx \pi\sqrt{m_\mathrm{eff}/k}` at every speed (Eq. 11 of the paper). A Hertz
contact becomes shorter with increasing speed,

.. math:: t_c = 3.218\,\left(\frac{m_\mathrm{eff}^2}{\rho^2 v}\right)^{1/5},\qquad
   \rho = \frac{2Y\sqrt{R_\mathrm{eff}}}{3(1-\nu^2)}

for elastic spheres (Hertz 1882). At 1 m/s the contact of a steel marble takes a few times ten microseconds, that of a
rubber ball a few milliseconds. The softened grains of many simulations, a hundred thousand times softer than steel,
are closer to rubber.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

speed = np.geomspace(1e-3, 10.0, 120)
materials = {  # radius [m], density [kg/m³], Young's modulus [Pa], Poisson's ratio
    "rubber ball, 3 cm": (0.015, 1100, 5e6, 0.49),
    "steel marble, softened to 2 MPa": (5e-3, 7850, 2e6, 0.3),
    "glass bead, 1 mm": (5e-4, 2500, 6e10, 0.25),
    "steel marble, 1 cm": (5e-3, 7850, 2.1e11, 0.3),
}

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.8))
    for name, (radius, density, modulus, poisson) in materials.items():
        hertz = hl.Viscoelastic(
            youngs_modulus=modulus, poisson_ratio=poisson, dissipative_time=0.0
        )
        contact = hertz.between(hl.Ball(radius=radius, density=density))
        ax.loglog(speed, contact.duration(speed), label=name)
    ax.set(
        xlabel="speed of impact [m/s]",
        ylabel="duration of the contact with a floor [s]",
        xlim=(1e-3, 10),
    )
    ax.set_ylim(1.5e-6, 0.2)
    ax.legend(loc="upper right", ncols=2)
plt.show()
