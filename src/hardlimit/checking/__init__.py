"""Scripts of other codes: whether an event-driven simulation may replace theirs, and the restitution of a contact."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ..boxes.system import ParticleSystem
from ..contact.balls import Ball, Floor
from ..contact.contact import Law

if TYPE_CHECKING:
    from .reading_back import Obtained
    from .result import Verdict

__all__ = ["check", "convert_back"]


def check(
    source: str | Path | ParticleSystem | Ball,
    *,
    code: str | None = None,
    dump: str | Path | None = None,
    speed: float | tuple[float, float] | None = None,
    variables: Mapping[str, str | float] = {},
    packing_fraction: float | None = None,
    law: Law | None = None,
    time_step: float | None = None,
    dimension: int | None = None,
    power: float | None = None,
    shear_rate: float | None = None,
    restitution_error: float | None = None,
    pressure: float | None = None,
    height: float | None = None,
    version: str | None = None,
    radius: float | None = None,
    density: float | None = None,
    mass: float | None = None,
) -> Verdict:
    """Check what the contacts of a simulation really do, and whether an event-driven simulation may replace it.

    Parameters
    ----------
    source : path, str, ParticleSystem or Ball
        Script or log of LAMMPS, LIGGGHTS or YADE, or its text; nothing in it is executed. Or a system, or one of many
        equal balls, under ``law``.
    code : str, optional
        "lammps", "liggghts" or "yade"; found in the script by default.
    dump : path, optional
        Text dump of LAMMPS or LIGGGHTS, also .gz. It gives the packing fraction, the impact speeds at 10, 50 and 90 %,
        and the share of lasting contacts. With several frames, the hottest one decides.
    speed : float or (float, float) [m/s]
        Mean impact speed √(πT), or its lowest and highest value; in ``lj`` units as in the script. It comes before the
        dump's.
    variables : mapping
        Variables of the script by name, as on the command line of its code.
    packing_fraction : float, optional
        φ of the grains. It comes before the dump's.
    law : Law, optional
        Contact law of a system or a ball.
    time_step : float [s], optional
        Time step under which a ball or a system is simulated; in place of that of a script.
    dimension : int, optional
        For a ball: 3 for spheres, the default, or 2 for disks; solid ones have ``inertia_factor=0.5``.
    power : float [W], optional
        Heating power of each grain, instead of ``speed``; as in the script if it is in ``lj`` units. The speed is that
        of the steady state, in which collisions dissipate this power. A system with a thermostat has its own.
    shear_rate : float [1/s], optional
        Rate of simple shear, instead of ``speed``. The speed is that of the steady state, in which collisions dissipate
        the work of the shear stress. Spheres with ε of at least 0.5.
    restitution_error : float, optional
        Error of ε that a time step may cause, 0.001 by default: that of the corrected lines.
    pressure : float [Pa], optional
        Pressure on grains that are held together; as in the script if it is in ``lj`` units, in two dimensions a force
        per length [N/m]. It comes before what the script says.
    height : float [m], optional
        Height of a bed that rests under gravity, instead of ``pressure``: the number is that at its bottom.
    version : str, optional
        Version of the script's code, such as "22Jul2025", "3.8.0" or "2023.02a"; it comes before that of a log.
    radius : float [m], optional
        Radius of the grains of whose size the script says nothing; as in the script if it is in ``lj`` units.
    density : float [kg/m³], optional
        Density of the grains of whose mass the script says nothing.
    mass : float [kg], optional
        Their mass, instead of ``density``.

    Returns
    -------
    Verdict
        ``.admissible`` is True if event-driven cooling (of a heated gas, the temperature; of a sheared one, the shear
        stress) is right within 1 %, False if it is not or if something cannot be simulated by events, such as cohesion
        or grains at rest or under pressure, and None if it cannot be said, as for grains with friction.

    Raises
    ------
    ValueError
        If the script is not granular or cannot be resolved, the dump cannot be read, or a value is outside its range.
    FileNotFoundError
        If there is no script or dump of this name.

    Notes
    -----
    The error is that of :func:`error_law` at Enskog's collision rate (Chapman & Cowling, The Mathematical Theory of
    Non-uniform Gases, 1970), as for a gas of equal grains of each pair's mean diameter. A force that never attracts
    ends a contact early: Schwager & Pöschel, Granular Matter 9, 465 (2007). The error of ε by the time step is that of
    the code's integration in an isolated contact. Rayleigh time: Thornton & Randall, Micromechanics of Granular
    Materials (1988). Steady temperatures: van Noije & Ernst, Granular Matter 1, 57 (1998) for heating (within 3 % of
    simulations for φ ≤ 0.1; where hard spheres are correlated, T is up to 30 % higher), Lun et al., J. Fluid Mech. 140,
    223 (1984) for shear.

    Examples
    --------
    >>> bead = hl.Ball(1e-3, density=2500.0)
    >>> soft = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    >>> print(hl.check(bead, law=soft, speed=0.3, packing_fraction=0.3))
    May an event-driven simulation replace this? No: event-driven cools 9.6 ± 0.5 %
    too fast at t_c ν = 0.19, δ/d = 0.01 (grains 1–1); 1 % takes a stiffness of
    1.1e5 N/m instead of 1e3.
    """
    from .checking import checked

    return checked(
        source=source,
        code=code,
        dump=dump,
        speed=speed,
        variables=variables,
        packing_fraction=packing_fraction,
        law=law,
        time_step=time_step,
        dimension=dimension,
        power=power,
        shear_rate=shear_rate,
        restitution_error=restitution_error,
        pressure=pressure,
        height=height,
        version=version,
        radius=radius,
        density=density,
        mass=mass,
    )


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
    """Compute the restitution that an input of a code really produces.

    ``restitution_error`` and ``time_step`` are those of :func:`convert`.

    Parameters
    ----------
    text : str
        Lines of input, such as ``convert(…).text``.
    ball : Ball
    other : Ball or FLOOR, optional
        The other body; by default another ``ball``.
    code : str
        "lammps", "liggghts" or "yade".
    model : str, optional
        Name of the contact model; by default it is found in the input.
    speed : float [m/s]
        Impact speed.
    contact : str, optional
        Selects a contact if the input has several with different forces: ``"1-2"`` or ``"1-wall"`` by types, or
        ``"1-floor"`` by the name of a wall, as listed in the error message. Types of YADE are materials by their
        labels, or by their numbers from 1.

    Returns
    -------
    Obtained

    Raises
    ------
    ValueError
        If a value is outside its range, the input has no model of the code or several, a statement that affects a
        contact is not understood (quoted with its line), or contacts have different forces and none is selected.

    Notes
    -----
    A force that never attracts ends the contact early: Schwager & Pöschel, Granular Matter 9, 465 (2007). The text is
    read as by :func:`check`, at its last run; nothing in it is executed. A part of a script is enough, such as the
    lines that :func:`convert` writes, and is in SI units unless it sets others. YADE's numerical damping d multiplies
    decelerating forces by 1 + d and accelerating forces by 1 − d; an elastic contact then gives √((1 − d)/(1 + d)).

    Examples
    --------
    >>> line = "hooke 1e4 0.7 damping coeff_restitution limit_damping"
    >>> found = hl.convert_back(line, hl.Ball(1e-3, density=2500.0), code="lammps")
    >>> round(found.restitution, 4)
    0.7182
    """
    from .reading_back import obtained

    return obtained(
        text,
        ball,
        other,
        code,
        model,
        speed=speed,
        restitution_error=restitution_error,
        time_step=time_step,
        contact=contact,
    )
