"""Fits of contact laws: identifiable parameters, coverage of the intervals, distribution of χ²."""

import json
import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy

import command_line
import hardlimit as hl
from conftest import refusal, slow
from hardlimit.fitting.candidates import candidate
from hardlimit.fitting.likelihood import chi_square_probability
from legible import assert_legible, coloured

BALL = hl.Ball(0.01, density=1000.0)
G = 9.81


def viscoelastic(restitution: float = 0.8, speed: float = 1.0) -> hl.Law:
    return hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=restitution, impact_speed=speed)


def peaks(law: hl.Law, height: float, n: int, scatter: float = 0.0, rng: object = None) -> np.ndarray:
    """Heights of a bouncing ball, from the definition of ε."""
    contact, heights = law.between(BALL), [height]
    for _ in range(n):
        e = contact.restitution(math.sqrt(2.0 * G * heights[-1]))
        heights.append(heights[-1] * (e + (scatter * rng.normal() if rng else 0.0)) ** 2)
    return np.array(heights)


def times_of(heights: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(2.0 * np.sqrt(2.0 * heights[1:] / G))])


def measured(kind: str, law: hl.Law, rng: np.random.Generator) -> hl.Impacts:
    """Noisy data of a law, of each kind that a file can hold."""
    if kind == "restitution":
        v = np.geomspace(0.1, 3.0, 12)
        e = law.between(BALL).restitution(v) + rng.normal(0.0, 0.005, v.size)
        return hl.Impacts.of_restitution(v, e, 0.005)
    if kind == "rebound heights":
        h = np.linspace(0.1, 0.9, 12)
        contact = law.between(BALL)
        up = h * contact.restitution(np.sqrt(2.0 * G * h)) ** 2 + rng.normal(0.0, 2e-3, h.size)
        return hl.Impacts.of_rebound_heights(h + rng.normal(0.0, 2e-3, h.size), up, 2e-3, 2e-3)
    h = peaks(law, 0.5, 9)
    if kind == "heights":
        return hl.Impacts.of_heights([h + rng.normal(0.0, 1e-3, h.size) for _ in range(2)], 1e-3)
    t = times_of(h)
    return hl.Impacts.of_times([t + rng.normal(0.0, 1e-4, t.size) for _ in range(2)], 1e-4)


KINDS = ["restitution", "rebound heights", "heights", "times"]


# --- statistics ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [1, 2, 3, 7, 10, 101, 1000])
def test_probability_of_chi_square(degrees: int) -> None:
    for x in (0.0, 1e-8, 0.3 * degrees, 1.0 * degrees, 2.0 * degrees + 3.0):
        expected = scipy.stats.chi2.sf(x, degrees)
        assert chi_square_probability(x, degrees) == pytest.approx(expected, rel=1e-11, abs=1e-300)
    assert math.isnan(chi_square_probability(1.0, 0))


@pytest.mark.parametrize("kind", ["restitution", *map(slow, ("times", "rebound heights", "heights"))])
def test_deviations_are_independent_with_unit_variance(kind: str) -> None:
    """Deviations from the true law have unit covariance for every kind of reading."""
    law, rng = viscoelastic(), np.random.default_rng(3)
    tried = candidate("viscoelastic", "impacts", 1.0, {}, None, BALL, hl.FLOOR)
    samples = np.array([measured(kind, law, rng).deviations(tried, law, 0.0)[0] for _ in range(300)])
    n = samples.shape[1]
    assert np.abs(samples.mean(0)).max() < 5.0 / math.sqrt(300)
    assert np.abs(samples.T @ samples / 300 - np.eye(n)).max() < 5.0 * math.sqrt(2.0 / 300)


def covered(kind: str, seeds: range, confidence: float) -> tuple[float, np.ndarray]:
    """Coverage of the intervals, and the probabilities of χ²."""
    truth, hits, chances = viscoelastic(0.8, 1.0), 0, []
    for seed in seeds:
        data = measured(kind, truth, np.random.default_rng(seed))
        fitted = hl.fit(data, fixed={"impact_speed": 1.0}, compare=False, confidence=confidence)
        estimate = fitted.parameters["restitution"]
        hits += estimate.lower <= 0.8 <= estimate.upper
        chances.append(fitted.probability)
    return hits / len(seeds), np.array(chances)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("confidence", [0.68, 0.95])
