"""The comparison of the event-driven model with Newton's equations: the verdict agrees with the numbers."""

import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, falling, free_columns, law_of, laws, log_floats, output_of

BALL = hl.Ball(0.02, mass=0.1)

#: From perfectly inelastic to elastic.
restitutions = st.one_of(st.floats(0.05, 1.0), st.sampled_from([1e-3, 0.01, 0.1, 0.99, 1.0]))

scenarios = st.one_of(
    columns(law=laws(restitutions), least=1, most=6),
    columns(law=laws(restitutions), least=2, most=2),
    free_columns(law=laws(restitutions), least=2, most=6),
)


@st.composite
def any_column(draw: st.DrawFn) -> hl.Column:
    """Two to five balls of any masses, gaps and stiffness, some of them equal."""
    n = draw(st.integers(2, 5))
    alike = draw(st.booleans())

    def for_each(values: st.SearchStrategy[float], n: int) -> list[float]:
        return [draw(values)] * n if alike else [draw(values) for _ in range(n)]

    far = log_floats(1e-3, 0.5)
    radii, densities = for_each(log_floats(3e-3, 0.1), n), for_each(log_floats(300.0, 9000.0), n)
    gaps = for_each(st.one_of(far, far, log_floats(1e-6, 1e-3), st.just(0.0)), n - 1)
    restitution = st.one_of(
        st.floats(0.5, 1.0), st.floats(0.02, 1.0), st.sampled_from([0.02, 0.1, 0.5, 0.9, 1.0])
    )
    stiffness = st.one_of(log_floats(1e3, 1e9), log_floats(1e7, 1e9))
    law = hl.LinearDashpot(stiffness=draw(stiffness), restitution=draw(restitution))
    balls = [hl.Ball(r, density=d) for r, d in zip(radii, densities, strict=True)]
    return hl.Column(balls, gaps, radii[0] + draw(log_floats(1e-2, 1.0)), law)


def value(text: str) -> float:
    return float(text.replace("−", "-"))


def last_contacts(result: hl.Result) -> tuple[np.ndarray, float, int]:
    """End of each ball's last contact before the second floor contact (NaN: none), the time of the latter (infinity:
    none), and the number of contacts up to then."""
    pair, begin, end = result.contact_times
    floor = np.flatnonzero(pair == 0)
    again, radius = math.inf, result.column.balls[0].radius
    for first, then in itertools.pairwise(floor):
        middle = 0.5 * (end[first] + begin[then])  # within a contact the gap stays closed
        opened = result.model == "independent" or result.trajectory(middle).position.values[0, 0] > radius
        if opened and math.isinf(again):
            again, floor_again = begin[then], then
    counts = np.isfinite(end)
    if math.isfinite(again):
        counts &= (pair == 0) & (np.arange(len(pair)) < floor_again) | (pair > 0) & (begin <= again)
        if result.model == "independent":
            counts &= np.arange(len(pair)) < floor_again
    balls = range(len(result.column.balls))
    ends = [end[counts & ((pair == j) | (pair == j + 1))].max(initial=-math.inf) for j in balls]
    return np.array([x if math.isfinite(x) else math.nan for x in ends]), again, np.count_nonzero(counts)


