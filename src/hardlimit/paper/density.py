"""The density that the paper does not print, inferred from the facts that it states."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import xarray as xr

from ..column.solvers import newton
from ..sweep import sweep
from .report import Row
from .sampling import Array
from .setup import Setup

#: The facts: contacts at ε = 1, and the tips of the two uppermost spikes, to half a unit of the last digit.
CONTACTS_AT_ONE = 3
SPIKES = (0.78, 0.67)
HALF_DIGIT = 0.005

#: Densities scanned, their distance, and the distance around the best of them [kg/m³].
RANGE = (300.0, 3000.0)
COARSE = 20.0
FINE = 1.0


def spike_tips(setup: Setup, lowest: float = 0.62) -> list[float]:
    """ε below which one more contact follows after the floor contact: the two highest (NaN: none)."""
    column = setup.linear()
    grid = np.linspace(lowest, 1.0, 381)
    tips: list[float] = []
    while len(tips) < 2:
        count = sweep(column, restitution=grid, variables=["n_contacts"])["n_contacts"].values.astype(int)
        rising = np.flatnonzero(np.diff(count) < 0)  # towards small ε
        if rising.size <= len(tips):
            break
        low, high = grid[rising[-1 - len(tips)]], grid[rising[-1 - len(tips)] + 1]
        tips.append(_bisect(setup, float(low), float(high)))
    return (tips + [float("nan")] * 2)[:2]


def _bisect(setup: Setup, low: float, high: float) -> float:
    below = newton(setup.linear(low)).n_contacts
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        if newton(setup.linear(middle)).n_contacts >= below:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def infer(progress: Callable[[float], object] = lambda part: None) -> xr.Dataset:
    """Scan the density, finely where the facts hold: contacts at ε = 1, spike tips, and whether all hold."""
    found: dict[float, tuple[int, list[float]]] = {}

    def add(densities: Array, start: float, share: float) -> None:
        for i, rho in enumerate(densities):
            setup = Setup(float(rho))
            found[float(rho)] = newton(setup.linear(1.0)).n_contacts, spike_tips(setup)
            progress(start + share * (i + 1) / len(densities))

    add(np.arange(RANGE[0], RANGE[1] + COARSE, COARSE), 0.0, 0.5)
    misfit = {rho: np.abs(np.array(tips) - SPIKES).max() for rho, (_, tips) in found.items()}
    best = min(misfit, key=lambda rho: misfit[rho] if math.isfinite(misfit[rho]) else math.inf)
    add(np.arange(best - 2 * COARSE, best + 2 * COARSE + FINE, FINE), 0.5, 0.5)

    density = np.array(sorted(found))
    counts = np.array([found[rho][0] for rho in density])
    tips = np.array([found[rho][1] for rho in density])
    holds = (counts == CONTACTS_AT_ONE) & np.all(np.abs(tips - SPIKES) <= HALF_DIGIT, axis=1)
    return xr.Dataset(
        {
            "n_contacts_elastic": ("density", counts, {"units": "1", "long_name": "contacts at ε = 1"}),
            "spike": (
                ("density", "tip"),
                tips,
                {"units": "1", "long_name": "ε at the tip of a spike of Fig. 3"},
            ),
            "holds": (
                "density",
                holds.astype(np.int8),
                {"units": "1", "long_name": "1 where all stated facts hold"},
            ),
        },
        coords={
            "density": ("density", density, {"units": "kg/m3", "long_name": "density of both balls"}),
            "tip": ("tip", [1, 2], {"units": "1", "long_name": "number of the spike, highest first"}),
            "printed": ("tip", list(SPIKES), {"units": "1", "long_name": "as the paper prints it"}),
        },
        attrs={"half_digit": HALF_DIGIT},
    )


def rows(setup: Setup, scan: xr.Dataset | None) -> list[Row]:
    """The density row of the table, and with a scan where the facts hold."""
    tips = spike_tips(setup)
    n = newton(setup.linear(1.0)).n_contacts
    good = n == CONTACTS_AT_ONE and all(abs(a - b) <= HALF_DIGIT for a, b in zip(tips, SPIKES, strict=True))
    found = [
        Row(
            "No density is printed; with the one used here the stated facts (3 contacts at ε = 1, spikes "
            "at ε ≈ 0.78 and 0.67) must come out",
            "Sec. IV A",
            f"ρ = {setup.density:g} kg/m³: {n} contacts, spikes at {tips[0]:.4f} and {tips[1]:.4f}",
            "yes" if good else "no",
            "density",
        )
    ]
    if scan is not None:
        held = scan["density"].values[scan["holds"].values == 1]
        if held.size:
            middle, half = 0.5 * (held[0] + held[-1]), 0.5 * (held[-1] - held[0])
            result = f"all facts hold from {held[0]:g} to {held[-1]:g}: ρ = {middle:.0f} ± {half:.0f} kg/m³"
        else:
            result = "no density scanned satisfies all facts"
        inside = held.size > 0 and held[0] <= setup.density <= held[-1]
        found.append(
            Row(
                f"Density inferred by a scan of {RANGE[0]:g}–{RANGE[1]:g} kg/m³ for those facts",
                "Sec. IV A",
                result,
                "yes" if inside else "no",
                "density",
            )
        )
    return found
