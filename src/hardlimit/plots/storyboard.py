"""The scenes of the film of a drop: fall, contacts and rebound, each with the times of its frames and its speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..column.result import Result
from .heights import release_time, time_shown

SECONDS_OF_CONTACTS: Final = 8.0  #: of film, approximately; the factor of slow motion is rounded


@dataclass(frozen=True)
class Scene:
    """A part of the film with one speed and one scale."""

    times: NDArray[np.float64]  #: [s] since the first floor touch, one for each frame
    slowed: float  #: seconds of film for one second of the drop
    close_up: bool
    highest: float = 0.0  #: [m] highest centre in all scenes of the same scale
    rebound: bool = False


def round_up(value: float) -> float:
    """The next higher of 1, 2, 5, 10, …."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(digit * power for digit in (1.0, 2.0, 5.0, 10.0) if digit * power >= value * (1.0 - 1e-9))


def storyboard(result: Result, ghost: Result, rate: int) -> list[Scene]:
    """Fall, contacts, and rebound to the top of every flight; only the contacts of a cradle."""
    start, stop = _sequence(result, ghost)
    slowed = round_up(SECONDS_OF_CONTACTS / (stop - start))
    contacts = Scene(_instants(start, stop, slowed, rate), slowed, True)
    if not result.column.floor:
        return [contacts]
    release = release_time(result)
    end = time_shown([result, ghost])
    end = min(model._known_up_to(end) for model in (result, ghost))
    wide = []
    if release < start:
        slowed = round_up(2.0 / (start - release))
        wide.append(Scene(_instants(release, start, slowed, rate), slowed, False))
    if end > stop:
        slowed = round_up(3.0 / (end - stop))
        times = _instants(stop, end, slowed, rate)
        times = np.concatenate([times, np.full(rate, times[-1])])  # the last frame stays for one second
        wide.append(Scene(times, slowed, False, rebound=True))
    highest = max((float(gaps_at(m, s.times)[0].max()) for s in wide for m in (result, ghost)), default=0.0)
    wide = [replace(scene, highest=highest) for scene in wide]
    return [*(s for s in wide if not s.rebound), contacts, *(s for s in wide if s.rebound)]


def _sequence(result: Result, ghost: Result) -> tuple[float, float]:
    """Begin and end of the contacts of both models, with a margin."""
    marks = [0.0]
    for model in (result, ghost):
        for name in ("begin", "end"):
            values = model.contacts[name].values
            marks += [float(t) for t in values[np.isfinite(values)]]
    start, stop = min(marks), max(marks)
    margin = 0.06 * (stop - start) or 1e-6
    end = min(model._padded(stop, margin) for model in (result, ghost))
    return max(start - margin, release_time(result)), end


def _instants(start: float, stop: float, slowed: float, rate: int) -> NDArray[np.float64]:
    count = max(2, round((stop - start) * slowed * rate))
    return np.linspace(start, stop, count)


def gaps_at(result: Result, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and gaps [m], each (times, balls); gap 0 is the one above the floor.

    The release may differ between models, if balls meet before the first floor touch. Before it, balls do not move.
    """
    z = result.trajectory(np.maximum(times, release_time(result)))["position"].values
    radii = np.array([ball.radius for ball in result.column.balls])
    between = np.diff(z, axis=1) - radii[1:] - radii[:-1]
    return z, np.column_stack([z[:, 0] - radii[0], between])
