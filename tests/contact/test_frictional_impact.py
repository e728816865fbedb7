"""One contact with friction and a fixed normal: closed forms, independent integrations, conservation, limits."""

import functools
import itertools
import json
import math
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import DATA, compiled, draws, refusal, slow, table
from frictional_motion import Pair, TooCostlyError, integrate
from hardlimit.contact.friction import FrictionTerms
from hardlimit.contact.impact import tangential_restitution

KAPPA = 3.5  #: m/m_t of a solid sphere
MODELS = ("spring", "mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force")


def wall_contact(
    friction: hl.Friction | None, *, restitution: float = 1.0, inertia_factor: float = 0.4, **law: float
) -> hl.Contact:
    """A ball of mass 1 on a wall under a linear law with stiffness 1, unless another law is given."""
    ball = hl.Ball(1.0, mass=1.0, inertia_factor=inertia_factor)
    if law:
        return hl.Viscoelastic(**law, friction=friction).between(ball)
    damping = {"damping": 0.0} if restitution == 1.0 else {"restitution": restitution}
    return hl.LinearDashpot(stiffness=1.0, **damping, friction=friction).between(ball)


def beta_of(psi: float, rho: float, **more: float) -> float:
    """β of an elastic sphere at tan γ = κ μ ψ under the linear law."""
    coefficient = 0.5
    contact = wall_contact(hl.Friction(coefficient, stiffness_ratio=rho / KAPPA, **more))
    return contact.impact(1.0, KAPPA * coefficient * psi).tangential_restitution


# ---- reference values --------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", table("impact_tangential"), ids=itertools.count())
def test_reference_of_linear_contacts(row: dict[str, str]) -> None:
    value = {name: float(text) for name, text in row.items() if name != "starts"}
    friction = hl.Friction(
        value["friction"],
        stiffness_ratio=value["tangential_stiffness_ratio"],
        damping_ratio=value["tangential_damping_ratio"],
    )
    contact = wall_contact(friction, restitution=value["restitution"], inertia_factor=value["inertia_factor"])
    impact = contact.impact(1.0, value["tan_angle"])
    stick = sum(i.end - i.begin for i in impact.intervals if i.state == "stick")
    assert impact.tangential_restitution == pytest.approx(value["beta"], abs=1e-12)
    assert impact.impulse_ratio == pytest.approx(value["impulse_ratio"], abs=1e-12)
    assert impact.duration == pytest.approx(value["duration"], abs=1e-12)
    assert stick / impact.duration == pytest.approx(value["stick_share"], abs=1e-12)
    assert impact.transitions == value["transitions"]
    assert row["starts"].endswith(impact.intervals[0].state)  # "limited then stick" too


#: β(ψ; ρ) without damping: friction.md, section 3; piecewise exact, direct integration and Stronge's model agree.
PSI = (0.01, 0.1, 0.3, 0.5, 0.8, 1.0, 1.2, 1.5, 1.8, 3.0)
ELASTIC = {
    1.0: (1, 1, 1, 1, 1, 1, 0.666667, 0.333333, 0.111111, -0.333333),
    2.0: (.275496, .353631, .491731, .587877, .693051, .645485, .548984, .333333, .111111, -.333333),
    2.8824: (-.572396, -.470295, -.181993, .194943, .441344, .459661, .424675, .305087, .111111, -.333333),
    3.15: (-.753233, -.674543, -.378985, .095655, .380660, .415440, .394129, .293333, .111111, -.333333),
    3.5: (-.915968, -.879133, -.612870, -.022573, .309389, .363599, .358016, .278155, .111111, -.333333),
    4.0: (-1, -1, -.864040, -.171692, .220544, .299038, .312652, .257584, .111111, -.333333),
}  # fmt: skip


@pytest.mark.parametrize("rho", ELASTIC)
def test_table_of_elastic_contacts(rho: float) -> None:
    assert [beta_of(psi, rho) for psi in PSI] == pytest.approx(ELASTIC[rho], abs=5.1e-7)


