"""A column of N beads hits a floor: collapse of instantaneous collisions, detachment under Newton's equations.

Beads at equal distances fall together, without gravity, as in Luding, Clément, Blumen, Rajchenbach & Duran, Phys. Rev.
E 50, 4113 (1994). What collisions make of it depends on N and ε nearly by N(1 − ε) alone, and beyond some 2.5 they
never end: an inelastic collapse. Under Newton's equations contacts last for t_c. Where the beads are far apart,
gap ≫ V t_c, little changes but the collapse, which does not happen. Where they are close, all touch at once: the column
comes off the floor as a whole, and keeps far more of its energy. The paper's two balls of different size stand at the
end.

Draws docs/images/beads.png in some ten seconds.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.pictures.plots import save, style
from hardlimit.pictures.style import PAGE_WIDTH, PALETTE

BEADS = {2: "black", 5: "orange", 10: "green", 20: "vermillion", 50: "blue"}
DISTANCES = (10.0, 0.1)  # gaps in V t_c
RADIUS, SPEED = 1e-3, 1.0  # [m], [m/s]
AXIS = np.array([0.2, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0])  # N(1 − ε)


def column(n: int, restitution: float, distance: float) -> tuple[hl.Column, float]:
    """The column, and a time [s] at which all is over."""
    ball = hl.Ball(RADIUS, density=2500.0)
    law = hl.LinearDashpot(stiffness=1e6, restitution=restitution)
    duration = law.between(ball, ball).duration()
    gap = distance * SPEED * duration
    made = hl.Column([ball] * n, [gap] * (n - 1), RADIUS + gap, law, gravity=0.0, velocities=[-SPEED] * n)
    return made, 40.0 * n * (gap / SPEED + duration)


def energy_kept(result: hl.Result) -> float:
    """Kinetic energy at the end over that before the impact; NaN where the run did not come to its end."""
    return float(np.mean(result.final_velocities**2)) / SPEED**2 if result.outcome == "ok" else np.nan


with style():
    figure = Figure(figsize=(PAGE_WIDTH, 3.4))
    panels = figure.subplots(1, 2, sharey=True)
    for ax, distance in zip(panels, DISTANCES, strict=True):
        for n, colour in BEADS.items():
            x = AXIS[n > AXIS]
            kept = []
            for loss in x:
                beads, end = column(n, 1.0 - loss / n, distance)
                kept.append([energy_kept(solve(beads, until=end)) for solve in (hl.newton, hl.independent)])
            newton, collisions = np.transpose(kept)
            ax.plot(x, newton, "o-", ms=3.0, color=PALETTE[colour], label=f"N = {n}")
            ax.plot(x, collisions, "s--", ms=5.0, mfc="none", lw=0.9, color=PALETTE[colour])
            print(f"gap {distance:g} V t_c, N = {n}: collisions come to an end up to N(1 − ε) = "
                  f"{x[np.isfinite(collisions)].max():g}")  # fmt: skip
        ax.set_title(rf"gap = {distance:g} $V\,t_c$")
        ax.set_xlabel(r"$N(1-\varepsilon)$")
        ax.set_yscale("log")
        ax.set_xlim(0.0, 5.3)
    panels[0].set_ylabel("kinetic energy kept")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(BEADS))
    kinds = [
        *panels[1].plot([], [], "o-", ms=3.0, color="0.4", label="Newton’s equations"),
        *panels[1].plot([], [], "s--", ms=5.0, mfc="none", lw=0.9, color="0.4", label="collisions"),
    ]
    panels[1].legend(handles=kinds, loc="center right")
    save(figure, Path(__file__).parents[1] / "images" / "beads.png", 150)

paper = hl.compare(hl.Column.paper(restitution=0.7, gap=1e-4))
print("The paper’s two balls:", paper.verdict.sentence)
