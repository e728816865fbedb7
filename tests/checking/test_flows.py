"""What check says of slopes and drums from the script alone."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import hardlimit as hl
from conftest import slow, table
from hardlimit.checking import flows
from hardlimit.checking.state_words import details

STATES = Path(__file__).parent / "data/states"
STUDY = Path(__file__).parents[2] / "studies/dense_flow.nc"


def text(name, *changes):
    script = (STATES / name).read_text(encoding="utf-8")
    for before, after in changes:
        assert before in script
        script = script.replace(before, after)
    return script


# --- slopes -----------------------------------------------------------------------------------------------------


def test_every_measured_flow_is_within_the_band():
    """Of all sheared boxes up to the largest I: it is in the band at the angle whose tangent is their stress ratio."""
    data = xr.load_dataset(STUDY).stack(run=("restitution", "stiffness", "looser", "replica"))
    for mu in flows.SLOPES:
        rows = data.sel(friction=mu).dropna("run", subset=["inertial_number"])
        slow = rows.where(rows.inertial_number < flows.FASTEST, drop=True)
        assert slow.sizes["run"] >= 12
        for inertial, ratio in zip(slow.inertial_number.values, slow.stress_ratio.values, strict=True):
            low, high = flows.on_slope(math.degrees(math.atan(ratio)), mu)
            assert low <= inertial <= high


def test_a_steeper_or_smoother_slope_flows_faster():
    """Of random slopes: the range grows with the angle and falls with μ; it is zero, then finite, then infinite."""
    random = np.random.default_rng(7)
    for _ in range(300):
        mu, tilt = random.uniform(0.1, 1.0), random.uniform(1.0, 60.0)
        low, high = flows.on_slope(tilt, mu)
        steeper = flows.on_slope(tilt + random.uniform(0.1, 5.0), mu)
        rougher = flows.on_slope(tilt, random.uniform(mu, 1.0))
        assert 0.0 <= low <= high and low <= steeper[0] and high <= steeper[1] and low >= rougher[0]
        assert all(value <= flows.FASTEST or value == math.inf for value in (low, high))
        assert (high == 0.0) <= (math.tan(math.radians(tilt)) < flows.rest_ratio(mu))
        inertial = random.uniform(0.0, 0.95) * flows.FASTEST
        low, high = flows.on_slope(math.degrees(math.atan(flows.stress_ratio(inertial, mu))), mu)
        assert low <= inertial <= high
    for mu in flows.SLOPES:
        assert flows.on_slope(10.0, mu) == (0.0, 0.0) and flows.on_slope(45.0, mu) == (math.inf, math.inf)


def test_smooth_grains_flow_down_gentle_slopes():
    """Of μ = 0.1 from 13.2° on; with μ = 0.5 they rest, and up to 15° nothing is said of the slope."""
    smooth = ("NULL 50 NULL 0.5 0", "NULL 50 NULL 0.1 0")
    for tilt, words in ((14.5, "flows with I up to"), (13.0, "")):
        at = ("chute 24.0", f"chute {tilt}")
        verdict = hl.check(text("lammps_chute", smooth, at))
        assert (words in verdict.sentence) and (("tilted" in verdict.sentence) is bool(words))
        assert "tilted" not in hl.check(text("lammps_chute", at)).sentence


def test_a_deep_layer_on_a_rough_base_flows_as_said():
    """In LAMMPS, μ = 0.5 at 24°; ``lammps_chute``, a thin layer over a flat base, has three times this I."""
    (row,) = (row for row in table("script_motions") if row["script"] == "lammps_rough_chute")
    verdict = hl.check(STATES / row["script"])
    low, high = verdict.state.slope_inertial_number
    assert low < float(row["inertial_number"]) < high < 2.5 * low
    assert "a deep layer flows with I = 0.066 to 0.15, on a flat one it may slide faster" in verdict.sentence
    assert "overlap" not in verdict.sentence and "At rest the overlap would be" in " ".join(details(verdict))


@pytest.mark.parametrize(
    ("mu", "tilt", "inertial"),
    [("0.1", "20.0", (0.168, 0.172)), ("1.0", "25.0", (0.131, 0.116))],
)
def test_other_frictions_flow_in_lammps_as_said(mu, tilt, inertial):
    """``lammps_rough_chute`` with another μ and angle (22 Jul 2025, two parts, as tools/verify_motion.py)."""
    changes = ("5714.285714285715 0.0 0.5", f"5714.285714285715 0.0 {mu}"), ("chute 24.0", f"chute {tilt}")
    low, high = hl.check(text("lammps_rough_chute", *changes)).state.slope_inertial_number
    assert all(low < part < high for part in inertial) and high < 4.0 * low


@pytest.mark.parametrize(
    ("tilt", "words"),
    [
        (16.0, "on a rough base a deep layer rests below 21°."),
        (20.7, "flows with I up to 0.039, or rests"),
        (29.0, "may get faster and faster, or flows with I > 0.28; contacts last below I = 0.12."),
        (45.0, "gets faster and faster, or flows with I > 0.4; contacts last below I = 0.067."),
    ],
)
def test_layers_rest_flow_or_get_faster(tilt, words):
    assert words in hl.check(text("lammps_chute", ("chute 24.0", f"chute {tilt}"))).sentence


@pytest.mark.parametrize("slopes", [15, slow(60)])
def test_a_slope_and_its_own_shear_have_one_answer(slopes):
    """Of random slopes: a No holds for --shear with each I of their range, and what cannot be said does not for all."""
    random = np.random.default_rng(5)
    answers = []
    for _ in range(slopes):
        stiffness, damping = 10.0 ** random.uniform(3, 7), random.uniform(0.02, 0.4)
        mu = random.uniform(0.1, 1.0)
        spring = f"{stiffness:.4g} NULL {damping * stiffness**0.5:.4g} NULL {mu:.3f} 0"
        changes = (
            ("chute 24.0", f"chute {random.uniform(15.5, 32.0):.2f}"),
            ("2e5 NULL 50 NULL 0.5 0", spring),
        )
        bed, height = text("lammps_chute", *changes), 10.0 ** random.uniform(0.5, 2.0)
        verdict = hl.check(bed, height=height)
        state = verdict.state
        if state.slope_inertial_number is None:  # ε outside the measured range
            continue
        low, high = state.slope_inertial_number
        answers.append(verdict.admissible)
        at = []
        for inertial in (max(low, 1e-4), min(high, 1.0)):
            if not 0.0 < inertial < math.inf:
                continue
            sheared = hl.check(bed, height=height, shear_rate=inertial * math.sqrt(state.pressure))
            assert sheared.state.inertial_number == pytest.approx(inertial)
            assert sheared.state.collisional_from == pytest.approx(state.collisional_from)
            at.append(sheared.admissible)
        assert at[-1] is verdict.admissible if at else verdict.admissible is None
        assert ("contacts last below" in verdict.sentence) is (verdict.admissible is None)
    assert slopes / 10 < answers.count(None) < 0.9 * slopes


@pytest.mark.parametrize(("mu", "share"), [(0.05, 0.8), (0.2, 0.9), (0.6, 1.0), (1.0, 0.6), (1.5, 0.6)])
def test_contacts_last_to_the_border_of_their_friction(mu, share):
    """Over that of μ = 0.5, under the same shear."""
    rubs = ("NULL 50 NULL 0.5 0", f"NULL 50 NULL {mu} 0")
    border, usual = (
        hl.check(text("lammps_chute", *change), shear_rate=0.1).state.collisional_from
        for change in ([rubs], [])
    )
    assert border == pytest.approx(share * usual)


def test_of_several_frictions_the_lowest_border_counts():
    """A base of μ = 1 below grains of 0.5."""
    line = next(line for line in text("lammps_rough_chute").splitlines() if line.startswith("pair_coeff"))
    rougher = line.replace("* *", "1 2").removesuffix("0.5") + "1.0"
    border, usual = (
        hl.check(text("lammps_rough_chute", (line, lines)), shear_rate=0.1).state.collisional_from
        for lines in (f"{line}\n{rougher}", line)
    )
    assert border == pytest.approx(0.6 * usual)


@pytest.mark.parametrize(
    "change",
    [
        ("NULL 50 NULL 0.5 0", "NULL 50 NULL 1.2 0"),  # μ beyond the measured ones
        ("NULL 50 NULL 0.5 0", "NULL 5000 NULL 0.5 0"),  # ε near 0
        ("gran/hooke/history", "gran/hooke"),  # no tangential spring
        ("units lj", "units lj\ndimension 2"),
    ],
)
def test_other_grains_have_no_number(change):
    verdict = hl.check(text("lammps_chute", change))
    assert verdict.state.slope_inertial_number is None and "24°: if they flow, --shear" in verdict.sentence


def test_grains_that_resist_rolling_have_no_number():
    words = "hooke 2e5 0.5 damping coeff_restitution tangential linear_history 5e4 0 0.5"
    style = (
        "pair_style gran/hooke/history 2e5 NULL 50 NULL 0.5 0\npair_coeff * *",
        "pair_style granular\npair_coeff * * ",
    )
    plain = hl.check(text("lammps_chute", (style[0], style[1] + words))).state
    rolls = hl.check(text("lammps_chute", (style[0], f"{style[1]}{words} rolling sds 5e4 20 0.1"))).state
    assert plain.slope_inertial_number is not None and rolls.slope_inertial_number is None


# --- drums ------------------------------------------------------------------------------------------------------


def test_a_cylinder_about_its_axis_has_a_froude_number():
    """ω²R/g of a region of LAMMPS that turns by PI in a unit of time."""
    verdict = hl.check(STATES / "lammps_turning_drum")
    assert verdict.state.froude_number == pytest.approx(math.pi**2 * 0.025 / 9.81)
    assert "No: grains rest or flow in lasting contact under gravity" in verdict.sentence
    assert "Fr = ω²R/g = 0.025: cascading." in verdict.sentence
    fast = text("lammps_turning_drum", ("equal PI*time", "equal 8*PI*(time-1)"))
    assert hl.check(fast).state.froude_number == pytest.approx(64 * math.pi**2 * 0.025 / 9.81)
    assert "centrifuging" in hl.check(fast).sentence
    by_steps = text("lammps_turning_drum", ("equal PI*time", "equal PI*step*5e-6"))
    assert hl.check(by_steps).state.froude_number == pytest.approx(verdict.state.froude_number)


@pytest.mark.parametrize(("rate", "collisional"), [(2.0, False), (5.0, False), (6.0, True), (20.0, True)])
def test_blades_that_turn_about_gravity_may_throw_grains(rate, collisional):
    """At ω²R/g = 1.1 at the side of the box, grains in LAMMPS had 0.5 contacts on average."""
    blade = "block -0.02 0.02 -0.002 0.002 0 0.005 side out rotate v_angle 0 0 0 0 0 1"
    mixer = text(
        "lammps_turning_drum",
        ("equal PI*time", f"equal {rate}*PI*time"),
        ("cylinder z 0 0 0.025 INF INF rotate v_angle 0 0 0 0 0 1", blade),
        ("vector 0 -1 0", "vector 0 0 -1"),
        ("boundary f f p", "boundary f f f"),
    )
    verdict = hl.check(mixer)
    froude = (rate * math.pi) ** 2 * 0.03 / 9.81
    assert verdict.state.mixer_froude_number == pytest.approx(froude)
    assert verdict.admissible is (None if collisional else False) and (froude >= 1.0) is collisional
    assert ("a mixer in which contacts may not last" in verdict.sentence) is collisional
    assert hl.check(text("lammps_turning_drum")).state.mixer_froude_number is None


@pytest.mark.parametrize(
    ("change", "known"),
    [
        (("equal PI*time", "equal PI*time^2"), None),
        (("equal PI*time", "equal ramp(0,1)"), None),
        (("0 0 0 0 0 1", "0 0 0 0 1 0"), None),  # about an axis along gravity: no drum
        (("0 0 0 0 0 1", "0.01 0 0 0 0 1"), "radius"),  # not about its own axis
        (("INF INF rotate", "INF INF side out rotate"), "radius"),  # grains around it
    ],
)
def test_other_rotations_have_none(change, known):
    state = hl.check(text("lammps_turning_drum", change)).state
    assert state.froude_number is None
    border = None if known is None else pytest.approx(9.81 / math.pi**2)
    assert state.centrifuging_radius == border


@pytest.mark.parametrize(
    ("name", "rate"), [("liggghts_turning_drum", 2.0 * math.pi / 3.0), ("yade_turning_drum", 2.0)]
)
def test_a_mesh_has_the_radius_at_which_it_centrifuges(name, rate):
    verdict = hl.check(STATES / name)
    assert verdict.state.centrifuging_radius == pytest.approx(9.81 / rate**2)
    assert "In a drum that turns so grains roll up to R = 2." in verdict.sentence
    assert verdict.state.rolling_radius == pytest.approx(0.01 * verdict.state.centrifuging_radius)
    assert ", are thrown from 2" in verdict.sentence


def test_a_drum_smaller_than_its_grains_does_not_roll():
    """As of an hourglass that is turned over; only the radius from which on it throws grains is left."""
    verdict = hl.check(text("liggghts_turning_drum", ("radius constant 0.003", "radius constant 0.006")))
    assert verdict.state.rolling_radius is None and "rolling" not in verdict.sentence
    assert "A drum that turns so throws its grains from R = 22 cm on" in verdict.sentence


@pytest.mark.parametrize("turns,thrown", [(1, False), (3, True)])
def test_contacts_in_a_drum_that_throws_its_grains_may_not_last(turns, thrown):
    verdict = hl.check(text("lammps_turning_drum", ("equal PI*time", f"equal {turns}*PI*time")))
    assert verdict.admissible is (None if thrown else False)
    assert ("Cannot be said: a drum in which contacts may not last" in verdict.sentence) is thrown
    assert ("cataracting" in verdict.sentence) is thrown


def test_the_radius_is_in_metres_in_every_unit():
    cgs = text(
        "liggghts_turning_drum",
        ("units si", "units cgs"),
        ("gravity 9.81", "gravity 981"),
    )
    assert hl.check(cgs).state.centrifuging_radius == pytest.approx(9.81 / (2.0 * math.pi / 3.0) ** 2)


@pytest.mark.parametrize("name", ["lammps_dense_shear", "yade_dense_shear"])
def test_a_sheared_cell_of_unknown_pressure_asks_for_it(name: str) -> None:
    request = "--pressure gives the inertial number"
    assert request in hl.check(STATES / name).sentence
    flow = hl.check(STATES / name, pressure=465.0)
    assert request not in flow.sentence and flow.state.regime == "dense"
