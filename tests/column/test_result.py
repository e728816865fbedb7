"""Columns and results as Python objects: layout, units, sampling at any time, equality, bad input."""

import copy
import io
import math
import multiprocessing
import operator
import pickle
from concurrent.futures import ProcessPoolExecutor
from html import escape
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import columns, draws, law_of, laws, refusal, too_deep_later
from hardlimit.support import html, saving

PAPER = hl.Column.paper(0.7)
BALLS = [hl.Ball(0.05, density=840.0), hl.Ball(0.02, density=840.0)]


def three_balls(name: str = "viscoelastic") -> hl.Column:
    return hl.Column([*BALLS, hl.Ball(0.01, mass=0.002)], [1e-4, 2e-4], 0.3, law_of(name, 0.8))


def results() -> dict[str, hl.Result]:
    cradle = hl.Column.cradle([hl.Ball(0.01, mass=0.1)] * 3, [1.0, 0.0, 0.0], law_of("linear", 0.9), 1e-4)
    return {
        "exact": hl.newton(PAPER),
        "general": hl.newton(PAPER, method="general"),
        "adiabatic": hl.adiabatic(PAPER),
        "independent": hl.independent(PAPER),
        "three balls": hl.newton(three_balls()),
        "three balls, until": hl.newton(three_balls(), until=0.01),
        "cradle": hl.newton(cradle),
        "cradle, until": hl.newton(cradle, until=0.05),
    }


RESULTS = results()
every_result = pytest.mark.parametrize("kind", RESULTS)


# ---- datasets ----------------------------------------------------------------------------------------------


@every_result
def test_contacts(kind):
    result = RESULTS[kind]
    contacts = result.contacts
    assert contacts.sizes == {"contact": len(contacts.pair)}
    assert set(contacts.data_vars) == {"pair", "begin", "end"}
    assert contacts.begin.attrs["units"] == contacts.end.attrs["units"] == "s"
    assert contacts.begin.dims == contacts.end.dims == contacts.pair.dims == ("contact",)
    n = len(result.column.balls)
    assert set(contacts.pair.values) <= set(range(0 if result.column.floor else 1, n))
    assert (np.diff(contacts.begin.values) >= 0.0).all()
    assert ((contacts.end >= contacts.begin) | contacts.end.isnull()).all()
    assert result.n_contacts <= int((contacts.pair > 0).sum())
    if result.until is not None:
        assert (contacts.begin <= result.until).all()


@every_result
def test_trajectory(kind):
    result = RESULTS[kind]
    n = len(result.column.balls)
    t = result.trajectory()
    assert t.sizes["ball"] == n
    assert t.ball.values.tolist() == list(range(1, n + 1))
    assert t.pair.values.tolist() == list(range(0 if result.column.floor else 1, n))
    assert t.position.dims == t.velocity.dims == ("time", "ball")
    assert t.force.dims == ("time", "pair")
    assert t.kinetic_energy.dims == ("time",)
    units = {name: t[name].attrs["units"] for name in t.data_vars}
    energies = dict.fromkeys(
        (f"{kind}_energy" for kind in ("kinetic", "potential", "contact", "dissipated")), "J"
    )
    assert units == {"position": "m", "velocity": "m/s", "force": "N"} | energies
    assert t.time.attrs["units"] == "s"
    for name in t.data_vars:
        assert np.isfinite(t[name].values).all(), name


@every_result
def test_default_times(kind):
    """Equally spaced over the sequence, plus every begin and end, so that a plot shows each contact."""
    result = RESULTS[kind]
    times = result.default_times()
    assert (np.diff(times) > 0.0).all()
    assert len(times) >= 1001
    marks = np.concatenate([result.contacts.begin.values, result.contacts.end.values])
    marks = marks[np.isfinite(marks) & (marks <= times[-1])]
    assert np.isin(marks, times).all()
    assert (result.trajectory().time.values == times).all()
    if result.until is not None:
        assert times[-1] == result.until


