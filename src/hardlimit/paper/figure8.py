"""Fig. 8: begin and end of every contact over the dissipative time A, the same material for both contacts."""

from __future__ import annotations

from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from .drawing import MICRO, draw_sequence, sequence_axes, sequence_legend
from .sampling import Array, Counts, counts_of, late_contacts, refine, sequences, successive, variable
from .setup import INPUT_SPEED, Paper
from .statement import Outcome, Statements, near

TITLE: Final = "Sequence of contacts, one material"
CHOICES: Final = "The range of A, 0.1 to 100 µs (logarithmic, upside down as in Fig. 7), is chosen here."
WEIGHT: Final = 2.5
STATEMENTS: Final = Statements()

TIMES: Final = (1e-7, 1e-4)


def parameters(paper: Paper) -> dict[str, str | float]:
    return paper.parameters(paper.same_material(1e-6), "dissipative_time_s")


def compute(paper: Paper) -> xr.Dataset:
    """Rows at equal factors of A, fine outlines; the ε of both contacts at 3 m/s for orientation."""
    rows = np.geomspace(*TIMES, 91)
    count = counts_of(paper.same_material(1e-6), "dissipative_time")
    outline = refine(count, np.geomspace(*TIMES, 361), 1e-7, logarithmic=True)
    parts = [
        sequences("dissipative_time", rows, paper.same_material),
        sequences("dissipative_time_outline", outline, paper.same_material, prefix="outline_"),
    ]
    data = xr.merge(parts, join="exact")
    contacts = [paper.same_material(float(a)).contacts for a in rows]
    for i, name in enumerate(("floor", "balls")):
        epsilon = np.array([pair[i].restitution(INPUT_SPEED) for pair in contacts])
        text = f"restitution of the {name} contact at {INPUT_SPEED:g} m/s"
        data[f"restitution_{name}"] = variable("dissipative_time", epsilon, "1", text)
    data["input_speed"] = variable((), INPUT_SPEED, "m/s", "speed to which the ε belong")
    for name in ("dissipative_time", "dissipative_time_outline"):
        data[name].attrs.update(units="s", long_name="dissipative time A")
    return data


def meaning(data: xr.Dataset) -> str:
    n = int(data["outline_n_contacts"].max())
    return (
        f"One material for both contacts instead of one ε changes little: there are up to {n} contacts in one drop, "
        f"so event-driven simulation fails however the dissipation is specified."
    )


# --- drawing ------------------------------------------------------------------------------------------------


def draw(data: xr.Dataset) -> Figure:
    """The sequence, with the restitution of the ball–ball contact on the right axis."""
    figure, ax = sequence_axes(data)
    ax.set_yscale("log")
    a = data["dissipative_time"].values * MICRO
    scaled = data.assign_coords(
        dissipative_time=a, dissipative_time_outline=data["dissipative_time_outline"].values * MICRO
    )
    margin = (a[-1] / a[0]) ** 0.012
    ax.set_ylim(a[-1] * margin, a[0] / margin)
    ax.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    draw_sequence(ax, scaled, "dissipative_time", "", 1.3)
    ax.set_ylabel("dissipative time $A$ [µs]")
    ax.tick_params(axis="y", which="both", right=False)
    _add_restitution(ax, a, data)
    ax.legend(handles=sequence_legend(), loc="lower right", bbox_to_anchor=(0.97, 0.0))
    return figure


def _add_restitution(ax: Axes, a: Array, data: xr.Dataset) -> None:
    """A right axis with the ε of the ball–ball contact that belongs to A [µs]."""
    right = ax.twinx()
    right.set_yscale("log")
    right.set_ylim(ax.get_ylim())
    epsilon = data["restitution_balls"].values
    ticks = [e for e in (0.99, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2) if epsilon.min() < e < epsilon.max()]
    right.set_yticks(np.exp(np.interp(ticks, epsilon[::-1], np.log(a[::-1]))), [f"{e:g}" for e in ticks])
    right.minorticks_off()
    right.set_ylabel(rf"$\varepsilon_{{12}}$ at {float(data['input_speed']):g} m/s")


# --- statements ---------------------------------------------------------------------------------------------


@STATEMENTS.add(
    "One material for both contacts gives the same structure, with minor differences in numbers",
    "App. C, Fig. 8",
    7,
    8,
)
def _one_material(paper: Paper) -> Outcome:
    def features(number: int, name: str) -> tuple[Counts, int]:
        figure = paper.figure(number)
        return figure["outline_n_contacts"].values, len(late_contacts(name, figure, "outline_"))

    (single, late_one), (both, late_both) = (
        features(7, "restitution_outline"),
        features(8, "dissipative_time_outline"),
    )
    path_one, path_both = successive(single[::-1]), successive(both)
    same_path = bool(np.array_equal(path_one, path_both))
    text = (
        f"Fig. 8: {', '.join(map(str, path_both))} contacts as A grows, Fig. 7 "
        f"{'the same' if same_path else ', '.join(map(str, path_one))}; late contacts in {late_both} "
        f"intervals (Fig. 7: {late_one})"
    )
    return text, both.max() > 1 and late_both > 0, abs(int(both.max()) - int(single.max())) <= 1


@STATEMENTS.add("One material means ε01 ≠ ε12", "App. C")
def _two_restitutions(paper: Paper) -> Outcome:
    floor, pair = (float(c.restitution(INPUT_SPEED)) for c in paper.same_material(1e-5).contacts)
    text = f"A = 10 µs: ε01 = {floor:.4f}, ε12 = {pair:.4f} at {INPUT_SPEED:g} m/s"
    return text, not near(floor, pair, 1e-3)