def test_pooltool_agrees() -> None:
    """Its resolver of Stronge's compliant contact (tools/verify_stronge.py), random ψ, ρ, μ, inertia and speeds."""
    sequences = set()
    for row in table("pooltool_stronge"):
        value = {name: float(text) for name, text in row.items() if name != "version"}
        friction = hl.Friction(value["friction"], stiffness_ratio=value["stiffness_ratio"])
        contact = wall_contact(friction, inertia_factor=value["inertia_factor"])
        impact = contact.impact(-value["normal"], -value["tangential"])
        beta = -value["tangential_after"] / value["tangential"]
        assert impact.tangential_restitution == pytest.approx(beta, abs=5e-14)
        sequences.add(tuple(interval.state for interval in impact.intervals))
    assert sequences == {("stick", "slip"), ("slip", "stick", "slip"), ("slip",)}


#: Names of the four histories in friction.json.
HISTORIES = {
    "displacement history": "mindlin",
    "force history": "mindlin_force",
    "displacement history, rescaled": "mindlin_rescale",
    "force history, rescaled": "mindlin_rescale_force",
}
HERTZ = json.loads((DATA / "friction.json").read_text(encoding="utf-8"))["impact_hertz"]


@pytest.mark.parametrize("case", HERTZ, ids=itertools.count())
def test_reference_of_hertz_contacts(case: dict) -> None:
    """Known to 2e-10, with the k_t and the damping of the case; k_t = tangential_ratio ρ √ξ."""
    friction = hl.Friction(
        math.inf if case["friction"] is None else case["friction"],
        stiffness_ratio=case["tangential_ratio"] / 1.5,
        damping_ratio=case["tangential_damping_ratio"],
        model=HISTORIES[case["history"]],
    )
    material = {name: case[name] for name in ("youngs_modulus", "poisson_ratio")}
    law = (
        hl.Tsuji(**material, damping_coefficient=case["scaled_damping"], friction=friction)
        if case["law"] == "tsuji"
        else hl.Viscoelastic(**material, dissipative_time=case["dissipative_time"], friction=friction)
    )
    ball = hl.Ball(case["radius"], mass=case["mass"], inertia_factor=case["inertia_factor"])
    impact = law.between(ball, ball).impact(case["speed"], case["speed"] * case["tan_angle"])
    stick = sum(i.end - i.begin for i in impact.intervals if i.state == "stick")
    known = 2.0 * case["known_to"] + 1e-11
    assert impact.tangential_restitution == pytest.approx(case["beta"], abs=known)
    assert impact.duration == pytest.approx(case["duration"], rel=1e-9)
    assert stick / impact.duration == pytest.approx(case["stick_share"], abs=1e-8)
    assert impact.transitions == case["transitions"]


def hertz(model: str, nu: float, coefficient: float, psi: float, ratio: float | None = None) -> float:
    friction = hl.Friction(coefficient, model=model, stiffness_ratio=ratio)
    contact = wall_contact(friction, youngs_modulus=1.0, poisson_ratio=nu, dissipative_time=0.0)
    slip = psi if math.isinf(coefficient) else KAPPA * coefficient * psi
    return contact.impact(1.0, slip).tangential_restitution


#: β of elastic Hertz contacts at ν = 0.2: without slip, and at ψ = 0.05, 0.5, 1.2 (friction.md, section 3).
MINDLIN = {
    "mindlin": (-1.0295, -1.0296, -0.0623, 0.3177),
    "mindlin_force": (-1.0295, -0.9691, -0.1258, 0.3563),
    "mindlin_rescale": (-0.7248, -0.7249, -0.0466, 0.2863),
    "mindlin_rescale_force": (-0.6112, -0.6106, -0.1094, 0.3177),
}


@pytest.mark.parametrize("model", MINDLIN)
def test_elastic_hertz_contacts(model: str) -> None:
    values = [hertz(model, 0.2, math.inf, 1.0), *(hertz(model, 0.2, 0.5, psi) for psi in (0.05, 0.5, 1.2))]
    assert values == pytest.approx(MINDLIN[model], abs=1e-4)


@pytest.mark.parametrize(("rho", "beta"), [(0.9, 1.041), (3.0, -1.000), (3.3, -1.051)])
def test_mindlin_gains_energy_without_slip(rho: float, beta: float) -> None:
    assert hertz("mindlin", 0.3, math.inf, 1.0, rho / KAPPA) == pytest.approx(beta, abs=5.1e-4)


