"""What a comparison of models found: every replica, means with their errors, differences, one sentence."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..boxes.box import Floats
from ..support import html, validation
from . import report as words
from . import statistics
from .encounters import EDGES
from .replica import DIVERGENCE, QUANTITIES, Arrays, Plan

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr
    from matplotlib.figure import Figure

#: Of a whole run: unit and meaning.
TOTALS: Final = {
    "overlapped_share": (
        "1",
        "share of the contacts that shared a particle with another one while they lasted; hard spheres: that would "
        "have, by the law’s duration",
    ),
    "median_restitution": ("1", "median of separation speed over impact speed of the contacts"),
    "n_contacts": ("1", "contacts of a replica, those with walls included"),
    "largest_compression": (
        "1",
        "largest compression of a replica over the smaller radius, as the law has contacts",
    ),
    "end_time": ("s", "time at which the run ended"),
}
STATISTICS: Final = ("mean", "standard_error")
#: Relative difference that must be told apart, unless asked otherwise.
RESOLUTION: Final = 0.01


class Departure(NamedTuple):
    """Where a rule is first told apart from Newton's equations; made by ``Fidelity.departure``.

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     16, 0.65, 1e-3, 2500.0, rms_speed=0.1, dimension=2
    ... )
    >>> law = hl.LinearDashpot(stiffness=10.0, restitution=0.3)
    >>> found = hl.fidelity(
    ...     box, law=law, until=0.04, models=["newton", "law"], replicas=8, samples=8
    ... )
    >>> time, size, error = found.departure("pressure", "law")
    >>> f"at {time * 1e3:.0f} ms by {100 * size:.0f} ± {100 * error:.0f} %"
    'at 20 ms by -7 ± 1 %'
    """

    time: float  #: [s]
    size: float  #: relative difference there
    error: float  #: its standard error


@dataclass(frozen=True, eq=False, repr=False)
class Fidelity:
    """One initial state under Newton's equations and rules for hard spheres, over replicas; made by :func:`fidelity`.

    ``print(f)`` gives one sentence, ``f.dataset`` everything, ``f.plot()`` a figure. It never changes.

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     16, 0.3, 1e-3, 2500.0, rms_speed=0.1, dimension=2
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.8)
    >>> found = hl.fidelity(
    ...     box, law=law, until=0.02, models=["newton", "law"], replicas=4, samples=4
    ... )
    >>> found.outcomes("law"), f"{found.tc_nu:.4f}"
    (['ok', 'ok', 'ok', 'ok'], '0.0139')
    >>> found.told_apart("granular_temperature", "law")
    False
    >>> estimate = found.final_difference("granular_temperature", "law")
    >>> f"{100 * estimate.mean:.1f} ± {100 * estimate.error:.1f} %"
    '-0.1 ± 0.1 %'
    >>> found.resolved("cooling", "law"), f"± {100 * found.bar('cooling', 'law'):.1f} %"
    (False, '± 5.6 %')
    >>> found.replicas_needed("cooling", "law")  # for ± 1 %
    29.0
    >>> found.difference("pressure", "law").mean.shape  # one for each sample
    (5,)
    >>> found.departure("granular_temperature", "law") is None
    True
    >>> print(found.save("fidelity.nc"), found.summary(), sep=": ")
    fidelity.nc: At t_c ν = 0.014 ...
    """

    plan: Plan  #: what is compared, over which samples
    system: str  #: the start of replica 0 in words
    dimension: int  #: 2 or 3
    arrays: tuple[Arrays, ...] = field(repr=False)  #: of each replica
    resolution: float = RESOLUTION  #: relative difference that should be told apart

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the models, Newton's equations first."""
        return self.plan.models

    @property
    def n_replicas(self) -> int:
        """Number of replicas; one gives no error bars and no verdict."""
        return len(self.arrays)

    @property
    def contact_duration(self) -> float:
        """t_c [s]: that of the law at the mean impact speed of the start, or as given."""
        return self.plan.contact_duration

    @cached_property
    def tc_nu(self) -> float:
        """t_c ν: contact duration times the collision rate under Newton's equations, mean over run and replicas; NaN
        where there is no time for a rate."""
        rate = self._all("collision_rate")[:, 0]
        last = self.last_common(0)
        return self.contact_duration * float(rate[:, last].mean())

    @property
    def bars(self) -> str:
        """How long the error bars are, in words."""
        if self.n_replicas < 2:
            return "none: one replica"
        return (
            f"{statistics.student(self.n_replicas - 1):.3g} standard errors (99 % of Student’s distribution)"
        )

    def _all(self, name: str) -> Floats:
        """Of all replicas, the first axis."""
        return np.array([found[name] for found in self.arrays])

    def last_common(self, model: int) -> int:
        """The last sample that this model and Newton's equations reached in every replica.

        :meta private:
        """
        there = np.isfinite(self._all("granular_temperature")[:, [0, model]]).all(axis=(0, 1))
        return int(np.flatnonzero(there)[-1])

    def _number_of(self, model: str) -> int:
        return self.models.index(validation.one_of("model", model, self.models))

    def outcomes(self, model: str) -> list[str]:
        """How the run of each replica ended, as a name among ``hardlimit.OUTCOMES``.

        Parameters
        ----------
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such model.
        """
        i = self._number_of(model)
        return [_core.outcome_names[int(found["outcome"][i])] for found in self.arrays]

    # --- differences ----------------------------------------------------------------------------------------

    def difference(self, quantity: str, model: str) -> statistics.Estimate:
        """(model − Newton) over the magnitude of Newton at every sample: mean and standard error over paired replicas.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        values = self._all(validation.one_of("quantity", quantity, tuple(QUANTITIES)))
        return statistics.relative_difference(values[:, self._number_of(model)], values[:, 0])

    def final_difference(self, quantity: str, model: str) -> statistics.Estimate:
        """The difference at the last sample that both reached in every replica; NaN if that is the start.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        found, last = self.difference(quantity, model), self.last_common(self._number_of(model))
        if last == 0:
            return statistics.Estimate(np.array(math.nan), np.array(math.nan))
        return statistics.Estimate(found.mean[last], found.error[last])

    def told_apart(self, quantity: str, model: str) -> bool:
        """Whether the final difference is outside its bars: 99 % of Student's distribution.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        return bool(statistics.outside(self.final_difference(quantity, model), self.n_replicas))

    def bar(self, quantity: str, model: str) -> float:
        """How long the bar of the final difference is: 99 % of Student's distribution; NaN for one replica.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        return float(statistics.bar(self.final_difference(quantity, model).error, self.n_replicas))

    def resolved(self, quantity: str, model: str) -> bool:
        """Whether the bar of the final difference is not longer than ``resolution``.

        Only then is a rule that is not told apart known to be near to Newton's equations.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        return self.bar(quantity, model) <= self.resolution

    def replicas_needed(self, quantity: str, model: str) -> float:
        """About how many replicas make the bar of the final difference as short as ``resolution``, if standard errors
        fall as the square root of their number. NaN without a bar, infinite above a million.

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.
        """
        error = float(self.final_difference(quantity, model).error)
        return statistics.replicas_needed(error, self.n_replicas, self.resolution)

    def departure(self, quantity: str, model: str) -> Departure | None:
        """When and with which size the model is first told apart from Newton's equations; None if it never is.

        The bars are longer than those of the final difference, since many samples are looked at. Of quantities that do
        not differ, less than 1 % have a departure (0.8 % of 48 000 comparisons of nothing with nothing).

        Parameters
        ----------
        quantity : str
            A value of the coordinate ``quantity`` of ``dataset``, such as "granular_temperature".
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model.

        Notes
        -----
        A difference counts that is outside bars of 0.5 % divided by the number of samples (Bonferroni), or that is
        outside bars of 0.5 % from that sample on to the end: tests in a fixed sequence, here backwards, all have the
        level of the first (Maurer, Hothorn & Lehmacher, Biometrie in der chemisch-pharmazeutischen Industrie 6, 3
        (1995)). The rate was measured with 2 to 30 replicas and 100 samples, whose noise was independent or lasted for
        up to the whole run.
        """
        found = self.difference(quantity, model)
        at = statistics.departure(found, self.n_replicas)
        if at is None:
            return None
        return Departure(float(self.plan.times[at]), float(found.mean[at]), float(found.error[at]))

    # --- labelled -------------------------------------------------------------------------------------------

    @cached_property
    def replicas(self) -> xr.Dataset:
        """Every replica: Dataset over ``model``, ``replica`` and ``time``, and what single contacts were like."""
        import xarray as xr

        data: dict[str, Any] = {}
        for name, (unit, meaning) in self._series().items():
            values = self._all(name).transpose(1, 0, 2)
            data[name] = (("model", "replica", "time"), values, {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in TOTALS.items():
            data[name] = (("model", "replica"), self._all(name).T, {"units": unit, "long_name": meaning})
        share = self._all("restitution_share").transpose(1, 0, 2)
        data["restitution_share"] = (("model", "replica", "restitution"), share, _SHARE)
        codes = self._all("outcome").T.astype(np.int8)
        data["outcome"] = (("model", "replica"), codes, _flags())
        coordinates = {**self._coordinates(), "replica": np.arange(self.n_replicas)}
        return xr.Dataset(data, coordinates, self._attributes("Replicas"))

    @property
    def largest_compression(self) -> float:
        """The largest compression under Newton's equations in any replica, over the smaller radius."""
        return float(np.nanmax(self._all("largest_compression")[:, self.models.index("newton")], initial=0.0))

    @cached_property
    def dataset(self) -> xr.Dataset:
        """Means and standard errors over ``model``, ``time`` and ``statistic``; relative differences from Newton's
        equations over ``quantity`` as well, with time and size at which each is first told
        apart (NaN: never)."""
        import xarray as xr

        data: dict[str, Any] = {}
        for name, (unit, meaning) in (self._series() | TOTALS).items():
            values = self._all(name)
            dims = ("model", "time", "statistic") if values.ndim == 3 else ("model", "statistic")
            data[name] = (dims, _stacked(statistics.mean(values)), {"units": unit, "long_name": meaning})
        share = _stacked(statistics.mean(self._all("restitution_share")))
        data["restitution_share"] = (("model", "restitution", "statistic"), share, _SHARE)
        coordinates = {
            **self._coordinates(),
            "statistic": list(STATISTICS),
            "quantity": list(QUANTITIES),
        }
        return xr.Dataset(data | self._differences(), coordinates, self._attributes("Means"))

    def _differences(self) -> dict[str, Any]:
        pairs = [[(name, model) for model in self.models] for name in QUANTITIES]
        found = np.array([[_stacked(self.difference(*pair)) for pair in row] for row in pairs])
        nowhere = Departure(math.nan, math.nan, math.nan)
        left = np.array([[self.departure(*pair) or nowhere for pair in row] for row in pairs])
        size = {"units": "1", "long_name": "relative difference when it is first told apart"}
        return {
            "difference": (
                ("quantity", "model", "time", "statistic"),
                found,
                {
                    "units": "1",
                    "long_name": "difference from Newton’s equations, relative to them, paired by starts",
                },
            ),
            "departure_time": (
                ("quantity", "model"),
                left[..., 0],
                {"units": "s", "long_name": "when the difference is first told apart, many looks considered"},
            ),
            "replicas_needed": (
                ("quantity", "model"),
                [[self.replicas_needed(*pair) for pair in row] for row in pairs],
                {
                    "units": "1",
                    "long_name": "replicas that make the bar at the end as short as the resolution",
                },
            ),
            "departure_size": (("quantity", "model", "statistic"), left[..., 1:], size),
        }

    def _series(self) -> dict[str, tuple[str, str]]:
        found = dict(QUANTITIES) | {"divergence": DIVERGENCE}
        if self.dimension == 2:
            found["pressure"] = ("N/m", found["pressure"][1])
        return found

    def _coordinates(self) -> dict[str, Any]:
        time = {"units": "s", "long_name": "time after the start"}
        middle = {"units": "1", "long_name": "coefficient of restitution, middle of a bin; the last is open"}
        return {
            "model": list(self.models),
            "time": ("time", self.plan.times, time),
            "restitution": ("restitution", 0.5 * (EDGES[1:] + EDGES[:-1]), middle),
        }

    def _attributes(self, what: str) -> dict[str, Any]:
        return {
            "title": f"{what} of a comparison of rules for hard spheres with Newton’s equations",
            "source": f"hardlimit {_core.version}",
            "system": self.system,
            "law": repr(self.plan.law),
            "engine": self.plan.engine,
            "restitution": self.plan.restitution,
            "contact_duration": self.contact_duration,
            "tc_nu": self.tc_nu,
            "n_replicas": self.n_replicas,
            "bars": self.bars,
            "resolution": self.resolution,
            "summary": self.summary(),
            "hardlimit_version": _core.version,
        }

    def save(self, path: str | Path) -> Path:
        """Write means and replicas as the groups ``means`` and ``replicas`` of one NetCDF file.

        Parameters
        ----------
        path : path
            Ends in .nc.

        Returns
        -------
        Path
            Of the file.

        Raises
        ------
        OSError
            If it cannot be written; names it.
        """
        import xarray as xr

        from ..support import saving

        return saving.groups(
            {"/": xr.Dataset(attrs=self.dataset.attrs), "means": self.dataset, "replicas": self.replicas},
            path,
        )

    # --- in words and pictures ------------------------------------------------------------------------------

    def summary(self) -> str:
        """One sentence: how far each rule is from Newton's equations at the end, with standard errors.

        Returns
        -------
        str
        """
        return words.sentence(self)

    def plot(self) -> Figure:
        """Differences of each rule from Newton's equations over time with their bars, contacts and paths.

        Returns
        -------
        matplotlib.figure.Figure

        Examples
        --------
        >>> box = hl.ParticleSystem.random(
        ...     16, 0.3, 1e-3, 2500.0, rms_speed=0.1, dimension=2
        ... )
        >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.8)
        >>> found = hl.fidelity(
        ...     box, law=law, until=0.02, models=["newton", "law"], replicas=4, samples=4
        ... )
        >>> found.plot().savefig("fidelity.svg")
        """
        from .. import plots

        return plots.fidelity(self)

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"<Fidelity of {', '.join(self.models)} over {self.n_replicas} replicas: {self.summary()}>"

    def _repr_html_(self) -> str:
        head, rows = words.table(self)
        return html.table("Difference from Newton’s equations at the end [%]", head, rows, self.summary())


_SHARE: Final = {"units": "1", "long_name": "share of the contacts in each bin of the restitution"}


def _flags() -> dict[str, Any]:
    names = _core.outcome_names
    return {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}


def _stacked(estimate: statistics.Estimate) -> Floats:
    """Mean and error side by side, along a last axis."""
    return np.stack([estimate.mean, estimate.error], axis=-1)