def test_intervals_cover_and_chi_square_is_one(kind: str, confidence: float) -> None:
    share, chances = covered(kind, range(80), confidence)
    assert abs(share - confidence) < 3.5 * math.sqrt(confidence * (1.0 - confidence) / 80)
    assert scipy.stats.kstest(chances, "uniform").pvalue > 1e-3


@pytest.mark.slow
def test_scatter_is_found_and_its_interval_covers() -> None:
    """Each impact has its own ε in addition to the reading error."""
    hits, values = 0, []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        drops = [peaks(viscoelastic(), 0.8, 8, 0.01, rng) for _ in range(4)]
        noisy = [h + rng.normal(0.0, 2e-4, h.size) for h in drops]
        fitted = hl.fit(hl.Impacts.of_heights(noisy, 2e-4), scatter=True, compare=False)
        hits += fitted.scatter.lower <= 0.01 <= fitted.scatter.upper
        values.append(fitted.scatter.value)
    # Maximum likelihood takes 1 of 32 values for the mean: 2 % too low.
    assert abs(np.mean(values) - 0.01) < 0.0008
    assert abs(hits / 40 - 0.68) < 0.24


@pytest.mark.parametrize("span", [1.0, 30.0, 1e4])
def test_the_polynomial_is_the_curve(span: float) -> None:
    """ε and its slope over ln v, for any ε and any measured range of speeds."""
    for e in (0.02, 0.3, 0.7, 0.95, 0.9999):
        tried = candidate("viscoelastic", "impacts", 1.0, {}, None, BALL, hl.FLOOR)
        law = viscoelastic(e)
        v = np.geomspace(1.0 / span, 1.0, 50)
        exact = law.between(BALL).restitution
        curve = tried.curve(law, v[0], v[-1])
        np.testing.assert_allclose(curve(np.log(v)), exact(v), atol=1e-9)
        slope = (exact(v * 1.0001) - exact(v * 0.9999)) / 2e-4
        np.testing.assert_allclose(curve.deriv()(np.log(v)), slope, atol=1e-6)


# --- parameters ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_exact_data_give_the_parameters_back(seed: int) -> None:
    """Random laws, bodies and speeds: without noise the fit is the law."""
    rng = np.random.default_rng(seed)
    e, v = rng.uniform(0.05, 0.99), np.geomspace(0.01, 10.0, 6) * rng.uniform(0.1, 10.0)
    ball, other = (hl.Ball(10.0 ** rng.uniform(-4, -1), density=rng.uniform(100, 8000)) for _ in range(2))
    law = [
        hl.LinearDashpot(stiffness=10.0 ** rng.uniform(3, 9), restitution=e),
        hl.Tsuji(elastic_prefactor=1e9, restitution=e),
        viscoelastic(e, 1.0),
    ][seed % 3]
    met = other if seed % 2 else hl.FLOOR
    data = hl.Impacts.of_restitution(v, law.between(ball, met).restitution(v), 1e-3)
    fitted = hl.fit(data, type(law), ball=ball, other=met, compare=False)
    np.testing.assert_allclose(fitted.contact.restitution(v), data.restitution, atol=2e-6)
    assert fitted.chi_square < 1e-6 and fitted.probability > 0.999
    if seed % 3 == 2:
        truth = law.between(ball, met)
        combination = truth.dissipative_time * (truth.elastic_prefactor / truth.effective_mass) ** 0.4
        assert fitted.dissipation.value == pytest.approx(combination, rel=1e-5)
        known = {"youngs_modulus": 1e9, "poisson_ratio": 0.3}
        again = hl.fit(data, fixed=known, ball=ball, other=met, compare=False)
        assert again.parameters["dissipative_time"].value == pytest.approx(truth.dissipative_time, rel=1e-5)


def test_dissipation_has_the_interval_of_the_restitution() -> None:
    """One is a function of the other: their intervals agree, and the error is that of its slope."""
    data = measured("restitution", viscoelastic(), np.random.default_rng(5))
    fitted = hl.fit(data, compare=False)
    other = hl.fit(data, fixed={"youngs_modulus": 2e8, "poisson_ratio": 0.1}, ball=BALL, compare=False)
    scale = (other.contact.elastic_prefactor / other.contact.effective_mass) ** 0.4
    for end in ("value", "error", "lower", "upper"):
        expected = getattr(other.parameters["dissipative_time"], end) * scale
        assert getattr(fitted.dissipation, end) == pytest.approx(expected, rel=0.02)