@every_result
def test_positions_velocities_and_energies_belong_together(kind):
    """dz/dt is the velocity, and the kinetic energy follows from the velocities."""
    result = RESULTS[kind]
    t = result.trajectory()
    masses = np.array([b.mass for b in result.column.balls])
    assert t.kinetic_energy.values == pytest.approx(0.5 * t.velocity.values**2 @ masses, rel=1e-12)
    if kind in ("independent", "cradle, until"):
        return  # velocities jump, or the times are too far apart for finite differences
    time, z, v = t.time.values, t.position.values, t.velocity.values
    slope = np.diff(z, axis=0) / np.diff(time)[:, None]
    mean = 0.5 * (v[1:] + v[:-1])
    long = np.diff(time) > 1e-3 * np.median(np.diff(time))
    largest = np.abs(v).max()
    assert np.abs(slope - mean)[long].max() < 0.01 * largest


@pytest.mark.parametrize("kind", [kind for kind in RESULTS if kind != "adiabatic"])
def test_energy_is_accounted_for(kind):
    """Energy is conserved in every model except the adiabatic one, which neglects the reaction."""
    t = RESULTS[kind].trajectory()
    mechanical = t.kinetic_energy + t.potential_energy
    total = (mechanical + t.contact_energy + t.dissipated_energy).values
    assert total == pytest.approx(np.full(len(total), float(mechanical[0])), rel=1e-9)


@every_result
def test_trajectory_takes_any_times_in_any_order(kind):
    result = RESULTS[kind]
    last = float(np.nanmax(result.contacts.end.values))
    times = np.array([0.7 * last, 0.0, 0.3 * last, 5.0 * last, 0.3 * last])
    many = result.trajectory(times)
    assert (many.time.values == times).all()
    for i, at in enumerate(times):
        single = result.trajectory(at)
        assert single.position.values[0] == pytest.approx(many.position.values[i], abs=1e-12)
        assert single.velocity.values[0] == pytest.approx(many.velocity.values[i], abs=1e-9)
    assert many.velocity.values[2] == pytest.approx(many.velocity.values[4], abs=0.0)


@pytest.mark.parametrize("kind", ["exact", "general", "three balls"])
def test_continuity_at_the_switches(kind):
    """Positions and velocities are continuous; a force jumps at the start of a contact and is zero at its end."""
    result = RESULTS[kind]
    contacts = result.contacts
    assert contacts.pair.size > 1
    largest = result.trajectory().force.max("time").values
    v = result.column.impact_speed
    for pair, begin, end in zip(
        contacts.pair.values, contacts.begin.values, contacts.end.values, strict=True
    ):
        h = 1e-9 * (end - begin)
        for mark in (begin, end):
            if mark - h < result._core.t_first:
                continue
            around = result.trajectory([mark - h, mark, mark + h])
            assert np.ptp(around.velocity.values, axis=0).max() < 1e-7 * v
            assert np.ptp(around.position.values, axis=0).max() < 1e-7 * v * (end - begin) + 1e-15
        at_end = result.trajectory([end - h, end + h]).force.sel(pair=pair).values
        assert at_end[0] < 1e-6 * largest[pair] and at_end[1] == 0.0
        inside = result.trajectory(np.linspace(begin, end, 52)[1:-1]).force.sel(pair=pair).values
        assert (inside > 0.0).all()
        outside = result.trajectory([begin - h]).force.sel(pair=pair).values if begin > 0.0 else np.zeros(1)
        assert outside[0] == 0.0


def test_dashpot_force_jumps_at_the_first_touch():
    """F(0+) = γ V."""
    result = hl.newton(PAPER)
    wanted = PAPER.contacts[0].damping * PAPER.impact_speed
    assert float(result.trajectory([1e-15]).force[0, 0]) == pytest.approx(wanted, rel=1e-9)
    assert float(result.trajectory([-1e-15]).force[0, 0]) == 0.0


def test_force_is_that_of_the_law():
    result = RESULTS["three balls"]
    t = result.trajectory()
    radii = np.array([b.radius for b in result.column.balls])
    z, v = t.position.values, t.velocity.values
    gap = np.diff(z, axis=1, prepend=0.0) - radii - np.concatenate([[0.0], radii[:-1]])
    rate = -np.diff(v, axis=1, prepend=0.0)
    for j, contact in enumerate(result.column.contacts):
        pushed = t.force.values[:, j]
        inside = gap[:, j] < -1e-9
        wanted = contact.force(-gap[inside, j], rate[inside, j])
        assert pushed[inside] == pytest.approx(wanted, abs=1e-6 * pushed.max())


