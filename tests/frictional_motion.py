"""An isolated contact with friction, integrated by SciPy in the coordinates of both bodies.

Written from the equations (Cundall & Strack 1979; arms a_i = R_i r/(R_i + R_j), parallel transport of the elastic
force) and independent of the core: positions, velocities and spins of both bodies and T as vectors in space.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Vector = NDArray[np.float64]
#: Part of the largest normal force below which the direction of slip is kept: its impulse is the square of this.
NEGLIGIBLE = 1e-6
#: Start of a slip from zero force, over the duration of the contact.
INSTANT = 1e-9
#: Compression at which the last step of an undamped contact begins, over its duration times its speed: powers of a
#: compression that ends at zero have no derivative there.
LAST = 1e-7
#: Force over its limit, in units of the largest normal force, up to which surfaces stick: where they begin to, it is at
#: its limit but for rounding.
ROUNDING = 1e-11
#: A contact that takes more is left out.
MAX_EVALUATIONS = 40_000
TOLERANCE = 1e-13
#: While the spring follows its limit: the part of the damping is that of differences.
ROUGH = 1e-11


def cross(a: Vector, b: Vector) -> Vector:
    """For two vectors; faster than NumPy's, which takes arrays of them."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def norm(a: Vector) -> float:
    return math.sqrt(a @ a)


class TooCostlyError(Exception):
    """A contact of more than ``MAX_EVALUATIONS``, or of steps that are too small for SciPy."""


@dataclass
class Pair:
    """Two bodies (``mass[1]`` infinite: a wall) with F = K ξ^p + C ξ^q dξ/dt and friction; units of order 1."""

    mass: tuple[float, float]
    radius: tuple[float, float]
    inertia_factor: tuple[float, float]
    powers: tuple[float, float]  # p, q
    coefficients: tuple[float, float]  # K, C
    terms: Any  # hl.contact.friction.FrictionTerms

    @property
    def wall(self) -> bool:
        return self.mass[1] == np.inf

    def normal_force(self, depth: float, rate: float) -> float:
        (p, q), (k, c) = self.powers, self.coefficients
        depth = max(depth, 0.0)
        return k * depth**p + c * depth**q * rate

    def force_growth(self, depth: float, rate: float, acceleration: float) -> float:
        (p, q), (k, c) = self.powers, self.coefficients
        depth = max(depth, 1e-300)
        slope = k * p * depth ** (p - 1.0) + c * q * depth ** (q - 1.0) * rate
        return slope * rate + c * depth**q * acceleration


