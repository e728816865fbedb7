"""Observables of boxes of grains: a record for each, from which series, attributes and documentation are made."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .box import AXES, Floats, component_axes, read_only
from .spins import AXES_OF_ROTATION
from .system import ParticleSystem
from .walls import name_of

Shape = Literal["scalar", "vector", "axial", "tensor", "walls"]
Kind = Literal["value", "sum", "rate"]
_DIMS: Final[Mapping[Shape, tuple[str, ...]]] = {
    "scalar": (),
    "vector": ("axis",),
    "axial": ("axis",),  # in 2-D one number, along the normal of the plane
    "tensor": ("component",),
    "walls": ("wall",),
}
#: Text that is appended to the meaning of a variable, by kind.
KINDS: Final[Mapping[Kind, str]] = {
    "value": "",
    "sum": ", since the start",
    "rate": ", mean since the previous sample",
}
#: Records that engines have only of runs with friction.
OF_FRICTION: Final = frozenset(field["name"] for field in _core.observed_fields if field["friction"])


class Samples:
    """Quantities that an engine recorded at the samples of a run; ``samples[name]`` is an array over the samples.

    ``now`` is the time [s] of ``system``, whose walls may move.
    """

    def __init__(self, system: ParticleSystem, records: Mapping[str, Floats], now: float = 0.0) -> None:
        self.system, self._records = system, records
        self.lasted = np.diff(records["time"])  #: time between samples [s]
        self._since_now = records["time"] - now

    def __getitem__(self, name: str) -> Floats:
        return self._records[name]

    def __contains__(self, name: str) -> bool:
        return name in self._records

    def rate(self, name: str) -> Floats:
        """Increase of a sum per time since the previous sample, without the first sample."""
        with np.errstate(invalid="ignore", divide="ignore"):
            growth: Floats = (np.diff(self[name], axis=0).T / self.lasted).T
        return growth

    def lengths(self) -> Floats:
        """Length of each axis of the box at the samples (samples, d) [m]."""
        return self.system.domain.mean_lengths(self._since_now, self._since_now)

    def mean_lengths(self) -> Floats:
        """Mean length of each axis since the previous sample (samples − 1, d) [m]."""
        return self.system.domain.mean_lengths(self._since_now[:-1], self._since_now[1:])

    def mean_volume(self) -> Floats:
        """Volume of the box [m³; disks m²], mean since the previous sample, without the first.

        Exact if the walls of one axis move; otherwise the product of the mean lengths.
        """
        volume: Floats = self.mean_lengths().prod(axis=1)
        return volume

    def mean_areas(self) -> Floats:
        """Area of each wall [m²; disks: length, m], mean since the previous sample (samples − 1, walls)."""
        lengths = self.mean_lengths()
        return np.stack(
            [np.delete(lengths, axis, 1).prod(axis=1) for _, axis, _ in self.system.domain.walls()], axis=1
        )

    def of_walls(self, name: str) -> Floats:
        """A record of all sides, of those that are walls (samples, walls)."""
        return self[name][:, [-1 - number for number, _, _ in self.system.domain.walls()]]

    def mean_thermal_energy(self) -> Floats:
        """Σ m v'², mean since the previous sample, without the first. Exact if the engine integrates it over time."""
        total = self.system.dimension * float(self.system.mass.sum())
        twice = self["granular_temperature"] * total
        mean = 0.5 * (twice[1:] + twice[:-1])
        if "kinetic_integral" not in self:
            return mean
        exact = self.rate("kinetic_integral")
        return np.where(np.isnan(exact), mean, exact)


@dataclass(frozen=True)
class Observable:
    """A quantity in the series of a run."""

    name: str
    unit: str
    meaning: str
    needs: tuple[str, ...]  #: the records of an engine from which it is computed
    kind: Kind = "value"
    shape: Shape = "scalar"
    never_falls: bool = (
        False  #: whether it never decreases with time, in runs without friction if it has its losses
    )
    unit_of_disks: str = ""  #: unit in 2-D, if different
    of: Callable[[Samples], Floats] | None = None  #: computes it; None: the record of the same name

    def values(self, samples: Samples) -> NDArray[Any]:
        """The values over the samples; the first value of a rate is NaN."""
        values = samples[self.name] if self.of is None else self.of(samples)
        if self.kind == "rate":
            values = np.concatenate([np.full((1, *values.shape[1:]), math.nan), values])
        whole = self.name.startswith("n_") and not np.isnan(values).any()
        return values.astype(np.int64) if whole else values.copy()

    def unit_in(self, dimension: int) -> str:
        """The unit in 2 or 3 dimensions."""
        return self.unit_of_disks if dimension == 2 and self.unit_of_disks else self.unit

    @property
    def of_friction(self) -> bool:
        """Whether only runs with friction have it."""
        return not OF_FRICTION.isdisjoint(self.needs)

    def dims(self, dimension: int) -> tuple[str, ...]:
        """The dimensions in a Dataset, of a box in 2 or 3 dimensions."""
        return ("time", *(() if self.shape == "axial" and dimension == 2 else _DIMS[self.shape]))


