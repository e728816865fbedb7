"""
How often do the balls hit each other?
======================================

Number of ball–ball contacts over the coefficient of restitution and the gap, as in the upper map of Fig. 4 of the
paper; each region is labelled with its number. The independent-collisions model always has one contact. This is
right for gaps above half a millimetre, but the two models agree only above 2.5 mm: one contact is necessary for
independent collisions, not sufficient. Along the bright ridge the balls leave the floor almost together and touch
many times. Each of the 48,000 drops is solved separately, piecewise exactly.
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
