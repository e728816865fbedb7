r"""
How high does the Astro-Blaster go?
===================================

The toy has four rubber balls on a stick, the largest at the bottom, and is dropped from half a metre. With
collisions one at a time from below,

.. math:: v_{k+1} + V = (v_k + V)\,\frac{1+\varepsilon}{1 + m_{k+1}/m_k},

the top ball would rise by eight metres. Balls that touch, as in the toy, push each other while the lowest one is
still on the floor, and the top ball rises by three metres. With gaps of a few millimetres the collisions are
separate; where the contacts of neighbours just overlap in time, the top ball rises even a little higher. Radii and
stiffness are estimates for rubber, :math:`\varepsilon = 0.9` at 3 m/s, without air. The contacts are compressed by up
to a quarter of the radius, beyond the range of the law; the warnings are suppressed.
"""

import warnings

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

balls = [hl.Ball(radius=radius, density=1100) for radius in (0.032, 0.022, 0.016, 0.011)]
rubber = hl.Viscoelastic(
    youngs_modulus=5e6, poisson_ratio=0.49, restitution=0.9, impact_speed=3.0
)
gaps = np.geomspace(1e-5, 2e-2, 60)
warnings.simplefilter("ignore", hl.CompressionWarning)


def top(model, gap):
    """Height [m] that the top ball gains over where it was released."""
    column = hl.Column(balls, gap, height=0.5 + balls[0].radius, law=rubber)
    return model(column).rebound_heights[-1] - column.initial_positions[-1]


with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    ax.semilogx(
        1e3 * gaps, [top(hl.newton, gap) for gap in gaps], label="Newton’s equations"
    )
    ax.semilogx(
        1e3 * gaps,
        [top(hl.independent, gap) for gap in gaps],
        ls=(0, (5, 2)),
        label="collisions",
    )
    ax.axhline(top(hl.newton, 0.0), color="black", ls=":", label="touching")
    ax.set(
        xlabel="gap between neighbours [mm]",
        ylabel="top ball above its release [m]",
        xlim=(1e-2, 20),
    )
    ax.set_ylim(0, None)
    ax.legend(loc="center left")
plt.show()
