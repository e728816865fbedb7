"""How a run by events gets on, and what small steps would take instead."""

from __future__ import annotations

import math
import time as clock
from typing import Any, Final

import numpy as np

from .. import _core
from ..contact.contact import Law
from ..support.progress import duration
from . import engines, time_step
from .system import ParticleSystem

#: Seconds [wall clock] that the share in clusters is taken over, at least.
WINDOW: Final = 2.0
#: How many times as long as the whole run by steps what is left must take by events for steps to be advised.
CLEARLY: Final = 3.0
#: Particles times steps by which steps are timed, and how many steps those may be.
TRIAL: Final = 1_000_000
FEWEST, MOST = 16, 1000


class Pace:
    """What there is to say of a run by events while it lasts."""

    def __init__(self) -> None:
        self._seen: tuple[float, float, float] | None = None  #: clock, time, of it in clusters [s]
        self._by_steps = math.nan  #: of the whole run [s]
        self._next, self._wait = (
            0.0,
            WINDOW,
        )  #: when steps are timed again; after so long, the next time twice that
        self._note = ""

    def note(self, system: ParticleSystem, law: Law, engine: Any, end: float) -> str:
        """The share of time that particles spent in clusters of late, and how long the whole run would take by steps,
        which a trial from the present state tells."""
        now = clock.monotonic(), engine.time, engine.time * engine.statistics()["cluster_share"]
        if self._seen is None:
            self._seen, self._next = now, now[0]
        lasted, passed, clustered = np.subtract(now, self._seen).tolist()
        if lasted >= WINDOW:
            if now[0] >= self._next:
                self._by_steps = seconds_by_steps(engines.present(system, engine), law, end)
                self._next, self._wait = now[0] + self._wait, 2.0 * self._wait
            share = clustered / passed if passed > 0.0 else engine.statistics()["cluster_share"]
            left = (end - engine.time) * lasted / passed if passed > 0.0 else math.inf
            self._note = (
                f"{min(max(share, 0.0), 1.0):.0%} of the time in clusters; the rest takes about {duration(left)}, "
                f"the whole run by engine='steps' about {duration(self._by_steps)}"
                f"{', which is advised' if left > CLEARLY * self._by_steps else ''}"
            )
            self._seen = (clock.monotonic(), *now[1:])  # the trial does not count
        return self._note


def seconds_by_steps(system: ParticleSystem, law: Law, until: float) -> float:
    """What a run of so many seconds takes by steps on one thread [s, wall clock], from a few steps of this system."""
    step = time_step.chosen(system, law, None, None)
    trial = _core.make_engine(
        "newton_steps", *engines.engine_arguments(system), law=engines.choice(law), time_step=step
    )
    begun = clock.monotonic()
    trial.advance(until, min(max(TRIAL // system.n, FEWEST), MOST))
    took = clock.monotonic() - begun
    return took / max(trial.work, 1) * (until / step)