@given(
    st.sampled_from(("mindlin_rescale", "mindlin_rescale_force")),
    st.floats(0.05, 6.0),
    st.floats(0.01, 4.0),
    st.floats(0.0, 0.3),
)
@draws(200, 20)
def test_a_rescaled_spring_never_gains(model: str, rho: float, psi: float, dissipation: float) -> None:
    friction = hl.Friction(0.5, model=model, stiffness_ratio=rho / KAPPA)
    contact = wall_contact(friction, youngs_modulus=1.0, poisson_ratio=0.3, dissipative_time=dissipation)
    impact = contact.impact(1.0, KAPPA * 0.5 * psi)
    assert abs(impact.tangential_restitution) <= 1.0 + 1e-12
    assert impact.energies["friction"] >= -1e-12


# ---- formulas ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("coefficient", [1e-9, 0.05, 0.3, 1.0, 7.0, 1e9, math.inf])
@pytest.mark.parametrize("inertia_factor", [0.05, 0.4, 0.5, 2.0 / 3.0, 1.0])
def test_equal_frequencies_are_the_constant_rule(coefficient: float, inertia_factor: float) -> None:
    """At ρ = κ k_t/k_n = 1 spring and force keep their ratio: Walton's rule with β0 = 1."""
    kappa = 1.0 + 1.0 / inertia_factor
    contact = wall_contact(
        hl.Friction(coefficient, stiffness_ratio=1.0 / kappa), inertia_factor=inertia_factor
    )
    tan = np.geomspace(1e-6, 1e6, 40)
    rule = np.minimum(1.0, -1.0 + 2.0 * kappa * coefficient / tan)
    got = [contact.impact(1.0, t).tangential_restitution for t in tan]
    assert got == pytest.approx(rule, abs=1e-12)
    assert contact.tangential_restitution(np.arctan(tan)) == pytest.approx(rule, abs=1e-9)


@pytest.mark.parametrize("rho", [1e-6, 0.3, 2.0, 3.99, 40.0, 1e4])
def test_without_slip(rho: float) -> None:
    beta = wall_contact(hl.Friction(math.inf, stiffness_ratio=rho / KAPPA)).tangential_restitution(0.3)
    assert beta == pytest.approx(-math.cos(math.pi * math.sqrt(rho)), abs=1e-12 * (1.0 + math.sqrt(rho)))


@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.1, 0.01])
@pytest.mark.parametrize("rho", [0.1, 1.0, 2.88, 3.5])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 20.0])
def test_without_slip_but_with_damping(restitution: float, rho: float, ratio: float) -> None:
    """β = −e^(−bτ) [cos Ωτ − (b/Ω) sin Ωτ], Ω² = ρ − b², over the duration of the clipped contact."""
    friction = hl.Friction(math.inf, stiffness_ratio=rho / KAPPA, damping_ratio=ratio)
    contact = wall_contact(friction, restitution=restitution)
    b = 0.5 * KAPPA * ratio * contact.damping
    tau, omega = contact.duration(), np.emath.sqrt(rho - b * b)
    beta = -math.exp(-b * tau) * (np.cos(omega * tau) - b / omega * np.sin(omega * tau))
    assert contact.tangential_restitution(0.3) == pytest.approx(np.real(beta), abs=1e-11)


#: β(ψ → 0) over the clipped contact at ε = 1, .9, .7, .5, .3, .1 (friction.md, section 3).
CLIPPED = {
    2.0 / 7.0: (1.0, 0.998, 0.975, 0.911, 0.752, 0.278),
    1.0: (-1.0, -0.919, -0.862, -0.680, -0.359, 0.181, 0.948)[1:],
}


@pytest.mark.parametrize("ratio", CLIPPED)
def test_head_on_limit_of_dissipative_contacts(ratio: float) -> None:
    values = [
        wall_contact(hl.Friction(0.5, stiffness_ratio=ratio), restitution=e).tangential_restitution(0.0)
        for e in (1.0, 0.9, 0.7, 0.5, 0.3, 0.1)
    ]
    assert values == pytest.approx(CLIPPED[ratio], abs=6e-4)


