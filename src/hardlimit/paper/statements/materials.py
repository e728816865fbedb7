"""Apps. B and C: viscoelastic spheres, and one material for both contacts (Figs. 7 and 8)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ...contact.balls import FLOOR
from ...contact.laws import LAWS
from ..data import Data
from ..sampling import late_contacts, maxima
from ..setup import INPUT_SPEED, POISSON_RATIO, YOUNGS_MODULUS_INSET
from .statement import Finding, Statements, near, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add("Viscoelastic spheres show the same structure", "App. B, Fig. 7", 7)
def _same_structure(data: Data) -> Finding:
    figure = data.figure(7)
    counts = figure["outline_n_contacts"].values
    late = late_contacts("restitution_outline", figure, "outline_")
    rises = counts.max() > counts[-1] and counts[0] < counts[-1]
    return Finding(
        f"{counts[-1]} contacts at ε = 1, up to {counts.max()}, {counts[0]} at ε = 0.1; {len(late)} "
        f"intervals of ε with a contact after the floor contact; {maxima(counts)} maxima over ε instead of "
        f"one",
        verdict(bool(rises), bool(late), maxima(counts) == 1),
    )


@STATEMENTS.add("Y = 6e9 N/m² matches the linear force at an overlap of (R1 + R2)/10", "App. B")
def _matched(data: Data) -> Finding:
    column = data.setup.linear()
    lower, upper = column.balls
    overlap = (lower.radius + upper.radius) / 10
    unit = LAWS["viscoelastic"](youngs_modulus=1.0, poisson_ratio=POISSON_RATIO, dissipative_time=0.0)
    linear = column.contacts[1].stiffness * overlap
    pair, floor = (
        linear / unit.between(*bodies).force(overlap) for bodies in ((upper, lower), (lower, FLOOR))
    )
    return Finding(
        f"Y = {pair:.3g} N/m² for the two balls, {floor:.3g} for ball and floor",
        verdict(near(pair, YOUNGS_MODULUS_INSET, 0.05e9)),
    )


@STATEMENTS.add(
    "In the geometry of Fig. 3 viscoelastic balls still touch several times", "App. B, Fig. 7 inset", 7
)
def _inset(data: Data) -> Finding:
    counts = data.figure(7)["inset_outline_n_contacts"].values
    return Finding(f"{counts[-1]} contacts at ε = 1, up to {counts.max()}", verdict(counts.max() > 1))


@STATEMENTS.add("The restitution of viscoelastic spheres depends on the speed", "App. B")
def _speed(data: Data) -> Finding:
    column = data.setup.viscoelastic(0.7)
    values = column.contacts[0].restitution(np.array([0.1, INPUT_SPEED, column.impact_speed]))
    return Finding(
        f"A set by ε = 0.7 at {INPUT_SPEED:g} m/s: {values[0]:.4f} at 0.1 m/s, {values[2]:.4f} at the "
        f"{column.impact_speed:.3f} m/s of the drop",
        verdict(values[0] > values[1] > values[2]),
    )


@STATEMENTS.add(
    "One material for both contacts gives the same structure, with minor differences in numbers",
    "App. C, Fig. 8",
    7,
    8,
)
def _one_material(data: Data) -> Finding:
    def features(number: int, name: str) -> tuple[NDArray[np.int64], int]:
        figure = data.figure(number)
        return figure["outline_n_contacts"].values, len(late_contacts(name, figure, "outline_"))

    (one, late_one), (both, late_both) = (
        features(7, "restitution_outline"),
        features(8, "dissipative_time_outline"),
    )
    path_one, path_both = (c[np.flatnonzero(np.diff(c, prepend=-1))] for c in (one[::-1], both))
    same_path = bool(np.array_equal(path_one, path_both))
    return Finding(
        f"Fig. 8: {', '.join(map(str, path_both))} contacts as A grows, Fig. 7 "
        f"{'the same' if same_path else ', '.join(map(str, path_one))}; late contacts in {late_both} "
        f"intervals (Fig. 7: {late_one})",
        verdict(both.max() > 1 and late_both > 0, abs(int(both.max()) - int(one.max())) <= 1),
    )


@STATEMENTS.add("One material means ε01 ≠ ε12", "App. C")
def _two_restitutions(data: Data) -> Finding:
    floor, pair = (float(c.restitution(INPUT_SPEED)) for c in data.setup.same_material(1e-5).contacts)
    return Finding(
        f"A = 10 µs: ε01 = {floor:.4f}, ε12 = {pair:.4f} at {INPUT_SPEED:g} m/s",
        verdict(not near(floor, pair, 1e-3)),
    )
