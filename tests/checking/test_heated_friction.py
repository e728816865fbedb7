"""``check`` on heated gases of grains that rub: temperature, T_r/T and their error, against theory and simulations."""

import math
import re
import subprocess

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, log_floats
from hardlimit.boxes import theory
from hardlimit.boxes.lammps import program
from hardlimit.boxes.theory import Heat
from hardlimit.checking import cases, drive
from hardlimit.checking.scripts import Bath, read_text
from hardlimit.fidelity_study.starts import equilibrated

try:
    PROGRAM = program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)

BEAD = hl.Ball(1e-3, density=2500.0)
VOLUME = 4.0 / 3.0 * math.pi * 1e-9


def dashpot(mu: float, rho: float = 1.0, e: float = 0.9, damping: float = 0.0) -> hl.Law:
    friction = hl.Friction(mu, stiffness_ratio=rho / 3.5, damping_ratio=damping) if mu else None
    return hl.LinearDashpot(stiffness=1e5, restitution=e, friction=friction)


def steady(
    driven: drive.Drive, law: hl.Law, phi: float, ball: hl.Ball = BEAD, d: int = 3
) -> drive.Steady | None:
    """As in a check."""
    return driven.steady(cases.of_law([ball], law, False, None)[0], d, phi)


def one(phi: float, d: int = 3) -> theory.Gas:
    volume = (math.pi * 1e-6 if d == 2 else VOLUME) / phi
    return theory.Gas(1, 1e-3, BEAD.mass, volume, d, 0.4)


# --- theory -------------------------------------------------------------------------------------------------------


@draws(10, few=1)
@given(
    log_floats(1e-3, 3.0), st.floats(0.3, 5.0), st.floats(0.3, 0.99), st.floats(0.0, 1.0), log_floats(1e-9, 1e-3),
    st.integers(2, 3),
)  # fmt: skip
def test_the_steady_state_is_that_of_the_exact_theory(mu, rho, e, damping, power, d):
    """Heat of the velocities: the temperature of ``hl.theory``, whose quadrature is another one."""
    law = dashpot(mu, rho, e, damping)
    state, exact = steady(drive.Drive(power), law, 0.2, d=d), one(0.2, d).rotating(law=law)
    assert state.temperature_ratio == pytest.approx(exact.heated_temperature_ratio(), rel=2e-3)
    assert state.speed == pytest.approx(math.sqrt(math.pi * exact.heated_temperature(power)), rel=2e-4)


@draws(60)
@given(
    log_floats(1e-3, 3.0), st.floats(0.3, 3.5), st.floats(0.5, 0.99), log_floats(1e-2, 1e2), log_floats(1e-1, 1e1),
    log_floats(1e-2, 1e4), st.integers(2, 3),
)  # fmt: skip
def test_heat_of_velocities_and_spins_is_what_collisions_take(mu, rho, e, hot, share, rate, d):
    """Both balances of a bath and of kicks, with the exact rates at the state that is found."""
    law, gas, t_b = dashpot(mu, rho, e), one(0.2, d), 1e-2 * hot
    exact, kicks = gas.rotating(law=law), (1e-6, share * 1e-6)
    bath = Bath(t_b, rate, share * t_b, 10.0 / 3.0 * rate)
    for driven in (drive.Drive(bath=bath), drive.Drive(kicks[0], spin_power=kicks[1])):
        state = steady(driven, law, 0.2)
        if d == 2:
            state = driven.steady(cases.of_law([BEAD], law, False, None)[0], 2, 0.2)
        t = state.speed**2 / math.pi
        nu, theta = float(gas.collision_rate(t)), state.temperature_ratio
        moving, turning = (nu * t * change for change in exact.rates(theta))
        if driven.bath is None:
            x, a2 = 1.0 - e * e, theory._heated_cumulant(e, d)
            moving -= 3.0 / 16.0 * a2 * x * nu * t / d
            heats = 2.0 * kicks[0] / (d * BEAD.mass), 2.0 * kicks[1] / ({2: 1, 3: 3}[d] * BEAD.mass)
        else:
            heats = rate * (t_b - t), bath.spin_rate * (share * t_b - theta * t)
        scale = abs(heats[0]) + abs(heats[1]) + nu * t * 1e-3
        assert heats[0] == pytest.approx(-moving, abs=3e-3 * scale)
        assert heats[1] == pytest.approx(-turning, abs=3e-3 * scale)