def test_verdict_tells_a_law_that_fails_from_one_that_describes() -> None:
    data = measured("times", viscoelastic(), np.random.default_rng(1))
    right, wrong = hl.fit(data), hl.fit(data, "tsuji")
    assert right.verdict.startswith("viscoelastic describes the data: χ² = ")
    assert "one ε (linear, tsuji) does worse by" in right.verdict
    assert wrong.verdict.startswith("one ε (linear, tsuji) cannot describe the data: χ² = ")
    assert "viscoelastic does better by" in wrong.verdict
    assert right.trials[0].name == wrong.trials[0].name == "viscoelastic"
    assert wrong.probability < 1e-6 < right.probability
    assert "impact_speed" in right.notes[-1]


def test_data_without_a_trend_cannot_tell_the_laws_apart() -> None:
    e = 0.8 + np.random.default_rng(0).normal(0.0, 0.05, 5)
    fitted = hl.fit(hl.Impacts.of_restitution(np.linspace(0.9, 1.1, 5), e, 0.05))
    assert fitted.verdict.endswith("one ε (linear, tsuji) cannot be distinguished from it (AIC within 10)")


def test_restitution_at_its_limit() -> None:
    """Noise moves values above 1: the best ε is 1, where its interval ends."""
    e = hl.fit(hl.Impacts.of_restitution([1.0, 2.0], [1.01, 1.02], 0.02), "linear").parameters["restitution"]
    assert e.value == pytest.approx(1.0, abs=1e-3) and e.upper == pytest.approx(1.0)
    assert 0.9 < e.lower < 1.0


@pytest.mark.slow
def test_rebounds_tell_stiffness_and_restitution() -> None:
    column = hl.Column.paper(restitution=0.7)
    gaps = np.array([2e-4, 5e-4, 7e-4, 1e-3, 2e-3])
    truth = np.array([hl.newton(column.replace(gaps=g)).separation_velocity for g in gaps])
    values = truth + np.random.default_rng(4).normal(0.0, 0.02, gaps.size)
    data = hl.Rebounds.of_column(column, "separation_velocity", values, 0.02, gap=gaps)
    fitted = hl.fit(data, "linear", compare=False)
    for name, true in (("stiffness", 5e7), ("restitution", 0.7)):
        estimate = fitted.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.error < 0.2 * true
        assert estimate.lower < estimate.value < estimate.upper
    assert fitted.covariance.shape == (2, 2) and fitted.degrees == 3
    assert_legible(fitted.plot())


@pytest.mark.slow
def test_rebounds_tell_laws_apart() -> None:
    column = hl.Column.paper(restitution=0.7)
    gaps = np.geomspace(1e-4, 3e-3, 10)
    truth = np.array([hl.newton(column.replace(gaps=g)).separation_velocity for g in gaps])
    data = hl.Rebounds.of_column(column, "separation_velocity", truth, 0.01, gap=gaps)
    fitted = hl.fit(data, "linear")
    assert fitted.trials[0].name == "linear" and fitted.chi_square < 1e-3
    assert {t.name for t in fitted.others} == {"viscoelastic", "tsuji", "collisions with one ε"}
    assert all(t.probability < 0.01 for t in fitted.others)


# --- refusals -----------------------------------------------------------------------------------------------