@pytest.mark.parametrize("kind", ["exact", "general", "independent", "three balls"])
def test_times_before_release_are_refused(kind):
    result = RESULTS[kind]
    first = result._core.t_first
    release = result.trajectory([first])
    assert release.position.values[0] == pytest.approx(result.column.initial_positions, rel=1e-12)
    for bad in (2.0 * first, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"times: got .*, must be (>= .*, the release|finite)$"):
            result.trajectory([0.0, bad])


def meeting_in_flight(velocities=(3.0, -3.0)) -> hl.Column:
    return PAPER.replace(velocities=velocities, gaps=0.1, height=1.0)


@draws(60)
@example(meeting_in_flight())
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=2).map(meeting_in_flight),
)
def test_until_is_not_before_the_release(column):
    """Balls that meet in flight change the time from the release to the first floor touch."""
    for solve in (hl.newton, hl.independent):
        first = solve(column)._core.t_first
        assert "the release" in refusal(lambda solve=solve, first=first: solve(column, until=1.001 * first))
        begun = solve(column, until=first)
        assert begun.positions == pytest.approx(column.initial_positions, rel=1e-9)
        assert begun.velocities == pytest.approx(column.velocities, abs=1e-9)


def test_release_of_balls_that_do_not_meet_in_flight():
    for column in (PAPER, three_balls()):
        assert hl.newton(column)._core.t_first == pytest.approx(column.release_time, rel=1e-12)


def known_for_a_while() -> dict[str, tuple[hl.Result, str]]:
    """Results that are ok, and what ends the motion soon after their sequence."""
    linear, soft = hl.LinearDashpot, hl.Viscoelastic
    heavy = [hl.Ball(0.00103, density=313.0), hl.Ball(0.0595, density=8470.0)]
    damped = [linear(stiffness=1.3e6, damping=0.0112), linear(stiffness=4.94e7, damping=778.0)]
    crowded = hl.Column(heavy, 0.0, 0.00279, damped, [-0.0554, -0.104], 0.0)
    # Its later collisions take a minute.
    slow_laws = [
        soft(youngs_modulus=5.05e9, poisson_ratio=0.15, dissipative_time=2.03e-5),
        soft(youngs_modulus=2.16e8, poisson_ratio=0.1, restitution=0.8, impact_speed=8.6),
    ]
    slower = hl.Column(heavy, 0.0, 1.91, slow_laws, [0.392, -0.403], 100.0)
    return {
        "too deep": (hl.newton(too_deep_later()), "too_deep"),
        "too many collisions": (hl.independent(crowded), "unresolved"),
        "too many slow collisions": (hl.independent(slower), ""),
    }


@pytest.mark.parametrize("kind", known_for_a_while())
def test_default_times_end_with_the_known_motion(kind):
    result, later = known_for_a_while()[kind]
    assert result.outcome == "ok"
    times = result.trajectory().time.values
    assert times[-1] > np.nanmax(np.concatenate(result.contact_times[1:]))
    if result.model == "independent":  # the margin ends before the next collision
        assert len(result._continued(times[-1]).contacts()[0]) == len(result.contact_times[0])
    if later:
        assert hl.OUTCOMES[result._solve(1.1 * times[-1] - 0.1 * times[0]).outcome] == later


def test_positions_and_velocities_are_those_at_the_end():
    result = hl.newton(PAPER)
    sample = result.trajectory([result.t_end])
    assert (result.positions == sample.position.values[0]).all()
    assert result.velocities[1] - result.velocities[0] == pytest.approx(result.relative_velocity, rel=1e-12)
    until = hl.newton(PAPER, until=0.01)
    assert (until.positions == until.trajectory([0.01]).position.values[0]).all()