def at_one_instant(comparison: hl.Comparison) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Velocities of the balls in both models at a common instant after the sequence, and by how much later each ball's
    last contact ended in the event-driven model. None if there is no such instant."""
    column, both = comparison.newton.column, (comparison.newton, comparison.independent)
    (ends, again, n), (hard_ends, hard_again, hard_n) = map(last_contacts, both)
    if np.isnan(ends).all() or np.isnan(hard_ends).all():
        return None
    over = max(np.nanmax(ends), np.nanmax(hard_ends))
    solvers = (hl.newton, hl.independent)
    begins = [solve(column, until=over + abs(over) + 1e-5).contact_times[1] for solve in solvers]
    next_one = min(again, hard_again, *(b[b > over].min(initial=2.0 * over + 1e-5) for b in begins))
    if not next_one > over * (1.0 + 1e-6):
        return None
    instant = 0.5 * (over + next_one)
    runs = [solve(column, until=instant) for solve in solvers]
    if [np.count_nonzero(run.contact_times[2] <= instant) for run in runs] != [n, hard_n]:
        return None  # several contacts at one instant, or one that has not ended
    if any(np.isnan(run.contact_times[2]).any() for run in runs):
        return None
    true, hard = (run.trajectory(instant).velocity.values[0] for run in runs)
    return true, hard, np.nan_to_num(hard_ends - ends)


def compared(comparison: hl.Comparison) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Velocities that the verdict compares (Newton, event-driven), from :func:`at_one_instant`, and the error scale."""
    column = comparison.newton.column
    if column.floor and len(column.balls) == 2:
        true, hard = (np.array([r.separation_velocity]) for r in (comparison.newton, comparison.independent))
        return true, hard, abs(float(true[0]))
    read = at_one_instant(comparison)
    if read is None:
        return None
    true, hard, delay = read
    v = column.velocities
    return true, hard - column.gravity * delay, column.impact_speed if column.floor else max(v) - min(v)


def overlapping(result: hl.Result) -> int:
    """Number of ball–ball contacts that overlap another contact in time, from all begins and ends."""
    end = result.contacts.end.fillna(math.inf).values
    spans = list(zip(result.contacts.pair.values, result.contacts.begin.values, end, strict=True))
    of_balls = sorted((span for span in spans if span[0] > 0), key=lambda span: span[1])[: result.n_contacts]
    return sum(
        any(other is not span and max(span[1], other[1]) < min(span[2], other[2]) for other in spans)
        for span in of_balls
    )


def check(comparison: hl.Comparison) -> None:
    answer, sentence = comparison.verdict
    outcomes = [hl.OUTCOMES[r.outcome_code] for r in (comparison.newton, comparison.independent)]
    first = {"yes": "Yes: ", "no": "No: ", "by luck": "Only by luck: ", "undecided": "No verdict: "}
    assert sentence.startswith(first[answer]) and sentence.endswith(".")
    assert not any(bad in sentence for bad in ("nan", "inf ", "\n"))
    one_ball = len(comparison.newton.column.balls) == 1
    if answer == "undecided":
        assert set(outcomes) & {"unresolved", "invalid", "never_lands", "too_deep"} or (
            outcomes == ["no_contact"] * 2 and not one_ball
        )
        return
    assert not set(outcomes) & {"unresolved", "invalid", "never_lands", "too_deep"}
    n = comparison.newton.n_contacts
    overlap = overlapping(comparison.newton)
    if answer in ("yes", "by luck"):
        # A single contact of the upper balls may be before or after the second floor contact.
        met = {"ok", "no_contact"} if one_ball or "follows the second floor contact" in sentence else {"ok"}
        assert set(outcomes) <= met
        assert (overlap > 0) == (answer == "by luck")
        stated = re.search(r"right to ([\d.e-]+) %\.$", sentence)
        assert float(stated[1]) <= 1.0
    elif "contact never ends" in sentence:
        assert outcomes[0] == "at_rest"
    elif "finite time" in sentence:
        assert outcomes[1] in ("collapse", "at_rest") and outcomes[0] != "at_rest"
    elif "but not" in sentence:
        assert (n == 0) != (comparison.independent.n_contacts == 0)
        assert ("before the second floor contact" in sentence) is comparison.newton.column.floor
    elif "before the balls separate" in sentence:
        assert np.isnan([r.separation_velocity for r in (comparison.newton, comparison.independent)]).any()
    else:
        said = re.search(r" is (\S+) m/s instead of (\S+) m/s\.$", sentence)
        assert said[1] != said[2]
    check_numbers(comparison)
    check_course(sentence, overlap, n)


