"""What a run of a box of grains found: the final state, series over time, collisions."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact import compression
from ..contact.contact import Law
from ..support import html
from ..support.formatting import digits
from .early_end import EarlyEnd, in_words
from .system import ParticleSystem

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

#: What is kept of every sample: sums from the start of the run on, so that samples can be left out later.
COLUMNS: Final = (
    "time",
    "kinetic_energy",
    "potential_energy",
    "granular_temperature",
    "n_collisions",
    "n_pairs",
    "virial",
    "kinetic_integral",
    "dissipated_energy",
)

#: Unit and meaning of the series.
SERIES: Final = {
    "kinetic_energy": ("J", "Σ m v²/2"),
    "potential_energy": ("J", "−Σ m g·x along unfolded paths"),
    "granular_temperature": ("m2/s2", "granular temperature Σ m|v − V|²/(d Σ m)"),
    "n_collisions": ("1", "collisions so far, those with walls included"),
    "collision_rate": ("1/s", "2·pair collisions/(N·time), mean since the sample before"),
    "pressure": ("Pa", "from the virial of pair collisions, mean since the sample before"),
    "dissipated_energy": ("J", "energy lost in collisions so far"),
}

#: What is said of each outcome.
OUTCOMES: Final = {
    "ok": "ok",
    "no_contact": "nothing collides any more",
    "collapse": "inelastic collapse: {who} collide without end {where}; molecular_dynamics goes on, and the rule tc "
    "where there is room between them",
    "no_room": "collapse: {who} collide without end {where}; molecular_dynamics goes on",
    "at_rest": "at rest: gravity holds {who} together {where}; molecular_dynamics goes on",
    "invalid": "invalid: a contact of {who} {where} whose numbers are beyond all range",
    "too_deep": "too deep: the contact of {who} {where} would reach half of the smaller radius, beyond the range of "
    "contact laws",
    "unresolved": "not resolved: a contact takes too many steps, {who} {where}",
}


@dataclass(frozen=True)
class Settings:
    """What the collisions of a run obey; made by :func:`hardlimit.event_driven`.

    Examples
    --------
    >>> pair = hl.ParticleSystem(
    ...     [[0.02, 0.05], [0.04, 0.05]],
    ...     [[0.1, 0], [-0.1, 0]],
    ...     0.005,
    ...     density=2500.0,
    ...     box=0.1,
    ... )
    >>> run = hl.event_driven(
    ...     pair, restitution=0.8, rule="tc", contact_duration=1e-5, until=0.1
    ... )
    >>> run.settings.words()
    'tc, restitution 0.8, contact duration 1e-05 s'
    """

    rule: str  #: "constant", "law", "tc" or "soft"
    restitution: float | None  #: of rules that take a constant one
    law: Law | None  #: of the other rules
    contact_duration: float | None  #: of the rule tc [s]

    def words(self) -> str:
        """In words, for a table or an attribute.

        Returns
        -------
        str
        """
        parts = [self.rule]
        parts += [f"restitution {self.restitution:g}"] if self.restitution is not None else []
        parts += [repr(self.law)] if self.law is not None else []
        parts += (
            [f"contact duration {self.contact_duration:g} s"] if self.contact_duration is not None else []
        )
        return ", ".join(parts)


@dataclass(frozen=True, eq=False, repr=False)
class ParticleResult:
    """Outcome of one run of a box of grains; made by :func:`event_driven`. It never changes.

    Times are in s after the start of the run. Where a rule may be wrong is counted: ``n_elastic_by_tc`` collisions that
    the rule tc made elastic, and among ``n_soft`` contacts of the rule soft ``n_soft_third_body`` during which a third
    body was in reach.

    Notes
    -----
    The granular temperature is that of Goldhirsch, Powder Technol. 182, 130 (2008), the pressure that of the virial.

    Examples
    --------
    >>> pair = hl.ParticleSystem(
    ...     [[0.02, 0.05], [0.04, 0.05]],
    ...     [[0.1, 0], [-0.1, 0]],
    ...     0.005,
    ...     density=2500.0,
    ...     box=0.1,
    ... )
    >>> run = hl.event_driven(pair, restitution=0.5, until=0.2, log=True)
    >>> run.collisions.time.values.round(4), run.collisions.impact_speed.values
    (array([0.05]), array([0.2]))
    >>> (run.series.dissipated_energy[-1] / run.series.kinetic_energy[0]).item()
    0.75
    """

    system: ParticleSystem  #: the final state, inside the box
    time: float  #: [s] of the final state
    settings: Settings  #: what the collisions obey
    outcome_name: str  #: ``"ok"`` or a name among ``hardlimit.OUTCOMES``
    n_collisions: int  #: of pairs and with walls
    n_pairs: int  #: collisions of two particles
    n_walls: int  #: collisions with walls
    n_elastic_by_tc: int  #: collisions that the rule tc made elastic
    n_soft: int  #: contacts of the rule soft
    n_soft_third_body: int  #: of them with a third body in reach
    largest_compression: (
        float | None
    )  #: of contacts as the law has them, over the smaller radius; None without a law
    early_end: EarlyEnd | None  #: where and when, unless the run went to its end or nothing collides any more
    rows: Floats = field(repr=False)  #: one row of ``COLUMNS`` for each sample
    log: tuple[NDArray[Any], ...] | None = field(
        repr=False
    )  #: time, first, second, impact speed, separation speed; None without log

    @property
    def outcome(self) -> str:
        """``"ok"``, or one sentence that says what happened instead."""
        name = self.outcome_name
        if name == "collapse" and (self.settings.rule in ("tc", "soft") or self.settings.restitution == 1.0):
            name = "no_room"
        return in_words(OUTCOMES[name], self.early_end)

    @property
    def outcome_code(self) -> int:
        """The outcome as an integer; 0 is ok, the names are those of ``hardlimit.OUTCOMES``."""
        return _core.outcome_names.index(self.outcome_name)

    @property
    def elastic_share(self) -> float:
        """Share of the collisions that the rule tc made elastic; NaN under other rules."""
        return self._share(self.n_elastic_by_tc, self.n_collisions, "tc")

    @property
    def third_body_share(self) -> float:
        """Share of the soft contacts during which a third body was in reach; NaN under other rules."""
        return self._share(self.n_soft_third_body, self.n_soft, "soft")

    def _share(self, count: int, total: int, rule: str) -> float:
        return count / total if total and self.settings.rule == rule else math.nan

    @property
    def series(self) -> xr.Dataset:
        """Dataset over ``time`` [s], equally spaced; the last sample is the end of the run.

        ``kinetic_energy``, ``potential_energy`` and ``dissipated_energy`` [J], ``granular_temperature`` [m²/s²],
        ``n_collisions``, ``collision_rate`` [1/s], ``pressure`` [Pa; disks N/m]. The rate and the pressure are means
        since the sample before and NaN at the first.
        """
        return self._series.copy()

    @cached_property
    def _series(self) -> xr.Dataset:
        import xarray as xr

        values = series_values(self.rows, self.system)
        data = {}
        for name, (unit, meaning) in SERIES.items():
            shown = "N/m" if name == "pressure" and self.system.dimension == 2 else unit
            data[name] = ("time", _fixed(values[name]), {"units": shown, "long_name": meaning})
        time = (
            "time",
            _fixed(self.rows[:, 0]),
            {"units": "s", "long_name": "time after the start of the run"},
        )
        return xr.Dataset(data, {"time": time}, self._attributes("Series"))

    @property
    def collisions(self) -> xr.Dataset:
        """Dataset over ``collision``: ``time`` [s], ``first``, ``second``, impact and separation speed [m/s].

        ``first < second``, or ``second < 0`` for a wall: −1 − 2·axis at 0, −2 − 2·axis at the edge.

        Raises
        ------
        ValueError
            If the run kept no log.
        """
        import xarray as xr

        if self.log is None:
            raise ValueError("log: got False, must be True for the run to keep its collisions")
        time, first, second, impact, separation = map(_fixed, self.log)
        return xr.Dataset(
            {
                "time": ("collision", time, {"units": "s"}),
                "first": ("collision", first, {"long_name": "particle"}),
                "second": (
                    "collision",
                    second,
                    {"long_name": "particle; −1 − 2·axis wall at 0, −2 − 2·axis at L"},
                ),
                "impact_speed": ("collision", impact, {"units": "m/s", "long_name": "speed of approach"}),
                "separation_speed": (
                    "collision",
                    separation,
                    {"units": "m/s", "long_name": "speed of separation"},
                ),
            },
            attrs=self._attributes("Collisions"),
        )

    def _attributes(self, what: str) -> dict[str, Any]:
        return {
            "title": f"{what} of a box of grains",
            "source": f"hardlimit {_core.version}, event-driven",
            "system": repr(self.system),
            "rule": self.settings.words(),
            "outcome": self.outcome,
            "hardlimit_version": _core.version,
        }

    def plot(self) -> Figure:
        """Temperature, collision rate and pressure over time, with theory beside them where it applies.

        Returns
        -------
        matplotlib.figure.Figure

        Examples
        --------
        >>> gas = hl.ParticleSystem.random(
        ...     100, packing_fraction=0.1, radius=1e-3, density=2500.0, rms_speed=0.1
        ... )
        >>> run = hl.event_driven(gas, restitution=0.9, max_collisions=1000)
        >>> run.plot().savefig("cooling.svg")
        """
        from .. import plots

        return plots.gas(self)

    def __repr__(self) -> str:
        found = f"{self.n_collisions} collisions in {self.time:.6g} s, {self.outcome}"
        return f"<ParticleResult of {self.system.n} particles ({self.settings.words()}): {found}>"

    def _repr_html_(self) -> str:
        rows = [[label, digits(value)] for label, value in quantities(self)]
        return html.table(self.settings.words(), ["", ""], [*rows, ["outcome", self.outcome]])


def _fixed(array: NDArray[Any]) -> NDArray[Any]:
    """The array, read-only: a result remembers it."""
    array.flags.writeable = False
    return array


def series_values(rows: Floats, system: ParticleSystem) -> dict[str, Floats]:
    """The series from the sums that are kept."""
    kept = dict(zip(COLUMNS, rows.T, strict=True))
    lasted = np.diff(kept["time"])
    total = float(system.mass.sum())
    relative = kept["granular_temperature"] * (system.dimension * total)  # Σ m v'²
    mean = 0.5 * (relative[1:] + relative[:-1])
    with np.errstate(invalid="ignore", divide="ignore"):
        rate = 2.0 * np.diff(kept["n_pairs"]) / (system.n * lasted)
        integral = np.diff(kept["kinetic_integral"]) / lasted
        kinetic = np.where(np.isnan(integral), mean, integral)
        volume = system.dimension * float(np.prod(system.box))
        pressure = (kinetic + np.diff(kept["virial"]) / lasted) / volume
    found = {name: kept[name] for name in SERIES if name in kept}
    found["n_collisions"] = kept["n_collisions"].astype(np.int64)
    found["collision_rate"] = np.concatenate([[math.nan], rate])
    found["pressure"] = np.concatenate([[math.nan], pressure])
    return found


def quantities(result: ParticleResult) -> list[tuple[str, float]]:
    """What a result says in numbers, in SI units: label and value of each, as a table shows them."""
    rows, d = result.rows, result.system.dimension
    lasted = np.diff(rows[:, 0])
    means = {}
    if lasted.sum() > 0.0:
        values = series_values(rows, result.system)
        means = {
            name: float(np.average(values[name][1:][lasted > 0.0], weights=lasted[lasted > 0.0]))
            for name in ("collision_rate", "pressure")
        }
    found: list[tuple[str, float]] = [
        ("time [s]", result.time),
        ("collisions", result.n_collisions),
        ("of them with walls", result.n_walls),
        ("collisions per particle", (2.0 * result.n_pairs + result.n_walls) / result.system.n),
        ("granular temperature at the start [m²/s²]", float(rows[0, 3])),
        ("granular temperature at the end [m²/s²]", float(rows[-1, 3])),
    ]
    if means:
        found.append(("mean collision rate [1/s]", means["collision_rate"]))
        found.append((f"mean pressure [{'N/m' if d == 2 else 'Pa'}]", means["pressure"]))
    found.append(("dissipated energy [J]", float(rows[-1, 8])))
    found += compression.rows(result.largest_compression)
    if result.settings.rule == "tc":
        found.append(("share that tc made elastic", result.elastic_share))
    if result.settings.rule == "soft":
        found.append(("share with a third body in reach", result.third_body_share))
    return found
