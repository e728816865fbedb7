"""
How often do the balls hit each other?
======================================

The number of ball–ball contacts over the coefficient of restitution and the gap, as in the upper map of Fig. 4
of the paper; the number is written in its region. Independent collisions always give 1. This is right for gaps
above half a millimetre, but the models agree only from 2.5 mm on: a single contact is necessary for
independence, but not sufficient. Along the bright ridge the balls leave the floor almost together and touch
repeatedly. Each of the 48,000 drops is solved piecewise exactly.
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