def check_numbers(comparison: hl.Comparison) -> None:
    """The answer, the error and the velocities are those of :func:`compared`."""
    answer, sentence = comparison.verdict
    stated = re.search(r"right to ([\d.e-]+) %\.$", sentence)
    said = re.search(r" is (\S+) m/s instead of (\S+) m/s\.$", sentence)
    read = compared(comparison)
    if not (stated or said) or read is None or "follows the second floor contact" in sentence:
        return
    true, hard, scale = read
    error = np.abs(hard - true).max() / scale if (hard != true).any() else 0.0
    if stated:
        assert answer in ("yes", "by luck") and error <= float(stated[1]) / 100.0 + 1e-9
        assert float(stated[1]) / 100.0 <= max(2.0 * error, 1.0001e-5)
        return
    assert answer == "no" and error > 0.01 - 1e-9
    ball = re.search(r"final velocity of ball (\d)", sentence)
    worst = int(ball[1]) - 1 if ball else 0
    assert abs(hard - true)[worst] == pytest.approx(error * scale, rel=1e-6)
    shown = float(comparison.newton.final_velocities[worst]) if ball else true[worst]
    assert value(said[2]) == pytest.approx(shown, rel=5e-3, abs=1e-300)
    assert value(said[1]) == pytest.approx(shown + hard[worst] - true[worst], rel=5e-3, abs=1e-300)


def check_course(sentence: str, overlap: int, n: int) -> None:
    """The number of contacts that overlap another one agrees."""
    if "another contact in time" in sentence:
        said = re.search(r": (the|both|all (\d+)|(\d+) of (\d+)) ball–ball contacts? overlaps? ", sentence)
        counts = {"the": (1, 1), "both": (2, 2)}.get(said[1])
        counts = counts or ((int(said[2]),) * 2 if said[2] else (int(said[3]), int(said[4])))
        assert counts == (overlap, n)
    if "no contacts overlap in time" in sentence:
        assert overlap == 0 and n > 0


@draws(40)
@given(scenarios)
def test_the_sentence_agrees_with_the_numbers(column):
    comparison = hl.compare(column)
    event(comparison.verdict.answer)
    event(re.sub(r"[\d−.e]+", "#", comparison.verdict.sentence))
    check(comparison)


@draws(150)
@given(any_column())
def test_a_second_definition_gives_the_same_verdict(column):
    """A comparison at one instant gives the same verdict as one at the same stage of the sequence, except for the
    effect of gravity during a delay. If all balls leave upwards and rise equally high, the verdict is not No."""
    comparison = hl.compare(column)
    answer, sentence = comparison.verdict
    event(answer)
    check(comparison)
    by_numbers = "right to" in sentence or "instead of" in sentence
    read = at_one_instant(comparison) if by_numbers else None
    if read is not None and len(column.balls) > 2 and "second floor contact" not in sentence:
        true, hard, delay = read
        falls = column.gravity * np.abs(delay).max() / column.impact_speed
        error = np.abs(hard - true).max() / column.impact_speed
        event(f"second definition: {answer}")
        assert error > 0.01 - falls - 1e-9 if answer == "no" else error < 0.01 + falls + 1e-9
    if by_numbers and answer == "no" and len(column.balls) > 2 and overlapping(comparison.newton) == 0:
        heights, hard_heights = comparison.newton.rebound_heights, comparison.independent.rebound_heights
        if np.isfinite(heights).all() and (comparison.newton.final_velocities > 0.0).all():
            event("second definition: heights")
            highest = column.impact_speed**2 / (2.0 * column.gravity)
            assert np.abs(heights - hard_heights).max() > 1e-3 * highest


def three_balls_far_apart() -> hl.Column:
    balls = [hl.Ball(0.02, mass=0.0027), hl.Ball(0.0335, mass=0.0577), hl.Ball(0.0335, mass=0.0577)]
    return hl.Column(balls, [0.05, 0.3], 0.3, hl.LinearDashpot(stiffness=1e9, restitution=0.9))


