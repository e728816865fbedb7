"""``hl.load`` returns what was saved, to the last bit, and the root of each file has the data."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import hardlimit as hl
from command_line import run
from conftest import refusal, slow
from hardlimit.support import saving

LAW = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
KICKS = hl.RandomKicks(power=1e-4, interval=1e-3, seed=3)
FLOOR = {"boundary": ["periodic", "periodic", "wall"], "gravity": [0.0, 0.0, -9.81]}


def box(n: int = 30, **options: Any) -> hl.ParticleSystem:
    arguments = {
        "packing_fraction": 0.05,
        "radius": [1e-3, 2e-3],
        "density": 2500.0,
        "rms_speed": 1.0,
    } | options
    return hl.ParticleSystem.random(n, **arguments)


def seen(time: float, system: hl.ParticleSystem) -> dict[str, Any]:
    return {
        "one": time,
        "matrix": np.arange(4).reshape(2, 2),
        "height": xr.DataArray([1, 2], {"h": [0.5, 1.5]}, "h"),
    }


#: Runs of each engine, rule, boundary and end.
RUNS: dict[str, Callable[[], Any]] = {
    "constant, log, observe": lambda: hl.event_driven(
        box(thermostat=KICKS), restitution=0.9, until=0.02, log=True, samples=5, observe=seen
    ),
    "soft": lambda: hl.event_driven(box(), law=LAW, rule="soft", until=0.002, samples=3),
    "tc, disks": lambda: hl.event_driven(
        box(dimension=2), restitution=0.8, rule="tc", contact_duration=1e-5, until=0.01
    ),
    "shaken, at rest": lambda: hl.event_driven(
        box(**FLOOR, walls={"z-": hl.MovingWall(1e-5, 50.0, velocity=1e-4)}), restitution=0.0, until=0.5, log=True
    ),
    "no collision": lambda: hl.event_driven(box(2), restitution=0.9, until=0.0, log=True),
    "events, log": lambda: hl.molecular_dynamics(box(**FLOOR), law=LAW, until=0.01, samples=3, log=True),
    "auto, sheared": lambda: hl.molecular_dynamics(
        box(shear_rate=20.0, boundary=["periodic", "lees-edwards", "periodic"]), law=LAW, until=1e-3, engine="auto"
    ),
    "steps": lambda: hl.molecular_dynamics(box(), law=LAW, until=1e-3, samples=3, engine="steps"),
}  # fmt: skip


#: The fast tests have each engine, walls, shear, heat, a log and values of ``observe``.
FAST = {"constant, log, observe", "events, log", "auto, sheared", "steps"}


@pytest.mark.parametrize("name", [name if name in FAST else slow(name) for name in RUNS])
def test_a_run_comes_back(name: str, tmp_path: Path) -> None:
    """All of it with ``hl.load``; series, log and final state also with xarray, the series from the root."""
    kept = RUNS[name]()
    path = kept.save(tmp_path / "run.nc")
    loaded = hl.load(path)
    assert type(loaded) is type(kept) and repr(loaded) == repr(kept)
    apart = ("log", "samples", "observed")
    for attribute in [field.name for field in dataclasses.fields(kept) if field.name not in apart]:
        assert getattr(loaded, attribute) == getattr(kept, attribute), attribute
    assert same_arrays(loaded.samples, kept.samples) and loaded.series.identical(kept.series)
    assert (loaded.system.unfolded_positions == kept.system.unfolded_positions).all()
    with xr.open_dataset(path) as root, xr.open_dataset(path, group="final") as final:
        assert root.drop_attrs().equals(kept.series.drop_attrs())
        assert final.equals(kept.system.dataset)
    if kept.log is not None:
        assert same_arrays(dict(enumerate(loaded.log)), dict(enumerate(kept.log)))
        logged = kept.collisions if isinstance(kept, hl.ParticleResult) else kept.contacts
        with xr.open_dataset(path, group=f"{kept.logged}s") as log:
            assert log.identical(logged)


def same_arrays(new: dict[Any, Any], old: dict[Any, Any]) -> bool:
    return new.keys() == old.keys() and all(
        new[key].dtype == old[key].dtype and np.array_equal(new[key], old[key], equal_nan=True) for key in old
    )


@pytest.mark.parametrize("name", RUNS)
def test_a_table_has_one_row_for_each_sample(name: str) -> None:
    """And each number of the series in one column."""
    kept = RUNS[name]()
    table, series = kept.to_dataframe(), kept.series
    assert table.index.name == "time" and (table.index == series.time.values).all()
    assert table.shape[1] == sum(v.size // len(table) for v in series.data_vars.values())
    for name, variable in series.data_vars.items():
        parts = variable.values.reshape(len(table), -1).T
        columns = [column for column in table if max(named(column, series), key=len) == name]
        np.testing.assert_array_equal(table[columns].values.T, parts)
    assert {"momentum_x", "pressure_tensor_xy"} <= {*table}


def named(column: str, series: xr.Dataset) -> list[str]:
    """The variables of the series to which a column may belong."""
    return [str(name) for name in series if column == name or column.startswith(f"{name}_")]


def test_a_name_of_the_user_that_is_a_component_is_refused() -> None:
    kept = hl.event_driven(box(2), restitution=0.9, until=0.0, observe=lambda t, s: {"momentum_x": 1.0})
    assert refusal(kept.to_dataframe).startswith("observe: got the name 'momentum_x', that of a component")


def test_a_comparison_comes_back(tmp_path: Path) -> None:
    kept = hl.fidelity(box(20), law=LAW, until=0.01, replicas=2, samples=4, resolution=0.02)
    loaded = hl.load(kept.save(tmp_path / "compare.nc"))
    assert loaded.summary() == kept.summary() and loaded.plan == kept.plan and loaded.start == kept.start
    assert loaded.dataset.identical(kept.dataset) and loaded.replicas.identical(kept.replicas)
    with xr.open_dataset(tmp_path / "compare.nc") as root:
        assert root.drop_attrs().equals(kept.dataset.drop_attrs())


SMALL = ["--n", "20", "--packing-fraction", "0.05", "--until", "10us"]
COMMANDS: dict[str, tuple[list[str], type]] = {
    "gas": (["gas", *SMALL, "--save", "a.nc"], hl.ParticleResult),
    "gas, engine": (
        ["gas", *SMALL, "--stiffness", "1e5", "--restitution", "0.9", "--engine", "steps", "--save", "a.nc"],
        hl.ContactResult,
    ),
    "sweep": (["sweep", "--restitution", "0.4:1:3", "--out", "a.nc"], xr.Dataset),
    "sweep, store": (["sweep", "--restitution", "0.4:1:3", "--out", "a.zarr"], xr.Dataset),
    "drop": (["drop", "--save", "a.nc"], xr.DataTree),
    "three balls": (["drop", *["--radius", "1cm"] * 3, "--density", "2500", "--save", "a.nc"], xr.DataTree),
    "gas compare": (
        ["gas", "compare", *SMALL, "--replicas", "1", "--workers", "1", "--out", "a.nc"],
        hl.Fidelity,
    ),
    "paper": (["paper", "--figures", "2", "--out", "."], xr.Dataset),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [name if name in ("gas", "sweep", "sweep, store", "drop") else slow(name) for name in COMMANDS]
)
def test_what_a_command_saves_is_loaded(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And is not empty for programs that read the root only."""
    monkeypatch.chdir(tmp_path)
    words, kind = COMMANDS[name]
    run(*words)
    (path,) = [path for path in tmp_path.iterdir() if path.suffix in (".nc", ".zarr")]
    assert isinstance(hl.load(path), kind)
    with xr.open_dataset(path) as root:
        assert root.data_vars


