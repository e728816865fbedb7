"""Properties of every law and column: forces, energy, momentum, mirror symmetry, time reversal, scaling."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, dimension, draws, free_columns, law_of, laws, log_floats

elastic = laws(restitution=st.just(1.0))


def until_of(column: hl.Column) -> float:
    """A time long enough for the contacts of one fall: several durations of the slowest contact."""
    speed = max(column.impact_speed, 0.1)
    return 4.0 * sum(c.duration(speed) for c in column.contacts) + sum(column.gaps) / speed


def masses_of(column: hl.Column) -> np.ndarray:
    return np.array([b.mass for b in column.balls])


def dense_times(result: hl.Result, until: float) -> np.ndarray:
    marks = np.concatenate([result.contacts.begin.values, result.contacts.end.values])
    marks = marks[np.isfinite(marks) & (marks <= until)]
    return np.unique(np.concatenate([np.linspace(0.0, until, 400), marks]))


@draws(60)
@given(columns())
def test_never_attractive_and_energy_never_rises(column):
    until = until_of(column)
    result = hl.newton(column, until=until)
    t = result.trajectory(dense_times(result, until))
    assert (t.force.values >= 0.0).all()
    assert t.force.values.max() > 0.0
    energy = (t.kinetic_energy + t.potential_energy + t.contact_energy).values
    scale = float(np.max(t.kinetic_energy + np.abs(t.potential_energy)))
    assert np.diff(energy).max() < 1e-11 * scale
    assert np.diff(t.dissipated_energy.values).min() > -1e-11 * scale
    # No force where the balls do not touch.
    radii = np.array([b.radius for b in column.balls])
    below = np.concatenate([[0.0], radii[:-1]])
    z = t.position.values
    gap = np.diff(z, axis=1, prepend=0.0) - radii - below
    assert (t.force.values[gap > 1e-12] == 0.0).all()


@draws(25)
@given(columns())
def test_momentum_changes_by_the_impulse_of_the_floor_and_the_weight(column):
    """For each ball m dv = ∫ (F below − F above − m g) dt, by Gauss quadrature between events."""
    until = until_of(column)
    result = hl.newton(column, until=until)
    marks = np.concatenate([[0.0, until], result.contacts.begin.values, result.contacts.end.values])
    marks = np.unique(marks[(marks >= 0.0) & (marks <= until)])
    # Between events t = a + (b − a) x² (3 − 2x): a force may start and end like a square root.
    points, gauss = np.polynomial.legendre.leggauss(12)
    x = ((np.arange(32)[:, None] + 0.5 * (1.0 + points)) / 32).ravel()
    length = np.diff(marks)[:, None]
    times = (marks[:-1, None] + length * x * x * (3.0 - 2.0 * x)).ravel()
    weights = (length * 6.0 * x * (1.0 - x) * np.tile(gauss / 64, 32)).ravel()
    impulse = weights @ result.trajectory(times).force.values
    v = result.trajectory(marks[[0, -1]]).velocity.values
    change = masses_of(column) * (v[1] - v[0] + column.gravity * (marks[-1] - marks[0]))
    scale = np.abs(impulse).max()
    assert change == pytest.approx(impulse - np.append(impulse[1:], 0.0), abs=1e-8 * scale)


@draws(80)
@given(free_columns())
def test_free_column_keeps_momentum(column):
    until = until_of(column)
    result = hl.newton(column, until=until)
    m = masses_of(column)
    v = result.trajectory(dense_times(result, until)).velocity.values
    scale = m.sum() * np.abs(column.velocities).max()
    assert np.abs(v @ m - column.velocities @ m).max() < 1e-12 * scale


@draws(80)
@given(free_columns())
def test_mirror_image_of_a_free_column(column):
    """Reversing the order of the balls and the signs gives the mirrored motion, contact by contact."""
    until = until_of(column)
    mirrored = hl.Column.cradle(
        column.balls[::-1], [-v for v in column.velocities[::-1]], column.laws[::-1], column.gaps[::-1]
    )
    a, b = hl.newton(column, until=until), hl.newton(mirrored, until=until)
    scale = np.abs(column.velocities).max()
    assert a.velocities == pytest.approx(-b.velocities[::-1], abs=1e-9 * scale)
    assert a.n_contacts == b.n_contacts
    n = len(column.balls)
    ends = [np.sort(r.contacts.end.values) for r in (a, b)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-6, nan_ok=True)
    counts = [[int((r.contacts.pair == j).sum()) for j in range(1, n)] for r in (a, b)]
    assert counts[0] == counts[1][::-1]


@draws(80)
@given(free_columns(law=elastic))
def test_time_reversal_when_elastic(column):
    """Run, reverse all velocities and run for the same time: the initial state is reached again."""
    until = until_of(column)
    result = hl.newton(column, until=until)
    z, v = result.positions, result.velocities
    radii = np.array([b.radius for b in column.balls])
    gaps = np.diff(z) - radii[1:] - radii[:-1]
    # A state within a contact cannot start a column, because gaps must not be negative.
    assume((gaps > 1e-9).all() and any(b > a for a, b in itertools.pairwise(v)))
    back = hl.newton(hl.Column.cradle(column.balls, -v, column.laws, gaps), until=until)
    scale = np.abs(column.velocities).max()
    assert back.velocities == pytest.approx([-v for v in column.velocities], abs=1e-6 * scale)
    returned = np.diff(back.positions) - radii[1:] - radii[:-1]
    assert returned == pytest.approx(column.gaps, abs=1e-6 * scale * until + 1e-12)
    kinetic = 0.5 * masses_of(column) @ (back.velocities**2)
    assert kinetic == pytest.approx(0.5 * masses_of(column) @ np.square(column.velocities), rel=1e-10)


def in_other_units(column: hl.Column, mass: float, length: float, time: float) -> hl.Column:
    def convert(value, unit):
        m, d, t = dimension(unit)
        return value * mass**m * length**d * time**t

    converted = []
    for law in column.laws:
        record = law.record
        units = {p["name"]: p["unit"] for group in (record["common"], *record["alternatives"]) for p in group}
        converted.append(type(law)(**{k: convert(v, units[k]) for k, v in law.parameters.items()}))
    return hl.Column(
        [hl.Ball(b.radius * length, mass=b.mass * mass) for b in column.balls],
        [g * length for g in column.gaps],
        column.height * length,
        converted,
        [convert(v, "m/s") for v in column.velocities],
        column.gravity * length / time**2,
    )


@draws(60)
@given(columns(), log_floats(0.01, 100.0), log_floats(0.1, 10.0), log_floats(0.1, 10.0))
def test_scaling(column, mass, length, time):
    """Equal dimensionless groups give equal dimensionless results."""
    scaled = in_other_units(column, mass, length, time)
    until = until_of(column)
    a, b = hl.newton(column, until=until), hl.newton(scaled, until=until * time)
    unit = length / time
    assert a.n_contacts == b.n_contacts
    # Touching balls that meet many times magnify the rounding of positions.
    near = hl.newton(column.replace(height=column.height * (1.0 + 1e-13)), until=until)
    magnified = float(np.abs(near.velocities - a.velocities).max(initial=0.0))
    assert b.velocities / unit == pytest.approx(
        a.velocities, abs=1e-8 * column.impact_speed + 100.0 * magnified
    )
    assert b.contacts.pair.values.tolist() == a.contacts.pair.values.tolist()
    assert b.contacts.begin.values / time == pytest.approx(a.contacts.begin.values, abs=1e-7 * until)
    for name in ("effective_restitution", "restitution_ratio"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), abs=1e-8, nan_ok=True)


@draws(80)
@given(
    st.sampled_from(sorted(hl.LAWS)),
    st.floats(0.3, 1.0),
    log_floats(3.0, 20.0),
    st.floats(1.05, 5.0),
    log_floats(0.3, 3.0),
)
def test_independent_collisions_where_they_should_hold(name, restitution, ratio, room, speed):
    """ε_eff = ε without gravity if the floor contact is over before the balls meet, with ε at both speeds.

    For R1/R2 >= 3 the lower ball continues upwards and does not touch the floor during the second contact.
    """
    balls = [hl.Ball(0.01 * ratio, density=1000.0), hl.Ball(0.01, density=1000.0)]
    contacts = [law_of(name, restitution, at) for at in (speed, (1.0 + restitution) * speed)]
    gap = room * speed * contacts[0].between(balls[0]).duration(speed)
    column = hl.Column(balls, [gap], balls[0].radius, contacts, velocities=-speed, gravity=0.0)
    result = hl.newton(column)
    assert result.n_contacts == 1
    assert result.relative_velocity == pytest.approx(restitution * (1.0 + restitution) * speed, rel=1e-9)
    assert result.effective_restitution == pytest.approx(restitution, rel=1e-9)
    assert hl.independent(column).effective_restitution == pytest.approx(restitution, rel=1e-10)


@draws(60)
@given(columns(most=2, law=laws(restitution=st.floats(0.3, 1.0))))
def test_separation_velocity_within_what_the_energy_allows(column):
    """The pair does not approach, and the relative motion has at most the energy of the impact."""
    result = hl.newton(column)
    assume(result.outcome == "ok" and not math.isnan(result.separation_velocity))
    m1, m2 = masses_of(column)
    energy = 0.5 * (m1 + m2) * column.impact_speed**2 + m2 * column.gravity * column.gaps[0]
    effective = m1 * m2 / (m1 + m2)
    assert 0.0 <= result.separation_velocity <= 1.001 * math.sqrt(2.0 * energy / effective)
