"""What a solver found about one column: contacts, velocities, trajectories (see docs/definitions.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .scenario import Column

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Solver = Callable[[float], _core.Solution]


class Result:
    """Outcome of one drop under one model. Times in s after the first floor touch (cradle: after release).

    Attributes
    ----------
    column : Column
    model : str
        ``"newton"``, ``"adiabatic"`` or ``"independent"``.
    method : str
        How it was solved, in words.
    """

    def __init__(self, column: Column, model: str, method: str, solver: Solver, until: float | None) -> None:
        self.column = column
        self.model = model
        self.method = method
        self.until = until
        self._solver = solver
        self._core = solver(math.nan if until is None else until)

    def __repr__(self) -> str:
        v = f"{self.relative_velocity:.6g} m/s" if not math.isnan(self.relative_velocity) else "undefined"
        found = f"{self.n_contacts} ball–ball contacts, v'_r {v}, {self.outcome}"
        return f"<Result of {self.model} ({self.method}): {found}>"

    @property
    def n_contacts(self) -> int:
        """Ball–ball contacts of the sequence, re-engagements of the clipped force included."""
        return self._core.n_contacts

    @property
    def t_end(self) -> float:
        """t_f [s]: end of the last ball–ball contact that began before the second floor contact."""
        return self._core.t_end

    @property
    def t_floor_end(self) -> float:
        """Time [s] at which the floor force first vanishes; NaN for a cradle or if it never does."""
        return self._core.t_floor_end

    @property
    def relative_velocity(self) -> float:
        """The paper's v'_r = v2 − v1 at ``t_end`` [m/s], when the floor may still push. Two balls, else NaN."""
        return self._core.relative_velocity

    @property
    def separation_velocity(self) -> float:
        """v2 − v1 at the first instant after ``t_end`` when no force acts and the gap is not closing [m/s]."""
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

    @property
    def outcome(self) -> str:
        """``"ok"``, or one sentence that says what happened instead."""
        return str(_core.outcome_messages[self._core.outcome])

    @property
    def outcome_code(self) -> int:
        """The outcome as an integer; 0 is ok, the names are those of ``hardlimit.OUTCOMES``."""
        return self._core.outcome

    @property
    def energy_error(self) -> float:
        """Largest error of the energy balance relative to the initial energy; NaN unless integrated."""
        return self._core.energy_error

    @cached_property
    def contacts(self) -> xr.Dataset:
        """Dataset over ``contact``: ``pair`` (0 = floor–lowest, 1 = lowest–second, …), ``begin``, ``end`` [s].

        ``end`` is NaN for a contact that never ends. With ``until``, the contacts that began up to it.
        """
        import xarray as xr

        pair, begin, end = self._core.contacts()
        if self.until is not None:
            kept = begin <= self.until
            pair, begin, end = pair[kept], begin[kept], end[kept]
        seconds = {"units": "s", "long_name": "time after the first floor touch"}
        return xr.Dataset(
            {
                "pair": (
                    "contact",
                    pair,
                    {"long_name": "0 = floor and lowest ball, 1 = lowest and second, …"},
                ),
                "begin": ("contact", begin, seconds),
                "end": ("contact", end, seconds),
            }
        )

    @cached_property
    def _final(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        at = self.t_end if len(self.column.balls) == 2 and self.column.floor else self._core.t_last
        if self.until is not None:
            at = self.until
        if math.isnan(at):
            at = self._core.t_last
        sampled = self._sample(np.array([at]))
        return sampled[0][0], sampled[1][0]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres [m], bottom first: at ``until`` if given, else at the end (``t_end`` for two balls)."""
        return self._final[0]

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities [m/s], upwards, bottom first, at the time of ``positions``."""
        return self._final[1]

    def _sample(self, times: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        core = self._core
        last = float(times.max(initial=-math.inf))
        if last > core.t_last:  # beyond what was solved: go on
            core = self._solver(last)
        return core.sample(times)

    def default_times(self) -> NDArray[np.float64]:
        """Times that show the contacts well: evenly spaced over the sequence, and every begin and end."""
        _, begin, end = self._core.contacts()
        marks = np.concatenate([begin, end])
        marks = marks[np.isfinite(marks)]
        if self.until is not None:
            start, stop = min(0.0, self.until), self.until
        else:
            stop = float(marks.max(initial=0.0))
            start = float(marks.min(initial=0.0))
            margin = 0.05 * (stop - start)
            start, stop = max(start - margin, self._core.t_first), stop + margin
        inside = marks[(marks >= start) & (marks <= stop)]
        return np.unique(np.concatenate([np.linspace(start, stop, 1001), inside]))

    def trajectory(self, times: ArrayLike | None = None) -> xr.Dataset:
        """Positions, velocities, contact forces and energies at ``times`` [s], any time from release on.

        Returns
        -------
        xarray.Dataset
            Dimensions ``time``, ``ball`` (1 = lowest) and ``pair`` (0 = floor–lowest); ``position`` [m],
            ``velocity`` [m/s], ``force`` [N], ``kinetic_energy``, ``potential_energy`` (zero when all gaps are),
            ``contact_energy`` and ``dissipated_energy`` [J].

        Raises
        ------
        ValueError
            If a time lies before release or is not finite.
        """
        import xarray as xr

        at = np.atleast_1d(
            np.asarray(self.default_times() if times is None else times, dtype=np.float64)
        ).ravel()
        first = self._core.t_first
        for bad in at[~(np.isfinite(at) & (at >= first * (1.0 + 1e-12)))]:
            raise ValueError(f"times: got {bad:.16g}, must be >= {first:.16g} (release) and finite")
        position, velocity, force, kinetic, potential, stored, dissipated = self._sample(
            np.ascontiguousarray(np.maximum(at, first))
        )
        n = len(self.column.balls)
        pairs = np.arange(0 if self.column.floor else 1, n)
        joule = {"units": "J"}
        return xr.Dataset(
            {
                "position": (("time", "ball"), position, {"units": "m", "long_name": "height of the centre"}),
                "velocity": (("time", "ball"), velocity, {"units": "m/s", "long_name": "velocity, upwards"}),
                "force": (("time", "pair"), force[:, pairs], {"units": "N", "long_name": "contact force"}),
                "kinetic_energy": ("time", kinetic, joule),
                "potential_energy": ("time", potential, joule | {"long_name": "zero when all gaps are"}),
                "contact_energy": ("time", stored, joule | {"long_name": "elastic energy of the contacts"}),
                "dissipated_energy": ("time", dissipated, joule),
            },
            coords={
                "time": ("time", at, {"units": "s", "long_name": "time after the first floor touch"}),
                "ball": np.arange(1, n + 1),
                "pair": pairs,
            },
        )

    def plot(self) -> Figure:
        """Contact forces over time, as in Fig. 2 of the paper."""
        from ..pictures import plots

        return plots.forces(self)

    def animate(self, path: str | Path, **options: Any) -> Path:
        """Write a slow-motion animation of the drop as MP4 or GIF (by the ending of ``path``)."""
        from ..pictures import animation

        return animation.animate(self, path, **options)
