"""Walls that move: ``MovingWall``, and the walls of a system by axis and end."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from fractions import Fraction
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..support import validation
from ..support.formatting import digits, length, quantity

Floats = NDArray[np.float64]
AXES: Final = ("x", "y", "z")
#: Parts of a quarter of a period, and steps of a search within them, for the least distance of two walls.
PARTS: Final = 16
SEARCH: Final = 60
WAVEFORMS: Final = ("sine", "triangle", "parabola")
#: Largest length, speed, acceleration, frequency and rate of a box. The smallest length is one over it. The core
#: multiplies up to eight of them, which then neither overflows nor underflows.
LARGEST: Final = 1e30
#: Number of periods of an oscillation that a run resolves: rounding of the time then shifts the phase by 1e-4 periods.
MOST_PERIODS: Final = 2.0**40
#: 2π with as many digits as the largest float needs.
TWO_PI: Final = Fraction(
    int(
        "62831853071795864769252867665590057683943387987502116419498891846156328125724179972560"
        "69650684234135964296173026564613294187689219101164463450718816256962234900568205403877"
        "04221111928924589790986076392885762195133186689225695129646757356633054240381829129713"
        "38469206972209086532964267872145204982825474491740132126311763497630418419256585081"
    ),
    10**340,
)


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
        Beyond ±2π it is replaced by its remainder in [0, 2π].
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
            "phase": _reduced(validation.number("phase", phase)),
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
        mean: Floats = self.offset + 0.5 * self.velocity * (begin + end)
        if not self.oscillates:
            return mean
        cycles = [(self.frequency * t + self.phase / (2.0 * math.pi)) % 1.0 for t in (begin, end)]
        gained = _integral(self.waveform, cycles[1]) - _integral(self.waveform, cycles[0])
        passed = self.frequency * (end - begin)
        still = np.array([_wave(self.waveform, float(c)) for c in cycles[0].ravel()]).reshape(begin.shape)
        mean += self.amplitude * np.divide(gained, passed, where=passed > 0.0, out=still)
        return mean

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

    def report(self) -> str:
        """Its motion in words, such as ``sine, amplitude 0.5 mm, frequency 50 Hz``.

        :meta private:
        """
        shown = []
        if self.oscillates:
            shown += [
                self.waveform,
                f"amplitude {length(self.amplitude)}",
                f"frequency {quantity(self.frequency, 'Hz')}",
            ]
            shown += [f"phase {digits(self.phase)} rad"] if self.phase else []
        shown += [f"velocity {quantity(self.velocity, 'm/s')}"] if self.velocity else []
        shown += [f"offset {length(self.offset)}"] if self.offset else []
        return ", ".join(shown)


def _reduced(phase: float) -> float:
    """A phase beyond ±2π as its remainder, exact to the last bit; sin and cos would differ between platforms."""
    return phase if abs(phase) <= 2.0 * math.pi else float(Fraction(phase) % TWO_PI)


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


def least_widening(low: MovingWall, high: MovingWall) -> float:
    """The least distance between two walls less that of their rest places [m].

    If they drift together, it is that of the oscillations, since a run may end before they meet. Phases count if the
    ratio of the frequencies is one of whole numbers up to 8; otherwise all phases occur.
    """
    together = min(high.velocity - low.velocity, 0.0)
    waves = [wall for wall in (low, high) if wall.oscillates]
    if not waves:
        return high.offset - low.offset
    ratio = Fraction(low.frequency) / Fraction(high.frequency) if len(waves) == 2 else Fraction(1)
    if max(ratio.numerator, ratio.denominator) > 8:
        return high.offset - low.offset - low.amplitude - high.amplitude
    period = ratio.numerator / waves[0].frequency
    # Between two quarters the acceleration of a wall is monotonic. Parts, then a search around each minimum.
    times = {0.0, period}
    for wall in waves:
        first = wall.phase / (2.0 * math.pi)
        quarters = range(math.ceil(4.0 * first), math.floor(4.0 * (first + wall.frequency * period)) + 1)
        times |= {min(max((0.25 * k - first) / wall.frequency, 0.0), period) for k in quarters}

    def widening(time: float) -> float:
        return high.displacement(time) - low.displacement(time) - together * time

    ends = sorted(times)
    grid = [a + (b - a) * k / PARTS for a, b in itertools.pairwise(ends) for k in range(PARTS)] + [period]
    at = [widening(time) for time in grid]
    least = min(at)
    for i in range(len(grid)):
        before, after = max(i - 1, 0), min(i + 1, len(grid) - 1)
        if at[i] <= min(at[before], at[after]):
            a, b = grid[before], grid[after]
            for _ in range(SEARCH):
                c, d = a + (b - a) / 3.0, b - (b - a) / 3.0
                a, b = (a, d) if widening(c) <= widening(d) else (c, b)
            least = min(least, widening(0.5 * (a + b)))
    return least


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
