"""Stacks whose top ball leaves fastest, and oblique drops of two balls."""

import driver
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

import hardlimit as hl
from hardlimit.plots.style import PALETTE, style

ELASTIC = hl.LinearDashpot(stiffness=1e7, restitution=1.0)
TOP_MASS = 0.01  # of the bottom mass
STIFFNESS_RATIOS = (0.2, 0.5, 1.0, 2.0, 5.0)  # of the pair over the floor
GAPS = (0.0, 0.03, 0.1, 0.3)  # in units of V t_c
SIZES = (2, 3, 4, 5, 6, 8, 12, 16, 20)
MOST_DRAWN = 8  # balls of the stacks whose masses are drawn
COLOURS = [PALETTE[name] for name in ("blue", "sky", "green", "orange", "vermillion", "purple", "black")]


def two_balls(ax, points):
    """Speed of the upper of two touching balls over the mass ratio, for several stiffness ratios."""
    ratios = np.geomspace(1e-3, 1.0, 4 * points)
    for factor, colour in zip(STIFFNESS_RATIOS, COLOURS, strict=False):
        laws = [ELASTIC, ELASTIC.replace(stiffness=ELASTIC.stiffness * factor)]
        speeds = []
        for ratio in ratios:
            balls = [hl.Ball(0.1, mass=1.0), hl.Ball(0.05, mass=ratio)]
            column = hl.Column(balls, 0.0, 0.1, laws, velocities=-1.0, gravity=0.0)
            speeds.append(hl.newton(column).final_velocities[-1])
        ax.semilogx(ratios, speeds, color=colour, label=f"{factor:g}")
        best = hl.stack(2, laws, bottom_mass=1.0)
        ax.plot(best.ratios, best.speed, "o", ms=4, color=colour)
    ax.semilogx(ratios, 4.0 / (1.0 + ratios) - 1.0, "k--", lw=1.0)
    ax.annotate("collisions", (1.4e-3, 2.8), fontsize=9)
    ax.set(xlabel=r"$m_2/m_1$", ylabel="speed of the top ball / $V$", ylim=(0.9, 3.1), xlim=(1e-3, 1.0))
    ax.legend(title="$k_{12}/k_{01}$", loc="center left", bbox_to_anchor=(0.0, 0.55))


def best_masses(ax, sizes):
    """Masses of the best touching stacks between the same ends."""
    for n, colour in zip(sizes, COLOURS, strict=False):
        best = hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=TOP_MASS)
        place = np.linspace(0.0, 1.0, n)
        ax.semilogy(place, best.masses, "o-", ms=3.5, color=colour, label=f"{n}")
        print(f"N = {n}: {best}; collisions' masses {collisions(n).speed_under('newton'):.4f} V")
    ax.semilogy([0.0, 1.0], [1.0, TOP_MASS], "k--", lw=1.0)
    ax.annotate("collisions, any N (dashed)", (0.02, 0.013), fontsize=9)
    ax.set(xlabel="place in the stack, bottom to top", ylabel="$m/m_1$")
    ax.legend(title="N")


def collisions(n):
    return hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=TOP_MASS, model="independent")


def speeds_over_size(ax, sizes):
    """Speed of the top ball over N: by independent collisions, and under Newton's equations at several gaps."""
    ax.plot(sizes, [collisions(n).speed for n in sizes], "k--", lw=1.0, label="collisions")
    for gap, colour in zip(GAPS, COLOURS, strict=False):
        best, kept = [], []
        for n in sizes:
            progression = collisions(n)
            wide = gap * progression.contact_way
            best.append(hl.stack(n, ELASTIC, bottom_mass=1.0, top_mass=TOP_MASS, gaps=wide).speed)
            kept.append(progression.speed_under("newton", wide))
        print(f"gap {gap:g} V t_c: best {np.round(best, 3)}, progression {np.round(kept, 3)}")
        ax.plot(sizes, best, "o-", ms=3.5, color=colour, label=f"gap {gap:g} $V t_c$")
        ax.plot(sizes, kept, ":", color=colour, lw=1.2)
    ax.set(xlabel="N", ylabel="speed of the top ball / $V$", yscale="log", ylim=(0.9, 60.0))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.legend(fontsize=8, ncols=2, loc="upper left")


def over_gaps(ax, points):
    """Five balls over the gap, with the masses that are best when touching and with those best for collisions."""
    touching = hl.stack(5, ELASTIC, bottom_mass=1.0, top_mass=TOP_MASS)
    for stack, colour, name in (
        (touching, PALETTE["blue"], "touch"),
        (collisions(5), PALETTE["vermillion"], "collisions"),
    ):
        gaps = np.geomspace(1e-4, 10.0, points)
        over = stack.over_gaps(gaps * stack.contact_way)
        ax.semilogx(gaps, over.newton, color=colour, label=f"masses best for {name}")
        ax.semilogx(gaps, over.independent, "--", color=colour, lw=1.0)
    ax.set(xlabel="gap / $V t_c$", ylabel="speed of the top ball / $V$", title="N = 5")
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 0.88))


def stacks(sizes, points):
    with style():
        figure = plt.figure(figsize=(8.4, 6.6))
        (two, masses), (size, gap) = figure.subplots(2, 2)
        two_balls(two, points)
        best_masses(masses, [n for n in sizes if n <= MOST_DRAWN])
        speeds_over_size(size, sizes)
        over_gaps(gap, 2 * points)
    return figure


def oblique(points):
    """Lateral velocity over the offset, and lateral distance at which the upper ball lands."""
    cases = {
        r"$R_2 = R_1/10$, gap 3 mm": hl.Column.paper(restitution=0.9, gap=3e-3),
        r"$R_2 = R_1/10$, gap 0.1 mm": hl.Column.paper(restitution=0.9, gap=1e-4),
        r"$R_2 = R_1/2$, gap 3 mm": hl.Column.paper(restitution=0.9, gap=3e-3, radius_1=0.1, radius_2=0.05),
    }
    with style():
        figure = plt.figure(figsize=(8.4, 3.4))
        sideways, landing = figure.subplots(1, 2)
        for (name, column), colour in zip(cases.items(), COLOURS[::2], strict=False):
            offsets = np.geomspace(1e-3, 0.5, points) * column.balls[0].radius
            drops = [hl.oblique_drop(column, d) for d in offsets]
            x = 100.0 * offsets / column.balls[0].radius
            sideways.loglog(x, [f.sideways_velocity for f in drops], color=colour, label=name)
            sideways.loglog(x, [f.estimate for f in drops], ":", color=colour, lw=1.2)
            landing.loglog(x, [distance(f) for f in drops], color=colour)
            near = hl.oblique_drop(column, 0.01 * column.balls[0].radius)
            print(
                f"{name}: 1 % of R1 gives {near.sideways_velocity:.4g} m/s (estimate {near.estimate:.4g}), {near}"
            )
        sideways.set(xlabel="offset / $R_1$ [%]", ylabel="sideways velocity [m/s]")
        landing.set(xlabel="offset / $R_1$ [%]", ylabel="comes down aside by [m]")
        for ax in (sideways, landing):
            ax.axvline(1.0, color="0.6", lw=0.8, ls="--")
        sideways.legend(fontsize=8)
    return figure


def distance(drop):
    """Lateral distance [m] of the upper ball when it is back at the height at which it left."""
    return 2.0 * drop.sideways_velocity * drop.velocities[1, 1] / drop.column.gravity


def draw():
    return {"oblique.png": oblique(60), "stacks.png": stacks(SIZES, 60)}


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=110), __doc__)
