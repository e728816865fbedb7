"""The verdict on event-driven for any column: its sentence says what the numbers say."""

import math
import re

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, falling, free_columns, law_of, laws

BALL = hl.Ball(0.02, mass=0.1)

#: From balls that stay where they land to balls that lose nothing.
restitutions = st.one_of(st.floats(0.05, 1.0), st.sampled_from([1e-3, 0.01, 0.1, 0.99, 1.0]))

scenarios = st.one_of(
    columns(law=laws(restitutions), least=1, most=6),
    columns(law=laws(restitutions), least=2, most=2),
    free_columns(law=laws(restitutions), least=2, most=6),
)


def value(text: str) -> float:
    return float(text.replace("−", "-"))


def velocities(found: hl.Comparison) -> tuple[np.ndarray, np.ndarray, float]:
    """What the verdict compares: under Newton, event-driven, and the scale of the error."""
    column = found.newton.column
    both = (found.newton, found.independent)
    if column.floor and len(column.balls) == 2:
        true, hard = (np.array([r.separation_velocity]) for r in both)
        return true, hard, abs(float(true[0]))
    true, hard = (r.final_velocities for r in both)
    v = column.velocities
    return true, hard, column.impact_speed if column.floor else max(v) - min(v)


def overlapping(result: hl.Result) -> int:
    """Ball–ball contacts that share an instant with another contact, from a list of all beginnings and ends."""
    end = result.contacts.end.fillna(math.inf).values
    spans = list(zip(result.contacts.pair.values, result.contacts.begin.values, end, strict=True))
    spans = [(p, b, e) for p, b, e in spans if not (p > 0 and b > result.t_end)]
    return sum(
        any(other is not one and max(one[1], other[1]) < min(one[2], other[2]) for other in spans)
        for one in spans
        if one[0] > 0
    )


def check(found: hl.Comparison) -> None:
    answer, sentence = found.verdict
    outcomes = [hl.OUTCOMES[r.outcome_code] for r in (found.newton, found.independent)]
    true, hard, scale = velocities(found)
    assert sentence.startswith(
        {"yes": "Yes: ", "no": "No: ", "by luck": "Only by luck: ", "undecided": "No verdict: "}[answer]
    )
    assert (
        sentence.endswith(".") and "nan" not in sentence and "inf " not in sentence and "\n" not in sentence
    )
    one_ball = len(found.newton.column.balls) == 1
    if answer == "undecided":
        assert set(outcomes) & {"unresolved", "invalid", "never_lands"} or (
            outcomes == ["no_contact"] * 2 and not one_ball
        )
        return
    assert not set(outcomes) & {"unresolved", "invalid", "never_lands"}
    n = found.newton.n_contacts
    overlap = overlapping(found.newton)
    if answer in ("yes", "by luck"):
        assert set(outcomes) == {"ok"} or (one_ball and set(outcomes) <= {"ok", "no_contact"})
        error = np.abs(hard - true).max() / scale if (hard != true).any() else 0.0
        assert error <= 0.01
        assert (overlap > 0) == (answer == "by luck")
        stated = re.search(r"right to ([\d.e-]+) %\.$", sentence)
        assert error <= float(stated[1]) / 100.0 <= max(2.0 * error, 1.0001e-5)
    elif "contact never ends" in sentence:
        assert outcomes[0] == "at_rest"
    elif "finite time" in sentence:
        assert outcomes[1] in ("collapse", "at_rest") and outcomes[0] != "at_rest"
    elif "do not" in sentence or "but not under" in sentence:
        assert (n == 0) != (found.independent.n_contacts == 0)
    elif "before the balls part" in sentence:
        assert np.isnan(true).any() or np.isnan(hard).any()
    else:
        said = re.search(r"gives (\S+) m/s instead of (\S+) m/s\.$", sentence)
        worst = int(np.argmax(np.abs(hard - true)))
        assert said[1] != said[2]
        assert value(said[1]) == pytest.approx(hard[worst], rel=5e-3, abs=1e-300)
        assert value(said[2]) == pytest.approx(true[worst], rel=5e-3, abs=1e-300)
        assert abs(hard[worst] - true[worst]) > 0.01 * scale
        assert "the final velocity" not in sentence or f"of ball {worst + 1} " in sentence
    check_course(sentence, overlap, n)


def check_course(sentence: str, overlap: int, n: int) -> None:
    """How many contacts happen while another lasts."""
    if "while another contact lasts" in sentence:
        said = re.search(
            r": (the|both|all (\d+)|(\d+) of (\d+)) contacts? of the balls happens? while", sentence
        )
        counts = {"the": (1, 1), "both": (2, 2)}.get(said[1])
        counts = counts or ((int(said[2]),) * 2 if said[2] else (int(said[3]), int(said[4])))
        assert counts == (overlap, n)
    if "one contact follows the other" in sentence:
        assert overlap == 0 and n > 0


@draws(150)
@given(scenarios)
def test_the_sentence_agrees_with_the_numbers(column):
    found = hl.compare(column)
    event(found.verdict.answer)
    event(re.sub(r"[\d−.e]+", "#", found.verdict.sentence))
    check(found)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.5, 0.1, 0.02, 3e-3, 1e-3])
@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-4, 5e-4, 5e-3, 0.1, 10.0])
def test_the_paper_over_gap_and_restitution(restitution, gap):
    check(hl.compare(hl.Column.paper(restitution, gap)))


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_known_answers(name):
    law = law_of(name, 0.9, 3.0)
    answers = {
        "one ball": hl.Column([BALL], [], 0.5, law),
        "far apart": hl.Column([BALL] * 2, 0.05, 0.5, law),
        "touching": falling([1.0, 0.1], 0.0, law),
        "two that meet head-on": hl.Column.cradle([BALL] * 2, [1.0, -1.0], law, 1e-3),
    }
    wanted = {"one ball": "yes", "far apart": "yes", "touching": "no", "two that meet head-on": "yes"}
    assert {case: hl.compare(column).verdict.answer for case, column in answers.items()} == wanted
    for column in answers.values():
        check(hl.compare(column))


def test_a_collapse_is_no():
    """Below ε = 7 − 4√3 one ball between two that close in collides for ever."""
    found = hl.compare(hl.Column.cradle([BALL] * 3, [1.0, 0.0, -1.0], law_of("linear", 0.05), 1e-3))
    assert found.independent.outcome.startswith("inelastic collapse")
    assert found.verdict == ("no", "No: event-driven ends in an inelastic collapse, infinitely many collisions in a "
                             "finite time, Newton’s equations do not.")  # fmt: skip
    check(found)


def test_balls_that_stay_where_they_land():
    found = hl.compare(hl.Column.paper(3e-3))
    assert found.newton.outcome.startswith("at rest")
    assert found.verdict.answer == "no" and "a contact never ends" in found.verdict.sentence


def test_a_common_velocity_changes_no_verdict_of_a_cradle():
    """One inertial frame is as good as another."""
    law = law_of("linear", 0.9)
    sentences = set()
    for shift in (0.0, 100.0):
        found = hl.compare(hl.Column.cradle([BALL] * 3, [1.0 + shift, shift, shift], law, 0.0))
        sentences.add(found.verdict.answer)
        check(found)
    assert sentences == {"no"}
