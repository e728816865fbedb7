"""Thermostats: kicks that all engines share, their power, the steady state against kinetic theory, and bits."""

import dataclasses
import math
import os
import sys
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hardlimit as hl
from box_engines import LINEAR, SOLVERS, interrupt_at, solved
from conftest import refusal, slow
from hardlimit.boxes import checkpoint, engines, observe, thermostats
from hardlimit.boxes import run as running
from hardlimit.boxes.engines import Engine
from hardlimit.boxes.system import described
from hardlimit.support import saving

KICKS = hl.RandomKicks(power=1e-3, interval=5e-4, seed=3)
#: Dimension and radii: disks of one size, and spheres of many.
SIZES = [(2, 1e-3), (3, (0.5e-3, 2e-3))]


def gas(n: int = 100, thermostat: Any = KICKS, **changed: Any) -> hl.ParticleSystem:
    arguments: dict[str, Any] = {
        "packing_fraction": 0.2, "radius": 1e-3, "density": 2500.0, "rms_speed": 0.3, "seed": 1,
        "thermostat": thermostat,
    }  # fmt: skip
    return hl.ParticleSystem.random(n, **arguments | changed)


def test_all_engines_get_the_same_kicks() -> None:
    """Particles that never touch: the same positions and velocities under every engine, to rounding."""
    system = gas(20, packing_fraction=1e-7, dimension=2)
    ends = [solved(name, system, 0.01).system for name in SOLVERS]
    for end in ends[1:]:
        np.testing.assert_allclose(end.velocities, ends[0].velocities, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(end.positions, ends[0].positions, rtol=1e-10)
    other = solved("constant", system.replace(thermostat=hl.RandomKicks(1e-3, 5e-4, seed=4)), 0.01).system
    assert np.abs(other.velocities - ends[0].velocities).max() > 1e-3


@pytest.mark.parametrize(("d", "radius"), SIZES)
def test_the_power_is_the_mean_heat(d: int, radius: Any) -> None:
    """10,000 degrees of freedom and more: within 5 standard deviations, from particles at rest."""
    system = gas(100, dimension=d, packing_fraction=1e-6, radius=radius, rms_speed=0.0)
    heat = []
    for seed in range(30):
        hot = system.replace(thermostat=hl.RandomKicks(power=2e-3, interval=1e-3, seed=seed))
        run = hl.event_driven(hot, restitution=1.0, until=0.05, samples=1)
        heat.append(float(run.series.heat[-1]))
    error = float(np.std(heat)) / math.sqrt(len(heat))
    assert float(np.mean(heat)) == pytest.approx(2e-3 * 0.05, abs=5.0 * error)
    assert error < 0.05 * 1e-4


def heated(e: float, n: int, periods: int, seed: int = 1) -> tuple[float, float, float]:
    """Temperature over theory, a2 over its samples, and theory's a2 of a heated gas in three dimensions."""
    system = gas(n, None, packing_fraction=0.02, rms_speed=0.1, seed=seed)
    phi = system.packing_fraction
    chi = (1.0 - 0.5 * phi) / (1.0 - phi) ** 3
    per_root = 4.0 * math.sqrt(math.pi) * n / system.domain.volume * (2e-3) ** 2 * chi
    above = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e)
    a2 = above / (73.0 + 56.0 * 3.0 - 24.0 * 3.0 * e - 105.0 * e + 30.0 * (1.0 - e) * e * e)
    mass, temperature = float(system.mass.sum()), system.granular_temperature
    power = 0.5 * mass * (1.0 - e * e) * per_root * temperature**1.5 * (1.0 + 3.0 * a2 / 16.0)
    duration = 1.0 / (per_root * math.sqrt(temperature))
    hot = system.replace(thermostat=hl.RandomKicks(power, 0.1 * duration, seed=seed))

    def observe(_: float, now: hl.ParticleSystem) -> dict[str, float]:
        square = (now.velocities**2).sum(axis=1)
        return {"second": float(square.mean()), "fourth": float((square**2).mean())}

    run = hl.event_driven(
        hot, restitution=e, until=periods * duration, samples=periods, observe=observe
    ).series.isel(time=slice(periods // 5, None))
    ratio = float(run.granular_temperature.mean()) / temperature
    cumulant = float((run.fourth / run.second**2).mean()) * 3.0 / 5.0 - 1.0
    return ratio, cumulant, a2


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.4, 0.8])
def test_the_steady_state_of_the_heated_gas(e: float) -> None:
    """T. P. C. van Noije and M. H. Ernst, Granular Matter 1, 57 (1998): the temperature within 3 % (kicks at intervals
    of a tenth of the free time, finite density), a2 = 0.038 and −0.009 within 0.006 (the linear theory is known to
    0.003 here, sampling to 0.002)."""
    temperature, cumulant, a2 = heated(e, 2000, 300)
    assert temperature == pytest.approx(1.0, abs=0.03)
    assert cumulant == pytest.approx(a2, abs=0.006)