@pytest.mark.parametrize("d", [2, 3])
def test_friction_that_vanishes_leaves_the_smooth_gas(d):
    """Continuously, in a bath and under kicks, with and without heat of the spins."""
    bath = Bath(0.03, 20.0, 0.03, 60.0)
    drives = drive.Drive(1e-6), drive.Drive(bath=bath), drive.Drive(bath=bath._replace(spin_rate=0.0))
    for driven in drives:
        smooth = steady(driven, dashpot(0.0), 0.2, d=d)
        assert smooth.temperature_ratio is None
        off = [steady(driven, dashpot(mu), 0.2, d=d).speed / smooth.speed - 1.0 for mu in (1e-9, 1e-6, 1e-5)]
        assert off[0] == pytest.approx(0.0, abs=1e-8) and abs(off[1]) < 2e-5 and abs(off[2]) < 2e-4
        if not driven.heats_spins:
            assert off[2] == pytest.approx(10.0 * off[1], rel=0.05) and off[2] < 0.0


@draws(30)
@given(st.floats(0.5, 3.5), st.floats(0.5, 0.99), st.floats(0.0, 1.0), log_floats(1e-3, 1.0))
def test_friction_cools_a_gas_whose_velocities_are_heated(rho, e, damping, mu):
    """It only takes energy, and weak friction takes the more and turns grains the faster the stronger it is."""
    smooth = steady(drive.Drive(1e-6), dashpot(0.0, e=e), 0.2)
    weak, strong = (steady(drive.Drive(1e-6), dashpot(m, rho, e, damping), 0.2) for m in (mu, 1.5 * mu))
    assert max(weak.speed, strong.speed) < smooth.speed
    assert weak.temperature_ratio > 0.0
    assert mu > 0.05 or (strong.speed < weak.speed and strong.temperature_ratio > weak.temperature_ratio)


def test_spins_follow_their_heat():
    law = dashpot(0.5)
    values = [steady(drive.Drive(1e-6, spin_power=p), law, 0.2) for p in (0.0, 1e-7, 1e-6, 1e-5)]
    ratios = [state.temperature_ratio for state in values]
    assert ratios == sorted(ratios) and ratios[0] == pytest.approx(0.5268, abs=1e-3) and ratios[-1] > 1.5
    speeds = [state.speed for state in values]
    assert speeds == sorted(speeds)
    # A strong bath has both temperatures; without its hold on spins they have θ of kicks.
    strong = steady(drive.Drive(bath=Bath(0.03, 1e7, 0.06, 1e7)), law, 0.2)
    assert strong.temperature_ratio == pytest.approx(2.0, rel=1e-3)
    assert strong.speed == pytest.approx(math.sqrt(math.pi * 0.03), rel=1e-3)
    free = steady(drive.Drive(bath=Bath(0.03, 1e7)), law, 0.2)
    assert free.temperature_ratio == pytest.approx(ratios[0], rel=1e-6)
    assert theory.RotatingGas.heated_state(one(0.2).rotating(law=law), Heat()) is None