def _collision_rate(samples: Samples) -> Floats:
    return 2.0 * samples.rate("n_pairs") / samples.system.n


def _pressure(samples: Samples) -> Floats:
    d = samples.system.dimension
    virial = samples.rate("virial_tensor")[:, :d].sum(axis=1)
    mean: Floats = (samples.mean_thermal_energy() + virial) / (d * samples.mean_volume())
    return mean


def _kinetic_pressure_tensor(samples: Samples) -> Floats:
    d, kinetic = samples.system.dimension, samples["kinetic_tensor"]
    mean = 0.5 * (kinetic[1:] + kinetic[:-1])
    # The mean of two samples is corrected isotropically to the exact mean thermal energy.
    isotropic = (samples.mean_thermal_energy() - mean[:, :d].sum(axis=1)) / d
    mean[:, :d] += isotropic[:, None]
    return mean / samples.mean_volume()[:, None]


def _collisional_pressure_tensor(samples: Samples) -> Floats:
    return samples.rate("virial_tensor") / samples.mean_volume()[:, None]


def _pressure_tensor(samples: Samples) -> Floats:
    """The trace divided by d is the pressure, to rounding."""
    return _kinetic_pressure_tensor(samples) + _collisional_pressure_tensor(samples)


def _gradient(samples: Samples) -> int:
    """The axis of the gradient of a shear flow along x."""
    return samples.system.domain.gradient or 1


def _shear_stress(samples: Samples) -> Floats:
    d = samples.system.dimension
    return -_pressure_tensor(samples)[:, d - 1 + _gradient(samples)]


def _first_normal_stress_difference(samples: Samples) -> Floats:
    tensor = _pressure_tensor(samples)
    difference: Floats = tensor[:, _gradient(samples)] - tensor[:, 0]
    return difference


def _packing_fraction(samples: Samples) -> Floats:
    filled = samples.system.packing_fraction * samples.system.domain.volume
    fraction: Floats = filled / samples.lengths().prod(axis=1)
    return fraction


def _flux_to_walls(name: str) -> Callable[[Samples], Floats]:
    def flux(samples: Samples) -> Floats:
        with np.errstate(invalid="ignore", divide="ignore"):
            growth = np.diff(samples.of_walls(name), axis=0) / samples.lasted[:, None]
        return growth / samples.mean_areas()

    return flux


def _rotational_temperature(samples: Samples) -> Floats:
    axes = AXES_OF_ROTATION[samples.system.dimension]
    return 2.0 * samples["rotational_energy"] / (axes * float(samples.system.mass.sum()))


def _temperature_ratio(samples: Samples) -> Floats:
    temperature = samples["granular_temperature"]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(temperature > 0.0, _rotational_temperature(samples) / temperature, math.nan)


def _damping_loss(samples: Samples) -> Floats:
    return samples["dissipated_energy"] - samples["friction_loss"]


def _damping_loss_rate(samples: Samples) -> Floats:
    return samples.rate("dissipated_energy") - samples.rate("friction_loss")


def _rate_of(name: str) -> Callable[[Samples], Floats]:
    return lambda samples: samples.rate(name)


def _overlapped_share(samples: Samples) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.diff(samples["n_overlapped"]) / np.diff(samples["n_ended"])


