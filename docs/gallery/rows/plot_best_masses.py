"""
Which masses throw the top ball highest?
========================================

Four balls, the lowest of 1 kg and the top one of 10 g: which masses are best between them? For collisions it is a
geometric progression. For balls that touch it is not: the two masses in between are equal. The right panel shows both
stacks over the gap between neighbours, in units of the distance :math:`V t_c` that a ball falls during a contact: each
stack is better in the range for which it was optimised (:doc:`/stacks`). Contacts are linear and elastic.
"""

import hardlimit as hl
from hardlimit import plots

springs = hl.LinearDashpot(stiffness=1e7, restitution=1.0)
ends = {"bottom_mass": 1.0, "top_mass": 0.01}
touching = hl.stack(4, springs, **ends)
progression = hl.stack(4, springs, **ends, model="independent")
for stack in (touching, progression):
    print(stack)

plots.stack(touching, progression)
