"""How a run under Newton's equations goes on: samples equally spaced in time, the log, checkpoints, the end."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact import Law
from ..laws import LAWS
from ..progress import Report
from . import checkpoint
from .contact_result import COLUMNS, LOG, ContactResult
from .course import folded
from .system import Floats, ParticleSystem

#: Seconds [wall clock] for which the engine runs at a time, between looks at the checkpoint and the progress.
PORTION: Final = 0.2
#: In the header of a checkpoint.
KIND: Final = "molecular_dynamics"
ENGINES: Final[dict[str, Any]] = {"events": _core.NewtonEvents, "steps": _core.NewtonSteps}

#: What an engine knows of itself.
STEPS: Final = ("time_step", "n_steps")
CLUSTERS: Final = ("largest_cluster", "cluster_share")

Log = tuple[NDArray[Any], ...]


@dataclass(frozen=True)
class Target:
    """Where a run ends, and when it is sampled: at the times span·(k/samples), and at the end."""

    until: float  #: [s]
    span: float  #: [s]
    samples: int

    def time(self, k: int) -> float:
        """Of sample k."""
        return self.span * (k / self.samples)

    def after(self, time: float) -> float:
        """Of the first sample after ``time``."""
        k = math.floor(self.samples * (time / self.span)) if self.span > 0.0 else 0
        while self.time(k) <= time < self.until:
            k += 1
        return min(self.time(k), self.until)


@dataclass(frozen=True)
class Settings:
    """What a run does beside its system and its end."""

    law: Law
    engine: str
    threads: int
    path: Path | None = None  #: of the checkpoint
    every: float = math.inf  #: seconds between two checkpoints [wall clock]

    @property
    def takes_steps(self) -> bool:
        """Of equal size, and on several threads."""
        return self.engine == "steps"


class ContactCourse:
    """One run under way. Whatever interrupts it between two statements, what it holds goes together."""

    def __init__(
        self,
        system: ParticleSystem,
        settings: Settings,
        engine: Any,
        target: Target,
        rows: Floats | None = None,
        log: Log | None = None,
    ) -> None:
        self.system, self.settings, self.engine, self.target = system, settings, engine, target
        self._rows: list[tuple[float, ...]] = [] if rows is None else [tuple(row) for row in rows.tolist()]
        self._log = None if log is None else [log]
        self._portion = 100
        self._saved_at = clock.monotonic()

    def set_end(self, until: float) -> None:
        """Go on to another end; the spacing of the samples stays."""
        self.target = replace(self.target, until=until)

    # --- the run --------------------------------------------------------------------------------------------

    def run(self, report: Report) -> ContactResult:
        """To the end.

        Raises
        ------
        KeyboardInterrupt
            At Ctrl-C, once the checkpoint is written if there is one.
        """
        try:
            self._sample()
            while self.engine.outcome == "ok" and self.engine.time < self.target.until:
                self._advance(self.target.after(self.engine.time), report)
                self._sample()
            self.save()
        except KeyboardInterrupt:
            log = self._joined_log()
            if log is None or len(log[0]) == self._logged():  # no row was lost on its way here
                self.save()
            raise
        return self.result()

    def _advance(self, at: float, report: Report) -> None:
        while self.engine.outcome == "ok" and (self.engine.time < at or self.engine.paused):
            begun = clock.monotonic()
            if self.settings.takes_steps:
                self.engine.advance(at, self.settings.threads, self._portion)
            else:
                self.engine.advance(at, self._portion)
            took = clock.monotonic() - begun
            if took < 0.5 * PORTION:
                self._portion = min(2 * self._portion, 2**40)
            elif took > 2.0 * PORTION:
                self._portion = max(self._portion // 2, 1)
            if clock.monotonic() - self._saved_at > self.settings.every:
                self.save()
            self._report(report)

    def _report(self, report: Report) -> None:
        """Steps, or contacts, so far and how many there will be; contacts if they go on at the same rate."""
        time, end = self.engine.time, self.target.until
        if self.settings.takes_steps:
            left = math.ceil((end - time) / self.engine.time_step)
            report(self.engine.n_steps, self.engine.n_steps + left)
        else:
            done = self.engine.contacts_reached
            report(done, max(done, 1, round(done * (end / time)) if time > 0.0 else 0))

    # --- what is kept ---------------------------------------------------------------------------------------

    def _sample(self) -> None:
        """One more sample, unless there is one of this time, or the engine pauses between two of them."""
        if self.engine.paused or (self._rows and self._rows[-1][0] == self.engine.time):
            return
        self._rows = [*self._rows, self._row()]
        if len(self._rows) == 1:
            self.save()

    def _row(self) -> tuple[float, ...]:
        """The sums of ``COLUMNS`` now."""
        seen = self.engine.observe()
        mass, kinetic = float(self.system.mass.sum()), float(seen["kinetic_energy"])
        momentum = np.asarray(seen["momentum"])
        temperature = (2.0 * kinetic - float(momentum @ momentum) / mass) / (self.system.dimension * mass)
        values = {**seen, "granular_temperature": max(temperature, 0.0), "time": self.engine.time}
        return tuple(float(values[name]) for name in COLUMNS)

    def _logged(self) -> int:
        """Rows of the log that the engine has made."""
        return int(self.engine.n_ended if self.settings.takes_steps else self.engine.n_logged)

    def _joined_log(self) -> Log | None:
        """Contacts that have ended, in the order of their ends."""
        if self._log is None:
            return None
        self._log = [_joined([*self._log, self.engine.take_log()])]
        return self._log[0]

    def save(self) -> None:
        """Write the checkpoint, if there is to be one.

        Raises
        ------
        OSError
            If it cannot be written; names it.
        """
        if self.settings.path is None:
            return
        law = self.settings.law
        log = self._joined_log()
        header = {
            "kind": KIND,
            "engine": self.settings.engine,
            "law": [law.record["name"], dict(law.parameters)],
            "boundary": list(self.system.boundary),
            "target": vars(self.target),
            "threads": self.settings.threads,
            "every": self.settings.every,
        }
        arrays = {
            name: np.asarray(getattr(self.system, name)) for name in ("radius", "mass", "box", "gravity")
        }
        arrays["engine"] = np.frombuffer(self.engine.save(), np.uint8)
        arrays["rows"] = np.array(self._rows).reshape(-1, len(COLUMNS))
        if log is not None:
            arrays |= {f"log_{i}": part for i, part in enumerate(log)}
        checkpoint.write(self.settings.path, header, arrays)
        self._saved_at = clock.monotonic()

    # --- results --------------------------------------------------------------------------------------------

    def result(self) -> ContactResult:
        """What has come out so far."""
        log = self._joined_log()
        if log is not None:
            log = _joined([log, self.engine.open_contacts()])
            order = np.argsort(log[0], kind="stable")
            *numbers, overlapped = (part[order] for part in log)
            log = (*numbers, overlapped.astype(bool))
        seen, counts = self.engine.observe(), ("n_contacts", "n_pairs", "n_ended", "n_overlapped")
        special = STEPS if self.settings.takes_steps else CLUSTERS
        return ContactResult(
            system=_moved(self.system, self.engine),
            law=self.settings.law,
            engine=self.settings.engine,
            outcome_name=self.engine.outcome,
            rows=np.array(self._rows),
            log=log,
            time=self.engine.time,
            **{name: seen[name] for name in counts},
            **{name: getattr(self.engine, name) for name in special},
        )


def _joined(parts: list[Log]) -> Log:
    return tuple(np.concatenate([part[i] for part in parts]) for i in range(len(LOG)))


def _moved(system: ParticleSystem, engine: Any) -> ParticleSystem:
    """The system now, inside the box."""
    positions, velocities = engine.state()
    return ParticleSystem._of(
        positions=folded(positions, system),
        velocities=velocities,
        radius=system.radius,
        mass=system.mass,
        box=system.box,
        boundary=system.boundary,
        gravity=system.gravity,
    )


def start(
    system: ParticleSystem, settings: Settings, time_step: float | None, target: Target, log: bool
) -> ContactCourse:
    """A run at its beginning; the arguments are checked."""
    law = settings.law
    engine = ENGINES[settings.engine](
        system.positions,
        system.velocities,
        np.ascontiguousarray(system.radius),
        np.ascontiguousarray(system.mass),
        system.box.tolist(),
        [side == "periodic" for side in system.boundary],
        system.gravity.tolist(),
        (law.record["name"], law.alternative, list(law.parameters.values())),
        *([time_step] if settings.takes_steps else []),
        log,
    )
    return ContactCourse(system, settings, engine, target, log=engine.take_log() if log else None)


def load(path: Any) -> ContactCourse:
    """The run that a checkpoint holds.

    Raises
    ------
    ValueError
        If the file cannot be read, is no checkpoint or damaged; names it.
    """
    header, arrays = checkpoint.read(path)
    try:
        law = LAWS[header["law"][0]](**header["law"][1])
        settings = Settings(law, header["engine"], int(header["threads"]), Path(path), float(header["every"]))
        engine = ENGINES[settings.engine].load(arrays["engine"].tobytes())
        positions, velocities = engine.state()
        system = ParticleSystem._of(
            positions=positions,
            velocities=velocities,
            boundary=tuple(header["boundary"]),
            **{name: arrays[name] for name in ("radius", "mass", "box", "gravity")},
        )
        log = tuple(arrays[f"log_{i}"] for i in range(len(LOG))) if "log_0" in arrays else None
        target = Target(**header["target"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: no checkpoint, or damaged: {error}") from None
    return ContactCourse(system, settings, engine, target, arrays["rows"], log)
