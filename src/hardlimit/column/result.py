"""Result of a column under one model: contacts, velocities, trajectories (defined in docs/definitions.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..contact import compression
from ..support import html, validation
from ..support.formatting import digits
from .models import MODELS, Model
from .scenario import Column

PAIRS: Final = "0 = floor and lowest ball, 1 = lowest and second, …"
ENERGIES: Final = {
    "kinetic_energy": "kinetic energy",
    "potential_energy": "zero when all gaps are",
    "contact_energy": "elastic energy of the contacts",
    "dissipated_energy": "dissipated energy",
}

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from .._core import Solution


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Result of a column under one model, returned by its solver.

    Times are in s after the first floor touch, or for a cradle after its release. A result is immutable, and its arrays
    are read-only. A copy, or a result that was sent to another process, is solved again at first use, with the same
    bits. :doc:`/definitions` defines each number exactly.

    Notes
    -----
    Symbols are those of the paper, Müller & Pöschel, Phys. Rev. E 83, 041304 (2011).

    Examples
    --------
    >>> drop = hl.newton(hl.Column.paper(gap=1e-4))
    >>> drop.n_contacts, f"{drop.t_end * 1e3:.3f} ms", drop.outcome
    (4, '0.721 ms', 'ok')
    >>> drop.final_velocities.round(2)  # lower and upper ball [m/s]
    array([2.19, 2.32])
    >>> drop.contacts.begin.values.round(6)  # the floor's first
    array([0.      , 0.000194, 0.000388, 0.00054 , 0.000695])
    """

    column: Column  #: the column that was solved
    model: str  #: ``"newton"``, ``"adiabatic"`` or ``"independent"``
    method: str  #: describes the solver
    until: float | None  #: the requested end time [s], if any
    options: tuple[Any, ...] = ()  #: further arguments of the model's solver

    @classmethod
    def _solved(
        cls, column: Column, model: Model, method: str, until: float | None, options: tuple[Any, ...] = ()
    ) -> Result:
        """Solve at once, so that errors and interrupts are raised by the caller's call."""
        core = model.solve(column.core, math.nan if until is None else until, *options)
        if until is not None:
            _refuse_before_release("until", until, core)
        # The constructor of a frozen dataclass would take a microsecond, as long as a solve.
        result = object.__new__(cls)
        result.__dict__.update(
            column=column, model=model.name, method=method, until=until, options=options, _core=core
        )
        if core.presses_by(compression.DEEP):
            compression.warn(compression.DEEP)
        return result

    @cached_property
    def _core(self) -> Solution:
        return self._solve(math.nan if self.until is None else self.until)

    def _solve(self, until: float) -> Solution:
        return MODELS[self.model].solve(self.column.core, until, *self.options)

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __repr__(self) -> str:
        v = f"{self.relative_velocity:.6g} m/s" if not math.isnan(self.relative_velocity) else "undefined"
        summary = f"{self.n_contacts} ball–ball contacts, v'_r {v}, {self.outcome}"
        return f"<Result of {self.model} ({self.method}): {summary}>"

    def _repr_html_(self) -> str:
        rows = [[label, digits(value)] for label, value in quantities(self)]
        rows.append(["outcome", self.outcome])
        model = MODELS[self.model]
        return html.table(f"{model.label}: {self.method}", ["", ""], rows, f"Limits: {model.limits}.")

    @property
    def n_contacts(self) -> int:
        """Number of ball–ball contacts of the sequence, including re-engagements of the clipped force."""
        return self._core.n_contacts

    @property
    def t_end(self) -> float:
        """t_f [s]: end of the last ball–ball contact that began before the second floor contact.

        For a single ball, the end of its first bounce: the last time at which the floor's force vanishes before the gap
        opens.
        """
        return self._core.t_end

    @property
    def t_floor_end(self) -> float:
        """Time [s] at which the floor force first vanishes; NaN for a cradle or if it never does."""
        return self._core.t_floor_end

    @property
    def relative_velocity(self) -> float:
        """The paper's v'_r = v2 − v1 [m/s] at ``t_end``, when the floor may still push. NaN except for two balls."""
        return self._core.relative_velocity

    @property
    def separation_velocity(self) -> float:
        """v2 − v1 [m/s] at the first instant after ``t_end`` at which no force acts and the gap is not closing."""
        return self._core.separation_velocity

    @property
    def effective_restitution(self) -> float:
        """ε_eff that gives ``relative_velocity`` in the independent-collisions model (Eq. 4 inverted)."""
        return self._effective(self.relative_velocity)

    @property
    def effective_restitution_at_separation(self) -> float:
        """ε_eff that gives ``separation_velocity`` in the independent-collisions model."""
        return self._effective(self.separation_velocity)

    @property
    def restitution_ratio(self) -> float:
        """ε_eff/ε_spec from ``relative_velocity``; NaN unless all contacts were given one ε."""
        return self.effective_restitution / self.column.specified_restitution

    @property
    def restitution_ratio_at_separation(self) -> float:
        """ε_eff/ε_spec from ``separation_velocity``; NaN unless all contacts were given one ε."""
        return self.effective_restitution_at_separation / self.column.specified_restitution

    def _effective(self, velocity: float) -> float:
        if not self.column.floor or len(self.column.balls) != 2:
            return math.nan
        return _core.effective_restitution(velocity, self.column.impact_speed)

    @cached_property
    def largest_compression(self) -> float:
        """Largest compression of all contacts, divided by the smaller radius of the two bodies.

        Contact laws describe small compressions. From 0.05 on there is a warning, and at 0.5 a run ends (see
        :doc:`/limits`). NaN for instantaneous collisions.
        """
        return self._core.largest_compression()

    @property
    def outcome(self) -> str:
        """``"ok"``, or a sentence that says why the run ended early."""
        message = str(_core.outcome_messages[self._core.outcome])
        pair = self._core.too_deep
        if pair < 0:
            return message
        bodies = f"ball {pair} and ball {pair + 1}" if pair else "the floor and ball 1"
        origin = "the first floor touch" if 0 in self._core.contacts()[0] else "release"
        return f"{message} ({bodies}, {self._core.t_last:.6g} s after {origin})"

    @property
    def outcome_code(self) -> int:
        """The outcome as an index of ``hardlimit.OUTCOMES``; 0 is ok."""
        return self._core.outcome

    @property
    def known_until(self) -> float:
        """Time [s] up to which the motion is known: infinite unless the outcome is not resolved or too deep."""
        return _known_until(self._core)

    def _known_up_to(self, end: float) -> float:
        """``end`` [s], or the end of the known motion if that is earlier; continues the solution if needed."""
        return min(end, _known_until(self._continued(end) if math.isinf(self.known_until) else self._core))

    def _continued(self, end: float) -> Solution:
        """The solution, continued to ``end`` [s] if it ends before; the latest continuation is kept."""
        if end <= self._core.t_last:
            return self._core
        kept: tuple[float, Solution] | None = self.__dict__.get("_latest")
        if kept is None or kept[0] != end:
            kept = self.__dict__["_latest"] = end, self._solve(end)
        return kept[1]

    def _padded(self, stop: float, margin: float) -> float:
        """``stop + margin`` [s], as far as the motion is known.

        The margin of instantaneous collisions ends before the next one, since very many may follow it at once.
        """
        end = stop + margin
        if self.model == "independent":
            end = max(stop, min(end, self._core.t_last + 0.9 * self._free_flight()))
        return self._known_up_to(end)

    def _free_flight(self) -> float:
        """Time [s] from the last collision of the solution to the next one, infinite if none follows."""
        column = self.column
        position, velocity, *_ = self._core.sample(np.array([self._core.t_last]))
        radii = np.array([ball.radius for ball in column.balls])
        closing = -np.diff(velocity[0])
        gaps = np.maximum(np.diff(position[0]) - radii[1:] - radii[:-1], 0.0)
        first = float((gaps / closing)[closing > 0.0].min(initial=math.inf))
        height, v = float(position[0, 0] - radii[0]), float(velocity[0, 0])
        if not column.floor or v == 0.0:  # a ball that rests on the floor
            return first
        return float(np.fmin(first, _core.fall_time(height, v, column.gravity)))

    @cached_property
    def final_velocities(self) -> NDArray[np.float64]:
        """Velocities [m/s], upwards, bottom first, at the end of the last contact that ended.

        NaN at rest, and if a contact became too deep. Without ``until`` the second floor contact does not count, since
        it is not part of the sequence.
        """
        return _fixed(np.asarray(self._core.final_velocities()))

    @cached_property
    def rebound_heights(self) -> NDArray[np.float64]:
        """Largest height of each centre above the floor [m] after the ball's first bounce, bottom first.

        With ``until``, the largest up to that time. Without it, the lowest ball is removed at its second floor contact,
        and later contacts between the others count (see :doc:`/definitions`). NaN for a ball that does not bounce, and
        for a cradle.
        """
        return _fixed(np.asarray(self._core.rebound_heights()))

    @property
    def energy_error(self) -> float:
        """Largest error of the energy balance relative to the initial energy; NaN unless the run was integrated."""
        return self._core.energy_error

    @property
    def contact_times(self) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """Pair, begin [s] and end [s] of each contact: ``contacts`` as plain arrays, without importing xarray."""
        pair, begin, end = self._core.contacts()
        if self.until is None:
            return pair, begin, end
        kept = begin <= self.until
        return pair[kept], begin[kept], end[kept]

    @property
    def contacts(self) -> xr.Dataset:
        """Dataset over ``contact``: ``pair`` (0 = floor–lowest, 1 = lowest–second, …), ``begin``, ``end`` [s].

        ``end`` is NaN for a contact that never ends, and for the floor contact that ends a run of more than two balls.
        With ``until``, the contacts that began up to that time.
        """
        return self._contacts.copy()

    @cached_property
    def _contacts(self) -> xr.Dataset:
        import xarray as xr

        pair, begin, end = self.contact_times
        seconds = {"units": "s", "long_name": self._since}
        return xr.Dataset(
            {
                "pair": ("contact", _fixed(pair), {"long_name": PAIRS}),
                "begin": ("contact", _fixed(begin), seconds),
                "end": ("contact", _fixed(end), seconds),
            },
            attrs=self._attributes("Contacts"),
        )

    @property
    def _since(self) -> str:
        return f"time after {'the first floor touch' if self.column.floor else 'release'}"

    def _attributes(self, what: str) -> dict[str, Any]:
        """Attributes of a Dataset by the CF conventions, with everything needed to compute it again."""
        facts: dict[str, Any] = {
            "title": f"{what} of a {'column' if self.column.floor else 'cradle'} of balls",
            "source": f"hardlimit {_core.version}, {MODELS[self.model].label}",
            "model": self.model,
            "method": self.method,
            "column": repr(self.column),
            "outcome": self.outcome,
            "hardlimit_version": _core.version,
        }
        if self.until is not None:
            facts["until"] = self.until
        return facts if math.isinf(self.known_until) else facts | {"known_until": self.known_until}

    @cached_property
    def _final(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        two_balls = len(self.column.balls) == 2 and self.column.floor
        at = self.until if self.until is not None else self.t_end if two_balls else math.nan
        at = self._core.t_last if math.isnan(at) else at
        if self.until is not None and at > self._core.t_last:  # the motion after t_last is unknown
            unknown = _fixed(np.full(len(self.column.balls), math.nan))
            return unknown, unknown
        sampled = self._sample(np.array([max(at, self._core.t_first)]))
        return _fixed(sampled[0][0]), _fixed(sampled[1][0])

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres [m], bottom first, at ``until`` if given, else at the end (``t_end`` for two balls).

        NaN where the solution ends before ``until``; ``outcome`` says why.
        """
        return self._final[0]

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities [m/s], upwards, bottom first, at the time of ``positions``."""
        return self._final[1]

    def _sample(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        return self._continued(float(times.max(initial=-math.inf))).sample(times)

    def default_times(self) -> NDArray[np.float64]:
        """Times that resolve the contacts: evenly spaced over the sequence, and every begin and end."""
        _, begin, end = self._core.contacts()
        marks = np.concatenate([begin, end])
        marks = marks[np.isfinite(marks)]
        if self.until is not None:
            stop = min(self.until, self._core.t_last)
            start = min(0.0, stop)
        else:
            start, stop = float(marks.min(initial=0.0)), float(marks.max(initial=0.0))
            stop = self._core.t_last if self._core.too_deep >= 0 else stop
            margin = 0.05 * (stop - start)
            start, stop = max(start - margin, self._core.t_first), self._padded(stop, margin)
        inside = marks[(marks >= start) & (marks <= stop)]
        return np.unique(np.concatenate([np.linspace(start, stop, 1001), inside]))

    def trajectory(self, times: ArrayLike | None = None) -> xr.Dataset:
        """Positions, velocities, contact forces and energies over time.

        The attribute ``known_until`` is set if the outcome is not resolved or too deep.

        Parameters
        ----------
        times : number or N numbers [s], optional
            Any times after the release. By default :meth:`default_times`, as far as the motion is known.

        Returns
        -------
        xarray.Dataset
            Dimensions ``time``, ``ball`` (1 = lowest) and ``pair`` (0 = floor–lowest); ``position`` [m],
            ``velocity`` [m/s], ``force`` [N], ``kinetic_energy``, ``potential_energy`` (zero when all gaps are),
            ``contact_energy`` and ``dissipated_energy`` [J].

        Raises
        ------
        ValueError
            If ``times`` is not a number or a one-dimensional array of numbers, or if one of them is not finite, before
            the release or after the end of the solution.

        Examples
        --------
        >>> path = hl.newton(hl.Column.paper()).trajectory(np.linspace(0, 1e-3, 101))
        >>> (path.force.max("time") / 1e3).values.round(1)  # floor, pair [kN]
        array([35.9,  0.4])
        """
        import xarray as xr

        at = self.default_times() if times is None else self._times(times)
        position, velocity, force, *energies = self._sample(np.maximum(at, self._core.t_first))
        n = len(self.column.balls)
        pairs = np.arange(0 if self.column.floor else 1, n)
        data: dict[str, Any] = {
            "position": (("time", "ball"), position, {"units": "m", "long_name": "height of the centre"}),
            "velocity": (("time", "ball"), velocity, {"units": "m/s", "long_name": "velocity, upwards"}),
            "force": (("time", "pair"), force[:, pairs], {"units": "N", "long_name": "contact force"}),
        }
        for (name, meaning), values in zip(ENERGIES.items(), energies, strict=True):
            data[name] = ("time", values, {"units": "J", "long_name": meaning})
        coords = {
            "time": ("time", at, {"units": "s", "long_name": self._since}),
            "ball": ("ball", np.arange(1, n + 1), {"long_name": "ball, 1 = lowest"}),
            "pair": ("pair", pairs, {"long_name": PAIRS}),
        }
        return xr.Dataset(data, coords, self._attributes("Trajectory"))

    def _times(self, times: ArrayLike) -> NDArray[np.float64]:
        at = np.atleast_1d(validation.array("times", times, empty_allowed=True))
        _refuse_before_release("times", float(at.min(initial=math.inf)), self._core)
        return at

    def plot(self) -> Figure:
        """Contact forces over time, as in Fig. 2 of the paper."""
        from .. import plots

        return plots.forces(self)

    def animate(self, path: str | Path, **options: Any) -> Path:
        """Write a slow-motion film of the drop as MP4 or GIF, by the suffix of ``path``.

        Parameters
        ----------
        path : path
            The file appears when it is complete.
        **options
            ``ghost``: a Result of the same column under another model, shown beside it; independent collisions by
            default. ``width`` of the 16:9 frames in pixels, 160 to 3840, rounded down to a multiple of 32; 1280 (MP4)
            or 640 (GIF) by default. ``frames_per_second``, 1 to 120; 30 or 15 by default. ``progress``:
            callable(done, total).

        Raises
        ------
        ValueError
            If the suffix is unknown, an option is outside its range, ``ghost`` is of another column, or the suffix is
            MP4 without ``pip install 'hardlimit[film]'``; GIF needs no extra.
        OSError
            If the file cannot be written; names it.
        """
        from ..plots import animation

        return animation.animate(self, path, **options)


def _refuse_before_release(name: str, time: float, core: Solution) -> None:
    """Refuse a time before the release, which only the solution knows if balls meet before the first floor touch."""
    first = core.t_first
    if not time >= first * (1.0 + 1e-12):
        raise ValueError(f"{name}: got {time:.16g}, must be >= {validation.at_least(first)}, the release")


def _known_until(core: Solution) -> float:
    """End of the known motion of a solution [s]: infinite unless it is not resolved or too deep."""
    unresolved = _core.outcome_names[core.outcome] == "unresolved"
    return core.t_last if unresolved or core.too_deep >= 0 else math.inf


def _fixed(array: NDArray[Any]) -> NDArray[Any]:
    """Make the array read-only, because a result caches it."""
    array.flags.writeable = False
    return array


def quantities(result: Result) -> list[tuple[str, float]]:
    """Labels and values (SI units) of a result, for tables."""
    column = result.column
    rows: list[tuple[str, float]] = [("ball–ball contacts", result.n_contacts)]
    if len(column.balls) > 1:
        rows.append(("end of the sequence t_f [s]", result.t_end))
    if column.floor:
        rows.append(("end of the floor contact [s]", result.t_floor_end))
    if column.floor and len(column.balls) == 2:
        rows += [
            ("relative velocity v'r at t_f [m/s]", result.relative_velocity),
            ("separation velocity [m/s]", result.separation_velocity),
            ("effective ε at t_f", result.effective_restitution),
            ("effective ε at separation", result.effective_restitution_at_separation),
            ("effective ε / ε at t_f", result.restitution_ratio),
            ("effective ε / ε at separation", result.restitution_ratio_at_separation),
        ]
    rows += compression.rows(result.largest_compression)
    for i in reversed(range(len(column.balls))):
        rows.append((f"final velocity of ball {i + 1} [m/s]", float(result.final_velocities[i])))
    for i in reversed(range(len(column.balls) if column.gravity else 0)):
        rows.append((f"rebound height of ball {i + 1} [m]", float(result.rebound_heights[i])))
    return rows
