"""Published approximations of the coefficient of restitution, for comparison.

``Contact.restitution`` uses none of them; it solves the collision to rounding error.
"""

from __future__ import annotations

import math
from typing import overload

import numpy as np

from .. import _core
from ..support import validation
from .contact import Floats, Values, shaped


def usual_damping(restitution: float, stiffness: float, effective_mass: float) -> float:
    """Damping γ [N s/m] of a linear dashpot by the formula in common use, γ = 2ζ√(k m_eff), ζ = −ln ε/√(π² + ln² ε).

    The formula assumes that a contact ends when the gap opens, after a phase of attraction. A contact without
    attraction ends earlier, and its restitution is larger than requested.

    Parameters
    ----------
    restitution : float
        Requested coefficient of restitution ε, in (0, 1].
    stiffness : float [N/m]
    effective_mass : float [kg]
        m_i m_j/(m_i + m_j), as ``Contact.effective_mass``.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Source: for instance Schäfer, Dippel & Wolf, J. Phys. I France 6, 5 (1996). Schwager & Pöschel, Granular Matter 9,
    465 (2007) explain why it fails for a force that is never attractive.

    Examples
    --------
    >>> ball = hl.Ball(0.01, density=2500.0)
    >>> damping = hl.usual_damping(0.5, stiffness=1e6, effective_mass=ball.mass)
    >>> law = hl.LinearDashpot(stiffness=1e6, damping=damping)
    >>> round(law.between(ball).restitution(), 4)
    0.5503
    """
    requested = validation.number("restitution", restitution, 0.0, 1.0, highest_allowed=True)
    k = validation.number("stiffness", stiffness, 0.0)
    mass = validation.number("effective_mass", effective_mass, 0.0)
    logarithm = abs(math.log(requested))
    return 2.0 * logarithm / math.hypot(math.pi, logarithm) * math.sqrt(k * mass)


@overload
def restitution_series(x: float, terms: int = ...) -> float: ...
@overload
def restitution_series(x: Values, terms: int = ...) -> Floats: ...
def restitution_series(x: float | Values, terms: int = 10) -> float | Floats:
    """ε of viscoelastic spheres by its power series Σ h_k x^{k/2}, k = 0 … terms − 1 (Eq. B3).

    Parameters
    ----------
    x : float or array
        (3/2) A (ρ/m_eff)^{2/5} v^{1/5}, from 0 to 1e60, with A = ``Contact.dissipative_time``,
        ρ = ``Contact.elastic_prefactor``, m_eff = ``Contact.effective_mass`` and the impact speed v.
    terms : int
        Number of terms, 1 … 10, including h_1 = h_3 = 0.

    Returns
    -------
    float or array
        Same shape as ``x``. The series is asymptotic in practice: with all terms the error is 3e-6 at x = 0.1. It is
        large beyond x = 0.6, where ε soon leaves (0, 1] and more terms increase the error.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Source: Schwager & Pöschel, Phys. Rev. E 78, 051304 (2008), coefficients to more digits.

    Examples
    --------
    >>> hl.restitution_series([0.1, 0.5, 1.0]).round(4)  # the last is wrong
    array([0.8929, 0.6056, 0.7283])
    >>> hl.restitution_pade([0.1, 0.5, 1.0]).round(4)
    array([0.8929, 0.5953, 0.394 ])
    """
    count = validation.whole("terms", terms, 1, len(_core.series_coefficients))
    at = _argument(x)
    series = np.polynomial.Polynomial(_core.series_coefficients[:count])
    return shaped(series(np.sqrt(at.ravel())), at.shape)


@overload
def restitution_pade(x: float, numerator: int = ..., denominator: int = ...) -> float: ...
@overload
def restitution_pade(x: Values, numerator: int = ..., denominator: int = ...) -> Floats: ...
def restitution_pade(x: float | Values, numerator: int = 3, denominator: int = 6) -> float | Floats:
    """ε of viscoelastic spheres by a Padé form in √x, which has the right limits at small and at large x.

    ``x`` is that of :func:`restitution_series`.

    Parameters
    ----------
    numerator, denominator : int
        Degrees of the polynomials in √x; their sum is at most 9, and ``denominator`` at most 6. Published are [1/4],
        with errors up to 9e-3, and [3/6], with errors up to 7e-4. Others may have poles.

    Returns
    -------
    float or array
        Same shape as ``x``.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Source: Müller & Pöschel, Phys. Rev. E 84, 021302 (2011). The form is computed from the series.
    """
    from scipy.interpolate import pade

    most = len(_core.series_coefficients) - 1
    above = validation.whole("numerator", numerator, 0, most)
    below = validation.whole("denominator", denominator, 0, min(6, most - above))
    at = _argument(x)
    top, bottom = pade(_core.series_coefficients[: above + below + 1], below, above)
    y = np.sqrt(at.ravel())
    return shaped(top(y) / bottom(y), at.shape)


def _argument(x: float | Values) -> Floats:
    # Beyond this limit a power of x overflows.
    return validation.array(
        "x",
        x,
        lowest=0.0,
        lowest_allowed=True,
        highest=1e60,
        highest_allowed=True,
        ndim=None,
        empty_allowed=True,
    )
