"""Numbers of grains at rest as ``check`` prints them, against those recorded in LAMMPS, LIGGGHTS and YADE."""

from pathlib import Path

import pytest

import hardlimit as hl
from conftest import table

STATES = Path(__file__).parent / "data/states"
MEASURED = {row["script"]: row for row in table("script_states")}
#: Grains of two kinds or of a range of sizes, with how much longer steps may be than that of check, which takes the
#: lightest grains and the stiffest contacts. YADE's numerical damping helps as well.
UNEQUAL = {"lammps_settled_hertz": 1.9, "lammps_hopper_loop": 1.25, "yade_triaxial": 1.35}


@pytest.fixture(scope="module", params=MEASURED)
def state(request):
    """The row of a script, and what is said of it with the dump of its grains at rest."""
    dump = None if "triaxial" in request.param else STATES / f"{request.param}.dump.gz"
    verdict = hl.check(STATES / request.param, dump=dump, speed=0.1)
    assert not verdict.admissible
    return MEASURED[request.param], verdict.state


def test_the_longest_stable_step_is_that_of_the_code(state):
    """The code is stable at 0.9 of it; at 1.1 of it, it blows up if all grains are equal."""
    row, said = state
    ratio = float(row["largest_stable_step"]) / said.largest_stable_step
    assert 0.9 < ratio < UNEQUAL.get(row["script"], 1.1)


def test_the_mean_overlap_is_that_in_the_code(state):
    """Within 10 %: 3.9 % above LAMMPS (linear), 9.7 % above LIGGGHTS (Hertz; 19 % at the mean force)."""
    row, said = state
    if row["script"] not in UNEQUAL:
        assert said.overlap == pytest.approx(float(row["overlap"]), rel=0.1)
        assert said.coordination == pytest.approx(float(row["coordination"]), rel=0.05)


def test_grains_in_many_contacts_rest_although_their_contacts_would_overlap_in_time():
    """In a dump without velocities, at speeds that were chosen, t_c ν may be large."""
    name = "liggghts_settled_bed"
    verdict = hl.check(STATES / name, dump=STATES / f"{name}.dump.gz")
    assert verdict.state.name == "rest" and verdict.admissible is False
    assert any("contacts last" in finding.what for finding in verdict.invalidates)
