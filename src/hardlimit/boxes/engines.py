"""Engines for boxes of grains: a record for each, and the interface through which a run uses an engine."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact.contact import Law
from .box import Floats
from .contacts import law_arguments
from .falling_frame import engine_arguments, laboratory_sums, spin_arguments, state, system_at
from .observe import Observed
from .pace import ProgressNote
from .result import COLLISIONS, CONTACTS, RUBBING, Column, ContactResult, EarlyEnd, Log, ParticleResult
from .rules import Settings, law_entry, law_from
from .spins import AXES_OF_ROTATION
from .system import ParticleSystem
from .thermostats import Andersen, refuse_rotational


def _sampled(engines: str) -> tuple[str, ...]:
    """The quantities at the samples of all engines and of these, from the core's table."""
    fields = (field["name"] for field in _core.observed_fields if field["engines"] in ("all", engines))
    return ("time", "granular_temperature", "heat", *fields)


#: Quantities at the samples of hard spheres, of our engines for Newton's equations, and of LAMMPS.
OF_COLLISIONS: Final = (*_sampled("collisions"), "n_collisions")
OF_CONTACTS: Final = _sampled("contacts")
OF_LAMMPS: Final = (
    *("time", "kinetic_energy", "potential_energy", "dissipated_energy", "granular_temperature", "momentum"),
    *("kinetic_tensor", "virial_tensor", "n_pairs", "flow_momentum", "shear_work", "contact_energy"),
    *("n_contacts", "n_ended", "n_overlapped", "n_in_contact"),
    *("rotational_energy", "tangential_energy", "spin"),
)
#: Arrays of a system in a checkpoint. Positions and velocities are in the saved state of the engine.
FIXED: Final = ("radius", "mass", "box", "gravity")
#: The same of a system with spins. Those of an engine with friction are in its saved state.
SPINS: Final = ("angular_velocities", "inertia_factor")


@dataclass(frozen=True)
class EngineRecord:
    """Properties of an engine for boxes."""

    name: str  #: as in ``engine=`` of molecular_dynamics and in checkpoints
    kind: str  #: name in the core; empty for an external program
    task: str  #: title of the progress bar
    counts: str  #: unit of the progress bar
    records: tuple[str, ...] = OF_CONTACTS  #: quantities at a sample; observables are made from them
    columns: tuple[Column, ...] = CONTACTS  #: columns of the log
    options: tuple[str, ...] = ()  #: arguments of molecular_dynamics that some engines do not accept


_NEWTON: Final = "molecular dynamics"
_OURS, _STEPS = ("checkpoint", "observe"), ("restitution_error", "time_step")  #: options
_RECORDS: Final = (
    EngineRecord("hard_spheres", "hard_spheres", "event-driven", "collisions", OF_COLLISIONS, COLLISIONS),
    EngineRecord("events", "newton_events", _NEWTON, "contacts", options=_OURS),
    EngineRecord("steps", "newton_steps", _NEWTON, "steps", options=(*_OURS, *_STEPS, "threads")),
    EngineRecord("lammps", "", _NEWTON, "steps", OF_LAMMPS, options=(*_STEPS, "ranks")),
)
#: Engines by name.
ENGINES: Final = {record.name: record for record in _RECORDS}
#: Names of the engines for Newton's equations.
NEWTON: Final = tuple(record.name for record in _RECORDS if record.task == _NEWTON)


@dataclass(frozen=True)
class NewtonSettings:
    """Settings of an engine for Newton's equations."""

    law: Law
    threads: int = 1
    reason: str = ""  #: why ``"auto"`` chose this engine; empty if the user chose it

    def entry(self) -> dict[str, Any]:
        """For a JSON file."""
        return vars(self) | {"law": law_entry(self.law)}

    @classmethod
    def from_entry(cls, entry: Mapping[str, Any]) -> NewtonSettings:
        """The settings from :meth:`entry`."""
        return cls(**{**entry, "law": law_from(entry["law"])})


class Field(NamedTuple):
    """A quantity among the numbers of a sample."""

    numbers: slice
    shape: tuple[int, ...]


