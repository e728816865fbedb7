r"""
What happens in the first millisecond?
======================================

Fig. 2 of the paper: the forces in both contacts from the first touch of the floor on. While the floor pushes
the large ball up (:math:`F_{01}`, below), the small one is hit four times (:math:`F_{12}`, above). With
instantaneous collisions, grey arrows, there is one hit, before the floor has done a tenth of its work. Each
contact begins with a jump of the force, since the damping of the linear dashpot (Eq. 7) acts at once. It ends
when the force has fallen to zero, before the bodies have recovered their shape.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.7, gap=1e-4)
newton = hl.newton(column)
print(newton.contacts.to_dataframe().to_string(float_format="{:.4e}".format))

# %%
# On the left the forces, on the right the resulting heights.

plots.drop(newton, hl.independent(column))
