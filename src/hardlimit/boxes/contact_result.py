"""What a run under Newton's equations found: the final state, series over time, contacts."""

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

Floats = NDArray[np.float64]

#: What is kept of every sample: sums from the start of the run on.
COLUMNS: Final = (
    "time",
    "kinetic_energy",
    "potential_energy",
    "contact_energy",
    "dissipated_energy",
    "granular_temperature",
    "n_contacts",
    "n_pairs",
    "n_ended",
    "n_overlapped",
    "n_in_contact",
    "virial",
)

#: Unit and meaning of the series.
SERIES: Final = {
    "kinetic_energy": ("J", "Σ m v²/2"),
    "potential_energy": ("J", "−Σ m g·x along unfolded paths"),
    "contact_energy": ("J", "elastic energy of all that overlap, also where the force has ended"),
    "dissipated_energy": ("J", "energy lost in contacts so far"),
    "granular_temperature": ("m2/s2", "granular temperature Σ m|v − V|²/(d Σ m)"),
    "n_contacts": ("1", "contacts that began so far, those with walls included"),
    "collision_rate": ("1/s", "2·contacts of pairs/(N·time), mean since the sample before"),
    "pressure": ("Pa", "from the virial of pairs, mean since the sample before"),
    "n_in_contact": ("1", "contacts that last at this time"),
    "overlapped_share": (
        "1",
        "of the contacts that ended since the sample before, those that shared a particle with another one",
    ),
}

#: Of the log: name, unit, meaning.
LOG: Final = (
    ("begin", "s", "first touch, or when the force sets in again"),
    ("end", "s", "when the force falls to zero; NaN: still open"),
    ("first", "1", "particle"),
    ("second", "1", "particle; −1 − 2·axis wall at 0, −2 − 2·axis at L"),
    ("impact_speed", "m/s", "speed of approach at the begin"),
    ("separation_speed", "m/s", "speed of separation at the end"),
    ("overlapped", "1", "shared a particle with another contact while it lasted"),
)

OUTCOMES: Final = {
    "ok": "ok",
    "too_deep": "too deep: the contact of {who} reached half of the smaller radius, beyond the range of contact laws, "
    "{where}",
    "steps": "not resolved: {who} became so fast that it moves too far in one step, {where}",
    "events": "not resolved: the contacts of {who} last too long to be integrated together, {where}; "
    "engine='steps' is made for that",
}


