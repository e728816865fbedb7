"""The solvers of a column under its three models: ``newton``, ``adiabatic`` and ``independent``."""

from __future__ import annotations

from typing import Any, Final, Literal, get_args

from ..support import validation
from .models import ADIABATIC, INDEPENDENT, NEWTON, Model
from .result import Result
from .scenario import Column

Method = Literal["auto", "exact", "general"]
METHODS: Final = get_args(Method)
AUTO: Final = "auto"

#: Default local error of the general solver, relative to the impact.
TOLERANCE: Final = 1e-14


def newton(
    column: Column, until: float | None = None, *, method: Method = AUTO, tolerance: float = TOLERANCE
) -> Result:
    """Solve Newton's equations (Eq. 14), exactly if the law allows it, otherwise by integration with event location.

    Parameters
    ----------
    column : Column
    until : float [s], optional
        End time after the first floor touch, up to which every contact is recorded; not before the release.
    method : {"auto", "exact", "general"}
        ``"exact"``: piecewise closed form for two balls on a floor under the linear law. ``"general"``: adaptive
        Runge–Kutta method of order 8, and an implicit method of order 9 (Radau IIA) for creeping motion of up to 16
        balls. ``"auto"``: exact if it applies, otherwise general.
    tolerance : float
        Local error of the general solver, relative to the impact, 1e-15 to 1e-2.

    Raises
    ------
    ValueError
        If an argument is outside its range, or ``method="exact"`` does not apply.

    Notes
    -----
    Source: Eq. 14 of the paper, with the forces of its Eqs. 7 and B1. The integrators are those of Hairer, Nørsett &
    Wanner, Solving Ordinary Differential Equations I (1993), and Hairer & Wanner, II (1996).

    Examples
    --------
    >>> drop = hl.newton(hl.Column.paper())  # Fig. 2 of the paper
    >>> drop
    <Result of newton (piecewise exact): 4 ball–ball contacts, v'_r 0.171711 m/s, ok>
    >>> round(drop.restitution_ratio, 3)  # ε_eff over ε
    0.074
    """
    end = _checked(NEWTON, column, until)
    general = not column.solvable_exactly
    if method is not AUTO:  # the default is not checked: a solve takes microseconds
        general = _is_general(method, general)
    if tolerance is not TOLERANCE:
        both = {"lowest_allowed": True, "highest_allowed": True}
        tolerance = validation.number("tolerance", tolerance, 1e-15, 1e-2, **both)
    description = "order-8 Runge–Kutta, switches located" if general else "piecewise exact"
    return Result._solved(column, NEWTON, description, end, (general, tolerance))


def adiabatic(column: Column, until: float | None = None) -> Result:
    """Solve two balls on a floor under the linear law without the force of the upper ball on the lower (Appendix A).

    Exact for R1 ≫ R2; the error is proportional to the mass ratio m2/m1. Parameters as for :func:`newton`.

    Raises
    ------
    ValueError
        If the column is not two balls on a floor under the linear law, or ``until`` is outside its range.
    """
    end = _checked(ADIABATIC, column, until)
    return Result._solved(column, ADIABATIC, "piecewise exact, lower ball unaffected", end)


def independent(column: Column, until: float | None = None) -> Result:
    """Compute the sequence of instantaneous collisions (independent-collisions model, Eqs. 1–6).

    Each collision has the restitution of the law at its impact speed. ``begin`` and ``end`` of a contact coincide.
    Parameters and errors as for :func:`newton`.
    """
    end = _checked(INDEPENDENT, column, until)
    return Result._solved(column, INDEPENDENT, "event-driven", end)


def _is_general(method: Any, only: bool) -> bool:
    """Whether ``method`` selects the general solver; ``only`` is true if the exact one does not apply."""
    validation.one_of("method", method, METHODS)
    if method == "exact" and only:
        need = "must be auto or general except for two balls on a floor under the linear law"
        raise ValueError(f"method: got 'exact', {need}")
    return method == "general" or only


def _checked(model: Model, column: Any, until: Any) -> float | None:
    """Check column and model; returns the checked ``until``."""
    if not isinstance(column, Column):
        raise ValueError(f"column: got {validation.shown(column)}, must be a Column")
    if not model.applies(column):
        raise ValueError(f"column: the {model.name} model applies only to {model.needs}")
    if until is None:
        return None
    return validation.number("until", until)