class Motion:
    """State: displacements since touch, velocities, spins of both bodies and T: 21 numbers."""

    def __init__(self, pair: Pair, normal: Vector, instant: float) -> None:
        self.pair, self.normal, self.size = pair, normal, instant
        self.slips = self.unloads = False
        self.evaluations = 0
        self.part: float | None = None  # of the damping, while the spring follows its limit without slip
        self.held: float | None = None  # that part, once the rest of the normal force no longer matters
        self.kept: Vector | None = None  # direction of slip, likewise

    def geometry(self, y: Vector) -> tuple[Any, ...]:
        pair, (ri, rj) = self.pair, self.pair.radius
        x, v, spin = y[:6].reshape(2, 3), y[6:12].reshape(2, 3), y[12:18].reshape(2, 3)
        moved = x[1] - x[0]
        if pair.wall:
            n, depth, arms, per_r = self.normal, -(moved @ self.normal), (ri, 0.0), 0.0
        else:
            apart = (ri + rj) * self.normal + moved
            r = norm(apart)
            n, depth = apart / r, -(2.0 * (ri + rj) * (moved @ self.normal) + moved @ moved) / (ri + rj + r)
            arms, per_r = (ri * r / (ri + rj), rj * r / (ri + rj)), 1.0 / r
        relative = v[1] - v[0]
        radial = relative @ n
        turning = (relative - radial * n) * per_r  # dn/dt
        roll = arms[0] * spin[0] + arms[1] * spin[1]
        g = relative - cross(roll, n)
        return n, depth, -radial, turning, arms, g - (g @ n) * n, spin

    def pieces(self, y: Vector) -> dict[str, Any]:
        n, depth, rate, turning, arms, g, spin = self.geometry(y)
        terms, pair = self.pair.terms, self.pair
        level = max(depth, 0.0)
        stiffness = terms.stiffness * level ** (0.25 * terms.stiffness_power)
        damping = terms.damping * level ** (0.25 * terms.damping_power)
        if terms.limit == 1 and self.slips and terms.stiffness > 0.0:
            damping = 0.0
        normal = pair.normal_force(depth, rate)
        elastic = y[18:21] - (y[18:21] @ n) * n
        force = elastic + (1.0 if self.part is None else self.part) * damping * g
        if self.slips and terms.stiffness == 0.0:
            force = terms.coefficient * normal * g / norm(g)
        if self.kept is not None:
            kept = self.kept - (self.kept @ n) * n
            force = terms.coefficient * normal * kept / norm(kept)
        return dict(
            n=n,
            depth=depth,
            rate=rate,
            turning=turning,
            arms=arms,
            g=g,
            spin=spin,
            level=level,
            stiffness=stiffness,
            damping=damping,
            normal=normal,
            elastic=elastic,
            force=force,
        )

    def accelerations(self, at: dict[str, Any]) -> tuple[Vector, Vector]:
        pair, total = self.pair, at["normal"] * at["n"] - at["force"]  # on the second body
        linear, angular = np.zeros((2, 3)), np.zeros((2, 3))
        for i, sign in ((0, -1.0), (1, 1.0)):
            if pair.mass[i] < np.inf:
                inertia = pair.inertia_factor[i] * pair.mass[i] * pair.radius[i] ** 2
                linear[i] = sign * total / pair.mass[i]
                angular[i] = at["arms"][i] / inertia * cross(at["n"], at["force"])
        return linear, angular

    def drive(self, at: dict[str, Any], linear: Vector, angular: Vector) -> tuple[Vector, float]:
        """The rate of T + γ_t g without slip, seen with the normal; and the rate of slip times k_t."""
        terms, n, m = (
            self.pair.terms,
            at["n"],
            self.pair.terms.unloading if self.unloads else self.pair.terms.loading,
        )
        ri, rj = self.pair.radius
        relative = linear[1] - linear[0]
        arms, spin = at["arms"], at["spin"]
        shares = (0.0, 0.0) if self.pair.wall else (ri / (ri + rj), rj / (ri + rj))
        roll = arms[0] * spin[0] + arms[1] * spin[1]
        roll_rate = arms[0] * angular[0] + arms[1] * angular[1]
        roll_rate = roll_rate - at["rate"] * (shares[0] * spin[0] + shares[1] * spin[1])
        # d/dt of g_t = v_t − roll×n, projected on the tangent plane; v_t = v + ξ̇ n, d(ξ̇ n)/dt adds ξ̇ dn/dt.
        g_rate = relative + at["rate"] * at["turning"] - cross(roll_rate, n) - cross(roll, at["turning"])
        g_rate -= (g_rate @ n) * n
        level = max(at["level"], 1e-300)
        h = at["stiffness"] * at["g"] + at["damping"] * g_rate
        h = h + 0.25 * terms.damping_power * at["damping"] * at["rate"] / level * at["g"]
        h = h + 0.5 * m * at["rate"] / level * at["elastic"]
        acceleration = -(relative @ n) - np.dot(at["turning"], at["turning"]) / max(self._per_r(at), 1e-300)
        growth = self.pair.force_growth(at["depth"], at["rate"], acceleration)
        size = norm(at["force"])
        f = at["force"] / size if size > 0.0 else at["g"] * 0.0
        return h, float(h @ f - terms.coefficient * growth)

    def _per_r(self, at: dict[str, Any]) -> float:
        return np.inf if self.pair.wall else 1.0 / (sum(self.pair.radius) - at["depth"])

    def at_limit(self, y: Vector) -> Vector:
        """T that is nearest to that of this state and just at its limit."""
        at, terms = self.pieces(y), self.pair.terms
        if terms.stiffness == 0.0:
            return y[18:21]
        limited = at["elastic" if terms.limit == 1 else "force"]
        return at["elastic"] + (terms.coefficient * at["normal"] / norm(limited) - 1.0) * limited

    def yielding(self, y: Vector) -> float:
        """The rate of the spring at its limit, without slip, less that of the limit."""
        at = self.pieces(y)
        at["damping"], at["force"] = 0.0, at["elastic"]
        return self.drive(at, *self.accelerations(at))[1]

    def following_part(self, y: Vector) -> float:
        """Part of the damping that keeps the spring at its limit; infinite if all of it is too little."""
        if self.held is not None:
            return self.held
        ends = []
        for self.part in (0.0, 1.0):
            speed = self.rates(y)
            step = 1e-4 / (1.0 + np.abs(speed[:6]).max()) * self.size
            ends.append((self.yielding(y + step * speed) - self.yielding(y - step * speed)) / (2.0 * step))
        none, whole = ends
        return (-none - self.yielding(y) / self.size) / (whole - none) if whole > max(0.0, none) else np.inf

    def __call__(self, _: float, y: Vector) -> Vector:
        self.evaluations += 1
        if self.evaluations > MAX_EVALUATIONS:
            raise TooCostlyError
        if self.part is not None:
            self.part = min(self.following_part(y), 10.0)  # of a step that goes too far
        return self.rates(y)

    def rates(self, y: Vector) -> Vector:
        at = self.pieces(y)
        linear, angular = self.accelerations(at)
        terms, n = self.pair.terms, at["n"]
        m = terms.unloading if self.unloads else terms.loading
        rate = at["stiffness"] * at["g"]
        if at["level"] > 0.0 and m and self.kept is None:
            rate = rate + 0.5 * m * at["rate"] / at["level"] * at["elastic"]
        if self.slips and terms.stiffness > 0.0 and self.kept is None:
            _, excess = self.drive(at, linear, angular)
            rate = rate - excess * at["force"] / norm(at["force"])
        rate = rate - (at["elastic"] @ at["turning"]) * n
        return np.concatenate([y[6:12], linear.ravel(), angular.ravel(), rate])


