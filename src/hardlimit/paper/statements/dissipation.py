"""Secs. IV B and V: where several contacts dissipate more or less than one (Figs. 4 to 6)."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from ...sweep import sweep
from .. import figure4, figure6
from ..data import Data
from ..sampling import share
from ..setup import RESTITUTION_5, RESTITUTION_6
from .statement import POINTS, Finding, Statements, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add("ε_eff/ε falls with growing R1/R2, as the contacts become more", "Sec. IV B, Fig. 6", 6)
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


@STATEMENTS.add("For most parameters several contacts dissipate more: ε_eff/ε < 1", "Sec. IV B", 4, 5, 6)
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


@STATEMENTS.add(
    "Near R1 = R2 dissipation is reduced: a small interval with ε_eff/ε > 1", "Sec. IV B, Fig. 6", 6
)
def _reduced(data: Data) -> Finding:
    low, high, at, top = figure6.above_one(data.figure(6))
    shown = (
        f"ε = {RESTITUTION_6:g}: above 1 from R1/R2 = {low:.2f} to {high:.2f}, at most {top:.4f} at {at:.2f}"
    )
    return Finding(shown if top > 1.0 else "nowhere above 1", verdict(top > 1.0, high - low < 1.0))


@STATEMENTS.add("Only in that interval is ε_eff > ε", "Sec. IV B", 4, 5, 6)
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


@STATEMENTS.add("ε_eff/ε takes any value from almost 0 to slightly above 1", "Sec. V, Figs. 5–6", 4, 5, 6)
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
