"""Thermostats, which change the velocities of all particles, and their spins, at equal intervals: random kicks, and
Andersen's."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support import validation
from ..support.formatting import digits, quantity
from .walls import LARGEST

Floats = NDArray[np.float64]

#: Intervals per mean time between two collisions of a particle with Andersen's bath, by default.
SUBDIVISION: Final = 20
#: What the refusal of another thermostat says.
BETWEEN_RUNS: Final = "run in pieces and change the velocities between them with ParticleSystem.replace"


#: Added to the seed of spins. Seeds of users are smaller, so that spins and velocities have different random numbers.
OF_SPINS: Final = 2**63


@dataclass(frozen=True, repr=False)
class Thermostat:
    """What all thermostats have in common. Random numbers depend on the seed and the number of the kick only."""

    interval: float  #: between two kicks [s]
    seed: int
    kicks: int  #: number of kicks before the run, as in the result of a run that has been continued

    def __repr__(self) -> str:
        values = [(field.name, getattr(self, field.name)) for field in fields(self)]
        shown = ", ".join(f"{name}={value!r}" for name, value in values if value is not None)
        return f"{type(self).__name__}({shown})"

    def values(self) -> dict[str, Any]:
        """The parameters by name, without ``rotational`` if the thermostat does not act on spins.

        :meta private:
        """
        return {name: value for name, value in vars(self).items() if value is not None}

    def time(self, kick: int) -> float:
        """Time of a kick in a run [s].

        It is a few rounding errors early. A run until k·``interval`` contains kick k however this product is rounded:
        3·0.1 as a float is above 0.3.

        :meta private:
        """
        return kick * self.interval * (1.0 - 2.0**-50)

    def after(self, kicks: int) -> Any:
        """The thermostat of a run that follows after this number of kicks.

        :meta private:
        """
        return replace(self, kicks=self.kicks + kicks)

    def _random(self, kick: int, n: int, normal: bool, seed: int = 0) -> Floats:
        stream = 2 * (self.kicks + kick) + normal
        return np.asarray(_core.random_numbers(self.seed + seed, stream, n, normal))


@validation.sealed(BETWEEN_RUNS)
@dataclass(frozen=True, init=False, repr=False)
class RandomKicks(Thermostat):
    """White noise, which heats a gas with a constant power.

    At the times k·``interval`` each particle gets a normally distributed change of its velocity, the same distribution
    for all. The total momentum does not change.

    Parameters
    ----------
    power : float [W]
        Mean power of all kicks on velocities together. May be 0 with ``rotational``.
    interval : float [s]
        Short compared with the mean time between collisions of a particle, so that kicks act as noise. Each kick costs
        about as much as a collision of each particle.
    rotational : float, optional [W]
        Mean power of further kicks on the spins: each particle gets a normally distributed change of its angular
        velocity at the same times, the same distribution for all. Their total changes. For runs with friction; without,
        spins would never act on velocities, and the run is refused. By default only friction changes spins.
    seed : int
        The same seed gives the same kicks, under every engine.
    kicks : int
        Number of kicks that are passed over. A result has it, so that another run continues with new kicks.

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    D. R. M. Williams and F. C. MacKintosh, Phys. Rev. E 54, R9 (1996); T. P. C. van Noije and M. H. Ernst, Granular
    Matter 1, 57 (1998). Kicks on spins: R. Cafiero, S. Luding and H. J. Herrmann, Europhys. Lett. 60, 854 (2002).

    Examples
    --------
    >>> hl.RandomKicks(power=1e-3, interval=1e-4)
    RandomKicks(interval=0.0001, seed=0, kicks=0, power=0.001)
    """

    power: float  #: [W]
    rotational: float | None = None  #: [W]

    def __init__(
        self,
        power: float,
        interval: float,
        *,
        rotational: float | None = None,
        seed: int = 0,
        kicks: int = 0,
    ) -> None:
        spinning = _checked_rotational(rotational)
        _set(
            self,
            power=validation.number("power", power, 0.0, LARGEST, lowest_allowed=bool(spinning)),
            interval=validation.number("interval", interval, 0.0, LARGEST),
            seed=validation.whole("seed", seed, 0, 2**63 - 1),
            kicks=validation.whole("kicks", kicks, 0, 2**60),
            rotational=spinning,
        )

    def report(self) -> str:
        """In words, for a table.

        :meta private:
        """
        spinning = f" and {quantity(self.rotational, 'W')} of the spins" if self.rotational else ""
        return (
            f"random kicks, power {quantity(self.power, 'W')}{spinning}, every {quantity(self.interval, 's')}"
        )

    def velocities(self, kick: int, velocities: Floats, mass: Floats) -> Floats:
        """The velocities after a kick, from those before it (N, d) [m/s].

        With variances σ² of all components, less the mean motion, the mean energy gained is d σ² (M − Σm²/M)/2.

        :meta private:
        """
        n, d = velocities.shape
        total = float(mass.sum())
        inert = total - float((mass * mass).sum()) / total
        spread = math.sqrt(2.0 * self.power * self.interval / (d * inert)) if inert > 0.0 else 0.0
        change = spread * self._random(kick, n * d, True).reshape(n, d)
        kicked: Floats = velocities + (change - (mass[:, None] * change).sum(axis=0) / total)
        return kicked

    def spins(self, kick: int, spins: Floats, inertia: Floats, mass: Floats) -> Floats:
        """The angular velocities after a kick, from those before it, (N, f) about f axes [rad/s].

        With variances σ² of all components the mean energy gained is f σ² ΣI/2.

        :meta private:
        """
        n, axes = spins.shape
        assert self.rotational is not None
        spread = math.sqrt(2.0 * self.rotational * self.interval / (axes * float(inertia.sum())))
        return spins + spread * self._random(kick, n * axes, True, OF_SPINS).reshape(n, axes)


@validation.sealed(BETWEEN_RUNS)
@dataclass(frozen=True, init=False, repr=False)
class Andersen(Thermostat):
    """Andersen's thermostat: particles collide with a heat bath at random times.

    Each particle has ``rate`` collisions with the bath per second on average, independent of each other, and each gives
    it a new velocity from Maxwell's distribution. The collisions of an interval happen at its end; several of one
    particle are as one. Momentum is not conserved.

    Parameters
    ----------
    temperature : float [m²/s²]
        Granular temperature of a particle of mean mass: the variance of each velocity component. A particle of the
        mass m has temperature·(mean mass)/m, the same energy.
    rate : float [1/s]
    interval : float [s], optional
        A twentieth of 1/``rate`` by default.
    rotational : float, optional [m²/s²]
        Rotational temperature T_r of the bath: each collision with it gives a new spin as well, each component with the
        mean energy (mean mass)·T_r/2. A bath in equilibrium has T_r = ``temperature``. For runs with friction; without,
        spins would never act on velocities, and the run is refused. By default only friction changes spins.
    seed : int
        ``seed`` and ``kicks`` as for :class:`RandomKicks`.
    kicks : int

    Raises
    ------
    ValueError
        If a value is outside its range.

    Notes
    -----
    In an interval a particle meets the bath with the probability p = 1 − exp(−rate·interval). A free one keeps its
    velocity for a time t with the probability (1 − p)^(t/interval) = exp(−rate t): velocities are forgotten, and a
    temperature relaxes, exactly at ``rate``. Collisions that another one follows in the same interval have no effect:
    p is smaller than rate·interval, by the factor 0.975 for the default interval.

    H. C. Andersen, J. Chem. Phys. 72, 2384 (1980).

    Examples
    --------
    >>> hl.Andersen(temperature=0.01, rate=10.0).interval
    0.005
    """

    temperature: float  #: [m²/s²]
    rate: float  #: [1/s]
    rotational: float | None = None  #: [m²/s²]

    def __init__(
        self,
        temperature: float,
        rate: float,
        *,
        interval: float | None = None,
        rotational: float | None = None,
        seed: int = 0,
        kicks: int = 0,
    ) -> None:
        often = validation.number("rate", rate, 0.0, LARGEST)
        chosen = 1.0 / (SUBDIVISION * often) if interval is None else interval
        _set(
            self,
            temperature=validation.number("temperature", temperature, 0.0, LARGEST, lowest_allowed=True),
            rate=often,
            interval=validation.number("interval", chosen, 0.0, LARGEST),
            seed=validation.whole("seed", seed, 0, 2**63 - 1),
            kicks=validation.whole("kicks", kicks, 0, 2**60),
            rotational=_checked_rotational(rotational),
        )

    def report(self) -> str:
        """In words, for a table.

        :meta private:
        """
        spinning = f" and {digits(self.rotational)} m²/s² of the spins" if self.rotational else ""
        return f"Andersen’s bath, {digits(self.temperature)} m²/s²{spinning}, rate {digits(self.rate)}/s"

    def velocities(self, kick: int, velocities: Floats, mass: Floats) -> Floats:
        """The velocities after a kick, from those before it (N, d) [m/s].

        :meta private:
        """
        n, d = velocities.shape
        spread = np.sqrt(self.temperature * float(mass.mean()) / mass)[:, None]
        drawn = spread * self._random(kick, n * d, True).reshape(n, d)
        return np.where(self._hit(kick, n)[:, None], drawn, velocities)

    def spins(self, kick: int, spins: Floats, inertia: Floats, mass: Floats) -> Floats:
        """The angular velocities after a kick, from those before it, (N, f) about f axes [rad/s].

        :meta private:
        """
        n, axes = spins.shape
        assert self.rotational is not None
        spread = np.sqrt(self.rotational * float(mass.mean()) / inertia)[:, None]
        drawn = spread * self._random(kick, n * axes, True, OF_SPINS).reshape(n, axes)
        return np.where(self._hit(kick, n)[:, None], drawn, spins)

    def _hit(self, kick: int, n: int) -> NDArray[np.bool_]:
        """Which particles collide with the bath."""
        return self._random(kick, n, False) < -math.expm1(-self.rate * self.interval)


def _checked_rotational(rotational: Any) -> float | None:
    if rotational is None:
        return None
    return validation.number("rotational", rotational, 0.0, LARGEST, lowest_allowed=True)


def _set(thermostat: Any, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(thermostat, name, value)


KINDS: Final = {kind.__name__: kind for kind in (RandomKicks, Andersen)}


def checked_thermostat(thermostat: Any, n: int, sheared: bool = False) -> Any:
    if thermostat is not None and not isinstance(thermostat, RandomKicks | Andersen):
        shown = validation.shown(thermostat)
        raise ValueError(f"thermostat: got {shown}, must be hl.RandomKicks, hl.Andersen or None")
    if n == 1 and isinstance(thermostat, RandomKicks):
        raise ValueError(
            "thermostat: got random kicks, must be none or Andersen’s for one particle: kicks keep the mean"
        )
    if sheared and isinstance(thermostat, Andersen):
        raise ValueError("thermostat: got Andersen’s, must be none or random kicks in a sheared box")
    return thermostat


def refuse_rotational(thermostat: Any) -> None:
    """Refuse a thermostat that acts on the spins of grains without friction."""
    if thermostat is not None and thermostat.rotational is not None:
        raise ValueError(
            f"rotational: got {thermostat.rotational:g}, must be left out of the thermostat in a run without friction, "
            "where spins never act on velocities"
        )


def as_entry(thermostat: Any) -> dict[str, Any] | None:
    """A thermostat for files."""
    return None if thermostat is None else {"kind": type(thermostat).__name__, **thermostat.values()}


def from_entry(entry: Any) -> Any:
    """The thermostat from :func:`as_entry`. Raises ValueError if the entry is damaged."""
    if entry is None:
        return None
    try:
        values = dict(entry)
        return KINDS[values.pop("kind")](**values)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"thermostat: {error}") from None
