"""Spins of a system in Python: values, random starts, boundaries, runs, checkpoints and results."""

import copy
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hardlimit as hl
from box_engines import SOLVERS, interrupt_at, solved
from conftest import lattice, refusal

LAW = hl.LinearDashpot(stiffness=1e4, restitution=0.8, friction=hl.Friction(0.5))
EACH_DIMENSION = pytest.mark.parametrize("d", [2, 3])


def gas(n: int = 50, d: int = 3, **changed: Any) -> hl.ParticleSystem:
    arguments: dict[str, Any] = {
        "packing_fraction": 0.2, "radius": 1e-3, "density": 2500.0, "rms_speed": 0.3, "seed": 1,
    }  # fmt: skip
    return hl.ParticleSystem.random(n, dimension=d, **arguments | changed)


def rubbed(system: hl.ParticleSystem, until: float = 0.01, **options: Any) -> hl.ContactResult:
    """A run with friction."""
    return hl.molecular_dynamics(system, law=LAW, until=until, engine="steps", **({"samples": 4} | options))


def as_rows(system: hl.ParticleSystem) -> Any:
    """Angular velocities (N, f) about f axes."""
    assert system.angular_velocities is not None
    return system.angular_velocities.reshape(system.n, -1)


# --- values -----------------------------------------------------------------------------------------------------


@EACH_DIMENSION
def test_systems_with_spins_are_values(d: int) -> None:
    spins = np.arange(8.0 * (3 if d == 3 else 1)).reshape((8, 3) if d == 3 else 8)
    system, plain = lattice(8, d, angular_velocities=spins), lattice(8, d)
    spins[0] = 7.0
    assert as_rows(system)[0, 0] == 0.0 and not as_rows(system).flags.writeable
    for copied in (pickle.loads(pickle.dumps(system)), copy.deepcopy(system), system.replace()):
        assert copied == system and hash(copied) == hash(system)
    assert system != plain != lattice(8, d, inertia_factor=0.3) != lattice(8, d, inertia_factor=0.4)
    assert system.replace(angular_velocities=2.0 * system.angular_velocities) != system
    assert plain.replace(inertia_factor=0.25).rotational_energy == plain.rotational_energy == 0.0
    inertia = (0.4 if d == 3 else 0.5) * system.mass * system.radius**2
    energy = 0.5 * float((inertia[:, None] * as_rows(system) ** 2).sum())
    assert system.rotational_energy == pytest.approx(energy, rel=1e-14)
    axes = 3 if d == 3 else 1
    assert system.rotational_temperature == pytest.approx(
        2.0 * energy / (axes * system.mass.sum()), rel=1e-14
    )
    assert np.array_equal(system.dataset.angular_velocity, system.angular_velocities)
    assert "rotational energy" in system._repr_html_() and "rotational" not in plain._repr_html_()


BAD: dict[str, tuple[Callable[[], Any], str]] = {
    "shape": (lambda: lattice(8, angular_velocities=np.ones(8)), "angular_velocities: got shape (8,), must be (8, 3)"),
    "plane": (lambda: lattice(8, 2, angular_velocities=np.ones((8, 3))), "angular_velocities: got shape (8, 3), must"),
    "text": (lambda: lattice(8, angular_velocities="x"), "angular_velocities: got 'x', must be numbers of"),
    "complex": (lambda: lattice(8, angular_velocities=1j * np.ones((8, 3))), "angular_velocities: got array(["),
    "ragged": (lambda: lattice(2, angular_velocities=[[1, 2, 3], [1]]), "angular_velocities: got [[1, 2, 3], [1]]"),
    "NaN": (lambda: lattice(1, angular_velocities=[[0, 0, math.nan]]), "angular_velocities[0]: got [0.0, 0.0, nan]"),
    "large": (lambda: lattice(2, 2, angular_velocities=[0, -1e31]), "angular_velocities[1]: got -1e+31, must be in"),
    "q": (lambda: lattice(8, inertia_factor=1.5), "inertia_factor: got 1.5, must be in [1e-06, 1]"),
    "one q": (lambda: lattice(2, inertia_factor=[0.4, 0.0]), "inertia_factor[1]: got 0, must be in [1e-06, 1]"),
    "some q": (lambda: lattice(8, inertia_factor=[0.4]), "inertia_factor: got 1 values, must be 8"),
    "rms_spin": (lambda: gas(rms_spin=-1.0), "rms_spin: got -1, must be in [0, 1e+30]"),
    "a word": (lambda: gas(rms_spin="same"), "rms_spin: got 'same', must be a number in [0, 1e+30] or 'equal'"),
    "a flag": (lambda: gas(rms_spin=True), "rms_spin: got True, must be a number in [0, 1e+30] or 'equal'"),
    "random q": (lambda: gas(inertia_factor=2.0), "inertia_factor: got 2, must be in [1e-06, 1]"),
}  # fmt: skip


