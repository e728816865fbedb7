"""Explicit Runge-Kutta steps for numba, unrolled: no arrays, no loops, no zero weights."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numba
import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop853

#: All fast-math flags except those that assume that there are no NaNs and no infinities.
FAST = {"reassoc", "contract", "arcp", "nsz", "afn"}
jit = numba.njit(error_model="numpy")

RK4 = (np.array([[0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1, 0]]), np.array([1, 2, 2, 1]) / 6)
TABLEAUX = {"RK4": RK4, "DOP853": (dop853.A[:12, :12], dop853.B)}


def unrolled(tableau: tuple[np.ndarray, np.ndarray], names: Sequence[str], slopes: Callable) -> Callable:
    """A compiled ``step(h, state…, slopes…, parameters…)`` of an autonomous system.

    ``slopes(state…, parameters…)`` gives the derivatives. The caller passes those at the start of the step.
    """
    a, b = tableau
    code = getattr(slopes, "py_func", slopes).__code__
    parameters = ", ".join(code.co_varnames[len(names) : code.co_argcount])
    first = [f"{n}_0" for n in names]
    lines = [f"def step(h, {', '.join(names)}, {', '.join(first)}, {parameters}):"]
    for i in range(1, len(b)):
        at = ", ".join(f"{n} + h * ({_sum(a[i], n)})" for n in names)
        lines.append(f"    {', '.join(f'{n}_{i}' for n in names)} = slopes({at}, {parameters})")
    lines.append(f"    return {', '.join(f'{n} + h * ({_sum(b, n)})' for n in names)}")
    space = {"slopes": slopes}
    exec("\n".join(lines), space)
    return numba.njit(space["step"], fastmath=FAST, error_model="numpy")


def _sum(weights: np.ndarray, name: str) -> str:
    return " + ".join(f"{float(w)!r} * {name}_{j}" for j, w in enumerate(weights) if w != 0.0)


def over_rows(solve: Callable) -> Callable:
    """A compiled loop of ``solve(row, fraction)``, which returns four numbers, over rows."""

    @jit
    def solve_all(rows, fraction):
        out = np.empty((len(rows), 4))
        for i in range(len(rows)):
            out[i, 0], out[i, 1], out[i, 2], out[i, 3] = solve(rows[i], fraction)
        return out

    return solve_all
