"""hl.fidelity: rules against Newton's equations from the same initial states, with correct error bars."""

import math
import os
import re
import shlex
import signal
import subprocess
import sys
import textwrap
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, law_of, slow, wait_until
from hardlimit.fidelity_study import contacts, observables, replica, report, statistics, typical_speed
from hardlimit.fidelity_study.prediction import Prediction
from hardlimit.fidelity_study.starts import Starts, equilibrated
from hardlimit.fidelity_study.store import Store
from hardlimit.measure.pairs import near as pairs_near
from hardlimit.support.estimate import Estimate
from hardlimit.support.formatting import percent_with_error

LAW = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
RULES = ("constant", "law", "tc", "soft")


def gas(
    seed: int = 0, n: int = 60, phi: float = 0.2, dimension: int = 3, **more: object
) -> hl.ParticleSystem:
    return hl.ParticleSystem.random(n, phi, 1e-3, 2500.0, 1.0, seed=seed, dimension=dimension, **more)


def compare(system: object = None, law: hl.Law = LAW, until: float = 2e-3, **more: object) -> hl.Fidelity:
    arguments = {"samples": 10} | more
    return hl.fidelity(gas() if system is None else system, law=law, until=until, **arguments)


def same(left: hl.Fidelity, other: hl.Fidelity) -> bool:
    return left.replicas.equals(other.replicas) and left.dataset.equals(other.dataset)


# --- observables --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_near_pairs_are_those_of_all_pairs(seed: int) -> None:
    """Boxes of any shape and boundary, particles of any size, unfolded positions outside the box."""
    rng = np.random.default_rng(seed)
    d = 2 + seed % 2
    radius = rng.uniform(0.3, 1.0, n := int(rng.integers(1, 150)))
    box = rng.uniform(4.3, 25.0, d)
    sides = rng.choice(["periodic", "wall"], d).tolist()
    system = hl.ParticleSystem._of(
        positions=rng.uniform(0.0, 1.0, (n, d)) * box, velocities=np.zeros((n, d)), radius=radius, mass=radius,
        box=box, boundary=tuple(sides), gravity=np.zeros(d), walls={}, thermostat=None,
        shear_rate=0.0, shear_displacement=0.0,
    )  # fmt: skip
    periodic = np.array([side == "periodic" for side in sides])
    apart = system.positions[:, None] - system.positions[None]
    apart -= np.where(periodic, box * np.round(apart / box), 0.0)
    near = np.linalg.norm(apart, axis=2) < observables.NEAR * (radius[:, None] + radius[None])
    unfolded = system.positions + np.where(periodic, box * rng.integers(-3, 4, (n, d)), 0.0)
    pairs = np.sort(
        np.transpose(pairs_near(system, np.where(periodic, unfolded % box, unfolded), observables.NEAR))
    )
    assert sorted(map(tuple, pairs)) == sorted(zip(*np.nonzero(np.triu(near, 1)), strict=True))
    expected = sum(
        (math.pi if d == 2 else 4.0 / 3.0 * math.pi) * (1.1**d - 1.0) * (radius[i] + radius[j]) ** d / np.prod(box)
        for i in range(n) for j in range(i)
    )  # fmt: skip
    if n > 1:
        g = observables.Observer(system).pair_correlation(unfolded)
        assert g * expected == pytest.approx(np.count_nonzero(np.triu(near, 1)), rel=1e-9)


def test_independent_places_have_no_structure() -> None:
    rng = np.random.default_rng(1)
    system = gas(n=4000, phi=0.01)
    observer = observables.Observer(system)
    seen = [
        (observer.pair_correlation(places), observer.density_variance(places))
        for places in (rng.uniform(0.0, 1.0, (4000, 3)) * system.box for _ in range(20))
    ]
    overlaps_too = 1.1**3 / (1.1**3 - 1.0)
    assert np.mean(seen, axis=0) == pytest.approx([overlaps_too, 1.0], rel=0.05)
    clustered = rng.uniform(0.0, 0.5, (4000, 3)) * system.box
    assert observer.density_variance(clustered) > 10.0


def test_divergence_is_in_radii() -> None:
    system = gas(n=30)
    observer = observables.Observer(system)
    assert observer.divergence(system.positions, system.positions) == 0.0
    moved = system.positions + np.array([3e-3, 0.0, 4e-3])
    assert observer.divergence(moved, system.positions) == pytest.approx(5.0)


# --- single contacts ----------------------------------------------------------------------------------------


