r"""
Why does the trick so often fail?
=================================

Nobody can drop two balls by hand exactly one above the other. If the upper ball is a distance :math:`d` off the
axis, the line of centres is tilted by :math:`\theta`, :math:`\sin\theta = d/(R_1+R_2)`, and the force acts
along it. To leading order the small ball leaves with a lateral velocity :math:`v_x = \theta\,(v_2 + V)`
(dotted, :doc:`/stacks`): the effect that amplifies the height also amplifies the error. An offset of a
hundredth of the large radius, one millimetre, already lands the ball some 17 cm away if the gap is wide. Balls
are smooth here; friction would turn part of this velocity into spin.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

offset = np.geomspace(1e-4, 5e-2, 40)  # m

with plots.style():
    figure, (sideways, angle) = plt.subplots(1, 2, figsize=(7.0, 3.3))
    for gap in (3e-3, 1e-4):
        column = hl.Column.paper(restitution=0.9, gap=gap)
        drops = [hl.oblique_drop(column, d) for d in offset]
        (line,) = sideways.loglog(1e3 * offset, [drop.sideways_velocity for drop in drops])
        sideways.loglog(1e3 * offset, [drop.estimate for drop in drops], ":", color="black", lw=1.0)
        angle.semilogx(
            1e3 * offset, np.degrees([d.throw_angle for d in drops]), label=f"gap {1e3 * gap:g} mm"
        )
    sideways.plot([], [], ":", color="black", lw=1.0, label="leading order")
    sideways.set(xlabel="offset [mm]", ylabel="sideways velocity [m/s]")
    sideways.legend()
    angle.set(xlabel="offset [mm]", ylabel="angle of throw to the vertical [°]", ylim=(0, None))
    angle.legend()
plt.show()
