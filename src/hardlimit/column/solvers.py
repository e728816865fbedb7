"""The three models of one column."""

from __future__ import annotations

from typing import Any, Final, Literal, get_args

from ..support import validation
from .models import ADIABATIC, INDEPENDENT, NEWTON, Model
from .result import Result
from .scenario import Column

Method = Literal["auto", "exact", "general"]
METHODS: Final = get_args(Method)
AUTO: Final = "auto"

#: Local error of the general solver, in units of the impact.
TOLERANCE: Final = 1e-14


def newton(
    column: Column, until: float | None = None, *, method: Method = AUTO, tolerance: float = TOLERANCE
) -> Result:
    """Newton's equations (Eq. 14): exact where the law allows, else integrated with every switch located.

    Parameters
    ----------
    column : Column
    until : float [s], optional
        Go on to this time after the first floor touch and record every contact up to it; not before release.
    method : {"auto", "exact", "general"}
        ``"exact"``: piecewise closed form, two balls on a floor under the linear law. ``"general"``: adaptive
        Runge–Kutta method of order 8, and an implicit one of order 9 (Radau IIA) for up to 16 balls while they creep.
        ``"auto"`` takes the exact one where it applies.
    tolerance : float
        Local error of the general solver, in units of the impact, 1e-15 to 1e-2.

    Returns
    -------
    Result

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
    if method is not AUTO:  # a default needs no check: a solve takes microseconds
        general = _is_general(method, general)
    if tolerance is not TOLERANCE:
        tolerance = validation.number(
            "tolerance", tolerance, 1e-15, 1e-2, lowest_allowed=True, highest_allowed=True
        )
    words = "order-8 Runge–Kutta, switches located" if general else "piecewise exact"
    return Result._solved(column, NEWTON, words, end, (general, tolerance))


def adiabatic(column: Column, until: float | None = None) -> Result:
    """Appendix A: the upper ball does not act on the lower one. Two balls on a floor, linear law.

    Exact for R1 ≫ R2; the error falls as the mass ratio m2/m1.

    Parameters
    ----------
    column : Column
    until : float [s], optional
        As for :func:`newton`.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If the column is not two balls on a floor under the linear law, or ``until`` lies before release or is not
        finite.

    Examples
    --------
    >>> drop = hl.Column.paper(radius_ratio=10)
    >>> both = hl.adiabatic(drop), hl.newton(drop)
    >>> [round(result.relative_velocity, 4) for result in both]
    [0.1711, 0.1717]
    """
    end = _checked(ADIABATIC, column, until)
    return Result._solved(column, ADIABATIC, "piecewise exact, lower ball unaffected", end)


def independent(column: Column, until: float | None = None) -> Result:
    """Independent-collisions model (Eqs. 1–6): instantaneous collisions, the whole event-driven sequence.

    Each contact has the restitution of its law at the speed of the collision; ``begin`` and ``end`` of a contact
    coincide.

    Parameters
    ----------
    column : Column
    until : float [s], optional
        As for :func:`newton`.

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If ``column`` is not a Column, or ``until`` lies before release or is not finite.

    Examples
    --------
    >>> drop = hl.independent(hl.Column.paper(restitution=0.7))
    >>> round(drop.relative_velocity, 3), round(drop.effective_restitution, 3)
    (3.727, 0.7)
    """
    end = _checked(INDEPENDENT, column, until)
    return Result._solved(column, INDEPENDENT, "event-driven", end)


def _is_general(method: Any, only: bool) -> bool:
    """Whether ``method`` means the general solver, which is the ``only`` one where no exact one applies."""
    validation.one_of("method", method, METHODS)
    if method == "exact" and only:
        raise ValueError(
            "method: got 'exact', must be auto or general unless two balls fall on a floor, linear law"
        )
    return method == "general" or only


def _checked(model: Model, column: Any, until: Any) -> float | None:
    """The time to solve to, once the model is known to apply to the column."""
    if not isinstance(column, Column):
        raise ValueError(f"column: got {validation.shown(column)}, must be a Column")
    if not model.applies(column):
        raise ValueError(f"column: the {model.name} model is that of {model.needs}")
    if until is None:
        return None
    end, first = validation.number("until", until), column.release_time
    if end < first:
        raise ValueError(f"until: got {end:.16g}, must be >= {validation.at_least(first)}, the release")
    return end
