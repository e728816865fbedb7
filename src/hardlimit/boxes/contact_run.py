"""How a run under Newton's equations goes on: samples equally spaced in time, the log, checkpoints, the end."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from .. import _core
from ..contact import compression
from ..contact.contact import Law
from ..support import validation
from ..support.progress import Report, Shown
from . import checkpoint, early_end, engines
from .contact_result import COLUMNS, LOG, ContactResult
from .pace import Pace
from .softness import refuse_too_soft
from .system import Floats, ParticleSystem

#: In the header of a checkpoint.
KIND: Final = "molecular_dynamics"
ENGINES: Final = {"events": "newton_events", "steps": "newton_steps"}

#: Of one run; so many can be counted.
MOST_STEPS: Final = 2**53
#: What an engine knows of itself.
STEPS: Final = ("time_step", "n_steps")
CLUSTERS: Final = ("largest_cluster", "cluster_share")

Log = engines.Log


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
    reason: str = ""  #: for the engine, unless it was asked for

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
        self._pace = Pace()

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
        for _ in self.steps(report):
            pass
        found = self.result()
        compression.warn(found.largest_compression)
        return found

    def steps(self, report: Report) -> Iterator[float]:
        """To the end, with a stop at every sample; yields its time [s]."""
        try:
            self._sample()
            yield self.engine.time
            while self.engine.outcome == "ok" and self.engine.time < self.target.until:
                self._advance(self.target.after(self.engine.time), report)
                self._sample()
                yield self.engine.time
            self.save()
        except KeyboardInterrupt:
            log = self._joined_log()
            if log is None or len(log[0]) == self._logged():  # no row was lost on its way here
                self.save()
            raise

    def _advance(self, at: float, report: Report) -> None:
        while self.engine.outcome == "ok" and (self.engine.time < at or self.engine.paused):
            begun = clock.monotonic()
            self.engine.advance(at, self._portion, self.settings.threads)
            took = clock.monotonic() - begun
            self._portion = engines.pace(self._portion, took)
            if clock.monotonic() - self._saved_at > self.settings.every:
                self.save()
            self._report(report)

    def _report(self, report: Report) -> None:
        """Steps, or contacts, so far and how many there will be; contacts if they go on at the same rate."""
        time, end = self.engine.time, self.target.until
        if self.settings.takes_steps:
            left = math.ceil((end - time) / self.engine.statistics()["time_step"])
            report(self.engine.work, self.engine.work + left)
        else:
            done = self.engine.n_contacts
            report(done, max(done, 1, round(done * (end / time)) if time > 0.0 else 0))
            if isinstance(report, Shown):
                report.note = self._pace.note(self.system, self.settings.law, self.engine, end)

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
        values = {**engines.observed(self.system, self.engine), "time": self.engine.time}
        return tuple(float(values[name]) for name in COLUMNS)

    def _logged(self) -> int:
        """Rows of the log that the engine has made."""
        return int(self.engine.n_logged)

    def _joined_log(self) -> Log | None:
        """Contacts that have ended, in the order of their ends."""
        if self._log is None:
            return None
        self._log = [engines.joined([*self._log, tuple(self.engine.take_log().values())])]
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
        header = {
            "kind": KIND,
            "engine": self.settings.engine,
            "engine_reason": self.settings.reason,
            "law": engines.law_entry(self.settings.law),
            "boundary": list(self.system.boundary),
            "target": vars(self.target),
            "threads": self.settings.threads,
            "every": self.settings.every,
        }
        rows = np.array(self._rows).reshape(-1, len(COLUMNS))
        arrays = engines.kept(self.system, self.engine, rows, self._joined_log())
        checkpoint.write(self.settings.path, header, arrays)
        self._saved_at = clock.monotonic()

    # --- results --------------------------------------------------------------------------------------------

    def result(self) -> ContactResult:
        """What has come out so far."""
        log = self._joined_log()
        if log is not None:
            log = engines.joined([log, tuple(self.engine.open_contacts().values())])
            order = np.argsort(log[0], kind="stable")
            *numbers, overlapped = (part[order] for part in log)
            log = (*numbers, overlapped.astype(bool))
        seen, counts = self.engine.observe(), ("n_contacts", "n_pairs", "n_ended", "n_overlapped")
        special = STEPS if self.settings.takes_steps else CLUSTERS
        now, of_engine = engines.present(self.system, self.engine), self.engine.statistics()
        return ContactResult(
            system=now,
            law=self.settings.law,
            engine=self.settings.engine,
            engine_reason=self.settings.reason,
            outcome_name=self.engine.outcome,
            rows=np.array(self._rows),
            log=log,
            time=self.engine.time,
            largest_compression=seen["largest_compression"],
            early_end=early_end.of_engine(self.engine, now),
            **{name: seen[name] for name in counts},
            **{name: of_engine[name] for name in special},
        )


def start(
    system: ParticleSystem, settings: Settings, time_step: float | None, target: Target, log: bool
) -> ContactCourse:
    """A run at its beginning; the other arguments are checked.

    Raises
    ------
    ValueError
        If contacts under the law would be too deep, or there would be more steps than can be counted.
    """
    refuse_too_soft(system, settings.law)
    if time_step is not None and not target.until / time_step <= MOST_STEPS:
        raise ValueError(
            f"time_step: got {time_step:.6g} s, must be >= {validation.at_least(target.until / MOST_STEPS)} s, "
            f"with which {target.until:.6g} s take {MOST_STEPS:.0e} steps"
        )
    engine = _core.make_engine(
        ENGINES[settings.engine],
        *engines.engine_arguments(system),
        law=engines.choice(settings.law),
        time_step=time_step or 0.0,
        log=log,
    )
    rows = tuple(engine.take_log().values()) if log else None
    return ContactCourse(system, settings, engine, target, log=rows)


def load(path: Any) -> ContactCourse:
    """The run that a checkpoint holds.

    Raises
    ------
    ValueError
        If the file cannot be read, is no checkpoint or damaged; names it.
    """
    header, arrays = checkpoint.read(path)
    try:
        law = engines.law_of(header["law"])
        settings = Settings(
            law,
            header["engine"],
            int(header["threads"]),
            Path(path),
            float(header["every"]),
            header["engine_reason"],
        )
        engine = _core.load_engine(ENGINES[settings.engine], arrays["engine"].tobytes())
        system = engines.system_in(header, arrays, engine)
        log = engines.log_in(arrays, len(LOG))
        target = Target(**header["target"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: no checkpoint, or damaged: {error}") from None
    return ContactCourse(system, settings, engine, target, arrays["rows"], log)