@pytest.mark.parametrize("rho", [1.1, 1.7, 2.88, 3.5, 12.0])
def test_border_of_sliding_throughout(rho: float) -> None:
    """An elastic contact slips throughout iff ψ > max(1/ρ, 2 − 1/ρ); there β = 1/(2ρ − 1), beyond it −1 + 2/ψ."""
    border = 2.0 - 1.0 / rho
    friction = hl.Friction(0.5, stiffness_ratio=rho / KAPPA)
    contact = wall_contact(friction)
    beyond = contact.impact(1.0, KAPPA * 0.5 * border * (1.0 + 1e-6))
    before = contact.impact(1.0, KAPPA * 0.5 * border * (1.0 - 1e-6))
    assert [i.state for i in beyond.intervals] == ["slip"]
    assert beyond.impulse_ratio == pytest.approx(0.5, rel=1e-14)
    assert before.transitions == 2
    assert before.tangential_restitution == pytest.approx(1.0 / (2.0 * rho - 1.0), abs=1e-5)
    assert beta_of(3.0 * border, rho) == pytest.approx(-1.0 + 2.0 / (3.0 * border), abs=1e-13)


def test_slip_ends_where_it_must() -> None:
    """A contact that starts slipping sticks at cos τ = (1 − ψ)/(1 − 1/ρ)."""
    rho, psi = 2.88, 1.2
    contact = wall_contact(hl.Friction(0.5, stiffness_ratio=rho / KAPPA))
    first = contact.impact(1.0, KAPPA * 0.5 * psi).intervals[0]
    assert first.state == "slip"
    assert first.end == pytest.approx(math.acos((1.0 - psi) / (1.0 - 1.0 / rho)), abs=1e-13)


@given(st.floats(0.05, 1.0), st.floats(1e-3, 50.0), st.floats(1e-3, 10.0), st.floats(1e-3, 100.0))
@draws(200, 30)
def test_without_a_spring_slip_is_never_reversed(
    restitution: float, ratio: float, coefficient: float, tan: float
) -> None:
    friction = hl.Friction(coefficient, model="none", damping=ratio)
    impact = wall_contact(friction, restitution=restitution).impact(1.0, tan)
    assert -1.0 <= impact.tangential_restitution <= 0.0
    # The impulse is the change of the slip velocity, which has the rounding error of that velocity.
    assert abs(impact.impulse_ratio) <= coefficient * (1.0 + 1e-12) + 1e-15 * tan


# ---- independent integrations ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Numbers:
    """A contact with mass, K and speed one: X'' = −X^p − C X^q X'; k_t = R X^r, γ_t = c X^w, with m_t."""

    powers: tuple[int, int, bool]
    damping: float
    terms: FrictionTerms
    tangential_mass: float
    slip: float

    @property
    def beta(self) -> float:
        mass = self.tangential_mass
        return float(
            tangential_restitution(self.powers, 1.0, self.damping, 1.0, self.terms, mass, 1.0, self.slip)
        )

    def integrated(self) -> float:
        """β of a ball on a wall, by the integration in space of tests/frictional_motion.py."""
        factor = self.tangential_mass / (1.0 - self.tangential_mass)  # m_t = m/(1 + 1/q)
        p, q, _ = self.powers
        pair = Pair((1.0, np.inf), (1.0, 1.0), (factor, 1.0), (p / 4, q / 4), (1.0, self.damping), self.terms)
        towards, start = np.array([0.0, 0.0, 1.0]), np.zeros(18)
        start[6:9] = [self.slip, 0.0, 1.0]
        end, _, _ = integrate(pair, start, towards, math.pi)
        return -float(end[6] + np.cross(end[12:15], towards)[0]) / self.slip


def random_numbers(random: np.random.Generator, *, steps: bool = False) -> Numbers:
    """A contact of any model; ``steps``: one that also time steps resolve, attractive tails included."""
    elastic = int(random.choice([4, 6]))
    damping = int(random.choice([0, 4] if elastic == 4 else [0, 1, 2, 4]))
    attracts = steps and bool(random.random() < 0.3)
    model = "spring" if elastic == 4 else MODELS[random.integers(5)]
    smooth = random.random() < 0.3
    normal = 0.0 if smooth else float(np.exp(random.uniform(math.log(0.02), math.log(1.5))))
    ratio = 0.0 if random.random() < 0.5 else float(np.exp(random.uniform(math.log(0.05), math.log(4.0))))
    kappa = 1.0 + 1.0 / random.uniform(0.2, 1.0)
    terms = FrictionTerms.of_model(
        model,
        random.choice(["total", "spring"]),
        coefficient=float(np.exp(random.uniform(math.log(0.05), math.log(2.0)))),
        stiffness=0.0
        if random.random() < 0.1
        else float(np.exp(random.uniform(math.log(0.1), math.log(3.0)))),
        stiffness_power=0 if model == "spring" else 2,
        damping=ratio * normal / kappa,
        damping_power=damping,
    )
    slip = float(np.exp(random.uniform(math.log(0.02), math.log(8.0))))
    return Numbers((elastic, damping, attracts), normal, terms, 1.0 / kappa, slip)


