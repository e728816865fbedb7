"""Published approximations of the coefficient of restitution, to compare with the exact one of a contact.

``Contact.restitution`` uses none of them: it solves the collision itself to rounding.
"""

from __future__ import annotations

import math
from typing import overload

from .. import _core
from ..support import validation
from .contact import Floats, Values


def usual_damping(restitution: float, stiffness: float, effective_mass: float) -> float:
    """Damping γ [N s/m] of a linear dashpot by the formula in common use, γ = 2ζ√(k m_eff), ζ = −ln ε/√(π² + ln² ε).

    The formula follows from a contact that ends when the bodies part, after a phase of attraction. A force that
    is never attractive lets go earlier, and the restitution comes out larger than asked for: that of
    ``LinearDashpot(stiffness=…, damping=usual_damping(…))`` is 0.5503 where 0.5 was asked for.

    Parameters
    ----------
    restitution : float
        Coefficient of restitution ε that is asked for, in (0, 1].
    stiffness : float [N/m]
    effective_mass : float [kg]
        m_i m_j/(m_i + m_j), as ``Contact.effective_mass``.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    Source: for instance Schäfer, Dippel & Wolf, J. Phys. I France 6, 5 (1996); why it fails for a force that is
    never attractive: Schwager & Pöschel, Granular Matter 9, 465 (2007).

    Examples
    --------
    >>> ball = hl.Ball(0.01, density=2500.0)
    >>> damping = hl.usual_damping(0.5, stiffness=1e6, effective_mass=ball.mass)
    >>> law = hl.LinearDashpot(stiffness=1e6, damping=damping)
    >>> round(law.between(ball).restitution(), 4)
    0.5503
    """
    asked = validation.number("restitution", restitution, 0.0, 1.0, highest_allowed=True)
    k = validation.number("stiffness", stiffness, 0.0)
    mass = validation.number("effective_mass", effective_mass, 0.0)
    logarithm = abs(math.log(asked))
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
        (3/2) A (ρ/m_eff)^{2/5} v^{1/5}, at least 0, with A = ``Contact.dissipative_time``,
        ρ = ``Contact.elastic_prefactor``, m_eff = ``Contact.effective_mass`` and the speed of impact v.
    terms : int
        How many terms, 1 … 10; h_1 = h_3 = 0 count.

    Returns
    -------
    float or array
        Same shape as ``x``. The series is asymptotic in practice: with all terms the error is 3e-6 at x = 0.1 and
        grows beyond x = 0.6, where ε soon leaves (0, 1] and more terms make it worse.

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
    count = validation.whole("terms", terms, 1, _core.series_terms)
    at = _argument(x)
    return _shaped(_core.viscoelastic_series(at.ravel(), count), at.shape)


@overload
def restitution_pade(x: float, numerator: int = ..., denominator: int = ...) -> float: ...
@overload
def restitution_pade(x: Values, numerator: int = ..., denominator: int = ...) -> Floats: ...
def restitution_pade(x: float | Values, numerator: int = 3, denominator: int = 6) -> float | Floats:
    """ε of viscoelastic spheres by a Padé form in √x, which has the right limits at small and at large x.

    Parameters
    ----------
    x : float or array
        (3/2) A (ρ/m_eff)^{2/5} v^{1/5}, at least 0, as for ``restitution_series``.
    numerator, denominator : int
        Degrees of the polynomials in √x, at most 9 together and at most 6 below. In use are [1/4], off by up to
        9e-3, and [3/6], by up to 7e-4. Others may have poles.

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

    Examples
    --------
    >>> law = hl.Viscoelastic(
    ...     youngs_modulus=7e10, poisson_ratio=0.3, restitution=0.8, impact_speed=1.0
    ... )
    >>> c = law.between(hl.Ball(0.01, density=2500.0))
    >>> a, rho = c.dissipative_time, c.elastic_prefactor
    >>> x = 1.5 * a * (rho / c.effective_mass) ** 0.4 * 10.0**0.2  # at 10 m/s
    >>> round(hl.restitution_pade(x), 4), round(c.restitution(10.0), 4)
    (0.7086, 0.7085)
    """
    most = _core.series_terms - 1
    above = validation.whole("numerator", numerator, 0, most)
    below = validation.whole("denominator", denominator, 0, min(6, most - above))
    at = _argument(x)
    return _shaped(_core.viscoelastic_pade(at.ravel(), above, below), at.shape)


def _argument(x: float | Values) -> Floats:
    return validation.array("x", x, lowest=0.0, lowest_allowed=True, ndim=None, empty_allowed=True)


def _shaped(flat: Floats, shape: tuple[int, ...]) -> float | Floats:
    return float(flat[0]) if shape == () else flat.reshape(shape)