@draws(30)
@given(st.integers(0, 40), st.integers(1, 6), st.integers(0, 1000))
def test_neighbours_are_the_last_and_the_next_collisions(n: int, particles: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    first = rng.integers(0, particles, n)
    second = rng.integers(-2, particles, n)
    second = np.where(second == first, -1, second)
    before, after = contacts.neighbours(np.arange(n, dtype=float), first, second)
    for i in range(n):
        for side, who in enumerate((first[i], second[i])):
            met = [j for j in range(n) if who >= 0 and who in (first[j], second[j])]
            assert before[i, side] == max((j for j in met if j < i), default=-1)
            assert after[i, side] == min((j for j in met if j > i), default=-1)


@pytest.mark.parametrize("walls", [False, True])
def test_what_tc_made_elastic_is_found_in_the_log(walls: bool) -> None:
    system = gas(n=80, phi=0.4, boundary="wall" if walls else "periodic")
    run = hl.event_driven(
        system, restitution=0.7, rule="tc", contact_duration=2e-5, max_collisions=2000, log=True
    )
    of_run = contacts.of_hard_spheres(system, LAW, run)
    assert np.count_nonzero(of_run.restitution == 1.0) == run.n_elastic_by_tc > 20


def test_restitution_and_overlap_of_contacts() -> None:
    """Newton's contacts are compared with the log; in a dilute gas their restitution is the law's, and hard spheres
    foresee which of them overlap."""
    system = gas(n=100, phi=0.3)
    law = hl.LinearDashpot(stiffness=2e5, restitution=0.8)
    run = hl.molecular_dynamics(system, law=law, until=2e-3, log=True)
    of_run = contacts.of_newton(run)
    ended = run.contacts.where(np.isfinite(run.contacts.end), drop=True)
    assert len(of_run.restitution) == ended.sizes["contact"] == run.n_ended
    assert of_run.overlapped_share == pytest.approx(run.overlapped_share)
    alone = of_run.restitution[~of_run.overlapped]
    assert np.median(alone) == pytest.approx(0.8, abs=1e-3) and 0.02 < of_run.overlapped_share < 0.5
    assert of_run.histogram.sum() == pytest.approx(1.0)
    foreseen = contacts.of_hard_spheres(system, law, hl.event_driven(system, law=law, until=2e-3, log=True))
    assert foreseen.overlapped_share == pytest.approx(of_run.overlapped_share, rel=0.3)


def test_without_contacts_there_are_no_shares() -> None:
    none = contacts.Contacts(np.empty(0), np.empty(0, bool))
    assert all(map(math.isnan, (none.median, none.overlapped_share, *none.histogram)))


# --- statistics ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 5, 8, 9, 30, 31, 200, 999])
def test_the_bars_are_students(freedom: int) -> None:
    assert statistics.student(freedom) == pytest.approx(
        scipy.stats.t.ppf(1.0 - 0.5 * statistics.LEVEL, freedom), rel=1e-9
    )


def test_bars_hold_as_often_as_they_say() -> None:
    """Pairs that share most of their noise: the difference is known better than either, and one in a hundred of
    differences of nothing is outside."""
    rng = np.random.default_rng(3)
    common = rng.normal(5.0, 0.5, (6, 20_000))
    values, reference = (common + rng.normal(0.0, 0.05, common.shape) for _ in range(2))
    difference = statistics.relative_difference(values, reference)
    assert difference.error.mean() == pytest.approx(0.05 * math.sqrt(2.0) / 5.0 / math.sqrt(6.0), rel=0.06)
    assert np.mean(statistics.significant(difference, 6)) == pytest.approx(statistics.LEVEL, rel=0.25)
    shifted = statistics.relative_difference(values * 1.1, reference)
    assert shifted.value.mean() == pytest.approx(0.1, abs=1e-3)
    assert statistics.significant(shifted, 6).mean() > 0.9


def test_a_departure_is_large_or_lasts() -> None:
    """In units of standard errors, of 8 replicas: 4.03 are the bars of what lasts, 5.6 and more those of one among
    three or more samples."""

    def departure(*values: float, replicas: int = 8) -> int | None:
        difference = statistics.with_interval(0.1 * np.array(values), np.full(len(values), 0.1), replicas)
        return statistics.departure(difference, replicas)

    assert departure(0.0, 4.5, 0.0, 4.5, 4.5) == 3
    assert departure(0.0, 4.5, 4.5, 0.0) is None and departure(0.0, 9.0, 0.0) == 1
    assert departure(0.0, 0.0, 4.5) == 2 and departure(0.0, 0.0, 3.9) is None
    assert departure(*[0.0] * 50, 6.5, 0.0) is None and departure(0.0, 6.5, 0.0) == 1  # of many, of few
    assert departure(9.0, 9.0) == 0 and departure(9.0, 9.0, replicas=1) is None
    assert departure(math.nan, 0.0, 4.5, 4.5, math.nan) == 2  # an early end
    assert departure(math.nan, math.nan) is None and departure() is None
    rounding = statistics.with_interval(np.array([1e-12, 1e-12]), np.zeros(2), 8)
    assert statistics.departure(rounding, 8) is None


#: Noise of one replica over the samples; its correlation time sets the number of independent tests.
NOISES = {
    "of one sample": lambda e: e,
    "of ten samples": lambda e: scipy.signal.lfilter([math.sqrt(1.0 - 0.9**2)], [1.0, -0.9], e),
    "that adds up": lambda e: e.cumsum(axis=-1) / math.sqrt(e.shape[-1]),
    "of means since the start": lambda e: e.cumsum(axis=-1) / np.arange(1, e.shape[-1] + 1) ** 0.5,
}


def noisy(
    rng: np.random.Generator, noise: str, replicas: int, departure: float = 0.0, stays: bool = True
) -> Estimate:
    """Difference of two models over 100 samples: paired starts, noise, and a departure after the 40th sample."""
    start = rng.normal(5.0, 0.5, (replicas, 1))
    true, rule = start + 0.05 * NOISES[noise](rng.normal(size=(2, replicas, 100)))
    later = np.clip((np.arange(100) - 40) / 10.0, 0.0, 1.0)
    if not stays:
        later *= np.arange(100) < 80
    return statistics.relative_difference(rule * (1.0 + departure * later), true)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("replicas", [2, *map(slow, (3, 8, 30))])
def test_nothing_departs_from_nothing_as_often_as_the_docstring_says(noise: str, replicas: int) -> None:
    """At most 1 % for any number of samples; in 1500 comparisons 1.8 % or less with a probability of 699/700."""
    rng = np.random.default_rng(replicas)
    departures = [statistics.departure(noisy(rng, noise, replicas), replicas) for _ in range(1500)]
    assert sum(at is not None for at in departures) <= 27


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("replicas", [4, 8, 30])
@pytest.mark.parametrize("stays", [True, False])
def test_what_departs_is_found(noise: str, replicas: int, stays: bool) -> None:
    """Twenty standard errors that stay, or many more that go again: found in almost all cases, and hardly ever before
    they are there."""
    rng = np.random.default_rng(replicas)
    errors = 20.0 if stays else 100.0
    size = errors * 0.05 * math.sqrt(2.0) / 5.0 / math.sqrt(replicas)
    departures = [
        statistics.departure(noisy(rng, noise, replicas, size, stays), replicas) for _ in range(200)
    ]
    at = np.array([x for x in departures if x is not None])
    assert len(at) >= 190 and np.mean(at <= 40) <= 0.04
    assert np.median(at) <= 60


@pytest.mark.parametrize("replicas", [2, 3, 8, 100])
@pytest.mark.parametrize("error", [1e-6, 1e-3, 0.3])
@pytest.mark.parametrize("resolution", [1e-3, 0.01, 1.0])
def test_so_many_replicas_resolve(replicas: int, error: float, resolution: float) -> None:
    """The smallest number whose bars, by 1/√N and Student's quantile, are short enough."""
    needed = statistics.replicas_needed(error, replicas, resolution)

    def bar(n: float) -> float:
        return scipy.stats.t.ppf(0.995, n - 1) * error * math.sqrt(replicas / n)

    assert bar(needed) <= resolution * 1.003 or math.isinf(needed)
    assert needed == 2 or bar(needed - 1 if math.isfinite(needed) else 1e6) > resolution * 0.997
    assert math.isnan(statistics.replicas_needed(math.nan, 1, resolution))


# --- what must come out -------------------------------------------------------------------------------------


def test_velocity_independent_laws_make_constant_and_law_the_same() -> None:
    """Except for rounding errors, which have not yet grown after a few collisions."""
    f = compare(models=("newton", "constant", "law"), until=1e-3)
    ds = f.replicas
    for name in replica.QUANTITIES:
        constant, other = ds[name].sel(model="constant"), ds[name].sel(model="law")
        np.testing.assert_allclose(constant, other, rtol=1e-9)
    assert ds.n_contacts.sel(model="law").item() > 20


def test_the_values_are_those_of_the_runs() -> None:
    system = gas(boundary="wall")
    f = compare(system)
    runs = {"newton": hl.molecular_dynamics(system, law=LAW, until=2e-3, samples=10, log=True)}
    options = {"constant": {"restitution": 0.9}, "law": {"law": LAW}, "soft": {"law": LAW, "rule": "soft"}}
    options["tc"] = {"restitution": 0.9, "rule": "tc", "contact_duration": f.contact_duration}
    runs |= {name: hl.event_driven(system, until=2e-3, samples=10, **rule) for name, rule in options.items()}
    for name, run in runs.items():
        values = f.replicas.sel(model=name, replica=0)
        assert values.granular_temperature.values.tolist() == run.series.granular_temperature.values.tolist()
        assert values.dissipation_rate[-1] == pytest.approx(run.series.dissipated_energy[-1] / 2e-3)
        assert values.collision_rate[-1] == pytest.approx(run.series.collision_rate[1:].mean())
        assert values.pressure[-1] == pytest.approx(run.series.pressure[1:].mean())
        left = system.kinetic_energy - run.series.dissipated_energy[-1]
        assert values.cooling[-1] == pytest.approx(math.sqrt(system.kinetic_energy / left) - 1.0)
        assert values.end_time == run.time and values.outcome == 0
    assert f.replicas.divergence.sel(model="newton").max() == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_hard_particles_agree_with_newton_in_every_rule(dimension: int) -> None:
    """t_c ν → 0: differences are within the bars plus the share of time in contact."""
    law = hl.LinearDashpot(stiffness=1e11, restitution=0.8)
    f = compare(partial(gas, n=40, dimension=dimension), law, replicas=5)
    assert f.tc_nu < 1e-4
    for rule in RULES:
        for name in replica.QUANTITIES:
            difference = f.final_difference(name, rule)
            bars = statistics.student(4) * difference.error
            assert math.isnan(difference.value) or abs(difference.value) <= bars + 10.0 * f.tc_nu, (
                rule,
                name,
                difference,
            )


def test_soft_follows_newton_where_contacts_are_alone() -> None:
    f = compare(gas(phi=0.02), hl.LinearDashpot(stiffness=1e6, restitution=0.9), until=3e-3)
    assert f.replicas.overlapped_share.sel(model="newton").item() == 0.0
    last = f.replicas.divergence.isel(time=-1, replica=0)
    assert last.sel(model="soft") < 1e-6 < 1e-3 < last.sel(model="law")


def test_bars_and_impacts_of_the_defaults() -> None:
    system = gas()
    law = hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=1e-4)
    ball = hl.Ball(1e-3, density=2500.0)
    f = compare(system, law, models=("newton", "constant", "tc"))
    speed = math.sqrt(math.pi * system.granular_temperature)
    assert typical_speed(system) == speed
    assert f.plan.restitution == pytest.approx(law.between(ball, ball).restitution(speed))
    assert f.contact_duration == pytest.approx(law.between(ball, ball).duration(speed))
    g = compare(system, law, models=("newton", "tc"), restitution=0.5, contact_duration=1e-4)
    assert (g.plan.restitution, g.contact_duration) == (0.5, 1e-4)
    assert (
        compare(law=hl.LinearDashpot(stiffness=1e6, restitution=0.123), until=0.0).plan.restitution == 0.123
    )