@dataclass(frozen=True, eq=False, repr=False)
class ContactResult:
    """Outcome of one run of a box of grains under Newton's equations; made by :func:`molecular_dynamics`.

    It never changes. Times are in s after the start of the run.

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
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.5)
    >>> run = hl.molecular_dynamics(pair, law=law, until=0.2, log=True)
    >>> begin, end = run.contacts.begin.values, run.contacts.end.values
    >>> f"{(end - begin)[0] * 1e3:.2f} ms"
    '2.20 ms'
    >>> run.contacts.separation_speed.values.round(3)  # came with 0.2 m/s
    array([0.1])
    >>> run.energy_error < 1e-9
    True
    """

    system: ParticleSystem  #: the final state, inside the box; particles in contact overlap
    time: float  #: [s] of the final state
    law: Law  #: of all contacts
    engine: str  #: ``"events"``, ``"steps"`` or ``"lammps"``
    outcome_name: str  #: ``"ok"`` or a name among ``hardlimit.OUTCOMES``
    n_contacts: int | None  #: that began, with walls too; None where nobody counted (LAMMPS without log)
    n_pairs: int | None  #: of them between two particles
    n_ended: int | None  #: of them that ended
    n_overlapped: int | None  #: of those that ended, how many shared a particle with another contact in time
    rows: Floats = field(repr=False)  #: one row of ``COLUMNS`` for each sample
    log: tuple[NDArray[Any], ...] | None = field(repr=False)  #: as in ``LOG``; None without log
    time_step: float | None = None  #: of steps and LAMMPS, the longest [s]
    n_steps: int | None = None  #: of steps and LAMMPS
    largest_cluster: int | None = None  #: of events, the most particles that were integrated together
    cluster_share: float | None = None  #: of events, share of all time that particles spent in such clusters
    largest_compression: float | None = None  #: of all contacts, over the smaller radius; None by LAMMPS
    early_end: EarlyEnd | None = None  #: where and when, unless the run went to its end
    engine_reason: str = ""  #: why ``"auto"`` chose this engine; empty where it was asked for

    @property
    def outcome(self) -> str:
        """``"ok"``, or one sentence that says what happened instead."""
        said = self.outcome_name if self.outcome_name in OUTCOMES else self.engine
        return in_words(OUTCOMES[said], self.early_end)

    @property
    def outcome_code(self) -> int:
        """The outcome as an integer; 0 is ok, the names are those of ``hardlimit.OUTCOMES``."""
        return _core.outcome_names.index(self.outcome_name)

    @property
    def overlapped_share(self) -> float:
        """Share of the contacts that ended which shared a particle with another one; NaN where none ended, or nobody
        counted."""
        return (
            self.n_overlapped / self.n_ended if self.n_ended and self.n_overlapped is not None else math.nan
        )

    @property
    def energy_error(self) -> float:
        """The largest departure of energy + dissipated energy from the energy at the start, over the largest kinetic
        energy or amount dissipated; NaN by LAMMPS, whose dissipated energy is what the others lack."""
        if self.engine == "lammps":
            return math.nan
        kept = dict(zip(COLUMNS, self.rows.T, strict=True))
        total = sum(kept[f"{kind}_energy"] for kind in ("kinetic", "potential", "contact", "dissipated"))
        scale = max(float(kept["kinetic_energy"].max()), float(kept["dissipated_energy"].max()))
        error = float(np.abs(total - total[0]).max())
        return error / scale if scale > 0.0 else error

    @property
    def series(self) -> xr.Dataset:
        """Dataset over ``time`` [s], equally spaced; the last sample is the end of the run.

        ``kinetic_energy``, ``potential_energy``, ``contact_energy`` and ``dissipated_energy`` [J],
        ``granular_temperature`` [m²/s²], ``n_contacts``, ``n_in_contact``, ``collision_rate`` [1/s], ``pressure`` [Pa;
        disks N/m] and ``overlapped_share``. The last three are means since the sample before and NaN at the first.
        What nobody counted is NaN: by LAMMPS without log ``n_contacts``, ``collision_rate`` and ``overlapped_share``.
        """
        return self._series.copy()

    @cached_property
    def _series(self) -> xr.Dataset:
        import xarray as xr

        values = series_values(self.rows, self.system)
        data = {}
        for name, (unit, meaning) in SERIES.items():
            shown = "N/m" if name == "pressure" and self.system.dimension == 2 else unit
            data[name] = ("time", values[name], {"units": shown, "long_name": meaning})
        time = ("time", self.rows[:, 0], {"units": "s", "long_name": "time after the start of the run"})
        return xr.Dataset(data, {"time": time}, self._attributes("Series"))

    @property
    def contacts(self) -> xr.Dataset:
        """Dataset over ``contact``, in the order of their begins: ``begin``, ``end`` [s], ``first``, ``second``,
        ``impact_speed``, ``separation_speed`` [m/s], ``overlapped``.

        ``first < second``, or ``second < 0`` for a wall: −1 − 2·axis at 0, −2 − 2·axis at the edge.

        Raises
        ------
        ValueError
            If the run kept no log.
        """
        import xarray as xr

        if self.log is None:
            raise ValueError("log: got False, must be True for the run to keep its contacts")
        data = {
            name: ("contact", values, {"units": unit, "long_name": meaning})
            for values, (name, unit, meaning) in zip(self.log, LOG, strict=True)
        }
        return xr.Dataset(data, attrs=self._attributes("Contacts"))

    def _attributes(self, what: str) -> dict[str, Any]:
        return {
            "title": f"{what} of a box of grains",
            "source": f"hardlimit {_core.version}, Newton’s equations",
            "system": repr(self.system),
            "law": repr(self.law),
            "engine": self.engine,
            **({"engine_reason": self.engine_reason} if self.engine_reason else {}),
            **({} if self.time_step is None else {"time_step": self.time_step}),
            "outcome": self.outcome,
            "hardlimit_version": _core.version,
        }

    def __repr__(self) -> str:
        counted = "" if self.n_contacts is None else f"{self.n_contacts} contacts in "
        found = f"{counted}{self.time:.6g} s, {self.outcome}"
        why = f"; {choice(self)}" if self.engine_reason else ""
        return f"<ContactResult of {self.system.n} particles ({self.engine}, {self.law!r}): {found}{why}>"

    def _repr_html_(self) -> str:
        rows = [[label, digits(value)] for label, value in quantities(self)]
        rows += [["engine", choice(self)]] if self.engine_reason else []
        return html.table(f"{self.engine}, {self.law!r}", ["", ""], [*rows, ["outcome", self.outcome]])


