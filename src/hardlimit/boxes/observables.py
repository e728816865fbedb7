"""Observables of boxes of grains: a record for each, from which series, attributes and documentation are made."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from .box import AXES, Floats, component_axes, read_only
from .system import ParticleSystem

Shape = Literal["scalar", "vector", "tensor"]
Kind = Literal["value", "sum", "rate"]
#: Text that is appended to the meaning of a variable, by kind.
KINDS: Final[Mapping[Kind, str]] = {
    "value": "",
    "sum": ", since the start",
    "rate": ", mean since the previous sample",
}


class Samples:
    """Quantities that an engine recorded at the samples of a run; ``samples[name]`` is an array over the samples."""

    def __init__(self, system: ParticleSystem, records: Mapping[str, Floats]) -> None:
        self.system, self._records = system, records
        self.lasted = np.diff(records["time"])  #: time between samples [s]

    def __getitem__(self, name: str) -> Floats:
        return self._records[name]

    def __contains__(self, name: str) -> bool:
        return name in self._records

    def rate(self, name: str) -> Floats:
        """Increase of a sum per time since the previous sample, without the first sample."""
        with np.errstate(invalid="ignore", divide="ignore"):
            growth: Floats = (np.diff(self[name], axis=0).T / self.lasted).T
        return growth

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
    never_falls: bool = False  #: whether it never decreases with time
    unit_of_disks: str = ""  #: unit in 2-D, if different
    of: Callable[[Samples], Floats] | None = None  #: computes it; None: the record of the same name

    def values(self, samples: Samples) -> NDArray[Any]:
        """The values over the samples; the first value of a rate is NaN."""
        found = samples[self.name] if self.of is None else self.of(samples)
        if self.kind == "rate":
            found = np.concatenate([np.full((1, *found.shape[1:]), math.nan), found])
        whole = self.unit == "1" and self.kind != "rate" and not np.isnan(found).any()
        return found.astype(np.int64) if whole else found.copy()

    def unit_in(self, dimension: int) -> str:
        """The unit in 2 or 3 dimensions."""
        return self.unit_of_disks if dimension == 2 and self.unit_of_disks else self.unit

    def dims(self) -> tuple[str, ...]:
        """The dimensions in a Dataset."""
        return {"scalar": ("time",), "vector": ("time", "axis"), "tensor": ("time", "component")}[self.shape]


def _collision_rate(samples: Samples) -> Floats:
    return 2.0 * samples.rate("n_pairs") / samples.system.n


def _pressure(samples: Samples) -> Floats:
    d = samples.system.dimension
    virial = samples.rate("virial_tensor")[:, :d].sum(axis=1)
    mean: Floats = (samples.mean_thermal_energy() + virial) / (d * samples.system.domain.volume)
    return mean


def _pressure_tensor(samples: Samples) -> Floats:
    """Components in LAMMPS' order; the trace divided by d is the pressure, to rounding."""
    d, kinetic = samples.system.dimension, samples["kinetic_tensor"]
    mean = 0.5 * (kinetic[1:] + kinetic[:-1])
    # The mean of two samples is corrected isotropically to the exact mean thermal energy.
    isotropic = (samples.mean_thermal_energy() - mean[:, :d].sum(axis=1)) / d
    mean[:, :d] += isotropic[:, None]
    return (mean + samples.rate("virial_tensor")) / samples.system.domain.volume


def _overlapped_share(samples: Samples) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.diff(samples["n_overlapped"]) / np.diff(samples["n_ended"])


_RECORDS: Final = (
    Observable("kinetic_energy", "J", "Σ m v²/2", ("kinetic_energy",)),
    Observable("potential_energy", "J", "−Σ m g·x along unfolded paths", ("potential_energy",)),
    Observable(
        "contact_energy",
        "J",
        "elastic energy of all contacts that overlap, also after their force has ended",
        ("contact_energy",),
    ),
    Observable(
        "dissipated_energy", "J", "energy lost in contacts", ("dissipated_energy",), "sum", never_falls=True
    ),
    Observable("wall_work", "J", "work of moving walls on the particles", ("wall_work",), "sum"),
    Observable("shear_work", "J", "work of a Lees–Edwards boundary on the particles", ("shear_work",), "sum"),
    Observable("heat", "J", "energy from the thermostat", ("heat",), "sum"),
    Observable(
        "granular_temperature",
        "m2/s2",
        "granular temperature Σ m|v − V|²/(d Σ m), v relative to the mean flow of a sheared box",
        ("granular_temperature",),
    ),
    Observable("momentum", "kg m/s", "Σ m v", ("momentum",), shape="vector"),
    Observable("n_collisions", "1", "collisions, with walls too", ("n_collisions",), "sum", never_falls=True),
    Observable(
        "n_contacts", "1", "contacts that began, with walls too", ("n_contacts",), "sum", never_falls=True
    ),
    Observable(
        "collision_rate", "1/s", "2·collisions of pairs/(N·time)", ("n_pairs",), "rate", of=_collision_rate
    ),
    Observable(
        "pressure",
        "Pa",
        "(Σ m v'² + Σ r·Δp of pairs per time)/(d·volume)",
        ("granular_temperature", "virial_tensor"),
        "rate",
        unit_of_disks="N/m",
        of=_pressure,
    ),
    Observable(
        "pressure_tensor",
        "Pa",
        "(Σ m v'⊗v' + Σ r⊗Δp of pairs per time)/volume, components xx, yy, zz, xy, xz, yz",
        ("granular_temperature", "kinetic_tensor", "virial_tensor"),
        "rate",
        "tensor",
        unit_of_disks="N/m",
        of=_pressure_tensor,
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
OBSERVABLES: Final = {one.name: one for one in _RECORDS}
#: Coordinates of a series, whose names no observable may have.
RESERVED: Final = ("time", "axis", "component")


def provided(records: Any) -> Iterator[Observable]:
    """The observables that can be computed from the records of an engine."""
    return (one for one in OBSERVABLES.values() if all(name in records for name in one.needs))


def components(dimension: int) -> list[str]:
    """Names of the components of a symmetric tensor, in LAMMPS' order: xx, yy, zz, xy, xz, yz."""
    return [AXES[a] + AXES[b] for a, b in zip(*component_axes(dimension), strict=True)]


def variables(samples: Samples) -> tuple[dict[str, Any], dict[str, Any]]:
    """The data variables and coordinates for an xarray Dataset."""
    system = samples.system
    data = {
        one.name: (
            one.dims(),
            read_only(one.values(samples)),
            {
                "units": one.unit_in(system.dimension),
                "long_name": one.meaning + KINDS[one.kind],
                "kind": one.kind,
            },
        )
        for one in provided(samples)
    }
    time = read_only(samples["time"].copy())
    coordinates: dict[str, Any] = {
        "time": ("time", time, {"units": "s", "long_name": "time after the start of the run"})
    }
    used = {dim for dims, _, _ in data.values() for dim in dims}
    named = {"axis": list(AXES[: system.dimension]), "component": components(system.dimension)}
    return data, coordinates | {dim: names for dim, names in named.items() if dim in used}