@pytest.mark.parametrize("which", BAD)
def test_bad_spins_are_refused_in_one_line(which: str) -> None:
    call, message = BAD[which]
    assert refusal(call).startswith(message)


# --- random starts ----------------------------------------------------------------------------------------------


@EACH_DIMENSION
def test_random_spins(d: int) -> None:
    """Exactly the root mean square or the temperature, and none of the other values changed."""
    plain, spinning = gas(d=d), gas(d=d, rms_spin=7.0, inertia_factor=np.linspace(0.1, 1, 50))
    for name in ("positions", "velocities", "radius", "mass"):
        assert np.array_equal(getattr(plain, name), getattr(spinning, name))
    assert plain.angular_velocities is None and gas(d=d, inertia_factor=0.4).rotational_energy == 0.0
    assert math.sqrt((as_rows(spinning) ** 2).sum(axis=1).mean()) == pytest.approx(7.0, rel=1e-15)
    for boundary in ("periodic", "wall"):
        equal = gas(d=d, rms_spin="equal", boundary=boundary)
        assert equal.rotational_temperature == pytest.approx(equal.granular_temperature, rel=1e-14)
    assert not as_rows(gas(d=d, rms_spin="equal", rms_speed=0.0)).any()
    assert gas(d=d, rms_spin=7.0) == gas(d=d, rms_spin=7.0) != gas(d=d, rms_spin=7.0, seed=2)
    assert np.allclose(
        14.0 / 7.0 * as_rows(gas(d=d, rms_spin=7.0)), as_rows(gas(d=d, rms_spin=14.0)), rtol=1e-14
    )


