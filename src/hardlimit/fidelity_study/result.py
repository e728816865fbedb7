"""Result of a comparison of rules with Newton's equations: replicas, means with errors, differences."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from .. import _core
from ..boxes.box import Floats
from ..boxes.engines import FIXED, SPINS
from ..boxes.error_law import softness
from ..boxes.observables import Observable, components
from ..boxes.rules import law_entry, law_from
from ..boxes.system import ParticleSystem
from ..support import html, saving, validation
from ..support.estimate import Estimate
from . import prediction, report, statistics, steady
from .contacts import EDGES
from .replica import DIVERGENCE, INTERVALS, NEWTON, NONLINEAR, PREFIX, Arrays, Plan, quantities

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr
    from matplotlib.figure import Figure

#: Values of a whole run: unit and meaning.
TOTALS: Final = {
    "overlapped_share": (
        "1",
        "share of the contacts during which another contact of a partner existed; for hard spheres if contacts had "
        "the law’s duration",
    ),
    "median_restitution": ("1", "median of separation speed over impact speed of the contacts"),
    "n_contacts": ("1", "contacts of a replica, including those with walls"),
    "largest_compression": (
        "1",
        "largest compression of a replica over the smaller radius, of contacts under the law",
    ),
    "end_time": ("s", "time at which the run ended"),
}
#: Arrays of the start in a saved comparison.
OF_START: Final = (*FIXED, *SPINS, "positions", "velocities")
STATISTICS: Final = ("mean", "standard_error")
#: Default of the smallest relative difference that must be resolved.
RESOLUTION: Final = 0.01
_SHARE: Final = {"units": "1", "long_name": "share of the contacts in each bin of the restitution"}


class Departure(NamedTuple):
    """First significant difference of a rule from Newton's equations; made by ``Fidelity.departure``."""

    time: float  #: [s]
    size: float  #: relative difference at that time
    error: float  #: its standard error


