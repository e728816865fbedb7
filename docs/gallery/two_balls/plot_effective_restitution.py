r"""
What is the effective restitution of a drop?
============================================

Independent collisions separate the balls with :math:`v'_r = \varepsilon(1+\varepsilon)V`, where :math:`V` is the
impact speed (Sec. II A of the paper). Solved for the coefficient, the actual relative velocity gives an effective
:math:`\varepsilon_\mathrm{eff}`; :math:`\varepsilon_\mathrm{eff}/\varepsilon = 1` for independent collisions. For a
gap of 0.1 mm the ratio is never above 0.22, and close to zero at some :math:`\varepsilon`.

The lower panel (Fig. 3 of the paper) shows the reason. Each coloured interval is one ball–ball contact; the floor
contact ends at the black line. Near :math:`\varepsilon = 0.782` and 0.667 the balls leave the floor almost together
and meet once more; the smaller their relative velocity, the later they meet. The positions of these spikes
determine the density of the balls, which the paper does not print (:doc:`/paper`).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(gap=1e-4)
restitution = np.linspace(0.5, 1.0, 2001)
ds = hl.sweep(column, restitution=restitution)


def effective(velocity):
    """The coefficient with which independent collisions give this relative velocity."""
    return (np.sqrt(1.0 + 4.0 * velocity / column.impact_speed) - 1.0) / 2.0


drops = [hl.newton(hl.Column.paper(restitution=e, gap=1e-4)) for e in restitution[::2]]
contacts = np.array(
    [
        (drop.column.specified_restitution, 1e6 * begin, 1e6 * end)
        for drop in drops
        for pair, begin, end in zip(*drop.contact_times, strict=True)
        if pair == 1
    ]
)

with plots.style():
    figure, (upper, lower) = plt.subplots(
        2, 1, figsize=(7.0, 5.2), sharex=True, height_ratios=(1, 1.2)
    )
    upper.plot(
        restitution,
        effective(ds.relative_velocity) / restitution,
        label="at the end of the last contact, $t_f$",
    )
    upper.plot(
        restitution,
        effective(ds.separation_velocity) / restitution,
        label="after all forces have ended",
    )
    upper.set(ylabel=r"$\varepsilon_\mathrm{eff}/\varepsilon$", ylim=(0.0, 0.25))
    upper.set_title("independent collisions: 1", loc="right")
    upper.legend(loc="upper left")
    lower.vlines(*contacts.T, color="C0", lw=0.6)
    lower.plot(
        restitution[::2],
        [1e6 * drop.t_floor_end for drop in drops],
        color="black",
        lw=0.8,
    )
    lower.set(
        xlabel=r"coefficient of restitution $\varepsilon$",
        xlim=(0.5, 1.0),
        ylim=(0.0, 1600.0),
    )
    lower.set_ylabel("contacts [µs after the floor touch]")
    figure.align_ylabels()
plt.show()