def test_typical_speeds_without_heat() -> None:
    rest = gas().replace(velocities=np.zeros((60, 3)))
    assert typical_speed(rest) == 1.0
    falling = rest.replace(gravity=9.81)
    assert typical_speed(falling) == pytest.approx(math.sqrt(2.0 * 9.81 * rest.box[2]))


# --- the sentence -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_the_sentence_says_what_the_dataset_holds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    law = hl.LinearDashpot(
        stiffness=10.0 ** rng.uniform(4.0, 7.0), restitution=float(rng.choice([1.0, rng.uniform(0.3, 0.99)]))
    )
    chosen = ("newton", *rng.permutation(RULES)[: rng.integers(1, 5)])
    f = compare(
        partial(gas, n=30, phi=rng.uniform(0.05, 0.4), dimension=int(rng.integers(2, 4))),
        law, until=1.5e-3, models=chosen, replicas=int(rng.integers(2, 6)),
    )  # fmt: skip
    said, ds = str(f), f.dataset
    measure = "collision_rate" if law.restitution == 1.0 else "cooling"
    assert said.startswith(f"At t_c ν = {ds.attrs['tc_nu']:.2g} ") and f" {f.n_replicas} replicas" in said
    for rule in chosen[1:]:
        value, error = ds.difference.sel(quantity=measure, model=rule).isel(time=-1).values
        raw = f.replicas[measure].isel(time=-1)
        true = raw.sel(model="newton").values
        assert value == pytest.approx(raw.sel(model=rule).values.mean() / true.mean() - 1.0, abs=1e-12)
        apart = abs(value) > max(scipy.stats.t.ppf(0.995, f.n_replicas - 1) * error, statistics.SMALLEST)
        if apart:
            ends = {"cooling": ("too fast", "too slowly"), "collision_rate": ("too often", "too rarely")}[
                measure
            ]
            size = percent_with_error(abs(value), error)
            verb = "cools" if measure == "cooling" else "collides"
            clause = f"{size} {ends[0] if value > 0 else ends[1]}"
            assert f" {rule} {clause}" in said or f" the rule {rule} {verb} {clause}" in said
        elif scipy.stats.t.ppf(0.995, f.n_replicas - 1) * error <= f.resolution:
            assert f"{rule} ({percent_with_error(value, error)})" in said
            assert "not significantly different from Newton’s equations in" in said
        else:
            assert re.search(rf"the rules? [^;%]*\b{rule}\b[^;%]* (is|are) not resolved by", said)
            assert f"{rule} (" not in said


