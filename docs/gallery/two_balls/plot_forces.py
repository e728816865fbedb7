"""
What happens in the first millisecond?
======================================

Fig. 2 of the paper: the forces in both contacts after the first touch of the floor. While the floor accelerates the
large ball upwards (:math:`F_{01}`, below), the small ball is hit four times (:math:`F_{12}`, above). The
independent-collisions model (grey arrows) has one hit, before the floor has done a tenth of its work. Each contact
starts with a jump of the force, because the linear dashpot (Eq. 7) depends on the rate. It ends when the force has
fallen to zero, before the bodies have recovered their shape.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.7, gap=1e-4)
newton = hl.newton(column)
print(newton.contacts.to_dataframe().to_string(float_format="{:.4e}".format))

# %%
# Left: the forces; right: the resulting heights.

plots.drop(newton, hl.independent(column))