@pytest.mark.parametrize("seed", [1, *(slow(k) for k in range(2, 9))])
def test_agrees_with_an_integration_in_time(seed: int) -> None:
    random = np.random.default_rng(seed)
    left_out = 0
    for _ in range(6 if seed == 1 else 45):
        numbers = random_numbers(random)
        try:
            expected = numbers.integrated()
        except (TooCostlyError, RuntimeWarning):  # a history that grows where the contact radius is zero
            left_out += 1
            continue
        # SciPy's error is that of the velocities.
        assert numbers.beta == pytest.approx(expected, abs=1e-9 + 2e-10 / numbers.slip), numbers
    assert left_out <= 10


def deviations(tmp_path, *arguments: str) -> dict[str, float]:
    """What the program beside this file prints: worst deviations by name."""
    program = compiled("contact/frictional_impact.cpp", tmp_path)
    done = subprocess.run([program, *arguments], capture_output=True, text=True, check=True)
    return {name: float(value) for name, value in map(str.split, done.stdout.splitlines())}


@pytest.mark.parametrize(("number", "most"), [(700, 1e-12), slow(20000, 1e-11)])
def test_closed_form_is_the_integration(tmp_path, number: int, most: float) -> None:
    worst = deviations(tmp_path, "forms", str(number))
    assert worst.pop("counts") == 0
    assert worst.pop("follows") >= 10
    assert max(worst.values()) < most, worst


@pytest.mark.slow
def test_closed_form_is_the_integration_of_extremes(tmp_path) -> None:
    """Damping ratios up to 2000, ρ and ψ over nine decades; stored energies then exceed those of the collision."""
    worst = deviations(tmp_path, "forms", "2000", "1000")
    assert worst["counts"] <= 2
    assert max(worst[name] for name in ("slip", "rate", "time")) < 1e-9, worst
    assert worst["ledger"] < 1e-13
    assert worst["work"] < 1e-4


@pytest.mark.parametrize("number", [60, slow(250)])
def test_agrees_with_the_steps_of_codes(tmp_path, number: int) -> None:
    """The limit of small steps: also where a spring follows its limit without slip, and in attractive tails."""
    worst = deviations(tmp_path, "steps", str(number))
    assert worst["steps"] < 1e-3
    assert worst["follows"] >= number // 20


# ---- conservation and symmetry -----------------------------------------------------------------------------


def random_law(random: np.random.Generator) -> hl.Law:
    """A law with friction; every model, limit and kind of damping."""
    friction = {
        "coefficient": float(random.choice([0.0, 0.05, 0.5, 2.0, math.inf])),
        "damping_ratio": float(random.choice([0.0, 0.0, 0.4, 3.0])),
        "limit": str(random.choice(["total", "spring"])),
    }
    restitution = float(random.choice([1.0, 0.9, 0.5, 0.1]))
    kind = random.integers(4)
    if kind == 0:
        friction["damping_ratio"] += 0.1
        return hl.LinearDashpot(
            stiffness=1e6, restitution=restitution, friction=hl.Friction(**friction, model="none")
        )
    if kind == 1:
        ratio = float(random.uniform(0.1, 2.0))
        spring = hl.Friction(**friction, stiffness_ratio=ratio)
        return hl.LinearDashpot(stiffness=1e6, restitution=restitution, friction=spring)
    model = hl.Friction(**friction, model=MODELS[1 + random.integers(4)])
    material = {"youngs_modulus": 1e9, "poisson_ratio": 0.3, "restitution": restitution}
    if kind == 2:
        return hl.Tsuji(**material, friction=model)
    return hl.Viscoelastic(**material, impact_speed=1.0, friction=model)


