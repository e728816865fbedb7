"""What the paper states, each computed and judged from the numbers; no verdict is written down beforehand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bodies import FLOOR
from ..column.scenario import Column
from ..column.solvers import adiabatic, independent, newton
from ..laws import LAWS
from ..sweep import sweep
from . import figure4, figure6
from .data import Data
from .report import Agreement, Row
from .sampling import jumps, late_contacts, maxima, middles, share
from .setup import (
    INPUT_SPEED,
    POISSON_RATIO,
    RESTITUTION_5,
    RESTITUTION_6,
    YOUNGS_MODULUS_INSET,
)


class Finding(NamedTuple):
    """What came out, and whether it is what the paper states."""

    result: str
    agrees: Agreement


class Statement(NamedTuple):
    """A statement in our words, its place, the figures it belongs to, and how to check it."""

    text: str
    where: str
    figures: tuple[int, ...]  #: computed with any of these; empty: with every run
    check: Callable[[Data], Finding]


STATEMENTS: Final[list[Statement]] = []


def statement(
    text: str, where: str, *figures: int
) -> Callable[[Callable[[Data], Finding]], Callable[[Data], Finding]]:
    """Register a check."""

    def register(check: Callable[[Data], Finding]) -> Callable[[Data], Finding]:
        STATEMENTS.append(Statement(text, where, figures, check))
        return check

    return register


def rows(
    data: Data, figures: tuple[int, ...], progress: Callable[[float], object] = lambda part: None
) -> list[Row]:
    """The rows of all statements that belong to ``figures``, in the order of the paper."""
    chosen = [s for s in STATEMENTS if set(s.figures) <= set(figures)]
    table = []
    for i, s in enumerate(chosen):
        table.append(Row(s.text, s.where, *s.check(data)))
        progress((i + 1) / len(chosen))
    return table


def verdict(*conditions: bool) -> Agreement:
    """Yes if all hold, no if none does, else partly."""
    return "yes" if all(conditions) else "partly" if any(conditions) else "no"


#: Rows across a map of Fig. 4 over which a share is a mean, and points along each, many because spikes are
#: narrow. With more of either the shares change by less than what :func:`_about` rounds to.
ROWS: Final = 60
POINTS: Final = 3000


def _about(part: float) -> str:
    """A share that is known to some per cent, rounded to 5 % but for 0 and 1."""
    rounded = min(max(5 * round(20 * part), 5), 95)
    return f"{100 * part:.0f} %" if part in (0.0, 1.0) else f"about {rounded} %"


def _counts(column: Column, **axes: NDArray[np.float64]) -> NDArray[np.int64]:
    """The number of ball–ball contacts over two parameters."""
    swept: dict[str, Any] = dict(axes)
    return sweep(column, variables=["n_contacts"], **swept)["n_contacts"].values.astype(np.int64)


def _near(value: float, wanted: float, within: float) -> bool:
    return math.isfinite(value) and abs(value - wanted) <= within


# --- Sec. II: independent collisions ------------------------------------------------------------------------


@statement(
    "Elastic, vanishing gap: v2 and v1 after both collisions are V (3 − μ)/(1 + μ) and V (1 − 3μ)/(1 + μ)",
    "Eqs. 5–6",
)
def _limit(data: Data) -> Finding:
    error = 0.0
    masses = (1e-6, 0.001, 0.1, 1 / 3, 0.9)
    for mu in masses:
        column = data.setup.mass_ratio(mu)
        v1, v2 = independent(column).velocities / column.impact_speed
        error = max(error, abs(v2 - (3 - mu) / (1 + mu)), abs(v1 - (1 - 3 * mu) / (1 + mu)))
    return Finding(
        f"largest deviation {error:.1e} V for {len(masses)} mass ratios μ = m2/m1", verdict(error < 1e-9)
    )


@statement("μ = 1/3 stops the lower ball, and the upper one leaves at twice its speed", "Sec. II A")
def _third(data: Data) -> Finding:
    column = data.setup.mass_ratio(1 / 3)
    v1, v2 = independent(column).velocities / column.impact_speed
    return Finding(
        f"v1 = {abs(v1):.1e} V, v2 = {v2:.9f} V", verdict(_near(v1, 0.0, 1e-9), _near(v2, 2.0, 1e-9))
    )


@statement("μ → 0: the upper ball leaves at 3V and rises to 9 z2(0) − 8 (2R1 + R2)", "Sec. II A")
def _nine_times(data: Data) -> Finding:
    column = data.setup.mass_ratio(1e-12)
    result = independent(column)
    speed = result.velocities[1]
    top = result.positions[1] + speed**2 / (2 * column.gravity)
    z0, (lower, upper) = column.initial_positions[1], (ball.radius for ball in column.balls)
    wanted = 9 * z0 - 8 * (2 * lower + upper)
    return Finding(
        f"v2 = {speed / column.impact_speed:.9f} V; height {top:.9f} m, formula {wanted:.9f} m",
        verdict(_near(speed / column.impact_speed, 3.0, 1e-9), _near(top, wanted, 1e-8)),
    )


@statement(
    "The sequence of two collisions fails if the lower ball is the lighter one, even elastically", "Sec. II A"
)
def _lighter_below(data: Data) -> Finding:
    def collisions(mu: float) -> int:
        column = data.setup.mass_ratio(mu, gap=1e-9)
        again = independent(column, until=0.1).contacts["pair"].values
        return int(np.sum(again == 1))

    counts = {mu: collisions(mu) for mu in (0.5, 0.9, 0.999, 1.001, 1.1, 2.0)}
    once = all(n == 1 for mu, n in counts.items() if mu < 1)
    more = all(n > 1 for mu, n in counts.items() if mu > 1)
    shown = ", ".join(f"{n} at μ = {mu:g}" for mu, n in counts.items())
    return Finding(f"ball–ball collisions of the hard spheres, ε = 1: {shown}", verdict(once, more))


@statement("One ε for both contacts makes γ01 larger than γ12", "Sec. III B")
def _two_dampings(data: Data) -> Finding:
    floor, pair = (c.damping for c in data.setup.linear().contacts)
    return Finding(f"ε = 0.7: γ01 = {floor:.4g}, γ12 = {pair:.4g} N s/m", verdict(floor > pair))


# --- Sec. IV A: sequence ------------------------------------------------------------------------------------


@statement("F01 jumps to a finite value at the first touch", "Sec. IV A, Fig. 2", 2)
def _jump(data: Data) -> Finding:
    force = data.figure(2)["force_floor"]
    at = float(force.sel(time=slice(0.0, None))[1])
    before = float(force.sel(time=slice(None, -1e-15))[-1])
    column = data.setup.linear()
    damping = column.contacts[0].damping * column.impact_speed
    return Finding(
        f"from {before:g} to {at / 1e3:.3f} kN; γ01 V = {damping / 1e3:.3f} kN",
        verdict(_near(at, damping, 1e-3 * damping)),
    )


@statement("The balls touch several times during one floor contact", "Sec. IV A, Fig. 2", 2)
def _several(data: Data) -> Finding:
    figure = data.figure(2)
    inside = int(np.sum(figure["end"].values < float(figure["t_floor_end"])))
    return Finding(
        f"{figure.sizes['contact']} contacts, {inside} of them within the floor contact; the last ends at "
        f"{float(figure.t_end) * 1e6:.3f} µs, the floor contact at {float(figure.t_floor_end) * 1e6:.3f} µs",
        verdict(inside > 1),
    )


@statement("The last contact may end before or after the floor contact", "Sec. IV A, Fig. 3", 3)
def _either_order(data: Data) -> Finding:
    figure = data.figure(3)
    epsilon = figure["restitution_outline"].values
    late = figure["outline_t_end"].values > figure["outline_t_floor_end"].values
    after = share(late, (epsilon, False))
    return Finding(
        f"after it for {100 * after:.1f} % of the ε from {epsilon[0]:g} to {epsilon[-1]:g}",
        verdict(0.0 < after < 1.0),
    )


@statement("3 contacts at ε = 1", "Sec. IV A, Fig. 3")
def _elastic(data: Data) -> Finding:
    n = newton(data.setup.linear(1.0)).n_contacts
    return Finding(f"{n} contacts", verdict(n == 3))


@statement("At a large gap one contact remains", "Sec. IV A")
def _large_gap(data: Data) -> Finding:
    counts = {gap: newton(data.setup.linear(1.0, gap=gap)).n_contacts for gap in (1e-4, 1e-3, 1e-2)}
    shown = ", ".join(f"{n} at {gap * 1e3:g} mm" for gap, n in counts.items())
    return Finding(f"ε = 1: {shown}", verdict(counts[1e-2] == 1))


@statement(
    "From ε = 1 downwards the number of contacts first grows, then falls: one maximum", "Sec. IV A, Fig. 3", 3
)
def _one_maximum(data: Data) -> Finding:
    counts = data.figure(3)["outline_n_contacts"].values
    path = counts[::-1]
    path = path[np.flatnonzero(np.diff(path, prepend=-1))]
    return Finding(
        f"{', '.join(map(str, path))} contacts as ε falls from 1 to 0.1", verdict(maxima(counts) == 1)
    )


@statement("The same for every set of parameters: the number over ε has a single maximum", "Sec. IV A", 7)
def _one_maximum_everywhere(data: Data) -> Finding:
    linear = data.setup.linear()
    gaps = middles(*figure4.GAPS, ROWS, logarithmic=True)
    ratios = middles(*figure4.RATIOS, ROWS)
    epsilon = np.linspace(*figure4.RESTITUTION, POINTS)
    by_gap = np.array([maxima(row) for row in _counts(linear, gap=gaps, restitution=epsilon)])
    by_ratio = np.array([maxima(row) for row in _counts(linear, radius_ratio=ratios, restitution=epsilon)])
    single = float(np.mean(by_gap == 1)), float(np.mean(by_ratio == 1))
    most = f"{by_gap.max()} maxima at Δh = {gaps[int(np.argmax(by_gap))] * 1e6:.2f} µm"
    hertz = maxima(data.figure(7)["outline_n_contacts"].values)
    return Finding(
        f"linear: one maximum for {_about(single[0])} of the Δh (logarithmic) and {_about(single[1])} "
        f"of the R1/R2 of Fig. 4; {most}; viscoelastic (Fig. 7): {hertz} maxima",
        verdict(min(single) == 1.0 and hertz == 1, min(single) > 0.5),
    )


@statement("The duration of a contact depends only weakly on ε", "Sec. IV A")
def _weakly(data: Data) -> Finding:
    def duration(epsilon: float) -> float:
        return float(data.setup.linear(epsilon).contacts[1].duration())

    changes = {epsilon: 1.0 - duration(epsilon) / duration(1.0) for epsilon in (0.9, 0.7, 0.5, 0.3)}
    shown = ", ".join(f"{100 * change:.0f} % at {epsilon:g}" for epsilon, change in changes.items())
    return Finding(
        f"shorter than at ε = 1 by {shown}",
        verdict(changes[0.7] < 0.1, changes[0.5] < 0.1, changes[0.3] < 0.1),
    )


@statement(
    "The adiabatic solution agrees perfectly with the numerical one at R1/R2 = 10", "Sec. IV A, Fig. 3", 3
)
def _adiabatic(data: Data) -> Finding:
    grid = np.linspace(0.1, 1.0, 1801)
    both = [
        sweep(data.setup.linear(), model=model, restitution=grid, variables=["n_contacts"])[
            "n_contacts"
        ].values
        for model in ("newton", "adiabatic")
    ]
    same = float(np.mean(both[0] == both[1]))
    worst = 0.0
    for epsilon in grid[both[0] == both[1]][::20]:
        column = data.setup.linear(float(epsilon))
        exact = newton(column)
        pair = exact.contacts["pair"].values == 1
        begin = exact.contacts["begin"].values[pair]
        early = begin < exact.t_floor_end  # late contacts drift apart without limit near the tip of a spike
        other = adiabatic(column).contacts
        mine = other["pair"].values == 1
        for name in ("begin", "end"):
            deviation = np.abs(exact.contacts[name].values[pair] - other[name].values[mine])[early]
            worst = max(worst, float(deviation.max(initial=0.0)) / exact.t_floor_end)
    tips = data.figure(3)
    shift = (
        float(np.abs(tips["spike"].values[0] - tips["adiabatic_spike"].values[0]))
        if tips.sizes["spike"]
        else 0.0
    )
    return Finding(
        f"equal counts for {100 * same:.1f} % of the ε from 0.1 to 1; contacts that begin during the floor "
        f"contact within {100 * worst:.2f} % of its duration; first spike shifted by {shift:.4f} in ε",
        verdict(worst < 0.01, same > 0.999),
    )


@statement("The adiabatic solution becomes exact for R1 ≫ R2", "App. A")
def _order(data: Data) -> Finding:
    errors, masses = [], []
    for upper in (0.01, 0.005, 0.0025):
        column = data.setup.linear(0.7, radius_2=upper)
        parted = []
        for solve in (newton, adiabatic):
            result = solve(column)
            after = result.trajectory(result.contacts["end"].values[1])["velocity"].values[0]
            parted.append(after[1] - after[0])
        errors.append(abs(parted[0] - parted[1]) / column.impact_speed)
        masses.append(column.balls[1].mass / column.balls[0].mass)
    order = math.log(errors[0] / errors[-1]) / math.log(masses[0] / masses[-1])
    return Finding(
        f"v2 − v1 after the first contact off by {errors[0]:.1e}, {errors[1]:.1e}, {errors[2]:.1e} V at "
        f"R1/R2 = 10, 20, 40: ∝ (m2/m1)^{order:.2f}",
        verdict(errors[0] > errors[1] > errors[2]),
    )


@statement(
    "Spikes at ε ≈ 0.78 and 0.67, where the balls meet once more after the floor contact",
    "Sec. IV A, Fig. 3",
    3,
)
def _spikes(data: Data) -> Finding:
    tips = data.figure(3)["spike"].values
    shown = ", ".join(f"{tip:.4f}" for tip in tips)
    return Finding(
        f"tips at {shown or 'no ε'}",
        verdict(tips.size > 0 and _near(tips[0], 0.78, 0.005), tips.size > 1 and _near(tips[1], 0.67, 0.005)),
    )


@statement(
    "For each ε some interval of Δh gives the most contacts; the number grows as Δh falls, up to a maximum",
    "Sec. IV A, Fig. 4",
    4,
)
def _maximum_over_gap(data: Data) -> Finding:
    epsilon = middles(*figure4.RESTITUTION, ROWS)
    gaps = np.geomspace(*figure4.GAPS, POINTS)
    counts = _counts(data.setup.linear(), restitution=epsilon, gap=gaps)
    grows, single = [], []
    for column in counts:
        at_most = np.flatnonzero(column == column.max())
        grows.append(bool(np.all(np.diff(column[at_most[-1] :]) <= 0)))
        single.append(bool(at_most[-1] - at_most[0] + 1 == at_most.size))
    i, j = np.unravel_index(int(np.argmax(counts)), counts.shape)
    return Finding(
        f"growing from 10 mm down to the maximum for {_about(float(np.mean(grows)))} of the ε of Fig. 4, the "
        f"maximum in one interval of Δh for {_about(float(np.mean(single)))}; most contacts: {counts.max()}, at ε = "
        f"{epsilon[i]:.3f}, Δh = {gaps[j] * 1e6:.1f} µm",
        verdict(all(grows), all(single)),
    )


@statement("t_c,01/t_c,12 grows with m1/m2", "Sec. IV A")
def _durations(data: Data) -> Finding:
    ratios = []
    for radii in (1.0, 2.0, 5.0, 10.0, 20.0):
        floor, pair = data.setup.linear(0.7, radius_ratio=radii).contacts
        ratios.append(floor.duration() / pair.duration())
    shown = ", ".join(f"{ratio:.2f}" for ratio in ratios)
    return Finding(f"{shown} at R1/R2 = 1, 2, 5, 10, 20", verdict(bool(np.all(np.diff(ratios) > 0))))


@statement(
    "The number of contacts grows with R1/R2, as the dominating of two effects", "Sec. IV A, Fig. 4", 4
)
def _grows_with_ratio(data: Data) -> Finding:
    epsilon = middles(*figure4.RESTITUTION, ROWS)
    ratios = np.linspace(*figure4.RATIOS, POINTS)
    counts = _counts(data.setup.linear(), restitution=epsilon, radius_ratio=ratios)
    never_falls = float(np.mean(np.all(np.diff(counts, axis=1) >= 0, axis=1)))
    ends_higher = float(np.mean(counts[:, -1] > counts[:, 0]))
    return Finding(
        f"higher at {ratios[-1]:g} than at {ratios[0]:g} for {_about(ends_higher)} of the ε of Fig. 4; "
        f"without falling in between for {_about(never_falls)}",
        verdict(ends_higher > 0.9, never_falls > 0.5),
    )


# --- Sec. IV B: effective restitution -----------------------------------------------------------------------


@statement("ε_eff/ε → 1 with growing Δh, where one contact is left", "Sec. IV B, Fig. 5", 5)
def _levels_off(data: Data) -> Finding:
    figure = data.figure(5)
    last = float(figure["restitution_ratio"][-1])
    single = int(figure["n_contacts"][-1]) == 1
    return Finding(
        f"{last:.4f} at {float(figure.gap[-1]) * 1e3:g} mm, with {int(figure.n_contacts[-1])} contact; it "
        f"levels off slightly above 1 because gravity acts during the contact",
        verdict(_near(last, 1.0, 0.01), single),
    )


@statement(
    "At a large gap the floor contact is over when the balls meet, and the collisions are independent",
    "Sec. IV B, Fig. 5",
    5,
)
def _independent_beyond(data: Data) -> Finding:
    column = data.setup.linear(RESTITUTION_5)
    floor = column.contacts[0]
    beta, omega2 = floor.damping / (2 * floor.effective_mass), floor.stiffness / floor.effective_mass
    formula = column.impact_speed * (floor.duration() - 2 * beta * RESTITUTION_5 / omega2)
    low, high = 1e-4, 1e-2
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        result = newton(data.setup.linear(RESTITUTION_5, gap=middle))
        pair = result.contacts["pair"].values == 1
        if float(result.contacts["begin"].values[pair][0]) < result.t_floor_end:
            low = middle
        else:
            high = middle
    ratio = newton(data.setup.linear(RESTITUTION_5, gap=high * 1.01)).restitution_ratio
    return Finding(
        f"from Δh = {high * 1e3:.3f} mm on (without gravity {formula * 1e3:.3f} mm); ε_eff/ε = {ratio:.4f} "
        f"there",
        verdict(_near(ratio, 1.0, 0.01)),
    )


@statement("One contact is necessary but not sufficient for independent collisions", "Sec. IV B, Fig. 5", 5)
def _not_sufficient(data: Data) -> Finding:
    result = newton(data.setup.linear(RESTITUTION_5, gap=5e-4))
    figure = data.figure(5)
    good = np.abs(figure["restitution_ratio"].values - 1.0) < 0.01
    necessary = bool(np.all(figure["n_contacts"].values[good] == 1))
    return Finding(
        f"ε = 0.9, Δh = 0.5 mm: {result.n_contacts} contact, ε_eff/ε = {result.restitution_ratio:.3f} at "
        f"t_f ({result.restitution_ratio_at_separation:.3f} at separation)",
        verdict(necessary, result.n_contacts == 1 and result.restitution_ratio < 0.95),
    )


@statement("The number of contacts over Δh has a maximum", "Sec. IV B, Fig. 5", 5)
def _peak(data: Data) -> Finding:
    figure = data.figure(5)
    counts = figure["n_contacts"].values
    at = figure["gap"].values[counts == counts.max()]
    inside = 0 < int(np.argmax(counts)) < counts.size - 1
    return Finding(
        f"{counts.max()} contacts from {at[0] * 1e6:.2f} to {at[-1] * 1e6:.2f} µm", verdict(inside)
    )


@statement(
    "At very small Δh the number oscillates, because of contacts after the floor contact",
    "Sec. IV B, Fig. 5",
    5,
)
def _oscillates(data: Data) -> Finding:
    figure = data.figure(5)
    found = jumps(figure["gap"].values, figure["n_contacts"].values)
    peak = float(figure["gap"].values[int(np.argmax(figure["n_contacts"].values))])
    falls = [at for at, below, above in found if at < peak and above < below]
    late = 0
    for at in falls:
        result = newton(data.setup.linear(RESTITUTION_5, gap=at * (1 - 1e-7)))
        begin = result.contacts["begin"].values[result.contacts["pair"].values == 1]
        late += int(begin[-1] > result.t_floor_end)
    return Finding(
        f"below {peak * 1e6:.1f} µm it falls {len(falls)} times as Δh grows; in {late} of them the contact "
        f"that is lost began after the floor contact",
        verdict(bool(falls), late == len(falls)),
    )


@statement("ε_eff/ε falls with growing R1/R2, as the contacts become more", "Sec. IV B, Fig. 6", 6)
def _falls_with_ratio(data: Data) -> Finding:
    figure = data.figure(6)
    ratio, counts = figure["restitution_ratio"].values, figure["n_contacts"].values
    peaks = [float(ratio[counts == n].max()) for n in np.unique(counts)]
    overall = bool(np.all(np.diff(peaks) < 0))
    monotone = bool(np.all(np.diff(ratio) <= 1e-9))
    shown = ", ".join(f"{p:.3f}" for p in peaks[:5])
    return Finding(
        f"its maximum at 1, 2, 3, … contacts falls: {shown} …; "
        + ("it never rises" if monotone else "but it jumps to ≈ 0 at each new contact and rises from there"),
        verdict(overall, monotone),
    )


@statement("For most parameters several contacts dissipate more: ε_eff/ε < 1", "Sec. IV B", 4, 5, 6)
def _most(data: Data) -> Finding:
    maps, radii = data.figure(4), data.figure(6)
    shares, highest = [], 0.0
    for name in ("gap", "radius_ratio"):
        several = maps[f"n_contacts_over_{name}"].values > 1
        shares.append(share(several, *figure4.axes(maps, name)))
        ratio = maps[f"restitution_ratio_over_{name}"].values[several]
        highest = max(highest, float(np.nanmax(ratio, initial=0.0)))
    shares.append(share(radii["n_contacts"].values > 1, (radii["radius_ratio"].values, False)))
    return Finding(
        f"several contacts on {100 * shares[0]:.0f} % of the upper map of Fig. 4 (Δh logarithmic), "
        f"{100 * shares[1]:.0f} % of the lower one, and {100 * shares[2]:.0f} % of the R1/R2 of Fig. 6; with "
        f"several contacts ε_eff/ε is at most {highest:.3f} on the maps",
        verdict(*(part > 0.5 for part in shares), highest < 1.0),
    )


@statement("Near R1 = R2 dissipation is reduced: a small interval with ε_eff/ε > 1", "Sec. IV B, Fig. 6", 6)
def _reduced(data: Data) -> Finding:
    low, high, at, top = figure6.above_one(data.figure(6))
    shown = (
        f"ε = {RESTITUTION_6:g}: above 1 from R1/R2 = {low:.2f} to {high:.2f}, at most {top:.4f} at {at:.2f}"
    )
    return Finding(shown if top > 1.0 else "nowhere above 1", verdict(top > 1.0, high - low < 1.0))


@statement("Only in that interval is ε_eff > ε", "Sec. IV B", 4, 5, 6)
def _only_there(data: Data) -> Finding:
    figure, maps = data.figure(5), data.figure(4)
    ratio, gap = figure["restitution_ratio"].values, figure["gap"].values
    above = gap[ratio > 1.0]
    radii = data.figure(6)["restitution_ratio"].values
    one_interval = int(np.sum(np.diff((radii > 1.0).astype(int)) == 1)) <= 1
    elsewhere = (
        f"also for every Δh above {above[0] * 1e3:.2f} mm in Fig. 5 (up to {ratio.max():.4f})"
        if above.size
        else "nowhere in Fig. 5"
    )
    shares = []
    for name in ("gap", "radius_ratio"):
        values = maps[f"restitution_ratio_over_{name}"].values
        shares.append((share(values > 1.0, *figure4.axes(maps, name)), *_highest(data, name)))
    (upper, upper_top, _), (lower, lower_top, where) = shares
    return Finding(
        f"{elsewhere}, on {100 * upper:.0f} % of the upper map of Fig. 4 (up to {upper_top:.4f}) and "
        f"{100 * lower:.0f} % of the lower one (up to {lower_top:.2f}, {where}); within Fig. 6, "
        + ("nowhere else" if one_interval else "also elsewhere"),
        verdict(one_interval, above.size == 0, upper == 0.0),
    )


@statement("ε_eff/ε takes any value from almost 0 to slightly above 1", "Sec. V, Figs. 5–6", 4, 5, 6)
def _range(data: Data) -> Finding:
    curves = [data.figure(n)["restitution_ratio"].values for n in (5, 6)]
    both = np.sort(np.concatenate(curves))
    hole = int(np.argmax(np.diff(both)))
    (upper, _), (lower, where) = (_highest(data, name) for name in ("gap", "radius_ratio"))
    shown = "; ".join(
        f"Fig. {n} (ε = {epsilon:g}): {curve.min():.1e} to {curve.max():.4f}"
        for n, epsilon, curve in zip((5, 6), (RESTITUTION_5, RESTITUTION_6), curves, strict=True)
    )
    return Finding(
        f"{shown}; neither has a value between {both[hole]:.3f} and {both[hole + 1]:.3f}. Maps of Fig. 4: up to "
        f"{upper:.4f} on the upper and {lower:.2f} on the lower one ({where})",
        verdict(
            bool(both[0] < 0.01),
            bool(1.0 < both[-1] < 1.05),
            bool(both[hole + 1] - both[hole] < 0.01),
            max(upper, lower) < 1.05,
        ),
    )


def _highest(data: Data, name: str) -> tuple[float, str]:
    """The largest ε_eff/ε on a map of Fig. 4, and where it lies.

    The map shows at which ε; the ridge is narrower than its cells, and is sampled again along that ε.
    """
    maps = data.figure(4)
    values = maps[f"restitution_ratio_over_{name}"].values
    epsilon = float(maps["restitution"].values[np.nanargmax(np.nanmax(values, axis=1))])
    low, high = figure4.GAPS if name == "gap" else figure4.RATIOS
    fine = np.geomspace(low, high, POINTS) if name == "gap" else np.linspace(low, high, POINTS)
    swept: dict[str, Any] = {name: fine}
    row = sweep(data.setup.linear(epsilon), variables=["restitution_ratio"], **swept)[
        "restitution_ratio"
    ].values
    i = int(np.nanargmax(row))
    place = f"Δh = {fine[i] * 1e3:.2f} mm" if name == "gap" else f"R1/R2 = {fine[i]:.2f}"
    return float(row[i]), f"at ε = {epsilon:.2f}, {place}"


# --- Appendices ---------------------------------------------------------------------------------------------


@statement("Viscoelastic spheres show the same structure", "App. B, Fig. 7", 7)
def _same_structure(data: Data) -> Finding:
    figure = data.figure(7)
    counts = figure["outline_n_contacts"].values
    late = late_contacts("restitution_outline", figure, "outline_")
    rises = counts.max() > counts[-1] and counts[0] < counts[-1]
    return Finding(
        f"{counts[-1]} contacts at ε = 1, up to {counts.max()}, {counts[0]} at ε = 0.1; {len(late)} "
        f"intervals of ε with a contact after the floor contact; {maxima(counts)} maxima over ε instead of "
        f"one",
        verdict(bool(rises), bool(late), maxima(counts) == 1),
    )


@statement("Y = 6e9 N/m² matches the linear force at an overlap of (R1 + R2)/10", "App. B")
def _matched(data: Data) -> Finding:
    column = data.setup.linear()
    lower, upper = column.balls
    overlap = (lower.radius + upper.radius) / 10
    unit = LAWS["viscoelastic"](youngs_modulus=1.0, poisson_ratio=POISSON_RATIO, dissipative_time=0.0)
    linear = column.contacts[1].stiffness * overlap
    pair, floor = (
        linear / unit.between(*bodies).force(overlap) for bodies in ((upper, lower), (lower, FLOOR))
    )
    return Finding(
        f"Y = {pair:.3g} N/m² for the two balls, {floor:.3g} for ball and floor",
        verdict(_near(pair, YOUNGS_MODULUS_INSET, 0.05e9)),
    )


@statement(
    "In the geometry of Fig. 3 viscoelastic balls still touch several times", "App. B, Fig. 7 inset", 7
)
def _inset(data: Data) -> Finding:
    counts = data.figure(7)["inset_outline_n_contacts"].values
    return Finding(f"{counts[-1]} contacts at ε = 1, up to {counts.max()}", verdict(counts.max() > 1))


@statement("The restitution of viscoelastic spheres depends on the speed", "App. B")
def _speed(data: Data) -> Finding:
    column = data.setup.viscoelastic(0.7)
    values = column.contacts[0].restitution(np.array([0.1, INPUT_SPEED, column.impact_speed]))
    return Finding(
        f"A set by ε = 0.7 at {INPUT_SPEED:g} m/s: {values[0]:.4f} at 0.1 m/s, {values[2]:.4f} at the "
        f"{column.impact_speed:.3f} m/s of the drop",
        verdict(values[0] > values[1] > values[2]),
    )


@statement(
    "One material for both contacts gives the same structure, with minor differences in numbers",
    "App. C, Fig. 8",
    7,
    8,
)
def _one_material(data: Data) -> Finding:
    def features(number: int, name: str) -> tuple[NDArray[np.int64], int]:
        figure = data.figure(number)
        return figure["outline_n_contacts"].values, len(late_contacts(name, figure, "outline_"))

    (one, late_one), (both, late_both) = (
        features(7, "restitution_outline"),
        features(8, "dissipative_time_outline"),
    )
    path_one, path_both = (c[np.flatnonzero(np.diff(c, prepend=-1))] for c in (one[::-1], both))
    same_path = bool(np.array_equal(path_one, path_both))
    return Finding(
        f"Fig. 8: {', '.join(map(str, path_both))} contacts as A grows, Fig. 7 "
        f"{'the same' if same_path else ', '.join(map(str, path_one))}; late contacts in {late_both} "
        f"intervals (Fig. 7: {late_one})",
        verdict(both.max() > 1 and late_both > 0, abs(int(both.max()) - int(one.max())) <= 1),
    )


@statement("One material means ε01 ≠ ε12", "App. C")
def _two_restitutions(data: Data) -> Finding:
    floor, pair = (float(c.restitution(INPUT_SPEED)) for c in data.setup.same_material(1e-5).contacts)
    return Finding(
        f"A = 10 µs: ε01 = {floor:.4f}, ε12 = {pair:.4f} at {INPUT_SPEED:g} m/s",
        verdict(not _near(floor, pair, 1e-3)),
    )
