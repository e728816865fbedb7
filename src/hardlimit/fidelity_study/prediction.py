"""What the law of the error predicts for a comparison of rules with Newton's equations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from ..boxes import theory
from ..boxes.contacts import mean_grain, rubs
from ..boxes.error_law import MEASURED_TC_NU, ErrorLaw, error_law, exponents, softness
from ..boxes.frictional_error import axes_of_rotation
from ..boxes.rules import RULES
from ..boxes.thermostats import RandomKicks
from ..checking.expectation import SHEAR_BAR
from ..support.estimate import Estimate
from .replica import NEWTON

if TYPE_CHECKING:
    from .result import Fidelity

#: Standard errors of the prediction in its 99 % interval.
BARS: Final = 2.6
#: Fewest particles of a gas.
FEWEST_PARTICLES: Final = 4
#: Fewest contacts that overlap others for a measured difference of the rule soft, which errs in them alone: the
#: differences of replicas with one or none of them have no normal distribution.
FEWEST_OVERLAPPING: Final = 100
#: Relative standard error of the law with friction before the time of its measurement, in which T_r/T changes.
EARLIER: Final = 0.2
#: Number of intervals of √(E(0)/E) over which the predicted error is integrated.
INTERVALS: Final = 64


class Prediction(NamedTuple):
    """Prediction for the final difference of the cooling of a rule; made by ``Fidelity.predicted``."""

    value: float = math.nan  #: relative difference, > 0 if the rule cools too fast; NaN without a prediction
    error: float = math.nan  #: its standard error
    reason: str = ""  #: why there is no prediction
    extrapolated: str = ""  #: which argument of the law is outside the range of its measurements

    def contradicts(self, measured: Estimate[float]) -> bool:
        """Whether a measured difference and the prediction differ significantly, at 99 %.

        :meta private:
        """
        bars = math.hypot(0.5 * (measured.upper - measured.lower), BARS * self.error)
        return abs(measured.value - self.value) > bars  # False with NaN


def predicted(f: Fidelity, rule: str) -> Prediction:
    """Prediction for the final difference of the cooling of a rule.

    The law gives the error e at equal energies. With y = √(E(0)/E), dy/dt of the rule is 1 + e(t_c ν) times that under
    Newton's equations, which is proportional to 1/(1 + a t_c ν). The difference is that of y − 1 at equal times.
    Besides, there are no contacts at the start, so that Newton's equations lag behind by t_c/2. The standard error
    contains half of this lag.
    """
    thermostat = f.start.thermostat
    heated = isinstance(thermostat, RandomKicks)
    if rubs(f.plan.law) and isinstance(thermostat, RandomKicks) and thermostat.rotational:
        return Prediction(reason="with friction it is that of kicks on velocities only")
    if f.sheared and thermostat is not None:
        return Prediction(reason="it is sheared and has a thermostat")
    still = f.start.replace(boundary="periodic") if f.sheared else f.start
    reason = theory.why_not(still.replace(thermostat=None) if heated else still)
    if reason is not None:
        return Prediction(reason=reason)
    if f.start.n < FEWEST_PARTICLES:
        return Prediction(reason=f"{f.start.n} particles are no gas")
    law, epsilon = f.plan.law, f.plan.restitution
    q = exponents(law).energy
    if rule not in RULES:
        return Prediction(reason="it is no rule")
    if not RULES[rule].error:
        return Prediction(reason="the law of the error does not know it")
    if RULES[rule].has_constant_restitution and abs(q - 2.0) > 1e-6:
        return Prediction(reason="ε of this contact law depends on the speed")
    at_start = f.start.granular_temperature
    own = softness(law, f.start, at_start)
    if not np.allclose((own.restitution, own.duration), (epsilon, f.contact_duration), rtol=1e-6):
        return Prediction(reason="ε or t_c was given and is not that of the law")
    gas = theory.gas(still.replace(thermostat=None))
    if heated or f.sheared:
        return _driven(f, rule, gas)
    tc_nu = f.contact_duration * float(gas.collision_rate(f.start.granular_temperature))
    last = f.last_common(rule)
    grown = float(f._all("cooling")[:, 0, last].mean())  # y − 1 under Newton's equations
    if tc_nu > MEASURED_TC_NU:
        return Prediction(reason=f"t_c ν = {tc_nu:.2g} is above {MEASURED_TC_NU:g}")
    if not grown > 0.0:
        return Prediction(reason="nothing was dissipated")
    try:
        reference, of_rule = (_law(f, name, gas) for name in ("law", rule))
    except ValueError as unknown:  # with friction
        return Prediction(reason=f"it is not known with this {unknown}")
    if not _has_own_restitution(f, rule):
        return Prediction(reason="β0 was given and is not that of the law")
    y = np.linspace(1.0, 1.0 + 2.0 * grown, 2 * INTERVALS + 1)
    slower = _by_rotation(f, reference)
    at = [slower * tc_nu / float(middle) ** (2.0 / q) for middle in 0.5 * (y[1:] + y[:-1])]
    newton = np.array([1.0 + reference.error(x) for x in at]) * np.diff(y)
    hard = newton / np.array([1.0 + of_rule.error(x) for x in at])
    time = newton[:INTERVALS].sum()
    reached = float(np.interp(time, np.append(0.0, np.cumsum(hard)), y)) - 1.0
    lag = tc_nu * _loss(f, gas) / (4.0 * grown)
    uncertain = float(np.mean([of_rule.error_bar(x) for x in at[:INTERVALS]]))
    if of_rule.friction is not None:  # the coefficient is that of a time after the start
        uncertain = math.hypot(
            uncertain, EARLIER * float(np.mean([of_rule.error(x) for x in at[:INTERVALS]]))
        )
    value = reached / grown - 1.0 + lag
    return Prediction(value, math.hypot(uncertain, 0.5 * lag), extrapolated=of_rule.extrapolated)


def contradicted(f: Fidelity, rule: str) -> bool:
    """Whether the measured final difference of a rule contradicts the prediction, at 99 %."""
    overlapping = f._all("overlapped_share")[:, 0] @ f._all("n_contacts")[:, 0]
    if RULES[rule].error == "soft" and not overlapping >= FEWEST_OVERLAPPING:
        return False
    measure = "granular_temperature" if f.driven else "cooling"
    return f.predicted(rule).contradicts(f.final_difference(measure, rule))


def _driven(f: Fidelity, rule: str, gas: theory.Gas) -> Prediction:
    """Prediction for the difference of the temperature in the steady state at equal heating power or shear rate, at
    Enskog's t_c ν of the temperature under Newton's equations."""
    if f.steady.reason:
        return Prediction(reason="there is no steady state")
    temperature = f.steady_mean("granular_temperature", NEWTON).value
    at = f.contact_duration * float(gas.collision_rate(temperature))
    if at > MEASURED_TC_NU:
        return Prediction(reason=f"t_c ν = {at:.2g} is above {MEASURED_TC_NU:g}")
    try:
        law = _law(f, rule, gas)
    except ValueError as unknown:  # with friction
        return Prediction(reason=f"it is not known with this {unknown}")
    if not f.sheared:
        value = law.heated_error(at)
        if math.isnan(value):
            return Prediction(
                reason="with friction it is that of spheres with linear springs under the rule law"
            )
        bar = 2.0 / 3.0 * (1.0 + value) * law.error_bar(at)
        return Prediction(value, bar, extrapolated=law.outside_driven(sheared=False))
    if reason := law.no_shear():
        return Prediction(reason=f"the law of the error of shear is not that of {reason}")
    value = law.sheared_errors(at).temperature
    if math.isnan(value):
        return Prediction(reason=f"t_c ν = {at:.2g} is too large for the theory of so thin a gas")
    bar = (1.0 + value) * math.hypot(law.error_bar(at), SHEAR_BAR * at)
    return Prediction(value, bar, extrapolated=law.outside_driven(sheared=True))


def _spinning(f: Fidelity) -> float:
    """T_r/T at the start."""
    return float(f.start.rotational_temperature / f.start.granular_temperature)


def _by_rotation(f: Fidelity, law: ErrorLaw) -> float:
    """√T at a given energy over that at the ratio T_r/T of the start; 1 without friction."""
    if law.friction is None:
        return 1.0
    share = axes_of_rotation(law.dimension) / law.dimension
    return math.sqrt((1.0 + share * _spinning(f)) / (1.0 + share * law.temperature_ratio))


def _loss(f: Fidelity, gas: theory.Gas) -> float:
    """Relative loss of energy at the start for a collision of each particle, by the theory of hard spheres."""
    if not rubs(f.plan.law):
        return (1.0 - f.plan.restitution**2) / gas.dimension
    theta = _spinning(f)
    speed = math.sqrt(math.pi * f.start.granular_temperature)
    loss = -gas.rotating(law=f.plan.law, speed=speed).mean_collision(theta).energy_change
    return loss / (gas.dimension + axes_of_rotation(gas.dimension) * theta)


def _has_own_restitution(f: Fidelity, rule: str) -> bool:
    """Whether β0 of the rule constant is that which stands for the law."""
    if not (rubs(f.plan.law) and RULES[rule].has_constant_restitution):
        return True
    grain = mean_grain(f.start)
    own = f.plan.law.between(grain, grain).effective_tangential_restitution(
        math.sqrt(math.pi * f.start.granular_temperature), f.start.dimension
    )
    return math.isclose(f.plan.tangential_restitution or 0.0, own, abs_tol=1e-3)


def _law(f: Fidelity, rule: str, gas: theory.Gas) -> ErrorLaw:
    rotation: dict[str, Any] = {}
    if rubs(f.plan.law):
        rotation = {"temperature_ratio": _spinning(f), "inertia_factor": gas.inertia_factor}
    return error_law(
        **rotation,
        packing_fraction=gas.packing_fraction,
        restitution=f.plan.restitution,
        dimension=gas.dimension,
        rule=rule,
        law=f.plan.law,
    )