def random_impact(random: np.random.Generator) -> tuple[hl.Impact, hl.Impact]:
    """A contact, and that with opposite tangential velocity and spins."""

    def ball() -> hl.Ball:
        return hl.Ball(random.uniform(0.005, 0.02), density=2500.0, inertia_factor=random.uniform(0.2, 1.0))

    other = hl.FLOOR if random.random() < 0.3 else ball()
    spin = random.uniform(-200.0, 200.0)
    other_spin = 0.0 if other is hl.FLOOR else random.uniform(-200.0, 200.0)
    contact = random_law(random).between(ball(), other)
    speed, aside = random.uniform(0.3, 3.0), random.uniform(-3.0, 3.0)
    return contact.impact(speed, aside, spin, other_spin), contact.impact(speed, -aside, -spin, -other_spin)


@functools.cache
def random_impacts() -> list[tuple[hl.Impact, hl.Impact]]:
    random = np.random.default_rng(7)
    return [random_impact(random) for _ in range(150)]


@pytest.fixture
def impacts() -> list[hl.Impact]:
    return [impact for impact, _ in random_impacts()]


def test_energy_is_accounted_for(impacts: list[hl.Impact]) -> None:
    for impact in impacts:
        turnover = impact.initial_energy + sum(map(abs, impact.energies.values()))
        assert sum(impact.energies.values()) == pytest.approx(impact.initial_energy, abs=1e-13 * turnover), (
            impact
        )
        for name in ("normal_spring", "normal_damping", "tangential_damping", "tangential_spring"):
            assert impact.energies[name] >= -1e-13 * turnover


def test_friction_loses_without_damping_and_history() -> None:
    random = np.random.default_rng(3)
    for _ in range(100):
        friction = hl.Friction(random.uniform(0.01, 2.0), stiffness_ratio=random.uniform(0.05, 3.0))
        contact = wall_contact(friction, restitution=random.uniform(0.05, 1.0))
        impact = contact.impact(1.0, random.uniform(0.01, 10.0))
        assert impact.energies["friction"] >= -1e-14
        assert abs(impact.tangential_restitution) <= 1.0 + 1e-13


def test_momentum_and_angular_momentum_are_conserved(impacts: list[hl.Impact]) -> None:
    for impact in impacts:
        if impact.other is hl.FLOOR:
            continue
        ball, other = impact.ball, impact.other
        before = ball.mass * np.array([impact.speed, impact.tangential_speed])
        after = ball.mass * impact.velocities[0] + other.mass * impact.velocities[1]
        assert after == pytest.approx(before, rel=1e-13, abs=1e-13 * ball.mass)
        # About the contact point the tangential momenta of the centres have the arms R and −R.
        inertia = [ball.moment_of_inertia, other.moment_of_inertia]
        turn = (inertia * (impact.spins - impact.initial_spins)).tolist()
        gained = ball.mass * (impact.velocities[0, 1] - impact.tangential_speed)
        scale = ball.radius * impact.normal_impulse
        assert turn[0] == pytest.approx(ball.radius * gained, abs=1e-13 * scale)
        assert turn[1] == pytest.approx(
            -other.radius * other.mass * impact.velocities[1, 1], abs=1e-13 * scale
        )


def test_relative_velocities_after_the_contact(impacts: list[hl.Impact]) -> None:
    """g_n' = −ε g_n and g_t' = −β g_t of the surfaces."""
    for impact in impacts:
        arms = [impact.ball.radius, 0.0 if impact.other is hl.FLOOR else impact.other.radius]
        normal, tangential = impact.velocities[0] - impact.velocities[1]
        surface = tangential + float(np.dot(arms, impact.spins))
        assert normal == pytest.approx(-impact.restitution * impact.speed, rel=1e-12)
        expected = -impact.tangential_restitution * impact.slip_velocity
        assert surface == pytest.approx(expected, abs=1e-12 * (abs(impact.slip_velocity) + 5.0))


def test_mirrored_impacts_are_equal() -> None:
    for impact, mirrored in random_impacts():
        assert mirrored.tangential_restitution == impact.tangential_restitution
        assert mirrored.intervals == impact.intervals
        assert mirrored.energies == impact.energies
        assert mirrored.velocities[:, 1].tolist() == (-impact.velocities[:, 1]).tolist()
        assert mirrored.spins.tolist() == (-impact.spins).tolist()
    impact, mirrored = random_impacts()[0]
    for name in ("tangential_force", "slip_velocity", "spin"):
        assert (mirrored.trajectory()[name] == -impact.trajectory()[name]).all()