@pytest.mark.parametrize("resolution", [1e-3, 0.01, 0.1, 1.0])
def test_what_is_not_resolved_is_no_agreement(resolution: float) -> None:
    """Replicas with few contacts: the sentence gives the long bars and the number of replicas needed."""
    soft = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    f = compare(partial(gas, n=30), soft, models=("newton", "law"), replicas=3, resolution=resolution)
    error = f.final_difference("cooling", "law").error
    bar = scipy.stats.t.ppf(0.995, 2) * error
    needed = f.dataset.replicas_needed.sel(quantity="cooling", model="law").item()
    assert report.half_width(f.final_difference("cooling", "law")) == pytest.approx(bar)
    assert (needed <= 3) is bool(bar <= resolution) and f.dataset.attrs["resolution"] == resolution
    if f.is_significant("cooling", "law") or bar <= resolution:
        assert "not resolved" not in str(f)
        return
    said = re.search(r"not resolved by cooling: ± ([\d.]+) % with 3 replicas .99 % confidence.; for ± ([\d.]+) % "
                     r"about (\d+) replicas would be needed\.$", str(f))  # fmt: skip
    assert float(said[1]) == pytest.approx(100.0 * bar, rel=0.06) and float(said[2]) == 100.0 * resolution
    assert needed <= float(said[3]) <= 1.11 * needed
    assert "not significantly different" not in str(f)


