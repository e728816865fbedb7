"""Bodies in contact: spheres and the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import validation

#: Limits of a mass [kg]; products of two masses neither underflow nor overflow.
LIGHTEST: Final = 1e-150
HEAVIEST: Final = 1e150
#: Least q of a ball; a point cannot take the torque of friction.
POINT: Final = 1e-6
#: q in the moment of inertia q m R² of a solid sphere.
SOLID_SPHERE: Final = 0.4


def ball_masses(density: NDArray[np.float64], radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """Masses of solid spheres [kg]."""
    return np.fromiter(map(_core.ball_mass, density.tolist(), radius.tolist()), np.float64, len(density))


@validation.sealed("write a function that returns a Ball")
@dataclass(frozen=True, init=False)
class Ball:
    """A sphere, by default a solid one.

    Parameters
    ----------
    radius : float [m]
    density : float [kg/m³]
        The mass is (4/3) π density radius³.
    mass : float [kg]
        Give exactly one of ``density`` and ``mass``.
    inertia_factor : float, default 2/5
        q in the moment of inertia q m R², in [1e-6, 1]: 2/5 for a solid sphere, 2/3 for a shell such as a tennis ball,
        1/2 for a disk. Only contacts with friction depend on it.

    Raises
    ------
    ValueError
        If a value is not positive and finite, the mass is not between 1e-150 and 1e150 kg, or not exactly one of the
        alternatives is given.
    """

    radius: float  #: [m]
    mass: float  #: [kg]
    density: float  #: [kg/m³]
    given: str  #: the value that :meth:`resized` keeps, ``"density"`` or ``"mass"``
    inertia_factor: float = SOLID_SPHERE  #: q in the moment of inertia q m R²

    def __init__(
        self,
        radius: float,
        density: float | None = None,
        mass: float | None = None,
        *,
        inertia_factor: float = SOLID_SPHERE,
    ) -> None:
        kept = validation.exactly_one(density=density, mass=mass)
        size = validation.number("radius", radius, 0.0)
        if density is not None:
            rho = validation.number("density", density, 0.0)
            weight = _core.ball_mass(rho, size)
        else:
            weight = validation.number("mass", mass, 0.0)
            volume = _core.ball_mass(1.0, size)
            rho = weight / volume if volume > 0.0 else math.inf
        if not LIGHTEST <= weight <= HEAVIEST:
            what, value = ("density", rho) if kept == "density" else ("mass", weight)
            raise ValueError(
                f"radius | {what}: got {size:.16g} and {value:.16g}, a mass of {weight:g} kg, "
                f"must be in [{LIGHTEST:g}, {HEAVIEST:g}]"
            )
        q = validation.number(
            "inertia_factor", inertia_factor, POINT, 1.0, lowest_allowed=True, highest_allowed=True
        )
        values = {"radius": size, "mass": weight, "density": rho, "given": kept, "inertia_factor": q}
        for name, entry in values.items():
            object.__setattr__(self, name, entry)

    def __repr__(self) -> str:
        q = "" if self.inertia_factor == SOLID_SPHERE else f", inertia_factor={self.inertia_factor!r}"
        return f"Ball(radius={self.radius!r}, {self.given}={getattr(self, self.given)!r}{q})"

    @property
    def moment_of_inertia(self) -> float:
        """q m R² [kg m²]."""
        return self.inertia_factor * self.mass * self.radius**2

    def resized(self, radius: float) -> Ball:
        """A ball with another radius and the same density (or the same mass if the mass was given)."""
        if self.given == "density":
            return Ball(radius, density=self.density, inertia_factor=self.inertia_factor)
        return Ball(radius, mass=self.mass, inertia_factor=self.inertia_factor)


@validation.sealed("the floor is hl.FLOOR")
class Floor:
    """The floor: body 0, of infinite mass and radius."""

    __slots__ = ()

    radius: Final = math.inf
    mass: Final = math.inf
    inertia_factor: Final = 1.0  # has no effect, since the mass is infinite

    def __repr__(self) -> str:
        return "FLOOR"

    def __reduce__(self) -> str:
        return "FLOOR"


FLOOR: Final = Floor()
