"""Note beside the progress bar of a run by events: its speed, compared with an estimate for engine steps."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from typing import Final

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..support.formatting import duration
from . import time_step
from .contacts import law_arguments
from .falling_frame import engine_arguments
from .system import ParticleSystem

#: Shortest averaging time of the fraction of time in clusters [s, wall clock].
WINDOW: Final = 2.0
#: Steps are recommended if the rest of the run takes this many times as long as a whole run by steps.
ADVANTAGE: Final = 3.0
#: Size of a trial run by steps: number of particles times number of steps, and the limits of the latter.
TRIAL: Final = 1_000_000
MIN_STEPS, MAX_STEPS = 16, 1000


class ProgressNote:
    def __init__(self) -> None:
        self._last: tuple[float, float, float] | None = None  #: wall clock, time, time in clusters [s]
        self._by_steps = math.nan  #: estimated wall time of the whole run by steps [s]
        self._trial_at = 0.0  #: clock of the next trial
        self._delay = WINDOW  #: delay after it, doubled each time
        self._note = ""

    def note(
        self, time: float, cluster_share: float, law: Law, current: Callable[[], ParticleSystem], end: float
    ) -> str:
        """The fraction of time that particles spent in clusters since the last note, and the estimated wall time of
        the whole run by steps, from a trial with the ``current`` state."""
        now = clock.monotonic(), time, time * cluster_share
        if self._last is None:
            self._last, self._trial_at = now, now[0]
        lasted, passed, clustered = np.subtract(now, self._last).tolist()
        if lasted >= WINDOW:
            if now[0] >= self._trial_at:
                self._by_steps = seconds_by_steps(current(), law, end)
                self._trial_at, self._delay = now[0] + self._delay, 2.0 * self._delay
            fraction = clustered / passed if passed > 0.0 else cluster_share
            left = (end - time) * lasted / passed if passed > 0.0 else math.inf
            self._note = (
                f"{min(max(fraction, 0.0), 1.0):.0%} of the time in clusters; the rest takes about {duration(left)}, "
                f"the whole run by the engine steps about {duration(self._by_steps)}"
                f"{' (recommended)' if left > ADVANTAGE * self._by_steps else ''}"
            )
            self._last = (clock.monotonic(), *now[1:])  # excludes the time of the trial
        return self._note


def seconds_by_steps(system: ParticleSystem, law: Law, until: float) -> float:
    """Estimated wall time of a run by steps on one thread [s], from a few steps of this system."""
    step = time_step.chosen(system, law, None, None)
    trial = _core.make_engine(
        "newton_steps", *engine_arguments(system), law=law_arguments(law), time_step=step
    )
    begun = clock.monotonic()
    trial.advance(until, min(max(TRIAL // system.n, MIN_STEPS), MAX_STEPS))
    took = clock.monotonic() - begun
    return took / max(int(trial.statistics()["n_steps"]), 1) * (until / step)
