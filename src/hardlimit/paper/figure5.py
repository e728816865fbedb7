"""Fig. 5: ε_eff/ε over Δh at ε = 0.9, and the number of contacts."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from ..column.solvers import newton
from ..plots.labels import QUANTITIES
from ..plots.style import PAGE_WIDTH
from ..sweep import sweep
from .drawing import MICRO, MILLI, count_ticks, ratio_and_counts
from .sampling import ball_contacts, bisect, counts_of, refine, variable
from .setup import Paper
from .statement import Outcome, Statements, near

TITLE: Final = "Effective restitution over the initial gap"
CHOICES: Final = (
    "The ranges are chosen here: Δh up to 4 mm, and from 0.3 µm to 0.44 mm on a logarithmic axis."
)
WEIGHT: Final = 1.0
STATEMENTS: Final = Statements()

RESTITUTION: Final = 0.9
SMALL: Final = (3e-7, 4.4e-4)
LARGE: Final = (4.4e-4, 4e-3)


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.linear(RESTITUTION), "gap_m")


def compute(paper: Paper) -> xr.Dataset:
    """One curve from 0.3 µm to 4 mm with dense points at every jump; both panels show parts of it."""
    column = paper.linear(RESTITUTION)
    grid = np.concatenate([np.geomspace(*SMALL, 2400), np.linspace(*LARGE, 600)])
    gap = refine(counts_of(column, "gap"), grid, logarithmic=True)
    wanted = ["n_contacts", "relative_velocity", "restitution_ratio", "t_floor_end", "t_end"]
    data = sweep(column, gap=gap, variables=wanted)
    data["n_contacts"] = data["n_contacts"].astype(np.int64)
    data["magnified_gap"] = variable((), SMALL[1], "m", "largest Δh of the magnification")
    return data


def safe_gap(data: xr.Dataset) -> float:
    """Smallest Δh above which the ratio stays within 0.01 of 1 [m]; NaN if there is none."""
    good = np.abs(data["restitution_ratio"].values - 1.0) <= 0.01
    bad = np.flatnonzero(~good)
    first = 0 if bad.size == 0 else bad[-1] + 1
    return float(data["gap"].values[first]) if first < good.size else float("nan")


def meaning(data: xr.Dataset) -> str:
    return (
        f"With ε = {RESTITUTION} an event-driven simulation has the right relative velocity, to one per cent of ε, "
        f"only for gaps above {safe_gap(data) * 1e3:.1f} mm; at smaller gaps the effective restitution jumps, down to "
        f"almost 0."
    )


# --- drawing ------------------------------------------------------------------------------------------------


NARROWEST: Final = 0.012  #: branch of the curve that is drawn, in widths of the axes


def draw(data: xr.Dataset) -> Figure:
    """The whole range above, small gaps magnified below."""
    figure = Figure(figsize=(PAGE_WIDTH * 0.85, 6.6))
    top, bottom = figure.subplots(2, 1)
    most = int(data["n_contacts"].max())
    longest = float(data["gap"][-1])
    wide = data.sel(gap=slice(_first_wide(data, NARROWEST * longest), None))
    right = ratio_and_counts(top, wide["gap"].values * MILLI, wide)
    top.set_xlim(0.0, longest * MILLI)
    top.set_ylim(0.0, 1.08)
    small = data.sel(gap=slice(None, float(data["magnified_gap"]) * (1 + 1e-12)))
    right.axvspan(0.0, float(small["gap"][-1]) * MILLI, color="#ececec", lw=0, zorder=-1)
    lower = ratio_and_counts(bottom, small["gap"].values * MICRO, small)
    bottom.set_xscale("log")
    bottom.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    bottom.set_xlim(float(small["gap"][0]) * MICRO, float(small["gap"][-1]) * MICRO)
    bottom.set_ylim(0.0, float(small["restitution_ratio"].max()) * 1.08)
    for axes in (right, lower):
        axes.set_ylim(0.0, most * 1.08)
        count_ticks(axes, most)
    top.set_xlabel(rf"{QUANTITIES['gap'][0]} [mm]")
    bottom.set_xlabel(rf"{QUANTITIES['gap'][0]} [µm]")
    hidden = wide.sizes["gap"] < data.sizes["gap"]
    dense = f"; not drawn below {float(wide['gap'][0]) * MILLI:.2g} mm" if hidden else ""
    top.set_title(f"(a)  shaded: the range of (b){dense}", loc="left", pad=4)
    bottom.set_title("(b)  small gaps, on a logarithmic axis", loc="left", pad=4)
    return figure


def _first_wide(data: xr.Dataset, width: float) -> float:
    """Δh [m] above which every interval of equal counts is at least ``width`` wide."""
    gap = data["gap"].values
    edges = gap[np.flatnonzero(np.diff(data["n_contacts"].values)) + 1]
    narrow = np.flatnonzero(np.diff(np.append(edges, gap[-1])) < width)
    return float(edges[narrow[-1] + 1]) if narrow.size and narrow[-1] + 1 < edges.size else float(gap[0])


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add("ε_eff/ε → 1 with growing Δh, where one contact is left", "Sec. IV B, Fig. 5", 5)
def _levels_off(paper: Paper) -> Outcome:
    figure = paper.figure(5)
    last = float(figure["restitution_ratio"][-1])
    single = int(figure["n_contacts"][-1]) == 1
    text = (
        f"{last:.4f} at {float(figure.gap[-1]) * 1e3:g} mm, with {int(figure.n_contacts[-1])} contact; it "
        f"levels off slightly above 1 because gravity acts during the contact"
    )
    return text, near(last, 1.0, 0.01), single


@STATEMENTS.add(
    "At a large gap the floor contact is over when the balls meet, and the collisions are independent",
    "Sec. IV B, Fig. 5",
    5,
)
def _independent_beyond(paper: Paper) -> Outcome:
    column = paper.linear(RESTITUTION)
    floor = column.contacts[0]
    beta, omega2 = floor.damping / (2 * floor.effective_mass), floor.stiffness / floor.effective_mass
    formula = column.impact_speed * (floor.duration() - 2 * beta * RESTITUTION / omega2)

    def meets_during_floor_contact(gap: float) -> bool:
        result = newton(paper.linear(RESTITUTION, gap=gap))
        return bool(ball_contacts(result)[0][0] < result.t_floor_end)

    _, high = bisect(1e-4, 1e-2, meets_during_floor_contact, 1e-9)
    ratio = newton(paper.linear(RESTITUTION, gap=high * 1.01)).restitution_ratio
    return (
        f"from Δh = {high * 1e3:.3f} mm on (without gravity {formula * 1e3:.3f} mm); ε_eff/ε = {ratio:.4f} "
        f"there",
        near(ratio, 1.0, 0.01),
    )


@STATEMENTS.add(
    "One contact is necessary but not sufficient for independent collisions", "Sec. IV B, Fig. 5", 5
)
def _not_sufficient(paper: Paper) -> Outcome:
    result = newton(paper.linear(RESTITUTION, gap=5e-4))
    figure = paper.figure(5)
    good = np.abs(figure["restitution_ratio"].values - 1.0) < 0.01
    necessary = bool(np.all(figure["n_contacts"].values[good] == 1))
    text = (
        f"ε = 0.9, Δh = 0.5 mm: {result.n_contacts} contact, ε_eff/ε = {result.restitution_ratio:.3f} at "
        f"t_f ({result.restitution_ratio_at_separation:.3f} at separation)"
    )
    return text, necessary, result.n_contacts == 1 and result.restitution_ratio < 0.95


@STATEMENTS.add("The number of contacts over Δh has a maximum", "Sec. IV B, Fig. 5", 5)
def _peak(paper: Paper) -> Outcome:
    figure = paper.figure(5)
    counts = figure["n_contacts"].values
    at = figure["gap"].values[counts == counts.max()]
    inside = 0 < int(np.argmax(counts)) < counts.size - 1
    return (f"{counts.max()} contacts from {at[0] * 1e6:.2f} to {at[-1] * 1e6:.2f} µm", inside)


@STATEMENTS.add(
    "At very small Δh the number oscillates, because of contacts after the floor contact",
    "Sec. IV B, Fig. 5",
    5,
)
def _oscillates(paper: Paper) -> Outcome:
    figure = paper.figure(5)
    gap, counts = figure["gap"].values, figure["n_contacts"].values
    peak = float(gap[int(np.argmax(counts))])
    falls = [0.5 * (gap[i] + gap[i + 1]) for i in np.flatnonzero(np.diff(counts) < 0)]
    falls = [at for at in falls if at < peak]
    late = 0
    for at in falls:
        result = newton(paper.linear(RESTITUTION, gap=at * (1 - 1e-7)))
        late += int(ball_contacts(result)[0][-1] > result.t_floor_end)
    text = (
        f"below {peak * 1e6:.1f} µm it falls {len(falls)} times as Δh grows; in {late} of them the contact "
        f"that is lost began after the floor contact"
    )
    return text, bool(falls), late == len(falls)