_OF_PARTS: Final = ("granular_temperature", "kinetic_tensor", "virial_tensor")
_COMPONENTS: Final = "components xx, yy, zz, xy, xz, yz, positive in compression"
_STRESSES: Final[tuple[tuple[str, str, tuple[str, ...], Shape, Callable[[Samples], Floats]], ...]] = (
    (
        "pressure",
        "(Σ m v'² + Σ r·Δp of pairs per time)/(d·volume)",
        ("granular_temperature", "virial_tensor"),
        "scalar",
        _pressure,
    ),
    (
        "pressure_tensor",
        f"(Σ m v'⊗v' + Σ r⊗Δp of pairs per time)/volume, {_COMPONENTS}",
        _OF_PARTS,
        "tensor",
        _pressure_tensor,
    ),
    (
        "kinetic_pressure_tensor",
        f"kinetic part of the pressure tensor, Σ m v'⊗v'/volume, {_COMPONENTS}",
        _OF_PARTS[:2],
        "tensor",
        _kinetic_pressure_tensor,
    ),
    (
        "collisional_pressure_tensor",
        f"collisional part of the pressure tensor, (Σ r⊗Δp of pairs per time)/volume, {_COMPONENTS}",
        _OF_PARTS[2:],
        "tensor",
        _collisional_pressure_tensor,
    ),
    (
        "shear_stress",
        "−P_xy of the pressure tensor P; y is the axis of the gradient in a sheared box",
        _OF_PARTS,
        "scalar",
        _shear_stress,
    ),
    (
        "first_normal_stress_difference",
        "P_yy − P_xx of the pressure tensor P; y is the axis of the gradient in a sheared box",
        _OF_PARTS,
        "scalar",
        _first_normal_stress_difference,
    ),
)

_RECORDS: Final = (
    Observable("kinetic_energy", "J", "Σ m v²/2", ("kinetic_energy",)),
    Observable("rotational_energy", "J", "Σ I ω²/2", ("rotational_energy",)),
    Observable("potential_energy", "J", "−Σ m g·x along unfolded paths", ("potential_energy",)),
    Observable(
        "contact_energy",
        "J",
        "elastic energy of all contacts that overlap, also after their force has ended; with tangential springs",
        ("contact_energy",),
    ),
    Observable(
        "tangential_energy",
        "J",
        "elastic energy F_t²/(2 k_t) of all tangential springs, part of contact_energy",
        ("tangential_energy",),
    ),
    Observable(
        "dissipated_energy", "J", "energy lost in contacts", ("dissipated_energy",), "sum", never_falls=True
    ),
    # A spring that is set anew at the Coulomb limit, or whose stiffness changes, may give energy back.
    Observable(
        "friction_loss", "J", "energy lost by tangential forces in contacts", ("friction_loss",), "sum"
    ),
    Observable(
        "damping_loss",
        "J",
        "energy lost by normal forces in contacts, dissipated_energy − friction_loss",
        ("dissipated_energy", "friction_loss"),
        "sum",
        never_falls=True,
        of=_damping_loss,
    ),
    Observable("wall_work", "J", "work of moving walls on the particles", ("wall_work",), "sum"),
    Observable("shear_work", "J", "work of a Lees–Edwards boundary on the particles", ("shear_work",), "sum"),
    Observable("heat", "J", "energy from the thermostat", ("heat",), "sum"),
    *(
        Observable(name, "W", f"{of} per time", (total,), "rate", of=_rate_of(total))
        for name, total, of in (
            ("dissipation_rate", "dissipated_energy", "energy lost in contacts"),
            ("wall_power", "wall_work", "work of moving walls on the particles"),
            ("shear_power", "shear_work", "work of a Lees–Edwards boundary on the particles"),
            ("heating_power", "heat", "energy from the thermostat"),
            ("friction_loss_rate", "friction_loss", "energy lost by tangential forces in contacts"),
        )
    ),
    Observable(
        "damping_loss_rate",
        "W",
        "energy lost by normal forces in contacts per time",
        ("dissipated_energy", "friction_loss"),
        "rate",
        of=_damping_loss_rate,
    ),
    Observable(
        "granular_temperature",
        "m2/s2",
        "granular temperature Σ m|v − V|²/(d Σ m), v relative to the mean flow of a sheared box",
        ("granular_temperature",),
    ),
    Observable(
        "rotational_temperature",
        "m2/s2",
        "rotational temperature T_r = Σ I ω²/(f Σ m), f = 3 for spheres and 1 for disks",
        ("rotational_energy",),
        of=_rotational_temperature,
    ),
    Observable(
        "temperature_ratio",
        "1",
        "T_r/T, rotational over granular temperature; NaN where T is 0",
        ("rotational_energy", "granular_temperature"),
        of=_temperature_ratio,
    ),
    Observable("momentum", "kg m/s", "Σ m v", ("momentum",), shape="vector"),
    Observable("spin", "kg m2/s", "Σ I ω, angular momentum of the rotation", ("spin",), shape="axial"),
    Observable("n_collisions", "1", "collisions, with walls too", ("n_collisions",), "sum", never_falls=True),
    Observable(
        "n_contacts", "1", "contacts that began, with walls too", ("n_contacts",), "sum", never_falls=True
    ),
    Observable(
        "collision_rate", "1/s", "2·collisions of pairs/(N·time)", ("n_pairs",), "rate", of=_collision_rate
    ),
    Observable(
        "wall_impulse",
        "N s",
        "momentum that each wall gets from the particles, along its outward normal",
        ("wall_impulse",),
        "sum",
        "walls",
        of=lambda samples: samples.of_walls("wall_impulse"),
    ),
    Observable(
        "wall_energy",
        "J",
        "energy that each wall gets from the particles: lost in its contacts, less its work",
        ("wall_energy",),
        "sum",
        "walls",
        of=lambda samples: samples.of_walls("wall_energy"),
    ),
    Observable(
        "wall_pressure",
        "Pa",
        "momentum flux to each wall along its outward normal: impulse per area and time",
        ("wall_impulse",),
        "rate",
        "walls",
        unit_of_disks="N/m",
        of=_flux_to_walls("wall_impulse"),
    ),
    Observable(
        "wall_heat_flux",
        "W/m2",
        "energy flux to each wall: energy lost in its contacts, less its work, per area and time",
        ("wall_energy",),
        "rate",
        "walls",
        unit_of_disks="W/m",
        of=_flux_to_walls("wall_energy"),
    ),
    Observable(
        "volume",
        "m3",
        "volume of the box, between the walls where they are",
        ("time",),
        unit_of_disks="m2",
        of=lambda samples: samples.lengths().prod(axis=1),
    ),
    Observable(
        "packing_fraction",
        "1",
        "volume of the particles over that of the box",
        ("time",),
        of=_packing_fraction,
    ),
    *(
        Observable(name, "Pa", meaning, needs, "rate", shape, unit_of_disks="N/m", of=of)
        for name, meaning, needs, shape, of in _STRESSES
    ),
    Observable("n_in_contact", "1", "contacts that last at this time", ("n_in_contact",)),
    Observable(
        "overlapped_share",
        "1",
        "share of the contacts that ended which shared a particle with another contact",
        ("n_ended", "n_overlapped"),
        "rate",
        of=_overlapped_share,
    ),
)
#: Observables by name, in the order of the variables of a Dataset.
OBSERVABLES: Final = {record.name: record for record in _RECORDS}
#: Coordinates of a series, whose names no observable may have.
RESERVED: Final = ("time", "axis", "component", "wall")