def series_values(rows: Floats, system: ParticleSystem) -> dict[str, Floats]:
    """The series from the sums that are kept."""
    kept = dict(zip(COLUMNS, rows.T, strict=True))
    lasted = np.diff(kept["time"])
    relative = kept["granular_temperature"] * (system.dimension * float(system.mass.sum()))  # Σ m v'²
    volume = system.dimension * float(np.prod(system.box))
    with np.errstate(invalid="ignore", divide="ignore"):
        rate = 2.0 * np.diff(kept["n_pairs"]) / (system.n * lasted)
        pressure = (0.5 * (relative[1:] + relative[:-1]) + np.diff(kept["virial"]) / lasted) / volume
        share = np.diff(kept["n_overlapped"]) / np.diff(kept["n_ended"])
    found = {name: kept[name] for name in SERIES if name in kept}
    for name in ("n_contacts", "n_in_contact"):
        if not np.isnan(kept[name]).any():
            found[name] = kept[name].astype(np.int64)
    for name, means in (("collision_rate", rate), ("pressure", pressure), ("overlapped_share", share)):
        found[name] = np.concatenate([[math.nan], means])
    return found


def choice(result: ContactResult) -> str:
    """Why this engine, where nobody asked for it."""
    return f"chose {result.engine}: {result.engine_reason}"


def quantities(result: ContactResult) -> list[tuple[str, float]]:
    """What a result says in numbers, in SI units: label and value of each, as a table shows them."""
    kept = dict(zip(COLUMNS, result.rows.T, strict=True))
    own = {
        "time step [s]": result.time_step,
        "largest cluster [particles]": result.largest_cluster,
        "share of time in clusters": result.cluster_share,
    }
    return [
        ("time [s]", result.time),
        *((label, float(value)) for label, value in own.items() if value is not None),
        *_counted(result),
        ("share that overlapped another in time", result.overlapped_share),
        ("granular temperature at the start [m²/s²]", float(kept["granular_temperature"][0])),
        ("granular temperature at the end [m²/s²]", float(kept["granular_temperature"][-1])),
        ("dissipated energy [J]", float(kept["dissipated_energy"][-1])),
        *compression.rows(result.largest_compression),
        ("error of the energy balance", result.energy_error),
    ]


def _counted(result: ContactResult) -> list[tuple[str, float]]:
    if result.n_contacts is None or result.n_pairs is None:
        return []
    return [
        ("contacts", result.n_contacts),
        ("of them with walls", result.n_contacts - result.n_pairs),
        ("contacts per particle", (result.n_contacts + result.n_pairs) / result.system.n),
    ]