def integrate(
    pair: Pair, y: Vector, normal: Vector, duration: float
) -> tuple[Vector, float, list[tuple[float, bool]]]:
    """State at the end, time, and the intervals (begin, slips) of a contact of about this duration."""
    motion, t, terms = Motion(pair, normal, 0.01 * duration), 0.0, pair.terms
    y = np.concatenate([y, np.zeros(3)])
    motion.slips, y, t = first_surfaces(motion, y, duration)
    intervals = [(0.0, motion.slips)]
    smallest = 1e-2 * np.repeat([duration, 1.0, 1.0 / duration], [6, 12, 3])  # of what counts
    for _ in range(60):
        names, events = event_functions(motion, duration)
        run = solve_ivp(
            motion,
            (t, t + 20.0 * duration),
            y,
            "DOP853",
            events=events,
            first_step=1e-7 * duration,
            max_step=0.04 * duration,
            rtol=TOLERANCE if motion.part is None else ROUGH,
            atol=TOLERANCE * smallest,
        )
        if not run.success:  # steps as small as the spacing of numbers
            raise TooCostlyError
        which = next(i for i, times in enumerate(run.t_events) if len(times))
        t, y = float(run.t_events[which][0]), run.y_events[which][0].copy()
        event, at = names[which], motion.pieces(y)
        if event == "end":
            left = at["depth"] / -at["rate"] if pair.coefficients[1] == 0.0 else 0.0
            return (y + left * motion.rates(y))[:18], t + left, intervals
        if event == "turn":
            motion.unloads = True
            continue
        if event == "negligible":
            motion.held = None if motion.part is None else motion.following_part(y)
            motion.kept = at["force"] / norm(at["force"]) if motion.slips else None
            continue
        if event == "hold":
            motion.part = None
            continue
        if event == "stick":
            y[18:21] = motion.at_limit(y)
            motion.slips, motion.part = False, None
            if terms.stiffness > 0.0 and terms.limit == 1 and terms.damping > 0.0:
                part = motion.following_part(y)
                motion.part = part if part < 1.0 else None
        else:
            motion.part = None
            motion.slips = True
            y[18:21] = motion.at_limit(y)
        intervals.append((t, motion.slips))
    raise AssertionError("too many changes")


