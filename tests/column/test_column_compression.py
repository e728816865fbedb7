"""Largest compressions of columns, and runs that end at a compression beyond the range of the law."""

import math
import shlex
import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import hardlimit as hl
from command_line import printed, refused, run
from conftest import columns, draws, log_floats
from hardlimit import _core

LIMIT = _core.deepest_compression
TOO_DEEP = hl.OUTCOMES.index("too_deep")


def solvers(column: hl.Column) -> list:
    """All solvers of Newton's equations that apply to the column, and the adiabatic one."""
    ways = [lambda until=None: hl.newton(column, until, method="general")]
    if column.solvable_exactly:
        ways += [lambda until=None: hl.newton(column, until), lambda until=None: hl.adiabatic(column, until)]
    return ways


def smaller_radii(column: hl.Column) -> np.ndarray:
    radii = np.array([ball.radius for ball in column.balls])
    return np.minimum(radii, np.append(math.inf, radii[:-1]))


def sampled_compression(result: hl.Result) -> float:
    """Largest compression over the smaller radius in a dense sample of the solution."""
    _, begin, end = result._core.contacts()
    first, last = result._core.t_first, result._core.t_last
    end = np.where(np.isnan(end), last, np.minimum(end, last))
    spans = [np.linspace(a, max(a, b), 400) for a, b in zip(begin[:60], end[:60], strict=True)]
    times = np.concatenate([np.linspace(first, last, 200), *spans])
    z = result._core.sample(np.clip(times, first, last))[0]
    radii = np.array([ball.radius for ball in result.column.balls])
    between = radii[1:] + radii[:-1] - np.diff(z, axis=1)
    floor = radii[0] - z[:, :1] if result.column.floor else np.full((len(z), 1), -math.inf)
    return float((np.hstack([floor, between]) / smaller_radii(result.column)).max(initial=0.0))


@st.composite
def soft_columns(draw, least=1) -> hl.Column:
    """Columns whose compressions range from small to far beyond the limit."""
    column = draw(columns(least=least, most=4))
    name = next(iter(column.laws[0].parameters))
    softer = column.laws[0].replace(**{name: column.laws[0].parameters[name] * draw(log_floats(1e-8, 1e-1))})
    return column.replace(law=softer)


@draws(200)
@given(soft_columns())
def test_largest_compression_is_that_of_a_dense_trajectory(column: hl.Column) -> None:
    for solve in solvers(column):
        result = solve()
        if result.outcome_code in (hl.OUTCOMES.index("unresolved"), hl.OUTCOMES.index("at_rest")):
            continue
        sampled = sampled_compression(result)
        assert sampled <= result.largest_compression * (1.0 + 1e-8) + 1e-12
        assert sampled == pytest.approx(result.largest_compression, rel=1e-3, abs=1e-12)
        assert (result.outcome_code == TOO_DEEP) == (result.largest_compression == LIMIT)


@draws(200)
@given(soft_columns(), st.floats(0.3, 1.0))
def test_bounds_never_hide_a_compression(column: hl.Column, share: float) -> None:
    """A compression that the energy bounds exclude never occurs."""
    for solve in solvers(column):
        core = solve()._core
        deepest = core.largest_compression()
        assert core.presses_by(share * deepest) or deepest == 0.0
        assert not core.presses_by(deepest * (1.0 + 1e-9) + 1e-300)


def at_limit(column: hl.Column, solve) -> tuple[hl.Column, hl.Column]:
    """The column slightly stiffer and slightly softer than the one that reaches the limit."""
    name = next(iter(column.laws[0].parameters))
    value = column.laws[0].parameters[name]

    def scaled(exponent: float) -> hl.Column:
        return column.replace(law=column.laws[0].replace(**{name: value * math.exp(exponent)}))

    soft, stiff = -30.0, 30.0
    assume(solve(scaled(soft)).outcome_code == TOO_DEEP)
    assume(solve(scaled(stiff)).outcome_code != TOO_DEEP)
    while stiff - soft > 1e-7:
        middle = 0.5 * (soft + stiff)
        if solve(scaled(middle)).outcome_code == TOO_DEEP:
            soft = middle
        else:
            stiff = middle
    return scaled(stiff), scaled(soft)


soft_laws = st.floats(0.1, 1.0).map(lambda e: hl.LinearDashpot(stiffness=1e4, restitution=e))