def test_effective_restitution_belongs_to_two_balls_on_a_floor():
    result = hl.newton(PAPER)
    ratio = result.relative_velocity / PAPER.impact_speed
    assert result.effective_restitution == pytest.approx(
        (math.sqrt(1.0 + 4.0 * ratio) - 1.0) / 2.0, rel=1e-14
    )
    assert result.restitution_ratio == pytest.approx(result.effective_restitution / 0.7, rel=1e-15)
    separation = result.separation_velocity / PAPER.impact_speed
    at_separation = (math.sqrt(1.0 + 4.0 * separation) - 1.0) / 2.0
    assert result.effective_restitution_at_separation == pytest.approx(at_separation, rel=1e-14)
    assert result.restitution_ratio_at_separation == pytest.approx(at_separation / 0.7, rel=1e-14)
    for kind in ("three balls", "cradle"):
        assert math.isnan(RESULTS[kind].effective_restitution)
        assert math.isnan(RESULTS[kind].relative_velocity)


@every_result
def test_outcome_and_repr(kind):
    result = RESULTS[kind]
    assert result.outcome == "ok" and result.outcome_code == 0 == hl.OUTCOMES.index("ok")
    text = repr(result)
    assert text.startswith("<Result of ") and result.model in text and str(result.n_contacts) in text
    assert "ok" in text and "\n" not in text


def test_models_and_methods_name_themselves():
    models = {kind: (RESULTS[kind].model, RESULTS[kind].method) for kind in RESULTS}
    assert models["exact"][0] == models["general"][0] == "newton"
    assert models["exact"][1] == "piecewise exact"
    assert models["general"][1] != models["exact"][1]
    assert models["adiabatic"][0] == "adiabatic"
    assert models["independent"][0] == "independent"
    assert RESULTS["general"].energy_error < 1e-12
    assert math.isnan(RESULTS["independent"].energy_error)


# ---- attributes of the datasets, notebooks -----------------------------------------------------------------


@every_result
def test_datasets_have_all_attributes(kind):
    """A dataset contains all that is needed to compute it again."""
    result = RESULTS[kind]
    for data in (result.contacts, result.trajectory([0.0])):
        about = data.attrs
        assert eval(about["column"], vars(hl).copy()) == result.column
        assert (about["model"], about["method"], about["outcome"]) == (result.model, result.method, "ok")
        assert about["hardlimit_version"] == hl.__version__ and hl.__version__ in about["source"]
        assert about.get("until") == result.until
        assert about["title"].split()[0] in ("Contacts", "Trajectory")
        since = "the first floor touch" if result.column.floor else "release"
        times = data.time if "time" in data.coords else data.begin
        assert times.attrs["long_name"] == f"time after {since}"
        for name, values in {**data.data_vars, **data.coords}.items():
            assert values.attrs["long_name"], name


