"""A slow, simple event-driven engine: a binary heap, all pairs, all images, all particles moved at every event.

It implements the collision rules independently, as a reference for the fast engine.
"""

import heapq
import itertools
import math
from dataclasses import dataclass, field

import numpy as np

import hardlimit as hl
from hardlimit import _core


@dataclass(frozen=True)
class Rule:
    """A collision rule. ``law`` is for the rules law and soft; tc takes ε or a law."""

    name: str = "constant"
    restitution: float = 1.0
    law: hl.Law | None = None
    contact_duration: float = math.nan


@dataclass
class SlowHardSpheres:
    """N particles in d dimensions, with unwrapped positions. ``boundary``: "periodic" or "wall" per axis."""

    position: np.ndarray
    velocity: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    box: np.ndarray
    boundary: tuple[str, ...]
    gravity: np.ndarray
    rule: Rule = field(default_factory=Rule)

    def __post_init__(self) -> None:
        self.position, self.velocity = self.position.copy(), self.velocity.copy()
        self.time = 0.0
        self.log: list[tuple[float, int, int, float]] = []
        self.n, self.dimension = self.position.shape
        self.met = np.zeros(self.n, dtype=int)  # collisions of each particle so far
        self.last = np.full(self.n, -math.inf)  # time of its last one
        self.soft: dict[tuple[int, int], tuple[float, int, int, tuple[int, ...]]] = {}
        self.periodic = np.array([b == "periodic" for b in self.boundary])
        axes = [(-1, 0, 1) if periodic else (0,) for periodic in self.periodic]
        self.images = np.array(list(itertools.product(*axes)))
        self.heap: list[tuple[float, int, int, int, int, tuple[int, ...]]] = []
        self.look_again()

    # ---- prediction ----------------------------------------------------------------------------------------

    def look_again(self) -> None:
        """Predict all events until a pair may have moved half a box, after which its nearest image may change."""
        self.fastest = self.speeds().max()
        crossing = 0.25 * self.box.min() / self.fastest if self.fastest > 0.0 else math.inf
        self.horizon = self.time + crossing
        self.heap = []
        for i in range(self.n):
            self.predict(i, np.arange(i + 1, self.n))

    def speeds(self) -> np.ndarray:
        return np.linalg.norm(self.velocity - self.velocity.mean(axis=0), axis=1)

    def push(self, time: float, i: int, j: int, image: tuple[int, ...]) -> None:
        if time <= self.horizon:
            other = int(self.met[j]) if j >= 0 else 0
            heapq.heappush(self.heap, (max(time, self.time), i, j, int(self.met[i]), other, image))

    def predict(self, i: int, others: np.ndarray) -> None:
        """Predict events of a particle with others and the walls. Gravity cancels in the relative motion of a pair."""
        r, v = self.position[i] - self.position[others], self.velocity[i] - self.velocity[others]
        nearest = np.where(self.periodic, -np.round(r / self.box), 0.0).astype(int)
        images = nearest[:, None, :] + self.images
        touch = self.radius[i] + self.radius[others]
        times = times_to_touch(r[:, None, :] + images * self.box, v[:, None, :], touch[:, None])
        for k, m in np.argwhere(self.time + times <= self.horizon):
            j, image = int(others[k]), images[k, m]
            if i < j:
                self.push_pair(self.time + times[k, m], i, j, image)
            else:
                self.push_pair(self.time + times[k, m], j, i, -image)
        for axis in np.flatnonzero(~self.periodic):
            for high in (False, True):
                self.predict_wall(i, int(axis), high)

    def push_pair(self, time: float, i: int, j: int, image: np.ndarray) -> None:
        if not self.is_soft_contact(i, j, tuple(image)):
            self.push(time, i, j, tuple(int(k) for k in image))

    def is_soft_contact(self, i: int, j: int, image: tuple[int, ...]) -> bool:
        """Whether the two are in, or have just left, a contact with each other, and neither has collided since."""
        begun = self.soft.get((i, j))
        other = int(self.met[j]) if j >= 0 else 0
        return begun is not None and begun[1:] == (int(self.met[i]), other, tuple(int(k) for k in image))

    def predict_wall(self, i: int, axis: int, high: bool) -> None:
        wall = -1 - 2 * axis - int(high)
        wait = 0.0
        if self.is_soft_contact(i, wall, ()):
            wait = max(self.soft[i, wall][0] - self.time, 0.0)
        acceleration = self.gravity[axis]
        x = self.position[i, axis] + wait * (self.velocity[i, axis] + 0.5 * wait * acceleration)
        speed = self.velocity[i, axis] + wait * acceleration
        gap, sign = (self.box[axis] - x, -1.0) if high else (x, 1.0)
        time = wait + time_to_fall(gap - self.radius[i], sign * speed, sign * acceleration)
        if math.isfinite(time):
            self.push(self.time + time, i, wall, ())

    # ---- events --------------------------------------------------------------------------------------------

    def advance(self, until: float, most_rows: int = 0) -> None:
        """Advance to ``until``, or to row number ``most_rows`` of the log."""
        while not most_rows or len(self.log) < most_rows:
            if not self.heap or self.heap[0][0] > min(self.horizon, until):
                if self.horizon >= until:
                    break
                self.move(self.horizon)
                self.look_again()
                continue
            time, i, j, met_i, met_j, image = heapq.heappop(self.heap)
            if met_i != self.met[i] or (j >= 0 and met_j != self.met[j]):
                continue
            self.move(time)
            self.collide(i, j, image)
        else:
            return
        self.move(until)

    def move(self, time: float) -> None:
        t = time - self.time
        self.position += t * (self.velocity + 0.5 * t * self.gravity)
        self.velocity += t * self.gravity
        self.time = time

    def collide(self, i: int, j: int, image: tuple[int, ...]) -> None:
        if j >= 0:
            r = self.position[i] - self.position[j] + np.array(image) * self.box
            v = self.velocity[i] - self.velocity[j]
            share_i, share_j = self.mass[[j, i]] / (self.mass[i] + self.mass[j])
        else:
            axis, high = divmod(-1 - j, 2)
            r = np.zeros(self.dimension)
            r[axis] = -1.0 if high else 1.0
            v, share_i, share_j = self.velocity[i].copy(), 1.0, 0.0
        n = r / np.linalg.norm(r)
        speed = -float(v @ n)
        self.log.append((self.time, i, j, speed))
        change, shift, duration = self.outcome(i, j, n, v, speed)
        self.velocity[i] += share_i * change
        self.position[i] += share_i * shift
        involved = [i] if j < 0 else [i, j]
        if j >= 0:
            self.velocity[j] -= share_j * change
            self.position[j] -= share_j * shift
        for k in involved:
            self.met[k] += 1
            self.last[k] = self.time
        if self.rule.name == "soft":
            other = int(self.met[j]) if j >= 0 else 0
            self.soft[i, j] = (self.time + duration, int(self.met[i]), other, image)
        if self.speeds()[involved].max() > self.fastest:
            self.look_again()
            return
        for k in involved:
            self.predict(k, np.delete(np.arange(self.n), k))

    def outcome(
        self, i: int, j: int, n: np.ndarray, v: np.ndarray, speed: float
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Change of the relative velocity, displacement of the relative position and duration of the contact."""
        rule = self.rule
        if rule.name == "soft":
            return self.soft_outcome(i, j, n, v, speed)
        partners = [i] if j < 0 else [i, j]
        restitution = rule.restitution
        if rule.name == "tc" and any(self.time - self.last[k] < rule.contact_duration for k in partners):
            restitution = 1.0
        elif rule.law is not None:
            restitution = float(self.contact(i, j).restitution(np.array([speed]))[0])
        return (1.0 + restitution) * speed * n, np.zeros_like(n), 0.0

    def soft_outcome(
        self, i: int, j: int, n: np.ndarray, v: np.ndarray, speed: float
    ) -> tuple[np.ndarray, np.ndarray, float]:
        across = v + speed * n
        sideways = float(np.linalg.norm(across))
        t = across / sideways if sideways > 0.0 else across
        distance = float(self.radius[i] + self.radius[j]) if j >= 0 else math.inf
        pressing = -float(self.gravity @ n) if j < 0 else 0.0
        end = _core.planar_contact(self.contact(i, j), distance, speed, sideways, pressing)
        assert end["outcome"] == "ok"
        change = end["normal_velocity"] * n + end["tangential_velocity"] * t - v
        return change, end["normal_shift"] * n + end["tangential_shift"] * t, end["duration"]

    def contact(self, i: int, j: int) -> _core.Contact:
        assert self.rule.law is not None
        balls = [hl.Ball(self.radius[k], mass=self.mass[k]) for k in (i, j) if k >= 0]
        return self.rule.law.between(balls[0], balls[1] if j >= 0 else hl.FLOOR).core


def times_to_touch(r: np.ndarray, v: np.ndarray, touch: np.ndarray) -> np.ndarray:
    """Time when |r + v t| falls to ``touch``; 0 for a pair that overlaps and approaches, infinity if there is none."""
    approach, square, distance = (r * v).sum(-1), (v * v).sum(-1), np.linalg.norm(r, axis=-1)
    gap = (distance - touch) * (distance + touch)
    reach = approach * approach - square * gap
    with np.errstate(invalid="ignore", divide="ignore"):
        later = gap / (np.sqrt(reach) - approach)
    meets = (approach < 0.0) & ((gap <= 0.0) | (reach >= 0.0))
    return np.where(meets, np.where(gap <= 0.0, 0.0, later), math.inf)


def time_to_fall(gap: float, speed: float, acceleration: float) -> float:
    """Time when gap + speed t + acceleration t²/2 falls to zero; 0 for a body at or in the wall that moves inwards.

    A body that moves out of the wall may fall back, or reverse within it.
    """
    if gap <= 0.0 and (speed < 0.0 or (speed == 0.0 and acceleration < 0.0)):
        return 0.0
    square = speed * speed - 2.0 * acceleration * gap
    if gap <= 0.0:
        return (speed + math.sqrt(max(square, 0.0))) / -acceleration if acceleration < 0.0 else math.inf
    if square < 0.0 or (acceleration >= 0.0 and speed >= 0.0):
        return math.inf
    if speed < 0.0:
        return 2.0 * gap / (math.sqrt(square) - speed)
    return (speed + math.sqrt(square)) / -acceleration
