"""Line styles of models, labels of quantities, and units with prefixes."""

from __future__ import annotations

import math
import re
from typing import Any, Final

#: Line style of each model. The adiabatic line often coincides with Newton's: it is broad, pale and below.
LOOKS: Final[dict[str, dict[str, Any]]] = {
    "newton": {"ls": "-"},
    "independent": {"ls": (0, (5, 2))},
    "adiabatic": {"ls": "-", "lw": 4.5, "alpha": 0.3, "zorder": 1.5},
}

# Label and unit of parameters and variables. A unit in the attributes of a variable takes precedence.
QUANTITIES: Final = {
    "restitution": (r"coefficient of restitution $\varepsilon$", ""),
    "gap": (r"initial gap $\Delta h$", "m"),
    "radius_ratio": (r"ratio of radii $R_1/R_2$", ""),
    "radius_1": (r"radius of the lower ball $R_1$", "m"),
    "radius_2": (r"radius of the upper ball $R_2$", "m"),
    "density": (r"density $\rho$", "kg/m³"),
    "stiffness": (r"stiffness $k$", "N/m"),
    "damping": (r"damping $\gamma$", "N s/m"),
    "height": (r"release height $z_1^{(0)}$", "m"),
    "gravity": (r"gravity $g$", "m/s²"),
    "youngs_modulus": (r"Young’s modulus $Y$", "Pa"),
    "poisson_ratio": (r"Poisson’s ratio $\nu$", ""),
    "dissipative_time": (r"dissipative time $A$", "s"),
    "impact_speed": (r"speed of impact", "m/s"),
    "n_contacts": ("ball–ball contacts", ""),
    "relative_velocity": (r"relative velocity $v_r^{\,\prime}$ at $t_f$", "m/s"),
    "separation_velocity": ("separation velocity", "m/s"),
    "effective_restitution": (r"effective restitution $\varepsilon_\mathrm{eff}$", ""),
    "restitution_ratio": (r"$\varepsilon_\mathrm{eff}/\varepsilon$", ""),
    "effective_restitution_at_separation": (r"$\varepsilon_\mathrm{eff}$ at separation", ""),
    "restitution_ratio_at_separation": (r"$\varepsilon_\mathrm{eff}/\varepsilon$ at separation", ""),
    "t_end": (r"end of the sequence $t_f$", "s"),
    "t_floor_end": ("end of the floor contact", "s"),
}

MAX_LABEL: Final = 50  #: longest meaning [characters] that an axis shows; beyond it the name
PREFIXED: Final = ("m", "s", "Pa")  #: units that take a prefix on an axis


def scaled(largest: float, unit: str) -> tuple[float, str]:
    """Factor and prefixed unit that bring ``largest`` between 1 and 1000: ``(1e-3, "kN")``."""
    if not (math.isfinite(largest) and largest > 0.0):
        return 1.0, unit
    exponent = min(max(3 * math.floor(math.log10(largest * 1.0000001) / 3), -12), 9)
    prefix = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[exponent]
    return 10.0**-exponent, prefix + unit


def axis_label(name: str, attrs: dict[str, Any] | None = None, largest: float | None = None) -> str:
    """Label of a parameter or a variable with its unit: ``initial gap Δh [m]``.

    A long name that does not fit beside an axis is replaced by the name. With ``largest``, the unit is that of
    :func:`axis_scale`.
    """
    long_name = str((attrs or {}).get("long_name", name))
    label = QUANTITIES.get(name, (long_name if len(long_name) <= MAX_LABEL else name.replace("_", " "), ""))[
        0
    ]
    unit = _unit(name, attrs)
    if largest is not None:
        unit = axis_scale(name, attrs, largest)[1]
    return label if unit in ("", "1") else f"{label} [{unit}]"


def axis_scale(name: str, attrs: dict[str, Any] | None, largest: float) -> tuple[float, str]:
    """Factor and prefixed unit for values up to ``largest``: metres as mm, seconds as µs.

    Only lengths, times and pressures take a prefix.
    """
    unit = _unit(name, attrs)
    return scaled(largest, unit) if unit in PREFIXED else (1.0, unit)


def _unit(name: str, attrs: dict[str, Any] | None) -> str:
    unit = str((attrs or {}).get("units", QUANTITIES.get(name, ("", ""))[1]))
    return re.sub(r"(?<=[a-z])([23])$", lambda m: {"2": "²", "3": "³"}[m[1]], unit)
