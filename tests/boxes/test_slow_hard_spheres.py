"""The slow reference engine: comparison with reference logs and, for the soft rule, with Newton's equations."""

import json
import math

import numpy as np
import pytest

import hardlimit as hl
from conftest import DATA
from slow_hard_spheres import Rule, SlowHardSpheres

CASES = json.loads((DATA / "grains.json").read_text(encoding="utf-8"))


def law_of_case(case: dict) -> hl.Law | None:
    if "youngs_modulus" in case:
        names = ("youngs_modulus", "poisson_ratio", "dissipative_time")
        return hl.Viscoelastic(**{name: case[name] for name in names})
    if "stiffness" in case:
        return hl.LinearDashpot(stiffness=case["stiffness"], restitution=case["restitution"])
    return None


def slow(case: dict, rule: Rule) -> SlowHardSpheres:
    arrays = (np.array(case[name]) for name in ("positions", "velocities", "radius", "mass", "box"))
    return SlowHardSpheres(*arrays, tuple(case["boundary"]), np.array(case["gravity"]), rule)


def assert_at_the_end_of(case: dict, engine: SlowHardSpheres) -> None:
    speed = math.sqrt(np.mean(np.sum(np.square(case["velocities"]), axis=1)))
    wrong_speed = np.abs(engine.velocity - case["end_velocities"]).max() / speed
    wrong_place = np.abs(engine.position - case["end_positions"]).max() / min(case["radius"])
    assert max(wrong_speed, wrong_place) <= case["tolerance"]


@pytest.mark.parametrize("case", CASES["event_driven"], ids=lambda c: f"{c['rule']}-{len(c['radius'])}")
def test_reference_log(case: dict) -> None:
    rule = Rule(
        case["rule"],
        case.get("restitution", 1.0),
        law_of_case(case),
        case.get("contact_duration", math.nan),
    )
    engine = slow(case, rule)
    engine.advance(math.inf, case["collisions"])
    log, known = np.array(engine.log), np.array(case["log"])
    assert np.array_equal(log[:, 1:3], known[:, 1:3])
    np.testing.assert_allclose(log[:, 0], known[:, 0], rtol=case["tolerance"])
    assert_at_the_end_of(case, engine)


@pytest.mark.parametrize("case", CASES["dilute"], ids=lambda c: f"{c['law']}-{c['dimension']}")
def test_soft_rule_is_newtons_equations_where_contacts_are_isolated(case: dict) -> None:
    engine = slow(case, Rule("soft", law=law_of_case(case)))
    engine.advance(case["until"])
    contacts = sorted((begin, first, second) for begin, _, first, second in case["contacts"])
    assert [row[1:3] for row in engine.log] == [row[1:] for row in contacts]
    times = [row[0] for row in engine.log]
    np.testing.assert_allclose(times, [row[0] for row in contacts], rtol=case["tolerance"])
    assert_at_the_end_of(case, engine)


def test_soft_rule_becomes_that_of_hard_spheres_with_order_one_in_the_duration() -> None:
    """Four times the stiffness halves the contact duration and the deviation from the hard-sphere path."""
    case = CASES["dilute"][0]
    hard = slow(case, Rule("constant", case["restitution"]))
    hard.advance(math.inf, 5)
    until = hard.time + 1e-4
    hard.advance(until)
    off = []
    for factor in (1e3, 4e3, 16e3, 64e3):
        law = hl.LinearDashpot(stiffness=factor * case["stiffness"], restitution=case["restitution"])
        soft = slow(case, Rule("soft", law=law))
        soft.advance(until)
        assert [row[1:3] for row in soft.log] == [row[1:3] for row in hard.log]
        off.append(np.abs(soft.position - hard.position).max())
    np.testing.assert_allclose(np.log2(np.array(off[:-1]) / off[1:]), 1.0, atol=0.05)