PAPER = hl.Column.paper()
GOOD = hl.Impacts.of_restitution([1.0, 2.0, 3.0], [0.8, 0.79, 0.78], 0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"free": ["stiffness", "restitution"], "law": "linear"}, "stiffness: cannot be determined"),
        ({"free": ["stiffness"], "law": "linear"}, "stiffness: cannot be determined"),
        ({"free": ["youngs_modulus", "dissipative_time"]}, "youngs_modulus | dissipative_time: only a"),
        ({"free": ["restitution", "impact_speed"]}, "impact_speed: cannot be determined from"),
        ({"free": ["stiffness"]}, "fixed | free: got stiffness, must be parameters of Viscoelastic"),
        ({"fixed": {"restitution": 1.5}}, "restitution: got 1.5, must be in (0, 1]"),
        ({"fixed": {"restitution": 0.5}, "free": ["restitution"]}, "fixed | free: got restitution in both"),
        ({"fixed": {"restitution": 0.5, "dissipative_time": 1e-6}}, "fixed | free: got dissipative_time"),
        ({"free": "restitution"}, "free: got 'restitution', must be a list of names"),
        ({"fixed": 3}, "fixed: got 3, must be a mapping"),
        ({"law": "hertz"}, "law: got 'hertz', must be one of"),
        ({"confidence": 1.0}, "confidence: got 1, must be in [0.001, 0.999999]"),
        ({"confidence": math.nextafter(1.0, 0.0)}, "confidence: got 0.9999999999999999, must be in"),
        ({"confidence": 1e-300}, "confidence: got 1e-300, must be in"),
        ({"ball": 3}, "ball: got 3, must be a Ball"),
        ({"other": None}, "other: got None, must be a Ball or FLOOR"),
    ],
)
def test_what_cannot_be_fitted_is_refused(arguments: dict, message: str) -> None:
    assert refusal(lambda: hl.fit(GOOD, **({"ball": BALL} | arguments))).startswith(message)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: hl.fit([0.8]), "data: got [0.8], must be Impacts or Rebounds"),
        (lambda: hl.fit(hl.Impacts.of_restitution([1.0], [0.8])), "error: missing or 0"),
        (
            lambda: hl.fit(hl.Impacts.of_restitution([1.0], [0.8]), scatter=True),
            "data: got 1 values, must be 2",
        ),
        (lambda: hl.fit(GOOD, fixed={"dissipative_time": 1e-6}), "ball: missing"),
        (lambda: hl.Impacts.of_restitution([1.0, 0.0], [0.8, 0.8]), "speed[1]: got 0, must be > 0"),
        (lambda: hl.Impacts.of_restitution([1.0, 2.0], [0.8]), "restitution: got 1 values, must be 2"),
        (
            lambda: hl.Impacts.of_restitution([1.0], [0.8], 1e307),
            "restitution_error: got 1e+307, must be in [0, 1]",
        ),
        (lambda: hl.Impacts.of_restitution([1.0], [0.8], 0.01, 0.5), "speed_error[0]: got 0.5 for a value"),
        (lambda: hl.Impacts.of_heights([1.0, 0.5]), "heights[0]: got 1 values, must be 2 or more"),
        (lambda: hl.Impacts.of_heights(3.0), "heights: got 3.0, must be a list of drops"),
        (lambda: hl.Impacts.of_heights([[1.0, -0.5]]), "heights[0]: got -0.5, must be > 0"),
        (lambda: hl.Impacts.of_heights([[1.0, 0.5]], [0.1, 0.1]), "height_error: got 2 drops, must be 1"),
        (lambda: hl.Impacts.of_times([[0.0, 1.0]]), "times[0]: got 2 values, must be 3 or more"),
        (lambda: hl.Impacts.of_times([[0.0, 1.0, 0.9]]), "times[0][2]: got 0.9 s after 1 s, must be later"),
        (lambda: hl.Impacts.of_times([[0.0, 0.5, 1.3]]), "times[0][2]: got a flight of 0.8 s after one"),
        (lambda: hl.Rebounds.of_column(3, "top_velocity", [1.0]), "column: got 3, must be a Column of two"),
        (lambda: hl.Rebounds.of_column(hl.Column.paper(), "mass", [1.0]), "observable: got 'mass'"),
        (
            lambda: hl.Rebounds.of_column(PAPER, "top_height", [1.0], height=[0.01]),
            "column[0]: height: got 0.01",
        ),
    ],
)
def test_bad_data_are_refused(make: object, message: str) -> None:
    assert refusal(make).startswith(message)


# --- files and command line ---------------------------------------------------------------------------------