@draws(60)
@given(
    log_floats(1e-12, 1e6), log_floats(1e-6, 1e3), st.floats(0.01, 1.0), log_floats(1e-9, 1e3), st.floats(1e-3, 0.6),
    st.sampled_from(["power", "kicks", "bath", "cold"]), st.integers(2, 3), log_floats(1e-30, 1e30),
)  # fmt: skip
def test_extremes_have_an_answer(mu, rho, e, damping, phi, kind, d, power):
    law = dashpot(mu, rho, e, damping)
    driven = {
        "power": drive.Drive(power),
        "kicks": drive.Drive(0.0, spin_power=power),
        "bath": drive.Drive(bath=Bath(power, 1.0 / power, 1.0, power)),
        "cold": drive.Drive(bath=Bath(0.0, power, 1.0, 1.0)),
    }[kind]
    state = steady(driven, law, phi, d=d)
    if state is not None:
        assert 0.0 < state.speed < math.inf
        assert state.temperature_ratio is None or 0.0 <= state.temperature_ratio < math.inf
    case = cases.of_law([BEAD], law, False, None)[0]
    if phi < 0.4:
        without = driven.without_friction(case, driven.gas(case, d, phi), 0.1)
        assert without is None or without >= -1.0  # at rest, if spins alone are heated
        assert kind != "power" or without is None or without > -1e-3


# --- scripts ------------------------------------------------------------------------------------------------------


def script(langevin: str, mu: float = 0.5, model: str = "linear_history 571.4 0.5", lines: str = "") -> str:
    """2000 beads at φ = 0.2, with the mean of 0.02 m²/s² of the bath in each component."""
    force = "hertz/material 1e7 0.9 0.3" if "mindlin" in model else "hooke 2e3 0.9"
    return f"""units si
atom_style sphere
boundary p p p
comm_modify vel yes
region box block 0 0.03473 0 0.03473 0 0.03473 units box
create_box 1 box
create_atoms 1 random 2000 7 box overlap 0.002 maxtry 500
set type 1 diameter 0.002 density 2500
pair_style granular
pair_coeff * * {force} damping coeff_restitution tangential {model} {mu} limit_damping
velocity all create 1.15e16 3
fix heat all langevin {langevin}
fix move all nve/sphere
timestep 4e-6
{lines}run 90000
"""


LANGEVIN = "2.3e16 2.3e16 0.02 7"
HOT = 1.380649e-23 * 2.3e16 / BEAD.mass


@pytest.mark.parametrize(
    ("words", "rate", "spin_rate"),
    [
        ("", 100.0, 0.0),
        ("omega no zero yes", 100.0, 0.0),
        ("omega yes", 100.0, 1000.0 / 3.0),
        ("tally yes omega yes", 100.0, 1000.0 / 3.0),
        ("scale 1 2.0 omega yes", 50.0, 500.0 / 3.0),
        ("scale 2 5.0", 100.0, 0.0),
        ("scale * 2.0", None, None),
        ("scale 1 v_x", None, None),
    ],
)
def test_langevin_is_read_with_its_spins(words, rate, spin_rate):
    """Rates 2/damp and, with ``omega yes``, 10/3 of it."""
    stage = read_text(script(f"{LANGEVIN} {words}")).stages[-1]
    if rate is None:
        assert stage.bath is None
        return
    assert stage.bath.rate == pytest.approx(rate) and stage.bath.spin_rate == pytest.approx(spin_rate)
    assert stage.bath.temperature == pytest.approx(1.380649e-23 * 2.3e16)
    assert stage.bath.spin_temperature == (stage.bath.temperature if spin_rate else 0.0)


def test_what_is_not_known_of_heated_friction_is_said_in_a_line():
    """Temperature and T_r/T stand, without the number of the error."""
    reasons = {
        f"{LANGEVIN} omega yes": "known only where no thermostat acts on spins",
        f"{LANGEVIN} ": "not known with this friction (it is for spheres of one μ with linear springs, normal and",
    }
    for langevin, reason in reasons.items():
        model = "linear_history 571.4 0.5" if "omega" in langevin else "mindlin_rescale NULL 1.0"
        verdict = hl.check(script(langevin, model=model))
        row = verdict.rows[0]
        assert verdict.admissible is None and reason in verdict.sentence and not row.error
        assert row.heated_error is None and row.frictionless_error < 0.0 and row.tc_nu > 0.0
        assert f"(kinetic theory with friction, T_r/T = {row.temperature_ratio:.2g}" in verdict.sentence
        assert verdict.to_dict()["contacts"][0]["temperature_ratio"] == row.temperature_ratio
    sheared = script(LANGEVIN).replace(
        f"fix heat all langevin {LANGEVIN}", "fix d all deform 1 xy erate 200 remap v"
    )
    verdict = hl.check(sheared)
    row = verdict.rows[0]
    assert verdict.quantity == "stress" and row.sheared_error > 2.0 * row.sheared_error_bar > 0.0
    assert f"(kinetic theory with friction, T_r/T = {row.temperature_ratio:.2g}" in verdict.sentence
    mindlin = sheared.replace("hooke 2e3", "hertz/material 1e8").replace("0.9 damping", "0.9 0.3 damping")
    hertz = hl.check(mindlin.replace("linear_history 571.4 0.5", "mindlin NULL 1.0"))
    assert "the error of the shear stress is not known with this friction (it is for" in hertz.sentence
    soft = hl.check(
        script(f"{LANGEVIN} omega yes").replace("hooke 2e3", "hooke 20").replace("571.4", "5.714")
    )
    assert soft.admissible is False and "is above 0.3, where contacts overlap in time" in soft.sentence


