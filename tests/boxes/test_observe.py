"""observe=: a user function called at each sample; its values in the series, in checkpoints and after resume."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import LAW, run
from conftest import draws
from same_samples import same_samples

NAMES = ("constant", "soft", "events", "steps")
every_run = pytest.mark.parametrize("name", NAMES)


def grains(seed=1, dimension=3, boundary="periodic", gravity=0.0):
    return hl.ParticleSystem.random(
        10, 0.1, (0.006, 0.01), 2500.0, 0.5, dimension=dimension, seed=seed, boundary=boundary, gravity=gravity
    )  # fmt: skip


def look(time, system):
    """Returns a float, a vector, a tensor and an integer."""
    velocities = system.velocities
    return {
        "at": time,
        "speed": np.sqrt((velocities**2).sum(axis=1)),
        "stress": system.mass @ (velocities[:, :, None] * velocities[:, None, :]).swapaxes(0, 1),
        "left": int((system.positions[:, 0] < 0.5 * system.box[0]).sum()),
        "temperature": system.granular_temperature,
    }


@draws(20)
@given(
    name=st.sampled_from(NAMES),
    seed=st.integers(0, 99),
    dimension=st.sampled_from([2, 3]),
    boundary=st.sampled_from(["periodic", "wall"]),
    gravity=st.sampled_from([0.0, 9.81]),
    samples=st.integers(1, 9),
)
def test_values_are_those_of_the_samples(name, seed, dimension, boundary, gravity, samples):
    system = grains(seed, dimension, boundary, gravity)
    plain = run(name, system, samples=samples)
    result = run(name, system, samples=samples, observe=look)
    assert result.system == plain.system  # observing does not change the run
    series = result.series
    assert np.array_equal(series["at"], series.time) and series.at.dims == ("time",)
    assert series.speed.dims == ("time", "speed_0") and series.stress.dims == ("time", "stress_0", "stress_1")
    assert series.left.dtype.kind == "i" and series.sizes["speed_0"] == system.n
    assert series.temperature.values == pytest.approx(series.granular_temperature.values, rel=1e-9)
    for key, value in look(result.time, result.system).items():
        assert np.array_equal(series[key].values[-1], value)
    assert series.drop_vars(list(result.observed.data)).equals(plain.series)


@every_run
def test_a_resumed_run_has_the_same_values(name, tmp_path):
    system, path = grains(3, gravity=9.81), tmp_path / "run.checkpoint"
    whole = run(name, system, samples=8, observe=look)
    run(name, system, until=0.1, samples=4, observe=look, checkpoint=path)
    assert same_samples(hl.resume(path, until=0.2, observe=look), whole)


@every_run
@pytest.mark.parametrize("k", [0, 3, 8])
def test_an_exception_ends_the_run_and_loses_nothing(name, k, tmp_path):
    system, path = grains(4, dimension=2), tmp_path / "run.checkpoint"
    whole, calls = run(name, system, samples=8, observe=look), []

    def broken(time, system):
        calls.append(time)
        if len(calls) > k:
            raise ZeroDivisionError("mine")
        return look(time, system)

    with pytest.raises(ZeroDivisionError, match=r"\Amine\nat .* s of 0.2 s; kept .*run.checkpoint\Z"):
        run(name, system, samples=8, observe=broken, checkpoint=path)
    assert len(calls) == k + 1
    assert same_samples(hl.resume(path, observe=look), whole)


def test_a_run_without_an_end_in_time_keeps_the_values_of_its_samples(tmp_path):
    path, options = tmp_path / "run.checkpoint", {"restitution": 0.9, "samples": 5, "observe": look}
    whole = hl.event_driven(grains(), max_collisions=300, **options)
    assert np.array_equal(whole.series["at"], whole.series.time)
    hl.event_driven(grains(), max_collisions=100, checkpoint=path, **options)
    resumed = hl.resume(path, max_collisions=300, observe=look)
    assert resumed.system == whole.system and np.array_equal(resumed.series["at"], resumed.series.time)


def labelled(system, name="z", values=(1.0, 2.0, 3.0), unit="m"):
    """A DataArray over a coordinate."""
    labels = np.array(values) * system.granular_temperature
    return xr.DataArray(
        labels, {name: (name, list(values), {"units": unit})}, name, attrs={"units": "J", "n": 3}
    )


def several(system):
    """A Dataset."""
    vector = xr.DataArray(system.momentum, {"axis": list("xyz")[: system.dimension]}, "axis")
    return xr.Dataset({"vector": vector, "scalar": 2, "kept": labelled(system)})


OBSERVE = [look, {"labelled": labelled, "set": several, "pair": lambda system: {"n": system.n}}]


@every_run
def test_data_arrays_keep_their_labels(name, tmp_path):
    system, path = grains(5), tmp_path / "run.checkpoint"
    whole = run(name, system, samples=6, observe=OBSERVE)
    series, last = whole.series, whole.system
    xr.testing.assert_identical(series.labelled.isel(time=-1, drop=True).rename(None), labelled(last))
    xr.testing.assert_identical(
        series.set_vector.isel(time=-1, drop=True).rename("vector"), several(last).vector
    )
    assert series.set_kept.dims == ("time", "z") and series.set_scalar.dims == ("time",)
    assert series.z.attrs == {"units": "m"} and series.pair_n.values.tolist() == [system.n] * 7
    assert series.axis.values.tolist() == ["x", "y", "z"] and np.array_equal(series["at"], series.time)
    run(name, system, until=0.1, samples=3, observe=OBSERVE, checkpoint=path)
    assert hl.resume(path, until=0.2, observe=OBSERVE).series.identical(series)
    with pytest.raises(
        ValueError, match=r"got other values of the coordinate 'z', must be those of the previous"
    ):
        moved = {
            name: lambda s, f=f: f(s).assign_coords(z=[1.0, 2.0, 4.0])
            for name, f in list(OBSERVE[1].items())[:2]
        }
        hl.resume(path, until=0.4, observe=[look, OBSERVE[1] | moved])


def changing(first, then):
    """A function whose second call returns values of a different kind."""
    returned = iter([first, then])
    return lambda time, system: next(returned)


REFUSED = {
    "no function": (3, "observe: got 3, must be a function of time and system"),
    "a sequence with a number": (
        [look, 3],
        "observe: got .*, must be a function of time and system, functions of the",
    ),
    "a name of a number": (
        {"a": 3},
        "observe: got {'a': 3}, must be a function of time and system, functions of",
    ),
    "a text for a function": ("look", "observe: got 'look', must be a function of time and system"),
    "a name twice": (
        [{"a": lambda s: 1.0}, lambda t, s: {"a": 2.0}],
        "got the name 'a' twice, must be",
    ),
    "two coordinates of one name": (
        {"a": labelled, "b": lambda s: labelled(s, values=(1.0, 2.0, 4.0))},
        "observe: at 0 s got other values of the coordinate 'z' with 'b', must be the same",
    ),
    "two lengths of one dimension": (
        {"a": lambda s: xr.DataArray([1.0], dims="z"), "b": lambda s: xr.DataArray([1.0, 2.0], dims="z")},
        "observe: at 0 s got 2 values of 'b' along 'z', must be 1",
    ),
    "a wrong axis": (
        {"a": lambda s: labelled(s, "axis")},
        "got other values of the coordinate 'axis' with 'a'",
    ),
    "a dimension of time": ({"a": lambda s: labelled(s, "time")}, "'time' is in the series already"),
    "a coordinate of dates": (
        {"a": lambda s: xr.DataArray([1.0], {"z": np.array(["2000-01-01"], "M8[ns]")}, "z")},
        "got the coordinate 'z' with 'a', must have numbers or words",
    ),
    "a coordinate that is an observable": (
        {"a": lambda s: labelled(s).assign_coords(pressure=("z", [1.0, 2.0, 3.0]))},
        "got the coordinate 'pressure', which is in the series already: rename it",
    ),
    "other dimensions": (
        changing({"a": xr.DataArray([1.0], dims="y")}, {"a": xr.DataArray([1.0], dims="z")}),
        r"observe: at 0.1 s got 'a' over \('z',\), must be \('y',\) as before",
    ),
    "no mapping": (lambda t, s: 1.0, "observe: at 0 s got 1.0, must return a mapping of names to numbers"),
    "no name": (lambda t, s: {1: 1.0}, "observe: at 0 s got the name 1, must be a non-empty text"),
    "a text": (lambda t, s: {"a": "b"}, "observe: at 0 s got 'b' for 'a', must be a number or numbers"),
    "nothing": (lambda t, s: {"a": None}, "observe: at 0 s got None for 'a', must be a number or numbers"),
    "complex": (lambda t, s: {"a": 1j}, "observe: at 0 s got 1j for 'a', must be a number or numbers"),
    "ragged": (lambda t, s: {"a": [[1], [1, 2]]}, "for 'a', must be a number or numbers"),
    "an observable": (
        lambda t, s: {"pressure": 1.0},
        "observe: at 0 s got the name 'pressure', must be another one: 'pressure' is in the series already",
    ),
    "a coordinate": (lambda t, s: {"time": t}, "must be another one: 'time' is in the series already"),
    "a dimension": (
        lambda t, s: {"a": [1.0], "a_0": 2.0},
        "must be another one: 'a_0' is in the series already",
    ),
    "other names": (
        changing({"a": 1.0}, {"b": 1.0}),
        "observe: at 0.1 s got the names 'b', must be those of the previous sample: 'a'",
    ),
    "another shape": (
        changing({"a": 1.0}, {"a": [1.0]}),
        r"observe: at 0.1 s got 'a' of shape \(1,\), must be \(\) as at the previous",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_observation_is_refused(case):
    observe, message = REFUSED[case]
    with pytest.raises(ValueError, match=message) as caught:
        hl.event_driven(grains(), restitution=0.9, until=0.2, samples=2, observe=observe)
    assert "\n" not in str(caught.value)


def test_a_checkpoint_needs_its_function_again(tmp_path):
    with_one, without = tmp_path / "a", tmp_path / "b"
    run("events", grains(), checkpoint=with_one, observe=look)
    run("constant", grains(), checkpoint=without, observe=lambda time, system: {})
    with pytest.raises(ValueError, match=r"^observe: missing, must be the function with which"):
        hl.resume(with_one)
    with pytest.raises(
        ValueError,
        match=r"^observe: at \S+ s got the names 'at', .* must be those of the previous sample: none",
    ):
        hl.resume(without, until=0.4, observe=look)
    assert hl.resume(without, until=0.4).observed.data == {}
    with pytest.raises(ValueError, match=r"^observe: got 1, must be a function of time and system"):
        hl.resume(with_one, observe=1)


def test_lammps_calls_no_function():
    with pytest.raises(
        ValueError, match=r"must be left out with engine 'lammps'; 'events' or 'steps' accepts it$"
    ):
        hl.molecular_dynamics(grains(), law=LAW, until=0.1, engine="lammps", observe=look)
