"""One replica: the same start under Newton's equations and under each rule, side by side from sample to sample."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..boxes import hard_spheres, newton, time_step
from ..boxes.box import Floats
from ..boxes.engines import NewtonSettings
from ..boxes.observables import OBSERVABLES, Samples
from ..boxes.result import ContactResult
from ..boxes.rules import Settings
from ..boxes.run import Keeping, Run
from ..boxes.system import ParticleSystem
from ..contact.contact import Law
from . import encounters
from .observables import Observer

NEWTON: Final = "newton"
RULES: Final = ("constant", "law", "tc", "soft")
#: Of ε, which Newton's equations by steps may make: a tenth of what they make unless asked.
RESTITUTION_ERROR: Final = 1e-4

#: Dissipated energies up to this part of the kinetic energy of the start are none.
ROUNDING: Final = 1e-12

#: Of every sample of every model: unit and meaning.
QUANTITIES: Final = {
    "granular_temperature": ("m2/s2", "granular temperature Σ m|v − V|²/(d Σ m)"),
    "cooling": ("1", "√(E(0)/E) − 1, E the energy not yet dissipated: linear in time under Haff’s law"),
    "dissipation_rate": ("W", "energy lost in contacts per time, mean since the start"),
    "collision_rate": ("1/s", "2·contacts of pairs/(N·time), mean since the start"),
    "pressure": ("Pa", "from the virial of pairs, mean since the start"),
    "pair_correlation": ("1", "g near contact, between 1 and 1.1 sums of radii, overlaps included"),
    "density_variance": ("1", "variance over mean of the particles in cells of some 8"),
}
DIVERGENCE: Final = (
    "1",
    "rms distance of the particles from their places under Newton’s equations, in radii",
)

Arrays = dict[str, NDArray[Any]]
Step = Callable[[], object]  #: called about every 0.2 s, and with each sample; may raise to stop


@dataclass(frozen=True)
class Plan:
    """What is done with every start."""

    law: Law
    models: tuple[str, ...]  #: Newton's equations first
    until: float  #: [s]
    samples: int
    restitution: float  #: of the rules constant and tc
    contact_duration: float  #: [s], of the rule tc
    engine: str = "events"  #: of Newton's equations

    @property
    def times(self) -> Floats:
        """Of the samples [s]."""
        spacings = self.samples if self.until > 0.0 else 0
        return np.array([self.until * (k / self.samples) for k in range(spacings + 1)])

    @property
    def steps(self) -> int:
        """Samples of all models of one replica."""
        return len(self.times) * len(self.models)


def digest(system: ParticleSystem) -> NDArray[np.uint8]:
    """32 bytes that tell one start from another."""
    found = hashlib.sha256()
    for field in fields(system):
        value = getattr(system, field.name)
        found.update(
            np.ascontiguousarray(value).tobytes() if field.name != "boundary" else repr(value).encode()
        )
    return np.frombuffer(found.digest(), np.uint8)


def compute(plan: Plan, system: ParticleSystem, sampled: Step, alive: Step) -> Arrays:
    """Quantities (model, time), and per model what the logs say; NaN after the end of a model that ended early.

    ``sampled`` is called with every sample of a model, ``alive`` in between as well.
    """
    runs = [_course(plan, model, system) for model in plan.models]
    paths = [run.steps(lambda done, total: alive()) for run in runs]
    observer, times = Observer(system), plan.times
    shape = len(runs), len(times)
    found = {name: np.full(shape, math.nan) for name in (*QUANTITIES, "divergence")}
    reached = [0] * len(runs)
    for k, time in enumerate(times):
        truth: Floats | None = None
        for i, (run, path) in enumerate(zip(runs, paths, strict=True)):
            sampled()
            if reached[i] < k or next(path, None) != time:
                continue
            reached[i] = k + 1
            places = run.engine.state()[0]
            truth = places if i == 0 else truth
            found["pair_correlation"][i, k] = observer.pair_correlation(places)
            found["density_variance"][i, k] = observer.density_variance(places)
            if truth is not None:
                found["divergence"][i, k] = observer.divergence(places, truth)
    logs = []
    for i, run in enumerate(runs):
        ended = run.result()
        for name, values in _series(system, ended, reached[i]).items():
            found[name][i, : reached[i]] = values
        logs.append(_of_the_log(plan, system, ended))
    return {
        **found,
        **{name: np.array([log[name] for log in logs]) for name in logs[0]},
        "start": digest(system),
    }


def _course(plan: Plan, model: str, system: ParticleSystem) -> Run:
    """The run of one model at its beginning."""
    keeping = Keeping(plan.samples, log=True)
    if model == NEWTON:
        step = None
        if plan.engine == "steps":
            step = time_step.chosen(system, plan.law, RESTITUTION_ERROR, None)
        return newton.start(plan.engine, system, NewtonSettings(plan.law), plan.until, keeping, step)
    if model in ("constant", "tc"):
        duration = plan.contact_duration if model == "tc" else None
        settings = Settings(model, plan.restitution, None, duration)
    else:
        settings = Settings(model, None, plan.law, None)
    return hard_spheres.start(system, settings, hard_spheres.End(plan.until, None), keeping)


def _series(system: ParticleSystem, ended: Any, reached: int) -> dict[str, Floats]:
    """Temperature and energy, and means since the start, of the samples that were reached."""
    samples = Samples(system, {name: values[:reached] for name, values in ended.samples.items()})
    time = samples["time"]
    lost, passed = samples["dissipated_energy"], time - time[0]
    lost = np.where(np.abs(lost) <= ROUNDING * system.kinetic_energy, 0.0, lost)
    lasted = np.diff(passed)
    found = {"granular_temperature": samples["granular_temperature"], "cooling": _cooling(system, lost)}
    with np.errstate(invalid="ignore", divide="ignore"):
        found["dissipation_rate"] = lost / passed
        for name in ("collision_rate", "pressure"):
            found[name] = np.append(0.0, np.cumsum(OBSERVABLES[name].values(samples)[1:] * lasted)) / passed
    return found


def _cooling(system: ParticleSystem, lost: Floats) -> Floats:
    """√(E(0)/E) − 1; under gravity nothing cools by itself: NaN.

    Between walls E is the kinetic energy, without them that of the motion relative to the centre of mass.
    """
    if system.gravity.any():
        return np.full(len(lost), math.nan)
    at_start = system.kinetic_energy
    if "wall" not in system.boundary:
        at_start = 0.5 * system.dimension * float(system.mass.sum()) * system.granular_temperature
    left = at_start - lost
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(left > 0.0, np.sqrt(at_start / left) - 1.0, math.nan)


def _of_the_log(plan: Plan, system: ParticleSystem, ended: Any) -> dict[str, Any]:
    """What single contacts were like, and how the run ended."""
    if isinstance(ended, ContactResult):
        assert ended.n_contacts is not None  # both of our engines count them
        found, count = encounters.of_newton(ended), ended.n_contacts
    else:
        found, count = encounters.of_hard_spheres(system, plan.law, ended), ended.n_collisions
    return {
        "overlapped_share": found.overlapped_share,
        "median_restitution": found.median,
        "restitution_share": found.histogram,
        "n_contacts": float(count),
        "largest_compression": math.nan if ended.largest_compression is None else ended.largest_compression,
        "end_time": ended.time,
        "outcome": float(ended.outcome_code),
    }
