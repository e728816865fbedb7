"""Columns are immutable values: replace makes new ones, and equal ones have equal hashes and solutions."""

import copy
import math
import pickle
from dataclasses import FrozenInstanceError, fields

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, free_columns, law_of

PAPER = hl.Column.paper()
CRADLE = hl.Column.cradle([hl.Ball(0.01, mass=0.1)] * 3, [1.0, 0.0, 0.0], law_of("linear", 0.9), 1e-4)
LINEAR = law_of("linear", 0.5)
BALL = hl.Ball(0.05, density=840.0)


# ---- immutability ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [field.name for field in fields(hl.Column)])
def test_a_column_does_not_change(name):
    """Its contacts are cached, so its attributes must not change."""
    with pytest.raises(FrozenInstanceError):
        setattr(PAPER, name, getattr(PAPER, name))
    with pytest.raises(FrozenInstanceError):
        delattr(PAPER, name)
    assert not hasattr(getattr(PAPER, name), "append")


def test_a_result_does_not_change():
    result = hl.newton(PAPER)
    for name in ("column", "model", "method", "until", "options"):
        with pytest.raises(FrozenInstanceError):
            setattr(result, name, None)


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_a_law_does_not_change(name):
    law = law_of(name, 0.5)
    for parameter in law.parameters:
        with pytest.raises(AttributeError, match=f"{parameter}: a law is immutable"):
            setattr(law, parameter, 1.0)
        with pytest.raises(TypeError):
            law.parameters[parameter] = 1.0
    with pytest.raises(AttributeError, match="parameters: a law is immutable"):
        law.parameters = {}
    with pytest.raises(AttributeError, match="parameters: a law is immutable"):
        del law.parameters
    assert law == law_of(name, 0.5) and hash(law) == hash(law_of(name, 0.5))


@pytest.mark.parametrize(
    ("base", "instead"),
    [
        (hl.Law, "Add a law"),
        *((law, "Add a law") for law in hl.LAWS.values()),
        *((hl.Contact, "Law.between"), (hl.Ball, "function"), (type(hl.FLOOR), "hl.FLOOR")),
        *((hl.Column, "function"), (hl.ParticleSystem, "function"), (hl.MovingWall, "Add a boundary")),
        *((hl.RandomKicks, "ParticleSystem.replace"), (hl.Andersen, "ParticleSystem.replace")),
    ],
)
def test_a_class_that_solvers_would_ignore_is_refused(base, instead):
    """When it is defined: the core computes with the numbers of a law, a wall or a box, not with its methods."""
    with pytest.raises(TypeError, match=rf"^Mine: got a subclass of {base.__name__}, .*; .*{instead}"):
        type("Mine", (base,), {"force": lambda self, compression, rate: 0.0})


@pytest.mark.parametrize("name", ["force", "stiffness", "law", "core"])
def test_a_contact_does_not_change(name):
    contact = law_of("linear", 0.5).between(hl.Ball(0.01, density=2500.0))
    with pytest.raises(AttributeError, match=f"{name}: a contact is immutable"):
        setattr(contact, name, None)


def test_the_floor_does_not_change():
    with pytest.raises(AttributeError):
        hl.FLOOR.mass = 1.0
    with pytest.raises(AttributeError):
        hl.FLOOR.colour = "green"
    assert copy.deepcopy(hl.FLOOR) is copy.copy(hl.FLOOR) is hl.FLOOR


def test_lists_that_made_a_column_are_not_kept():
    balls, gaps, velocities, laws = [BALL] * 2, [1e-3], [0.0, 0.0], [LINEAR] * 2
    column = hl.Column(balls, gaps, 1.0, laws, velocities)
    same = hl.Column(balls, gaps, 1.0, laws, velocities)
    balls.append(BALL)
    gaps[0] = velocities[0] = 7.0
    laws[0] = law_of("linear", 0.9)
    assert column == same and column.gaps == (1e-3,) and column.velocities == (0.0, 0.0)


# ---- equality ----------------------------------------------------------------------------------------------


@draws(60)
@given(st.one_of(columns(least=1), free_columns()))
def test_equal_columns_hash_pickle_and_copy(column):
    for other in (
        pickle.loads(pickle.dumps(column)),
        copy.copy(column),
        copy.deepcopy(column),
        column.replace(),
        eval(repr(column), vars(hl).copy()),
    ):
        assert other == column and hash(other) == hash(column)
        assert repr(other) == repr(column) and other.core is not column.core
        assert [c.effective_mass for c in other.contacts] == [c.effective_mass for c in column.contacts]
    assert len({column, column.replace()}) == 1 and column != "paper"