def test_a_rule_that_ended_before_the_first_sample_has_no_number() -> None:
    """A dense packing with strong damping collapses at once."""
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.1)
    f = compare(partial(gas, n=40, phi=0.7, dimension=2), law, models=("newton", "constant"), replicas=2,
                until=2e-2, samples=1)  # fmt: skip
    assert f.outcomes("constant") == ["collapse"] * 2 and f.last_common("constant") == 0
    assert str(f) == (
        "No verdict: no rule reached a sample. The rule constant ended with inelastic collapse in 2 of 2 replicas; "
        "it ended before the first sample."
    )
    for name in replica.QUANTITIES:
        assert math.isnan(f.final_difference(name, "constant").value)
        assert math.isnan(f.replicas_needed(name, "constant")) and not f.is_significant(name, "constant")
    _, rows = report.table(f)
    assert [row[1] for row in rows] == ["–"] * len(rows)
    both = compare(partial(gas, n=40, phi=0.7, dimension=2), law, models=("newton", "constant", "tc"), replicas=2,
                   until=2e-2, samples=1)  # fmt: skip
    assert "constant (" not in str(both) and "tc" in str(both)
    assert str(both).endswith("it ended before the first sample.")


# --- extremes -----------------------------------------------------------------------------------------------


def test_one_replica_gives_no_verdict() -> None:
    f = compare()
    assert "one replica has no error bars" in str(f) and "%" not in str(f)
    assert f.dataset.difference.sel(statistic="standard_error").isnull().all()
    assert f.dataset.departure_time.isnull().all()


def test_one_model_no_time_and_no_contact() -> None:
    alone = compare(models=("newton",), replicas=2)
    assert "no rule to compare with" in str(alone) and alone.dataset.sizes["model"] == 1
    at_once = compare(until=0.0, replicas=2)
    assert "no contact" in str(at_once) and at_once.dataset.time.values.tolist() == [0.0]
    assert math.isnan(at_once.tc_nu)
    free = compare(partial(gas, n=2, phi=1e-6), replicas=2, until=1e-6)
    assert "no contact" in str(free) and free.dataset.departure_time.isnull().all()


def test_elastic_particles_are_judged_by_their_rate() -> None:
    f = compare(law=LAW.replace(restitution=1.0), replicas=3)
    assert "collision rate" in str(f) or "collides" in str(f)
    assert np.nanmax(abs(f.dataset.cooling.sel(statistic="mean"))) == 0.0
    lost = f.dataset.difference.sel(quantity=["cooling", "dissipation_rate"])
    assert lost.isnull().all()  # nothing is lost but by rounding, and that has no ratio


def heap(seed: int) -> hl.ParticleSystem:
    sides = ["periodic", "wall"]
    return gas(seed, n=20, phi=0.3, dimension=2, boundary=sides, gravity=50.0)


def test_a_collapse_is_an_outcome() -> None:
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.1)
    dense = partial(gas, n=40, phi=0.7, dimension=2)
    f = compare(dense, law, models=("newton", "constant", "tc"), replicas=2, until=2e-4, samples=20)
    assert "collapse" in f.outcomes("constant")
    assert "The rule constant ended with inelastic collapse in" in str(f) and "tc" in str(f)
    ended = f.replicas.sel(model="constant")
    for k in range(2):
        gone = ended.granular_temperature.isel(replica=k)
        assert (gone.isnull() == (gone.time > ended.end_time.isel(replica=k))).all()


def test_polydisperse_particles_between_walls() -> None:
    system = hl.ParticleSystem.random(40, 0.2, (0.5e-3, 1.5e-3), 2500.0, 1.0, boundary="wall")
    f = compare(system, replicas=2)
    assert np.isfinite(f.dataset.difference.isel(time=-1)).all()
    other = equilibrated(system, 7)
    assert other.granular_temperature == pytest.approx(system.granular_temperature, rel=1e-12)
    assert other.momentum == pytest.approx(system.momentum, abs=1e-12 * np.abs(system.momentum).max())
    assert abs(other.positions - system.positions).max() > 1e-3


# --- replicas -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_a_few_particles_between_walls(n: int, dimension: int) -> None:
    """Walls have numbers down to −6, which are no indices of so few particles."""
    system = gas(n=n, phi=0.1, dimension=dimension, boundary="wall")
    f = compare(system, until=0.01, replicas=1 + (n > 1), samples=2)
    assert f.arrays[0]["n_contacts"].min() > 0.0 and "t_c ν = " in str(f)
    for first, second in (([0], [-2 * dimension]), ([0, 0], [-1, n - 1])):
        durations = contacts.durations(system, LAW, np.array(first), np.array(second), np.ones(len(first)))
        ball = hl.Ball(1e-3, mass=float(system.mass[0]))
        assert durations[0] == pytest.approx(LAW.between(ball, hl.FLOOR).duration(), rel=1e-9)


