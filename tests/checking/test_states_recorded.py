"""Numbers of grains at rest as ``check`` prints them, against those recorded in LAMMPS, LIGGGHTS and YADE."""

import math
from pathlib import Path

import pytest
from stand_ins import stand_ins

import hardlimit as hl
from conftest import table
from hardlimit.checking import flows, scripts, state_words

STATES = Path(__file__).parent / "data/states"
MEASURED = {row["script"]: row for row in table("script_states")}
MOTIONS = {row["script"]: row for row in table("script_motions")}
#: Grains of two kinds or of a range of sizes, with how much longer steps may be than that of check, which is safe.
#: YADE's numerical damping helps as well; of the two materials the few grains at the bottom have the stiffest contacts.
UNEQUAL = {
    "lammps_settled_hertz": 1.7,
    "lammps_two_sizes": 1.25,
    "lammps_hertz_sizes": 1.25,
    "liggghts_three_sizes": 1.2,
    "lammps_hopper_loop": 1.15,
    "yade_triaxial": 1.15,
}
#: Relative difference of the overlap, beside two standard errors where it is a mean over beds. Not known are those of
#: 160 grains of two materials and of four layers of grains, of which few contacts are in the middle.
OVERLAP = 0.05
OVERLAPS = (
    "lammps_settled_bed",
    "lammps_two_sizes",
    "lammps_hertz_sizes",
    "liggghts_settled_bed",
    "liggghts_three_sizes",
    "yade_triaxial",
)


@pytest.fixture(scope="module", params=MEASURED)
def state(request):
    """The row of a script, and what is said of it with the dump of its grains at rest."""
    dump = None if "triaxial" in request.param else STATES / f"{request.param}.dump.gz"
    with pytest.MonkeyPatch.context() as patch:
        stand_ins(patch)
        verdict = hl.check(STATES / request.param, dump=dump, speed=0.1)
    assert not verdict.admissible
    return MEASURED[request.param], verdict.state


def test_the_longest_stable_step_is_that_of_the_code(state):
    """The code is stable at 0.9 of it; at 1.1 of it, it blows up if all grains are equal."""
    row, said = state
    ratio = float(row["largest_stable_step"]) / said.largest_stable_step
    assert 0.9 < ratio < UNEQUAL.get(row["script"], 1.1)


def test_the_mean_overlap_is_that_in_the_code(state):
    """Linear and Hertz, equal and unequal, settled and pressed; YADE's cell is in the range that is said."""
    row, said = state
    if row["script"] in OVERLAPS:
        overlap, error = float(row["overlap"]), float(row["overlap_error"] or 0.0)
        assert said.overlap == pytest.approx(overlap, abs=OVERLAP * overlap + 2.0 * error)
        assert error < 0.03 * overlap
        assert said.overlap_of == "all contacts"
    assert (said.overlap_range is not None) is (row["script"] == "yade_triaxial")
    if said.overlap_range is not None:
        assert said.overlap_range[0] < float(row["overlap"]) < said.overlap_range[1]


def test_the_overlap_in_a_cone_is_at_most_that_below_the_same_height(state):
    """Its walls carry a part of the weight: a fifth of the overlap at the bottom."""
    row, said = state
    if row["script"] == "lammps_hopper_loop":
        assert said.pressure_is_bound and 1.0 < said.overlap / float(row["overlap"]) < 1.25


def test_grains_in_many_contacts_rest_although_their_contacts_would_overlap_in_time():
    """In a dump without velocities, at speeds that were chosen, t_c ν may be large."""
    name = "liggghts_settled_bed"
    verdict = hl.check(STATES / name, dump=STATES / f"{name}.dump.gz")
    assert verdict.state.name == "rest" and verdict.admissible is False
    assert any("contacts last" in finding.what for finding in verdict.invalidates)


@pytest.mark.parametrize("name", [name for name, row in MOTIONS.items() if row["gamma"]])
def test_shaken_plates_move_as_check_says(name):
    """Γ and S of the sine through the places of the wall in the code."""
    said, row = hl.check(STATES / name).state, MOTIONS[name]
    assert said.shaking == pytest.approx(float(row["gamma"]), rel=1e-3)
    assert said.shaking_strength == pytest.approx(float(row["strength"]), rel=1e-3)


@pytest.mark.parametrize("name", [name for name, row in MOTIONS.items() if row["shear_rate"]])
def test_the_inertial_number_is_that_of_the_flow_in_the_code(name):
    """Of a chute in lj units and of the flowing layer of a drum, at their shear rate and pressure."""
    row = MOTIONS[name]
    options = {"shear_rate": float(row["shear_rate"]), "pressure": float(row["pressure"])}
    said = hl.check(STATES / name, **options).state
    drawn = 5e-3 if name == "yade_dense_shear" else 1e-3  # the mean of its radii is not that of their range
    assert said.inertial_number == pytest.approx(float(row["inertial_number"]), rel=drawn)
    assert said.regime == ("collisional" if name == "lammps_chute" else "dense")


def test_a_dense_box_is_sheared_in_lammps_as_our_own_are():
    """Its stress ratio is that of our boxes at its I; overlaps are three times those of a packing at rest."""
    name = "lammps_dense_shear"
    row = MOTIONS[name]
    low, high = flows.on_slope(math.degrees(math.atan(float(row["stress_ratio"]))), 0.5)
    assert low < float(row["inertial_number"]) < high
    verdict = hl.check(STATES / name, pressure=float(row["pressure"]))
    assert verdict.admissible is False and verdict.state.regime == "dense"
    assert 2.0 < float(row["overlap"]) / verdict.state.overlap < 8.0 and "overlap" not in verdict.sentence
    assert "1 to 8 times that" in " ".join(state_words.details(verdict))


def test_a_dense_cell_is_sheared_in_yade_as_check_says():
    """Slow and soft: the overlap is nearly that at rest, and the step that of a packing, on the safe side."""
    name = "yade_dense_shear"
    row = {
        key: float(value)
        for key, value in MOTIONS[name].items()
        if key not in ("script", "version") and value
    }
    verdict = hl.check(STATES / name, pressure=row["pressure"])
    said = verdict.state
    assert verdict.admissible is False and said.regime == "dense" and said.overlap_of == "all contacts"
    assert said.inertial_number == pytest.approx(row["inertial_number"], rel=5e-3)
    ratio = flows.rest_ratio(0.5) + flows.RISE / (1.0 + flows.SCALE / said.inertial_number)
    assert row["stress_ratio"] == pytest.approx(ratio, abs=0.03)
    assert 1.0 < row["overlap"] / said.overlap < 1.2
    assert 0.9 < row["largest_stable_step"] / said.largest_stable_step < 1.25


def test_the_numbers_of_a_distribution_are_those_that_the_code_inserts():
    """LIGGGHTS' shares are of the mass: 398, 177 and 125 of 700 grains; the script alone says what its dump says."""
    name = "liggghts_three_sizes"
    (stage,) = scripts.read((STATES / name).read_text(encoding="utf-8")).stages
    assert [lot.number for lot in stage.contents.lots] == pytest.approx([398, 177, 125], abs=0.5)
    alone, dumped = (
        hl.check(STATES / name, dump=dump, speed=0.1).state for dump in (None, STATES / f"{name}.dump.gz")
    )
    assert alone.pressure == pytest.approx(dumped.pressure, rel=2e-3)
    assert alone.overlap == pytest.approx(dumped.overlap, rel=5e-3)