run, printed = partial(command_line.run, "fit"), partial(command_line.printed, "fit")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "got 0 lines besides comments, must be a header and rows"),
        ("# only\nspeed,restitution\n", "got 1 lines besides comments"),
        ("speed,restitution\n1,x\n", "line 2, column restitution: got 'x', must be a number > 0"),
        ("speed,restitution\n1,0.8\n\n-2,0.8\n", "line 4, column speed: got -2, must be > 0"),
        ("speed,restitution\n1,0.8,0.1\n", "line 2: got 3 cells, must be 2"),
        ("speed,restitution\n1,nan\n", "line 2, column restitution: got nan, must be > 0"),
        ("speed,restitution,restitution_error\n1,0.8,-1\n", "column restitution_error: got -1, must be >= 0"),
        ("speed,mass\n1,2\n", "line 1: got columns 'speed, mass', must hold speed, restitution |"),
        ("speed restitution\n1 0.8\n", "with comma, semicolon or tab between cells"),
        ("speed,restitution\n1,0.8\n2,1.2\n", "line 3, column restitution: got 1.2, must be in (0, 1]"),
        ("speed;restitution;restitution_error\n1;1.2;0.03\n", "line 2, column restitution: got 1.2, must be"),
        ("drop_height,rebound_height\n1,0.8\n1,1.5\n", "line 3, column rebound_height: got a rebound of 1.5"),
        ("drop\theight\n1\t1\n1\t0.5\n2\t1\n2\t1.5\n", "line 5, column height: got a rebound of 1.5 m"),
        ("time\n0\n1\n2.1\n", "line 4, column time: got a flight of 1.1 s after one of 1 s, must be shorter"),
        ("speed,speed\n1,2\n", "line 1: got column speed twice"),
        ("speed [kg],restitution\n1,0.8\n", "line 1: speed: got '1 kg', must be a number [m/s]"),
        ("speed\n1\n2\n", "line 1: got columns 'speed', must hold speed, restitution |"),
        ("# c\ntime\n0\n1\n0.5\n", "line 5, column time: got 0.5 s after 1 s, must be later"),
        ("drop,time\n1,0\n1,1\n2,0\n2,1\n2,1.5\n", "lines 2 to 3, column time: got 2 values, must be 3"),
        ("drop,time\n1,0\n2,0\n1,1\n2,1\n1,1.5\n2,2.9\n", "line 7, column time: got a flight of 1.9 s"),
        ("height,height_error\n1,0.5\n0.5,0.1\n", "line 2, column height_error: got 0.5 for a value of 1"),
        ("top_height\n1\n", "column: missing, must be the Column whose top_height was measured"),
    ],
)
def test_faults_of_a_file_are_named_by_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "data.csv"
    file.write_text(text, encoding="utf-8")
    assert message in command_line.refused("fit", file)


def test_files_are_read_with_their_units(tmp_path: Path) -> None:
    file = tmp_path / "data.csv"
    h = peaks(viscoelastic(), 0.5, 4)
    rows = [f"7,{100.0 * x!r},1" for x in h.tolist()]
    file.write_text("drop,height [cm],height_error [mm]\n" + "\n".join(rows), encoding="utf-8")
    data, direct = hl.read_measurements(file), hl.Impacts.of_heights([h], 1e-3)
    np.testing.assert_allclose(data.speed, direct.speed, rtol=1e-14)
    np.testing.assert_allclose(data.restitution_error, direct.restitution_error, rtol=1e-12)


@pytest.mark.parametrize("separator", [",", ";", "\t", " ; ", "\t "])
@pytest.mark.parametrize("extra", [False, True])
def test_separators_are_told_and_other_columns_ignored(tmp_path: Path, separator: str, extra: bool) -> None:
    file = tmp_path / "data.csv"
    head = ("speed [cm/s]", "restitution", "restitution_error")
    rows = [head, ("100", "0.8", "0.01"), ("200", "1.01", "0.01")]
    more = [("my note, or two" if separator.strip() != "," else "note", "gap"), ("first", "1"), ("", "x")]
    rows = [(*row[:1], *other, *row[1:]) for row, other in zip(rows, more, strict=True)] if extra else rows
    file.write_text("\r\n".join(separator.join(row) for row in rows), encoding="utf-8")
    result = run(file, "--json")
    known = "speed, restitution, restitution_error, speed_error"
    said = f"column {more[0][0]!r}, 'gap' is ignored: it is not one of {known}"
    assert (said in result.stderr) == extra and len(result.stderr.splitlines()) == extra
    assert json.loads(result.stdout)["data"]["speed"] == pytest.approx([1.0, 2.0])
    if extra:
        with pytest.warns(UserWarning, match="is ignored"):
            hl.read_measurements(file)


