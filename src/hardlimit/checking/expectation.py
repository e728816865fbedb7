"""Error of event-driven cooling that the law of the error expects for a contact force."""

from __future__ import annotations

import math
from functools import cache
from typing import Final, NamedTuple

from ..boxes.error_law import DENSEST, MEASURED_POWERS, ErrorLaw, Exponents, of_exponents
from ..convert.force import Powers
from ..support import validation

#: Error of event-driven cooling up to which the answer is yes.
ACCEPTED: Final = 0.01
#: Standard error of temperature and stress under shear that theory leaves, over t_c ν: from studies/sheared_gas.nc.
SHEAR_BAR: Final = 0.08
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
    error, bar = law.error(tc_nu), law.error_bar(tc_nu)
    heated = law.heated_error(tc_nu)
    stress = math.nan if law.no_shear() else law.sheared_errors(tc_nu).stress
    # Temperatures go as the power −2/3 of the rate of cooling, stresses as −1/2.
    errors = Expected(
        (error, bar),
        None if math.isnan(heated) else (heated, 2.0 / 3.0 * (1.0 + heated) * bar),
        None if math.isnan(stress) else (stress, (1.0 + stress) * math.hypot(0.5 * bar, SHEAR_BAR * tc_nu)),
    )
    return errors if form in MEASURED_POWERS else errors.wider(OTHER_POWERS)


@cache
def _law(
    rule: str, dimension: int, packing_fraction: float, restitution: float, powers: tuple[int, int]
) -> ErrorLaw:
    return of_exponents(dimension, packing_fraction, restitution, rule, Exponents.of(powers))


def checked_packing_fraction(value: float, dimension: int) -> float:
    """A packing fraction for which there is a law of the error."""
    return validation.number("packing_fraction", value, 0.0, DENSEST[dimension], highest_allowed=True)
