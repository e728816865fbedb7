"""A column of N equal beads hits a floor: hard spheres collapse where Newton's equations let them fly apart.

After Luding, Clément, Blumen, Rajchenbach & Duran, Phys. Rev. E 50, 4113 (1994). The two-ball problem is the limiting
case.
"""

import driver
import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl

SPEED = 1.0  # m/s, of all beads initially; there is no gravity, so beads move freely at the end
BEAD = hl.Ball(1e-3, density=2500.0)
LOSSES = 5.0  # largest N(1 − ε)
SIZES = (2, 5, 10, 20, 50)
GAPS = (0.1, 1.0, 10.0)  # in units of SPEED times the duration of a contact with the floor


def law(restitution):
    return hl.LinearDashpot(stiffness=1e6, restitution=restitution)


def column(n, restitution, gap):
    """N beads above a floor with equal gaps, in units of the distance that a bead moves during a floor contact."""
    duration = law(restitution).between(BEAD).duration()
    wide = gap * SPEED * duration
    return hl.Column(
        [BEAD] * n, [wide] * (n - 1), BEAD.radius + wide, law(restitution), velocities=-SPEED, gravity=0.0
    )


def bounce(result):
    """Speed of the centre of mass and speed of expansion after the last contact, both divided by SPEED."""
    if "collapse" in result.outcome:
        return 0.0, 0.0  # infinitely many collisions: no bead leaves the others or the floor
    if result.outcome != "ok":
        return np.nan, np.nan
    velocities = result.velocities  # masses are equal
    return velocities.mean() / SPEED, (velocities[-1] - velocities[0]) / SPEED


def curve(model, n, gap, points):
    """Bounce and expansion over N(1 − ε)."""
    losses = np.linspace(0.0, min(LOSSES, 0.95 * n), points)
    long = 1e5 * BEAD.radius / SPEED
    bounces = [bounce(model(column(n, 1.0 - x / n, gap), until=long)) for x in losses]
    return losses, *np.array(bounces).T


def two_balls(points):
    """ε_eff/ε at separation of the paper's two balls at ε = 0.9, over the gap in units of V t_c."""
    paper = hl.Column.paper(restitution=0.9)
    lower = paper.balls[0]
    distance = (
        np.sqrt(2.0 * paper.gravity * (paper.height - lower.radius)) * paper.laws[0].between(lower).duration()
    )
    gaps = np.geomspace(0.03, 30.0, points)
    ratios = [hl.newton(paper.replace(gaps=g * distance)).restitution_ratio_at_separation for g in gaps]
    return gaps, np.array(ratios)


def critical(n):
    """N(1 − ε) of the collapse, ε = tan²(π/4 (1 − 1/N)): Bernu & Mazighi, J. Phys. A 23, 5745 (1990)."""
    return n * (1.0 - np.tan(0.25 * np.pi * (1.0 - 1.0 / n)) ** 2)


def draw(sizes=SIZES, points=41):
    figure, ((energy, expansion), (spacing, pair)) = plt.subplots(
        2, 2, figsize=(9.0, 7.2), layout="constrained"
    )
    colours = plt.colormaps["viridis"](np.linspace(0.0, 0.85, len(sizes)))
    for n, colour in zip(sizes, colours, strict=True):
        x, collided, spread = curve(hl.independent, n, 1.0, points)
        energy.plot(x, collided, "--", color=colour)
        expansion.plot(x, spread, "--", color=colour)
        x, soft, spread = curve(hl.newton, n, 1.0, points)
        energy.plot(x, soft, color=colour, label=f"N = {n}")
        expansion.plot(x, spread, color=colour)
        if critical(n) <= x[-1]:
            energy.plot(critical(n), 0.0, "|", ms=12, mew=2, color=colour, clip_on=False)
    middle = sizes[len(sizes) // 2]
    x, collided, _ = curve(hl.independent, middle, 1.0, points)
    spacing.plot(x, collided, "k--", label="collisions")
    for gap, shade in zip(GAPS, ("C1", "C3", "C5"), strict=True):
        x, soft, _ = curve(hl.newton, middle, gap, points)
        spacing.plot(x, soft, color=shade, label=f"Newton, gap {gap:g} $V t_c$")
    gaps, ratio = two_balls(2 * points)
    pair.semilogx(gaps, ratio, "k")
    pair.axhline(1.0, ls="--", color="k", lw=1.0)
    dress(energy, expansion, spacing, pair, middle)
    return {"beads.png": figure}


def dress(energy, expansion, spacing, pair, middle):
    over = "$N(1-\\varepsilon)$"
    energy.set(
        xlabel=over, ylabel="$\\varepsilon_\\mathrm{col}$", title="bounce of the centre of mass", ylim=(0, 1)
    )
    energy.plot([], [], "--", color="grey", label="collisions")
    energy.plot([], [], "|", ms=10, mew=2, color="grey", label="collapse begins (theory)")
    energy.legend(title="Newton, gap $V t_c$", frameon=False, fontsize=8, title_fontsize=8)
    expansion.set(
        xlabel=over, ylabel="(top − bottom)/$V$", title="detachment: speed of expansion", ylim=(0, None)
    )
    spacing.set(
        xlabel=over, ylabel="$\\varepsilon_\\mathrm{col}$", title=f"N = {middle}, other gaps", ylim=(0, 1)
    )
    spacing.legend(frameon=False, fontsize=8)
    pair.set(
        xlabel="gap over $V t_c$",
        ylabel="$\\varepsilon_\\mathrm{eff}/\\varepsilon$",
        title="the paper's two balls, $\\varepsilon = 0.9$",
        ylim=(0, 1.1),
    )
    pair.annotate("collisions", (0.04, 1.02), fontsize=8)


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=110), __doc__)
