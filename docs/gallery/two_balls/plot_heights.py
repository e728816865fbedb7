r"""
How high does the small ball fly?
=================================

A small ball above a large one falls half a metre with a gap of 0.1 mm and :math:`\varepsilon = 0.9`. In the
*independent-collisions model* (dashed; Eqs. 1–4 of the paper, and any event-driven simulation) the large ball bounces
first and then meets the small one, which is still falling. The small ball rises to 3.6 m. In *Newton's equations*
(full lines; Eq. 14) contacts have a duration: here a few times ten microseconds for the balls and three quarters of a
millisecond for the floor. The balls push each other while the floor still compresses the large one, and the small
ball rises to 0.78 m. The full lines end when the large ball lands for the second time.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.9, gap=1e-4)
newton = hl.newton(column)
collisions = hl.independent(column)
for result in (newton, collisions):
    print(f"{result.model}: the small ball rises to {result.rebound_heights[1]:.2f} m")

plots.heights(newton, collisions)