def test_a_single_particle_strikes_with_its_speed() -> None:
    single = gas(n=1, phi=0.1, dimension=2, boundary="wall").replace(velocities=[[0.3, 0.4]])
    assert typical_speed(single) == pytest.approx(0.5)


@pytest.mark.parametrize("n", [2, 3, 8])
def test_rare_third_particles_contradict_nothing(n: int) -> None:
    """In short runs of few particles no third one touches a pair: the rule soft is exact to rounding."""
    start = gas(n=n, dimension=2)
    for seed in range(3):
        f = hl.fidelity(start, law=LAW, until=5e-3, replicas=4, samples=4, seed=10 * seed)
        assert "contradicts" not in str(f)
    assert (f.predicted("soft").reason != "") == (n < 4)


OTHER_BOXES = {
    "dimension 2": {"dimension": 2},
    "wall, wall, wall": {"boundary": "wall"},
    "gravity [0.0, 0.0, -9.8]": {"gravity": [0.0, 0.0, -9.8]},
    "RandomKicks": {"thermostat": hl.RandomKicks(1e-3, 1e-4)},
    "shear rate 20": {"boundary": ["periodic", "lees-edwards", "periodic"], "shear_rate": 20.0},
}


@pytest.mark.parametrize("what", OTHER_BOXES)
def test_replicas_share_their_box(what: str) -> None:
    def start(seed: int) -> hl.ParticleSystem:
        return gas(seed, **(OTHER_BOXES[what] if seed else {}))

    with pytest.raises(ValueError, match=r"^system: got a box of .* for replica 1, must be a box") as refused:
        compare(start, until=1e-5, replicas=2)
    assert what in str(refused.value).partition(" from the function")[0]


@pytest.mark.slow
def test_any_number_of_workers_gives_the_same() -> None:
    system = gas(n=30)
    here = compare(system, replicas=3)
    told: list[tuple[int, int]] = []
    there = compare(system, replicas=3, workers=2, progress=lambda done, total: told.append((done, total)))
    assert same(here, there)
    steps = 3 * 5 * 11
    assert told[-1] == (steps, steps) and all(total == steps for _, total in told)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


@pytest.mark.slow
def test_a_cluster_gives_the_same() -> None:
    pytest.importorskip("distributed")
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as local,
        Client(local, set_as_default=False) as client,
    ):
        assert same(compare(replicas=2, scheduler=client), compare(replicas=2))


@pytest.mark.slow
def test_a_store_keeps_what_is_finished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C in the third replica: the first two are kept and not computed again."""
    store = tmp_path / "replicas"
    started: list[int] = []

    def interrupt(done: int, total: int) -> None:
        if done > 2.5 * total / 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compare(replicas=4, store=store, progress=interrupt)
    whole = compare(replicas=4)
    real = Starts.start
    monkeypatch.setattr(
        Starts, "start", lambda self, k, report: (started.append(k), real(self, k, report))[1]
    )
    assert same(compare(replicas=4, store=store), whole)
    assert started == [0, 2, 3]  # the first one to know what the store must hold
    started.clear()
    assert same(compare(replicas=2, store=store), compare(replicas=2))
    more = compare(replicas=5, store=store)
    assert more.n_replicas == 5 and same(more, compare(replicas=5))


def test_two_writers_of_a_store_lose_nothing(tmp_path: Path) -> None:
    """Each has opened the store before the other one wrote."""
    path, facts = tmp_path / "replicas", {"until": 1.0}
    store, other = Store(path, facts), Store(path, facts)
    store.add(0, {"x": np.array([1.0])})
    other.add(1, {"x": np.array([2.0])})
    store.add(2, {"x": np.array([3.0])})
    replicas = Store(path, facts).replicas
    assert {k: arrays["x"].tolist() for k, arrays in replicas.items()} == {0: [1.0], 1: [2.0], 2: [3.0]}


SCRIPT = """
import hardlimit as hl

