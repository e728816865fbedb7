"""Find contacts in the overlaps that LAMMPS writes: energy and number at samples, times and speeds for the log.

LAMMPS writes the distances of all overlapping pairs. The difference between two steps gives the velocity half a step
earlier, with which LAMMPS computes its forces. With the same forces from our law, we obtain the velocities before the
touch and after the release, and the begin and end of the force to a fraction of a step.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from threading import Lock
from typing import Any, Final, NamedTuple

import numpy as np

from ..box import Floats
from ..system import ParticleSystem
from .forces import Flags, Integers, Pairs
from .output import Snapshot, snapshots, table

#: Number of lines of a dump that are parsed at a time.
LINES: Final = 50_000
#: Number of overlaps that are searched at a time.
ROWS: Final = 500_000
#: Number of fixed-point iterations for the rate before a touch; each gains more than a digit.
ITERATIONS: Final = 20


class Overlaps(NamedTuple):
    """Overlaps at several steps."""

    step: Integers
    first: Integers
    second: Integers  #: a negative number is a wall
    compression: Floats  #: [m]
    force_acts: Flags  #: whether the force is not zero
    tangential_energy: Floats  #: [J]


class PairDump:
    """Dump of pairs; each row has two particle numbers, distance and force.

    With friction it also has the tangential force on the first particle, and the way to it from the second one.
    """

    def __init__(self, pairs: Pairs) -> None:
        self._pairs = pairs
        self.width = 10 if pairs.rubs else 4

    def overlaps(self, step: Integers, table: Floats) -> Overlaps:
        both = np.sort(table[:, :2].astype(np.int64), axis=1) - 1
        first, second = both[:, 0], both[:, 1]
        compression = self._pairs.apart(first, second) - table[:, 2]
        elastic = np.zeros((len(table), 3)) if self._pairs.damped else table[:, 4:7]  # see SpringReader
        stored = self._pairs.tangential_energy(first, second, compression, elastic)
        return Overlaps(step, first, second, compression, table[:, 3] > 0.0, stored)


class WallDump:
    """Dump of particles at walls; each row has number, position and velocity.

    With friction it also has the angular velocity, and the force of each wall.
    """

    def __init__(self, pairs: Pairs, system: ParticleSystem) -> None:
        self._pairs, self._system = pairs, system
        self.width = 7 + (3 + 3 * len(list(system.domain.walls())) if pairs.rubs else 0)

    def overlaps(self, step: Integers, table: Floats) -> Overlaps:
        sides = zip(*self._sides(step, table), strict=True)
        step, first, second, compression, rate, tangential = (np.concatenate(part) for part in sides)
        force = self._pairs.force(first, second, compression, rate)
        stored = self._pairs.tangential_energy(first, second, compression, tangential)
        return Overlaps(step, first, second, compression, force > 0.0, stored)

    def _sides(self, step: Integers, table: Floats) -> Iterator[tuple[Any, ...]]:
        number = table[:, 0].astype(np.int64) - 1
        for order, (wall, axis, upper) in enumerate(self._system.domain.walls()):
            x, v, edge = table[:, 1 + axis], table[:, 4 + axis], self._system.box[axis]
            depth = self._system.radius[number] - (edge - x if upper else x)
            rate, hit = v if upper else -v, depth > 0.0
            first, second = number[hit], np.full(int(hit.sum()), wall)
            elastic = self._spring(table[hit], order, axis, upper, first, second, depth[hit])
            yield step[hit], first, second, depth[hit], rate[hit], elastic

    def _spring(
        self,
        rows: Floats,
        order: int,
        axis: int,
        upper: bool,
        first: Integers,
        second: Integers,
        depth: Floats,
    ) -> Floats:
        """Forces of the tangential springs (N, 3) [N], those of the wall ``order`` without damping."""
        if not self._pairs.rubs:
            return np.zeros((len(rows), 3))
        arm = np.zeros((len(rows), 3))
        arm[:, axis] = self._system.radius[first] * (1.0 if upper else -1.0)
        damped = rows[:, 4:7] + np.cross(rows[:, 7:10], arm)
        damped *= self._pairs.tangential_damping(first, second, depth)[:, None]
        elastic: Floats = rows[:, 10 + 3 * order : 13 + 3 * order] + damped
        elastic[:, axis] = 0.0
        return elastic


class Sums(NamedTuple):
    """Sums over contacts at a sample."""

    energy: float  #: energy of all normal and tangential springs [J]
    tangential: float  #: that of the tangential ones
    in_contact: float


class DumpReader:
    """Reads a dump and computes the sums at samples; passes the overlaps to a ``Finder`` if there is a log."""

    def __init__(
        self,
        dump: PairDump | WallDump,
        pairs: Pairs,
        per_sample: int,
        finder: Finder | None,
        springs: SpringReader | None = None,
    ) -> None:
        self._dump, self._pairs, self._per_sample, self.finder = dump, pairs, per_sample, finder
        self._springs = springs
        self.sums: dict[int, Sums] = {}  #: by step

    def read(self, lines: Iterable[str]) -> None:
        unread: list[Snapshot] = []
        n_lines = 0
        for snapshot in snapshots(lines):
            unread.append(snapshot)
            n_lines += 1 + len(snapshot.rows)
            if n_lines > LINES:
                self._parse(unread)
                unread, n_lines = [], 0
        if unread:
            self._parse(unread)

    def _parse(self, parts: list[Snapshot]) -> None:
        steps = np.array([part.step for part in parts])
        numbers = table([row for part in parts for row in part.rows], self._dump.width)
        overlaps = self._dump.overlaps(np.repeat(steps, [len(part.rows) for part in parts]), numbers)
        samples = steps[steps % self._per_sample == 0]
        self._sum(samples, overlaps)
        if self._springs is not None:
            for sample in samples.tolist():
                self._springs.add_pairs(sample, numbers[overlaps.step == sample])
        if self.finder is not None:
            self.finder.add(overlaps, int(steps[-1]))

    def _sum(self, samples: Integers, overlaps: Overlaps) -> None:
        now = overlaps.step % self._per_sample == 0
        energies = self._pairs.energy(overlaps.first[now], overlaps.second[now], overlaps.compression[now])
        at, n = np.searchsorted(samples, overlaps.step[now]), len(samples)
        tangential = overlaps.tangential_energy[now]
        columns = energies + tangential, tangential, overlaps.force_acts[now]
        rows = np.stack([np.bincount(at, column, n) for column in columns], axis=1)
        self.sums |= dict(zip(samples.tolist(), map(Sums._make, rows.tolist()), strict=True))


class SpringReader:
    """Reads the motion of particles at samples and computes the energy of damped tangential springs of pairs.

    The rows of the pairs come from another thread, before or after.
    """

    finder: Final = None

    def __init__(self, pairs: Pairs, system: ParticleSystem) -> None:
        self._pairs, self._system = pairs, system
        self.sums: dict[int, Sums] = {}  #: by step
        self._waiting: dict[int, Floats] = {}  # what has come of a step
        self._lock = Lock()

    def read(self, lines: Iterable[str]) -> None:
        for snapshot in snapshots(lines):
            motion = table(snapshot.rows, 10)
            if (rows := self._other(snapshot.step, motion)) is not None:
                self._sum(snapshot.step, rows, motion)

    def add_pairs(self, step: int, rows: Floats) -> None:
        """Add the rows of :class:`PairDump` at a sample."""
        if (motion := self._other(step, rows)) is not None:
            self._sum(step, rows, motion)

    def _other(self, step: int, part: Floats) -> Floats | None:
        """The other part of a step; None if this one is the first."""
        with self._lock:
            if step in self._waiting:
                return self._waiting.pop(step)
            self._waiting[step] = part
        return None

    def _sum(self, step: int, rows: Floats, motion: Floats) -> None:
        motion = motion[np.argsort(motion[:, 0])]
        at = np.searchsorted(motion[:, 0], rows[:, :2])
        first, second = (rows[:, :2].astype(np.int64) - 1).T
        compression = self._pairs.apart(first, second) - rows[:, 2]
        damping = self._pairs.tangential_damping(first, second, compression)
        elastic = rows[:, 4:7] + damping[:, None] * self._slip(rows, motion[at[:, 0]], motion[at[:, 1]])
        stored = float(self._pairs.tangential_energy(first, second, compression, elastic).sum())
        self.sums[step] = Sums(stored, stored, 0.0)

    def _slip(self, rows: Floats, first: Floats, second: Floats) -> Floats:
        """Velocities of the surfaces of first particles relative to those of the second ones (N, 3)."""
        normal = rows[:, 7:10] / rows[:, 2:3]
        velocity = first[:, 4:7] - second[:, 4:7]
        axis = self._system.domain.gradient
        if axis is not None:  # the contact may be with an image
            edge = float(self._system.box[axis])
            crossed = np.rint((first[:, 1 + axis] - second[:, 1 + axis] - rows[:, 7 + axis]) / edge)
            velocity[:, 0] -= crossed * (self._system.shear_rate * edge)
        numbers = rows[:, :2].astype(np.int64) - 1
        arms = self._system.radius[numbers]
        turning = arms[:, :1] * first[:, 7:10] + arms[:, 1:] * second[:, 7:10]
        slip: Floats = (
            velocity - (velocity * normal).sum(axis=1)[:, None] * normal - np.cross(turning, normal)
        )
        return slip


class Change(NamedTuple):
    """Contacts that begin, or that end."""

    first: Integers
    second: Integers
    time: Floats  #: [s]
    speed: Floats  #: of approach or separation [m/s]; NaN for a contact of a single step


class Finder:
    """Finds the begins and ends of contacts in the overlaps of all steps."""

    def __init__(self, pairs: Pairs, time_step: float, last: int) -> None:
        self._pairs, self._dt, self._last = pairs, time_step, last
        self._kept: list[Overlaps] = []
        self._count, self._done = 0, -1  # number of rows kept; last step searched
        self.begins: list[Change] = []
        self.ends: list[Change] = []

    def add(self, overlaps: Overlaps, until: int) -> None:
        """Add the overlaps of the next steps up to ``until``."""
        self._kept.append(overlaps)
        self._count += len(overlaps.step)
        if until == self._last:
            self._search(until)
        elif self._count > ROWS:
            self._search(until - 1)

    def _search(self, until: int) -> None:
        """Find begins and ends from the last searched step to ``until``, and keep the last rows for differences."""
        overlaps = Overlaps._make(np.concatenate(column) for column in zip(*self._kept, strict=True))
        rows = Rows(self._pairs, self._dt, overlaps)
        new = (rows.step > self._done) & (rows.step <= until)
        self.begins.append(rows.begins(new))
        self.ends.append(rows.ends(new & (rows.step < self._last)))
        last = overlaps.step >= until - 1
        self._kept = [Overlaps._make(column[last] for column in overlaps)]
        self._count, self._done = int(last.sum()), until


class Rows:
    """Overlaps of many steps, sorted by pair and then by time."""

    def __init__(self, pairs: Pairs, dt: float, overlaps: Overlaps) -> None:
        order = np.lexsort((overlaps.step, overlaps.second, overlaps.first))
        columns: tuple[Any, ...] = overlaps
        step, first, second, depth, *_ = (column[order] for column in columns)
        self.step, self._first, self._second, self._depth, self._dt = step, first, second, depth, dt
        same = (np.diff(first) == 0) & (np.diff(second) == 0) & (np.diff(step) == 1)
        self._has_before = np.append(False, same)[: len(step)]
        self._has_after = np.append(same, False)[: len(step)]
        # Change of velocity per force from one half step to the next; the first change of LAMMPS is half a step long.
        self._kick = np.where(step == 0, 0.5, 1.0) * dt / pairs.effective_mass(first, second)
        self._rate = np.full(len(step), np.nan)
        change = np.diff(depth) / dt
        before, after = np.flatnonzero(self._has_before), np.flatnonzero(self._has_after)
        self._rate[before] = change[before - 1]
        self._after = np.full(len(step), np.nan)
        self._after[after] = change[after]
        touch = np.flatnonzero(self._has_after & ~self._has_before)
        self._rate[touch] = self._before_touch(pairs, touch)
        self._force = pairs.force(first, second, depth, np.nan_to_num(self._rate))
        self._acts = self._force > 0.0
        leaving = np.isnan(self._after)
        self._after[leaving] = (self._rate - self._kick * self._force)[leaving]

    def _before_touch(self, pairs: Pairs, at: Integers) -> Floats:
        """The rates u before the touch, which satisfy u − F(ξ, u) Δt/m = measured rate after it."""
        measured = self._after[at]
        rate = measured
        for _ in range(ITERATIONS):
            force = pairs.force(self._first[at], self._second[at], self._depth[at], rate)
            rate = measured + self._kick[at] * force
        return rate

    def begins(self, among: Flags) -> Change:
        """The contacts whose force begins to act at one of the rows ``among``."""
        acted_before = np.append(False, self._acts[:-1])[: len(self.step)] & self._has_before
        at = np.flatnonzero(among & self._acts & ~acted_before)
        since = np.clip(self._depth[at] / self._rate[at], 0.0, self._dt)
        since = np.where(self._has_before[at] | np.isnan(since), 0.5 * self._dt, since)
        time = np.where(self.step[at] == 0, 0.0, self.step[at] * self._dt - since)
        return Change(self._first[at], self._second[at], time, self._rate[at])

    def ends(self, among: Flags) -> Change:
        """The contacts whose force acts for the last time at one of the rows ``among``."""
        acts_after = np.append(self._acts[1:], False)[: len(self.step)] & self._has_after
        at = np.flatnonzero(among & self._acts & ~acts_after)
        force = self._force[at]
        fell = np.where(self._has_before[at], self._force[at - 1] - force, np.nan)
        with np.errstate(divide="ignore", invalid="ignore"):
            by_force = np.where(fell > 0.0, force / fell, 0.5)
            by_gap = np.where(self._has_after[at], 1.0, -self._depth[at] / (self._after[at] * self._dt))
        left = np.fmin(np.fmin(by_force, np.where(by_gap > 0.0, by_gap, 1.0)), 1.0)
        time = (self.step[at] + left) * self._dt
        return Change(self._first[at], self._second[at], np.asarray(time, np.float64), -self._after[at])