def test_the_table_of_a_drop(tmp_path: Path) -> None:
    run("drop", "--restitution", "0.7", "--gap", "0.1mm", "--save", tmp_path / "drop.nc")
    tree, exact = hl.load(tmp_path / "drop.nc"), hl.newton(hl.Column.paper(restitution=0.7, gap=1e-4))
    table = tree.sel(model="newton")
    assert table.n_contacts == exact.n_contacts and table.separation_velocity == exact.separation_velocity
    assert tree["newton/trajectory"].to_dataset(inherit=False).sizes["ball"] == 2
    assert len(tree["newton/contacts"].begin) == len(exact.contact_times[0])


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = hl.event_driven(box(2), restitution=0.9, until=0.0).save(tmp_path / "run.nc")
    content = path.read_bytes()
    chance = np.random.default_rng(0)
    for _ in range(30):
        damaged = bytearray(content[: chance.integers(len(content))])
        (tmp_path / "damaged.nc").write_bytes(damaged)
        assert "damaged" in refusal(lambda: hl.load(tmp_path / "damaged.nc"))
    pd.DataFrame({"a": [1.0]}).to_csv(tmp_path / "table.csv")
    xr.Dataset({"a": 1.0}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    xr.Dataset(attrs={"title": "hardlimit gas"}).to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    newer = xr.Dataset({"a": 1.0}, attrs={saving.RESULT: "ParticleResult 99"})
    newer.to_netcdf(tmp_path / "newer.nc", engine="h5netcdf")
    for name, words in {
        "table.csv": "not a NetCDF file",
        "other.nc": "must be a file of hardlimit",
        "old.nc": "has no data at its root; xarray.open_groups reads its groups",
        "newer.nc": "got format 99, must be 1",
        ".": "must be a NetCDF file or the Zarr store of a sweep",
    }.items():
        assert words in refusal(lambda file=name: hl.load(tmp_path / file))
    assert refusal(lambda: hl.load(3)).startswith("path: got 3, must be a path")