class Engine:
    """A compiled engine that simulates a system."""

    def __init__(
        self,
        name: str,
        system: ParticleSystem,
        settings: Settings | NewtonSettings,
        compiled: Any,
        moment: Floats,
    ) -> None:
        self.record, self.system, self.settings, self.compiled = ENGINES[name], system, settings, compiled
        self._moment = moment  #: Σ m x at the start of the run [kg m]
        self._note = ProgressNote()
        self._latest = system.domain.resolved_until

    @classmethod
    def make(
        cls,
        name: str,
        system: ParticleSystem,
        settings: Settings | NewtonSettings,
        log: bool,
        time_step: float | None = None,
    ) -> Engine:
        """Make the engine for the start of a run."""
        if isinstance(system.thermostat, Andersen) and system.domain.common_fall.any():
            raise ValueError(
                "thermostat: got Andersen, must be RandomKicks or None with gravity along a periodic axis"
            )
        own: dict[str, Any] = {} if settings.law is None else {"law": law_arguments(settings.law)}
        if isinstance(settings, Settings):
            own["rule"] = settings.rule
            own["restitution"] = math.nan if settings.restitution is None else settings.restitution
            if settings.friction is not None:
                own["friction"] = settings.friction
                own["tangential_restitution"] = settings.tangential_restitution
            own["rule_parameters"] = list(settings.parameters.values())
        if time_step is not None:
            own["time_step"] = time_step
        own |= spin_arguments(system)
        compiled = _core.make_engine(ENGINES[name].kind, *engine_arguments(system), log=log, **own)
        if not compiled.rotates:
            refuse_rotational(system.thermostat)
        return cls(name, system, settings, compiled, system.mass @ system.positions)

    # --- running --------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Current time [s]."""
        return float(self.compiled.time)

    @property
    def outcome(self) -> str:
        """``"ok"``, or the name of the reason why the run cannot continue."""
        outcome = str(self.compiled.outcome)
        return "unresolved" if outcome == "ok" and self.time >= self._latest else outcome

    @property
    def paused(self) -> bool:
        """Whether the engine has stopped within an event or a step, where no sample can be taken."""
        return bool(self.record.name != "hard_spheres" and self.compiled.paused)

    def has_reached(self, time: float) -> bool:
        """Whether all that happens up to ``time`` [s] has happened."""
        now = self.time
        return now >= time and not self.compiled.paused and now < self._next_kick()

    @property
    def n_contacts(self) -> int:
        """Number of collisions, or of contacts that have begun."""
        return int(self.compiled.n_contacts)

    @property
    def kicks(self) -> int:
        """Number of kicks of the thermostat so far."""
        return int(self.compiled.n_kicks)

    def advance(self, until: float, work: int) -> None:
        """Advance to ``until`` [s], or by ``work`` collisions, events or steps, whichever comes first.

        A kick of the thermostat counts as one of these for each particle.
        """
        threads = self.settings.threads if isinstance(self.settings, NewtonSettings) else 1
        last = self.compiled.work + work
        while self.outcome == "ok":
            kick = self._next_kick()
            self.compiled.advance(min(until, kick, self._latest), max(last - self.compiled.work, 1), threads)
            if self.compiled.paused or self.time < kick or self.outcome != "ok":
                return
            self._kick()
            last -= self.system.n
            if self.time >= until or self.compiled.work >= last:
                return

    def _next_kick(self) -> float:
        """Time of the next kick of the thermostat [s]; infinite without one."""
        thermostat = self.system.thermostat
        return math.inf if thermostat is None else thermostat.time(self.kicks + 1)

    def _kick(self) -> None:
        # Contiguous arrays and no BLAS: sums have the same bits after a checkpoint.
        thermostat, mass = self.system.thermostat, np.ascontiguousarray(self.system.mass)
        assert thermostat is not None
        positions, unfolded = map(np.asarray, self.compiled.state())
        before = unfolded.copy()
        self.system.domain.fold(positions, before, self.time)
        after = np.ascontiguousarray(thermostat.velocities(self.kicks + 1, before, mass))
        heat = 0.5 * float((mass[:, None] * ((after - before) * (after + before))).sum())
        turning = None
        if thermostat.rotational is not None:
            turning, gained = self._turned(thermostat, mass)
            heat += gained
        self.compiled.kick(after + (unfolded - before), heat, turning)

    def _turned(self, thermostat: Any, mass: Floats) -> tuple[Floats, float]:
        """Spins of the core after the next kick, and the energy that they gain [J]."""
        inertia, axes = np.ascontiguousarray(self.system.inertia), AXES_OF_ROTATION[self.system.dimension]
        rows = np.asarray(self.compiled.spins())
        before = rows[:, 3 - axes :].copy()
        turning = thermostat.spins(self.kicks + 1, before, inertia, mass)
        rows[:, 3 - axes :] = turning
        return rows, 0.5 * float((inertia[:, None] * ((turning - before) * (turning + before))).sum())

    def done_and_total(self, until: float | None, max_collisions: int | None) -> tuple[int, int]:
        """Progress: number of collisions, contacts or steps so far, and their expected total at this rate."""
        if self.record.name == "steps":
            assert until is not None
            statistics = self.compiled.statistics()
            return statistics["n_steps"], statistics["n_steps"] + math.ceil(
                (until - self.time) / statistics["time_step"]
            )
        done, expected = self.n_contacts + self.kicks, math.inf
        if until is not None and self.time > 0.0:
            expected = done * (until / self.time)
        if max_collisions is not None:
            expected = min(expected, max_collisions + self.kicks)
        return done, max(done, 1, round(expected) if expected < 2**53 else 0)

    def note(self, until: float | None) -> str:
        """Text beside the progress bar."""
        if self.record.name != "events" or until is None or self.settings.law is None:
            return ""
        cluster_share = float(self.compiled.statistics()["cluster_share"])
        return self._note.note(self.time, cluster_share, self.settings.law, self.current, until)

    # --- state and records ----------------------------------------------------------------------------------

    def state(self) -> tuple[Floats, Floats]:
        """Current unfolded positions [m] and velocities [m/s], (N, d) each."""
        return state(self.system, self.time, self.compiled.state())

    def current(self) -> ParticleSystem:
        """The current system, with positions in the box."""
        spin = self.compiled.spins() if self.compiled.rotates else None
        now = system_at(self.system, self.time, self.compiled.state(), spin)
        if now.thermostat is None:
            return now
        values = now._values() | {"thermostat": now.thermostat.after(self.kicks)}
        return now._of(**values, _unfolded=now._unfolded)

    @functools.cached_property
    def fields(self) -> dict[str, Field]:
        """The quantities of a sample by name."""
        fields, begin = {}, 0
        for name, shape in self.compiled.sample_fields():
            fields[name] = Field(slice(begin, begin + math.prod(shape)), shape)
            begin = fields[name].numbers.stop
        return fields

    def sample(self) -> Floats:
        """The numbers of a sample, as in ``fields``, in the falling frame; :meth:`result` converts those of all
        samples at once."""
        return np.asarray(self.compiled.sample())

    def number(self, name: str, sample: Floats) -> float:
        """A quantity of a sample that is one number."""
        return float(sample[self.fields[name].numbers.start])

    def by_name(self, samples: Sequence[Floats]) -> dict[str, Floats]:
        """All samples: one array for each quantity."""
        n = len(samples)
        rows = np.array(samples).T  # one for each number
        fields = self.fields.items() if n else ()
        return {name: np.ascontiguousarray(rows[f.numbers].T).reshape(n, *f.shape) for name, f in fields}

    def samples_from(self, arrays: Mapping[str, NDArray[Any]]) -> list[Floats]:
        """The inverse of :meth:`by_name`."""
        n = len(arrays["time"]) if arrays else 0
        return list(np.hstack([arrays[name].reshape(n, -1) for name in self.fields])) if n else []

    def is_at(self, sample: Floats) -> bool:
        """Whether this sample was taken in the current state, or no sample can be taken in it."""
        counts = self.n_contacts
        counted = self.number("n_collisions", sample) if "n_collisions" in self.fields else counts
        return self.paused or bool(self.number("time", sample) == self.time and counted == counts)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the log."""
        return (*self.record.columns, *(RUBBING if self.compiled.rotates else ()))

    @property
    def n_logged(self) -> int:
        """Number of rows of the log so far."""
        return int(self.compiled.n_logged)

    def take_log(self) -> Log:
        """Remove and return the rows of the log since the last call."""
        return self._columns(self.compiled.take_log())

    def whole_log(self, taken: Log) -> Log:
        """The complete log in order of time: the rows taken so far and the open contacts."""
        if self.record.name == "hard_spheres":
            log = taken
        else:
            rows = joined([taken, self._columns(self.compiled.open_contacts())])
            order = np.argsort(rows[0], kind="stable")
            log = tuple(part[order] for part in rows)
        return tuple(part.astype(bool) if part.dtype == np.uint8 else part for part in log)

    def _columns(self, log: Mapping[str, NDArray[Any]]) -> Log:
        return tuple(log[column.name] for column in self.columns)

    def early_end(self, now: ParticleSystem) -> EarlyEnd | None:
        """The event that ended the run early, or None; ``now`` is the current system."""
        if self.compiled.early_end is None:
            return None
        time, particles, wall = self.compiled.early_end
        return EarlyEnd(time, tuple(now.positions[particles[0]].tolist()), tuple(particles), wall)

    def result(
        self, samples: Mapping[str, Floats], log: Log | None, observed: Observed, idle: bool
    ) -> ParticleResult | ContactResult:
        """The result of a run that ends now, from all its samples; ``idle`` means that no more collisions happen."""
        now, sums, statistics = self.current(), self.compiled.observe(), self.compiled.statistics()
        largest = float(self.compiled.largest_compression)
        common: dict[str, Any] = {
            "system": now,
            "time": self.time,
            "outcome_name": "no_contact" if idle and self.outcome == "ok" else self.outcome,
            "samples": self._in_laboratory(samples),
            "log": None if log is None else self.whole_log(log),
            "largest_compression": None if math.isnan(largest) else largest,
            "early_end": self.early_end(now),
            "observed": observed,
        }
        if isinstance(self.settings, Settings):
            counts = ("n_walls", "n_elastic_by_tc", "n_soft", "n_soft_third_body")
            return ParticleResult(
                settings=self.settings,
                n_collisions=sums["n_contacts"],
                n_pairs=sums["n_pairs"],
                **{name: statistics[name] for name in counts},
                **common,
            )
        own = ("time_step", "n_steps", "largest_cluster", "cluster_share")
        return ContactResult(
            law=self.settings.law,
            engine=self.record.name,
            engine_reason=self.settings.reason,
            **{name: sums[name] for name in ("n_contacts", "n_pairs", "n_ended", "n_overlapped")},
            **{name: statistics[name] for name in own if name in statistics},
            **common,
        )

    def _in_laboratory(self, samples: Mapping[str, Floats]) -> dict[str, Floats]:
        """The samples in the laboratory. The momentum is constant along the axes of the common fall."""
        moment = self._moment + samples["time"][:, None] * samples["momentum"]
        potential = samples["potential_energy"] - moment @ self.system.domain.common_fall
        return laboratory_sums(self.system, samples["time"], {**samples, "potential_energy": potential})

    # --- checkpoints ----------------------------------------------------------------------------------------

    def saved(self) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        header = {
            "engine": self.record.name,
            **self.system.entries(),
            "kicks": [self.kicks, self.compiled.heat],
            "settings": self.settings.entry(),
        }
        names = FIXED if self.system.inertia_factor is None else FIXED + SPINS
        arrays = {name: np.asarray(getattr(self.system, name)) for name in names}
        arrays["moment"] = self._moment
        return header, arrays | {"engine": np.frombuffer(self.compiled.save(), np.uint8)}

    @classmethod
    def load(cls, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> Engine:
        """The engine of a checkpoint. Raises KeyError, TypeError or ValueError if an entry is missing or damaged."""
        name = header["engine"]
        kind: type[Settings | NewtonSettings] = Settings if name == "hard_spheres" else NewtonSettings
        settings = kind.from_entry(header["settings"])
        kicks, heat = int(header["kicks"][0]), float(header["kicks"][1])
        compiled = _core.load_engine(ENGINES[name].kind, arrays["engine"].tobytes(), kicks, heat)
        positions, velocities = compiled.state()
        fixed = {key: arrays[key] for key in FIXED + SPINS if key in arrays or key in FIXED}
        falling = ParticleSystem.from_entries(header, positions=positions, velocities=velocities, **fixed)
        positions, velocities = state(falling, compiled.time, compiled.state())
        return cls(name, falling._moved(positions, velocities), settings, compiled, arrays["moment"])


def joined(parts: Sequence[Log]) -> Log:
    return tuple(np.concatenate(columns) for columns in zip(*parts, strict=True))
