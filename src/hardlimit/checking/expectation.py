"""Error of event-driven cooling that the law of the error expects for a contact force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, Final, NamedTuple

from ..boxes.error_law import (
    DENSEST,
    LINEAR_POWERS,
    MEASURED_POWERS,
    ErrorLaw,
    Exponents,
    of_exponents,
    with_friction,
)
from ..boxes.frictional_error import Setting
from ..contact.friction import LIMITS, NONE, RECORD, SPRING, Friction, FrictionTerms
from ..convert.force import Powers
from ..support import validation

#: Error of event-driven cooling up to which the answer is yes.
ACCEPTED: Final = 0.01
#: Standard error of temperature and stress under shear that theory leaves, over t_c ν: from studies/sheared_gas.nc.
SHEAR_BAR: Final = 0.08
#: Relative error of the stress under shear by a speed from theory, whose temperature is 5 % too high to 8 % too low.
SHEAR_SPEED_BAR: Final = 0.04
#: Relative error bar for a force with other powers than those measured: of these, the nearest with the same elastic
#: force are taken, if there are any.
OTHER_POWERS: Final = 0.1


class Expected(NamedTuple):
    """Relative errors with their error bars: of the rate of cooling, of the temperature of a heated gas, and of the
    stress of a sheared one; None if unknown."""

    cooling: tuple[float, float]
    temperature: tuple[float, float] | None
    stress: tuple[float, float] | None

    def wider(self, relative: float) -> Expected:
        """With a further relative error."""

        def wide(error: tuple[float, float]) -> tuple[float, float]:
            return error[0], math.hypot(error[1], error[0] * relative)

        temperature = None if self.temperature is None else wide(self.temperature)
        return Expected(wide(self.cooling), temperature, None if self.stress is None else wide(self.stress))


def expected(
    rule: str, dimension: int, packing_fraction: float, restitution: float, powers: Powers, tc_nu: float
) -> Expected | None:
    """The error under one rule of collision; None if the packing is too dense for any gas."""
    if packing_fraction > DENSEST[dimension]:
        return None
    form = (powers.elastic, powers.damping)
    same_elastic = [known for known in MEASURED_POWERS if known[0] == powers.elastic]
    nearest = form if form in same_elastic or not same_elastic else same_elastic[0]
    law = _law(rule, dimension, packing_fraction, restitution, nearest)
    bar = law.error_bar(tc_nu)
    errors = Expected((law.error(tc_nu), bar), *_driven(law, tc_nu, bar))
    return errors if form in MEASURED_POWERS else errors.wider(OTHER_POWERS)


class Rubbing(NamedTuple):
    """Grains with friction: what their error depends on."""

    friction: Friction
    inertia_factor: float


def rubbing(terms: FrictionTerms, numbers: Mapping[str, Any], inertia_factor: float) -> Rubbing | None:
    """The friction of a contact by its model and its ratios; None if they are not those of a :class:`Friction`."""
    ratio, damping, mu = numbers.get("stiffness_ratio"), numbers.get("damping_ratio"), terms.coefficient
    history = {"loading": terms.loading, "unloading": terms.unloading}
    models = [model["name"] for model in RECORD["models"] if {key: model[key] for key in history} == history]
    models = [name for name in models if name != NONE and (name == SPRING) == (terms.stiffness_power == 0)]
    if not models or ratio is None or damping is None or not ratio > 0.0 or not 0.0 < mu < math.inf:
        return None
    rounded = {
        "stiffness_ratio": float(f"{ratio:.6g}"),
        "damping_ratio": float(f"{damping:.6g}"),
    }
    return Rubbing(Friction(mu, **rounded, model=models[0], limit=LIMITS[terms.limit]), inertia_factor)


def expected_rubbing(
    rule: str,
    dimension: int,
    packing_fraction: float,
    restitution: float,
    powers: Powers,
    grains: Rubbing,
    tc_nu: float,
    *,
    sheared: bool,
) -> Expected | None:
    """The errors under the rule law or constant with the friction of the grains; None if they are not known. Those of
    heating and shear are known under the rule law for spheres with linear springs. That of shear takes a second and
    is left out unless the gas is ``sheared``.

    The spins at the start of a cooling gas are not known. Its error is the mean of that without spins and that of equal
    temperatures, and half of their difference is in its bar.
    """
    laws = _rubbing_laws(rule, dimension, packing_fraction, float(f"{restitution:.6g}"), powers, grains)
    if not laws:
        return None
    first, second = (law.error(tc_nu) for law in laws)
    bar = max(law.error_bar(tc_nu) for law in laws)
    cooling = 0.5 * (first + second), math.hypot(bar, 0.5 * (first - second))
    return Expected(cooling, *_driven(laws[0], tc_nu, bar, sheared))


def _driven(
    law: ErrorLaw, tc_nu: float, bar: float, sheared: bool = True
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """The errors of heating and shear, where they are known. Temperatures go as the power −2/3 of the rate of cooling,
    whose error has this bar, stresses as −1/2."""
    heated = law.heated_error(tc_nu)
    stress = math.nan if law.no_shear() or not sheared else law.sheared_errors(tc_nu).stress
    return (
        None if math.isnan(heated) else (heated, 2.0 / 3.0 * (1.0 + heated) * bar),
        None
        if math.isnan(stress)
        else (
            stress,
            math.hypot((1.0 + stress) * math.hypot(0.5 * bar, SHEAR_BAR * tc_nu), SHEAR_SPEED_BAR * stress),
        ),
    )


def knows_driven(dimension: int, powers: Powers) -> bool:
    """Whether the errors of heated and sheared gases with friction are known: for spheres with linear springs."""
    return dimension == 3 and (powers.elastic, powers.damping) == LINEAR_POWERS


def smooth_error(
    dimension: int, packing_fraction: float, restitution: float, powers: Powers, grains: Rubbing
) -> float | None:
    """The error of event-driven cooling that leaves the friction of the grains out, in theory, for the same spins."""
    laws = _rubbing_laws("law", dimension, packing_fraction, float(f"{restitution:.6g}"), powers, grains)
    return sum(law.smooth_error for law in laws) / len(laws) if laws else None


def extrapolated(
    dimension: int,
    packing_fraction: float,
    restitution: float,
    powers: Powers,
    grains: Rubbing,
    quantity: str,
) -> str:
    """How the grains are outside what was measured of a quantity, a field of :class:`Expected`, in words; empty if they
    are inside or nothing is known."""
    e = float(f"{restitution:.6g}")
    laws = _rubbing_laws("law", dimension, packing_fraction, e, powers, grains)
    if quantity == "cooling" or not laws:
        return laws[0].extrapolated if laws else ""
    form = (powers.elastic, powers.damping)
    grains_of = Setting(dimension, e, grains.friction, 0.0, grains.inertia_factor, form)
    return grains_of.outside_driven(packing_fraction, quantity == "stress")


@cache
def _rubbing_laws(
    rule: str, dimension: int, packing_fraction: float, restitution: float, powers: Powers, grains: Rubbing
) -> tuple[ErrorLaw, ...]:
    """The law of the error of gases without spins and of equal temperatures; none if it is not known."""
    form = (powers.elastic, powers.damping)
    if packing_fraction > DENSEST[dimension] or form not in MEASURED_POWERS:
        return ()
    smooth = of_exponents(dimension, packing_fraction, restitution, rule, Exponents.of(form))
    try:
        return tuple(
            with_friction(smooth, grains.friction, theta, grains.inertia_factor, form) for theta in (0.0, 1.0)
        )
    except ValueError:  # far from what was measured
        return ()


@cache
def _law(
    rule: str, dimension: int, packing_fraction: float, restitution: float, powers: tuple[int, int]
) -> ErrorLaw:
    return of_exponents(dimension, packing_fraction, restitution, rule, Exponents.of(powers))


def checked_packing_fraction(value: float, dimension: int) -> float:
    """A packing fraction for which there is a law of the error."""
    return validation.number("packing_fraction", value, 0.0, DENSEST[dimension], highest_allowed=True)
