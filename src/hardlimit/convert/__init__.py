"""Convert a restitution into damping, time step and input of particle codes.

The function imports its modules when called, which keeps ``import hardlimit`` fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..contact.balls import Ball

if TYPE_CHECKING:
    from .conversion import Conversion

__all__ = ["convert"]


def convert(
    balls: Ball | Sequence[Ball],
    *,
    restitution: float,
    speed: float = 1.0,
    stiffness: float | None = None,
    youngs_modulus: float | None = None,
    poisson_ratio: float | None = None,
    duration: float | None = None,
    compression: float | None = None,
    law: str | None = None,
    wall: bool = True,
    code: str | None = None,
    model: str | None = None,
    attraction: bool = False,
    friction: float | None = None,
    tangential_restitution: float | None = None,
    restitution_error: float | None = None,
    time_step: float | None = None,
) -> Conversion:
    """Convert a coefficient of restitution into damping, time step and input of particle codes, for all pairs of sizes.

    Parameters
    ----------
    balls : Ball or sequence of Ball
        The sizes in a bed, at most 30. There is a contact for every pair of sizes, and for each size with a wall.
    restitution : float
        Wanted coefficient of restitution ε, in [0.001, 1].
    speed : float [m/s]
        Impact speed at which it is wanted.
    stiffness : float [N/m]
        Stiffness of a linear spring. Give exactly one of ``stiffness``, ``youngs_modulus``, ``duration`` and
        ``compression``.
    youngs_modulus : float [Pa]
        Young's modulus of the material of balls and wall. Under the linear law, an undamped impact at ``speed``
        compresses the spring as far as the Hertz contact.
    poisson_ratio : float
        Poisson's ratio of this material, to be given with ``youngs_modulus``; in (-1, 0.5].
    duration : float [s]
        Duration of each contact.
    compression : float [m]
        Largest compression in each contact.
    law : str
        "linear", "tsuji" (Hertz, with a restitution independent of the speed) or "viscoelastic". The default is "tsuji"
        with a modulus, else "linear".
    wall : bool
        Whether to include contacts with a wall.
    code : str
        Name of a code; all by default.
    model : str
        Name of one of the code's models; by default all models of this law.
    attraction : bool
        Whether the force attracts at the end of a contact, for codes with this option.
    friction : float
        Coefficient of friction μ, > 0; grains are smooth unless it is given.
    tangential_restitution : float
        Wanted coefficient of tangential restitution β0 in a gas, in (-1, 1], to be given with ``friction``. A gas of
        these grains exchanges as much energy between translation and rotation as one whose sticking contacts have β0.
    restitution_error : float
        Error of ε allowed for the time step, 1e-3 by default.
    time_step : float [s]
        A time step for which the error of ε is computed, instead of ``restitution_error``.

    Returns
    -------
    Conversion
        ``.contacts`` has the contacts under our own law. ``.models`` has the numbers for each code, and the restitution
        that the usual number would give there. ``.text`` is the input to paste.

    Raises
    ------
    ValueError
        If a value is outside its range, or alternatives are combined.

    Notes
    -----
    Schwager & Pöschel, Granular Matter 9, 465 (2007), explain why the usual damping gives another ε if a force never
    attracts. The files in ``hardlimit/convert/codes`` name the source of each code's formulas.

    Examples
    --------
    >>> ball = hl.Ball(1e-3, density=2500.0)
    >>> found = hl.convert(
    ...     ball, restitution=0.7, stiffness=1e4, code="chrono", wall=False
    ... )
    >>> one = found.models[0].contacts[0]
    >>> round(one.usual_restitution, 3)  # restitution if the input had 0.7
    0.718
    >>> print(found.models[0].text)
    // Chrono 9 (ChDefaultContactForceTorqueSMC): ChSystemSMC::Hooke with material properties
    sys.SetContactForceModel(ChSystemSMC::Hooke);
    // 1 – 1
    sys.SetCharacteristicImpactVelocity(1);
    mat->SetYoungModulus(159517379.523);
    mat->SetPoissonRatio(0.3);
    mat->SetRestitution(0.679193715508);
    sys.DoStepDynamics(2.062e-07);
    """
    from .conversion import converted
    from .wanted import wanted

    target = wanted(
        restitution,
        speed,
        law,
        stiffness=stiffness,
        youngs_modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        duration=duration,
        compression=compression,
        friction=friction,
        tangential_restitution=tangential_restitution,
    )
    return converted(
        balls, target, wall, code, model, attraction, restitution_error=restitution_error, time_step=time_step
    )
