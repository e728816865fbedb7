"""What walls get from particles, rates of work, parts of the pressure tensor, the volume between moving walls."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
import scipy
from hypothesis import example, given
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import NEWTON, RULES, solved
from conftest import draws, refusal, slow
from hardlimit.boxes.box import component_axes
from hardlimit.boxes.observables import OBSERVABLES, Samples

WAVEFORMS = ("sine", "triangle", "parabola")
ENGINES = [*RULES, *(slow(name) if name.endswith("viscoelastic") else name for name in NEWTON)]


def wall_of(random: np.random.Generator) -> hl.MovingWall:
    if random.random() < 0.3:
        return hl.MovingWall(velocity=random.uniform(-0.01, 0.01))
    frequency = random.uniform(20.0, 100.0)
    return hl.MovingWall(
        random.uniform(1e-5, 3e-4), frequency, str(random.choice(WAVEFORMS)), random.uniform(-3.0, 3.0)
    )


def box_of(seed: int, n: int = 30, moving: bool = True) -> hl.ParticleSystem:
    """A random box with one walled axis or more, some of whose walls move, gravity, and unequal particles."""
    random = np.random.default_rng(seed)
    d = int(random.integers(2, 4))
    walled = random.random(d) < 0.6
    walled[random.integers(d)] = True
    boundary = ["wall" if wall else "periodic" for wall in walled]
    names = [f"{'xyz'[axis]}{end}" for axis in range(d) if walled[axis] for end in "-+"]
    walls = {name: wall_of(random) for name in names if moving and random.random() < 0.5}
    gravity = np.where(random.random(d) < 0.5, random.uniform(-5.0, 5.0, d), 0.0)
    radius = 1e-3 if random.random() < 0.5 else (0.5e-3, 1e-3)
    return hl.ParticleSystem.random(
        n, 0.1, radius, 2500.0, 0.3, dimension=d, boundary=boundary, gravity=gravity, walls=walls, seed=seed
    )


def given_to_walls(run: Any, name: str) -> dict[str, float]:
    """The sums at the end of a run, by wall."""
    last = run.series[name][-1]
    return dict(zip(last.wall.values.tolist(), last.values.tolist(), strict=True))


@pytest.mark.parametrize("rule", ["constant", "tc", "law"])
@draws(40)
@given(seed=st.integers(0, 2**20))
def test_each_wall_gets_what_the_log_of_hard_spheres_says(rule: str, seed: int) -> None:
    """m(u + u') along the normal in each collision of a wall, with the speeds u and u' relative to it."""
    system = box_of(seed)
    run = solved(rule, system, 0.05, samples=5, log=True)
    rows, impulse = run.collisions, given_to_walls(run, "wall_impulse")
    speeds = rows.impact_speed.values + rows.separation_speed.values
    expected = dict.fromkeys(impulse, 0.0)
    for first, second, speed in zip(rows.first.values, rows.second.values, speeds, strict=True):
        if second < 0:
            expected["xyz"[(-1 - second) // 2] + "-+"[(-1 - second) % 2]] += system.mass[first] * speed
    assert impulse == pytest.approx(expected, rel=1e-10, abs=1e-10 * max(expected.values()))
    # Energy: pairs lose μ(u² − u'²)/2, the rest is lost at walls.
    m = np.array(system.mass)
    pairs = rows.second.values >= 0
    a, b = m[rows.first.values[pairs]], m[rows.second.values[pairs]]
    u, after = rows.impact_speed.values[pairs], rows.separation_speed.values[pairs]
    of_pairs = float((0.5 * a * b / (a + b) * (u - after) * (u + after)).sum())
    at_walls = float(run.series.wall_energy[-1].sum() + run.series.wall_work[-1])
    assert at_walls + of_pairs == pytest.approx(float(run.series.dissipated_energy[-1]), rel=1e-10)


@pytest.mark.parametrize("engine", NEWTON)
@pytest.mark.parametrize("velocity", [slow(0.0), 0.02, slow(-0.02)])
def test_each_wall_gets_what_the_log_of_newtons_equations_says(engine: str, velocity: float) -> None:
    """m(u + u') in each contact of a lone disk, and m(u² − u'²)/2 less the work of the wall, which moves uniformly."""
    system = hl.ParticleSystem(
        [[0.02, 0.013]], [[0.5, -0.3]], 2e-3, density=2500.0, box=0.04, boundary="wall",
        walls={"x+": hl.MovingWall(velocity=velocity)},
    )  # fmt: skip
    run = solved(engine, system, 1.5, log=True)
    m, rows = float(system.mass[0]), run.contacts
    impulse = dict.fromkeys(("x-", "x+", "y-", "y+"), 0.0)
    energy = dict(impulse)
    for wall, u, after in zip(
        rows.second.values, rows.impact_speed.values, rows.separation_speed.values, strict=True
    ):
        name = "xyz"[(-1 - wall) // 2] + "-+"[(-1 - wall) % 2]
        impulse[name] += m * (u + after)
        work = -m * (u + after) * velocity if name == "x+" else 0.0
        energy[name] += 0.5 * m * (u - after) * (u + after) - work
    assert len(rows.second) > 10 and not np.isnan(rows.end.values).any()
    tolerance = 1e-8 if engine.startswith("events") else 2e-3
    assert given_to_walls(run, "wall_impulse") == pytest.approx(impulse, rel=tolerance)
    assert given_to_walls(run, "wall_energy") == pytest.approx(energy, rel=10 * tolerance)


@pytest.mark.parametrize("law", ["linear", "viscoelastic"])
def test_sums_of_walls_in_clusters_agree_between_the_engines(law: str) -> None:
    """A column pressed on the floor: several contacts at a time, sampled while they last."""
    x = [[0.01, 1e-3 + 1.9e-3 * k] for k in range(4)]
    system = hl.ParticleSystem(
        x, [[0.0, -0.2 * k] for k in range(4)], 0.95e-3, density=2500.0, box=0.02, boundary="wall",
        gravity=9.81, walls={"y-": hl.MovingWall(5e-5, 300.0)},
    )  # fmt: skip
    until = 4e-3
    runs = [
        solved(f"events, {law}", system, until, samples=40),
        hl.molecular_dynamics(
            system,
            law=NEWTON[f"steps, {law}"]["law"],
            until=until,
            samples=40,
            engine="steps",
            time_step=1e-8,
        ),
    ]
    assert all(run.outcome == "ok" for run in runs) and runs[0].largest_cluster >= 3
    for name in ("wall_impulse", "wall_energy"):
        left, other = (run.series[name].sel(wall="y-").values for run in runs)
        assert abs(left).max() > 0.0
        np.testing.assert_allclose(left, other, atol=1e-3 * abs(left).max())


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["constant", "events, linear", "steps, linear"])
def test_the_momentum_flux_of_an_elastic_gas_is_its_pressure(engine: str) -> None:
    """Between two walls the centres have the length L − 2R. By the virial theorem P_zz of the whole box is the flux
    times (L − 2R)/L, and the flux is the pressure n T m (1 + 4φ + 10φ²) at the density between the walls."""
    L, radius, n = 0.06, 1e-3, 300
    x = hl.ParticleSystem.random(
        n, n * 4 / 3 * math.pi * radius**3 / L**3, radius, 2500.0, 0.5, boundary=["periodic"] * 2 + ["wall"]
    )
    law = hl.LinearDashpot(stiffness=1e6, restitution=1.0)
    if engine == "constant":
        run = hl.event_driven(x, restitution=1.0, until=10.0, samples=400)
    else:
        run = hl.molecular_dynamics(x, law=law, until=2.0, samples=400, engine=engine.split(",")[0])
    flux = run.series.wall_pressure
    low, high = (hl.measure.steady(flux.sel(wall=name)).mean for name in ("z-", "z+"))
    p = hl.measure.pressure_tensor(run)
    zz, error = (
        float(p[name].sel(row="z", column="z")) for name in ("pressure_tensor", "pressure_tensor_error")
    )
    edge = float(x.box[2])
    for wall in (low, high):
        expected = zz * edge / (edge - 2 * radius)
        assert abs(wall.value - expected) < 4.0 * math.hypot(wall.error, error)
        assert wall.error < 0.05 * wall.value
    between = x.domain.volume * (edge - 2 * radius) / edge
    phi = n * 4 / 3 * math.pi * radius**3 / between
    temperature = float(run.series.granular_temperature[0])
    state = float(x.mass.sum()) * temperature / between * (1 + 4 * phi + 10 * phi**2)
    mean = 0.5 * (low.value + high.value)
    assert abs(mean - state) < 3.0 * math.hypot(low.error, high.error) + 0.01 * state
    assert float(abs(run.series.wall_energy).max()) < 1e-3 * float(run.series.kinetic_energy[0])


@pytest.mark.parametrize("engine", ["constant", "events, linear"])
def test_the_energy_flux_of_a_shaken_floor_is_the_dissipation(engine: str) -> None:
    """In the steady state the floor gives what is lost elsewhere: its work, less what is lost in its contacts."""
    system = hl.ParticleSystem.random(
        60, 0.05, 1e-3, 2500.0, 0.3, dimension=2, boundary=["periodic", "wall"], gravity=9.81, seed=2,
        walls={"y-": hl.MovingWall(5e-4, 60.0)},
    )  # fmt: skip
    run = solved(engine, system, 4.0, samples=80)
    assert run.outcome == "ok"
    steady = run.series.sel(time=slice(1.0, None))
    from_floor = -steady.wall_heat_flux.sel(wall="y-") * float(system.box[0])
    lost = steady.dissipation_rate
    supplied = hl.measure.steady(from_floor).mean
    at_floor = steady.wall_heat_flux.sel(wall="y-") * float(system.box[0]) + steady.wall_power
    in_pairs = lost - at_floor
    assert supplied.value == pytest.approx(float(in_pairs.mean()), abs=4.0 * supplied.error)
    assert supplied.error < 0.2 * supplied.value


# --- rates --------------------------------------------------------------------------------------------------

RATES = {
    "dissipation_rate": "dissipated_energy",
    "wall_power": "wall_work",
    "shear_power": "shear_work",
    "heating_power": "heat",
}


@pytest.mark.parametrize("engine", ENGINES)
@draws(20)
@given(seed=st.integers(0, 2**20), heated=st.booleans())
def test_rates_times_time_are_the_sums(engine: str, seed: int, heated: bool) -> None:
    system = box_of(seed)
    if heated:
        system = system.replace(thermostat=hl.RandomKicks(power=1e-5, interval=1e-3))
    run = solved(engine, system, 0.01, samples=6)
    lasted = np.diff(run.series.time)
    for rate, total in RATES.items():
        rates, expected = run.series[rate].values, run.series[total].values
        assert math.isnan(rates[0])
        np.testing.assert_allclose(rates[1:] * lasted, np.diff(expected), rtol=1e-12, atol=1e-300)
    assert bool(heated) == bool(run.series.heating_power[-1] != 0.0)


# --- pressure tensor ----------------------------------------------------------------------------------------


def sheared(rate: float = 40.0, **changed: Any) -> hl.ParticleSystem:
    arguments: dict[str, Any] = {"boundary": ("periodic", "lees-edwards", "periodic"), "seed": 1}
    return hl.ParticleSystem.random(
        arguments.pop("n", 200), 0.2, 1e-3, 2500.0, 0.2, shear_rate=rate, **arguments | changed
    )


@pytest.mark.parametrize("engine", ENGINES)
@draws(20)
@given(seed=st.integers(0, 2**20), shear=st.booleans())
def test_parts_of_the_pressure_tensor_are_those_of_the_states(engine: str, seed: int, shear: bool) -> None:
    """The kinetic part has the velocities relative to the flow, and the parts add up."""
    system = sheared(50.0, seed=seed) if shear else box_of(seed)
    d = system.dimension
    first, second = component_axes(d)

    def kinetic(now: hl.ParticleSystem) -> Any:
        c = now.velocities - now.domain.mean_flow(now.positions)
        c = c - now.mass @ c / now.mass.sum()
        return now.mass @ (c[:, first] * c[:, second]) / now.domain.volume

    run = solved(engine, system, 0.01, samples=5, observe={"own": kinetic})
    series = run.series
    total, of_motion, of_contacts = (
        series[name].values[1:]
        for name in ("pressure_tensor", "kinetic_pressure_tensor", "collisional_pressure_tensor")
    )
    np.testing.assert_allclose(of_motion + of_contacts, total, rtol=1e-12, atol=1e-12 * abs(total).max())
    np.testing.assert_allclose(total[:, :d].mean(axis=1), series.pressure[1:], rtol=1e-12)
    own = series.own.values
    tolerance = 0.02 if system.domain.moving else 1e-6
    expected = 0.5 * (own[1:] + own[:-1])
    np.testing.assert_allclose(of_motion[:, d:], expected[:, d:], atol=tolerance * abs(own).max())
    # The isotropic correction to the exact mean of the energy leaves the differences.
    difference, wanted = (part[:, 0] - part[:, 1] for part in (of_motion, expected))
    np.testing.assert_allclose(difference, wanted, atol=tolerance * abs(own).max())
    np.testing.assert_array_equal(series.shear_stress[1:], -total[:, d])
    np.testing.assert_array_equal(series.first_normal_stress_difference[1:], total[:, 1] - total[:, 0])


def test_stresses_of_a_gradient_along_z_are_those_along_y() -> None:
    """The same box with its axes y and z exchanged."""
    original = sheared()
    swap = [0, 2, 1]
    other = sheared(boundary=("periodic", "periodic", "lees-edwards")).replace(
        positions=original.positions[:, swap], velocities=original.velocities[:, swap]
    )
    a, b = (hl.event_driven(x, restitution=0.9, until=0.02, samples=4).series for x in (original, other))
    for name in ("shear_stress", "first_normal_stress_difference"):
        np.testing.assert_allclose(a[name][1:], b[name][1:], rtol=1e-6)
    assert float(a.shear_stress[1:].mean()) > 0.0


def test_the_pressure_tensor_of_a_run_has_rows_columns_and_errors() -> None:
    run = hl.event_driven(sheared(), restitution=0.9, until=0.5, samples=200)
    p = hl.measure.pressure_tensor(run)
    assert p.pressure_tensor.dims == ("row", "column") and p.row.values.tolist() == ["x", "y", "z"]
    np.testing.assert_allclose(p.kinetic + p.collisional, p.pressure_tensor, rtol=1e-12)
    np.testing.assert_array_equal(p.pressure_tensor, p.pressure_tensor.values.T)
    used = run.series.isel(time=run.series.time.values > p.attrs["start"])
    xy = p.sel(row="x", column="y")
    assert float(xy.pressure_tensor) == pytest.approx(-float(used.shear_stress.mean()), rel=1e-12)
    assert 0.0 < float(xy.pressure_tensor_error) < 0.1 * abs(float(xy.pressure_tensor))
    later = hl.measure.pressure_tensor(run, start=0.4)
    assert later.attrs["start"] == pytest.approx(0.4, abs=1e-9)
    assert float(later.pressure_tensor_error.mean()) > float(p.pressure_tensor_error.mean())
    flat = hl.event_driven(
        sheared(dimension=2, boundary=("periodic", "lees-edwards")), restitution=0.9, until=0.1
    )
    assert hl.measure.pressure_tensor(flat).attrs["units"] == "N/m"
    assert "start: got 0.499" in refusal(lambda: hl.measure.pressure_tensor(run, start=0.499))
    assert "run: got 3, must be a result" in refusal(lambda: hl.measure.pressure_tensor(3))  # type: ignore[arg-type]


def test_pictures_have_a_line_for_each_label() -> None:
    run = solved("constant", box_of(1), 0.05, samples=20)
    for name in ("wall_pressure", "wall_heat_flux", "kinetic_pressure_tensor"):
        (ax,) = hl.measure.plot(run.series[name]).axes
        assert len(ax.lines) == run.series[name].shape[1] == len(ax.get_legend().get_texts())
    (ax,) = hl.measure.plot(hl.measure.pressure_tensor(run, start=0.0)).axes
    labels = [text.get_text() for text in ax.get_xticklabels()]
    assert labels == run.series.component.values.tolist()


# --- volume -------------------------------------------------------------------------------------------------


@example("sine", 1.0, 1.0, -1e-94, 0.0, 0.0, 1.0)  # the phase as a part of a period is rounded to a whole one
@draws(100)
@given(
    waveform=st.sampled_from(WAVEFORMS),
    amplitude=st.floats(0.0, 1.0),
    frequency=st.floats(0.1, 30.0),
    phase=st.floats(-7.0, 7.0),
    velocity=st.floats(-1.0, 1.0),
    begin=st.floats(-1.0, 1.0),
    lasted=st.floats(1e-3, 1.0),
)
def test_mean_displacement_of_a_wall(
    waveform: str,
    amplitude: float,
    frequency: float,
    phase: float,
    velocity: float,
    begin: float,
    lasted: float,
) -> None:
    """Against quadrature; over no time it is the displacement."""
    own = (amplitude, frequency) if amplitude else (0.0, 0.0)
    wall = hl.MovingWall(*own, waveform, phase, velocity=velocity, offset=0.3)
    ends = np.array([begin]), np.array([begin + lasted])
    kinks = np.arange(math.floor(4 * frequency * begin), 4 * frequency * (begin + lasted) + 8)
    kinks = (kinks / 4 - (phase / (2 * math.pi)) % 0.25) / frequency
    grid = [begin, *(t for t in kinks if begin < t < begin + lasted), begin + lasted]
    exact = sum(
        scipy.integrate.quad(wall.displacement, a, b, epsabs=1e-12)[0] for a, b in itertools.pairwise(grid)
    )
    assert wall.mean_displacement(*ends)[0] == pytest.approx(exact / lasted, abs=1e-9)
    assert wall.mean_displacement(ends[0], ends[0])[0] == pytest.approx(wall.displacement(begin), abs=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_volume_is_that_between_the_walls(engine: str) -> None:
    """Also in a result, whose walls have moved."""
    walls = {"y-": hl.MovingWall(2e-4, 60.0, phase=1.0), "y+": hl.MovingWall(velocity=-0.05)}
    system = hl.ParticleSystem.random(30, 0.1, 1e-3, 2500.0, 0.3, boundary="wall", walls=walls)
    run = solved(engine, system, 0.05, samples=9)
    t = run.series.time.values
    length = system.box[1] - 0.05 * t - 2e-4 * np.sin(2 * math.pi * 60.0 * t + 1.0)
    volume = system.box[0] * system.box[2] * length
    np.testing.assert_allclose(run.series.volume, volume, rtol=1e-12)
    filled = float((4 / 3 * math.pi * system.radius**3).sum())
    np.testing.assert_allclose(run.series.packing_fraction, filled / volume, rtol=1e-12)
    assert run.system.packing_fraction == pytest.approx(filled / volume[-1], rel=1e-12)
    mean = Samples(run.system, run.samples, run.time).mean_volume()
    area = run.series.wall_impulse.sel(wall="x-").diff("time").values / (np.diff(t) * mean / system.box[0])
    np.testing.assert_allclose(run.series.wall_pressure.sel(wall="x-")[1:], area, rtol=1e-12)
    pressures = OBSERVABLES["pressure"].values(Samples(system, run.samples))
    np.testing.assert_allclose(run.series.pressure, pressures, rtol=1e-9)


def test_a_piston_compresses_an_elastic_gas_adiabatically() -> None:
    """To half of the volume, slowly: T V^(2/3) stays, less for the work of collisions at φ = 0.01 to 0.02, where the
    compressibility Z = 1 + 4φ multiplies dT/T = −(2/3) Z dV/V; and pV = M T Z."""
    system = hl.ParticleSystem.random(
        300, 0.01, 1e-3, 2500.0, 1.0, boundary=["periodic"] * 2 + ["wall"], seed=4
    )
    edge = float(system.box[2])
    until = 2.0
    system = system.replace(walls={"z+": hl.MovingWall(velocity=-0.5 * edge / until)})
    series = hl.event_driven(system, restitution=1.0, until=until, samples=50).series
    assert float(series.volume[-1]) == pytest.approx(0.5 * float(series.volume[0]), rel=1e-12)
    grown = float(series.granular_temperature[-1] / series.granular_temperature[0])
    assert grown == pytest.approx(2 ** (2 / 3) * math.exp(2 / 3 * 4 * (0.02 - 0.01)), rel=0.06)
    z = series.pressure * series.volume / (float(system.mass.sum()) * series.granular_temperature)
    assert float(z[1:10].mean()) == pytest.approx(1 + 4 * 0.01, rel=0.02)
    assert float(z[-10:].mean()) == pytest.approx(1 + 4 * 0.02, rel=0.02)