@dataclass(frozen=True, eq=False, repr=False)
class Fidelity:
    """Comparison of collision rules for hard spheres with Newton's equations, over replicas; made by :func:`fidelity`.

    ``print(f)`` prints a summary sentence, ``f.dataset`` has all values, and ``f.plot()`` draws a figure.

    Examples
    --------
    >>> box = hl.ParticleSystem.random(
    ...     16, 0.3, 1e-3, 2500.0, rms_speed=0.1, dimension=2
    ... )
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.8)
    >>> found = hl.fidelity(
    ...     box, law=law, until=0.02, models=["newton", "law"], replicas=4, samples=4
    ... )
    >>> estimate = found.final_difference("granular_temperature", "law")
    >>> f"{100 * estimate.value:.1f} ± {100 * estimate.error:.1f} %"
    '-0.1 ± 0.1 %'
    >>> found.is_significant("granular_temperature", "law")
    False
    >>> found.replicas_needed("cooling", "law")  # for ± 1 %
    29.0
    """

    plan: Plan  #: models, law and samples
    start: ParticleSystem  #: initial state of replica 0
    dimension: int  #: 2 or 3
    arrays: tuple[Arrays, ...] = field(repr=False)  #: of each replica
    resolution: float = RESOLUTION  #: relative difference that should be resolved

    @property
    def models(self) -> tuple[str, ...]:
        """Names of the models, Newton's equations first."""
        return self.plan.models

    @property
    def n_replicas(self) -> int:
        """Number of replicas. One replica gives no errors and no verdict."""
        return len(self.arrays)

    @property
    def contact_duration(self) -> float:
        """t_c [s]: as given, or that of the law at the mean impact speed of the initial state."""
        return self.plan.contact_duration

    @cached_property
    def tc_nu(self) -> float:
        """t_c ν: contact duration times the collision rate under Newton's equations, averaged over run and replicas;
        in a driven box over the steady state. NaN without elapsed time or steady state."""
        if self.driven:
            return self.contact_duration * self.steady_mean("collision_rate", NEWTON).value
        rate = self._all("collision_rate")[:, 0]
        return self.contact_duration * float(rate[:, self.last_common(NEWTON)].mean())

    @cached_property
    def delta_over_d(self) -> float:
        """δ/d: greatest compression of a contact at the mean impact speed, over the mean diameter; mean of the run.
        In a thin gas the error of the rules follows δ/d. NaN for particles at rest."""
        temperature = self._all("granular_temperature")[:, 0, : self.last_common(NEWTON) + 1]
        if self.driven:
            temperature = temperature[:, self.steady.first + 1 :]
        return softness(self.plan.law, self.start, temperature).delta_over_d

    def predicted(self, model: str) -> prediction.Prediction:
        """What the law of the error (:func:`error_law`) predicts for the final difference of the cooling of a rule.

        Parameters
        ----------
        model : str
            One of ``models``.

        Returns
        -------
        Prediction
            Difference with its standard error; NaN and the reason if the law does not apply.

        Raises
        ------
        ValueError
            If there is no such model.
        """
        self._index(model)
        return prediction.predicted(self, model)

    @property
    def largest_compression(self) -> float:
        """Largest compression under Newton's equations in any replica, over the smaller radius."""
        return float(np.nanmax(self._all("largest_compression")[:, 0], initial=0.0))

    @property
    def bars(self) -> str:
        """Half-width of the confidence intervals, in words."""
        if self.n_replicas < 2:
            return (
                "99 % by the independent samples of the one replica" if self.driven else "none: one replica"
            )
        half = statistics.student(self.n_replicas - 1)
        return f"{half:.3g} standard errors (99 % of Student’s distribution)"

    def outcomes(self, model: str) -> list[str]:
        """Outcome of each replica, a name from ``hardlimit.OUTCOMES``.

        Parameters
        ----------
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such model.
        """
        i = self._index(model)
        return [_core.outcome_names[int(arrays["outcome"][i])] for arrays in self.arrays]

    def _all(self, name: str) -> Floats:
        """Values of all replicas, the first axis."""
        return np.array([arrays[name] for arrays in self.arrays])

    def _index(self, model: str) -> int:
        return self.models.index(validation.one_of("model", model, self.models))

    def last_common(self, model: str) -> int:
        """The last sample that this model and Newton's equations reached in every replica.

        :meta private:
        """
        reached = np.isfinite(self._all("granular_temperature")[:, [0, self._index(model)]]).all(axis=(0, 1))
        return int(np.flatnonzero(reached)[-1])

    # --- steady states of driven boxes ----------------------------------------------------------------------

    @property
    def driven(self) -> bool:
        """Whether walls move, a thermostat heats or the box is sheared. Final differences are then those of the steady
        state."""
        return self.start.driven

    @property
    def sheared(self) -> bool:
        """Whether the box is sheared: shear stress and first normal stress difference are then compared too."""
        return self.start.shear_rate != 0.0

    @cached_property
    def quantities(self) -> dict[str, Observable]:
        """The observables that are compared, by name.

        :meta private:
        """
        return quantities(self.start, self.plan.law)

    @property
    def examined(self) -> tuple[str, ...]:
        """The quantities that must be steady, and that the summary of a driven box compares.

        :meta private:
        """
        return (*steady.EXAMINED, "shear_stress") if self.sheared else steady.EXAMINED

    def nonlinear_flow(self, model: str) -> float:
        """Share of the fluctuations of v_x in a sheared box that is a flow in layers, in the steady state; the largest
        of the replicas. 0 in homogeneous shear, near 1 in shear bands. NaN without shear or steady state.

        Parameters
        ----------
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such model.
        """
        i = self._index(model)
        if not self.sheared or self.steady.reason:
            return math.nan
        values = self._all(NONLINEAR.name)[:, i, self.steady.first + 1 :]
        return float(values.mean(axis=1).max())

    @cached_property
    def steady(self) -> steady.SteadyState:
        """Where the steady state begins that all models share, or the reason why there is none.

        Of temperature, pressure, dissipation, collision rate and, in a sheared box, shear stress, under each model that
        reached the end in all replicas, the mean over replicas is examined: :func:`hardlimit.measure.steady` finds the
        start. From there on it
        must have at least ten independent samples of all replicas together, and three of each, and the means of its
        halves must not differ (99.9 % for all together).
        """
        if not self.driven:
            return steady.SteadyState(0, math.nan, "the box is not driven")
        series = {
            (
                report.NAMES[name],
                "under " + ("Newton’s equations" if model == NEWTON else f"the rule {model}"),
            ): values
            for name in self.examined
            for model in self.models
            if np.isfinite(values := self.series(name, model)).all()
        }
        return steady.detected(series, self.plan.times)

    def series(self, quantity: str, model: str) -> Floats:
        """Values of a quantity of a driven box (replica, interval): at the end of each interval between samples, or
        averaged over it. NaN after an early end.

        Parameters
        ----------
        quantity : str
            As for :meth:`Fidelity.difference`.
        model : str
            One of ``models``.

        Raises
        ------
        ValueError
            If there is no such quantity or model, or the box is not driven.
        """
        name = validation.one_of("quantity", quantity, tuple(self.quantities))
        i = self._index(model)
        if not self.driven:
            raise ValueError("series: the box is not driven, must have moving walls, a thermostat or shear")
        if PREFIX + name in self.arrays[0]:
            return self._all(PREFIX + name)[:, i]
        return self._all(name)[:, i, 1:]

    def steady_mean(self, quantity: str, model: str) -> Estimate[float]:
        """Average over the steady state of a driven box, with its 99 % interval: Student's distribution over replicas;
        for one replica from its correlated samples (:func:`hardlimit.measure.steady`). NaN without a steady state.

        Parameters and errors as for :meth:`Fidelity.series`.
        """
        values = self.series(quantity, model)
        if math.isnan(self.steady.start):
            return Estimate(math.nan, math.nan, math.nan, math.nan)
        return steady.average(values, self.steady)

    # --- differences ----------------------------------------------------------------------------------------

    def difference(self, quantity: str, model: str) -> Estimate[Floats]:
        """(model − Newton) over the magnitude of Newton at every sample, paired by replica, with 99 % intervals.

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
        values = self._all(validation.one_of("quantity", quantity, tuple(self.quantities)))
        return statistics.relative_difference(values[:, self._index(model)], values[:, 0])

    def final_difference(self, quantity: str, model: str) -> Estimate[float]:
        """The difference at the last sample that both models reached in every replica; NaN if that is the start.

        In a driven box: the difference of the averages over the steady state, paired by replica; with one replica, the
        errors of both averages are taken as independent. NaN without a steady state.

        Parameters as for :meth:`Fidelity.difference`.
        """
        if self.driven:
            values, reference = (self.series(quantity, name) for name in (model, NEWTON))
            if math.isnan(self.steady.start):
                return Estimate(math.nan, math.nan, math.nan, math.nan)
            return steady.difference(values, reference, self.steady)
        differences, last = self.difference(quantity, model), self.last_common(model)
        return Estimate(*(float(part[last]) if last else math.nan for part in differences))

    def is_significant(self, quantity: str, model: str) -> bool:
        """Whether the confidence interval of the final difference excludes zero.

        Parameters as for :meth:`Fidelity.difference`.
        """
        difference = self.final_difference(quantity, model)
        return difference.lower > 0.0 or difference.upper < 0.0

    def replicas_needed(self, quantity: str, model: str) -> float:
        """Approximate number of replicas that would resolve the final difference: intervals of ± ``resolution``.

        It is at most ``n_replicas`` if the difference is resolved already. NaN for one replica, infinite above a
        million. Parameters as for :meth:`Fidelity.difference`.
        """
        error = self.final_difference(quantity, model).error
        return statistics.replicas_needed(error, self.n_replicas, self.resolution)

    def departure(self, quantity: str, model: str) -> Departure | None:
        """First sample with a significant difference, corrected for the number of samples; None if there is none.

        Less than 1 % of the quantities that do not differ have a departure (0.8 % in 48 000 tests with 2 to 30 replicas
        and 100 samples). Parameters as for :meth:`Fidelity.difference`.

        Notes
        -----
        A difference is significant at a level of 0.5 % divided by the number of samples (Bonferroni), or if it is
        significant at 0.5 % from that sample to the last one: tests in a fixed sequence, here backwards, all have the
        level of the first (Maurer, Hothorn & Lehmacher, Biometrie in der chemisch-pharmazeutischen Industrie 6, 3
        (1995)).
        """
        differences = self.difference(quantity, model)
        at = statistics.departure(differences, self.n_replicas)
        if at is None:
            return None
        return Departure(
            float(self.plan.times[at]), float(differences.value[at]), float(differences.error[at])
        )

    # --- datasets -------------------------------------------------------------------------------------------

    @cached_property
    def replicas(self) -> xr.Dataset:
        """Values of each replica: Dataset over ``model``, ``replica`` and ``time``, with statistics of the contacts."""
        import xarray as xr

        data: dict[str, Any] = {}
        for name, attributes in self._attributes().items():
            values = np.moveaxis(self._all(name), 1, 0)
            data[name] = (("model", "replica", "time")[: values.ndim], values, attributes)
        share = self._all("restitution_share").transpose(1, 0, 2)
        data["restitution_share"] = (("model", "replica", "restitution"), share, _SHARE)
        names = _core.outcome_names
        flags = {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}
        data["outcome"] = (("model", "replica"), self._all("outcome").T.astype(np.int8), flags)
        coordinates = {**self._coordinates(), "replica": np.arange(self.n_replicas)}
        if self.driven:
            for name, record in INTERVALS.items():
                intervals = np.moveaxis(self._all(PREFIX + name), 1, 0)
                dims = ("model", "replica", "interval", "component")[: intervals.ndim]
                meaning = f"{record.meaning}, in each interval between samples"
                attributes = {"units": record.unit_in(self.dimension), "long_name": meaning}
                data[PREFIX + name] = (dims, intervals, attributes)
            coordinates["component"] = components(self.dimension)
            coordinates["interval"] = (
                "interval",
                self.plan.times[1:],
                {"units": "s", "long_name": "its end"},
            )
        return xr.Dataset(data, coordinates, self._global_attributes("Replicas"))

    @cached_property
    def dataset(self) -> xr.Dataset:
        """Means and standard errors over ``model``, ``time`` and ``statistic``; relative differences from Newton's
        equations and departures (NaN: none) also over ``quantity``."""
        import xarray as xr

        data: dict[str, Any] = {}
        for name, attributes in self._attributes().items():
            values = _with_error(statistics.mean(self._all(name)))
            dims = ("model", "time", "statistic") if values.ndim == 3 else ("model", "statistic")
            data[name] = (dims, values, attributes)
        share = _with_error(statistics.mean(self._all("restitution_share")))
        data["restitution_share"] = (("model", "restitution", "statistic"), share, _SHARE)
        coordinates = {
            **self._coordinates(),
            "statistic": list(STATISTICS),
            "quantity": list(self.quantities),
        }
        return xr.Dataset(data | self._differences(), coordinates, self._global_attributes("Means"))

    def _differences(self) -> dict[str, Any]:
        def table(function: Any) -> Floats:
            return np.array([[function(name, model) for model in self.models] for name in self.quantities])

        steady_parts: dict[str, Any] = {}
        if self.driven:
            final = table(lambda *pair: np.array(self.final_difference(*pair)[:2]))
            say = {
                "units": "1",
                "long_name": "difference from Newton’s equations in the steady state, relative",
            }
            steady_parts["steady_difference"] = (("quantity", "model", "statistic"), final, say)
            for name, record in self.quantities.items():
                mean = np.array([self.steady_mean(name, model)[:2] for model in self.models])
                meaning = record.meaning.removesuffix(", mean since the start")
                attributes = {
                    "units": record.unit_in(self.dimension),
                    "long_name": f"{meaning}, average over the steady state",
                }
                steady_parts[f"steady_{name}"] = (("model", "statistic"), mean, attributes)
        departures = table(lambda *pair: self.departure(*pair) or (math.nan,) * 3)
        return steady_parts | {
            "difference": (
                ("quantity", "model", "time", "statistic"),
                table(lambda *pair: _with_error(self.difference(*pair))),
                {
                    "units": "1",
                    "long_name": "difference from Newton’s equations, relative, paired by replica",
                },
            ),
            "departure_time": (
                ("quantity", "model"),
                departures[..., 0],
                {"units": "s", "long_name": "time of the first significant difference"},
            ),
            "departure_size": (
                ("quantity", "model", "statistic"),
                departures[..., 1:],
                {"units": "1", "long_name": "relative difference at that time"},
            ),
            "replicas_needed": (
                ("quantity", "model"),
                table(self.replicas_needed),
                {"units": "1", "long_name": "replicas that would resolve the final difference"},
            ),
        }

    def _attributes(self) -> dict[str, dict[str, str]]:
        """Unit and meaning of each variable."""
        observables = (*self.quantities.values(), *([NONLINEAR] if self.sheared else []), DIVERGENCE)
        all_of = {
            record.name: (record.unit_in(self.dimension), record.meaning) for record in observables
        } | TOTALS
        return {name: {"units": unit, "long_name": meaning} for name, (unit, meaning) in all_of.items()}

    def _coordinates(self) -> dict[str, Any]:
        time = {"units": "s", "long_name": "time"}
        middle = {"units": "1", "long_name": "coefficient of restitution, middle of a bin; the last is open"}
        return {
            "model": list(self.models),
            "time": ("time", self.plan.times, time),
            "restitution": ("restitution", 0.5 * (EDGES[1:] + EDGES[:-1]), middle),
        }

    def _global_attributes(self, what: str) -> dict[str, Any]:
        beta = self.plan.tangential_restitution
        own = ("contact_duration", "tc_nu", "delta_over_d", "n_replicas", "bars", "resolution")
        return {
            "title": f"{what} of a comparison of rules for hard spheres with Newton’s equations",
            "source": f"hardlimit {_core.version}",
            "system": repr(self.start),
            "law": repr(self.plan.law),
            "engine": self.plan.engine,
            "restitution": self.plan.restitution,
            **({} if beta is None else {"tangential_restitution": beta}),
            **{name: getattr(self, name) for name in own},
            **({"steady_from": self.steady.start} if self.driven else {}),
            "summary": self.summary(),
            "hardlimit_version": _core.version,
        }

    def save(self, path: str | Path) -> Path:
        """Write means and, in the group ``replicas``, the replicas as one NetCDF file, which :func:`load` reads.

        Parameters
        ----------
        path : path
            Ends in .nc.

        Raises
        ------
        OSError
            If it cannot be written; names it.
        """
        state = {name: getattr(self.start, name) for name in OF_START}
        arrays = {f"start_{name}": values for name, values in state.items() if values is not None}
        flat = [
            (f"replica_{k}", name, array)
            for k, arrays in enumerate(self.arrays)
            for name, array in arrays.items()
        ]
        header = {
            "system": self.start.entries(),
            "plan": vars(self.plan) | {"law": law_entry(self.plan.law)},
            "values": {"dimension": self.dimension, "resolution": self.resolution, "n": self.n_replicas},
            "names": [name for _, name, _ in flat],
        }
        arrays |= {f"{replica}_{i}": array for i, (replica, _, array) in enumerate(flat)}
        datasets = {"/": self.dataset, "replicas": self.replicas}
        return saving.result(path, type(self).__name__, datasets, header, arrays)

    @classmethod
    def _loaded(cls, content: saving.Saved) -> Fidelity:
        """The comparison of a file. Raises KeyError, TypeError or ValueError if it is damaged."""
        header, flat = content.state()
        plan, values = dict(header["plan"]), header["values"]
        plan |= {"law": law_from(plan["law"]), "models": tuple(plan["models"])}
        state = {name: flat[f"start_{name}"] for name in OF_START if f"start_{name}" in flat}
        replicas: list[Arrays] = [{} for _ in range(values["n"])]
        of_replicas = (name for name in flat if name.startswith("replica_"))
        for key in of_replicas:
            _, replica, i = key.split("_")
            replicas[int(replica)][header["names"][int(i)]] = flat[key]
        start = ParticleSystem.from_entries(header["system"], **state)
        return cls(Plan(**plan), start, values["dimension"], tuple(replicas), values["resolution"])

    # --- text and plots -------------------------------------------------------------------------------------

    def summary(self) -> str:
        """In words: the final difference of each rule from Newton's equations, with standard errors; in a driven box
        since when it is steady, and the differences there."""
        return report.sentence(self)

    def plot(self) -> Figure:
        """Plot the differences of each rule from Newton's equations over time, contacts and trajectories."""
        from .. import plots

        return plots.fidelity(self)

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return f"<Fidelity of {', '.join(self.models)} over {self.n_replicas} replicas: {self.summary()}>"

    def _repr_html_(self) -> str:
        head, rows = report.table(self)
        return html.table(
            f"Difference from Newton’s equations {report.when(self)} [%]", head, rows, self.summary()
        )


def _with_error(estimate: Estimate[Floats]) -> Floats:
    """Value and standard error along a last axis."""
    return np.stack([estimate.value, estimate.error], axis=-1)
