"""``hl.fit``: fit a contact law to measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from ..contact.balls import FLOOR, Ball, Floor
from ..contact.contact import Law
from ..support import validation
from ..support.progress import Report, reporter
from .candidates import candidate, rivals
from .likelihood import minimum
from .measurements import Measured
from .result import Fit, Trial

__all__ = ["fit"]


def fit(
    data: Measured,
    law: str | type[Law] = "viscoelastic",
    *,
    fixed: Mapping[str, float] | None = None,
    free: Sequence[str] | None = None,
    ball: Ball | None = None,
    other: Ball | Floor = FLOOR,
    scatter: bool = False,
    confidence: float = 0.68,
    compare: bool = True,
    progress: bool | Report | None = None,
) -> Fit:
    """Fit a contact law to measured impacts or rebounds, and test whether it describes them.

    Parameters
    ----------
    data : Impacts or Rebounds
        From a class method of ``hardlimit.Impacts`` or ``hardlimit.Rebounds``, or from
        ``hardlimit.read_measurements``.
    law : str or Law class
        A name of ``hardlimit.LAWS``, or the class.
    fixed : mapping, optional
        Known parameters by name, in SI units.
    free : sequence of str, optional
        Parameters to fit. Impacts determine only ε(v): by default ``restitution`` is fitted, at the speed
        ``impact_speed`` if it depends on speed; with Young's modulus and Poisson's ratio in ``fixed``, the dissipative
        parameter. Rebounds determine the stiffness as well. ``Fit.notes`` gives the values of all other parameters.
    ball : Ball, optional
        The ball of the impacts; needed if more than ε is fitted.
    other : Ball or FLOOR
        The other body of the contact.
    scatter : bool
        Fit the scatter of ε (or of the rebound) between impacts, beyond the errors of the measurement, as a normal
        distribution of one width. The law then describes the mean, and χ² is no test.
    confidence : float
        Confidence level of the intervals, in [0.001, 0.999999]; they come from the profile likelihood.
    compare : bool
        Fit the other laws too, and for rebounds independent collisions with one ε.
    progress : bool or callable(done, total), optional
        True shows a bar. A function is called with the number of fitted laws and their total.

    Raises
    ------
    ValueError
        If an argument is outside its range, the data have no errors and ``scatter`` is False, there are fewer values
        than parameters, or the data do not determine the parameters; names them.

    Notes
    -----
    The likelihood is that of normal errors, with the covariance of speeds and coefficients of restitution that share a
    reading. Maximum and profile are found by MINUIT: James & Roos, Comput. Phys. Commun. 10, 343 (1975).

    Examples
    --------
    >>> steel = hl.Impacts.of_restitution(
    ...     [0.05, 0.5, 5.0], [0.965, 0.944, 0.912], 0.003
    ... )
    >>> found = hl.fit(steel, "viscoelastic")
    >>> print(found.parameters["restitution"], found.notes[-1], sep=", ")
    0.943666 ± 0.0016, restitution is that at 0.5 m/s (impact_speed)
    >>> print(found.verdict)
    viscoelastic describes the data: χ² = 0.1818 for 2 degrees of freedom, p = 0.91; one
    ε (linear, tsuji) does worse by 158 or more in AIC
    """
    if not isinstance(data, Measured):
        raise ValueError(f"data: got {validation.shown(data)}, must be Impacts or Rebounds")
    validation.flag("compare", compare)
    if not validation.flag("scatter", scatter) and not data.has_errors:
        raise ValueError("error: missing or 0 for some values, must be > 0 unless scatter=True")
    level = validation.number(
        "confidence", confidence, 0.001, 0.999999, lowest_allowed=True, highest_allowed=True
    )
    if ball is not None and not isinstance(ball, Ball):
        raise ValueError(f"ball: got {validation.shown(ball)}, must be a Ball")
    if not isinstance(other, Ball | Floor):
        raise ValueError(f"other: got {validation.shown(other)}, must be a Ball or FLOOR")
    constants = _mapping(fixed)
    chosen = candidate(
        law=law,
        kind=data.kind,
        reference_speed=data.reference_speed,
        fixed=constants,
        free=_names(free),
        ball=ball,
        other=other,
    )
    if data.n < len(chosen.free) + scatter:
        raise ValueError(f"data: got {data.n} values, must be {len(chosen.free) + scatter} or more")
    others = rivals(chosen, data.kind, data.reference_speed, constants) if compare else []
    others = [rival for rival in others if data.n >= len(rival.free) + scatter]
    with reporter(progress, "fit", "laws") as report:
        best = minimum(data, chosen, scatter, level)
        tried: list[Trial] = []
        for done, rival in enumerate(others, 1):
            report(done, 1 + len(others))
            with suppress(ValueError):  # the data do not determine its parameters
                tried.append(Trial(rival, minimum(data, rival, scatter, level)))
    return Fit(chosen, best, data, tuple(tried), level)


def _mapping(fixed: Any) -> dict[str, float]:
    if not isinstance(fixed, Mapping | None):
        raise ValueError(f"fixed: got {validation.shown(fixed)}, must be a mapping of names to values")
    return dict(fixed or {})


def _names(free: Any) -> list[str] | None:
    if free is None:
        return None
    if not isinstance(free, Sequence) or isinstance(free, str) or not all(isinstance(x, str) for x in free):
        raise ValueError(f"free: got {validation.shown(free)}, must be a list of names")
    return list(free)
