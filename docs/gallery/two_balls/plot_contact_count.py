"""
How often do the balls hit each other?
======================================

The number of ball–ball contacts over the coefficient of restitution and the gap, as in the upper map of Fig.
4 of the paper; the number stands in its region. Independent collisions know the answer 1. It is right for
gaps above half a millimetre, and yet the models agree from 2.5 mm on only: one contact is necessary for
independence, but not sufficient. Along the bright ridge the balls leave the floor almost together and touch
again and again. Each of the 48,000 drops is solved on its own, piecewise exactly.
"""

import numpy as np

import hardlimit as hl
from hardlimit import plots

ds = hl.sweep(
    hl.Column.paper(),
    restitution=np.linspace(0.3, 1.0, 240),
    gap=np.geomspace(1e-5, 3e-3, 200),
    variables=["n_contacts"],
)
plots.count_map(ds)