@draws(30)
@given(columns(least=2, most=2, law=soft_laws))
def test_both_solvers_end_at_the_limit(column: hl.Column) -> None:
    above, below = at_limit(column, hl.newton)
    for method in ("exact", "general"):
        result = hl.newton(above, method=method)
        assert result.outcome_code != TOO_DEEP or result.largest_compression == pytest.approx(LIMIT, rel=1e-6)
        assert 0.9 * LIMIT < result.largest_compression <= LIMIT * (1.0 + 1e-9)
    softer = below.replace(law=below.laws[0].replace(stiffness=below.laws[0].stiffness * 0.99))
    exact, general = (hl.newton(softer, method=method) for method in ("exact", "general"))
    for result in (exact, general):
        assume(result.outcome_code == TOO_DEEP)
        check_cut(result)
    assert exact._core.t_last == pytest.approx(general._core.t_last, rel=1e-9)
    assert exact._core.too_deep == general._core.too_deep
    assert exact.n_contacts == general.n_contacts
    assert np.allclose(exact.positions, general.positions, rtol=1e-8)
    for left, other in zip(exact.contact_times, general.contact_times, strict=True):
        assert np.allclose(left, other, rtol=1e-8, atol=1e-12, equal_nan=True)


def check_cut(result: hl.Result) -> None:
    """No result refers to times after the instant at which a contact is too deep."""
    last = result._core.t_last
    _, begin, end = result.contact_times
    assert result.outcome.startswith("too deep: ") and f"{last:.6g} s after" in result.outcome
    assert (begin <= last).all() and np.isnan(end).any() and (end[~np.isnan(end)] <= last).all()
    assert math.isnan(result.t_end) and math.isnan(result.relative_velocity)
    assert math.isnan(result.separation_velocity) and math.isnan(result.effective_restitution)
    assert np.isnan(result.final_velocities).all() and np.isnan(result.rebound_heights).all()
    assert not result.t_floor_end > last
    assert result.known_until == last
    gap = sampled_at(result, last)[result._core.too_deep]
    assert -gap / smaller_radii(result.column)[result._core.too_deep] == pytest.approx(LIMIT, rel=1e-9)
    with pytest.raises(ValueError, match="where the solution ends: too deep"):
        result.trajectory(last + 1.0)


def sampled_at(result: hl.Result, time: float) -> np.ndarray:
    z = result._core.sample(np.array([time]))[0][0]
    radii = np.array([ball.radius for ball in result.column.balls])
    return np.append(z[0] - radii[0], np.diff(z) - radii[1:] - radii[:-1])


def paper(stiffness: float, **options) -> hl.Column:
    column = hl.Column.paper(**options)
    return column.replace(law=column.laws[0].replace(stiffness=stiffness))


def test_a_column_that_is_too_soft() -> None:
    """Regression: it rebounded to −34 m and came to rest."""
    result = hl.newton(paper(1.0))
    check_cut(result)
    assert result._core.too_deep == 0 and result.contact_times[0].tolist() == [0]
    v, limit = result.column.impact_speed, LIMIT * 0.1
    assert result._core.t_last == pytest.approx(limit / v, rel=0.1)  # hardly slowed down
    assert "the floor and ball 1" in result.outcome


@pytest.mark.parametrize("restitution", [1.0, 0.7, 0.05, 1e-4])
@pytest.mark.parametrize("stiffness", [1.0, 300.0, 3e3])
def test_a_ball_alone(restitution: float, stiffness: float) -> None:
    """The compression is that of a damped oscillator under gravity in closed form."""
    ball = hl.Ball(0.05, mass=1.0)
    law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    column = hl.Column([ball], [], 0.3, law)
    result = hl.newton(column)
    k, c, g = stiffness, law.between(ball).damping, column.gravity
    until = 20.0 if restitution < 0.01 else 4.0  # overdamped, or deepest in the first contact
    t = np.linspace(0.0, until, int(1e5 * until) + 1)
    beta = 0.5 * c
    root = np.emath.sqrt(k - beta**2) + 0j
    y0, dy0 = g / k, -column.impact_speed  # about the equilibrium, upwards
    up, down = (np.exp((sign * 1j * root - beta) * t) for sign in (1.0, -1.0))
    y = 0.5 * (y0 * (up + down) + (dy0 + beta * y0) * (up - down) / (1j * root))
    depth = (g / k - y.real) / ball.radius
    if depth.max() < LIMIT:
        rests = result.outcome_code == hl.OUTCOMES.index("at_rest")
        assert rests or result.outcome_code == 0
        deepest = max(depth.max(), g / (k * ball.radius) if rests else 0.0)
        assert result.largest_compression == pytest.approx(deepest, rel=1e-6)
    else:
        assert result.outcome_code == TOO_DEEP
        assert result._core.t_last == pytest.approx(t[np.argmax(depth >= LIMIT)], abs=2e-5)