@pytest.mark.parametrize("name", ["constant", "events, linear"])
def test_andersen_reaches_its_temperature(name: str) -> None:
    """A mixture: the same energy for small and large particles, 10 % (sampling)."""
    bath = hl.Andersen(temperature=0.04, rate=400.0, seed=2)
    system = gas(400, bath, radius=[1e-3] * 200 + [1.5e-3] * 200, packing_fraction=0.1, rms_speed=0.05)

    def observe(_: float, now: hl.ParticleSystem) -> dict[str, Any]:
        energy = now.mass * (now.velocities**2).sum(axis=1) / (3.0 * now.mass.mean())
        return {"energy": energy.reshape(2, 200).mean(axis=1)}

    more = {"law": hl.LinearDashpot(stiffness=1e5, restitution=1.0)} if "events" in name else {}
    if more:
        run = hl.molecular_dynamics(system, until=0.05, engine="events", samples=50, observe=observe, **more)
    else:
        run = hl.event_driven(system, restitution=1.0, until=0.05, samples=50, observe=observe)
    np.testing.assert_allclose(run.series.energy.values[15:].mean(axis=0), 0.04, rtol=0.1)


@pytest.mark.parametrize("per_bath_collision", [20.0, 1.0, 0.4])
def test_andersen_forgets_velocities_at_its_rate(per_bath_collision: float) -> None:
    """Free particles, at intervals of any length: exp(−rate t) of them keep their velocity, and the temperature
    relaxes at the rate, within 5 standard deviations. The share of new velocities per interval is below rate·interval.
    """
    rate, n = 100.0, 40_000
    bath = hl.Andersen(temperature=0.04, rate=rate, interval=1.0 / (per_bath_collision * rate), seed=5)
    mass, start = np.ones(n), np.full((n, 2), 1.0)
    now = start
    for kick in range(1, math.ceil(2.0 * per_bath_collision) + 1):
        now = bath.velocities(kick, now, mass)
        kept = math.exp(-rate * kick * bath.interval)
        share = float((now == start).all(axis=1).mean())
        assert share == pytest.approx(kept, abs=5.0 * math.sqrt(kept * (1.0 - kept) / n))
        energy = (now**2).mean(axis=1)
        error = float(energy.std()) / math.sqrt(n)
        assert float(energy.mean()) == pytest.approx(0.04 + (1.0 - 0.04) * kept, abs=5.0 * error)


@pytest.mark.parametrize("interval", [0.1, 1.0 / 3.0, 0.007, 1e-3 * math.pi])
@pytest.mark.parametrize("thermostat", [hl.RandomKicks(1e-9, 1.0), hl.Andersen(0.01, 1e3, interval=1.0)])
def test_no_kick_is_lost_to_rounding(thermostat: Any, interval: float) -> None:
    """k kicks until k·interval, however the product is rounded: 3·0.1 is above 0.3. Parts of a run add up."""
    system = gas(3, dataclasses.replace(thermostat, interval=interval), packing_fraction=1e-7, rms_speed=0.0)
    for kicks in (1, 2, 3, 6, 7, 12, 49):
        for until in (
            kicks * interval,
            kicks / (1.0 / interval),
            float(sum(Fraction(interval) for _ in range(kicks))),
        ):
            end = hl.event_driven(system, restitution=1.0, until=until, samples=1).system
            assert end.thermostat.kicks == kicks
    for until, kicks in ((0.3, 3), (0.7, 7), (1.2, 12)):
        tenths = system.replace(thermostat=dataclasses.replace(thermostat, interval=0.1))
        kept = hl.event_driven(tenths, restitution=1.0, until=until, samples=kicks).series.heat.values
        assert np.count_nonzero(np.diff(kept)) == kicks