def test_values_above_their_limit_by_an_error_are_data() -> None:
    """Noise may move ε above 1, but not by more than five errors, and not without errors."""
    hl.Impacts.of_restitution([1.0], [1.04], 0.01)
    hl.Impacts.of_rebound_heights([1.0], [1.04], 0.01)
    hl.Impacts.of_heights([[1.0, 1.0, 1.05]], 0.01)
    of = hl.Impacts
    for make, message in (
        (lambda: of.of_restitution([1.0, 2.0], [1.0, 1.06], 0.01), "restitution[1]: got 1.06, must be in"),
        (lambda: of.of_restitution([1.0], [1.000001]), "restitution[0]: got 1"),
        (lambda: of.of_rebound_heights([1.0] * 2, [0.8, 1.06], 0.01), "rebound_height[1]: got a rebound of"),
        (lambda: of.of_heights([[1.0, 0.9], [1.0, 1.08]], 0.01), "heights[1][1]: got a rebound of 1.08 m"),
        (lambda: of.of_times([[0.0, 1.0, 2.2]], 0.01), "times[0][2]: got a flight of 1.2 s"),
    ):
        assert refusal(make).startswith(message)


@pytest.mark.slow
def test_the_command_fits_its_example(tmp_path: Path) -> None:
    file, picture = tmp_path / "impacts.csv", tmp_path / "fit.png"
    file.write_text(run("--example").stdout, encoding="utf-8")
    text = run(file, "--plot", picture).stdout
    assert "Viscoelastic describes the data" in " ".join(text.split())
    assert coloured(picture) > 3e-3
    output = printed(file)
    direct = hl.fit(hl.read_measurements(file))
    assert output["parameters"]["restitution"]["value"] == direct.parameters["restitution"].value
    assert output["verdict"] == direct.verdict and len(output["data"]["speed"]) == output["n"] == 16
    assert_legible(direct.plot())


def test_a_column_from_a_file_and_its_rebounds(tmp_path: Path) -> None:
    column = hl.Column.paper(restitution=0.9, gap=3e-3)
    toml, file = tmp_path / "column.toml", tmp_path / "data.csv"
    command_line.run("drop", "--restitution", "0.9", "--toml", toml)
    value = hl.newton(column).separation_velocity
    file.write_text(f"gap,separation_velocity,separation_velocity_error\n3e-3,{value!r},0.01\n")
    output = printed(file, "--column", toml, "--stiffness", "5e7", "--no-compare")
    assert output["parameters"]["restitution"]["value"] == pytest.approx(0.9, abs=1e-4)


def test_refusals_of_the_command(tmp_path: Path) -> None:
    refused = partial(command_line.refused, "fit")
    assert "FILE: missing" in refused()
    assert "FILE: must be left out with --example" in refused("x.csv", "--example")
    missing = tmp_path / "none.csv"
    assert refused(missing).endswith(f"fit: {missing}: no such file")


@pytest.mark.parametrize(("law", "fits"), [("linear", 4), slow("linear", 12), slow("viscoelastic", 12)])
def test_the_error_at_a_limit_is_not_too_small(law: str, fits: int) -> None:
    """ε of 0.999, measured three times to 0.01: of the fits, many end at the limit 1."""
    rng = np.random.default_rng(3)
    for _ in range(fits):
        values = 0.999 + 0.01 * rng.standard_normal(3)
        estimate = hl.fit(hl.Impacts.of_restitution([1.0, 1.0, 1.0], values, 0.01), law).parameters[
            "restitution"
        ]
        assert 0.3 * 0.01 / math.sqrt(3.0) < estimate.error < 1.5 * 0.01 / math.sqrt(3.0)


def test_values_that_agree_exactly_have_no_scatter() -> None:
    with pytest.raises(ValueError, match="scatter: got values that agree with the law exactly"):
        hl.fit(hl.Impacts.of_restitution([1.0, 2.0, 3.0, 4.0], [0.9] * 4), "linear", scatter=True)


@pytest.mark.parametrize("errors", [[0, 0.01, 0, 0.01], [0, 0.01, 0.01, 0]])
def test_a_chain_needs_as_many_errors_as_impacts(errors: list[float]) -> None:
    heights = [[1.0, 0.64, 0.41, 0.26]]
    with pytest.raises(ValueError, match="error: missing or 0 for some values"):
        hl.fit(hl.Impacts.of_heights(heights, [errors]), "linear")
    hl.fit(hl.Impacts.of_heights(heights, [[0, 0.01, 0.01, 0.01]]), "linear")