@pytest.mark.parametrize("method", ["exact", "general"])
@pytest.mark.parametrize("restitution", [1e-3, 0.02])
def test_a_column_that_sinks_under_its_weight(method: str, restitution: float) -> None:
    """Released at rest in contact: at rest if stiff enough, otherwise too deep, however slowly it creeps."""
    balls = [hl.Ball(0.05, mass=1.0), hl.Ball(0.04, mass=0.5)]
    for static, deep in ((0.4, False), (0.6, True)):
        stiffness = 1.5 * 9.81 / (static * 0.05)
        law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
        result = hl.newton(hl.Column(balls, 0.0, 0.05 + 1e-9, law), method=method)
        assert (result.outcome_code == TOO_DEEP) is deep, result
        if not deep:
            assert static - 1e-9 <= result.largest_compression < LIMIT


def test_a_time_before_the_limit_is_known() -> None:
    column = paper(1.0)
    end = hl.newton(column)._core.t_last
    early = hl.newton(column, 0.5 * end)
    assert early.outcome_code == TOO_DEEP  # the outcome is that of the whole sequence, like t_end
    assert np.isfinite(early.positions).all()
    late = hl.newton(column, 2.0 * end)
    assert late._core.t_last == pytest.approx(end, rel=1e-14) and np.isnan(late.positions).all()
    assert early._core.t_last == pytest.approx(end, rel=1e-14)


def test_pairs_that_meet_too_hard_before_the_floor() -> None:
    balls = [hl.Ball(0.05, mass=1.0), hl.Ball(0.04, mass=1.0)]
    law = hl.LinearDashpot(stiffness=10.0, restitution=0.9)
    column = hl.Column(balls, [0.01], 20.0, law, velocities=[0.0, -3.0])
    exact, general = (hl.newton(column, method=method) for method in ("exact", "general"))
    for result in (exact, general):
        assert result._core.too_deep == 1 and "ball 1 and ball 2" in result.outcome
        assert "s after release" in result.outcome and result._core.t_first == 0.0
    assert exact._core.t_last == pytest.approx(general._core.t_last, rel=1e-10)
    assert exact.contact_times[0].tolist() == general.contact_times[0].tolist() == [1]


def test_cradles_end_as_well() -> None:
    balls = [hl.Ball(0.01, mass=0.1)] * 3
    law = hl.LinearDashpot(stiffness=100.0, restitution=1.0)
    result = hl.newton(hl.Column.cradle(balls, [3.0, 0.0, 0.0], law))
    assert result.outcome_code == TOO_DEEP and "ball 1 and ball 2" in result.outcome


# ---- warnings ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("solve", [hl.newton, lambda c: hl.newton(c, method="general"), hl.adiabatic])
def test_a_warning_from_five_per_cent_on(solve) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solve(paper(5e7)).largest_compression < 0.05
        hl.independent(paper(1e5))
    with pytest.warns(hl.CompressionWarning, match="compressed by more than 5 % of the smaller") as told:
        assert solve(paper(1e5)).largest_compression == pytest.approx(0.158, rel=0.03)
    if solve is hl.newton:
        assert told[0].filename == __file__


def test_instantaneous_collisions_have_none() -> None:
    assert math.isnan(hl.independent(paper(1.0)).largest_compression)


def test_the_verdict() -> None:
    answer, sentence = hl.compare(paper(1.0)).verdict
    assert answer == "undecided" and "too deep" in sentence


def test_pickled_results_are_too_deep_as_well() -> None:
    import pickle

    result = hl.newton(paper(1.0))
    again = pickle.loads(pickle.dumps(result))
    assert again.outcome == result.outcome and again.largest_compression == LIMIT


# ---- sweeps --------------------------------------------------------------------------------------------------

VALUES = ("relative_velocity", "separation_velocity", "effective_restitution", "restitution_ratio", "t_end")