def provided(records: Any) -> Iterator[Observable]:
    """The observables that can be computed from the records of an engine."""
    return (record for record in OBSERVABLES.values() if all(name in records for name in record.needs))


def components(dimension: int) -> list[str]:
    """Names of the components of a symmetric tensor, in LAMMPS' order: xx, yy, zz, xy, xz, yz."""
    return [AXES[a] + AXES[b] for a, b in zip(*component_axes(dimension), strict=True)]


def wall_names(system: ParticleSystem) -> list[str]:
    """The walls of a system: ``"x-"`` at 0, ``"x+"`` at the edge, … ``"z+"``."""
    return [name_of(axis, upper) for _, axis, upper in system.domain.walls()]


def variables(samples: Samples) -> tuple[dict[str, Any], dict[str, Any]]:
    """The data variables and coordinates for an xarray Dataset."""
    system = samples.system
    data = {
        record.name: (
            record.dims(system.dimension),
            read_only(record.values(samples)),
            {
                "units": record.unit_in(system.dimension),
                "long_name": record.meaning + KINDS[record.kind],
                "kind": record.kind,
            },
        )
        for record in provided(samples)
        if record.shape != "walls" or "wall" in system.boundary
    }
    time = read_only(samples["time"].copy())
    coordinates: dict[str, Any] = {
        "time": ("time", time, {"units": "s", "long_name": "time after the start of the run"})
    }
    used = {dim for dims, _, _ in data.values() for dim in dims}
    named = {
        "axis": list(AXES[: system.dimension]),
        "component": components(system.dimension),
        "wall": wall_names(system),
    }
    return data, coordinates | {dim: names for dim, names in named.items() if dim in used}