@pytest.mark.parametrize("name", ["constant", "events, linear", "steps, linear"])
def test_kicks_without_collisions_are_checkpointed_and_told(name: str, tmp_path: Path) -> None:
    """A single call of the engine ends after some kicks, so that the run looks at the clock."""
    system, path, told = (
        gas(20, hl.RandomKicks(1e-12, 1e-4), packing_fraction=1e-7, rms_speed=0.0),
        tmp_path / "ck",
        [],
    )

    def progress(done: int, total: int) -> None:
        told.append((done, total, path.stat().st_mtime_ns))
        assert 0 <= done <= total

    run = solved(name, system, 0.2, samples=1, checkpoint=path, checkpoint_every=1e-9, progress=progress)
    assert run.system.thermostat.kicks == 2000
    assert len({stamp for *_, stamp in told}) > 5
    assert sum(0.1 < done / total < 0.9 for done, total, _ in told) > 1


class Instructions:
    """Raises KeyboardInterrupt, as Ctrl-C does, at the instruction with this number in these functions or files."""

    def __init__(self, where: Sequence[Any], last: float = math.inf) -> None:
        self._codes = [getattr(f, "__code__", None) for f in where]
        self._files = [f.__file__ for f in where if hasattr(f, "__file__")]
        self._last, self.count = last, 0

    def __enter__(self) -> "Instructions":
        sys.settrace(self._call)
        return self

    def __exit__(self, *_: object) -> None:
        sys.settrace(None)

    def _call(self, frame: Any, *_: object) -> Any:
        if frame.f_code not in self._codes and frame.f_code.co_filename not in self._files:
            return None
        frame.f_trace_opcodes = True
        return self._step

    def _step(self, _: object, event: str, __: object) -> Any:
        self.count += event == "opcode"
        if self.count >= self._last:
            sys.settrace(None)
            raise KeyboardInterrupt
        return self._step