@pytest.mark.parametrize("engine", ["cpu", "dask"])
@pytest.mark.parametrize("model", ["newton", "adiabatic"])
def test_a_map_through_the_limit(model: str, engine: str) -> None:
    stiffness = np.geomspace(1e2, 1e7, 60)
    gaps = [0.0, 1e-4, 1e-2]
    grid = hl.sweep(hl.Column.paper(), model=model, engine=engine, stiffness=stiffness, gap=gaps,
                    variables=("n_contacts", "outcome", *VALUES))  # fmt: skip
    solve = hl.newton if model == "newton" else hl.adiabatic
    alone = [[solve(paper(k, gap=gap)) for gap in gaps] for k in stiffness]
    codes = np.array([[r.outcome_code for r in row] for row in alone])
    assert (grid.outcome.values == codes).all()
    assert 10 < (codes == TOO_DEEP).sum() < codes.size - 10
    assert "too_deep" in grid.outcome.attrs["flag_meanings"].split()
    assert (grid.n_contacts.values == [[r.n_contacts for r in row] for row in alone]).all()
    for name in VALUES:
        assert np.isnan(grid[name].values[codes == TOO_DEEP]).all()
        expected = [[getattr(r, name) for r in row] for row in alone]
        assert np.allclose(grid[name].values, expected, rtol=1e-6, atol=1e-9, equal_nan=True)


def test_a_viscoelastic_map_through_the_limit() -> None:
    column = hl.Column.paper(radius_ratio=2.0)
    law = hl.Viscoelastic(youngs_modulus=1e6, poisson_ratio=0.3, restitution=0.8, impact_speed=3.0)
    column = column.replace(law=law)
    youngs = np.geomspace(1e2, 1e8, 30)
    grid = hl.sweep(column, youngs_modulus=youngs, gap=[1e-5, 1e-3])
    for i, y in enumerate(youngs):
        for j, gap in enumerate((1e-5, 1e-3)):
            result = hl.newton(column.replace(law=law.replace(youngs_modulus=y), gaps=gap))
            assert grid.outcome.values[i, j] == result.outcome_code
    assert set(np.unique(grid.outcome.values)) == {0, TOO_DEEP}


def test_a_map_of_three_balls() -> None:
    balls = [hl.Ball(r, density=840.0) for r in (0.05, 0.03, 0.02)]
    column = hl.Column(balls, 1e-4, 0.5, hl.LinearDashpot(stiffness=1e6, restitution=0.8))
    grid = hl.sweep(column, stiffness=[1e2, 1e6])
    assert grid.outcome.values.tolist() == [TOO_DEEP, 0]
    assert np.isnan(grid.rebound_height.values[0]).all() and np.isnan(grid.final_velocity.values[0]).all()


# ---- uses of the result ---------------------------------------------------------------------------------------


def text_of(*arguments: object) -> str:
    """What a command prints, without line breaks."""
    return " ".join(run(*arguments).stdout.split())


def test_the_command_names_a_sufficient_stiffness() -> None:
    text = text_of("drop", "--stiffness", 1)
    assert "Too deep: a contact was compressed by half of the smaller radius" in text
    assert "With a stiffness of 100000 N/m, contacts are not too deep." in text and "rests" not in text
    assert hl.newton(paper(1e5)).outcome_code == 0
    assert "Contacts were compressed by up to 16 % of the smaller" in text_of("drop", "--stiffness", 1e5)
    assert "compressed by up to" not in text_of("drop")
    said = refused("stack", "--balls", 2, "--stiffness", 1)
    assert "--law: got linear --stiffness 1.0 --restitution 0.7, must be stiffer" in said


def test_the_command_in_json() -> None:
    newton = printed("drop", "--stiffness", 1)["models"]["newton"]
    assert newton["largest_compression"] == LIMIT and newton["outcome"].startswith("too deep")


def test_one_contact_on_the_command_line() -> None:
    command = shlex.split("contact --radius 1cm --mass 10g --stiffness 1e4 --speed 1 --restitution 1")
    assert printed(*command)["largest_compression"] == pytest.approx([math.sqrt(0.01 / 1e4) / 0.01], rel=1e-9)
    two = [*command, "--other-radius", "5mm", "--other-mass", "10g"]
    assert printed(*two)["largest_compression"] == pytest.approx([math.sqrt(0.005 / 1e4) / 0.005], rel=1e-9)
    assert "Contacts were compressed by up to 1000 %" in text_of(*command, "--speed", 100)