def test_intervals_fill_the_contact(impacts: list[hl.Impact]) -> None:
    for impact in impacts:
        ends = [0.0, *(interval.end for interval in impact.intervals)]
        assert [interval.begin for interval in impact.intervals] == ends[:-1]
        assert ends[-1] == impact.duration
        assert sorted(set(ends)) == ends
        states = [interval.state for interval in impact.intervals]
        assert all(before != after for before, after in itertools.pairwise(states))


def test_motion_follows_the_forces(impacts: list[hl.Impact]) -> None:
    """Impulses are the integrals of the forces, and a sample in any order is that of the whole motion."""
    for impact in impacts[:30]:
        middles = (np.arange(1000) + 0.5) / 1000
        pieces = [(i.begin, i.end - i.begin) for i in impact.intervals]
        motion = [impact.trajectory(begin + length * middles) for begin, length in pieces]
        for force, impulse in (
            ("normal_force", "normal_impulse"),
            ("tangential_force", "tangential_impulse"),
        ):
            means = [float(piece[force].mean()) for piece in motion]
            total = sum(mean * length for mean, (_, length) in zip(means, pieces, strict=True))
            assert total == pytest.approx(getattr(impact, impulse), abs=1e-3 * impact.normal_impulse)
        whole, times = impact.trajectory(), impact.default_times()
        chosen = np.random.default_rng(1).permutation(len(times))[:60]
        some = impact.trajectory(times[chosen])
        for name in ("slip_velocity", "tangential_force", "compression", "spin"):
            scale = float(np.abs(whole[name]).max())
            assert some[name].values == pytest.approx(whole[name].values[chosen], abs=1e-12 * scale)
        assert whole["slip_velocity"].values[0] == pytest.approx(impact.slip_velocity)
        assert whole["spin"].values[-1] == pytest.approx(
            impact.spins, abs=1e-10 * (1.0 + np.abs(impact.spins).max())
        )
        limit = impact.numbers.terms.coefficient * np.abs(whole["normal_force"].values)
        if impact.numbers.terms.limit == 0:
            over = np.abs(whole["tangential_force"].values) - limit
            assert over.max() <= 1e-9 * float(whole["normal_force"].max())


