"""The density inferred from the spikes of Fig. 3."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from matplotlib.figure import Figure

from ...plots.style import PAGE_WIDTH, PALETTE, style

if TYPE_CHECKING:
    import xarray as xr

BLUE: Final = PALETTE["blue"]
RED: Final = PALETTE["vermillion"]


def density(scan: xr.Dataset) -> Figure:
    """The tips of the two uppermost spikes over the density, what the paper prints, and where both agree."""
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
