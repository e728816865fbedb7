"""Sec. IV A and App. A: how good the adiabatic solution is."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ...column.solvers import adiabatic, newton
from ...sweep import sweep
from ..data import Data
from .statement import Finding, Statements, verdict

STATEMENTS: Final = Statements()


@STATEMENTS.add(
    "The adiabatic solution agrees perfectly with the numerical one at R1/R2 = 10", "Sec. IV A, Fig. 3", 3
)
def _adiabatic(data: Data) -> Finding:
    grid = np.linspace(0.1, 1.0, 1801)
    both = [
        sweep(data.setup.linear(), model=model, restitution=grid, variables=["n_contacts"])[
            "n_contacts"
        ].values
        for model in ("newton", "adiabatic")
    ]
    same = float(np.mean(both[0] == both[1]))
    worst = 0.0
    for epsilon in grid[both[0] == both[1]][::20]:
        column = data.setup.linear(float(epsilon))
        exact = newton(column)
        pair = exact.contacts["pair"].values == 1
        begin = exact.contacts["begin"].values[pair]
        early = begin < exact.t_floor_end  # late contacts drift apart without limit near the tip of a spike
        other = adiabatic(column).contacts
        mine = other["pair"].values == 1
        for name in ("begin", "end"):
            deviation = np.abs(exact.contacts[name].values[pair] - other[name].values[mine])[early]
            worst = max(worst, float(deviation.max(initial=0.0)) / exact.t_floor_end)
    tips = data.figure(3)
    shift = (
        float(np.abs(tips["spike"].values[0] - tips["adiabatic_spike"].values[0]))
        if tips.sizes["spike"]
        else 0.0
    )
    return Finding(
        f"equal counts for {100 * same:.1f} % of the ε from 0.1 to 1; contacts that begin during the floor "
        f"contact within {100 * worst:.2f} % of its duration; first spike shifted by {shift:.4f} in ε",
        verdict(worst < 0.01, same > 0.999),
    )


@STATEMENTS.add("The adiabatic solution becomes exact for R1 ≫ R2", "App. A")
def _order(data: Data) -> Finding:
    errors, masses = [], []
    for upper in (0.01, 0.005, 0.0025):
        column = data.setup.linear(0.7, radius_2=upper)
        parted = []
        for solve in (newton, adiabatic):
            result = solve(column)
            after = result.trajectory(result.contacts["end"].values[1])["velocity"].values[0]
            parted.append(after[1] - after[0])
        errors.append(abs(parted[0] - parted[1]) / column.impact_speed)
        masses.append(column.balls[1].mass / column.balls[0].mass)
    order = math.log(errors[0] / errors[-1]) / math.log(masses[0] / masses[-1])
    return Finding(
        f"v2 − v1 after the first contact off by {errors[0]:.1e}, {errors[1]:.1e}, {errors[2]:.1e} V at "
        f"R1/R2 = 10, 20, 40: ∝ (m2/m1)^{order:.2f}",
        verdict(errors[0] > errors[1] > errors[2]),
    )
