"""One replica: an initial state simulated under Newton's equations and each rule, synchronously at every sample."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..boxes import hard_spheres, newton, time_step
from ..boxes.box import Floats
from ..boxes.contacts import rubs
from ..boxes.engines import NewtonSettings
from ..boxes.observables import OBSERVABLES, Observable, Samples
from ..boxes.result import ContactResult
from ..boxes.rules import RULES, Settings
from ..boxes.run import Output, Run
from ..boxes.system import ParticleSystem
from ..contact.contact import Law
from . import contacts
from .observables import Observer

NEWTON: Final = "newton"
#: Accepted error of ε with the engine "steps", a tenth of its default.
RESTITUTION_ERROR: Final = 1e-4

#: Dissipated energies below this fraction of the initial kinetic energy are rounding errors.
ROUNDING: Final = 1e-12


def _mean(name: str) -> Observable:
    """The mean since the start of a rate in the series of a box."""
    rate = OBSERVABLES[name]
    return replace(rate, meaning=f"{rate.meaning}, mean since the start")


_COMPARED: Final = (
    OBSERVABLES["granular_temperature"],
    Observable(
        "cooling",
        "1",
        "√(E(0)/E) − 1, E the energy not yet dissipated: linear in time under Haff’s law",
        ("dissipated_energy",),
    ),
    _mean("dissipation_rate"),
    _mean("collision_rate"),
    _mean("pressure"),
    Observable(
        "pair_correlation", "1", "g near contact, up to 1.1 sums of radii, overlaps included", ("state",)
    ),
    Observable(
        "density_variance",
        "1",
        "variance over mean of the number of particles in cells of about 8",
        ("state",),
    ),
)
#: Observables of every sample and model that are compared, by name.
QUANTITIES: Final = {record.name: record for record in _COMPARED}
#: A further one of grains that rub.
ROTATION: Final = OBSERVABLES["rotational_temperature"]
#: Further ones of a sheared box.
OF_SHEAR: Final = {name: _mean(name) for name in ("shear_stress", "first_normal_stress_difference")}
NONLINEAR: Final = Observable(
    "nonlinear_flow",
    "1",
    "share of the mean square of v_x, about the linear flow of a sheared box, that is a flow in layers",
    ("state",),
)
DIVERGENCE: Final = Observable(
    "divergence",
    "1",
    "rms distance of the particles from their positions under Newton’s equations, in radii",
    ("state",),
)

#: Observables of driven boxes in each interval between samples, besides the quantities themselves.
INTERVALS: Final = {
    record.name: record
    for record in (
        OBSERVABLES["dissipation_rate"],
        OBSERVABLES["collision_rate"],
        OBSERVABLES["pressure"],
        OBSERVABLES["pressure_tensor"],
        Observable(
            "driving_power",
            "W",
            "work of the walls and of shear, and heat, per time",
            ("wall_work", "heat", "shear_work"),
            "rate",
        ),
    )
}
PREFIX: Final = "interval_"  #: of their arrays

Arrays = dict[str, NDArray[Any]]
Call = Callable[[], object]  #: may raise an exception to stop the run


def quantities(system: ParticleSystem, law: Law) -> dict[str, Observable]:
    """The observables that are compared in a box."""
    rotation = {ROTATION.name: ROTATION} if rubs(law) else {}
    return QUANTITIES | rotation | (OF_SHEAR if system.shear_rate else {})


@dataclass(frozen=True)
class Plan:
    """The models, samples and parameters that all replicas share."""

    law: Law
    models: tuple[str, ...]  #: Newton's equations first
    until: float  #: [s]
    samples: int
    restitution: float  #: of the rules that take one
    contact_duration: float  #: [s], of the rule tc
    engine: str = "events"  #: of Newton's equations
    tangential_restitution: float | None = (
        None  #: of the rules that take a restitution; None without friction
    )

    @property
    def times(self) -> Floats:
        """Times of the samples [s]."""
        spacings = self.samples if self.until > 0.0 else 0
        return np.array([self.until * (k / self.samples) for k in range(spacings + 1)])

    @property
    def steps(self) -> int:
        """Number of samples of one replica, all models together."""
        return len(self.times) * len(self.models)


def digest(system: ParticleSystem) -> NDArray[np.uint8]:
    """Hash of an initial state, 32 bytes."""
    hash_of = hashlib.sha256()
    for value in system._values().values():
        if isinstance(value, np.ndarray):
            hash_of.update(np.ascontiguousarray(value).tobytes())
    hash_of.update(system._drive().encode())
    return np.frombuffer(hash_of.digest(), np.uint8)


def compute(plan: Plan, system: ParticleSystem, sampled: Call, alive: Call) -> Arrays:
    """Observables (model, time) and statistics of the contacts of each model; NaN after an early end.

    ``sampled`` is called at every sample of a model, ``alive`` about every 0.2 s in between.
    """
    runs = [_start(plan, model, system) for model in plan.models]
    paths = [run.steps(lambda done, total: alive()) for run in runs]
    observer, times = Observer(system), plan.times
    arrays = {
        name: np.full((len(runs), len(times)), math.nan)
        for name in (
            *quantities(system, plan.law),
            *([NONLINEAR.name] if system.shear_rate else []),
            "divergence",
        )
    }
    reached = [0] * len(runs)
    for k, time in enumerate(times):
        reference: Floats | None = None  # positions under Newton's equations
        for i, (run, path) in enumerate(zip(runs, paths, strict=True)):
            sampled()
            if reached[i] < k or next(path, None) != time:
                continue
            reached[i] = k + 1
            positions, velocities = run.engine.state()
            reference = positions if i == 0 else reference
            arrays["pair_correlation"][i, k] = observer.pair_correlation(positions, time)
            arrays["density_variance"][i, k] = observer.density_variance(positions, time)
            if system.shear_rate:
                arrays[NONLINEAR.name][i, k] = observer.nonlinear_flow(positions, velocities, time)
            if reference is not None:
                arrays["divergence"][i, k] = observer.divergence(positions, reference)
    totals = []
    for i, run in enumerate(runs):
        ended = run.result()
        for name, values in _series(system, ended, reached[i]).items():
            arrays[name][i, : reached[i]] = values
        totals.append(_totals(plan, system, ended))
        if system.driven:
            for name, values in _intervals(system, ended, reached[i]).items():
                empty = np.full((len(runs), len(times) - 1, *values.shape[1:]), math.nan)
                arrays.setdefault(PREFIX + name, empty)[i, : len(values)] = values
    arrays |= {name: np.array([total[name] for total in totals]) for name in totals[0]}
    return {**arrays, "start": digest(system)}


def _start(plan: Plan, model: str, system: ParticleSystem) -> Run:
    """The run of one model, not yet advanced."""
    output = Output(plan.samples, log=True)
    if model == NEWTON:
        steps = plan.engine == "steps"
        step = time_step.chosen(system, plan.law, RESTITUTION_ERROR, None) if steps else None
        return newton.start(plan.engine, system, NewtonSettings(plan.law), plan.until, output, step)
    rule = RULES[model]
    parameters = dict.fromkeys(rule.parameters, plan.contact_duration)
    if "restitution" in rule.takes:
        friction = plan.law.friction if rubs(plan.law) else None
        rubbing = () if friction is None else (friction.coefficient, plan.tangential_restitution)
        settings = Settings(model, plan.restitution, None, parameters, *rubbing)
    else:
        settings = Settings(model, None, plan.law, parameters)
    return hard_spheres.start(system, settings, hard_spheres.End(plan.until, None), output)


def _series(system: ParticleSystem, ended: Any, reached: int) -> dict[str, Floats]:
    """Temperature, cooling, and means since the start, of the samples that were reached."""
    samples = Samples(system, {name: values[:reached] for name, values in ended.samples.items()})
    lost, passed = samples["dissipated_energy"], samples["time"] - samples["time"][0]
    lost = np.where(np.abs(lost) <= ROUNDING * system.kinetic_energy, 0.0, lost)
    lasted = np.diff(passed)
    rotates = "rotational_energy" in samples
    means = {
        "granular_temperature": samples["granular_temperature"],
        "cooling": _cooling(system, lost, rotates),
    }
    if rotates:
        means[ROTATION.name] = ROTATION.values(samples)
    with np.errstate(invalid="ignore", divide="ignore"):
        means["dissipation_rate"] = lost / passed
        for name in ("collision_rate", "pressure", *(OF_SHEAR if system.shear_rate else ())):
            means[name] = np.append(0.0, np.cumsum(OBSERVABLES[name].values(samples)[1:] * lasted)) / passed
    return means


def _intervals(system: ParticleSystem, ended: Any, reached: int) -> dict[str, Floats]:
    """The observables of the intervals between the samples that were reached."""
    samples = Samples(system, {name: values[:reached] for name, values in ended.samples.items()})
    shared = [*(INTERVALS.keys() & OBSERVABLES.keys()), *(OF_SHEAR if system.shear_rate else ())]
    rates = {name: OBSERVABLES[name].values(samples)[1:] for name in shared}
    rates["driving_power"] = np.sum([samples.rate(name) for name in INTERVALS["driving_power"].needs], axis=0)
    return rates


def _cooling(system: ParticleSystem, lost: Floats, rotates: bool = False) -> Floats:
    """√(E(0)/E) − 1; NaN under gravity and in driven boxes.

    E is the kinetic energy; without walls, that relative to the centre of mass; with friction also that of rotation.
    """
    if system.gravity.any() or system.driven:
        return np.full(len(lost), math.nan)
    at_start = system.kinetic_energy
    if "wall" not in system.boundary:
        at_start = 0.5 * system.dimension * float(system.mass.sum()) * system.granular_temperature
    at_start += system.rotational_energy if rotates else 0.0
    left = at_start - lost
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(left > 0.0, np.sqrt(at_start / left) - 1.0, math.nan)


def _totals(plan: Plan, system: ParticleSystem, ended: Any) -> dict[str, Any]:
    """Statistics of the contacts, and how the run ended."""
    if isinstance(ended, ContactResult):
        assert ended.n_contacts is not None  # both of our engines count them
        overlaps, count = contacts.of_newton(ended), ended.n_contacts
    else:
        overlaps, count = contacts.of_hard_spheres(system, plan.law, ended), ended.n_collisions
    return {
        "overlapped_share": overlaps.overlapped_share,
        "median_restitution": overlaps.median,
        "restitution_share": overlaps.histogram,
        "n_contacts": float(count),
        "largest_compression": math.nan if ended.largest_compression is None else ended.largest_compression,
        "end_time": ended.time,
        "outcome": float(ended.outcome_code),
    }
