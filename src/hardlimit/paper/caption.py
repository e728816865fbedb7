"""Captions of figures: the parameters, and the meaning for event-driven simulations."""

from __future__ import annotations

import json
import math
import re
import textwrap
from typing import Any, Final

import xarray as xr
from matplotlib.figure import Figure

FONT_SIZE: Final = 8.5  #: [points]
LINE: Final = 0.155  #: [inch] from one line of the caption to the next
LETTERS: Final = 17.3  #: average number of characters per inch

#: Symbol and unit of the entries of ``attrs["parameters"]``, in the order of the caption.
SYMBOLS: Final = {
    "restitution": ("ε", ""),
    "impact_speed_m_s": ("v_in", "m/s"),
    "gap_m": ("Δh", "m"),
    "radius_1_m": ("R1", "m"),
    "radius_2_m": ("R2", "m"),
    "stiffness_N_m": ("k", "N/m"),
    "youngs_modulus_N_m2": ("Y", "N/m²"),
    "poisson_ratio": ("ν", ""),
    "density_kg_m3": ("ρ", "kg/m³"),
    "height_m": ("z1(0)", "m"),
}

#: Plain symbols as mathematical text.
TYPESET: Final = {
    "R1/R2": "$R_1/R_2$",
    "z1(0)": "$z_1^{(0)}$",
    "v_in": r"$v_\mathrm{in}$",
    "R1": "$R_1$",
    "R2": "$R_2$",
    "Δh": r"$\Delta h$",
    "ε": r"$\varepsilon$",
    "k": "$k$",
    "Y": "$Y$",
    "ν": r"$\nu$",
    "ρ": r"$\rho$",
}


def write_caption(figure: Figure, data: xr.Dataset) -> None:
    """Write parameters and meaning below the axes, which shrink to make room."""
    width, height = figure.get_size_inches()
    wrap = int(LETTERS * width)
    lines = textwrap.wrap(parameter_line(json.loads(data.attrs["parameters"])), wrap)
    lines += textwrap.wrap(str(data.attrs.get("meaning", "")), wrap)
    below = (LINE * len(lines) + 0.15) / height
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, below, 1.0, 1.0 - below))
    for i, line in enumerate(reversed(lines)):
        y = (0.07 + LINE * i) / height
        figure.text(0.02, y, typeset(line), ha="left", va="baseline", fontsize=FONT_SIZE, color="#222222")


def parameter_line(parameters: dict[str, Any]) -> str:
    """``Parameters: ε = 0.7, Δh = 0.1 mm, …``, without line breaks inside an entry."""
    parts = []
    for name, (symbol, unit) in SYMBOLS.items():
        if name in parameters:
            value = f"{symbol} = {quantity(float(parameters[name]), unit)}"
            parts.append(value.replace(" ", "\u00a0"))
    return f"Parameters: {', '.join(parts)}."


def quantity(value: float, unit: str) -> str:
    """A number with its unit: lengths in m, cm or mm, large numbers as 5×10^7."""
    if unit == "m":
        factor, unit = next((f, u) for least, f, u in _LENGTHS if abs(value) >= least)
        value *= factor
    text = f"{value:.6g}"
    if abs(value) >= 1e5:
        exponent = math.floor(math.log10(abs(value)))
        digits = f"{value / 10.0**exponent:.4g}"
        text = f"10^{exponent}" if digits == "1" else f"{digits}×10^{exponent}"
    return f"{text} {unit}".rstrip()


_LENGTHS: Final = ((0.2, 1.0, "m"), (5e-3, 1e2, "cm"), (0.0, 1e3, "mm"))


def typeset(text: str) -> str:
    """Text with symbols and powers of ten as mathematical text."""
    for plain, mathematical in TYPESET.items():
        alone = rf"(?<![\w$\\_{{/]){re.escape(plain)}(?![\w/])"
        text = re.sub(alone, mathematical.replace("\\", r"\\"), text)
    return re.sub(r"10\^(\d+)", r"$10^{\1}$", text)