@pytest.mark.slow
def test_a_sheared_script_with_friction_has_its_number():
    """The stress at the t_c ν of the steady state, and what leaving friction out does to it."""
    shear = "fix d all deform 1 xy erate 200 remap v"
    text = script(LANGEVIN).replace(f"fix heat all langevin {LANGEVIN}", shear)
    verdict = hl.check(text)
    row = verdict.rows[0]
    friction = hl.Friction(0.5, stiffness_ratio=0.2857, damping_ratio=0.5)
    law = hl.error_law(packing_fraction=0.2, restitution=row.restitution, rule="law", friction=friction)
    assert row.sheared_error == pytest.approx(law.sheared_errors(row.tc_nu).stress, rel=1e-3)
    assert row.rule == "law" and row.extrapolated == "" and row.softening > 1.0
    gas = hl.boxes.theory.Gas(1, 1e-3, BEAD.mass, BEAD.mass / 2500.0 / 0.2, 3)
    bead = hl.LinearDashpot(stiffness=2e3, restitution=row.restitution, friction=friction)
    assert row.speed**2 / math.pi == pytest.approx(
        gas.rotating(law=bead).sheared_temperature(200.0), rel=1e-3
    )
    smooth = hl.check(text.replace(" 0.5 limit_damping", " 0 limit_damping")).rows[0]
    without = gas.rotating(row.restitution, 0.0, 0.0)
    assert smooth.speed**2 / math.pi == pytest.approx(without.sheared_temperature(200.0), rel=1e-3)
    stresses = [
        grains.sheared_state(200.0).pressure_tensor[0, 1] for grains in (without, gas.rotating(law=bead))
    ]
    assert row.smooth_error == pytest.approx(stresses[0] / stresses[1] - 1.0, rel=1e-2)
    assert "the shear stress of event-driven is" in verdict.sentence and "too high" in verdict.sentence
    spinning = hl.check(text, speed=0.1).rows[0]
    assert spinning.sheared_error == pytest.approx(law.sheared_errors(spinning.tc_nu).stress, rel=1e-3)
    beyond = hl.check(script(LANGEVIN, mu=1.5).replace(f"fix heat all langevin {LANGEVIN}", shear))
    assert "sheared gases were measured at 0 ≤ μ ≤ 1, not at 1.5." in beyond.sentence