@EACH_DIMENSION
def test_random_spins_are_independent_and_of_equal_energy(d: int) -> None:
    """Each axis and each half of the sizes has the same energy, within 5 standard deviations; spins know nothing of
    the velocities."""
    n = 4000
    system = gas(n, d, packing_fraction=0.05, radius=np.repeat([0.5e-3, 1e-3], n // 2), rms_spin="equal")
    rows = as_rows(system)
    energy = system.inertia[:, None] * rows**2 / (float(system.mass.mean()) * system.granular_temperature)
    for part in (*energy.T, energy[: n // 2], energy[n // 2 :]):
        assert part.mean() == pytest.approx(1.0, abs=5.0 * math.sqrt(2.0 / part.size))
    assert abs(np.corrcoef(rows[:, 0], system.velocities[:, 0])[0, 1]) < 5.0 / math.sqrt(n)
    fourth = (energy**2).mean() / energy.mean() ** 2
    assert fourth == pytest.approx(3.0, abs=5.0 * math.sqrt(96.0 / energy.size))


@pytest.mark.parametrize(
    ("d", "gradient", "mean"), [(2, 1, [-1.5]), (3, 1, [0, 0, -1.5]), (3, 2, [0, 1.5, 0])]
)
def test_random_spins_in_shear_are_relative_to_the_mean_flow(d: int, gradient: int, mean: Any) -> None:
    """Half of the vorticity ∇ × v of v_x = γ̇ (y − L/2), γ̇ = 3."""
    sides = ["lees-edwards" if k == gradient else "periodic" for k in range(d)]
    turning = gas(d=d, boundary=sides, shear_rate=3.0, rms_spin=0.0)
    assert (as_rows(turning) == np.array(mean)).all()
    sheared, still = (
        gas(d=d, boundary=sides, shear_rate=3.0, rms_spin=5.0),
        gas(d=d, boundary=sides, rms_spin=5.0),
    )
    assert as_rows(sheared) == pytest.approx(as_rows(still) + mean, rel=1e-14, abs=1e-14)
    assert gas(d=d, boundary=sides, shear_rate=3.0).angular_velocities is None


# --- runs -------------------------------------------------------------------------------------------------------


@EACH_DIMENSION
@pytest.mark.parametrize("name", SOLVERS)
def test_smooth_grains_keep_their_spins(name: str, d: int, tmp_path: Path) -> None:
    """The other values have the bits of a run without spins; so have checkpoints and saved results."""
    system, plain = gas(20, d, rms_spin=5.0), gas(20, d)
    path = tmp_path / "run.ckpt"
    run, without = (solved(name, of, 0.005, samples=2) for of in (system, plain))
    assert np.array_equal(run.system.velocities, without.system.velocities)
    assert np.array_equal(run.system.positions, without.system.positions)
    assert np.array_equal(run.system.angular_velocities, system.angular_velocities)
    assert without.system.angular_velocities is None
    solved(name, system, 0.002, samples=2, checkpoint=path)
    assert np.array_equal(hl.resume(path, until=0.005).system.angular_velocities, system.angular_velocities)
    if d == 3 and name in (SOLVERS[0], SOLVERS[-1]):  # each kind of result
        assert hl.load(run.save(tmp_path / "run.nc")).system == run.system


@EACH_DIMENSION
def test_runs_with_friction_keep_spins_in_checkpoints_results_and_files(d: int, tmp_path: Path) -> None:
    for system in (
        gas(20, d, packing_fraction=0.3),
        gas(20, d, packing_fraction=0.3, rms_spin="equal", inertia_factor=0.3),
    ):
        path, seen = tmp_path / "run.ckpt", []

        def observe(time: float, now: hl.ParticleSystem, seen: list[float] = seen) -> dict[str, float]:
            seen.append(now.rotational_temperature)
            return {"T_r": now.rotational_temperature}

        whole = rubbed(system, 0.004, observe=observe)
        assert whole.system.rotational_energy > 0.0 and len(set(seen)) > 1
        assert np.allclose(whole.series.T_r, whole.series.rotational_temperature, rtol=1e-9, atol=1e-18)
        with pytest.raises(KeyboardInterrupt):
            rubbed(system, 0.004, checkpoint=path, progress=interrupt_at(3), observe=observe)
        again = hl.resume(path, observe=observe)
        assert again.system == whole.system and again.series.identical(whole.series)
        for suffix in (".xyz", ".gsd"):
            loaded = hl.ParticleSystem.read(
                whole.system.write(tmp_path / f"box{suffix}"), allowed_overlap=0.1
            )
            assert loaded == whole.system
        assert whole.system.inertia_factor is not None
        solid = 0.5 if d == 2 else 0.4
        assert set(whole.system.inertia_factor) == {0.3 if system.inertia_factor is not None else solid}


def test_a_study_of_smooth_grains_ignores_spins() -> None:
    options: dict[str, Any] = {"law": LAW.replace(friction=None), "until": 0.005, "samples": 2}
    options |= {"models": ["newton", "law"], "replicas": 2}
    plain, spinning = (hl.fidelity(gas(16, 2, rms_spin=spin), **options) for spin in (None, "equal"))
    assert plain.replicas.equals(spinning.replicas)
    kicks = hl.RandomKicks(1e-6, 1e-4, rotational=1e-6)
    message = refusal(lambda: hl.fidelity(gas(16, 2, thermostat=kicks), **options))
    assert message.startswith(
        "rotational: got 1e-06, must be left out of the thermostat in a run without friction"
    )


def test_a_fall_does_not_change_spins() -> None:
    """Gravity along periodic axes: the same spins to the last bit."""
    system = gas(rms_spin="equal", packing_fraction=0.3)
    free, fallen = rubbed(system), rubbed(system.replace(gravity=[0.3, -9.81, 2.0]))
    assert np.array_equal(free.system.angular_velocities, fallen.system.angular_velocities)
    assert free.n_contacts == fallen.n_contacts > 10


@EACH_DIMENSION
def test_images_do_not_change_spins(d: int) -> None:
    """Grains that leave a sheared box through its far side and do not collide."""
    sides = ["periodic", "lees-edwards", "periodic"][:d]
    system = gas(
        10,
        d,
        packing_fraction=1e-3,
        boundary=sides,
        shear_rate=100.0,
        rms_spin="equal",
        rms_speed=0.0,
        radius=1e-3,
    )
    velocities = system.velocities + np.array([0.0, 50.0, 0.0])[:d]
    run = rubbed(system.replace(velocities=velocities), 2.0 * float(system.box[1]) / 50.0, time_step=5e-7)
    assert run.n_contacts == 0 and (run.system.shear_displacement != 0.0)
    assert np.array_equal(run.system.angular_velocities, system.angular_velocities)


@pytest.mark.slow
@pytest.mark.parametrize("gradient", [1, 2])
def test_grains_turn_with_the_mean_flow(gradient: int) -> None:
    """From rest to half of the vorticity: C. K. K. Lun, J. Fluid Mech. 233, 539 (1991). Within 5 standard errors."""
    sides = ["lees-edwards" if k == gradient else "periodic" for k in range(3)]
    system = gas(200, packing_fraction=0.3, radius=1e-3, boundary=sides, shear_rate=100.0)
    law = LAW.replace(stiffness=1e3)

    def spin(_: float, now: hl.ParticleSystem) -> dict[str, Any]:
        rows = as_rows(now) if now.angular_velocities is not None else np.zeros((now.n, 3))
        return {"mean_spin": rows.mean(axis=0)}

    run = hl.molecular_dynamics(system, law=law, until=0.3, engine="steps", samples=60, observe=spin)
    late = run.series.mean_spin.values[21:].reshape(8, 5, 3).mean(axis=1)
    error = late.std(axis=0, ddof=1) / math.sqrt(8)
    assert (error < 8.0).all()
    assert (np.abs(late.mean(axis=0) - system.domain.mean_spin) < 5.0 * error).all()
