"""Restitution into the damping, time step and input of particle codes, and back.

The work is imported when it is called: files of codes need what ``import hardlimit`` does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..contact.balls import Ball, Floor

if TYPE_CHECKING:
    from .conversion import Conversion, Obtained

__all__ = ["convert", "convert_back"]


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
    restitution_error: float | None = None,
    time_step: float | None = None,
) -> Conversion:
    """A coefficient of restitution as damping, time step and the input of particle codes, for every pair of sizes.

    Parameters
    ----------
    balls : Ball or sequence of Ball
        The sizes in a bed, at most 30. Contacts are those of each with itself, with every other one, and with a wall.
    restitution : float
        Coefficient of restitution ε that is wanted, in [0.001, 1].
    speed : float [m/s]
        Of the impact at which it is wanted.
    stiffness : float [N/m]
        Of a linear spring. Exactly one of ``stiffness``, ``youngs_modulus``, ``duration`` and ``compression`` is given.
    youngs_modulus : float [Pa]
        Of the material of balls and wall. Under the linear law, the spring is one that an undamped impact at ``speed``
        compresses as far as the Hertz contact.
    poisson_ratio : float
        Of that material, beside ``youngs_modulus``; in (-1, 0.5].
    duration : float [s]
        Of each contact.
    compression : float [m]
        The greatest in each contact.
    law : str
        "linear", "tsuji" (Hertz, with a restitution that does not depend on the speed) or "viscoelastic". By default
        "tsuji" with a modulus, else "linear".
    wall : bool
        Whether contacts with a wall are wanted.
    code : str
        A code; by default all.
    model : str
        One of its models; by default all of this law.
    attraction : bool
        For codes that leave the choice: whether the force attracts at the end of a contact.
    restitution_error : float
        The error of ε that the time step may make, by default 1e-3.
    time_step : float [s]
        Instead, a time step whose error of ε is wanted.

    Returns
    -------
    Conversion
        ``.contacts`` under our own law; ``.models`` with the numbers that each code must be given and what the usual
        number would give there; ``.text`` to paste.

    Raises
    ------
    ValueError
        If a value is outside its range, or alternatives do not go together.

    Notes
    -----
    Why the usual damping gives another ε where a force never attracts: Schwager & Pöschel, Granular Matter 9, 465
    (2007).
    Source of each code's formulas: the files in ``hardlimit/convert/codes``.

    Examples
    --------
    >>> ball = hl.Ball(1e-3, density=2500.0)
    >>> found = hl.convert(
    ...     ball, restitution=0.7, stiffness=1e4, code="chrono", wall=False
    ... )
    >>> one = found.models[0].contacts[0]
    >>> round(one.usual_restitution, 3)  # what 0.7 in the input would give
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

    asked = wanted(restitution, speed, law, stiffness, youngs_modulus, poisson_ratio, duration, compression)
    return converted(balls, asked, wall, code, model, attraction, restitution_error, time_step)


def convert_back(
    text: str,
    ball: Ball,
    other: Ball | Floor | None = None,
    *,
    code: str,
    model: str | None = None,
    speed: float = 1.0,
    restitution_error: float | None = None,
    time_step: float | None = None,
    contact: str | None = None,
) -> Obtained:
    """The restitution that an input of a code really gives.

    Parameters
    ----------
    text : str
        Lines of input, such as ``convert(…).text`` holds.
    ball : Ball
    other : Ball or FLOOR, optional
        The other body; by default one like ``ball``.
    code : str
        Of which code the input is.
    model : str, optional
        Found in the input unless it is given.
    speed : float [m/s]
        Of impact.
    restitution_error : float
        As for :func:`convert`.
    time_step : float [s]
        As for :func:`convert`.
    contact : str, optional
        Which contact is meant, where an input has several with different numbers: ``"1-2"`` or ``"1-wall"`` by types,
        or the name of an object, as the refusal lists them.

    Returns
    -------
    Obtained

    Raises
    ------
    ValueError
        If a value is outside its range, the input has no model of the code or several, a statement that decides on a
        contact is not understood (quoted with its line), or contacts have different numbers and none is named.

    Notes
    -----
    A force that never attracts ends the contact early: Schwager & Pöschel, Granular Matter 9, 465 (2007). Source of
    each code's formulas: as for :func:`convert`. The text is cut into words as the code does it, with its comments,
    continued lines, quotes, variables and units; nothing in it is executed. YADE's numerical damping d brakes with
    1 + d of a force and drives with 1 − d of it: an elastic contact gives √((1 − d)/(1 + d)).

    Examples
    --------
    >>> line = "hooke 1e4 0.7 damping coeff_restitution limit_damping"
    >>> found = hl.convert_back(line, hl.Ball(1e-3, density=2500.0), code="lammps")
    >>> round(found.restitution, 4)
    0.7182
    """
    from .conversion import obtained

    return obtained(text, ball, other, code, model, speed, restitution_error, time_step, contact)
