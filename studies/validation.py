"""Figures of the validation: results beside reference values, theory, a second engine and other codes.

They come from tests/data and from runs of half a minute. docs/validation.md names the tests that check these results.
"""

import csv
import json
from pathlib import Path

import driver
import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit.boxes import theory
from hardlimit.convert.codes import Pair, Written, code
from hardlimit.plots.style import PALETTE, style

DATA = Path(__file__).resolve().parents[1] / "tests" / "data"
COLOURS = [PALETTE[name] for name in ("blue", "orange", "green", "purple", "vermillion", "sky")]

#: Z of elastic spheres: Kolafa, Labík & Malijevský, Phys. Chem. Chem. Phys. 6, 2335 (2004).
COMPRESSIBILITY = {0.1: 1.5217, 0.2: 2.4094, 0.3: 3.9838, 0.4: 6.9429, 0.45: 9.3993}


def table(name, most=None):
    """Rows of a reference table, evenly sampled if there are more than `most`."""
    with open(DATA / f"{name}.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return rows if most is None or len(rows) <= most else rows[:: -(-len(rows) // most)]


def balls(row):
    return [hl.Ball(float(row[f"radius_{i}_m"]), density=float(row["density_kg_m3"])) for i in (1, 2)]


def linear_column(row):
    law = hl.LinearDashpot(stiffness=float(row["stiffness_N_m"]), restitution=float(row["restitution"]))
    # Larger balls of the same masses: under this law radii only decide when a contact is too deep.
    both = [hl.Ball(100.0 * ball.radius, mass=ball.mass) for ball in balls(row)]
    height = float(row["height_m"]) - float(row["radius_1_m"]) + both[0].radius
    return hl.Column(both, float(row["gap_m"]), height, law)


def viscoelastic_column(row):
    damping = (
        {"restitution": float(row["restitution"]), "impact_speed": 3.0}
        if row["restitution"]
        else {"dissipative_time": float(row["dissipative_time_s"])}
    )
    law = hl.Viscoelastic(
        youngs_modulus=float(row["youngs_modulus_Pa"]), poisson_ratio=float(row["poisson_ratio"]), **damping
    )
    both = balls(row)
    height = both[0].radius + float(row["impact_speed_m_s"]) ** 2 / (2.0 * 9.81)
    return hl.Column(both, float(row["gap_m"]), height, law)


def deviations(rows, column_of, **method):
    """|v'_r − reference|/V of each row with a reference value; the number of contacts must be equal."""
    offsets = []
    for row in rows:
        column = column_of(row)
        result = hl.newton(column, **method)
        assert result.n_contacts == int(row["n_contacts"])
        if row["relative_velocity_end_m_s"]:
            off = result.relative_velocity - float(row["relative_velocity_end_m_s"])
            offsets.append(abs(off) / column.impact_speed)
    return np.sort(offsets)


def columns(rows):
    """Sorted deviations from reference values of two balls, with the tolerance of the tests."""
    with style():
        figure, ax = plt.subplots(figsize=(7.0, 3.8), layout="constrained")
        linear = [row for name in ("paper", "ratio", "wide") for row in table(f"two_ball_{name}", rows)]
        sets = (
            ("linear, exact solver", deviations(linear, linear_column, method="exact"), 1e-10),
            ("linear, general solver", deviations(linear, linear_column, method="general"), 1e-9),
            ("viscoelastic", deviations(table("two_ball_viscoelastic", rows), viscoelastic_column), 1e-8),
        )
        for (name, offsets, tolerance), colour in zip(sets, COLOURS, strict=False):
            share = (np.arange(offsets.size) + 1.0) / offsets.size
            ax.semilogx(
                np.maximum(offsets, 1e-18), share, color=colour, label=f"{name}: {offsets.size} columns"
            )
            ax.axvline(tolerance, color=colour, ls="--", lw=1.0)
            print(f"{name}: {offsets.size} columns, largest deviation {offsets.max():.1e} V")
        ax.set(
            xlabel=r"$|v_r^{\,\prime} - \mathrm{reference}|/V$ (dashed: tolerance of the tests)",
            ylabel="share of the columns",
            xlim=(5e-19, 1e-2),
            xticks=10.0 ** np.arange(-18, -1, 2),
            ylim=(0.0, 1.02),
        )
        ax.legend(loc="center right")
    return figure


def restitution(ax):
    """ε of viscoelastic spheres: the table, this package, and the two approximations."""
    ball = hl.Ball(0.01, density=1000.0)
    contact = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-4).between(ball)
    scale = 1.5 * 1e-4 * (contact.elastic_prefactor / contact.effective_mass) ** 0.4
    x = np.geomspace(2e-3, 10.0, 200)
    ax.semilogx(x, contact.restitution((x / scale) ** 5), color=COLOURS[0], label="this package")
    ax.semilogx(x[x < 1.2], hl.restitution_series(x[x < 1.2]), ":", color=COLOURS[1], label="series (B3)")
    ax.semilogx(x, hl.restitution_pade(x), "--", color=COLOURS[2], label="Padé [1/4]")
    known = [(float(r["x"]), float(r["restitution"])) for r in table("restitution_viscoelastic")]
    known = [pair for pair in known if 2e-3 < pair[0] < 10.0]
    at, value = np.array(known).T
    ax.semilogx(at, value, "o", ms=3, color=COLOURS[4], label="reference", zorder=5)
    off = np.abs(contact.restitution((at / scale) ** 5) - value).max()
    print(f"viscoelastic: {at.size} reference values drawn, largest deviation {off:.1e}")
    ax.set(
        xlabel=r"$x = \frac{3}{2} A (\rho/m_\mathrm{eff})^{2/5} v^{1/5}$",
        ylabel=r"$\varepsilon$",
        ylim=(0, 1.02),
    )
    ax.legend()