def first_surfaces(motion: Motion, y: Vector, duration: float) -> tuple[bool, Vector, float]:
    """Whether the surfaces slip at touch; the state then, a little later if the normal force starts from zero."""
    pair, terms = motion.pair, motion.pair.terms
    at = motion.pieces(y)
    mu, speed = terms.coefficient, norm(at["g"])
    if speed == 0.0 or mu == np.inf:
        return False, y, 0.0
    depth = INSTANT * duration * at["rate"]
    stiffness = terms.stiffness * depth ** (0.25 * terms.stiffness_power)
    spring = (
        stiffness * speed * depth / at["rate"] / (0.25 * terms.stiffness_power + 1.0 - 0.5 * terms.loading)
    )
    damping = terms.damping * depth ** (0.25 * terms.damping_power)
    if terms.limit == 1 and terms.stiffness > 0.0:
        damping = 0.0
    limit = mu * pair.normal_force(
        depth if pair.powers[1] > 0 or pair.coefficients[1] == 0 else 0.0, at["rate"]
    )
    first = pair.normal_force(0.0, at["rate"])  # the depth at touch may be a rounding error
    if first > 0.0:
        spring = 0.0
    if spring + damping * speed <= limit:
        return False, y, 0.0
    if terms.stiffness == 0.0:
        return True, y, 0.0
    y = y.copy()
    start = 0.0
    if first == 0.0:  # a little later
        start = INSTANT * duration
        y[:6] += start * y[6:12]
        at = motion.pieces(y)
    motion.slips = True
    for sign in (1.0, -1.0):  # a history that grows with the contact radius may drive the surfaces
        f = sign * at["g"] / norm(at["g"])
        y[18:21] = mu * at["normal"] * f - (at["damping"] * at["g"] if terms.limit == 0 else 0.0)
        now = motion.pieces(y)
        if motion.drive(now, *motion.accelerations(now))[1] > 0.0:
            return True, y, start
    f = at["g"] / norm(at["g"])
    y[18:21] = mu * at["normal"] * f - (at["damping"] * at["g"] if terms.limit == 0 else 0.0)
    motion.slips = False
    return False, y, start


def event_functions(motion: Motion, duration: float) -> tuple[list[str], list[Any]]:
    terms = motion.pair.terms

    def end(_: float, y: Vector) -> float:
        at = motion.pieces(y)
        if at["rate"] >= 0.0:
            return 1.0
        last = at["depth"] - LAST * duration
        if c == 0.0:
            return last
        if p == q:  # the force may last until the bodies part
            return min(last, k + c * at["rate"])
        return k * max(at["depth"], 0.0) ** (p - q) + c * at["rate"]

    def turn(_: float, y: Vector) -> float:
        return motion.pieces(y)["rate"]

    def grip(_: float, y: Vector) -> float:
        at = motion.pieces(y)
        limited = at["elastic"] if terms.limit == 1 and terms.stiffness > 0.0 else at["force"]
        return terms.coefficient * at["normal"] - norm(limited) + ROUNDING * scale

    def slipping(_: float, y: Vector) -> float:
        at = motion.pieces(y)
        if terms.stiffness == 0.0:
            return at["damping"] * norm(at["g"]) - terms.coefficient * at["normal"]
        return motion.drive(at, *motion.accelerations(at))[1]

    def negligible(_: float, y: Vector) -> float:
        at = motion.pieces(y)
        part = NEGLIGIBLE if motion.part is None else 10.0 * NEGLIGIBLE  # by differences over 1e-6 durations
        return at["normal"] - part * scale if at["rate"] < 0.0 else 1.0

    (p, q), (k, c) = motion.pair.powers, motion.pair.coefficients
    scale = k ** (1.0 / (p + 1.0))

    def follows(_: float, y: Vector) -> float:
        return motion.following_part(y)

    def holds(_: float, y: Vector) -> float:
        return 1.0 - motion.following_part(y)

    chosen: list[tuple[str, Any]] = [("end", end)]
    if terms.loading != terms.unloading and not motion.unloads:
        chosen.append(("turn", turn))
    if motion.part is not None and motion.held is None:
        chosen += [("slip", follows), ("hold", holds), ("negligible", negligible)]
    elif motion.part is None and terms.coefficient < np.inf and motion.kept is None:
        chosen += [("stick", slipping), ("negligible", negligible)] if motion.slips else [("slip", grip)]
    for _, event in chosen:
        event.terminal, event.direction = True, -1.0
    return [name for name, _ in chosen], [event for _, event in chosen]
