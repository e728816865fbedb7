"""Results of boxes of grains, of hard spheres and of Newton's equations: final state, time series, log."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..contact import compression
from ..contact.contact import Law
from ..support import html, saving
from ..support.formatting import digits, listed
from . import observables, observe, theory
from .box import WALL_NUMBERS, Floats, read_only, wall_name
from .observables import OBSERVABLES, Samples
from .rules import RULES, Settings, law_entry, law_from
from .system import ParticleSystem

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

#: Largest number of particles that a message names.
MAX_NAMED: Final = 3
#: Labels in tables.
TEMPERATURES: Final = {
    "granular_temperature": "granular temperature",
    "rotational_temperature": "rotational temperature",
    "temperature_ratio": "temperature ratio θ = T_r/T",
}
Log = tuple[NDArray[Any], ...]


class EarlyEnd(NamedTuple):
    """Time, place and particles of the event that ended a run early; ``outcome`` of the result gives the reason.

    Made by :func:`hardlimit.event_driven` and :func:`hardlimit.molecular_dynamics`.
    """

    time: float  #: [s]
    position: tuple[float, ...]  #: position of the first particle [m]
    particles: tuple[int, ...]  #: in the contact or cluster, or the one that was too fast; ascending
    wall: int | None  #: wall of the contact, −1 − 2·axis at 0, −2 − 2·axis at the edge; None without one

    def who(self) -> str:
        """The particles and the wall as text."""
        names = [str(i) for i in self.particles]
        if self.wall is not None:
            return f"particle {names[0]} and the wall {wall_name(self.wall)}"
        if len(names) > MAX_NAMED:
            return f"{len(names)} particles ({', '.join(names[:MAX_NAMED])}, …)"
        return f"particle{'s' if len(names) > 1 else ''} {listed(names)}"

    def where(self) -> str:
        """Time and place as text, such as ``at 0.27 s, near (0.05, 0.01) m``."""
        return f"at {self.time:.6g} s, near ({', '.join(f'{x:.6g}' for x in self.position)}) m"


#: Outcome of a run whose time has become too large (``Box.resolved_until``).
TOO_LATE: Final = (
    "not resolved: later times do not resolve the phase of walls, or the slowest motion of grains"
)
#: Sentence of each outcome.
HARD_SPHERES_OUTCOMES: Final = {
    "ok": "ok",
    "no_contact": "no further collisions",
    "collapse": "inelastic collapse: {who} collide infinitely often {where}; use molecular_dynamics, or the rule "
    "tc if there are gaps between them",
    "no_room": "collapse: {who} collide infinitely often {where}; use molecular_dynamics",
    "at_rest": "at rest: {what} holds {who} together {where}; use molecular_dynamics",
    "invalid": "invalid: a contact of {who} {where} has values outside the floating-point range",
    "too_deep": "too deep: the contact of {who} {where} would reach half of the smaller radius, beyond the range "
    "of contact laws",
    "unresolved": "not resolved: a contact of {who} takes too many steps, {where}",
}
NEWTON_OUTCOMES: Final = {
    "ok": "ok",
    "too_deep": "too deep: the contact of {who} reached half of the smaller radius, beyond the range of contact laws, "
    "{where}",
    "steps": "not resolved: {who} moves too far in one step, {where}",
    "events": "not resolved: the contacts of {who} last too long to be integrated together, {where}; "
    "use engine='steps'",
}


#: Arrays of the final state in a saved result.
STATE: Final = (
    *("positions", "velocities", "radius", "mass", "box", "gravity", "_unfolded"),
    *("angular_velocities", "inertia_factor"),
)


class Column(NamedTuple):
    name: str
    unit: str  #: empty if it has none
    meaning: str


COLLISIONS: Final = (
    Column("time", "s", "time after the start of the run"),
    Column("first", "", "particle"),
    Column("second", "", f"particle; {WALL_NUMBERS}"),
    Column("impact_speed", "m/s", "speed of approach"),
    Column("separation_speed", "m/s", "speed of separation"),
)
CONTACTS: Final = (
    Column("begin", "s", "first touch, or when the force switches on again"),
    Column("end", "s", "when the force falls to zero; NaN: still open"),
    Column("first", "1", "particle"),
    Column("second", "1", f"particle; {WALL_NUMBERS}"),
    Column(
        "impact_speed",
        "m/s",
        "approach speed at the beginning; negative if a jump of velocity pressed the grains",
    ),
    Column("separation_speed", "m/s", "speed of separation at the end"),
    Column("overlapped", "1", "shared a particle with another contact while it lasted"),
)
#: Further columns of a run with friction.
RUBBING: Final = (
    Column("tangential_speed", "m/s", "tangential speed of the surfaces at the beginning"),
    Column(
        "tangential_restitution", "1", "β = −(tangential speed after)/(before), along the direction before"
    ),
    Column("slid", "1", "the surfaces have slipped"),
)


def at_the_end(name: str) -> str:
    """Row of a table for a temperature at the end of a run."""
    return f"{TEMPERATURES[name]} at the end{'' if OBSERVABLES[name].unit == '1' else ' [m²/s²]'}"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class _Result:
    """Common part of the results of all engines of boxes."""

    solves: ClassVar[str]
    logged: ClassVar[str]  #: what a row of the log is
    columns: ClassVar[tuple[Column, ...]]
    outcomes: ClassVar[Mapping[str, str]]

    system: ParticleSystem  #: the final state, with positions in the box
    time: float  #: time of the final state [s]
    outcome_name: str  #: ``"ok"`` or a name among ``hardlimit.OUTCOMES``
    samples: Mapping[str, Floats] = field(repr=False)  #: quantities recorded by the engine, over the samples
    log: Log | None = field(repr=False)  #: arrays of the ``columns``; None if the run kept no log
    largest_compression: float | None  #: of all contacts, over the smaller radius; None if unknown
    early_end: EarlyEnd | None = None  #: the event that ended the run early; None if the run reached its end
    observed: observe.Observed = field(default=observe.NOTHING, repr=False)  #: values of ``observe``

    @property
    def outcome(self) -> str:
        """``"ok"``, or one sentence that says why the run ended early."""
        end = self.early_end
        if end is None and self.outcome_name == "unresolved":
            return TOO_LATE
        sentence = self.outcomes[self._outcome_key()]
        what = "gravity" if self.system.gravity.any() else "the acceleration of the wall"
        return sentence if end is None else sentence.format(who=end.who(), where=end.where(), what=what)

    def _outcome_key(self) -> str:
        return self.outcome_name

    @property
    def outcome_code(self) -> int:
        """The outcome as an index of ``hardlimit.OUTCOMES``; 0 is ok."""
        return _core.outcome_names.index(self.outcome_name)

    @property
    def _samples(self) -> Samples:
        return Samples(self.system, self.samples, self.time)

    @cached_property
    def _series(self) -> xr.Dataset:
        import xarray as xr

        data, coordinates = observables.variables(self._samples)
        seen, labels = observe.variables(self.observed)
        return xr.Dataset(data | seen, coordinates | labels, self._attributes("Series"))

    def _log_dataset(self) -> xr.Dataset:
        import xarray as xr

        dim = self.logged
        if self.log is None:
            raise ValueError(f"log: got False, must be True for a run whose {dim}s are read")
        data = {}
        for column, values in zip((*self.columns, *RUBBING), self.log, strict=False):
            units = {"units": column.unit} if column.unit else {}
            data[column.name] = (dim, read_only(values), units | {"long_name": column.meaning})
        return xr.Dataset(data, attrs=self._attributes(f"{dim.capitalize()}s"))

    def _attributes(self, what: str) -> dict[str, Any]:
        return {
            "title": f"{what} of a box of grains",
            "source": f"hardlimit {_core.version}, {self.solves}",
            "system": repr(self.system),
            **self._own_attributes(),
            "outcome": self.outcome,
            "hardlimit_version": _core.version,
        }

    def _own_attributes(self) -> dict[str, Any]:
        raise NotImplementedError

    # --- tables and files -----------------------------------------------------------------------------------

    @property
    def series(self) -> xr.Dataset:
        """Dataset over ``time``; its variables depend on the engine."""
        return self._series.copy()

    def to_dataframe(self) -> pd.DataFrame:
        """The series as a table with one row for each sample, indexed by ``time`` [s].

        A vector, a tensor or a value for each wall has one column for each component, such as ``momentum_x``,
        ``pressure_tensor_xy`` and ``wall_pressure_z-``; an array of ``observe`` has ``name_0``, ``name_1``, …. Units
        and meanings are in ``series``.
        """
        import pandas as pd

        columns: dict[str, NDArray[Any]] = {}
        for name, variable in self._series.data_vars.items():
            dims, shape = variable.dims[1:], variable.shape[1:]
            labels = [
                self._series[dim].values if dim in self._series.coords else range(n)
                for dim, n in zip(dims, shape, strict=True)
            ]
            for at in np.ndindex(shape):
                column = "_".join([str(name), *(str(label[i]) for label, i in zip(labels, at, strict=True))])
                if column in columns:
                    raise ValueError(
                        f"observe: got the name {column!r}, that of a component in the table: rename it"
                    )
                columns[column] = variable.values[(slice(None), *at)]
        return pd.DataFrame(columns, pd.Index(self._series["time"].values, name="time"))

    def save(self, path: str | Path) -> Path:
        """Write the result as NetCDF, which :func:`load` reads.

        The series are at the root of the file. Groups are ``collisions`` or ``contacts`` if the run kept a log,
        ``final``, the final state, and ``state``, for :func:`load` only.

        Parameters
        ----------
        path : path
            Ends in .nc.

        Raises
        ------
        ValueError
            If it is not such a path.
        OSError
            If it cannot be written; names it.
        """
        datasets = {"/": self._series, "final": self.system.dataset}
        if self.log is not None:
            datasets[f"{self.logged}s"] = self._log_dataset()
        labels, arrays = observe.saved(self.observed)
        arrays |= {f"sample_{name}": values for name, values in self.samples.items()}
        state = {f"system_{name}": getattr(self.system, name) for name in STATE}
        arrays |= {name: values for name, values in state.items() if values is not None}
        header = {**self._saved_values(), "system": self.system.entries(), "end": self.early_end, **labels}
        return saving.result(
            path, type(self).__name__, datasets, header | {"logged": self.log is not None}, arrays
        )

    def _saved_values(self) -> dict[str, Any]:
        """The numbers and texts of the result, and its law or rule, for JSON."""
        apart = ("system", "samples", "log", "early_end", "observed", "law", "settings")
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.name not in apart}
        return {"values": values}

    @classmethod
    def _loaded(cls, content: saving.Saved) -> Self:
        """The result of a file. Raises KeyError, TypeError or ValueError if it is damaged."""
        header, arrays = content.state()
        state = {name: arrays.get(f"system_{name}") for name in STATE}
        log = content.root(f"{cls.logged}s") if header["logged"] else None
        end = header["end"]
        return cls(
            **header["values"],
            **cls._loaded_values(header),
            system=ParticleSystem.from_entries(header["system"], **state),
            samples={name[7:]: array for name, array in arrays.items() if name.startswith("sample_")},
            log=None
            if log is None
            else tuple(log[column.name].values for column in (*cls.columns, *RUBBING) if column.name in log),
            early_end=None if end is None else EarlyEnd(end[0], tuple(end[1]), tuple(end[2]), end[3]),
            observed=observe.loaded(header, arrays),
        )

    @classmethod
    def _loaded_values(cls, header: Mapping[str, Any]) -> dict[str, Any]:
        raise NotImplementedError

    def _temperatures(self) -> Iterator[tuple[str, float]]:
        """Rows of a table: temperatures at the start and at the end, with friction those of the rotation too."""
        samples = self._samples
        for name in TEMPERATURES:
            record = OBSERVABLES[name]
            if all(need in samples for need in record.needs):
                first, last = record.values(samples)[[0, -1]].tolist()
                yield at_the_end(name).replace(" at the end", " at the start"), first
                yield at_the_end(name), last

    def _losses(self) -> Iterator[tuple[str, float]]:
        """Rows of a table: the dissipated energy, and with friction the part of friction."""
        for name in ("dissipated_energy", "friction_loss"):
            if name in self.samples:
                label = "energy lost by friction" if name == "friction_loss" else "dissipated energy"
                yield f"{label} [J]", float(self.samples[name][-1])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ParticleResult(_Result):
    """Result of an event-driven run of a box of grains; made by :func:`event_driven`. It is immutable.

    Times are in s after the start of the run. The rule soft may be wrong for the ``n_soft_third_body`` contacts during
    which a third body was in reach.

    Notes
    -----
    The granular temperature is that of Goldhirsch, Powder Technol. 182, 130 (2008); the pressure is that of the virial.

    Examples
    --------
    >>> at, moving = [[0.02, 0.05], [0.04, 0.05]], [[0.1, 0.0], [-0.1, 0.0]]
    >>> pair = hl.ParticleSystem(at, moving, radius=0.005, density=2500.0, box=0.1)
    >>> run = hl.event_driven(pair, restitution=0.5, until=0.2, log=True)
    >>> run.collisions.time.values.round(4), run.collisions.impact_speed.values
    (array([0.05]), array([0.2]))
    >>> (run.series.dissipated_energy[-1] / run.series.kinetic_energy[0]).item()
    0.75
    """

    solves = "event-driven"
    logged = "collision"
    columns = COLLISIONS
    outcomes = HARD_SPHERES_OUTCOMES

    settings: Settings  #: the collision rule and its parameters
    n_collisions: int  #: number of collisions, including those with walls
    n_pairs: int  #: number of collisions of two particles
    n_walls: int  #: number of collisions with walls
    n_elastic_by_tc: int  #: number of collisions that the rule tc made elastic
    n_soft: int  #: number of contacts of the rule soft
    n_soft_third_body: int  #: number of these contacts with a third body in reach

    def _outcome_key(self) -> str:
        settings = self.settings
        elastic = settings.restitution == 1.0 and not settings.has_friction  # friction alone may collapse
        no_room = RULES[settings.rule].knows_duration or elastic
        return "no_room" if self.outcome_name == "collapse" and no_room else self.outcome_name

    def cooling_of_theory(self) -> dict[str, Floats]:
        """Temperatures at the samples of a homogeneous gas under a rule with one ε: Haff's law, with friction that of
        :class:`hardlimit.boxes.theory.RotatingGas`. Empty if no theory applies.

        :meta private:
        """
        samples, rule = self._samples, self.settings
        started, time = float(self.samples["granular_temperature"][0]), self.samples["time"]
        if rule.restitution is None or not started > 0.0 or theory.why_not(self.system) is not None:
            return {}
        gas = theory.gas(self.system)
        if not rule.has_friction:
            return {"granular_temperature": gas.cooling(time, started, rule.restitution)}
        if "rotational_energy" not in samples:
            return {}
        spinning = float(OBSERVABLES["rotational_temperature"].values(samples)[0])
        rotating = gas.rotating(rule.restitution, rule.friction, rule.tangential_restitution)
        moving, turning = rotating.cooling(time, started, spinning)
        return {
            "granular_temperature": moving,
            "rotational_temperature": turning,
            "temperature_ratio": turning / moving,
        }

    @property
    def elastic_share(self) -> float:
        """Fraction of the collisions that the rule tc made elastic; NaN under other rules."""
        return self._share("elastic_share", self.n_elastic_by_tc, self.n_collisions)

    @property
    def third_body_share(self) -> float:
        """Fraction of the contacts of the rule soft with a third body in reach; NaN under other rules."""
        return self._share("third_body_share", self.n_soft_third_body, self.n_soft)

    def _share(self, name: str, count: int, total: int) -> float:
        return count / total if total and name in RULES[self.settings.rule].counts else math.nan

    @property
    def series(self) -> xr.Dataset:
        """Dataset over ``time`` [s], equally spaced; the last sample is the end of the run.

        ``kinetic_energy``, ``potential_energy`` and ``dissipated_energy`` [J], ``granular_temperature`` [m²/s²],
        ``momentum`` [kg m/s], ``n_collisions``, ``collision_rate`` [1/s], ``pressure`` and ``pressure_tensor`` [Pa;
        disks N/m], what each ``wall`` gets, rates of work and more (:doc:`grains` lists all), and the values of
        ``observe``. With friction also ``rotational_energy``, ``rotational_temperature``, ``temperature_ratio``,
        ``spin`` (in 2-D a number), and ``friction_loss`` and ``damping_loss``, the two parts of ``dissipated_energy``.
        Rates and pressures are means since the previous sample, and NaN at the first sample. The tensor is
        positive in compression; its ``component`` is xx, yy, zz, xy, xz or yz.
        """
        return self._series.copy()

    @property
    def collisions(self) -> xr.Dataset:
        """Dataset over ``collision``: ``time`` [s], ``first``, ``second``, ``impact_speed``, ``separation_speed``
        [m/s].

        ``first < second``, or ``second < 0`` for a wall: −1 − 2·axis at 0, −2 − 2·axis at the edge. With friction also
        ``tangential_speed`` [m/s] at the beginning, ``tangential_restitution`` β, and ``slid``, whether the surfaces
        slipped.

        Raises
        ------
        ValueError
            If the run kept no log.
        """
        return self._log_dataset()

    def plot(self) -> Figure:
        """Plot temperatures, collision rate and pressure over time, with kinetic theory if it applies."""
        from .. import plots

        return plots.gas(self)

    def _own_attributes(self) -> dict[str, Any]:
        return {"rule": self.settings.report()}

    def _saved_values(self) -> dict[str, Any]:
        return {
            **super()._saved_values(),
            "settings": self.settings.entry(),
        }

    @classmethod
    def _loaded_values(cls, header: Mapping[str, Any]) -> dict[str, Any]:
        return {"settings": Settings.from_entry(header["settings"])}

    def __repr__(self) -> str:
        summary = f"{self.n_collisions} collisions in {self.time:.6g} s, {self.outcome}"
        return f"<ParticleResult of {self.system.n} particles ({self.settings.report()}): {summary}>"

    def _repr_html_(self) -> str:
        return _table(self.settings.report(), self.quantities(), self.outcome)

    def quantities(self) -> list[tuple[str, float]]:
        """Label, with the SI unit, and value of each row of a table.

        :meta private:
        """
        lasted = np.diff(self.samples["time"])
        rows: list[tuple[str, float]] = [
            ("time [s]", self.time),
            ("collisions", self.n_collisions),
            ("collisions with walls", self.n_walls),
            ("collisions per particle", (2.0 * self.n_pairs + self.n_walls) / self.system.n),
            *self._temperatures(),
        ]
        if lasted.sum() > 0.0:
            good, samples = lasted > 0.0, self._samples
            for name, label in (("collision_rate", "mean collision rate"), ("pressure", "mean pressure")):
                mean = np.average(OBSERVABLES[name].values(samples)[1:][good], weights=lasted[good])
                rows.append((f"{label} [{OBSERVABLES[name].unit_in(self.system.dimension)}]", float(mean)))
        rows += self._losses()
        rows += compression.rows(self.largest_compression)
        rule = RULES[self.settings.rule]
        return rows + [(f"fraction {rule.share}", getattr(self, name)) for name in rule.counts[-1:]]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ContactResult(_Result):
    """Result of a run of a box of grains under Newton's equations; made by :func:`molecular_dynamics`. It is immutable.

    Times are in s after the start of the run. The granular temperature and the pressure are those of
    :class:`ParticleResult` (Goldhirsch 2008).

    Examples
    --------
    >>> at, moving = [[0.02, 0.05], [0.04, 0.05]], [[0.1, 0.0], [-0.1, 0.0]]
    >>> pair = hl.ParticleSystem(at, moving, radius=0.005, density=2500.0, box=0.1)
    >>> law = hl.LinearDashpot(stiffness=1e3, restitution=0.5)
    >>> run = hl.molecular_dynamics(pair, law=law, until=0.2, log=True)
    >>> begin, end = run.contacts.begin.values, run.contacts.end.values
    >>> f"{(end - begin)[0] * 1e3:.2f} ms"
    '2.20 ms'
    >>> run.contacts.separation_speed.values.round(3)  # impact at 0.2 m/s
    array([0.1])
    """

    solves = "Newton’s equations"
    logged = "contact"
    columns = CONTACTS
    outcomes = NEWTON_OUTCOMES

    law: Law  #: contact law of all contacts
    engine: str  #: ``"events"``, ``"steps"`` or ``"lammps"``
    n_contacts: int | None  #: number of contacts that began, with walls too; None with LAMMPS without log
    n_pairs: int | None  #: number of these between two particles
    n_ended: int | None  #: number of contacts that ended
    n_overlapped: int | None  #: number of ended contacts that overlapped another contact in time
    largest_compression: float | None = None  #: of all contacts, over the smaller radius; None with LAMMPS
    time_step: float | None = None  #: longest step [s] (steps, lammps)
    n_steps: int | None = None  #: number of steps (steps, lammps)
    largest_cluster: int | None = None  #: largest number of particles integrated together (events)
    cluster_share: float | None = None  #: fraction of time that particles spent in clusters (events)
    engine_reason: str = ""  #: why ``"auto"`` chose this engine; empty if the user chose it

    def _outcome_key(self) -> str:
        return self.outcome_name if self.outcome_name in self.outcomes else self.engine

    @property
    def overlapped_share(self) -> float:
        """Fraction of the ended contacts that shared a particle with another contact while they lasted; NaN if none
        ended or contacts were not counted."""
        ended, overlapped = self.n_ended, self.n_overlapped
        return overlapped / ended if ended and overlapped is not None else math.nan

    @property
    def energy_error(self) -> float:
        """Largest change of the total energy, including dissipated energy and less that from walls, shear and
        thermostat, over the largest kinetic or dissipated energy; NaN with LAMMPS, whose dissipated energy is computed
        as the difference of the others."""
        if self.engine == "lammps":
            return math.nan
        kept = self.samples
        kinds = ("kinetic", "potential", "contact", "dissipated", "rotational")
        total = np.sum([kept[name] for kind in kinds if (name := f"{kind}_energy") in kept], axis=0)
        total -= kept["wall_work"] + kept["shear_work"] + kept["heat"]
        scale = max(float(kept["kinetic_energy"].max()), float(kept["dissipated_energy"].max()))
        error = float(np.abs(total - total[0]).max())
        return error / scale if scale > 0.0 else error

    @property
    def series(self) -> xr.Dataset:
        """Dataset over ``time`` [s], equally spaced; the last sample is the end of the run.

        ``kinetic_energy``, ``potential_energy``, ``contact_energy`` and ``dissipated_energy`` [J],
        ``granular_temperature`` [m²/s²], ``momentum`` [kg m/s], ``n_contacts``, ``n_in_contact``, ``collision_rate``
        [1/s], ``pressure`` and ``pressure_tensor`` [Pa; disks N/m], ``overlapped_share``, what each ``wall`` gets,
        rates of work and more (:doc:`grains` lists all), and the values of ``observe``. With friction also
        ``rotational_energy``, ``rotational_temperature``, ``temperature_ratio``, ``spin`` (in 2-D a number),
        ``tangential_energy``, the part of ``contact_energy`` in tangential springs, and ``friction_loss`` and
        ``damping_loss``, the two parts of ``dissipated_energy``. Rates, pressures and share are means since the
        previous sample, and NaN at the first sample. The tensor is positive in compression; its ``component`` is xx,
        yy, zz, xy, xz or yz. With LAMMPS and without a log ``n_contacts``, ``collision_rate`` and ``overlapped_share``
        are NaN; it has no quantities of walls, boundaries and thermostats, nor ``friction_loss`` and ``damping_loss``.
        """
        return self._series.copy()

    @property
    def contacts(self) -> xr.Dataset:
        """Dataset over ``contact``, ordered by ``begin``: ``begin``, ``end`` [s], ``first``, ``second``,
        ``impact_speed``, ``separation_speed`` [m/s], ``overlapped``.

        ``first < second``, or ``second < 0`` for a wall: −1 − 2·axis at 0, −2 − 2·axis at the edge. With friction,
        but not with LAMMPS, also ``tangential_speed`` [m/s] at the beginning, ``tangential_restitution`` β, and
        ``slid``, whether the surfaces slipped.

        Raises
        ------
        ValueError
            If the run kept no log.
        """
        return self._log_dataset()

    def choice(self) -> str:
        """Why this engine was chosen.

        :meta private:
        """
        return f"chose {self.engine}: {self.engine_reason}"

    def _saved_values(self) -> dict[str, Any]:
        return {**super()._saved_values(), "law": law_entry(self.law)}

    @classmethod
    def _loaded_values(cls, header: Mapping[str, Any]) -> dict[str, Any]:
        return {"law": law_from(header["law"])}

    def _own_attributes(self) -> dict[str, Any]:
        attributes: dict[str, Any] = {"law": repr(self.law), "engine": self.engine}
        attributes |= {"engine_reason": self.engine_reason} if self.engine_reason else {}
        return attributes if self.time_step is None else attributes | {"time_step": self.time_step}

    def __repr__(self) -> str:
        counted = "" if self.n_contacts is None else f"{self.n_contacts} contacts in "
        summary = f"{counted}{self.time:.6g} s, {self.outcome}"
        why = f"; {self.choice()}" if self.engine_reason else ""
        return f"<ContactResult of {self.system.n} particles ({self.engine}, {self.law!r}): {summary}{why}>"

    def _repr_html_(self) -> str:
        why = [("engine", self.choice())] if self.engine_reason else []
        return _table(f"{self.engine}, {self.law!r}", self.quantities(), self.outcome, why)

    def quantities(self) -> list[tuple[str, float]]:
        """Label, with the SI unit, and value of each row of a table.

        :meta private:
        """
        own = {
            "time step [s]": self.time_step,
            "largest cluster [particles]": self.largest_cluster,
            "fraction of time in clusters": self.cluster_share,
        }
        return [
            ("time [s]", self.time),
            *((label, float(value)) for label, value in own.items() if value is not None),
            *self._counted(),
            ("fraction that overlapped another contact in time", self.overlapped_share),
            *self._temperatures(),
            *self._losses(),
            *compression.rows(self.largest_compression),
            ("error of the energy balance", self.energy_error),
        ]

    def _counted(self) -> Iterator[tuple[str, float]]:
        if self.n_contacts is not None and self.n_pairs is not None:
            yield "contacts", self.n_contacts
            yield "collisions with walls", self.n_contacts - self.n_pairs
            yield "contacts per particle", (self.n_contacts + self.n_pairs) / self.system.n


def _table(
    title: str, quantities: list[tuple[str, float]], outcome: str, more: list[tuple[str, str]] | None = None
) -> str:
    rows = [(label, digits(value)) for label, value in quantities]
    return html.table(title, ["", ""], [list(row) for row in (*rows, *(more or []), ("outcome", outcome))])