def test_attributes_survive_a_file(tmp_path):
    data = RESULTS["three balls, until"].trajectory()
    data.to_netcdf(tmp_path / "t.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "t.nc", engine="h5netcdf") as read:
        assert read.attrs == data.attrs and read.pair.attrs == data.pair.attrs


class Page(HTMLParser):
    """HTML parser: rows of text of the tables, and the tags left open at the end."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.open, self.names = [], [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        self.names |= {name for name, _ in attrs}
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


@every_result
def test_html_of_a_result(kind):
    """A well-formed table that sets no colours, readable in light and dark notebooks."""
    result = RESULTS[kind]
    page = Page(result._repr_html_())
    assert not page.open and page.names <= {"style"} and "color" not in result._repr_html_()
    rows = dict(row for row in page.rows if len(row) == 2)
    assert rows["ball–ball contacts"] == str(result.n_contacts) and rows["outcome"] == "ok"
    for i in range(len(result.column.balls)):
        assert float(rows[f"final velocity of ball {i + 1} [m/s]"]) == pytest.approx(
            result.final_velocities[i], rel=1e-5
        )


def test_html_of_columns_and_comparisons():
    page = Page(three_balls()._repr_html_())
    assert not page.open
    assert [row[0] for row in page.rows] == ["", "ball 3", "ball 2", "ball 1"]
    assert page.rows[1][1:] == ["0.01", "0.002", "0.0002", "0"]
    assert not Page(RESULTS["cradle"].column._repr_html_()).open
    comparison = hl.compare(PAPER)
    text = comparison._repr_html_()
    page = Page(text)
    assert not page.open and page.rows[0] == ["", "Newton", "adiabatic", "independent"]
    assert {len(row) for row in page.rows} == {4} and escape(comparison.verdict.sentence) in text


def test_html_is_escaped():
    text = html.table("<caption>", ["", "<b>"], [["a & b", "<script>"]], "1 < 2")
    assert "<script>" not in text and "&lt;script&gt;" in text and "a &amp; b" in text and "1 &lt; 2" in text
    assert Page(text).rows == [["", "<b>"], ["a & b", "<script>"]]


# ---- copies ------------------------------------------------------------------------------------------------


def same_bits(a, b):
    assert repr(a) == repr(b) and a.column == b.column and a.outcome == b.outcome
    assert a.contacts.identical(b.contacts)
    assert a.trajectory().identical(b.trajectory())
    assert a.positions.tobytes() == b.positions.tobytes()
    assert a.velocities.tobytes() == b.velocities.tobytes()


@every_result
def test_results_pickle_and_copy(kind):
    """A copy is solved again on first use, with bit-identical results."""
    result = RESULTS[kind]
    for other in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert other is not result and "_core" not in vars(other)
        same_bits(result, other)


def test_pickles_are_small():
    result = hl.newton(PAPER, until=1.0)
    before = len(pickle.dumps(result))
    result.trajectory()
    assert len(result.contacts.pair) > 1 and len(pickle.dumps(result)) == before < 3000


def test_arrays_of_a_result_are_read_only():
    result = hl.newton(PAPER)
    for name in ("positions", "velocities", "final_velocities", "rebound_heights"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(result, name)[0] = 7.0
    for name in ("pair", "begin", "end"):
        with pytest.raises(ValueError, match="read-only"):
            result.contacts[name].values[0] = 7
    mine = result.contacts
    mine["begin"] = mine["begin"] + 1.0
    mine.attrs["title"] = "mine"
    assert result.contacts.identical(hl.newton(PAPER).contacts)


def test_results_go_through_a_process_pool():
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(hl.newton, PAPER, method="general")
        velocity = pool.submit(operator.attrgetter("relative_velocity"), RESULTS["exact"])
        future = pool.submit(hl.compare, PAPER)
        same_bits(there.result(), RESULTS["general"])
        assert velocity.result() == RESULTS["exact"].relative_velocity
        assert future.result().verdict == hl.compare(PAPER).verdict


# ---- one ball ----------------------------------------------------------------------------------------------

BOUNCES = 5


def bouncing(law=None, height=0.6, velocity=0.0):
    ball = hl.Ball(0.1, density=840.0)
    return hl.Column([ball], [], height, law_of("linear", 0.7) if law is None else law, velocity)


@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.5])
def test_bounces_of_one_ball(restitution):
    """After n bounces the height is ε^{2n} H, and the flight that follows lasts 2 ε^n V/g."""
    column = bouncing(law_of("linear", restitution))
    v, h = column.impact_speed, column.drop_height
    touches = np.concatenate([[0.0], np.cumsum(2.0 * restitution ** np.arange(1, BOUNCES) * v / 9.81)])
    last = float(touches[-1] + restitution**BOUNCES * v / 9.81)
    result = hl.independent(column, until=last)
    assert result.contacts.begin.values == pytest.approx(touches, rel=1e-12)
    assert (result.contacts.pair == 0).all()
    for n, touch in enumerate(touches, start=1):
        top = result.trajectory([touch + restitution**n * v / 9.81])
        assert float(top.position[0, 0]) == pytest.approx(0.1 + restitution ** (2 * n) * h, rel=1e-12)
        assert float(top.velocity[0, 0]) == pytest.approx(0.0, abs=1e-12 * v)


def test_the_stiffer_the_floor_the_nearer_is_newton_to_instantaneous_collisions():
    """The error comes from gravity during the contact, g t_c ~ k^{-1/2}."""
    errors = []
    for stiffness in (1e7, 1e9, 1e11):
        column = bouncing(hl.LinearDashpot(stiffness=stiffness, restitution=0.8))
        hard = hl.independent(column).final_velocities[0]
        errors.append(abs(hl.newton(column).final_velocities[0] - hard) / hard)
        assert hard == pytest.approx(0.8 * column.impact_speed, rel=1e-14)
    assert errors[0] < 1e-2
    for coarse, fine in pairwise(errors):
        assert fine == pytest.approx(coarse / 10.0, rel=0.05)


@pytest.mark.parametrize("name", sorted(hl.LAWS))
@pytest.mark.parametrize("solve", [hl.newton, hl.independent])
@pytest.mark.parametrize("until", [None, 2.0])
def test_results_of_one_ball(name, solve, until):
    result = solve(bouncing(law_of(name, 0.8)), until)
    assert result.n_contacts == 0 and result.outcome_code in (0, hl.OUTCOMES.index("no_contact"))
    for quantity in (
        "relative_velocity", "separation_velocity", "effective_restitution", "restitution_ratio",
        "effective_restitution_at_separation", "restitution_ratio_at_separation",
    ):  # fmt: skip
        assert math.isnan(getattr(result, quantity)), quantity
    assert result.t_floor_end >= 0.0
    assert math.isnan(result.t_end) or result.t_end == result.t_floor_end
    assert result.positions.shape == result.velocities.shape == (1,)
    trajectory = result.trajectory()
    assert trajectory.sizes["ball"] == trajectory.sizes["pair"] == 1
    assert np.isfinite(trajectory.to_array()).all()
    assert trajectory.position.values.min() > 0.0
    assert 0.1 < result.rebound_heights[0] < 0.6 and result.final_velocities[0] > 0.0
    assert "\n" not in repr(result) and not Page(result._repr_html_()).open
    assert len(result.plot().axes) == 1
    same_bits(result, pickle.loads(pickle.dumps(result)))


# ---- columns -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(hl.LAWS))
def test_laws_are_values(name):
    law = law_of(name, 0.7)
    for other in (pickle.loads(pickle.dumps(law)), copy.copy(law), eval(repr(law), vars(hl).copy())):
        assert other == law and hash(other) == hash(law)
        assert type(other) is hl.LAWS[name] is getattr(hl, hl.LAWS[name].__name__)
    assert law != law_of(name, 0.71)
    assert law.replace(restitution=0.71) == law_of(name, 0.71)
    assert law.restitution == law.specified_restitution == 0.7
    with pytest.raises(AttributeError, match="nonsense"):
        law.nonsense  # noqa: B018


def test_balls_are_values():
    ball = hl.Ball(0.1, density=840.0)
    assert ball == hl.Ball(0.1, density=840.0) != hl.Ball(0.1, mass=ball.mass)
    assert ball.mass == pytest.approx(4.0 / 3.0 * math.pi * 840.0 * 1e-3, rel=1e-15)
    assert hl.Ball(0.1, mass=2.0).density == pytest.approx(2.0 / (4.0 / 3.0 * math.pi * 1e-3), rel=1e-15)
    assert eval(repr(ball), vars(hl).copy()) == ball == pickle.loads(pickle.dumps(ball))
    assert ball.resized(0.2).mass == pytest.approx(8.0 * ball.mass, rel=1e-14)
    assert hl.Ball(0.1, mass=2.0).resized(0.2).mass == 2.0
    with pytest.raises(AttributeError):
        ball.radius = 1.0
    assert pickle.loads(pickle.dumps(hl.FLOOR)) is hl.FLOOR


def test_paper_preset():
    column = hl.Column.paper()
    assert [b.radius for b in column.balls] == [0.1, 0.01]
    assert {b.density for b in column.balls} == {hl.PAPER_DENSITY} == {840.0}
    assert column.gaps == (1e-4,) and column.height == 0.6 and column.gravity == 9.81
    assert column.laws[0] == hl.LinearDashpot(stiffness=5e7, restitution=0.7)
    assert hl.Column.paper(radius_ratio=3.0).balls[0].radius == pytest.approx(0.03)
    assert hl.Column.paper(gap=1e-3, density=1000.0).balls[0].density == 1000.0
    assert column.initial_positions.tolist() == [0.6, 0.6 + 0.1 + 1e-4 + 0.01]


# ---- rebound and final velocities --------------------------------------------------------------------------


def highest(result, begin, end, ball):
    """Largest height of a ball on a fine grid of times."""
    return float(result.trajectory(np.linspace(begin, end, 20001)).position.values[:, ball].max())


@draws(25)
@given(columns(law=laws(st.floats(0.3, 1.0)), least=1, most=4))
def test_rebound_until_is_the_greatest_height(column):
    """With `until`, it agrees with a fine grid of times from the end of the first bounce on."""
    until = 0.7 * column.impact_speed / column.gravity
    result = hl.newton(column, until)
    for ball, height in enumerate(result.rebound_heights):
        own = result.contacts.pair.values == ball
        if not own.any() or math.isnan(result.contacts.end.values[own][0]):
            continue
        begin = result.contacts.end.values[own][0]
        if begin >= until:
            continue
        grid = highest(result, begin, until, ball)
        assert grid - 1e-12 <= height <= grid + 1e-5 * abs(grid)


@every_result
def test_final_velocities_are_those_after_the_last_contact(kind):
    result = RESULTS[kind]
    last = float(result.contacts.end.max())
    assert (result.final_velocities == result.trajectory([last]).velocity.values[0]).all()
    if not result.column.floor:
        momentum = [ball.mass for ball in result.column.balls] @ result.final_velocities
        assert momentum == pytest.approx(0.1, rel=1e-12)
        assert np.isnan(result.rebound_heights).all()


def test_a_floor_contact_that_was_not_followed_leaves_final_velocities():
    """A run of three balls stops at the second floor contact, which then has no end; the column is not at rest."""
    balls = [hl.Ball(1e-3, mass=1e-5), hl.Ball(0.05, mass=1.0), hl.Ball(4e-3, mass=1e-4)]
    law = law_of("viscoelastic", 0.9).replace(youngs_modulus=1e13)
    result = hl.newton(hl.Column(balls, [1e-6, 0.1], 2e-3, law, gravity=1000.0))
    end = result.contacts.end.values
    assert result.outcome == "ok" and math.isnan(end[-1]) and result.contacts.pair.values[-1] == 0
    # The lowest ball is in flight until then; a contact above it lasts longer.
    again = result.contacts.begin.values[-1]
    last, met = result.trajectory([np.nanmax(end), again]).velocity.values
    assert np.nanmax(end) > again and (result.final_velocities == [met[0], *last[1:]]).all()


LINEAR = law_of("linear", 0.5)
SOFT = law_of("viscoelastic", 0.5)


def moving(velocities, gravity=9.81, height=1.0):
    return hl.Column(BALLS, [0.0], height, LINEAR, velocities, gravity)


BAD_COLUMNS = {
    "no balls": (lambda: hl.Column([], [], 1.0, LINEAR), ("balls", "0", "one or more")),
    "cradle of one ball": (lambda: hl.Column.cradle(BALLS[:1], [1.0], LINEAR), ("balls", "1", "two or more")),
    "a ball alone": (lambda: hl.Column(BALLS[0], [], 1.0, LINEAR), ("balls", "must be a list of Ball")),
    "no ball": (lambda: hl.Column([BALLS[0], 3], [0.0], 1.0, LINEAR), ("balls[1]", "3", "Ball")),
    "negative gap": (lambda: hl.Column(BALLS, [-1e-9], 1.0, LINEAR), ("gaps[0]", "-1e-09", ">= 0")),
    "NaN gap": (lambda: hl.Column(BALLS, [math.nan], 1.0, LINEAR), ("gaps[0]", "nan", ">= 0")),
    "too many gaps": (lambda: hl.Column(BALLS, [0.0, 0.0], 1.0, LINEAR), ("gaps", "2 values", "must be 1")),
    "text for gaps": (lambda: hl.Column(BALLS, "no", 1.0, LINEAR), ("gaps", "'no'")),
    "below the floor": (lambda: hl.Column(BALLS, [0.0], 0.049, LINEAR), ("height", "0.049", "radius")),
    "NaN height": (lambda: hl.Column(BALLS, [0.0], math.nan, LINEAR), ("height", "nan", "finite")),
    "nothing moves": (
        lambda: hl.Column(BALLS, [0.0], 0.05, LINEAR),
        ("height", "0.05", "nothing would move"),
    ),
    "negative gravity": (lambda: moving(0.0, -1.0), ("gravity", ">= 0")),
    "never lands": (lambda: moving(1.0, 0.0), ("velocities[0]", "1", "< 0")),
    "NaN velocity": (lambda: moving([0.0, math.nan]), ("velocities[1]", "nan", "finite")),
    "no law": (lambda: hl.Column(BALLS, [0.0], 1.0, 0.5), ("law", "0.5", "contact law")),
    "too few laws": (lambda: hl.Column(BALLS, [0.0], 1.0, [LINEAR]), ("law", "1 laws", "one or 2")),
    "two kinds": (lambda: hl.Column(BALLS, [0.0], 1.0, [LINEAR, SOFT]), ("law", "one kind")),
    "ratio and radius": (lambda: hl.Column.paper(radius_1=0.1, radius_ratio=2.0), ("radius_ratio", "both")),
    "zero ratio": (lambda: hl.Column.paper(radius_ratio=0.0), ("radius_ratio", "0", "> 0")),
    "law and restitution": (lambda: hl.Column.paper(0.5, law=SOFT), ("law | restitution", "both")),
    "restitution of 0": (lambda: hl.Column.paper(0.0), ("restitution", "0", "in (0, 1]")),
    "restitution above 1": (lambda: hl.Column.paper(1.0001), ("restitution", "1.0001", "in (0, 1]")),
    "cradle at rest": (lambda: hl.Column.cradle(BALLS, [0.0, 0.0], LINEAR), ("velocities", "approach")),
    "cradle that opens": (lambda: hl.Column.cradle(BALLS, [0.0, 1.0], LINEAR), ("velocities", "approach")),
    "cradle with a floor law": (
        lambda: hl.Column.cradle(BALLS, [1.0, 0.0], [LINEAR, LINEAR]),
        ("law", "2 laws", "one or 1"),
    ),
    "no column": (lambda: hl.newton("drop"), ("column", "'drop'", "Column")),
    "unknown method": (lambda: hl.newton(PAPER, method="magic"), ("method", "'magic'")),
    "exact for Hertz": (lambda: hl.newton(three_balls(), method="exact"), ("method", "exact")),
    "endless height": (lambda: hl.Column(BALLS, [0.0], 1e101, LINEAR), ("height", "1e+101", "1e+100]")),
    "endless gap": (lambda: hl.Column(BALLS, [2e100], 1.0, LINEAR), ("gaps[0]", "2e+100", "1e+100]")),
    "endless speed": (lambda: moving([0.0, -1e308]), ("velocities[1]", "-1e+308", "[-1e+100")),
    "nothing falls": (lambda: moving(0.0, 0.0), ("gravity | velocities", "nothing would move")),
    "until before release": (lambda: hl.newton(PAPER, until=-1.0), ("until", "-1", "release")),
    "until before a cradle": (
        lambda: hl.independent(RESULTS["cradle"].column, until=-1e-9),
        ("until", "-1e-09", ">= 0"),
    ),
    "NaN until": (lambda: hl.newton(PAPER, until=math.nan), ("until", "nan", "finite")),
    "infinite until": (lambda: hl.independent(PAPER, until=math.inf), ("until", "inf", "finite")),
    "wild tolerance": (lambda: hl.newton(PAPER, method="general", tolerance=1.0), ("tolerance", "1", "in [")),
}


@pytest.mark.parametrize("case", BAD_COLUMNS)
def test_bad_input_is_refused_in_one_line(case):
    call, words = BAD_COLUMNS[case]
    message = refusal(call)
    assert all(word in message for word in words), message


def test_a_file_that_cannot_be_written_frees_its_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also while the exception is kept: Python 3.14 reports an error if an exported buffer is freed."""
    monkeypatch.setattr(saving, "open", lambda *_, **__: io.FileIO(__file__), raising=False)  # read-only
    content = bytearray(b"0123")
    with pytest.raises(OSError, match=r"out\.bin: cannot be written: File not open for writing$") as caught:
        saving.write(tmp_path / "out.bin", content)
    content.append(0)  # refused while the buffer is exported
    assert caught.value.__cause__ is not None
