r"""
How high does the small ball fly?
=================================

A small ball rides on a large one; both fall half a metre, 0.1 mm apart, with :math:`\varepsilon = 0.9`.
*Independent collisions* (dashed) let the large ball bounce first and then meet the small one, which is still
falling: Eqs. 1–4 of the paper, and the answer of any event-driven simulation. The small ball goes up to 3.6
m. *Newton's equations* (full lines, Eq. 14) let the contacts last as long as they do, here a few ten
microseconds each while the floor contact takes three quarters of a millisecond. The balls then push each
other while the floor is still compressing the large one, and the small ball comes to 0.78 m. Newton's lines
end where the large ball lands for the second time.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.9, gap=1e-4)
newton = hl.newton(column)
collisions = hl.independent(column)
for result in (newton, collisions):
    print(f"{result.model}: the small ball rises to {result.rebound_heights[1]:.2f} m")

plots.heights(newton, collisions)