def predicted_and_measured(row):
    """ε that this package predicts for a row of numbers, and ε obtained from the code."""
    particle_code, wall = code(row["code"]), row["contact"].endswith("wall")
    sizes = [int(digit) * 5e-4 for digit in row["contact"] if digit.isdigit()] or [5e-4]  # of a bed, or one
    first, second = ([hl.Ball(radius, density=7850.0) for radius in sizes] * 2)[:2]
    inverse = [
        1.0 / x + (0.0 if wall else 1.0 / y)
        for x, y in ((first.mass, second.mass), (first.radius, second.radius))
    ]
    pair = Pair("", 1.0 / inverse[0], 1.0 / inverse[1], wall)
    written = Written(particle_code.model(row["model"]), pair, float(row["speed"]), row["attraction"] == "1")
    force = written.force(json.loads(row["numbers"]))
    return force.collision(float(row["speed"])).restitution, float(row["restitution"])


def other_codes(ax, rows):
    """ε from LIGGGHTS, YADE, Kratos and MuJoCo over ε predicted by this package."""
    runs = table("code_restitution", rows)
    names = {"liggghts": "LIGGGHTS", "yade": "YADE", "kratos": "Kratos", "mujoco": "MuJoCo"}
    for (name, title), colour, mark in zip(names.items(), COLOURS, "os^v", strict=False):
        pairs = np.array([predicted_and_measured(row) for row in runs if row["code"] == name])
        ax.plot(
            pairs[:, 0],
            pairs[:, 1] - pairs[:, 0],
            mark,
            ms=4,
            color=colour,
            label=f"{title}: {len(pairs)} runs",
        )
        print(f"{title}: largest difference {np.abs(pairs[:, 1] - pairs[:, 0]).max():.1e}")
    for bound in (-1.5e-3, 1.5e-3):
        ax.axhline(bound, color=PALETTE["black"], ls="--", lw=1.0)
    ax.set(
        xlabel=r"$\varepsilon$ according to this package",
        ylabel=r"$\varepsilon$ of the code − the same",
        ylim=(-2e-3, 3e-3),
    )
    ax.ticklabel_format(axis="y", scilimits=(-3, -3))
    ax.legend(loc="upper left", ncols=2, columnspacing=1.0, handletextpad=0.2)


def contacts(rows):
    with style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
        restitution(left)
        other_codes(right, rows)
    return figure


