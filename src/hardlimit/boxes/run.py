"""Run loop of all engines of boxes: samples at equal time intervals, log, checkpoints, end of the run."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, NamedTuple

from numpy.typing import NDArray

from ..contact import compression
from ..support import validation
from ..support.progress import Report, Shown
from . import checkpoint as checkpoints
from . import observe as observing
from .engines import Engine, joined
from .observe import Observe, Values
from .result import ContactResult, Log, ParticleResult
from .system import ParticleSystem

#: Number of times that the sampling interval may double without a collision before a run without ``until`` stops.
PATIENCE: Final = 20
#: Target duration [s, wall clock] of a call of the engine, after which checkpoint and progress are updated.
PORTION: Final = 0.2
#: Collisions, events or steps in the first call of the engine.
FIRST_PORTION: Final = 100
MOST_SAMPLES: Final = 10_000_000


class Keeping(NamedTuple):
    """The records that a run keeps: samples, log, checkpoints, values of ``observe``."""

    samples: int = 100
    log: bool = False
    path: Path | None = None  #: path of the checkpoint
    every: float = math.inf  #: time between checkpoints [s, wall clock]
    observe: Observe | None = None


def checked_keeping(samples: Any, log: Any, checkpoint: Any, every: Any, observe: Any = None) -> Keeping:
    """Check the arguments that say what a run keeps."""
    return Keeping(
        checked_samples(samples),
        validation.flag("log", log),
        None if checkpoint is None else checkpoints.checked_path(checkpoint),
        validation.number("checkpoint_every", every, 0.0),
        observing.checked_function(observe),
    )


def checked_samples(samples: Any) -> int:
    """Check the number of intervals between samples."""
    return validation.whole("samples", samples, 1, MOST_SAMPLES)


@dataclass(frozen=True)
class Target:
    """The end of a run, and the times span·(k/samples) of its samples."""

    until: float | None  #: [s]
    max_collisions: int | None
    span: float  #: [s]
    samples: int
    idle: int = 0  #: number of times that the sampling interval has doubled since the last collision

    def time(self, k: int) -> float:
        """Time of sample k [s]."""
        return self.span * (k / self.samples)

    def is_reached(self, engine: Engine) -> bool:
        """Whether the run has ended."""
        if engine.outcome != "ok" or self.idle > PATIENCE:
            return True
        if self.max_collisions is not None and engine.n_contacts >= self.max_collisions:
            return True
        return self.until is not None and engine.time >= self.until and not engine.paused


class Sample(NamedTuple):
    """The values recorded at one sampling time."""

    records: Mapping[str, NDArray[Any]]  #: quantities recorded by the engine
    observed: Values  #: values of the user's function


class Run:
    """A run in progress. It stays consistent if an interrupt occurs between any two statements."""

    def __init__(
        self,
        engine: Engine,
        target: Target,
        keeping: Keeping,
        samples: Sequence[Sample] = (),
        log: Log | None = None,
    ) -> None:
        self.engine, self._keeping = engine, keeping
        self._log = [engine.take_log() if log is None else log] if keeping.log else None
        self._portion = FIRST_PORTION
        self._saved_at = clock.monotonic()
        # The samples and the target to which they belong. Thinning the samples replaces both in one assignment.
        self._sampled: tuple[list[Sample], Target] = list(samples), target

    @property
    def target(self) -> Target:
        """The end of the run and the sampling times."""
        return self._sampled[1]

    def set_end(self, until: float | None, max_collisions: int | None = None) -> None:
        """Set another end; the sampling interval is unchanged."""
        samples, target = self._sampled
        self._sampled = samples, replace(target, until=until, max_collisions=max_collisions)

    def set_observe(self, observe: Any) -> None:
        """Set the user's function for the rest of the run; it must return the same names and shapes as before."""
        found, samples = observing.checked_function(observe), self._sampled[0]
        returned = samples[-1].observed if samples else self._keeping.observe
        if found is None and returned:
            raise ValueError("observe: missing, must be given again: the run of this checkpoint has one")
        self._keeping = self._keeping._replace(observe=found)

    # --- the loop -------------------------------------------------------------------------------------------

    def run(self, report: Report) -> ParticleResult | ContactResult:
        """Run to the end.

        Raises
        ------
        KeyboardInterrupt
            At Ctrl-C, after writing the checkpoint if the run has one.
        """
        for _ in self.steps(report):
            pass
        found = self.result()
        compression.warn(found.largest_compression)
        return found

    def steps(self, report: Report) -> Iterator[float]:
        """Run to the end; yields the time [s] of each sample after it is taken."""
        try:
            while not (self._sampled[0] and self.target.is_reached(self.engine)):
                samples, target = self._sampled
                at = target.time(len(samples))
                if self._advance(at, report):
                    self._sample()
                    if len(self._sampled[0]) == 1:
                        self.save()
                    yield self.engine.time
            self.save()
        except KeyboardInterrupt:
            self._save_if_whole()
            raise

    def _advance(self, at: float, report: Report) -> bool:
        """Advance to ``at`` [s] or to the end of the run. Returns whether a sample is to be taken."""
        engine, target = self.engine, self.target
        if engine.time >= at and not engine.paused:
            return True
        stop = at if target.until is None else min(at, target.until)
        while (engine.time < stop or engine.paused) and not target.is_reached(engine):
            work = self._portion
            if target.max_collisions is not None:
                work = min(work, target.max_collisions - engine.n_contacts)
            begun = clock.monotonic()
            engine.advance(stop, work)
            self._adapt_portion(clock.monotonic() - begun)
            if clock.monotonic() - self._saved_at > self._keeping.every:
                self.save()
            report(*engine.done_and_total(target.until, target.max_collisions))
            if isinstance(report, Shown):
                report.note = engine.note(target.until)
        return engine.time == at and engine.outcome == "ok"

    def _adapt_portion(self, took: float) -> None:
        """Adapt the work per call of the engine so that a call takes about ``PORTION``."""
        if took < 0.5 * PORTION:
            self._portion = min(2 * self._portion, 2**40)
        elif took > 2.0 * PORTION:
            self._portion = max(self._portion // 2, 1)

    # --- samples, log and checkpoints -----------------------------------------------------------------------

    def _sample(self) -> None:
        """Take a sample. In a run without ``until``, drop every second sample and double the interval if there are
        too many."""
        new = self._present_sample()
        samples, target = self._sampled
        samples.append(new)
        if target.until is None and len(samples) > 2 * target.samples:
            middle, last = (int(samples[k].records["n_collisions"]) for k in (len(samples) // 2, -1))
            idle = target.idle + 1 if middle == last else 0
            self._sampled = samples[::2], replace(target, span=2.0 * target.span, idle=idle)

    def _present_sample(self) -> Sample:
        observe, samples = self._keeping.observe, self._sampled[0]
        if observe is None:
            return Sample(self.engine.sample(), {})
        before = samples[-1].observed if samples else None
        try:
            seen = observing.call(observe, self.engine.time, self.engine.current(), before)
        except Exception:
            self._save_if_whole()
            raise
        return Sample(self.engine.sample(), seen)

    def _taken_log(self) -> Log | None:
        """The complete log so far; None if the run keeps none."""
        if self._log is None:
            return None
        self._log.append(self.engine.take_log())
        self._log = [joined(self._log)]
        return self._log[0]

    def _save_if_whole(self) -> None:
        """Write the checkpoint, unless an interrupt lost rows of the log while they were taken from the engine."""
        log = self._taken_log()
        if log is None or len(log[0]) == self.engine.n_logged:
            self.save()

    def save(self) -> None:
        """Write the checkpoint, if the run has one."""
        keeping, (samples, target) = self._keeping, self._sampled
        if keeping.path is None:
            return
        log = self._taken_log()  # before the engine is saved, so that no row is saved twice
        header, arrays = self.engine.saved()
        seen = observing.collected([sample.observed for sample in samples])
        header |= {
            "target": vars(target),
            "every": keeping.every,
            "observed": list(seen),
        }
        arrays |= {f"sample_{name}": values for name, values in _stacked(samples).items()}
        arrays |= {f"observed_{i}": values for i, values in enumerate(seen.values())}
        arrays |= {f"log_{i}": part for i, part in enumerate(log or ())}
        checkpoints.write(keeping.path, header, arrays)
        self._saved_at = clock.monotonic()

    # --- results --------------------------------------------------------------------------------------------

    def current(self) -> ParticleSystem:
        """The current system, with positions in the box."""
        return self.engine.current()

    def result(self) -> ParticleResult | ContactResult:
        """The result so far."""
        samples, target = self._sampled
        if not samples or not self.engine.is_at(samples[-1].records):
            samples = [*samples, self._present_sample()]
        return self.engine.result(
            _stacked(samples),
            self._taken_log(),
            observing.collected([sample.observed for sample in samples]),
            target.idle > PATIENCE,
        )


def _stacked(samples: Sequence[Sample]) -> dict[str, NDArray[Any]]:
    """Stack the recorded quantities of all samples: one array for each."""
    return observing.collected([dict(sample.records) for sample in samples])


def _observe_again(time: float, system: ParticleSystem) -> Mapping[str, Any]:
    """Placeholder for the function of a loaded checkpoint until the user gives it again."""
    raise AssertionError


def load(path: Any) -> Run:
    """Load a run from a checkpoint."""
    header, arrays = checkpoints.read(path)
    try:
        engine = Engine.load(header, arrays)
        target, every = Target(**header["target"]), float(header["every"])
        names = header["observed"]
        records = {name[7:]: array for name, array in arrays.items() if name.startswith("sample_")}
        seen = {name: arrays[f"observed_{i}"] for i, name in enumerate(names or ())}
        n = len(records["time"]) if records else 0
        samples = list(map(Sample, observing.split(records, n), observing.split(seen, n)))
        columns = range(len(engine.record.columns))
        log = tuple(arrays[f"log_{i}"] for i in columns) if "log_0" in arrays else None
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise ValueError(f"{path}: no checkpoint, or damaged: {error}") from None
    observe = _observe_again if names else None
    keeping = Keeping(target.samples, log is not None, Path(path), every, observe)
    return Run(engine, target, keeping, samples, log)


def checked_until(run: Run, until: Any) -> float:
    """Check the new end [s] of a run that is continued."""
    end, target, reached = validation.number("until", until), run.target, run.engine.time
    if end < reached:
        raise ValueError(
            f"until: got {end:.16g}, must be >= {validation.at_least(reached)}, the time of the checkpoint"
        )
    most = target.span / target.samples * MOST_SAMPLES
    if 0.0 < most < end:
        raise ValueError(
            f"until: got {end:.16g}, must be <= {validation.at_most(most)}, up to which the samples, "
            f"whose spacing stays, are {MOST_SAMPLES:.0e}"
        )
    return end