def test_the_second_floor_contact_is_on_neither_side():
    """A table tennis ball between the floor and tennis balls: stiff contacts that do not overlap, and rebound heights
    that agree to 0.02 %."""
    comparison = hl.compare(three_balls_far_apart())
    assert comparison.verdict.answer == "yes" and "right to 0.005 %" in comparison.verdict.sentence
    assert comparison.independent.final_velocities == pytest.approx(
        comparison.newton.final_velocities, rel=1e-3
    )
    check(comparison)


@pytest.mark.parametrize(
    ("radii", "density", "gaps", "stiffness", "restitution", "height"),
    [
        ([0.0319] * 3, 667.0, [3.95e-3, 3.34e-4], 9.6e6, 0.1, 0.110),
        ([4.4e-3] * 4, 406.0, [1.144e-4, 6.367e-5, 2.293e-4], 4.806e6, 0.6053, 0.6641),
    ],
)
def test_a_contact_of_the_upper_balls_may_come_after_the_floor(
    radii, density, gaps, stiffness, restitution, height
):
    """The second ball hits the third just before or just after the second floor contact. The later motion is the same,
    and so is the verdict."""
    law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    column = hl.Column([hl.Ball(r, density=density) for r in radii], gaps, height, law)
    comparison = hl.compare(column)
    assert comparison.newton.n_contacts != comparison.independent.n_contacts
    assert comparison.verdict.answer == "yes"
    assert "under one model the last one follows the second floor contact" in comparison.verdict.sentence
    fewer, more = sorted((comparison.newton, comparison.independent), key=lambda result: result.n_contacts)
    at = fewer.trajectory(last_contacts(fewer)[1] * (1.0 - 1e-9))
    apart = np.diff(at.position.values[0, 1:]) - 2.0 * radii[0]
    upper = hl.Column.cradle(column.balls[1:], at.velocity.values[0, 1:], law, apart)
    solve = hl.newton if fewer.model == "newton" else hl.independent
    end = solve(upper).contact_times[2][0]
    after = solve(upper, until=end).trajectory(end).velocity.values[0]
    assert np.diff(after) == pytest.approx(np.diff(more.final_velocities[1:]), abs=0.01 * column.impact_speed)


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


def test_a_collapse_gives_the_verdict_no():
    """Below ε = 7 − 4√3 a ball between two approaching balls collides infinitely often."""
    comparison = hl.compare(hl.Column.cradle([BALL] * 3, [1.0, 0.0, -1.0], law_of("linear", 0.05), 1e-3))
    assert comparison.independent.outcome.startswith("inelastic collapse")
    assert comparison.verdict == (
        "no",
        "No: the event-driven sequence ends in an inelastic collapse, infinitely many collisions in a finite time; "
        "that of Newton’s equations does not.",
    )
    check(comparison)


def test_balls_that_stay_where_they_land():
    comparison = hl.compare(hl.Column.paper(3e-3))
    assert comparison.newton.outcome.startswith("at rest")
    assert comparison.verdict.answer == "no" and "a contact never ends" in comparison.verdict.sentence


def test_a_common_velocity_changes_no_verdict_of_a_cradle():
    """The verdict does not depend on the inertial frame."""
    law = law_of("linear", 0.9)
    sentences = set()
    for shift in (0.0, 100.0):
        comparison = hl.compare(hl.Column.cradle([BALL] * 3, [1.0 + shift, shift, shift], law, 0.0))
        sentences.add(comparison.verdict.answer)
        check(comparison)
    assert sentences == {"no"}


@pytest.mark.slow
def test_a_verdict_computes_no_more_collisions_than_it_needs(tmp_path):
    """Six viscoelastic balls whose upper ones collide 30000 times after the sequence: each is computed about once. The
    mechanical energies of the balls, which the page shows, are together that of the column."""
    collisions, answer, difference = output_of("column/comparison_work.cpp", tmp_path).split()
    assert answer == "no" and int(collisions) < 200_000 and float(difference) < 1e-11