@pytest.mark.slow
def test_a_heated_script_with_friction_has_its_number():
    verdict = hl.check(script(LANGEVIN))
    row = verdict.rows[0]
    t = row.speed**2 / math.pi
    friction = hl.Friction(0.5, stiffness_ratio=0.2857, damping_ratio=0.5)
    law = hl.error_law(packing_fraction=0.2, restitution=row.restitution, rule="law", friction=friction)
    share = 1.5 * (HOT - t) / (t + 1.5 * (HOT - t))  # of a bath, as without friction
    assert row.heated_error == pytest.approx(share * law.heated_error(row.tc_nu), rel=2e-2)
    assert row.rule == "law" and row.extrapolated == "" and row.heated_error_bar > 0.0
    smooth = hl.check(script(LANGEVIN, mu=0.0)).rows[0]
    assert row.smooth_error == pytest.approx((smooth.speed / row.speed) ** 2 - 1.0, rel=1e-3)
    assert verdict.admissible is True and verdict.quantity == "temperature"
    assert "event-driven is 0.25 ± 0.08 % too cold" in verdict.sentence
    assert (
        "Event-driven must have the same friction (rule law); without, it is about 32 % too hot."
        in verdict.sentence
    )
    assert row.softening < 1.0
    # At the speed of a dump or an option, with the bath of the script.
    at = hl.check(script(LANGEVIN), speed=row.speed).rows[0]
    assert at.heated_error == pytest.approx(row.heated_error) and at.temperature_ratio is None
    other = hl.check(script(LANGEVIN, mu=1.5))
    assert (
        "Less is known of these grains: heated gases were measured at 0 ≤ μ ≤ 1, not at 1.5."
        in other.sentence
    )
    slight = hl.check(script(LANGEVIN, mu=1e-6)).rows[0]
    assert slight.heated_error == pytest.approx(smooth.heated_error, rel=1e-4)


@pytest.mark.slow
def test_elastic_grains_that_rub_have_a_steady_state():
    """Friction alone dissipates, also that of superballs; smooth ones heat for ever."""
    for rho in (1.0, 2.88):
        verdict = hl.check(BEAD, law=dashpot(0.5, rho, 1.0), packing_fraction=0.2, power=1e-6)
        row = verdict.rows[0]
        assert row.heated_error_bar > 0.0 and row.smooth_error is None and row.speed > 0.0
        assert "Event-driven must have the same friction (rule law). Less is known" in verdict.sentence
    assert hl.check(BEAD, law=dashpot(0.0, e=1.0), packing_fraction=0.2, power=1e-6).rows[0].speed is None


@pytest.mark.slow
@settings(max_examples=12, deadline=None, phases=[Phase.reuse, Phase.generate])
@given(
    log_floats(1e3, 1e7), st.floats(0.6, 0.98), st.floats(0.05, 0.48), log_floats(1e-5, 1e-1), st.floats(0.01, 1.5),
    st.floats(0.8, 3.8), st.floats(0.0, 1.0),
)  # fmt: skip
def test_the_softest_heated_grains_that_rub_are_admissible(stiffness, e, phi, power, mu, rho, damping):
    def with_stiffness(value):
        law = dashpot(mu, rho, e, damping).replace(stiffness=value)
        return hl.check(BEAD, law=law, packing_fraction=phi, power=power * BEAD.mass)

    row = with_stiffness(stiffness).rows[0]
    assert with_stiffness(1.001 * row.spring[2]).admissible is True
    assert with_stiffness(0.97 * row.spring[2]).admissible is not True


