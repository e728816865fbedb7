"""
Can the large ball ignore the small one?
========================================

Appendix A of the paper solves the drop for a lower ball that is not affected by the upper one. The plot shows the
error of this solution in the separation velocity, relative to the full equations, over the mass ratio. The
envelope of the error is proportional to :math:`m_2/m_1` (line); the dips are changes of sign. At the paper's
:math:`R_1/R_2 = 10` (dotted) the error is a thousandth of the impact speed; for a mass ratio of ten it is a tenth.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

column = hl.Column.paper(restitution=0.9, gap=1e-4)
ratio = np.geomspace(2.0, 40.0, 240)
full, fixed = (
    hl.sweep(column, model=model, radius_ratio=ratio) for model in ("newton", "adiabatic")
)
error = abs(fixed.separation_velocity - full.separation_velocity) / column.impact_speed

with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 3.6))
    ax.loglog(ratio**-3.0, error, ".", ms=4)
    ax.loglog(ratio**-3.0, 2.0 * ratio**-3.0, color="black", lw=0.8)
    ax.annotate(r"$2\,m_2/m_1$", (1e-4, 3e-4), ha="right")
    ax.axvline(1e-3, color="black", ls=":")
    ax.set(
        xlabel=r"ratio of the masses $m_2/m_1$",
        ylabel="error of the separation velocity / $V$",
    )
plt.show()
