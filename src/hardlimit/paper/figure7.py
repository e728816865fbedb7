"""Fig. 7: begin and end of every contact over ε, viscoelastic spheres; inset with the geometry of Fig. 3."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..contact.balls import FLOOR
from ..contact.laws import LAWS
from ..plots.labels import QUANTITIES
from .caption import quantity, typeset
from .drawing import MILLI, draw_sequence, sequence_axes, sequence_legend
from .sampling import counts_of, late_contacts, maxima, refine, sequences, variable
from .setup import INPUT_SPEED, POISSON_RATIO, YOUNGS_MODULUS_INSET, Paper
from .statement import Outcome, Statements, near

TITLE: Final = "Sequence of contacts, viscoelastic spheres"
CHOICES: Final = (
    "ε sets A of each contact at v_in = 3 m/s, as in the paper. The ranges of ε and time are chosen here."
)
WEIGHT: Final = 3.0
STATEMENTS: Final = Statements()

LOWEST: Final = 0.1


def parameters(paper: Paper) -> dict[str, str | float]:
    fixed = paper.parameters(paper.viscoelastic(), "restitution")
    return fixed | {"column_inset": repr(paper.viscoelastic_inset())}


def compute(paper: Paper) -> xr.Dataset:
    """Rows at every 0.01 of ε and fine outlines; ``inset_`` variables belong to the inset."""
    rows = np.round(np.arange(LOWEST, 1.005, 0.01), 10)
    rows_inset = np.round(np.arange(LOWEST, 1.005, 0.02), 10)
    column, geometry = paper.viscoelastic(), paper.viscoelastic_inset()
    outline = refine(counts_of(column, "restitution"), np.linspace(LOWEST, 1.0, 361), 1e-7)
    inset = refine(counts_of(geometry, "restitution"), np.linspace(LOWEST, 1.0, 181), 1e-7)
    parts = [
        sequences("restitution", rows, paper.viscoelastic),
        sequences("restitution_outline", outline, paper.viscoelastic, prefix="outline_"),
        sequences("restitution_inset", rows_inset, paper.viscoelastic_inset, prefix="inset_"),
        sequences("restitution_inset_outline", inset, paper.viscoelastic_inset, prefix="inset_outline_"),
    ]
    data = xr.merge(parts, join="exact")
    data["input_speed"] = variable((), INPUT_SPEED, "m/s", "speed at which ε sets A")
    radius = geometry.balls[1].radius
    data["inset_radius_2"] = variable((), radius, "m", "radius of the upper ball in the inset")
    data["inset_youngs_modulus"] = variable((), YOUNGS_MODULUS_INSET, "N/m2", "Young's modulus in the inset")
    speed = column.impact_speed
    data["impact_speed"] = variable((), speed, "m/s", "speed at the floor in the drop")
    data.attrs["choices"] = f"{CHOICES} The drop itself meets the floor at {speed:.2f} m/s."
    return data


def meaning(data: xr.Dataset) -> str:
    n = int(data["outline_n_contacts"].max())
    return (
        f"A more realistic contact force does not make event-driven simulation valid: viscoelastic spheres have up to "
        f"{n} contacts in one drop, and an event-driven simulation has one."
    )


# --- drawing ------------------------------------------------------------------------------------------------


def draw(data: xr.Dataset) -> Figure:
    """The sequence with its inset."""
    figure, ax = sequence_axes(data)
    ax.set_ylim(float(data["restitution"].min()) - 0.012, 1.012)
    draw_sequence(ax, data, "restitution", "", 1.3)
    ax.set_ylabel(rf"{QUANTITIES['restitution'][0]} at {float(data['input_speed']):g} m/s")
    _draw_inset(ax, data)
    ax.legend(handles=sequence_legend(), loc="upper right", bbox_to_anchor=(1.0, 0.72))
    return figure


def _draw_inset(ax: Axes, data: xr.Dataset) -> None:
    inset = ax.inset_axes((0.62, 0.1, 0.355, 0.38))
    floor_end = float(data["inset_outline_t_floor_end"].max()) * MILLI
    inset.set_xlim(0.0, 2.0 * floor_end)
    inset.set_ylim(ax.get_ylim())
    draw_sequence(inset, data, "restitution_inset", "inset_", 0.9)
    radius, modulus = float(data["inset_radius_2"]), float(data["inset_youngs_modulus"])
    title = typeset(f"R2 = {quantity(radius, 'm')}, Y = {quantity(modulus, 'N/m²')}")
    inset.set_title(title, fontsize=8.5, pad=3)
    inset.set_xlabel("time [ms]", fontsize=8.5, labelpad=1)
    inset.set_ylabel(r"$\varepsilon$", fontsize=8.5, labelpad=1)
    inset.tick_params(labelsize=8)


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add("Viscoelastic spheres show the same structure", "App. B, Fig. 7", 7)
def _same_structure(paper: Paper) -> Outcome:
    figure = paper.figure(7)
    counts = figure["outline_n_contacts"].values
    late = late_contacts("restitution_outline", figure, "outline_")
    rises = counts.max() > counts[-1] and counts[0] < counts[-1]
    text = (
        f"{counts[-1]} contacts at ε = 1, up to {counts.max()}, {counts[0]} at ε = 0.1; {len(late)} "
        f"intervals of ε with a contact after the floor contact; {maxima(counts)} maxima over ε instead of "
        f"one"
    )
    return text, bool(rises), bool(late), maxima(counts) == 1


@STATEMENTS.add("Y = 6e9 N/m² matches the linear force at an overlap of (R1 + R2)/10", "App. B")
def _matched(paper: Paper) -> Outcome:
    column = paper.linear()
    lower, upper = column.balls
    overlap = (lower.radius + upper.radius) / 10
    unit = LAWS["viscoelastic"](youngs_modulus=1.0, poisson_ratio=POISSON_RATIO, dissipative_time=0.0)
    linear = column.contacts[1].stiffness * overlap
    pair, floor = (
        linear / unit.between(*bodies).force(overlap) for bodies in ((upper, lower), (lower, FLOOR))
    )
    text = f"Y = {pair:.3g} N/m² for the two balls, {floor:.3g} for ball and floor"
    return text, near(pair, YOUNGS_MODULUS_INSET, 0.05e9)


@STATEMENTS.add(
    "In the geometry of Fig. 3 viscoelastic balls still touch several times", "App. B, Fig. 7 inset", 7
)
def _inset(paper: Paper) -> Outcome:
    counts = paper.figure(7)["inset_outline_n_contacts"].values
    return (f"{counts[-1]} contacts at ε = 1, up to {counts.max()}", counts.max() > 1)


@STATEMENTS.add("The restitution of viscoelastic spheres depends on the speed", "App. B")
def _speed(paper: Paper) -> Outcome:
    column = paper.viscoelastic(0.7)
    values = column.contacts[0].restitution(np.array([0.1, INPUT_SPEED, column.impact_speed]))
    return (
        f"A set by ε = 0.7 at {INPUT_SPEED:g} m/s: {values[0]:.4f} at 0.1 m/s, {values[2]:.4f} at the "
        f"{column.impact_speed:.3f} m/s of the drop",
        values[0] > values[1] > values[2],
    )