@pytest.mark.slow
@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("omega", ["no", "yes"])
def test_heated_grains_in_lammps_have_the_temperature_of_check(omega, tmp_path):
    """``fix langevin`` on velocities, and on spins, too: T within 3 % (0.7, 0.0), T_r/T within 4 % (−2.2, −0.3)."""
    text = script(f"{LANGEVIN} omega {omega}", lines="compute spin all erotate/sphere\nthermo 100\n"
                  "thermo_style custom step ke c_spin\n")  # fmt: skip
    row = hl.check(text).rows[0]
    (tmp_path / "in.heat").write_text(text, encoding="utf-8")
    command = PROGRAM.command(1, "-in", "in.heat", "-log", "log.heat", "-screen", "none")
    subprocess.run(command, cwd=tmp_path, env=PROGRAM.environment(), check=True, capture_output=True)
    lines = (tmp_path / "log.heat").read_text("utf-8").splitlines()
    rows = [line.split() for line in lines if re.fullmatch(r"\s*\d+(\s+\S+){2}\s*", line)]
    _, moving, turning = np.array(rows, float)[len(rows) // 3 :].T
    assert np.mean(moving) * 2.0 / (3.0 * 2000 * BEAD.mass) == pytest.approx(row.speed**2 / math.pi, rel=0.03)
    assert np.mean(turning / moving) == pytest.approx(row.temperature_ratio, rel=0.04)


# --- our engines --------------------------------------------------------------------------------------------------

#: φ, ε, μ, ρ, γ_t/γ_n, t_c ν, and the power on spins over that on velocities.
RUNS = {
    "undamped": (0.2, 0.9, 0.5, 1.0, 0.0, 0.1, 0.0),
    "thin": (0.1, 0.8, 0.3, 2.88, 0.5, 0.1, 0.0),
    "dense": (0.4, 0.9, 1.0, 1.0, 0.5, 0.2, 0.0),
    "damped": (0.2, 0.9, 0.5, 1.0, 0.5, 0.2, 0.0),
    "spins": (0.2, 0.9, 0.5, 1.0, 0.0, 0.1, 1.0),
}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::hardlimit.CompressionWarning")
@pytest.mark.parametrize("name", RUNS)
def test_heated_grains_have_the_temperature_and_the_error_of_check(name):
    """2000 grains, 100 collisions of each: T and T_r/T of hard spheres within 5 %, and the error of T within its bars.

    Kinetic theory leaves out that velocities are correlated, which makes T about 3 % higher. studies/driven_friction.py
    has more runs.
    """
    phi, e, mu, rho, damping, tc_nu, share = RUNS[name]
    start = hl.ParticleSystem.random(2000, phi, 1e-3, 2500.0, 0.1, seed=1, rms_spin="equal")
    start = equilibrated(start, 1001, collisions=20)
    gas = theory.Gas(2000, 1e-3, BEAD.mass, start.domain.volume, 3)
    nu = float(gas.collision_rate(start.granular_temperature))
    law = dashpot(mu, rho, e, damping)
    speed = math.sqrt(math.pi * start.granular_temperature)
    law = law.replace(stiffness=1e5 * (law.between(BEAD, BEAD).duration(speed) * nu / tc_nu) ** 2)
    kicks = hl.RandomKicks(1e-3, 1.0, rotational=1e-3 * share if share else None)
    reached = hl.check(start.replace(thermostat=kicks), law=law).rows[0].speed  # ∝ power^(1/3)
    power = 1e-3 * (speed / reached) ** 3
    kicks = hl.RandomKicks(power, 0.05 / nu, rotational=power * share if share else None, seed=77)
    start = start.replace(thermostat=kicks)
    row = hl.check(start, law=law).rows[0]
    assert row.speed == pytest.approx(speed, rel=1e-6) and row.tc_nu == pytest.approx(tc_nu, rel=1e-3)
    temperatures, losses = [], []
    for engine in ("hard", "steps"):
        options = {"until": 125.0 / nu, "samples": 375}
        run = (
            hl.event_driven(start, law=law, **options)
            if engine == "hard"
            else hl.molecular_dynamics(start, law=law, engine="steps", threads=1, **options)
        )
        series = run.series.isel(time=slice(75, None))
        t = series.granular_temperature.values
        theta = float((series.rotational_temperature.values / t).mean())
        assert theta == pytest.approx(row.temperature_ratio, rel=0.05 if engine == "hard" else 0.1)
        temperatures.append(float(t.mean()))
        losses.append(float(np.diff(series.dissipated_energy.values[[0, -1]])[0]) / float(np.mean(t**1.5)))
    assert temperatures[0] == pytest.approx(row.speed**2 / math.pi, rel=0.05)
    assert temperatures[1] == pytest.approx(row.speed**2 / math.pi, rel=0.08)
    measured = (losses[0] / losses[1]) ** (-2.0 / 3.0) - 1.0  # of T at equal power
    if share:
        assert row.heated_error is None
        return
    assert row.extrapolated == ""
    assert measured == pytest.approx(row.heated_error, abs=3.0 * math.hypot(row.heated_error_bar, 0.005))
    assert abs(row.frictionless_error - measured) > 0.01  # without friction in it, the number is another one
