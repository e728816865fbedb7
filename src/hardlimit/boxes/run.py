"""Run loop of all engines of boxes: samples at equal time intervals, log, checkpoints, end of the run."""

from __future__ import annotations

import math
import time as clock
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

from ..contact import compression
from ..support import validation
from ..support.progress import Report, Shown
from . import checkpoint as checkpoints
from . import observe as observing
from .box import Floats
from .engines import Engine, joined
from .observe import Observed, Parts
from .result import ContactResult, Log, ParticleResult
from .system import ParticleSystem

#: Number of times that the sampling interval may double without a collision before a run without ``until`` stops.
MAX_DOUBLINGS: Final = 20
#: Schedule duration [s, wall clock] of a call of the engine, after which checkpoint and progress are updated.
CALL_DURATION: Final = 0.2
#: Collisions, events or steps in the first call of the engine.
FIRST_WORK: Final = 100
MAX_SAMPLES: Final = 10_000_000


class Output(NamedTuple):
    """What a run records."""

    samples: int = 100  #: number of intervals between samples
    log: bool = False  #: whether every contact is recorded
    path: Path | None = None  #: path of the checkpoint
    every: float = math.inf  #: time between checkpoints [s, wall clock]
    observe: Parts | None = None


def checked_output(samples: Any, log: Any, checkpoint: Any, every: Any, observe: Any = None) -> Output:
    return Output(
        checked_samples(samples),
        validation.flag("log", log),
        None if checkpoint is None else checkpoints.checked_path(checkpoint),
        validation.number("checkpoint_every", every, 0.0),
        observing.checked_functions(observe),
    )


def checked_samples(samples: Any) -> int:
    return validation.whole("samples", samples, 1, MAX_SAMPLES)


@dataclass(frozen=True)
class Schedule:
    """The end of a run, and the times span·(k/samples) of its samples."""

    until: float | None  #: [s]
    max_collisions: int | None
    span: float  #: [s]
    samples: int
    idle: int = 0  #: number of times that the sampling interval has doubled since the last collision

    def time(self, k: int) -> float:
        """Time of sample k [s]."""
        return self.span * (k / self.samples)

    def is_over(self, engine: Engine) -> bool:
        if engine.outcome != "ok" or self.idle > MAX_DOUBLINGS:
            return True
        if self.max_collisions is not None and engine.n_contacts >= self.max_collisions:
            return True
        return self.until is not None and engine.has_reached(self.until)


class Sample(NamedTuple):
    """The values recorded at one sampling time."""

    records: Floats  #: quantities recorded by the engine, as Engine.fields
    observed: Observed  #: values of the user's functions


