r"""
Why does the experiment so often fail?
======================================

Nobody drops two balls exactly one above the other. If the upper ball is displaced by a distance :math:`d` from the
axis, the line of centres is tilted by :math:`\theta`, :math:`\sin\theta = d/(R_1+R_2)`, and the force acts along
this line. To leading order the small ball leaves with a sideways velocity :math:`v_x = \theta\,(v_2 + V)` (dotted,
:doc:`/stacks`): the amplification of the height also amplifies the error. With a wide gap, an offset of one
hundredth of the large radius, one millimetre, displaces the landing point by 17 cm. The balls are smooth here;
friction would turn a part of this velocity into spin.
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
        (line,) = sideways.loglog(
            1e3 * offset, [drop.sideways_velocity for drop in drops]
        )
        sideways.loglog(
            1e3 * offset, [drop.estimate for drop in drops], ":", color="black", lw=1.0
        )
        angle.semilogx(
            1e3 * offset,
            np.degrees([d.throw_angle for d in drops]),
            label=f"gap {1e3 * gap:g} mm",
        )
    sideways.plot([], [], ":", color="black", lw=1.0, label="leading order")
    sideways.set(xlabel="offset [mm]", ylabel="sideways velocity [m/s]")
    sideways.legend()
    angle.set(
        xlabel="offset [mm]", ylabel="angle of throw to the vertical [°]", ylim=(0, None)
    )
    angle.legend()
plt.show()