if __name__ == "__main__":
    system = hl.ParticleSystem.random(60, 0.2, 1e-3, 2500.0, 1.0)
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    hl.fidelity(system, law=law, until=2e-2, samples=10, replicas=12, workers=2, store={store!r})
"""


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_process_that_ends_leaves_its_replicas_and_no_workers(tmp_path: Path, how: signal.Signals) -> None:
    store = tmp_path / "replicas"
    script = tmp_path / "script.py"
    script.write_text(textwrap.dedent(SCRIPT.format(store=str(store))))
    process = subprocess.Popen(
        [sys.executable, str(script)], stderr=subprocess.PIPE, text=True, start_new_session=True
    )

    def known() -> int:
        return len(Store(store, {}).replicas) if store.exists() else 0

    wait_until(lambda: known() > 0 or process.poll() is not None)
    os.killpg(process.pid, how) if how is signal.SIGINT else process.kill()
    complaint = process.communicate()[1]
    assert complaint.count("Traceback") <= 1, complaint
    wait_until(lambda: not group_lives(process.pid))
    assert 0 < known() <= 12
    law, until = hl.LinearDashpot(stiffness=1e6, restitution=0.9), 2e-2
    arguments = {"law": law, "until": until, "samples": 10, "replicas": known()}
    resumed = hl.fidelity(gas(), store=store, **arguments) if set(Store(store, {}).replicas) >= {0} else None
    assert resumed is None or same(resumed, hl.fidelity(gas(), **arguments))


@pytest.mark.slow
def test_the_end_of_a_job_leaves_replicas_and_no_workers(tmp_path: Path) -> None:
    """A scheduler sends SIGTERM to all processes: the workers leave it to their parent, which prints one line."""
    store = tmp_path / "replicas"
    options = shlex.split("--n 60 --packing-fraction 0.2 --until 20ms --samples 10 --replicas 12 --workers 2")
    command = [sys.executable, "-m", "hardlimit", "gas", "compare", *options, "--store", str(store)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_until(lambda: (store.exists() and Store(store, {}).replicas) or process.poll() is not None)
    os.killpg(process.pid, signal.SIGTERM)
    complaint = process.communicate()[1].strip()
    assert "Traceback" not in complaint
    assert complaint.splitlines()[-1] == (
        f"interrupted by SIGTERM (replicas that are finished are in {store}; the same command goes on)"
    )
    assert process.returncode == 143
    wait_until(lambda: not group_lives(process.pid))


HASTE = """
import os
import re
import signal
import hardlimit as hl

if __name__ == "__mp_main__":  # of a worker, before its pool has told it anything
    os.kill(os.getpid(), signal.SIGINT)
