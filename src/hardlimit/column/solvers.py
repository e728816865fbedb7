"""The three models of one column."""

from __future__ import annotations

import math
from typing import Literal

from .. import _core, validation
from .result import Result
from .scenario import Column

Method = Literal["auto", "exact", "general"]


def newton(
    column: Column, until: float | None = None, *, method: Method = "auto", tolerance: float = 1e-14
) -> Result:
    """Newton's equations (Eq. 14): exact where the law allows, else integrated with every switch located.

    Parameters
    ----------
    column : Column
    until : float [s], optional
        Go on to this time after the first floor touch and record every contact up to it.
    method : {"auto", "exact", "general"}
        ``"exact"``: piecewise closed form, two balls on a floor under the linear law. ``"general"``: adaptive
        Runge–Kutta method of order 8. ``"auto"`` takes the exact one where it applies.
    tolerance : float
        Local error of the general solver, in units of the impact.

    Raises
    ------
    ValueError
        If ``until`` is not finite, or ``method="exact"`` does not apply.
    """
    core = _checked(column)
    exact = column.floor and len(column.balls) == 2 and column.laws[0].record["name"] == "linear"
    if method not in ("auto", "exact", "general"):
        raise ValueError(f"method: got {method!r}, must be auto, exact or general")
    if method == "exact" and not exact:
        raise ValueError(
            "method: got 'exact', must be auto or general unless two balls fall on a floor, linear law"
        )
    if tolerance != 1e-14:
        tolerance = validation.number(
            "tolerance", tolerance, 1e-15, 1e-2, lowest_allowed=True, highest_allowed=True
        )
    general = method == "general" or not exact
    words = "order-8 Runge–Kutta, switches located" if general else "piecewise exact"
    return Result(column, "newton", words, lambda t: _core.newton(core, t, general, tolerance), _time(until))


def adiabatic(column: Column, until: float | None = None) -> Result:
    """Appendix A: the upper ball does not act on the lower one. Two balls on a floor, linear law.

    Exact for R1 ≫ R2; the error falls as the mass ratio m2/m1.

    Raises
    ------
    ValueError
        If the column is not two balls on a floor under the linear law.
    """
    core = _checked(column)
    return Result(
        column,
        "adiabatic",
        "piecewise exact, lower ball unaffected",
        lambda t: _core.adiabatic(core, t),
        _time(until),
    )


def independent(column: Column, until: float | None = None) -> Result:
    """Independent-collisions model (Eqs. 1–6): instantaneous collisions, the whole event-driven sequence.

    Each contact has the restitution of its law at the speed of the collision. A collision's ``begin`` and ``end``
    coincide.
    """
    core = _checked(column)
    return Result(column, "independent", "event-driven", lambda t: _core.independent(core, t), _time(until))


def _checked(column: Column) -> _core.Column:
    if not isinstance(column, Column):
        raise ValueError(f"column: got {column!r}, must be a Column")
    return column.core


def _time(until: float | None) -> float | None:
    if until is None:
        return None
    value = validation.number("until", until)
    return value if not math.isnan(value) else None
