"""Inference of the density, which the paper does not give, from the facts that it states."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from ..column.solvers import newton
from ..plots.style import PAGE_WIDTH, style
from .drawing import BLUE, RED
from .report import Row
from .sampling import Array, bisect, counts_over, variable
from .setup import Paper

#: The facts: contacts at ε = 1, and the tips of the two uppermost spikes, to half a unit of the last digit.
CONTACTS_AT_ONE = 3
SPIKES = (0.78, 0.67)
HALF_DIGIT = 0.005

#: Range of the scan, its step, and the finer step around the best density [kg/m³].
RANGE = (300.0, 3000.0)
COARSE = 20.0
FINE = 1.0


def spike_tips(paper: Paper) -> list[float]:
    """ε below which one more contact follows after the floor contact: the two highest (NaN: none)."""
    grid = np.linspace(0.62, 1.0, 381)
    rising = np.flatnonzero(np.diff(counts_over(paper.linear(), restitution=grid)) < 0)  # towards small ε
    tips = []
    for i in rising[::-1][:2]:
        count = newton(paper.linear(float(grid[i]))).n_contacts

        def below(epsilon: float, count: int = count) -> bool:
            return newton(paper.linear(epsilon)).n_contacts >= count

        tips.append(0.5 * sum(bisect(float(grid[i]), float(grid[i + 1]), below, 1e-7)))
    return (tips + [float("nan")] * 2)[:2]


def infer(progress: Callable[[float], object] = lambda part: None) -> xr.Dataset:
    """Scan the density, finely where the facts hold. Data: contacts at ε = 1, spike tips, whether all facts hold."""
    facts: dict[float, tuple[int, list[float]]] = {}

    def add(densities: Array, start: float, part: float) -> None:
        for i, rho in enumerate(densities):
            paper = Paper(float(rho))
            facts[float(rho)] = newton(paper.linear(1.0)).n_contacts, spike_tips(paper)
            progress(start + part * (i + 1) / len(densities))

    add(np.arange(RANGE[0], RANGE[1] + COARSE, COARSE), 0.0, 0.5)
    misfit = {rho: np.abs(np.array(tips) - SPIKES).max() for rho, (_, tips) in facts.items()}
    best = min(misfit, key=lambda rho: misfit[rho] if math.isfinite(misfit[rho]) else math.inf)
    add(np.arange(best - 2 * COARSE, best + 2 * COARSE + FINE, FINE), 0.5, 0.5)

    density = np.array(sorted(facts))
    counts = np.array([facts[rho][0] for rho in density])
    tips = np.array([facts[rho][1] for rho in density])
    holds = (counts == CONTACTS_AT_ONE) & np.all(np.abs(tips - SPIKES) <= HALF_DIGIT, axis=1)
    return xr.Dataset(
        {
            "n_contacts_elastic": variable("density", counts, "1", "contacts at ε = 1"),
            "spike": variable(("density", "tip"), tips, "1", "ε at the tip of a spike of Fig. 3"),
            "holds": variable("density", holds.astype(np.int8), "1", "1 where all stated facts hold"),
        },
        coords={
            "density": variable("density", density, "kg/m3", "density of both balls"),
            "tip": variable("tip", [1, 2], "1", "number of the spike, highest first"),
            "printed": variable("tip", list(SPIKES), "1", "as the paper prints it"),
        },
        attrs={"half_digit": HALF_DIGIT},
    )


def draw(scan: xr.Dataset) -> Figure:
    """The tips of the two uppermost spikes over the density, the printed values, and where all facts hold."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.7, 3.4))
        ax = figure.subplots()
        x, holds = scan["density"].values, scan["holds"].values == 1
        near = x[holds] if holds.any() else x
        shown = (x > near[0] - 150.0) & (x < near[-1] + 150.0)
        half = float(scan.attrs["half_digit"])
        for i, (printed, colour) in enumerate(zip(scan["printed"].values, (BLUE, RED), strict=True)):
            ax.axhspan(printed - half, printed + half, color=colour, alpha=0.18, lw=0)
            label = rf"spike at $\varepsilon\approx{printed:g}$ in the paper"
            ax.plot(x[shown], scan["spike"].values[shown, i], color=colour, label=label)
        if holds.any():
            ax.axvspan(near[0], near[-1], color="#888888", alpha=0.25, lw=0)
            ax.annotate(
                f"{0.5 * (near[0] + near[-1]):.0f} ± {0.5 * (near[-1] - near[0]):.0f} kg/m³",
                (near[-1], 0.5),
                (6, 0),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                va="center",
            )
        ax.set_xlim(x[shown][0], x[shown][-1])
        ax.set_xlabel("density [kg/m³]")
        ax.set_ylabel(r"$\varepsilon$ at the tip of the spike")
        ax.legend(loc="upper left")
    return figure


def rows(paper: Paper, scan: xr.Dataset | None) -> list[Row]:
    """The row of the table on the density, and after a scan a row with the range in which the facts hold."""
    tips = spike_tips(paper)
    n = newton(paper.linear(1.0)).n_contacts
    good = n == CONTACTS_AT_ONE and all(abs(a - b) <= HALF_DIGIT for a, b in zip(tips, SPIKES, strict=True))
    stated = (
        "The paper states no density; the one used here must reproduce 3 contacts at ε = 1 and spikes at ε ≈ 0.78 "
        "and 0.67"
    )
    result = f"ρ = {paper.density:g} kg/m³: {n} contacts, spikes at {tips[0]:.4f} and {tips[1]:.4f}"
    table = [Row(stated, "Sec. IV A", result, "yes" if good else "no", "density")]
    if scan is not None:
        densities = scan["density"].values[scan["holds"].values == 1]
        result = "no density of the scan reproduces all facts"
        if densities.size:
            middle, half = 0.5 * (densities[0] + densities[-1]), 0.5 * (densities[-1] - densities[0])
            result = f"all facts hold from {densities[0]:g} to {densities[-1]:g}: ρ = {middle:.0f} ± {half:.0f} kg/m³"
        inside = densities.size > 0 and densities[0] <= paper.density <= densities[-1]
        scanned = f"Density inferred by a scan of {RANGE[0]:g}–{RANGE[1]:g} kg/m³ for these facts"
        table.append(Row(scanned, "Sec. IV A", result, "yes" if inside else "no", "density"))
    return table