@given(st.integers(0, 10**6), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
@draws(60, 8)
def test_units_do_not_matter(seed: int, mass: float, length: float, time: float) -> None:
    """A contact in other units of mass, length and time has the same β."""
    numbers = random_numbers(np.random.default_rng(seed), steps=True)
    p, q, _ = numbers.powers
    terms = numbers.terms
    scaled = terms._replace(
        stiffness=terms.stiffness * mass / time**2 / length ** (terms.stiffness_power / 4),
        damping=terms.damping * mass / time / length ** (terms.damping_power / 4),
    )
    beta = tangential_restitution(
        numbers.powers,
        mass * length / time**2 / length ** (p / 4),
        numbers.damping * mass / time / length ** (q / 4),
        mass,
        scaled,
        numbers.tangential_mass * mass,
        length / time,
        numbers.slip * length / time,
    )
    assert float(beta) == pytest.approx(numbers.beta, abs=1e-10)


# ---- limits and input --------------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.3, 1e-6])
@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_without_friction_the_contact_is_the_smooth_one(restitution: float, ratio: float) -> None:
    smooth = wall_contact(None, restitution=restitution)
    for coefficient in (0.0, 1e-300, 1e-9):
        rough = wall_contact(hl.Friction(coefficient, damping_ratio=ratio), restitution=restitution)
        impact = rough.impact(1.7, 0.8, spin=0.3)
        assert impact.restitution == smooth.restitution(1.7)
        assert impact.duration == smooth.duration(1.7)
        assert impact.tangential_restitution == pytest.approx(-1.0, abs=4.0 * KAPPA * 1.7e-9)
        assert impact.velocities[0, 0] == smooth.impact(1.7).velocities[0, 0]
    impact = wall_contact(hl.Friction(0.0, damping_ratio=1.0), restitution=restitution).impact(1.7, 0.8)
    assert impact.energies["friction"] == impact.energies["tangential_spring"] == 0.0
    assert smooth.impact(1.7, 0.8).velocities[0, 1] == 0.8
    assert smooth.tangential_restitution([0.0, 0.5, 1.5]).tolist() == [-1.0, -1.0, -1.0]
    assert [i.state for i in smooth.impact(1.7, 0.8).intervals] == ["slip"]


@pytest.mark.parametrize("law", ["linear", "tsuji"])
def test_head_on_is_the_limit_of_small_angles(law: str) -> None:
    friction = hl.Friction(0.5, damping_ratio=0.3)
    ball = hl.Ball(0.01, density=2500.0)
    contact = (
        hl.LinearDashpot(stiffness=1e6, restitution=0.8, friction=friction)
        if law == "linear"
        else hl.Tsuji(youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.8, friction=friction)
    ).between(ball)
    assert contact.tangential_restitution(0.0) == pytest.approx(
        contact.tangential_restitution(1e-6), abs=1e-5
    )
    head_on = contact.impact(1.0)
    assert head_on.tangential_impulse == 0.0
    assert head_on.velocities[0, 1] == 0.0
    assert head_on.spins.tolist() == [0.0, 0.0]


def test_a_damped_history_may_drive_the_surfaces() -> None:
    """The number is that of 20000 and 160000 steps of a code per contact, extrapolated."""
    friction = hl.Friction(0.5, model="mindlin_rescale", stiffness_ratio=0.1, damping_ratio=1.0)
    law = hl.Tsuji(elastic_prefactor=1.0, restitution=0.3, friction=friction)
    beta = law.between(hl.Ball(1.0, mass=1.0)).tangential_restitution(0.7)
    assert beta == pytest.approx(-1.9115, abs=1e-3)


@pytest.mark.parametrize("limit", ["total", "spring"])
@pytest.mark.parametrize("power", [4, 6])
def test_any_slip_velocity(power: int, limit: str) -> None:
    """From rounding errors of rolling surfaces to infinity; an infinite friction does not depend on it."""
    terms = FrictionTerms(0.5, 1.0, power - 4, 0.1, limit=("total", "spring").index(limit))

    def betas(terms: FrictionTerms, slip: list[float]) -> np.ndarray:
        return tangential_restitution((power, 0, False), 1.0, 0.1, 1.0, terms, 2 / 7, 1.0, slip)

    head_on = betas(terms, [0.0])[0]
    small = 10.0 ** -np.array([16, 17, 20, 30, 40, 100, 300])
    np.testing.assert_allclose(betas(terms, list(small)), head_on, atol=3e-14, rtol=0)
    assert betas(terms, [1e300, math.inf]).tolist() == [-1.0, -1.0]
    rough = betas(terms._replace(coefficient=math.inf), [0.0, 1.0, 1e300, math.inf])
    assert (rough == rough[0]).all() and abs(rough[0]) < 1.0


def test_rolling_contact_has_no_friction() -> None:
    contact = wall_contact(hl.Friction(0.5))
    impact = contact.impact(1.0, 3.0, spin=-3.0)
    assert impact.slip_velocity == 0.0
    assert impact.velocities[0].tolist() == [-1.0, 3.0]


def test_impact_refuses_bad_values() -> None:
    contact = wall_contact(hl.Friction(0.5))
    assert refusal(lambda: contact.impact(0.0)) == "speed: got 0, must be > 0 and finite"
    assert refusal(lambda: contact.impact(1.0, math.nan)) == "tangential_speed: got nan, must be finite"
    assert refusal(lambda: contact.impact(1.0, spin="a")).startswith("spin: got 'a', must be")
    assert (
        refusal(lambda: contact.impact(1.0, other_spin=2.0)) == "other_spin: got 2, must be 0 for the floor"
    )
    for speed, energy in ((1e155, "inf"), (1e-155, "5e-311")):
        assert refusal(lambda speed=speed: contact.impact(speed)) == (
            f"speed | tangential_speed | spin: got a kinetic energy of {energy} J, must be in [1e-290, 1e+300]"
        )
    assert "energy of inf J" in refusal(lambda: contact.impact(1.0, spin=-1e200))
    assert refusal(lambda: contact.tangential_restitution(math.pi / 2)).startswith("angle: got 1.57")
    assert refusal(lambda: contact.tangential_restitution([0.1, -0.1])).startswith("angle: got -0.1")
    assert (
        refusal(lambda: contact.tangential_restitution(0.1, speed=-1.0))
        == "speed: got -1, must be > 0 and finite"
    )
    late = contact.impact(1.0, 0.5)
    assert refusal(lambda: late.trajectory([0.0, 4.0])).startswith("times: got 4, must be in [0, 3.14")
    with pytest.raises(TypeError):
        type("MyImpact", (hl.Impact,), {})
