"""Where and when a run of a box of grains ended before it was to."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from .system import ParticleSystem

#: Of a group of particles, that many are named.
MOST_NAMED: Final = 3


class EarlyEnd(NamedTuple):
    """Where and when a run ended before it was to, and with whom; ``outcome`` says why.

    Made by :func:`hardlimit.event_driven` and :func:`hardlimit.molecular_dynamics`.

    Examples
    --------
    >>> bed = hl.ParticleSystem(
    ...     [[0.05, 0.05]],
    ...     [[0, 0]],
    ...     0.01,
    ...     density=2500.0,
    ...     box=0.1,
    ...     boundary="wall",
    ...     gravity=9.81,
    ... )
    >>> run = hl.event_driven(bed, restitution=0.5, until=1.0)
    >>> run.outcome_name, f"{run.early_end.time:.4f} s"
    ('collapse', '0.2709 s')
    >>> run.early_end.particles, run.early_end.wall
    ((0,), -3)
    >>> run.early_end.who()
    'particle 0 and the wall y = 0'
    >>> run.early_end.where()
    'at 0.270914 s, near (0.05, 0.01) m'
    """

    time: float  #: [s]
    position: tuple[float, ...]  #: of the first particle [m]
    particles: tuple[int, ...]  #: ascending: of the contact or group, or the one that was too fast
    wall: int | None  #: of the contact, −1 − 2·axis at 0 and −2 − 2·axis at the edge; None: none

    def who(self) -> str:
        """The particles in words, with the wall.

        Returns
        -------
        str
        """
        if self.wall is not None:
            return f"particle {self.particles[0]} and the wall {wall_name(self.wall)}"
        if len(self.particles) == 1:
            return f"particle {self.particles[0]}"
        if len(self.particles) > MOST_NAMED:
            named = ", ".join(str(i) for i in self.particles[:MOST_NAMED])
            return f"{len(self.particles)} particles ({named}, …)"
        *others, last = self.particles
        return f"particles {', '.join(str(i) for i in others)} and {last}"

    def where(self) -> str:
        """Time and place in words.

        Returns
        -------
        str
        """
        return f"at {self.time:.6g} s, near ({', '.join(f'{x:.6g}' for x in self.position)}) m"


def of_engine(engine: Any, now: ParticleSystem) -> EarlyEnd | None:
    """What an engine tells of its end; ``now`` is its system."""
    if engine.early_end is None:
        return None
    time, particles, wall = engine.early_end
    return EarlyEnd(time, tuple(now.positions[particles[0]].tolist()), tuple(particles), wall)


def in_words(said: str, end: EarlyEnd | None) -> str:
    """A text with who and where in it."""
    return said if end is None else said.format(who=end.who(), where=end.where())


def wall_name(second: int) -> str:
    """The wall that a negative partner stands for, such as ``z = 0``."""
    axis, upper = divmod(-1 - second, 2)
    return f"{'xyz'[axis]} = {'L' if upper else '0'}"
