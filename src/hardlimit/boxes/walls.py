"""Walls that move: ``MovingWall``, and the walls of a system by axis and end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..support import validation

Floats = NDArray[np.float64]
AXES: Final = ("x", "y", "z")
WAVEFORMS: Final = ("sine", "triangle", "parabola")
#: Largest displacement, speed and acceleration of a wall: the squares of larger ones would overflow.
LARGEST: Final = 1e100


@validation.sealed("a waveform is C++: CONTRIBUTING.md, 'Add a boundary'")
@dataclass(frozen=True, init=False)
class MovingWall:
    """Motion of a wall along its axis, for ``walls=`` of :class:`ParticleSystem`.

    At the time t of a run the wall is at its rest place plus offset + velocity·t + amplitude·w(2π·frequency·t + phase),
    along the axis (a positive velocity of an upper wall opens the box).

    Parameters
    ----------
    amplitude : float [m]
        Give ``frequency`` as well.
    frequency : float [Hz]
    waveform : {"sine", "triangle", "parabola"}
        w(φ). The other two have the zeros and extrema of sin φ: ``"triangle"`` moves at constant speed, ``"parabola"``
        at constant acceleration, which changes its sign at the zeros.
    phase : float [rad]
    velocity : float [m/s]
        Of a wall that moves uniformly, alone or in addition to an oscillation.
    offset : float [m]
        Displacement from the rest place. A result has it where a wall has moved uniformly.

    Raises
    ------
    ValueError
        If a value is outside its range, or amplitude and frequency are not given together.

    Examples
    --------
    >>> hl.MovingWall(amplitude=0.5e-3, frequency=50.0).acceleration / 9.81
    5.030...
    """

    amplitude: float  #: [m]
    frequency: float  #: [Hz]
    waveform: str  #: "sine", "triangle" or "parabola"
    phase: float  #: [rad]
    velocity: float  #: [m/s]
    offset: float  #: [m]

    def __init__(
        self,
        amplitude: float = 0.0,
        frequency: float = 0.0,
        waveform: str = "sine",
        phase: float = 0.0,
        *,
        velocity: float = 0.0,
        offset: float = 0.0,
    ) -> None:
        limits: dict[str, Any] = {"highest": LARGEST, "lowest_allowed": True}
        values: dict[str, Any] = {
            "amplitude": validation.number("amplitude", amplitude, 0.0, **limits),
            "frequency": validation.number("frequency", frequency, 0.0, **limits),
            "waveform": validation.one_of("waveform", waveform, WAVEFORMS),
            "phase": validation.number("phase", phase, -LARGEST, LARGEST),
            "velocity": validation.number("velocity", velocity, -LARGEST, LARGEST),
            "offset": validation.number("offset", offset, -LARGEST, LARGEST),
        }
        if (values["amplitude"] > 0.0) != (values["frequency"] > 0.0):
            raise ValueError(
                f"amplitude | frequency: got {amplitude:g} and {frequency:g}, must both be > 0, or neither be given"
            )
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if not self.acceleration < LARGEST:
            raise ValueError(f"frequency: got {frequency:g}, must be lower: the acceleration would overflow")

    @property
    def oscillates(self) -> bool:
        """Whether the wall oscillates."""
        return self.amplitude > 0.0

    @property
    def acceleration(self) -> float:
        """Largest acceleration [m/s²]: amplitude·ω² of a sine, 32·amplitude·frequency² of parabolas, 0 otherwise."""
        factor = {"sine": 4.0 * math.pi**2, "triangle": 0.0, "parabola": 32.0}[self.waveform]
        return factor * self.amplitude * self.frequency**2

    @property
    def fastest(self) -> float:
        """Largest speed [m/s]."""
        factor = {"sine": 2.0 * math.pi, "triangle": 4.0, "parabola": 8.0}[self.waveform]
        return abs(self.velocity) + factor * self.amplitude * self.frequency

    def displacement(self, time: float = 0.0) -> float:
        """Displacement from the rest place at a time of the run [m].

        :meta private:
        """
        cycles = math.fmod(self.frequency * time + self.phase / (2.0 * math.pi), 1.0) % 1.0
        moved = self.offset + self.velocity * time
        return moved + self.amplitude * _wave(self.waveform, cycles) if self.oscillates else moved

    def mean_displacement(self, begin: Floats, end: Floats) -> Floats:
        """Mean displacement from the rest place between two times of the run [m], exact for each waveform.

        :meta private:
        """
        found: Floats = self.offset + 0.5 * self.velocity * (begin + end)
        if not self.oscillates:
            return found
        cycles = [(self.frequency * t + self.phase / (2.0 * math.pi)) % 1.0 for t in (begin, end)]
        gained = _integral(self.waveform, cycles[1]) - _integral(self.waveform, cycles[0])
        passed = self.frequency * (end - begin)
        still = np.array([_wave(self.waveform, float(c)) for c in cycles[0].ravel()]).reshape(begin.shape)
        found += self.amplitude * np.divide(gained, passed, where=passed > 0.0, out=still)
        return found

    def after(self, time: float) -> MovingWall:
        """The wall in a run that begins at a time of this one [s].

        :meta private:
        """
        if time == 0.0:
            return self
        phase = self.phase
        if self.oscillates:
            phase = 2.0 * math.pi * math.remainder(self.frequency * time + self.phase / (2.0 * math.pi), 1.0)
        return MovingWall(
            self.amplitude,
            self.frequency,
            self.waveform,
            phase,
            velocity=self.velocity,
            offset=self.offset + self.velocity * time,
        )

    def __repr__(self) -> str:
        shown = []
        if self.oscillates:
            shown += [f"amplitude={self.amplitude:g}", f"frequency={self.frequency:g}"]
            shown += [f"waveform={self.waveform!r}"] if self.waveform != "sine" else []
            shown += [f"phase={self.phase:g}"] if self.phase else []
        for name in ("velocity", "offset"):
            value = getattr(self, name)
            shown += [f"{name}={value:g}"] if value else []
        return f"MovingWall({', '.join(shown)})"


def _wave(waveform: str, cycles: float) -> float:
    if waveform == "sine":
        return math.sin(2.0 * math.pi * cycles)
    if waveform == "triangle":
        return 1.0 - 4.0 * abs((cycles + 0.25) % 1.0 - 0.5)
    half = cycles % 0.5
    return math.copysign(16.0 * half * (0.5 - half), 0.5 - cycles)


def _integral(waveform: str, cycles: Floats) -> Floats:
    """Integral of the wave over the cycles in [0, 1] from 0. The second half of a period is the first with the other
    sign."""
    half: Floats = np.where(cycles < 0.5, cycles, cycles - 0.5)
    if waveform == "sine":
        first, whole = (1.0 - np.cos(2.0 * math.pi * half)) / (2.0 * math.pi), 1.0 / math.pi
    elif waveform == "triangle":
        first = np.where(half < 0.25, 2.0 * half**2, 0.25 - 2.0 * (0.5 - half) ** 2)
        whole = 0.25
    else:
        first, whole = half**2 * (4.0 - 16.0 / 3.0 * half), 1.0 / 3.0
    return np.where(cycles < 0.5, first, whole - first)


#: The moving walls of a system, by axis and end: ``"x-"`` at 0, … ``"z+"`` at the edge. In this order.
Walls = Mapping[str, MovingWall]


def name_of(axis: int, upper: bool) -> str:
    """``"x-"``, …, ``"z+"``."""
    return AXES[axis] + ("+" if upper else "-")


def number_of(name: str) -> int:
    """The number of a wall in logs: −1 − 2·axis at 0, −2 − 2·axis at the edge."""
    return -1 - 2 * AXES.index(name[0]) - (name[1] == "+")


def checked_walls(walls: Any, boundary: Sequence[str]) -> dict[str, MovingWall]:
    """The moving walls of a box in the order of their axes, without those that are at rest in their place."""
    if walls is None:
        return {}
    if not isinstance(walls, Mapping):
        raise ValueError(f"walls: got {validation.shown(walls)}, must be a mapping of 'x-', … to MovingWall")
    named = {name_of(axis, upper): axis for axis in range(len(boundary)) for upper in (False, True)}
    for name, wall in walls.items():
        validation.one_of("walls", name, list(named))
        if not isinstance(wall, MovingWall):
            raise ValueError(f"walls[{name!r}]: got {validation.shown(wall)}, must be a MovingWall")
        if boundary[named[name]] != "wall":
            raise ValueError(f"walls: got {name!r}, must be on an axis whose boundary is 'wall'")
    return {name: walls[name] for name in named if name in walls and walls[name] != MovingWall()}


def of_core(walls: Walls) -> Iterator[tuple[int, float, float, float, float, float, str]]:
    """The arguments of the core for each wall."""
    for name, wall in walls.items():
        waveform = wall.waveform if wall.oscillates else "none"
        yield (
            number_of(name),
            wall.offset,
            wall.velocity,
            wall.amplitude,
            wall.frequency,
            wall.phase,
            waveform,
        )


def as_entries(walls: Walls) -> list[list[Any]]:
    """The walls for files: each with its name, and the arguments of MovingWall in their order."""
    return [[name, *astuple(wall)] for name, wall in walls.items()]


def from_entries(entries: Any) -> dict[str, MovingWall]:
    """The walls from :func:`as_entries`. Raises ValueError if an entry is damaged."""
    try:
        return {
            str(name): MovingWall(
                float(amplitude),
                float(frequency),
                str(waveform),
                float(phase),
                velocity=float(velocity),
                offset=float(offset),
            )
            for name, amplitude, frequency, waveform, phase, velocity, offset in entries
        }
    except (TypeError, ValueError) as error:
        raise ValueError(f"walls: {error}") from None