@pytest.mark.slow
def test_pictures_end_where_the_run_does(tmp_path) -> None:
    result = hl.newton(paper(1e3))
    result.plot().savefig(tmp_path / "forces.png", dpi=40)
    from hardlimit import plots

    figure = plots.drop(result, hl.independent(result.column), None)
    assert figure._suptitle.get_text().startswith("too deep: known up to ")
    figure.savefig(tmp_path / "drop.png", dpi=40)
    result.animate(tmp_path / "drop.gif", width=160, frames_per_second=1)
    assert result.trajectory().time.values.max() <= result.known_until


def test_a_stack_that_is_too_soft() -> None:
    law = hl.LinearDashpot(stiffness=1.0, restitution=0.9)
    with pytest.raises(ValueError, match=r"law: got LinearDashpot.*must be stiffer: too deep"):
        hl.stack(2, law, bottom_mass=0.6)
    with pytest.warns(hl.CompressionWarning, match="contacts were compressed by more than 5 %") as told:
        soft = hl.stack(2, law.replace(stiffness=3e3), bottom_mass=0.6)
    assert len(told) == 1 and told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert soft.speed_under("newton") == soft.speed
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        said = run("stack", "--balls", 2, "--stiffness", 3e3, "--bottom-mass", 0.6).stderr
    assert said.count("warning: contacts were compressed by more than") == 1


def test_an_oblique_drop_that_is_too_soft() -> None:
    with pytest.raises(RuntimeError, match="oblique drop: too deep"):
        hl.oblique_drop(paper(1.0), 1e-4)


# ---- energies ------------------------------------------------------------------------------------------------


@draws(100)
@given(columns(law=st.one_of(
    st.sampled_from([0.01, 0.05, 0.2, 0.9]).map(lambda e: hl.LinearDashpot(stiffness=1e7, restitution=e)),
    st.sampled_from([0.02, 0.3]).map(lambda e: hl.Tsuji(elastic_prefactor=1e9, restitution=e)),
    st.sampled_from([0.1, 0.3]).map(
        lambda e: hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=e, impact_speed=1.0)
    ),
), most=3))  # fmt: skip
def test_energies_are_functions_of_the_state(column: hl.Column) -> None:
    """The contact energy is that of all overlaps, and is continuous where a force ends before the gap opens."""
    results = [hl.newton(column, method="general")]
    if column.solvable_exactly:
        results.append(hl.newton(column))
    for result in results:
        _, begin, end = result.contact_times
        last = result._core.t_last
        marks = np.concatenate([begin, end])
        marks = marks[np.isfinite(marks)][:40]
        near = np.concatenate([marks * (1.0 - 1e-13), marks * (1.0 + 1e-13)])
        after = np.concatenate([np.linspace(t, t + 3e-4, 60) for t in marks] or [[0.0]])
        times = np.unique(np.concatenate([np.linspace(result._core.t_first, last, 500), near, after]))
        times = times[(times >= result._core.t_first) & (times <= last)]
        path = result.trajectory(times)
        z = path.position.values
        radii = np.array([ball.radius for ball in column.balls])
        kinds = ("kinetic", "potential", "contact", "dissipated")
        total = sum(path[f"{kind}_energy"].values for kind in kinds)
        scale = total[0]
        assert np.allclose(total, scale, rtol=0.0, atol=1e-9 * scale)
        assert np.diff(path.dissipated_energy.values).min(initial=0.0) >= -1e-11 * scale
        depth = np.column_stack([radii[0] - z[:, 0], radii[1:] + radii[:-1] - np.diff(z, axis=1)])
        stored = sum(
            contact.energy(np.maximum(depth[:, j], 0.0)) for j, contact in enumerate(column.contacts)
        )
        assert np.allclose(path.contact_energy.values, stored, rtol=1e-5, atol=1e-9 * scale)
        for t in marks:
            if not result._core.t_first < t < last:
                continue
            around = result.trajectory([t * (1.0 - 1e-13), t * (1.0 + 1e-13)])
            for name in ("contact_energy", "dissipated_energy"):
                assert abs(np.diff(around[name].values)[0]) <= 1e-9 * scale
    if len(results) == 2 and results[0].n_contacts == results[1].n_contacts:
        known = min(result._core.t_last for result in results)
        first = max(result._core.t_first for result in results)
        left, other = (result.trajectory(np.linspace(first, 0.999 * known, 300)) for result in results)
        for name in ("contact_energy", "dissipated_energy"):
            assert np.abs(left[name].values - other[name].values).max() <= 1e-7 * scale
