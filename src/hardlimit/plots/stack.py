"""Plot of stacks: masses, and speed of the top ball over the gap."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..stacks import Stack
from .labels import LOOKS
from .style import GREY, PAGE_WIDTH, PALETTE, style

#: Gaps of the picture in units of V t_c.
GAPS = np.geomspace(1e-3, 30.0, 61)
NAMES = {"newton": "Newton’s equations", "independent": "collisions"}
COLOURS = {"newton": PALETTE["blue"], "independent": PALETTE["vermillion"]}


def stack(*stacks: Stack) -> Figure:
    """Masses of the stacks, each optimal for its model, and the speed of the top balls over the gap.

    Full lines: Newton's equations; dashed: collisions. The colour gives the model for which the masses are optimal.
    """
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.1))
        left, right = figure.subplots(1, 2)
        for best in stacks:
            look = {"color": COLOURS[best.model], "label": f"best under {NAMES[best.model]}"}
            left.plot(np.arange(1, best.masses.size + 1), best.masses, "o-", ms=4.0, **look)
            way = best.contact_way
            speeds = best.over_gaps(GAPS * way)
            for model in NAMES:
                right.plot(GAPS, speeds[model], color=COLOURS[best.model], **LOOKS[model])
        left.set_yscale("log")
        left.xaxis.set_major_locator(MaxNLocator(integer=True))
        left.tick_params(axis="x", which="minor", bottom=False, top=False)
        left.set_xlabel("ball, from below")
        left.set_ylabel("mass [kg]")
        left.legend(loc="best")
        for model, name in NAMES.items():
            right.plot([], [], color=GREY, label=name, **LOOKS[model])
        right.set_xscale("log")
        right.set_xlim(GAPS[0], GAPS[-1])
        right.set_xlabel(r"gap / $V t_c$")
        right.set_ylabel("speed of the top ball / $V$")
        right.legend(loc="best")
    return figure