if __name__ == "__main__":
    system = hl.ParticleSystem.random(20, 0.2, 1e-3, 2500.0, 1.0)
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    print(hl.fidelity(system, law=law, until=1e-4, samples=2, replicas=2, workers=2).n_replicas)
"""


@pytest.mark.slow
def test_workers_that_still_start_do_not_hear_an_interrupt(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(HASTE)
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert (run.returncode, run.stdout.strip(), run.stderr) == (0, "2", "")


def group_lives(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


# --- refusals -----------------------------------------------------------------------------------------------

REFUSED = {
    "system: got 3, must be": {"system": 3},
    "law: got None": {"law": None},
    "until: got -1": {"until": -1.0},
    "replicas: got 0": {"replicas": 0},
    "samples: got 0": {"samples": 0},
    "workers: got 0": {"workers": 0},
    "seed: got -1": {"seed": -1},
    "models: got 'newton'": {"models": "newton"},
    "models: got none": {"models": ()},
    "models: got constant, must include newton": {"models": ("constant",)},
    "models: got newton, newton": {"models": ("newton", "newton")},
    "models[1]: got 'sft'": {"models": ("newton", "sft")},
    "restitution: got 1.5": {"restitution": 1.5},
    "contact_duration: got -1": {"contact_duration": -1.0},
    "resolution: got 0": {"resolution": 0.0},
    "resolution: got 1.5": {"resolution": 1.5},
    "resolution: got nan": {"resolution": math.nan},
    "store: got": {"store": "/nowhere/at/all"},
    "scheduler | workers": {"scheduler": "tcp://127.0.0.1:1", "workers": 2},
    "progress: got 3": {"progress": 3},
    "system | replicas: got a system under gravity": {"system": heap(0), "replicas": 2},
    "system | replicas: got a system without relative motion": {
        "system": gas().replace(velocities=np.zeros((60, 3))), "replicas": 2,
    },
    "system: got 1 from the function": {"system": lambda seed: seed + 1},
    "system: got <function": {"system": lambda seed: gas(seed), "replicas": 2, "workers": 2},
    "system: got the same start for replicas 0 and 1": {"system": lambda seed: gas(3), "replicas": 2},
    "box: got": {
        "system": hl.ParticleSystem([[0, 0], [2e-3, 2e-3]], np.zeros((2, 2)), 1e-3, 1.0, box=4.1e-3),
        "engine": "events",
    },
}  # fmt: skip


@pytest.mark.parametrize("message", REFUSED)
def test_bad_input_is_refused_in_one_line(message: str) -> None:
    given_arguments = {"system": gas(), "law": LAW, "until": 1e-5, "samples": 2} | REFUSED[message]
    with pytest.raises(ValueError) as refused:
        hl.fidelity(given_arguments.pop("system"), **given_arguments)
    assert str(refused.value).startswith(message) and "\n" not in str(refused.value)


OTHERS = {
    "until": {"until": 1e-4},
    "samples": {"samples": 4},
    "law": {"law": LAW.replace(stiffness=2e6)},
    "models": {"models": ("newton", "soft")},
    "restitution": {"restitution": 0.5},
    "contact_duration": {"contact_duration": 1e-9},
    "seed": {"seed": 1},
    "another start": {"system": gas(5)},
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_store_of_other_arguments_is_refused(what: str, tmp_path: Path) -> None:
    store = tmp_path / "replicas"
    arguments = {"system": gas(), "law": LAW, "until": 1e-5, "samples": 2, "store": store}
    hl.fidelity(**arguments)
    with pytest.raises(ValueError, match=rf"store: .* was made with {what}\b.*repeat that call") as refused:
        hl.fidelity(**(arguments | OTHERS[what]))
    assert "\n" not in str(refused.value)


def test_files_that_are_no_stores(tmp_path: Path) -> None:
    other = tmp_path / "other"
    hl.event_driven(gas(), restitution=0.9, until=1e-5, checkpoint=other)
    with pytest.raises(ValueError, match=r"store: .* is the checkpoint of a run"):
        compare(store=other)
    other.write_bytes(b"nothing")
    with pytest.raises(ValueError, match=r"store: .* damaged"):
        compare(store=other)


# --- files --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_everything_is_saved_with_units(tmp_path: Path) -> None:
    import xarray as xr

    f = compare(replicas=2)
    path = f.save(tmp_path / "f.nc")
    with xr.open_dataset(path) as means, xr.open_dataset(path, group="replicas") as replicas:
        assert means.equals(f.dataset) and replicas.equals(f.replicas)
        assert means.attrs["summary"] == str(f)
    for ds in (f.dataset, f.replicas):
        for name, variable in ds.data_vars.items():
            assert name == "outcome" or {"units", "long_name"} <= set(variable.attrs), name
    assert compare(gas(dimension=2), until=1e-5).replicas.pressure.attrs["units"] == "N/m"


# --- the law of the error -----------------------------------------------------------------------------------


def gas_beside_rules(n: int = 64, replicas: int = 4, **options: object) -> hl.Fidelity:
    start = hl.ParticleSystem.random(n, 0.3, 1e-3, 2500.0, 1.0)
    law = hl.LinearDashpot(stiffness=2e5, restitution=0.9)
    return hl.fidelity(start, law=law, until=2e-3, replicas=replicas, samples=4, **options)


def test_the_law_of_the_error_stands_beside_the_measurement() -> None:
    f = gas_beside_rules()
    head, rows = report.table(f)
    (row,) = (row for row in rows if row[0] == "cooling, law of the error")
    assert len(row) == len(head) and "The law of the error predicts" in str(f)
    for rule in f.models[1:]:
        prediction = f.predicted(rule)
        assert prediction.reason == "" and 0.0 < prediction.error < 0.02
        assert not prediction.contradicts(f.final_difference("cooling", rule))
        assert prediction.contradicts(
            f.final_difference("cooling", rule)._replace(value=9.0, lower=8.9, upper=9.1)
        )
    assert "contradicts" not in str(f)
    assert f.predicted("tc").value < 0.0 < f.predicted("constant").value


def test_a_prediction_that_is_wrong_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    f = gas_beside_rules(models=["newton", "constant"])
    monkeypatch.setattr(hl.Fidelity, "predicted", lambda *_: Prediction(9.0, 0.1))
    assert str(f).endswith("Warning: this contradicts the measured cooling of constant.")


def test_no_prediction_where_the_law_does_not_hold() -> None:
    assert "given" in gas_beside_rules(8, 1, restitution=0.7).predicted("constant").reason
    walls = hl.ParticleSystem.random(8, 0.1, 1e-3, 2500.0, 1.0, boundary="wall")
    law = hl.LinearDashpot(stiffness=2e5, restitution=0.9)
    assert "walls" in hl.fidelity(walls, law=law, until=1e-4, samples=1).predicted("law").reason


@pytest.mark.parametrize("name", ["linear", "viscoelastic"])
def test_the_ratio_of_compression_to_diameter(name: str) -> None:
    """δ/d of isolated contacts, from the largest compression of two spheres that collide head-on."""
    start = hl.ParticleSystem.random(8, 0.05, 1e-3, 2500.0, 1.0)
    law = law_of(name, 0.9)
    fidelity = hl.fidelity(start, law=law, until=1e-6, samples=1)
    ball = hl.Ball(1e-3, density=2500.0)
    speed = np.sqrt(np.pi * start.granular_temperature)
    assert fidelity.delta_over_d == pytest.approx(law.between(ball, ball).compression(speed) / 2e-3, rel=1e-3)


def test_particles_below_the_box_count_in_its_lowest_cells() -> None:
    """A wall that has moved out lets them leave the box by more than a cell."""
    system = hl.ParticleSystem.random(300, 0.1, 1e-3, 2500.0, 0.3, boundary=("periodic", "periodic", "wall"))
    low = system.positions.copy()
    low[:50, 2] -= system.box[2]
    lowest = low.copy()
    lowest[:, 2] = np.maximum(lowest[:, 2], 0.0)
    variance = observables.Observer(
        system.replace(walls={"z-": hl.MovingWall(velocity=-1.0)})
    ).density_variance
    assert variance(low) == variance(lowest)
