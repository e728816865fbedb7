r"""
What happens in the first millisecond?
======================================

Fig. 2 of the paper: the forces in both contacts from the first touch of the floor on. While the floor pushes
the large ball up (:math:`F_{01}`, below), the small one is hit four times (:math:`F_{12}`, above).
Instantaneous collisions, grey arrows, know of one hit, and that one comes before the floor has done a tenth
of its work. Each contact begins with a jump, since the damping of the linear dashpot (Eq. 7) sees the speed
at once, and ends when the force has fallen to zero, which is before the bodies have regained their shape.
"""

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.7, gap=1e-4)
newton = hl.newton(column)
print(newton.contacts.to_dataframe().to_string(float_format="{:.4e}".format))

# %%
# Left the forces, right the heights that follow from them.

plots.drop(newton, hl.independent(column))
