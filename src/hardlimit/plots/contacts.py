"""Plots of a contact: restitution over speed, tangential restitution over the angle, obtained over requested ε."""

from __future__ import annotations

from itertools import cycle
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..contact.contact import Contact
from ..support.formatting import digits
from .labels import scaled
from .style import COLUMN_WIDTH, PAGE_WIDTH, PALETTE, style

#: Smallest span of an axis of ε, so that a constant ε appears as a straight line.
LEAST_SPAN: Final = 0.1


def restitution_over_speed(contact: Contact, speeds: NDArray[np.float64]) -> Figure:
    """Coefficient of restitution and duration of one isolated contact over the impact speed [m/s]."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.6, 4.0))
        upper, lower = figure.subplots(2, 1, sharex=True)
        restitution = np.asarray(contact.restitution(speeds))
        upper.plot(speeds, restitution, color=PALETTE["blue"])
        upper.set_ylabel(r"coefficient of restitution $\varepsilon$")
        low, high = float(restitution.min()), float(restitution.max())
        margin = max(0.1 * (high - low), 0.5 * (LEAST_SPAN - (high - low)))
        upper.set_ylim(max(low - margin, 0.0), high + margin)
        duration = np.asarray(contact.duration(speeds))
        factor, unit = scaled(float(duration.max()), "s")
        lower.plot(speeds, duration * factor, color=PALETTE["vermillion"])
        lower.set_ylabel(f"duration [{unit}]")
        lower.set_ylim(0.0, 1.1 * float(duration.max()) * factor)
        lower.set_xscale("log")
        lower.set_xlim(speeds[0], speeds[-1])
        lower.set_xlabel("speed of impact [m/s]")
    return figure


def tangential_restitution(
    contact: Contact, angles: NDArray[np.float64], speeds: NDArray[np.float64]
) -> Figure:
    """β over the angle of impact [rad], one curve for each impact speed [m/s], beside that of surfaces that slide.

    Of a single speed, also the constant rule that acts alike in a gas, and where the surfaces stick and slide.
    """
    degrees = np.degrees(angles)
    with style():
        figure = Figure(figsize=(PAGE_WIDTH * 0.6, 3.6))
        ax = figure.subplots()
        for speed, colour in zip(speeds.tolist(), cycle(PALETTE.values()), strict=False):
            label = "this contact" if len(speeds) == 1 else f"{digits(speed)} m/s"
            ax.plot(
                degrees, contact.tangential_restitution(angles, speed), color=colour, label=label, zorder=3
            )
        speed = float(speeds[0])
        sliding = _sliding(contact, angles, speed)
        if len(speeds) == 1:
            rule = np.minimum(contact.effective_tangential_restitution(speed), sliding)
            ax.plot(
                degrees,
                rule,
                ls=(0, (5, 2)),
                color=PALETTE["vermillion"],
                label="constant rule, alike in a gas",
            )
            _draw_border(ax, contact.sticks_below(speed), "sticks below ", "right")
            _draw_border(ax, contact.slides_beyond(speed), " slides beyond", "left")
        ax.plot(
            degrees,
            np.where(sliding <= 1.05, sliding, np.nan),
            ls=":",
            color="0.3",
            label="sliding throughout",
        )
        ax.set_xlabel(r"angle of impact $\gamma$ [°]")
        ax.set_ylabel(r"tangential restitution $\beta$")
        ax.set_xlim(degrees[0], degrees[-1])
        ax.set_ylim(-1.05, 1.05)
        ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, columnspacing=1.5)
    return figure


def _draw_border(ax: Axes, border: float, name: str, side: str) -> None:
    """A line at an angle [rad], with its name on one side."""
    if 0.0 < border < 0.5 * np.pi:
        ax.axvline(np.degrees(border), color="0.8", lw=0.8, zorder=0)
        ax.text(np.degrees(border), -1.0, name, fontsize="small", ha=side, color="0.4", clip_on=True)


def _sliding(contact: Contact, angles: NDArray[np.float64], speed: float) -> NDArray[np.float64]:
    """β of surfaces that slide throughout, −1 + (m_n/m_t) μ (1 + ε)/tan γ."""
    assert contact.law.friction is not None
    share = contact.effective_mass / contact.tangential_mass * (1.0 + contact.restitution(speed))
    with np.errstate(divide="ignore"):
        return np.asarray(-1.0 + share * contact.law.friction.coefficient / np.tan(angles))


def restitution_obtained(requested: NDArray[np.float64], curves: dict[str, NDArray[np.float64]]) -> Figure:
    """Obtained over requested restitution, one curve for each way to choose the damping."""
    with style():
        figure = Figure(figsize=(COLUMN_WIDTH * 1.15, COLUMN_WIDTH * 1.05))
        ax = figure.subplots()
        for (name, obtained), line in zip(curves.items(), ("-", (0, (5, 2)), (0, (1, 1.2))), strict=False):
            ax.plot(requested, obtained, ls=line, label=name)
        ax.set_xlabel(r"$\varepsilon$ requested")
        ax.set_ylabel(r"$\varepsilon$ obtained")
        ax.set_xlim(0.0, 1.0)
        ax.set_ylim(0.0, 1.02)
        ax.legend(loc="lower right")
    return figure