@draws(60)
@given(st.one_of(columns(least=1), free_columns()), st.data())
def test_columns_that_differ_in_one_value_are_not_equal(column, data):
    what = data.draw(st.sampled_from(["balls", "gaps", "law", "velocities", "height", "gravity"]))
    assume(column.floor or what not in ("height", "gravity"))
    assume(column.gaps or what != "gaps")
    changed = {
        "balls": lambda: [hl.Ball(column.balls[0].radius, mass=math.nextafter(column.balls[0].mass, 9e9)),
                          *column.balls[1:]],
        "gaps": lambda: [math.nextafter(g, 1.0) for g in column.gaps],
        "law": lambda: [law.replace(restitution=math.nextafter(law.restitution, 0.0)) for law in column.laws],
        "velocities": lambda: [v - 1e-3 for v in column.velocities],
        "height": lambda: math.nextafter(column.height, 9.0),
        "gravity": lambda: column.gravity + 1.0,
    }[what]()  # fmt: skip
    assert column.replace(**{what: changed}) != column


def test_equality_is_that_of_the_numbers():
    """0.0 and −0.0, or 1 and 1.0, make equal columns although they print differently."""
    still = hl.Column([BALL] * 2, [0.0], 1, LINEAR, velocities=[0, 0.0])
    for other in (
        hl.Column([BALL] * 2, [-0.0], 1.0, LINEAR, velocities=-0.0),
        hl.Column((BALL, BALL), 0, 1.0, (LINEAR, LINEAR)),
    ):
        assert other == still and hash(other) == hash(still)
    left, other = hl.Ball(1, mass=2), hl.Ball(1.0, mass=2.0)
    assert left == other and hash(left) == hash(other)
    moving = hl.Column.cradle([BALL] * 2, [1.0, 0.0], LINEAR)
    assert moving != hl.Column([BALL] * 2, 0.0, moving.height, LINEAR, velocities=[-1.0, 0.0], gravity=0.0)
    assert still != repr(still)


# ---- replace -----------------------------------------------------------------------------------------------


def test_another_gravity_is_another_column():
    """Replacing gravity changes the physics: on the moon the impact is slower."""
    hl.newton(PAPER)
    moon = PAPER.replace(gravity=1.62)
    assert moon.gravity == 1.62 and PAPER.gravity == 9.81
    assert moon == hl.Column.paper(gravity=1.62)
    assert hl.newton(moon).relative_velocity == hl.newton(hl.Column.paper(gravity=1.62)).relative_velocity
    assert hl.newton(moon).relative_velocity != hl.newton(PAPER).relative_velocity


def test_every_part_can_be_replaced():
    law = law_of("viscoelastic", 0.8)
    changed = PAPER.replace(balls=[BALL] * 2, gaps=1e-3, height=2.0, law=law, velocities=-1.0, gravity=1.0)
    assert changed == hl.Column([BALL] * 2, 1e-3, 2.0, law, -1.0, 1.0)
    replaced = PAPER.replace(law=[PAPER.laws[0], LINEAR])
    assert replaced.laws == (PAPER.laws[0], LINEAR) and replaced.replace(gaps=0.0).laws == replaced.laws


def test_shared_values_fit_any_number_of_balls():
    assert PAPER.replace(balls=[BALL] * 4) == hl.Column([BALL] * 4, 1e-4, 0.6, PAPER.laws[0])
    assert PAPER.replace(balls=[BALL]) == hl.Column([BALL], [], 0.6, PAPER.laws[0])
    uneven = hl.Column([BALL] * 3, [1e-4, 2e-4], 1.0, LINEAR)
    with pytest.raises(ValueError, match="gaps: got 2 values, must be 3"):
        uneven.replace(balls=[BALL] * 4)


def test_replace_checks_what_the_column_checks():
    with pytest.raises(ValueError, match="gravity: got -1, must be >= 0"):
        PAPER.replace(gravity=-1.0)
    with pytest.raises(ValueError, match=r"height: got 0\.1, must be > 0\.1"):
        PAPER.replace(height=0.1)
    with pytest.raises(ValueError, match=r"gaps\[0\]: got nan"):
        PAPER.replace(gaps=[math.nan])
    with pytest.raises(TypeError, match="radius_ratio"):
        PAPER.replace(radius_ratio=3.0)


def test_cradles_are_replaced_by_cradles():
    other = CRADLE.replace(velocities=[2.0, 0.0, 0.0])
    assert not other.floor and other.laws == CRADLE.laws and other.velocities == (2.0, 0.0, 0.0)
    assert other == hl.Column.cradle(CRADLE.balls, [2.0, 0.0, 0.0], CRADLE.laws[0], 1e-4)
    for name in ("height", "gravity"):
        with pytest.raises(ValueError, match=f"{name}: got 9.81, must be left out for a cradle"):
            CRADLE.replace(**{name: 9.81})


# ---- masses ------------------------------------------------------------------------------------------------


@draws(50)
@given(st.floats(1e-3, 1.0), st.floats(1.0, 2e4))
def test_a_ball_weighs_what_it_weighs_in_a_sweep(radius, density):
    """A map over the density is bit-identical to the map over the masses."""
    ball = hl.Ball(radius, density=density)
    column = hl.Column([ball, ball], 1e-4, radius + 0.5, LINEAR)
    by_density = hl.sweep(column, density=[density])
    by_mass = hl.sweep(column, mass_1=[ball.mass], mass_2=ball.mass)
    assert by_density.relative_velocity.values.tobytes() == by_mass.relative_velocity.values.tobytes()