KICK, RUN = (Engine._kick,), (running, engines, thermostats, observe, checkpoint, saving)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")
@pytest.mark.parametrize(
    ("name", "where", "every"),
    [("constant", KICK, 31), slow("constant", KICK, 1), slow("events, linear", KICK, 7), slow("steps, linear", KICK, 7),
     *(slow(name, RUN, 293) for name in ("constant", "soft", "events, linear", "steps, linear"))],
)  # fmt: skip
def test_a_run_interrupted_at_any_instruction_has_the_same_bits(
    name: str, where: Sequence[Any], every: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Kicks, one at the time of a sample, a moving wall, a log, samples and checkpoints."""
    floor = {"boundary": ("periodic", "periodic", "wall"), "walls": {"z-": hl.MovingWall(1e-5, 300.0)}}
    system = gas(30, packing_fraction=0.3, **floor)
    monkeypatch.setattr(os, "fsync", lambda _: None)
    path = tmp_path / "run.ckpt"
    options: dict[str, Any] = {"samples": 2, "log": True, "observe": lambda time, _: {"again": time}}
    options |= {"checkpoint": path, "checkpoint_every": 1e-9 if where == RUN else 1e9}
    with Instructions(where) as all_of_them:
        whole = solved(name, system, 0.001, **options)
    went_on = 0
    for last in range(1, all_of_them.count, every):
        path.unlink(missing_ok=True)
        with pytest.raises(KeyboardInterrupt), Instructions(where, last):
            solved(name, system, 0.001, **options)
        if path.exists():
            resumed = hl.resume(path, observe=options["observe"])
            assert resumed.system == whole.system and resumed.series.identical(whole.series), last
            for column, other in zip(resumed.log, whole.log, strict=True):
                np.testing.assert_array_equal(column, other)  # NaN where a contact goes on
            went_on += 1
    assert went_on > 0.8 * all_of_them.count / every


@pytest.mark.parametrize(
    "law",
    [
        hl.LinearDashpot(stiffness=1e4, restitution=0.1),
        hl.Viscoelastic(youngs_modulus=5e7, poisson_ratio=0.3, restitution=0.1, impact_speed=1.0),
        hl.Tsuji(elastic_prefactor=1e6, restitution=0.1),
    ],
)
@pytest.mark.parametrize("seeds", [range(10, 14), slow(range(24))])
def test_a_kick_presses_grains_that_have_just_let_go(law: hl.Law, seeds: range) -> None:
    """Their force has ended before their overlap. It acts again at once if the kick makes it repulsive."""
    again = 0
    for seed in seeds:
        kicks = hl.RandomKicks(power=2e-3, interval=1e-4, seed=seed)
        system = hl.ParticleSystem(
            [[0.005, 0.01], [0.00701, 0.0101]],
            [[0.5, 0.0], [-0.5, 0.0]],
            1e-3,
            2500.0,
            box=0.02,
            thermostat=kicks,
        )
        options = {"law": law, "until": 1.5e-4, "log": True}
        events = hl.molecular_dynamics(system, engine="events", **options)
        steps = hl.molecular_dynamics(system, engine="steps", time_step=2e-8, **options)
        assert events.system.velocities == pytest.approx(steps.system.velocities, abs=2e-4)
        again += bool((events.contacts.impact_speed < 0.0).any())
    assert again > 0


RUBBING = LINEAR.replace(friction=hl.Friction(0.5))
#: The same, for long steps.
SOFT = hl.LinearDashpot(stiffness=1e-2, restitution=0.8, friction=hl.Friction(0.5))
SPINNING = hl.RandomKicks(power=1e-3, interval=5e-4, rotational=2e-3, seed=3)


def by_steps(system: hl.ParticleSystem, until: float, **options: Any) -> hl.ContactResult:
    """A run with friction."""
    settings = {"law": RUBBING, "engine": "steps", "samples": 10} | options
    return hl.molecular_dynamics(system, until=until, **settings)


@pytest.mark.parametrize(("d", "radius"), SIZES)
def test_the_rotational_power_is_the_mean_heat_of_spins(d: int, radius: Any) -> None:
    """Within 5 standard deviations, from particles at rest. Velocities get the kicks that they get without."""
    system = gas(100, dimension=d, packing_fraction=1e-3, radius=radius, rms_speed=0.0, inertia_factor=0.6)
    energies = []
    for seed in range(20):
        kicks = dataclasses.replace(SPINNING, interval=1e-6, seed=seed)
        run = by_steps(system.replace(thermostat=kicks), 4e-5, time_step=1e-7, samples=1)
        energies.append(run.system.rotational_energy)
        gained = run.system.kinetic_energy + run.system.rotational_energy
        assert float(run.series.heat[-1]) == pytest.approx(gained, rel=1e-12) and run.n_contacts == 0
    alone = system.replace(thermostat=dataclasses.replace(kicks, rotational=None))
    plain = by_steps(alone, 4e-5, time_step=1e-7)
    assert (plain.system.velocities == run.system.velocities).all() and plain.system.rotational_energy == 0.0
    error = float(np.std(energies)) / math.sqrt(len(energies))
    assert float(np.mean(energies)) == pytest.approx(2e-3 * 4e-5, abs=5.0 * error)
    assert error < 0.05 * 8e-8
    spin = run.system.angular_velocities.reshape(100, -1)[:, 0]
    assert abs(np.corrcoef(run.system.velocities[:, 0], spin)[0, 1]) < 0.5  # other random numbers


@pytest.mark.parametrize("d", [2, 3])
def test_a_bath_sets_the_rotational_temperature(d: int) -> None:
    """A mixture that does not collide: the same mean energy of small and large particles, within 5 standard deviations,
    and spins change with the velocities, exactly where a particle meets the bath."""
    bath = hl.Andersen(temperature=0.04, rate=100.0, interval=1e-3, rotational=0.01, seed=2)
    n, axes = 1000, 3 if d == 3 else 1
    radius = [1e-3] * (n // 2) + [2e-3] * (n // 2)
    system = gas(n, bath, dimension=d, radius=radius, packing_fraction=1e-6, rms_spin=5.0, rms_speed=0.01)
    run = by_steps(system, 1e-3, law=SOFT, time_step=2e-5, samples=1).system
    moved = (run.velocities != system.velocities).any(axis=1)
    turned = (run.angular_velocities != system.angular_velocities).reshape(n, -1).any(axis=1)
    assert (moved == turned).all() and 0.03 < moved.mean() < 0.2
    end = by_steps(system, 0.05, law=SOFT, time_step=2e-5, samples=1).system
    energy = end.inertia[:, None] * end.angular_velocities.reshape(n, axes) ** 2 / end.mass.mean()
    for part in (energy[: n // 2], energy[n // 2 :]):
        assert part.mean() == pytest.approx(0.01, abs=5.0 * 0.01 * math.sqrt(2.0 / part.size))


@pytest.mark.parametrize(
    "thermostat", [slow(SPINNING), hl.Andersen(0.09, 500.0, rotational=0.05, interval=5e-4)]
)
def test_heat_of_spins_closes_the_balance_and_resumes(thermostat: Any, tmp_path: Path) -> None:
    """Energy within the error of the step; checkpoints and threads keep the bits; parts continue the kicks."""
    system = gas(60, thermostat, packing_fraction=0.3, rms_spin="equal")
    path = tmp_path / "run.ckpt"
    whole = by_steps(system, 0.004, restitution_error=1e-4)
    series = whole.series
    total = (
        series.kinetic_energy + series.rotational_energy + series.contact_energy + series.dissipated_energy
    )
    assert float(abs(total - series.heat - total[0]).max()) < 1e-3 * float(series.kinetic_energy[0])
    with pytest.raises(KeyboardInterrupt):
        by_steps(system, 0.004, restitution_error=1e-4, checkpoint=path, progress=interrupt_at(6))
    resumed = hl.resume(path)
    assert resumed.system == whole.system and resumed.series.identical(whole.series)
    half = by_steps(system, 0.002, restitution_error=1e-4)
    assert half.system.thermostat == dataclasses.replace(thermostat, kicks=4)
    assert hl.load(whole.save(tmp_path / "run.nc")).system == whole.system


@pytest.mark.parametrize("thermostat", [SPINNING, hl.Andersen(0.09, 500.0, rotational=0.05, interval=5e-4)])
def test_events_and_steps_get_the_same_kicks_on_spins(thermostat: Any) -> None:
    """A gas that rubs: steps tend to events."""
    system = gas(30, thermostat, packing_fraction=0.3, dimension=2, rms_spin="equal")
    exact = by_steps(system, 0.003, engine="events")
    errors = []
    for h in (4e-7, 1e-7):
        run = by_steps(system, 0.003, time_step=h)
        errors.append(float(np.abs(run.system.angular_velocities - exact.system.angular_velocities).max()))
        assert run.n_contacts == exact.n_contacts > 5
    assert errors[1] < 0.5 * errors[0] and errors[1] < 1e-2 * float(
        np.abs(exact.system.angular_velocities).max()
    )
    series = exact.series
    total = (
        series.kinetic_energy + series.rotational_energy + series.contact_energy + series.dissipated_energy
    )
    assert float(abs(total - series.heat - total[0]).max()) < 1e-9 * float(total[0])


@pytest.mark.parametrize("name", SOLVERS)
def test_rotational_kicks_without_friction_are_refused(name: str) -> None:
    system = gas(10, SPINNING, packing_fraction=0.01, rms_spin=1.0)
    assert refusal(lambda: solved(name, system, 0.01)).startswith(
        "rotational: got 0.002, must be left out of the thermostat"
    )


def test_a_thermostat_without_rotation_is_written_as_before() -> None:
    assert hl.RandomKicks(0.0, 1.0, rotational=1.0).power == 0.0
    assert repr(KICKS) == "RandomKicks(interval=0.0005, seed=3, kicks=0, power=0.001)"
    assert "rotational" not in thermostats.as_entry(KICKS)
    assert repr(SPINNING) == "RandomKicks(interval=0.0005, seed=3, kicks=0, power=0.001, rotational=0.002)"
    assert thermostats.from_entry(thermostats.as_entry(SPINNING)) == SPINNING != KICKS


def test_tables_say_in_words_what_drives_a_box() -> None:
    assert KICKS.report() == "random kicks, power 1 mW, every 500 µs"
    assert SPINNING.report() == "random kicks, power 1 mW and 2 mW of the spins, every 500 µs"
    bath = hl.Andersen(0.1, 50.0, rotational=0.2)
    assert bath.report() == "Andersen’s bath, 0.1 m²/s² and 0.2 m²/s² of the spins, rate 50/s"
    wall = hl.MovingWall(amplitude=5e-5, frequency=50.0, phase=1.0, velocity=-0.1, offset=1e-3)
    assert wall.report() == (
        "sine, amplitude 50 µm, frequency 50 Hz, phase 1 rad, velocity −100 mm/s, offset 1 mm"
    )
    system = gas(10, SPINNING, packing_fraction=0.01, rms_spin=1.0)
    assert SPINNING.report() in dict(described(system)).values()


def test_results_continue_with_new_kicks() -> None:
    """Two halves are the whole."""
    system = gas(40)
    half = hl.event_driven(system, restitution=0.9, until=0.005)
    again = hl.event_driven(half.system, restitution=0.9, until=0.005)
    whole = hl.event_driven(system, restitution=0.9, until=0.01)
    assert again.system.thermostat == whole.system.thermostat
    np.testing.assert_allclose(again.system.positions, whole.system.positions, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: hl.RandomKicks(power=0.0, interval=1.0), "power: got 0"),
        (lambda: hl.RandomKicks(power=1.0, interval=-1.0), "interval: got -1"),
        (lambda: hl.Andersen(temperature=-1.0, rate=1.0), "temperature: got -1"),
        (lambda: hl.Andersen(temperature=1.0, rate=0.0), "rate: got 0"),
        (lambda: hl.RandomKicks(1.0, 1.0, seed=-1), "seed: got -1"),
        (lambda: hl.RandomKicks(power=0.0, interval=1.0, rotational=0.0), "power: got 0"),
        (lambda: hl.RandomKicks(1.0, 1.0, rotational=-1.0), "rotational: got -1"),
        (lambda: hl.Andersen(1.0, 1.0, rotational=math.inf), "rotational: got inf"),
        (lambda: gas(10, 3.0, packing_fraction=0.01), "thermostat: got 3.0, must be hl.RandomKicks"),
        (
            lambda: hl.ParticleSystem([[1, 1]], [[1, 0]], 0.1, mass=1, box=9, thermostat=KICKS),
            "thermostat: got random kicks",
        ),
    ],
)
def test_bad_thermostats_are_refused(make: Callable[[], Any], message: str) -> None:
    assert refusal(make).startswith(message)


def test_andersen_in_a_common_fall_is_refused() -> None:
    falling = gas(10, hl.Andersen(0.01, 10.0), packing_fraction=0.01, gravity=9.81)
    assert refusal(lambda: hl.event_driven(falling, restitution=0.9, until=0.1)).startswith("thermostat: ")
    assert hl.event_driven(falling.replace(thermostat=KICKS), restitution=0.9, until=0.01).outcome == "ok"


@pytest.mark.parametrize("seed", [0, 1, *map(slow, range(2, 6))])
def test_no_energy_is_dissipated_backwards(seed: int) -> None:
    """Rule soft: a kick ends contacts with walls, and the grain that it lifts takes its energy from the heat.

    Regression: it was taken from the dissipated energy.
    """
    heat: Any = hl.RandomKicks(1e-4, 1e-4, seed=seed)
    if seed % 2:
        heat = hl.Andersen(0.01, 200.0, interval=1e-4, seed=3 * seed + 4)
    system = hl.ParticleSystem.random(
        20, 0.1, 1e-3, 2500.0, 0.1, dimension=2, boundary=["periodic", "wall"], gravity=9.81, seed=seed,
        thermostat=heat,
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    series = hl.event_driven(system, law=law, rule="soft", until=0.5, samples=400).series
    assert (np.diff(series.dissipated_energy) >= 0.0).all()
    total = series.kinetic_energy + series.potential_energy + series.dissipated_energy - series.heat
    assert float(abs(total - total[0]).max() / abs(total).max()) < 1e-12
