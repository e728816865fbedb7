"""How a run goes on: samples equally spaced in time, the log, checkpoints, the end."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact import compression
from ..support.progress import Report
from . import checkpoint, early_end, engines
from .result import COLUMNS, ParticleResult, Settings
from .system import Floats, ParticleSystem

#: Times that the spacing of the samples may double without a collision before nothing is taken to collide any more.
PATIENCE: Final = 20


@dataclass(frozen=True)
class Target:
    """Where a run ends, and when it is sampled: at the times span·(k/samples)."""

    until: float | None  #: [s]
    max_collisions: int | None
    span: float  #: [s]
    samples: int
    idle: int = 0  #: times that the spacing has doubled since the last collision

    @property
    def open_ended(self) -> bool:
        """Whether the samples must find their spacing on the way."""
        return self.until is None

    def time(self, k: int) -> float:
        """Of sample k."""
        return self.span * (k / self.samples)


class Course:
    """One run under way. Whatever interrupts it between two statements, what it holds goes together."""

    def __init__(
        self,
        system: ParticleSystem,
        settings: Settings,
        engine: Any,
        target: Target,
        *,
        rows: Floats | None = None,
        log: tuple[NDArray[Any], ...] | None = None,
        path: Path | None = None,
        every: float = math.inf,
    ) -> None:
        self.system, self.settings, self.engine = system, settings, engine
        self.path, self.every = path, every
        self._log = None if log is None else [log]
        self._portion = 1000
        self._saved_at = clock.monotonic()
        # Samples and the target they were taken for: thinning out replaces both at once.
        self._sampled: tuple[list[tuple[float, ...]], Target] = (
            [] if rows is None else [tuple(row) for row in rows.tolist()],
            target,
        )

    @property
    def target(self) -> Target:
        """Where the run ends."""
        return self._sampled[1]

    def set_end(self, until: float | None, max_collisions: int | None) -> None:
        """Go on to another end; the spacing of the samples stays."""
        rows, target = self._sampled
        self._sampled = rows, replace(target, until=until, max_collisions=max_collisions)

    # --- the run --------------------------------------------------------------------------------------------

    def run(self, report: Report) -> ParticleResult:
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
            while not (self._sampled[0] and self._over()):
                rows, target = self._sampled
                at = target.time(len(rows))
                if self.engine.time >= at or self._advance(at, report):
                    self._sample()
                    if self.path is not None and len(self._sampled[0]) == 1:
                        self.save()
                    yield self.engine.time
            if self.path is not None:
                self.save()
        except KeyboardInterrupt:
            if self.path is not None and self._whole():
                self.save()
            raise

    def _over(self) -> bool:
        target = self.target
        if self.engine.outcome != "ok" or self.target.idle > PATIENCE:
            return True
        if target.max_collisions is not None and self.engine.n_contacts >= target.max_collisions:
            return True
        return target.until is not None and self.engine.time >= target.until

    def _advance(self, at: float, report: Report) -> bool:
        """To a time or to the end of the run; whether that is the time and it belongs to the samples."""
        target = self.target
        stop = at if target.until is None else min(at, target.until)
        while self.engine.time < stop and not self._over():
            most = self._portion
            if target.max_collisions is not None:
                most = min(most, target.max_collisions - self.engine.n_contacts)
            begun = clock.monotonic()
            self.engine.advance(stop, most)
            self._keep_log()
            self._pace(clock.monotonic() - begun)
            self._report(report)
        return bool(self.engine.time == at and self.engine.outcome == "ok")

    def _pace(self, took: float) -> None:
        """Portions of about the same time; a checkpoint when it is due."""
        self._portion = engines.pace(self._portion, took)
        if self.path is not None and clock.monotonic() - self._saved_at > self.every:
            self.save()

    def _report(self, report: Report) -> None:
        """Collisions so far, and how many to expect in all if they go on at the same rate."""
        done, target = self.engine.n_contacts, self.target
        expected = math.inf
        if target.until is not None and self.engine.time > 0.0:
            expected = done * (target.until / self.engine.time)
        if target.max_collisions is not None:
            expected = min(expected, target.max_collisions)
        report(done, max(done, 1, round(expected) if expected < 2**53 else 0))

    # --- what is kept ---------------------------------------------------------------------------------------

    def _sample(self) -> None:
        """One more sample; every second one goes, and the spacing doubles, where an open end makes too many."""
        rows, target = self._sampled
        rows.append(self._row())
        if target.open_ended and len(rows) > 2 * target.samples:
            still = rows[-1][4] == rows[len(rows) // 2][4]
            idle = target.idle + 1 if still else 0
            self._sampled = rows[::2], replace(target, span=2.0 * target.span, idle=idle)

    def _row(self) -> tuple[float, ...]:
        """The sums of ``COLUMNS`` now."""
        values = {
            **engines.observed(self.system, self.engine),
            "time": self.engine.time,
            "n_collisions": self.engine.n_contacts,
        }
        return tuple(float(values[name]) for name in COLUMNS)

    def _keep_log(self) -> None:
        if self._log is not None:
            self._log.append(tuple(self.engine.take_log().values()))

    def _whole(self) -> bool:
        """Whether no row of the log was lost to an interrupt on its way."""
        kept = 0 if self._log is None else sum(len(part[0]) for part in self._log)
        if self._log is None or kept == self.engine.n_contacts:
            return True
        self._keep_log()
        return bool(sum(len(part[0]) for part in self._log) == self.engine.n_contacts)

    def _joined_log(self) -> tuple[NDArray[Any], ...] | None:
        if self._log is None:
            return None
        if len(self._log) != 1:
            self._log = [engines.joined(self._log)]
        return self._log[0]

    def save(self) -> None:
        """Write the checkpoint.

        Raises
        ------
        OSError
            If it cannot be written; names it.
        """
        assert self.path is not None
        rows, target = self._sampled
        settings, law = self.settings, self.settings.law
        header = {
            "rule": settings.rule,
            "restitution": settings.restitution,
            "contact_duration": settings.contact_duration,
            "law": engines.law_entry(law),
            "boundary": list(self.system.boundary),
            "target": vars(target),
            "every": self.every,
        }
        arrays = engines.kept(
            self.system, self.engine, np.array(rows).reshape(-1, len(COLUMNS)), self._joined_log()
        )
        checkpoint.write(self.path, header, arrays)
        self._saved_at = clock.monotonic()

    # --- results --------------------------------------------------------------------------------------------

    def current(self) -> ParticleSystem:
        """The system now, inside the box."""
        return engines.present(self.system, self.engine)

    def result(self) -> ParticleResult:
        """What has come out so far."""
        rows = self._sampled[0]
        if not rows or rows[-1][0] != self.engine.time or rows[-1][4] != self.engine.n_contacts:
            rows = [*rows, self._row()]
        now, seen, counts = self.current(), self.engine.observe(), self.engine.statistics()
        largest = seen["largest_compression"]
        idle = self.target.idle > PATIENCE and self.engine.outcome == "ok"
        return ParticleResult(
            system=now,
            time=self.engine.time,
            settings=self.settings,
            outcome_name="no_contact" if idle else self.engine.outcome,
            n_collisions=self.engine.n_contacts,
            n_pairs=seen["n_pairs"],
            n_walls=counts["n_walls"],
            n_elastic_by_tc=counts["n_elastic_by_tc"],
            n_soft=counts["n_soft"],
            n_soft_third_body=counts["n_soft_third_body"],
            largest_compression=None if math.isnan(largest) else largest,
            early_end=early_end.of_engine(self.engine, now),
            rows=np.array(rows),
            log=self._joined_log(),
        )


def engine_of(system: ParticleSystem, settings: Settings, log: bool) -> Any:
    """The compiled engine with the system in it."""
    law = settings.law
    tc = settings.contact_duration
    return _core.make_engine(
        "hard_spheres",
        *engines.engine_arguments(system),
        law=None if law is None else engines.choice(law),
        rule=settings.rule,
        restitution=math.nan if settings.restitution is None else settings.restitution,
        rule_parameters=[] if tc is None else [tc],
        log=log,
    )


def load(path: Any) -> Course:
    """The run that a checkpoint holds.

    Raises
    ------
    ValueError
        If the file cannot be read, is no checkpoint or damaged; names it.
    """
    header, arrays = checkpoint.read(path)
    try:
        law = None if header["law"] is None else engines.law_of(header["law"])
        settings = Settings(header["rule"], header["restitution"], law, header["contact_duration"])
        engine = _core.load_engine("hard_spheres", arrays["engine"].tobytes())
        system = engines.system_in(header, arrays, engine)
        log = engines.log_in(arrays, 4)
        target = Target(**header["target"])
        every = float(header["every"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: no checkpoint, or damaged: {error}") from None
    return Course(
        system, settings, engine, target, rows=arrays["rows"], log=log, path=Path(path), every=every
    )