class Run:
    """A run in progress. It stays consistent if an interrupt occurs between any two statements."""

    def __init__(
        self,
        engine: Engine,
        schedule: Schedule,
        output: Output,
        samples: Sequence[Sample] = (),
        log: Log | None = None,
        kept: float | None = None,
    ) -> None:
        self.engine, self._output = engine, output
        self._log = [engine.take_log() if log is None else log] if output.log else None
        self._work = FIRST_WORK
        self._saved_at = clock.monotonic()
        self._kept = kept  # time of the last checkpoint [s]
        # The samples and their schedule. Thinning the samples replaces both in one assignment.
        self._sampled: tuple[list[Sample], Schedule] = list(samples), schedule

    @property
    def schedule(self) -> Schedule:
        """The end of the run and the sampling times."""
        return self._sampled[1]

    @property
    def sampled_times(self) -> list[float]:
        """Times of the samples so far [s]."""
        return [self.engine.number("time", sample.records) for sample in self._sampled[0]]

    def takes_samples(self, until: float) -> bool:
        """Whether samples follow up to ``until`` [s], where one is taken in any case."""
        samples, schedule = self._sampled
        due = schedule.time(len(samples)) <= until
        return self.engine.outcome == "ok" and (due or not self.engine.has_reached(until))

    def set_end(self, until: float | None, max_collisions: int | None = None) -> None:
        """Set another end; the sampling interval is unchanged."""
        samples, schedule = self._sampled
        self._sampled = samples, replace(schedule, until=until, max_collisions=max_collisions)

    def set_observe(self, observe: Any) -> None:
        """Set the user's functions for the rest of the run; they must return the same names and shapes as before."""
        functions, samples = observing.checked_functions(observe), self._sampled[0]
        returned = samples[-1].observed.data if samples else self._output.observe
        if functions is None and returned:
            raise ValueError("observe: missing, must be the function with which the run was started")
        self._output = self._output._replace(observe=functions)

    # --- the loop -------------------------------------------------------------------------------------------

    def run(self, report: Report) -> ParticleResult | ContactResult:
        """Run to the end. Ctrl-C raises KeyboardInterrupt after writing the checkpoint, if the run has one.

        The error says which time was reached, and what the checkpoint holds.
        """
        for _ in self.steps(report):
            pass
        try:
            result = self.result()
        except (KeyboardInterrupt, Exception) as error:  # the user's functions see the end
            error.add_note(self._progress())
            raise
        compression.warn(result.largest_compression)
        return result

    def steps(self, report: Report) -> Iterator[float]:
        """Run to the end; yields the time [s] of each sample after it is taken."""
        try:
            while not (self._sampled[0] and self.schedule.is_over(self.engine)):
                samples, schedule = self._sampled
                at = schedule.time(len(samples))
                if self._advance(at, report):
                    self._sample()
                    if len(self._sampled[0]) == 1:
                        self.save()
                    yield self.engine.time
            self._save_last()
        except (KeyboardInterrupt, Exception) as error:
            self._save_after(error)
            raise

    def _advance(self, at: float, report: Report) -> bool:
        """Advance to ``at`` [s] or to the end of the run. Returns whether a sample is to be taken."""
        engine, schedule = self.engine, self.schedule
        if engine.has_reached(at):
            return True
        stop = at if schedule.until is None else min(at, schedule.until)
        while not (engine.has_reached(stop) or schedule.is_over(engine)):
            work = self._work
            if schedule.max_collisions is not None:
                work = min(work, schedule.max_collisions - engine.n_contacts)
            begun = clock.monotonic()
            engine.advance(stop, work)
            took = clock.monotonic() - begun
            if took < 0.5 * CALL_DURATION:
                self._work = min(2 * self._work, 2**40)
            elif took > 2.0 * CALL_DURATION:
                self._work = max(self._work // 2, 1)
            if clock.monotonic() - self._saved_at > self._output.every:
                self.save()
            report(*engine.done_and_total(schedule.until, schedule.max_collisions))
            if isinstance(report, Shown):
                report.note = engine.note(schedule.until)
        return engine.has_reached(at) and engine.outcome == "ok"

    # --- samples, log and checkpoints -----------------------------------------------------------------------

    def _sample(self) -> None:
        """Take a sample. In a run without ``until``, drop every second sample and double the interval if there are
        too many."""
        new = self._new_sample()
        samples, schedule = self._sampled
        if schedule.until is not None or len(samples) < 2 * schedule.samples:
            samples.append(new)
            return
        middle, last = (
            self.engine.number("n_collisions", s.records) for s in (samples[schedule.samples], new)
        )
        idle = schedule.idle + 1 if middle == last else 0
        self._sampled = [*samples[::2], new], replace(schedule, span=2.0 * schedule.span, idle=idle)

    def _new_sample(self) -> Sample:
        observe, samples = self._output.observe, self._sampled[0]
        if observe is None:
            return Sample(self.engine.sample(), observing.NOTHING)
        before = samples[-1].observed if samples else None
        seen = observing.call(observe, self.engine.time, self.engine.current(), before)
        return Sample(self.engine.sample(), seen)

    def _taken_log(self) -> Log | None:
        """The complete log so far; None if the run keeps none."""
        if self._log is None:
            return None
        self._log.append(self.engine.take_log())
        self._log = [joined(self._log)]
        return self._log[0]

    def _save_after(self, error: BaseException) -> None:
        """Write the checkpoint, unless an interrupt lost rows of the log while they were taken from the engine.

        The error gets a note of what is kept.
        """
        with suppress(OSError, MemoryError):
            log = self._taken_log()
            if log is None or len(log[0]) == self.engine.n_logged:
                self.save()
        error.add_note(self._progress())

    def _progress(self) -> str:
        """The time reached, the end, and what the checkpoint holds."""
        engine, schedule = self.engine, self.schedule
        parts = [] if schedule.until is None else [f"{engine.time:.6g} s of {schedule.until:.6g} s"]
        if schedule.max_collisions is not None:
            parts.append(f"{engine.n_contacts} of {schedule.max_collisions} collisions")
        text = f"at {' and '.join(parts)}"
        if self._kept is None:
            return text
        return f"{text}; kept {self._output.path}" + self._age()

    def _age(self) -> str:
        """The time of the checkpoint, if the run has gone on since."""
        return "" if self._kept in (None, self.engine.time) else f" of {self._kept:.6g} s"

    def _save_last(self) -> None:
        """Write the checkpoint of a run that is over; its result is not lost if that fails."""
        try:
            self.save()
        except OSError as error:
            kept = f"; kept the one{self._age()}" if self._kept is not None else ""
            warnings.warn(f"{error}{kept}", checkpoints.CheckpointWarning, stacklevel=5)

    def save(self) -> None:
        """Write the checkpoint, if the run has one."""
        output, (samples, schedule) = self._output, self._sampled
        if output.path is None:
            return
        log = self._taken_log()  # before the engine is saved, so that no row is saved twice
        header, arrays = self.engine.saved()
        labels, seen = observing.saved(observing.joined([sample.observed for sample in samples]))
        header |= {"schedule": vars(schedule), "every": output.every, **labels}
        arrays |= {f"sample_{name}": values for name, values in self._records(samples).items()} | seen
        arrays |= {f"log_{i}": part for i, part in enumerate(log or ())}
        checkpoints.write(output.path, header, arrays)
        self._saved_at, self._kept = clock.monotonic(), self.engine.time

    # --- results --------------------------------------------------------------------------------------------

    def result(self) -> ParticleResult | ContactResult:
        samples, schedule = self._sampled
        if not samples or not self.engine.is_at(samples[-1].records):
            samples = [*samples, self._new_sample()]
        seen = observing.joined([sample.observed for sample in samples])
        idle = schedule.idle > MAX_DOUBLINGS
        return self.engine.result(self._records(samples), self._taken_log(), seen, idle)

    def _records(self, samples: Sequence[Sample]) -> dict[str, Floats]:
        return self.engine.by_name([sample.records for sample in samples])


def _observe_again(time: float, system: ParticleSystem) -> Mapping[str, Any]:
    """Placeholder for the functions of a loaded checkpoint until the user gives them again."""
    raise NotImplementedError


def load(path: Any) -> Run:
    header, arrays = checkpoints.read(path)
    try:
        engine = Engine.load(header, arrays)
        schedule, every = Schedule(**header["schedule"]), float(header["every"])
        seen = observing.loaded(header, arrays)
        records = {name[7:]: array for name, array in arrays.items() if name.startswith("sample_")}
        rows = engine.samples_from(records)
        samples = list(map(Sample, rows, observing.separated(seen, len(rows))))
        columns = range(len(engine.columns))
        log = tuple(arrays[f"log_{i}"] for i in columns) if "log_0" in arrays else None
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise ValueError(f"{path}: not a checkpoint, or damaged: {error}") from None
    observe = (_observe_again,) if seen.data else None
    output = Output(schedule.samples, log is not None, Path(path), every, observe)
    return Run(engine, schedule, output, samples, log, engine.time)


def checked_until(run: Run, until: Any) -> float:
    end, schedule, reached = validation.number("until", until), run.schedule, run.engine.time
    if end < reached:
        raise ValueError(
            f"until: got {end:.16g}, must be >= {validation.at_least(reached)}, the time of the checkpoint"
        )
    most = schedule.span / schedule.samples * MAX_SAMPLES
    if 0.0 < most < end:
        raise ValueError(
            f"until: got {end:.16g}, must be <= {validation.at_most(most)}: the interval between samples is fixed, "
            f"and a run has at most {MAX_SAMPLES:.0e} samples"
        )
    return end