def gas(n, phi, seed, **settings):
    """An equilibrium of elastic spheres, and a run that starts from it."""
    start = hl.ParticleSystem.random(n, phi, 1e-3, 2500.0, 1.0, seed=seed)
    mixed = hl.event_driven(start, restitution=1.0, max_collisions=20 * n, samples=1).system
    return mixed, hl.event_driven(mixed, **settings)


def pressure(ax, n):
    """Z = p V/(N m T) of elastic spheres."""
    phi = np.linspace(0.0, 0.47, 100)
    ax.plot(phi, (1 + phi + phi**2 - phi**3) / (1 - phi) ** 3, color=COLOURS[0], label="Carnahan–Starling")
    ax.plot(
        list(COMPRESSIBILITY),
        list(COMPRESSIBILITY.values()),
        "o",
        mfc="none",
        color=COLOURS[4],
        label="Kolafa et al.",
    )
    for k, (fraction, known) in enumerate(COMPRESSIBILITY.items()):
        start, run = gas(n, fraction, k, restitution=1.0, max_collisions=60 * n)
        ideal = n * float(start.mass[0]) * start.granular_temperature / float(np.prod(start.box))
        mean = np.average(
            run.series.pressure[1:], weights=np.diff(run.series.time)
        )  # each is a mean since the previous sample
        z = mean / ideal
        ax.plot(fraction, z, "x", color=PALETTE["black"], label=None if k else "this package")
        print(f"φ = {fraction}: Z = {z:.4f}, known {known}")
    ax.set(xlabel=r"$\phi$", ylabel=r"$Z = pV/NmT$")
    ax.legend()


def cooling(ax, n):
    """Temperature of cooling gases and Haff's law."""
    for e, colour in zip((0.95, 0.9, 0.8), COLOURS, strict=False):
        start, run = gas(n, 0.05, 9, restitution=e, until=0.12, samples=60)
        time, begin = run.series.time.values, start.granular_temperature
        haff = theory.gas(start).cooling(time, begin, e)
        ax.semilogy(
            1e3 * time, run.series.granular_temperature / begin, color=colour, label=rf"$\varepsilon$ = {e}"
        )
        ax.semilogy(
            1e3 * time, haff / begin, ":", color=PALETTE["black"], label=None if e != 0.8 else "Haff's law"
        )
    ax.set(xlabel="time [ms]", ylabel="$T/T(0)$")
    ax.legend()


def two_engines(ax):
    """Difference of the velocities of 30 spheres between steps and events, over the time step."""
    start = hl.ParticleSystem.random(30, 0.3, 1e-3, 2500.0, 1.0, seed=1)
    steps = np.geomspace(4e-7, 2.5e-8, 7)
    for e, colour in zip((1.0, 0.9, 0.7), COLOURS, strict=False):
        law = hl.LinearDashpot(stiffness=1e5, restitution=e)
        exact = hl.molecular_dynamics(
            start, law=law, until=1e-3, engine="events", samples=2
        ).system.velocities
        off = [
            np.abs(
                hl.molecular_dynamics(
                    start, law=law, until=1e-3, engine="steps", time_step=step, samples=2, threads=1
                ).system.velocities
                - exact
            ).max()
            for step in steps
        ]
        grain = hl.Ball(1e-3, density=2500.0)
        per_contact = law.between(grain, grain).duration(1.0) / steps
        ax.loglog(per_contact, off, "o-", ms=4, color=colour, label=rf"$\varepsilon$ = {e}")
    ax.loglog(
        per_contact,
        off[-1] * (per_contact[-1] / per_contact) ** 2,
        "--",
        color=PALETTE["black"],
        lw=1.0,
        label="second order",
    )
    ax.set(xlabel="steps in a contact", ylabel="largest difference [m/s]")
    ax.legend()


def grains(n):
    with style():
        figure, axes = plt.subplots(1, 3, figsize=(12.0, 3.8), layout="constrained")
        pressure(axes[0], n)
        cooling(axes[1], n)
        two_engines(axes[2])
    return figure


def draw(rows=100_000, spheres=2000):
    """Of at most so many rows of each table, and with so many spheres."""
    figures = {"columns": columns(rows), "contacts": contacts(rows), "grains": grains(spheres)}
    return {f"validation_{name}.png": figure for name, figure in figures.items()}


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=110), __doc__)
