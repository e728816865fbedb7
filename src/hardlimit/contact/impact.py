"""One contact with friction and a fixed normal."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .friction import FrictionTerms


def tangential_restitution(
    powers: tuple[int, int, bool],
    stiffness: float,
    damping: float,
    effective_mass: float,
    terms: FrictionTerms,
    tangential_mass: float,
    speed: float,
    tangential_speed: ArrayLike,
) -> NDArray[np.float64]:
    """Coefficients of tangential restitution β of a contact under F = K ξ^p + C ξ^q dξ/dt with a fixed normal.

    Parameters
    ----------
    powers : (int, int, bool)
        4p, 4q, and whether the normal force may attract; otherwise it is cut off at zero. |F| limits friction.
    stiffness, damping : float
        K > 0 [N/m^p] and C ≥ 0 [N s/m^(1 + q)].
    effective_mass, tangential_mass : float [kg]
        m_n and m_t.
    terms : FrictionTerms
    speed : float [m/s]
        Normal impact speed, > 0.
    tangential_speed : array [m/s]
        Slip velocities at touch; at 0 the limit of small ones.

    Returns
    -------
    array
        g_t' = −β g_t, same shape as ``tangential_speed``. NaN where the contact has too many changes of stick and slip.
    """
    slip = np.asarray(tangential_speed, np.float64)
    values = _core.tangential_restitution(
        powers, (stiffness, damping), effective_mass, tangential_mass, tuple(terms), speed, slip.ravel()
    )
    return values.reshape(slip.shape)
