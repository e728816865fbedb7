r"""
How high does the small ball fly?
=================================

A small ball falls 0.1 mm above a large one; both fall half a metre, with :math:`\varepsilon = 0.9`. With
*independent collisions* (dashed) the large ball first bounces and then meets the small one, which is still
falling: Eqs. 1–4 of the paper, and the result of any event-driven simulation. The small ball rises to 3.6 m.
Under *Newton's equations* (solid lines, Eq. 14) contacts have a duration, here some tens of microseconds each,
while the floor contact takes three quarters of a millisecond. The balls then push each other while the floor
still compresses the large one, and the small ball rises to 0.78 m. Newton's lines end when the large ball lands
for the second time.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.9, gap=1e-4)
newton = hl.newton(column)
collisions = hl.independent(column)
for result in (newton, collisions):
    print(f"{result.model}: the small ball rises to {result.rebound_heights[1]:.2f} m")

plots.heights(newton, collisions)
