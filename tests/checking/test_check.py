"""``hl.check`` and ``hardlimit check``: contacts, the answer, corrected lines, JSON, exit codes, bad input."""

import dataclasses
import itertools
import json
import math
import pickle
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from command_line import printed, refused, run
from conftest import draws, log_floats, slow
from hardlimit.boxes import theory
from hardlimit.boxes.error_law import error_law
from hardlimit.checking.options import Options
from hardlimit.checking.script_check import checked_script
from hardlimit.checking.scripts import ContactSettings, Description, Grains, Note, Quote, Setting, Stage
from hardlimit.cli.check import cells, corrections
from hardlimit.support.formatting import listed

BEAD = hl.Ball(1e-3, density=2500.0)
DATA = Path(__file__).parent / "data"
NUMBERS = (
    "--radius 1mm --density 2500 --stiffness 1e5 --restitution 0.9 --speed 0.3m/s --packing-fraction 0.3"
)
NONE = Options(None, (), None, {})


def script(
    contact: str, *more: str, units: str = "si", grains: str = "set type 1 diameter 2e-3 density 2500"
) -> str:
    """A LAMMPS script of grains in a periodic box."""
    return "\n".join(
        [
            f"units {units}\natom_style sphere\nboundary p p p\nregion box block 0 1 0 1 0 1\ncreate_box 1 box",
            f"create_atoms 1 random 100 7 box\n{grains}\n{contact}",
            *more,
            "fix move all nve/sphere\ntimestep 1e-7\nrun 100\n",
        ]
    )  # fmt: skip


TANGENTIAL = "tangential linear_nohistory 0.0 0.0"
HOOKE = f"pair_style granular\npair_coeff * * hooke 1e5 0.9 damping coeff_restitution {TANGENTIAL}"
CLIPPED = f"{HOOKE} limit_damping"
MATERIAL = f"hertz/material 1e7 0.7 0.3 damping coeff_restitution {TANGENTIAL} limit_damping"
HERTZ = f"pair_style granular\npair_coeff * * {MATERIAL}"
WALL = f"fix floor all wall/gran granular hooke 1e5 0.5 damping coeff_restitution {TANGENTIAL} zplane 0 1"


def described(units="lj", **changed) -> Description:
    """A description of gran/hertz/history with one damping for grains of two sizes, in lj units."""
    m = 4 / 3 * math.pi * 0.3**3
    a = (2 * math.log(10) / math.pi) ** 2
    gamma = math.sqrt(a * 2e5 / m / (1 + 0.25 * a))
    step = 0.02 * math.pi / math.sqrt(2e5 / m - gamma / 4)
    quote = Quote("in.mixer", 7, "run 1000")
    normal = {"normal": Setting(("gran/hertz", "1e5", repr(gamma)), 1, "")}
    pairs = (
        ContactSettings(("1", "1"), None, normal, (quote,)),
        ContactSettings(("1", "wall"), "w", normal, (quote,)),
    )
    stage = Stage(quote, step, True, 1000, pairs, {"1": Grains("1", (0.3, 0.6), (1.0, 1.0))}, 1.0, None,
                  units=units, units_given=False)  # fmt: skip
    return Description(**{"code": "lammps", "version": None, "stages": (stage,)} | changed)


# --- contacts -------------------------------------------------------------------------------------------------


def test_one_damping_for_all_sizes_gives_several_restitutions():
    """Numbers of LAMMPS' own example of a mixer, with the natural logarithm in its formula for the damping."""
    verdict = checked_script(described(), Options(None, (1.0,), None, {}))
    assert [round(row.restitution, 3) for row in verdict.rows] == [0.805, 0.428, 0.688, 0.224]
    assert [float(f"{row.duration:.3g}") for row in verdict.rows] == [0.0153, 0.0337, 0.0179, 0.0445]
    assert [row.steps_per_contact for row in verdict.rows] == [323, 713, 379, 941]
    assert verdict.admissible is False and "rest on each other under gravity" in verdict.sentence
    assert "from 0.224 to 0.805" in " ".join(verdict.remarks)


@pytest.mark.parametrize("law", [
    hl.LinearDashpot(stiffness=1e5, restitution=0.8),
    hl.Tsuji(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.8),
    hl.Viscoelastic(youngs_modulus=1e8, poisson_ratio=0.3, restitution=0.8, impact_speed=1.0),
])  # fmt: skip
def test_our_own_laws_are_the_same_contacts(law):
    for other, row in zip((BEAD, hl.FLOOR), hl.check(BEAD, law=law, speed=0.4).rows, strict=True):
        contact = law.between(BEAD, other)
        assert row.restitution == pytest.approx(contact.restitution(0.4), abs=1e-9)
        assert row.duration == pytest.approx(contact.duration(0.4), rel=1e-9)
        assert row.largest_overlap == pytest.approx(contact.compression(0.4) / 1e-3, rel=1e-9)


def test_what_does_not_depend_on_an_unknown_is_known():
    """ε of coeff_restitution depends on neither size nor speed; the duration of a linear spring on the mass."""
    unknown = hl.check(script(CLIPPED, grains=""), speed=0.1).rows[0]
    small, large = (
        hl.check(script(CLIPPED, grains=f"set type 1 diameter {d} density 900"), speed=0.1).rows[0]
        for d in (1e-3, 3e-3)
    )
    assert unknown.restitution == pytest.approx(small.restitution) == pytest.approx(large.restitution)
    assert small.duration != pytest.approx(large.duration)
    without = hl.check(script(CLIPPED)).rows[0]
    assert (
        without.speed is None
        and without.restitution == pytest.approx(small.restitution)
        and without.duration is not None
    )
    assert without.largest_overlap is None and without.tc_nu is None
    hertz = hl.check(script(HERTZ)).rows[0]
    assert hertz.restitution == pytest.approx(0.7182, abs=1e-4) and hertz.speed == 0.01
    hertz = hl.check(script(HERTZ, units="lj")).rows[0]
    assert hertz.restitution == pytest.approx(0.7182, abs=1e-4) and hertz.duration is None


def test_clipping_and_time_step():
    free, clipped = (hl.check(script(line), speed=0.3).rows[0] for line in (HOOKE, CLIPPED))
    assert free.restitution == pytest.approx(0.9, abs=1e-9) and not free.clipped
    assert clipped.restitution > 0.902 and clipped.clipped and clipped.duration < free.duration
    assert clipped.steps_per_contact == math.floor(clipped.duration / 1e-7)
    coarse = hl.check(script(CLIPPED).replace("timestep 1e-7", "timestep 2e-6"), speed=0.3)
    assert coarse.rows[0].restitution_error_of_step > 1e-3 and "timestep 2.145e-07" in coarse.corrected
    endless = hl.check(script(CLIPPED).replace("timestep 1e-7", "timestep 1e-3"), speed=0.3)
    assert endless.rows[0].restitution_error_of_step > 1.0 and endless.corrected == coarse.corrected
    assert "too long" in " ".join(endless.remarks)
    without_end = hl.check(
        script(HOOKE.replace("0.9", "0.05")).replace("timestep 1e-7", "timestep 1e3"), speed=0.3
    )
    assert "too long" in " ".join(without_end.remarks) and without_end.rows[0].steps_per_contact == 0


def test_units_of_a_script_are_converted():
    """The same grains in cgs and SI."""
    si = hl.check(script(HERTZ), speed=0.3, packing_fraction=0.1)
    cgs = hl.check(
        script(HERTZ.replace("1e7", "1e8"), units="cgs", grains="set type 1 diameter 0.2 density 2.5"),
        speed=0.3,
        packing_fraction=0.1,
    )
    for row, other in zip(si.rows, cgs.rows, strict=True):
        for name in (
            "radius",
            "density",
            "speed",
            "duration",
            "time_step",
            "rayleigh_time",
            "tc_nu",
            "restitution",
        ):
            assert getattr(row, name) == pytest.approx(getattr(other, name), rel=1e-9), name
    assert si.time_step == cgs.time_step == 1e-7


#: Boxes of grains in several units: diameter, density, stiffness, time step and gravity of the same box in all but lj.
BOXES = {
    "si": (2e-3, 2500.0, 1e2, 1e-5, 9.81),
    "cgs": (0.2, 2.5, 1e5, 1e-5, 981.0),
    "micro": (2e3, 2.5e-3, 1e5, 10.0, 9.81e-6),
    "lj": (1.0, 1.0, 1e5, 1e-4, 1.0),
}


def box(units, dimension=3):
    d, rho, k, step, g = BOXES[units]
    return (
        f"units {units}\ndimension {dimension}\natom_style sphere\ncreate_box 1 box\ncreate_atoms 1 box\n"
        f"set type 1 diameter {d} density {rho}\npair_style granular\n"
        f"pair_coeff * * hooke {k} 0.9 damping coeff_restitution\nfix g all gravity {g} vector 0 0 -1\n"
        f"timestep {step}\nrun 100\n"
    )


@pytest.mark.parametrize(
    ("pair", "dimensions"),  # a pair of spheres, and in the other order of disks and spheres
    [
        case if len(case[0]) == 1 or (case[0] < case[0][::-1]) == (case[1] == (3, 3)) else slow(*case)
        for case in itertools.product(
            [*itertools.permutations(BOXES, 2), ("si",), ("lj",), ("cgs",)], [(3, 3), (2, 3)]
        )
    ],
)
def test_each_system_of_a_script_has_its_own_units(pair, dimensions, tmp_path):
    """After ``clear``, another system begins; the numbers of those before stay as they are, also if none follows."""
    options = {"speed": 0.3, "packing_fraction": 0.1}
    alone = [hl.check(box(*system), **options) for system in zip(pair, dimensions, strict=False)]
    text = "clear\n".join([*map(box, pair, dimensions), ""])
    both = hl.check(text, **options)
    for number, (verdict, units) in enumerate(zip(alone, pair, strict=True), 1):
        rows = [row for row in both.rows if row.stage == number]
        assert rows == [dataclasses.replace(row, stage=number) for row in verdict.rows]
        assert both.stages[number - 1][2:] == verdict.stages[0][2:]
        assert both.stages[number - 1].units == units
    assert both.units == pair[-1] and both.units_given and both.time_step == alone[-1].time_step
    assert both.admissible == (not any(verdict.admissible is False for verdict in alone))
    assert any("Overlaps" in note for verdict in alone for note in verdict.remarks) == any(
        "Overlaps" in note for note in both.remarks
    )
    shown = [f"timestep {line}" for verdict in alone for line in verdict.corrected]
    assert len(both.corrected) == len(shown) and both.contacts.attrs["units"] == pair[-1]
    path = tmp_path / "in.boxes"
    path.write_text(text)
    said = run("check", path, "--speed", "0.3").stdout
    assert f"{listed(list(pair))} units" in said and (len(pair) < 2 or f"of run 2 ({pair[1]} units)" in said)


def test_numerical_damping_is_part_of_the_restitution():
    """With a numerical damping d alone, ε = √((1 − d)/(1 + d)), and half a contact lasts π/2 √(m/(k(1 ± d)))."""
    quote = Quote("", 1, "O.run()")
    undamped = {"physics": Setting(("FrictPhys",), 1, ""), "young": Setting(("1e6",), 1, "")}
    pair = ContactSettings(("a", "a"), None, undamped, (quote,))
    stage = Stage(
        quote, 1e-6, True, None, (pair,), {"a": Grains("a", (1e-3, 1e-3), (2500.0, 2500.0))}, None, 0.2
    )
    verdict = checked_script(
        described(code="yade", units="si", stages=(stage,)), Options(None, (0.5,), None, {})
    ).rows[0]
    assert verdict.restitution == pytest.approx(math.sqrt(0.8 / 1.2), abs=1e-9)
    assert verdict.types == ("a", "a")
    k, m = 2.0 * 1e6 * 5e-4, BEAD.mass / 2
    halves = [math.pi / 2 * math.sqrt(m / (k * (1 + d))) for d in (0.2, -0.2)]
    assert verdict.duration == pytest.approx(sum(halves), rel=1e-6)


SYSTEM = """units si
atom_style sphere
region box block 0 0.1 0 0.1 0 0.1
create_box 1 box
create_atoms 1 random 100 1 box
set type 1 diameter 2e-3 density 2500
pair_style granular
pair_coeff * * hooke {} 0.9 damping coeff_restitution tangential linear_nohistory 0 0
fix move all nve/sphere
{}
timestep 1e-7
run 1000
"""


@pytest.mark.parametrize("first, second, answer", [(1e3, 1e8, False), (1e8, 1e3, False), (1e8, 1e8, True)])
def test_systems_with_different_questions_have_one_answer(first, second, answer):
    """A cooling gas, then a sheared one in other units: no if it is for one of them, yes if it is for both."""
    sheared = SYSTEM.format(1e3 * second, "fix shear all deform 1 xy erate 100 remap v")
    sheared = sheared.replace("units si", "units cgs").replace("2e-3 density 2500", "0.2 density 2.5")
    texts = [SYSTEM.format(first, ""), sheared.replace("0.1", "10")]
    options = {"speed": 0.5, "packing_fraction": 0.3}
    alone = [hl.check(text, **options) for text in texts]
    assert [verdict.quantity for verdict in alone] == ["cooling", "stress"]
    assert [verdict.admissible for verdict in alone] == [first > 1e4, second > 1e4]
    both = hl.check("clear\n".join(texts), **options)
    assert both.admissible is answer
    # Of two systems with the same answer, either sentence holds.
    assert both.sentence in [verdict.sentence for verdict in alone if verdict.admissible is answer]


def test_systems_of_the_same_units_have_their_own_questions():
    """``clear`` begins another system: the cooling of the first is not judged by the stress of the second."""
    sheared = SYSTEM.format(2e5, "fix shear all deform 1 xy erate 100 remap v")
    for texts in ([SYSTEM.format(2e5, ""), sheared], [sheared, SYSTEM.format(2e5, "")]):
        alone = [hl.check(text, speed=0.5, packing_fraction=0.3) for text in texts]
        assert {verdict.admissible for verdict in alone} == {False, None}
        both = hl.check("clear\n".join(texts), speed=0.5, packing_fraction=0.3)
        assert both.admissible is False and "cools 1.16" in both.sentence
        assert [row.stage for row in both.rows] == [1, 2] and both.rows[0].error == alone[0].rows[0].error
    # A system like that before it is one with it.
    twice = hl.check("clear\n".join([sheared, sheared]), speed=0.5, packing_fraction=0.3)
    assert (
        twice.sentence == hl.check(sheared, speed=0.5, packing_fraction=0.3).sentence and len(twice.rows) == 1
    )


def test_a_system_at_rest_decides_whatever_shakes_the_next():
    rest = SYSTEM.format(1e8, "fix g all gravity 9.81 vector 0 0 -1\nfix floor all wall/gran granular hooke 1e8 0.9 &\n"
                         "damping coeff_restitution zplane 0 1")  # fmt: skip
    shaken = rest.replace("zplane 0 1", "zplane 0 1 wiggle z 0.001 0.02")
    options = {"speed": 0.5, "packing_fraction": 0.3}
    assert hl.check(shaken, **options).admissible is None
    assert hl.check(f"{rest}clear\n{shaken}", **options).admissible is False


def test_versions_of_a_code_differ():
    """LAMMPS' tsuji before and since 2 Sep 2026: a log's version decides, else the newest, and the other is named."""
    quote = Quote("", 1, "run 1")
    words = {"normal": Setting(("hooke", "1e5", "0.6"), 1, ""), "damping": Setting(("tsuji",), 1, "")}
    stage = Stage(quote, 1e-7, True, 1, (ContactSettings(("1", "1"), None, words, (quote,)),), {}, None, None)
    verdicts = {
        version: checked_script(described(version=version, units="si", stages=(stage,)), NONE)
        for version in (None, "22 Jul 2025 - Update 4", "2 Sep 2026", "10 Dec 2026")
    }
    epsilon = {version: verdict.rows[0].restitution for version, verdict in verdicts.items()}
    assert epsilon["22 Jul 2025 - Update 4"] > epsilon["2 Sep 2026"] + 0.05
    assert epsilon[None] == epsilon["10 Dec 2026"] == epsilon["2 Sep 2026"]
    older = verdicts["22 Jul 2025 - Update 4"].rows[0].restitution
    assert [version[:2] for version in verdicts[None].rows[0].other_versions] == [("2 Sep 2026", older)]
    assert (
        f"LAMMPS before 2 Sep 2026: ε {older:.3g} instead of {epsilon[None]:.3g} (1–1)."
        in verdicts[None].remarks
    )
    assert "before" not in " ".join(verdicts["2 Sep 2026"].remarks)


@pytest.mark.parametrize(
    "version,known", [("10 Mar 2021", True), ("14 May 2021", False), ("29 Sep 2021", True)]
)
def test_a_version_with_an_unknown_force_has_no_restitution(version, known):
    """Walls of fix wall/gran granular hooke, which were wrong in the middle of 2021."""
    wall = f"fix floor all wall/gran granular hooke 1e5 0.1 damping velocity {TANGENTIAL} zplane 0 1"
    text = script(f"pair_style granular\npair_coeff * * hooke 1e5 0.1 damping velocity {TANGENTIAL}", wall)
    verdict = hl.check(f"LAMMPS ({version})\n{text}", speed=0.1)
    assert [row.restitution is not None for row in verdict.rows] == [True, known]
    assert bool(verdict.unknown) == (not known) and (known or "to 29 Sep 2021" in verdict.sentence)
    assert not hl.check(text, speed=0.1).rows[1].other_versions


def test_frozen_grains_are_walls_of_infinite_mass_and_meet_no_frozen_grains():
    quote = Quote("", 1, "run 1")
    words = {"normal": Setting(("gran/hooke", "1e5", "2e4"), 1, "")}
    pairs = [ContactSettings(types, None, words, (quote,)) for types in (("1", "1"), ("1", "2"), ("2", "2"))]
    grains = {k: Grains(k, (1e-3, 1e-3), (2500.0, 2500.0), frozen=k == "1") for k in ("1", "2")}
    stage = Stage(quote, 1e-7, True, 1, tuple(pairs), grains, None, None)
    rows = checked_script(described(units="si", stages=(stage,)), NONE).rows
    assert [row.types for row in rows] == [("1", "2"), ("2", "2")]
    assert rows[0].duration > 1.35 * rows[1].duration  # √2 without damping


# --- the answer -----------------------------------------------------------------------------------------------


@draws(60)
@given(
    radius=log_floats(1e-5, 1e-1),
    stiffness=log_floats(1e-1, 1e9),
    restitution=st.floats(0.05, 1.0),
    speed=log_floats(1e-4, 10.0),
    phi=st.floats(0.001, 0.64),
    dimension=st.sampled_from([2, 3]),
    hertz=st.booleans(),
)
def test_the_sentence_agrees_with_the_numbers(radius, stiffness, restitution, speed, phi, dimension, hertz):
    law = (
        hl.Tsuji(elastic_prefactor=stiffness / math.sqrt(radius) * 10, restitution=restitution)
        if hertz
        else hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    )
    verdict = hl.check(
        hl.Ball(radius, density=2500.0), law=law, speed=speed, packing_fraction=phi, dimension=dimension
    )
    row = verdict.rows[0]
    value, bar = row.error["constant"]
    law_of_error = error_law(packing_fraction=phi, restitution=row.restitution, dimension=dimension, law=law)
    assert value == pytest.approx(law_of_error.error(row.tc_nu)) and bar == pytest.approx(
        law_of_error.error_bar(row.tc_nu)
    )
    low, high = abs(value) - bar, abs(value) + bar
    wanted = False if low > 0.01 or row.tc_nu > 0.3 else True if high <= 0.01 else None
    assert verdict.admissible is wanted
    assert verdict.sentence.startswith({True: "Yes: ", False: "No: ", None: "Cannot be said: "}[wanted])
    assert ("too fast" in verdict.sentence) == (value > 0 and row.tc_nu <= 0.3)
    if 0.0 < row.spring[2] < 1e300 and row.tc_nu < 0.3 and row.spring[2] != row.spring[1]:
        factor = row.spring[2] / row.spring[1]
        name = "elastic_prefactor" if hertz else "stiffness"
        other = type(law)(**{**law.parameters, name: row.spring[2]})
        again = hl.check(
            hl.Ball(radius, density=2500.0), law=other, speed=speed, packing_fraction=phi, dimension=dimension
        ).rows[0]
        if again.tc_nu < 0.29:
            value, bar = again.error["constant"]
            assert abs(value) + bar == pytest.approx(0.01, rel=0.02), factor


@draws(60)
@given(
    stiffness=log_floats(1.0, 1e12),
    restitution=st.sampled_from([0.01, 0.011, 0.5, 0.999999, 1.0]),
    speed=log_floats(1e-6, 100.0),
    phi=st.sampled_from([1e-9, 1e-3, 0.3, 0.5, 0.64]),
    dimension=st.sampled_from([2, 3]),
    time_step=st.none() | log_floats(1e-12, 1.0),
    hidden=st.sampled_from([None, "speed", "packing_fraction"]),
    law=st.sampled_from(["linear", "tsuji", "viscoelastic"]),
)
def test_extreme_numbers_agree_with_the_sentence(
    stiffness, restitution, speed, phi, dimension, time_step, hidden, law
):
    expected = {
        "linear": lambda: hl.LinearDashpot(stiffness=stiffness, restitution=restitution),
        "tsuji": lambda: hl.Tsuji(elastic_prefactor=stiffness, restitution=restitution),
        "viscoelastic": lambda: hl.Viscoelastic(
            youngs_modulus=stiffness, poisson_ratio=0.3, dissipative_time=1e-5 * (1.0 - restitution)
        ),
    }[law]()
    options = {"speed": speed, "packing_fraction": phi} | ({hidden: None} if hidden else {})
    verdict = hl.check(BEAD, law=expected, dimension=dimension, time_step=time_step, **options)
    json.dumps(verdict.to_dict(), allow_nan=False)
    row = verdict.rows[0]
    if row.restitution == 0.0:
        assert verdict.admissible is False and row.duration is None
    elif hidden:
        name = {"speed": "speeds are", "packing_fraction": "packing is"}[hidden]
        assert verdict.admissible is None and verdict.sentence.startswith(f"Cannot be said: {name} not known")
    else:
        value, bar = row.error[row.rule]
        low, high = abs(value) - bar, abs(value) + bar
        wanted = False if low > 0.01 or row.tc_nu > 0.3 else True if high <= 0.01 else None
        assert verdict.admissible is wanted
    too_deep = any((row.largest_overlap or 0.0) > 0.05 for row in verdict.rows)
    assert any("Overlaps reach" in note for note in verdict.remarks) is too_deep
    assert not {"nan", "inf"} & set(verdict.sentence.replace(",", " ").split())


def test_what_is_missing_is_named():
    sentence = hl.check(BEAD, law=hl.LinearDashpot(stiffness=1e5, restitution=0.9)).sentence
    assert (
        sentence
        == "Cannot be said: speeds and packing are not known (give --dump, or --speed and --packing-fraction)."
    )
    few = script(HOOKE).replace("random 100 ", "random 10 ")
    assert "packing is not known" in hl.check(few, speed=1.0).sentence
    stage = replace(described().stages[0], grains={}, gravity=None)
    verdict = checked_script(described(stages=(stage,)), Options(None, (1.0,), 0.1, {}))
    assert verdict.sentence == "Cannot be said: sizes are not known (give --dump, or --radius)."


@pytest.mark.parametrize(
    ("source", "options", "text"),
    [
        (5, {}, "source: got 5"),
        (BEAD, {}, "law: got None"),
        (
            BEAD,
            {"law": hl.LinearDashpot(stiffness=1e5, restitution=0.9), "variables": {"a": 1}},
            "variables: got",
        ),
        (script(HOOKE), {"variables": 5}, "variables: got 5"),
        (script(HOOKE), {"dimension": 3}, "dimension: got 3"),
    ],
)
def test_arguments_that_do_not_belong_together(source, options, text):
    with pytest.raises(ValueError, match=text):
        hl.check(source, **options)


def test_a_verdict_can_be_pickled():
    verdict = hl.check(script(CLIPPED, WALL), speed=(0.1, 1.0), packing_fraction=0.2)
    again = pickle.loads(pickle.dumps(verdict))
    assert (
        again == verdict
        and again.to_dict() == verdict.to_dict()
        and again.contacts.identical(verdict.contacts)
    )
    assert repr(verdict) == f"<Verdict: {verdict.sentence}>"


def test_the_times_of_waves_are_those_of_the_grains_own_materials():
    """LIGGGHTS' formulas have an effective modulus between two materials, but waves run in each of them."""
    moduli, ratios, radii = (5e6, 1e8), (0.45, 0.25), (1e-3, 2e-3)
    text = f"""units si
atom_style granular
region reg block 0 1 0 1 0 1 units box
create_box 2 reg
pair_style gran model hertz tangential history
pair_coeff * *
fix m1 all property/global youngsModulus peratomtype {moduli[0]} {moduli[1]}
fix m2 all property/global poissonsRatio peratomtype {ratios[0]} {ratios[1]}
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.8 0.8 0.7
fix m4 all property/global coefficientFriction peratomtypepair 2 0 0 0 0
fix zw all wall/gran model hertz tangential history primitive type 2 zplane 0.0
create_atoms 1 single 0 0 0
create_atoms 2 single 0 0 1
set type 1 diameter {2 * radii[0]} density 2500
set type 2 diameter {2 * radii[1]} density 2500
timestep 1e-6
run 1
"""
    wave = [r * math.sqrt(2500 / y) for r, y in zip(radii, moduli, strict=True)]
    rayleigh = [
        math.pi * wave_time * math.sqrt(2 + 2 * nu) / (0.1631 * nu + 0.8766)
        for wave_time, nu in zip(wave, ratios, strict=True)
    ]
    row = {row.types: row for row in hl.check(text, speed=0.5).rows}
    for times, of in (("p_wave_time", wave), ("rayleigh_time", rayleigh)):
        got = {types: getattr(row, times) for types, row in row.items()}
        expected = {
            ("1", "1"): of[0],
            ("2", "2"): of[1],
            ("1", "2"): min(of),
            ("1", "wall"): of[0],
            ("2", "wall"): of[1],
        }
        assert got == pytest.approx(expected, rel=1e-12)


def test_gravity_counts_where_grains_can_come_to_rest():
    fall = "fix g all gravity 9.81 vector 0 0 -1"
    options = {"speed": 0.01, "packing_fraction": 0.05}
    assert hl.check(script(HOOKE, fall), **options).admissible  # periodic: nothing to rest on
    walled = script(HOOKE, fall, WALL).replace("boundary p p p", "boundary p p f")
    verdict = hl.check(walled, **options)
    assert verdict.admissible is False and verdict.invalidates[0].where
    assert [finding.what for finding in verdict.checked] == [
        "normal contact",
        "time step",
        "walls",
        "gravity",
    ]


@pytest.mark.parametrize(
    "shape", ["xplane 0 1", "yplane NULL 1", "zplane 0 NULL", "zplane NULL 1", "zcylinder 0.5"]
)
@pytest.mark.parametrize(
    ("gravity", "down"),
    [
        ("vector 0 0 -2", (0, 0, -1)),
        ("vector 3 0 4", (0.6, 0, 0.8)),
        ("vector 0 v_one 0", (0, 1, 0)),
        ("chute 30", (0.5, 0, -math.sqrt(0.75))),
        ("spherical 270 90", (0, -1, 0)),
        ("spherical 0 180", (0, 0, -1)),
    ],
)
def test_grains_rest_only_on_a_wall_that_stops_the_fall(shape, gravity, down):
    """A wall along gravity, or above the grains, does not: as in a vertical channel, where friction holds the flow."""
    x, y, z = down
    stops = {
        "xplane 0 1": abs(x) > 1e-9,
        "yplane NULL 1": y > 1e-9,
        "zplane 0 NULL": z < -1e-9,
        "zplane NULL 1": z > 1e-9,
        "zcylinder 0.5": math.hypot(x, y) > 1e-9,
    }[shape]
    wall = WALL.replace("zplane 0 1", shape)
    text = script(HOOKE, "variable one equal 1", f"fix g all gravity 9.81 {gravity}", wall)
    verdict = hl.check(text, speed=0.01, packing_fraction=0.05)
    states = ("rest on each other", "come to rest", "rest or flow")
    assert any(words in verdict.sentence for words in states) is stops
    assert verdict.admissible is not stops


def test_what_invalidates_or_is_not_understood_decides():
    options = Options(None, (0.01,), 0.1, {})
    quote = Quote("in.file", 3, "fix d all drag 1")
    stage = described().stages[0]
    calm = [Stage(quote, 1e-5, True, 1, stage.contacts[:1], stage.grains, None, None)]
    drag = checked_script(described(stages=calm, invalidates=(Note("drag", None, quote),)), options)
    assert drag.admissible is False and drag.sentence.startswith("No: drag, which no event-driven")
    unclear = checked_script(described(stages=calm, unknown=(quote,)), options)
    assert unclear.admissible is not True
    sticky = {"normal": Setting(("jkr", "1e5", "0.1", "0.3", "1"), 4, "pair_coeff * * jkr 1e5 0.1 0.3 1")}
    both = [
        Stage(
            quote,
            1e-5,
            True,
            1,
            (ContactSettings(("1", "1"), None, sticky, (quote,)),),
            stage.grains,
            None,
            None,
        )
    ]
    jkr = checked_script(described(stages=both, invalidates=(Note("adhesion", ("1", "1"), quote),)), options)
    assert jkr.admissible is False and jkr.rows[0].restitution is None and not jkr.unknown
    strange = checked_script(described(stages=both), options)
    assert strange.admissible is None and "1–1" in strange.sentence


def test_an_overdamped_contact_sticks():
    text = script(f"pair_style granular\npair_coeff * * hooke 1e3 10 damping velocity {TANGENTIAL}")
    verdict = hl.check(text, speed=0.1, packing_fraction=0.1)
    row = verdict.rows[0]
    assert row.restitution == 0.0 and row.duration is None and row.steps_per_contact is None
    assert verdict.admissible is False and "overdamped" in verdict.sentence


# --- corrections ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "contact",
    [CLIPPED, HERTZ, HERTZ.replace("coeff_restitution", "tsuji"), f"{CLIPPED}\n{WALL} limit_damping"],
)
def test_corrected_lines_give_the_restitution_that_was_asked_for(contact):
    text = script(contact.replace(" 0.9 ", " 0.6 "))
    verdict = hl.check(text)
    wrong = [row for row in verdict.rows if abs(row.restitution - row.restitution_asked) > 5e-3]
    assert wrong and "differs from ε asked" in " ".join(verdict.remarks)
    lines = text.splitlines()
    for line in verdict.corrected:
        if not line.startswith("timestep"):
            head = line.split()[:3]
            (place,) = [k for k, old in enumerate(lines) if old.split()[:3] == head]
            lines[place] = line
    again = hl.check("\n".join(lines))
    for row, old in zip(again.rows, verdict.rows, strict=True):
        assert row.restitution == pytest.approx(old.restitution_asked, abs=1e-4)
        assert row.restitution_asked == old.restitution_asked  # from the comment; the number is another one
    assert "differs from ε asked" not in " ".join(again.remarks)
    assert not [line for line in again.corrected if "timestep" not in line]
    other = hl.check(re.sub(r"restitution of [\d.]+", "restitution of 0.5", "\n".join(lines)))
    assert [line for line in other.corrected if line.endswith("  # for a restitution of 0.5")]
    assert not [line for line in hl.check(script(HOOKE), speed=1.0).corrected if "timestep" not in line]


COHESIVE = """\
atom_style granular
units si
region reg block 0 1 0 1 0 1 units box
create_box 1 reg
fix m1 all property/global youngsModulus peratomtype 1e7
fix m2 all property/global poissonsRatio peratomtype 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.6
fix m4 all property/global cohesionEnergyDensity peratomtypepair 1 {}
pair_style gran model hertz cohesion sjkr
timestep 1e-5
create_atoms 1 random 10 1 reg
set group all diameter 1e-2 density 2500
fix integr all nve/sphere
run 1000
"""


def test_a_corrected_matrix_of_one_number_is_not_corrected_again():
    text = COHESIVE.format("0").replace("hertz cohesion sjkr", "hertz limitForce on")
    (line,) = [line for line in hl.check(text, speed=0.5).corrected if "Restitution" in line]
    assert line.endswith("  # for a restitution of 0.6")
    (old,) = [old for old in text.splitlines() if "Restitution" in old]
    again = hl.check(text.replace(old, line), speed=0.5)
    assert again.rows[0].restitution_asked == 0.6
    assert again.rows[0].restitution == pytest.approx(0.6, abs=1e-4)
    assert not [line for line in again.corrected if "Restitution" in line]


@pytest.mark.parametrize("matrix", ["2 0.6 0.5 0.5 0.7", "2 0.6 0.6 0.6 0.6", "2 '0.6' 0.5 0.5 \"0.7\""])
def test_a_matrix_over_types_is_corrected_as_a_whole(matrix):
    text = COHESIVE.format("0").replace("hertz cohesion sjkr", "hertz limitForce on")
    text = re.sub("peratomtype (.*)", r"peratomtype \1 \1", text).replace("create_box 1", "create_box 2")
    text = text.replace("peratomtypepair 1 0.6", f"peratomtypepair {matrix}")
    text = text.replace("peratomtypepair 1 0", "peratomtypepair 2 0 0 0 0")
    text = text.replace("set group", "create_atoms 2 random 10 1 reg\nset group")
    verdict = hl.check(text, speed=0.5)
    assert "ε given differs from ε asked" in " ".join(verdict.remarks)
    (line,) = [line for line in verdict.corrected if "Restitution" in line]
    assert line.endswith("  # for a restitution of 0.6") is ("0.5" not in matrix)
    (old,) = [old for old in text.splitlines() if "Restitution" in old]
    again = hl.check(text.replace(old, line), speed=0.5)
    for row, before in zip(again.rows, verdict.rows, strict=True):
        assert row.restitution == pytest.approx(before.restitution_asked, abs=1e-4)
    assert ("ε given differs from ε asked" in " ".join(again.remarks)) is ("0.5" in matrix)


def test_cohesion_is_part_of_the_restitution():
    """LIGGGHTS 3.8.0 gives .600, .508, and grains that stay together."""
    none, some, much = (hl.check(COHESIVE.format(w), speed=0.5) for w in ("0", "1e5", "3e5"))
    assert none.admissible is None and not none.invalidates
    assert none.rows[0].restitution == pytest.approx(0.6, abs=1e-6)
    assert none.rows[0] == hl.check(COHESIVE.format("0").replace(" cohesion sjkr", ""), speed=0.5).rows[0]
    assert (
        some.rows[0].restitution == pytest.approx(0.5077, abs=2e-4) and some.rows[0].restitution_asked == 0.6
    )
    assert some.rows[0].rule == "law" and not some.rows[0].error
    assert much.rows[0].restitution == 0.0 and much.rows[0].duration is None
    assert "differs from ε asked" in " ".join(some.remarks)
    for verdict in (some, much):
        assert verdict.admissible is False and [finding.what for finding in verdict.invalidates] == [
            "cohesion (sjkr)"
        ]
        assert verdict.sentence.startswith("No: cohesion (sjkr) of type 1") and not verdict.unknown
        assert not [line for line in verdict.corrected if not line.startswith("timestep")]
    slowly = [hl.check(COHESIVE.format("1e5"), speed=v).rows[0].restitution for v in (0.04, 0.05, 0.2, 2.0)]
    assert slowly[0] == 0.0 and slowly == sorted(slowly)
    crushed = hl.check(COHESIVE.format("1e8"), speed=0.5)
    assert crushed.rows[0].restitution is None and crushed.admissible is False and not crushed.unknown
    sizes = "set group all diameter 1e-2 density 2500"
    unsized = COHESIVE.format("1e5").replace(sizes, "read_restart old")
    assert hl.check(unsized, speed=0.5).rows[0].restitution is None
    dense = hl.check(COHESIVE.format("1e5"), speed=0.5, packing_fraction=0.1).rows[0]
    assert dense.tc_nu and not dense.error and dense.softening is None


@pytest.mark.parametrize("model", ["easo/capillary/viscous", "magic"])
def test_cohesion_that_is_not_modelled_leaves_the_restitution_out(model):
    verdict = hl.check(COHESIVE.format("1e5").replace("sjkr", model), speed=0.5)
    assert verdict.admissible is False and f"cohesion ({model})" in verdict.sentence
    assert [row.restitution for row in verdict.rows] == [None] and not verdict.unknown


def test_corrected_lines_say_for_which_error_and_a_wanted_one_is_given():
    """``restitution_error`` changes the time step as in ``convert``; the title of the lines has it."""
    coarse = script(CLIPPED).replace("timestep 1e-7", "timestep 1e-5")
    steps = []
    for error in (None, 1e-2, 1e-4):
        verdict = hl.check(coarse, speed=0.3, restitution_error=error)
        assert corrections(verdict) == f"Corrected lines (time step for an error of ε of {error or 0.001:g}):"
        (line,) = [line for line in verdict.corrected if line.startswith("timestep")]
        again = hl.check(coarse.replace("timestep 1e-5", line), speed=0.3, restitution_error=error)
        assert 0.5 < again.rows[0].restitution_error_of_step / (error or 1e-3) <= 1.05
        assert again.restitution_error == (error or 1e-3) and not again.corrected
        steps.append(float(line.split()[1]))
    assert steps[1] > 2.0 * steps[0] > 4.0 * steps[2]
    fine = script(CLIPPED.replace("0.9", "0.5")).replace("timestep 1e-7", "timestep 1e-8")
    assert corrections(hl.check(fine)) == "Corrected lines (for ε):"
    for error in (0.0, 0.2, "much"):
        with pytest.raises(ValueError, match="restitution_error: got"):
            hl.check(coarse, speed=0.3, restitution_error=error)


def test_a_numerical_damping_is_left_out_only_where_an_restitution_remains():
    """Elastic contacts would then be undamped, which the remark says; with en= the line says which ε is left."""
    elastic = hl.check(COLUMN, speed=0.1)
    assert not any("damping=0" in line for line in elastic.corrected)
    assert "damping of 0.2 (centre of mass at rest; without it, ε is 1)" in " ".join(elastic.remarks)
    damped = YADE_BOX.format(engine="", more="", g=0).replace("damping=0", "damping=0.2")
    verdict = hl.check(damped, speed=0.1)
    assert verdict.corrected == (
        "NewtonIntegrator(damping=0)  # in O.engines, with its other arguments; ε is then 0.9",
    )
    assert hl.check(damped.replace("damping=0.2", "damping=0"), speed=0.1).rows[
        0
    ].restitution == pytest.approx(0.9, abs=1e-3)


def test_corrected_lines_say_which_restitution_the_contact_really_has():
    """MindlinPhys with en = 0.999 gives 0.984; a law that leaves out the damping is to be replaced."""
    box = (
        YADE_BOX.format(engine="", more="", g=0)
        .replace("en=0.9", "en=0.999")
        .replace("damping=0", "damping=0.2")
    )
    *own, damping = hl.check(box, speed=0.1).corrected
    assert own and all(line.startswith("# ") and line.endswith("its ε is 0.984") for line in own)
    assert damping.endswith("ε is then 0.984")
    undamped = box.replace("Law2_ScGeom_MindlinPhys_Mindlin", "Law2_ScGeom_MindlinPhys_MindlinDeresiewitz")
    law, damping = hl.check(undamped, speed=0.1).corrected
    assert law.endswith("en=0.999 then gives ε = 0.984") and damping.endswith("ε is then 0.984")
    fine = hl.check(undamped.replace("0.999", "0.8"), speed=0.1).corrected
    assert "then gives" not in fine[0] and fine[1].endswith("ε is then 0.8")


def test_no_corrected_line_contradicts_itself():
    """Where contacts need different numbers in one statement, each stands once, named with its sizes if they differ."""
    physics = "ViscElMat_ViscElMat_ViscElPhys"
    text = COLUMN.replace("FrictMat(young=1e7, poisson=0.3", "ViscElMat(tc=1e-3, en=0.6, et=0.6").replace(
        "FrictMat(young=1e9, poisson=0.3", "ViscElMat(tc=1e-3, en=0.6, et=0.6"
    )
    text = text.replace("FrictMat_FrictMat_FrictPhys", physics).replace(
        "FrictPhys_CundallStrack", "ViscElPhys_Basic"
    )
    more = "O.bodies.append(sphere((0, 0, 0.03), 0.002, fixed=True, material='steel'))"
    text = text.replace(
        "O.engines", f"{more}\nO.bodies.append(sphere((0, 0, 0.1), 0.004, material='glass'))\nO.engines"
    )
    verdict = hl.check(text.replace("NewtonIntegrator()", "NewtonIntegrator(damping=0)"), speed=0.1)
    lines = [line.partition("  # ")[2] for line in verdict.corrected if "restitution" in line]
    assert len(lines) > 1
    for line in lines:
        own, *others = line.split("; ")
        names = [own, *(re.split(" needs? ", text)[0] for text in others)]
        pairs = [
            name
            for each in names
            for name in re.findall(r"\w+–\w+(?: fixed)?(?: R [\d.]+(?:, [\d.]+)?)?", each)
        ]
        assert len(pairs) >= 3 and len(pairs) == len(set(pairs)), line


def test_stiffness_has_its_unit():
    """A number in the sentence has the unit of the script's number; none in lj units."""
    options = {"speed": 0.5, "packing_fraction": 0.2}
    units = {}
    for name, contact in (
        ("si", "hooke 1e4 0.7"), ("lj", "hooke 1e4 0.7"), ("cgs", "hooke 1e7 0.7"), ("micro", "hooke 1e-2 0.7")
    ):  # fmt: skip
        grains = {"cgs": "set type 1 diameter 0.2 density 2.5", "micro": "set type 1 diameter 2 density 2.5"}
        text = script(CLIPPED.replace("hooke 1e5 0.9", contact), units=name,
                      grains=grains.get(name, "set type 1 diameter 2e-3 density 2500"))  # fmt: skip
        verdict = hl.check(text, **options)
        units[name] = re.search(r"a stiffness of \S+ ?(\S*) (?:instead of|from)", verdict.sentence)[1]
    assert units == {"si": "N/m", "lj": "", "cgs": "dyn/cm", "micro": "nN/µm"}
    hertz = hl.check(script(HERTZ), **options).sentence
    assert re.search(r"a Young's modulus of \S+ Pa (instead of|from)", hertz)
    prefactor = hl.check(BEAD, law=hl.Tsuji(elastic_prefactor=1e7, restitution=0.9), **options)
    assert "N/m^1.5" in prefactor.sentence
    pair = CLIPPED.replace("hooke 1e5 0.9 damping coeff_restitution", "hertz 1e7 0.5 damping tsuji")
    assert re.search(r"a stiffness of \S+ Pa", hl.check(script(pair), **options).sentence)


def test_what_a_steady_state_lacks_is_asked_for():
    """No speed beside a shear rate that excludes it; in its place where no steady state is known."""
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
    verdict = hl.check(BEAD, law=law, shear_rate=100.0)
    assert verdict.missing == ("packing",) and "(give --dump, or --packing-fraction)" in verdict.sentence
    for restitution, why in ((0.3, "ε from 0.5 on"), (1.0, "heat for ever")):
        verdict = hl.check(
            BEAD, law=law.replace(restitution=restitution), shear_rate=100.0, packing_fraction=0.2
        )
        assert verdict.missing == ("speeds",) and "give --speed instead of --shear" in verdict.sentence
        assert any(why in remark for remark in verdict.remarks)
    assert (
        "give --speed instead of --power"
        in hl.check(BEAD, law=law.replace(restitution=1.0), power=1e-6, packing_fraction=0.2).sentence
    )


def test_soft_grains_that_overlap_deeply_are_no_advice():
    """A strong bath leaves an error below 1 % where overlaps are larger than any contact law describes."""
    bath = hl.Andersen(0.1, 1e4)
    box = hl.ParticleSystem.random(100, 0.05, radius=1e-3, density=2500.0, rms_speed=0.5, thermostat=bath)
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.98)
    verdict = hl.check(box, law=law)
    assert re.search(
        r"from 1e6, but overlaps are then \S+ % of R, and contact laws hold up to 5 %\.", verdict.sentence
    )
    row = verdict.rows[0]
    soft = hl.check(box, law=law.replace(stiffness=row.spring[2])).rows[0]
    assert soft.largest_overlap > 0.05
    assert soft.largest_overlap == pytest.approx(row.softened_overlap, rel=1e-3)
    gas = hl.check(BEAD, law=law, speed=0.3, packing_fraction=0.4)
    assert "you may soften" in gas.sentence and "overlaps are then" not in gas.sentence


def test_one_speed_is_refused_without_an_index():
    numbers = NUMBERS.replace("--speed 0.3m/s", "").split()
    assert "--speed: got nan" in refused("check", *numbers, "--speed", "nan")
    assert "--speed[1]: got 1e+200" in refused("check", *numbers, "--speed", "0.1:1e200")
    assert printed("check", *numbers, "--speed", "0.1:0.3m/s")["contacts"][-1]["speed"] == 0.3


def test_a_mean_in_a_corrected_line_has_no_rounding_error():
    text = (DATA / "states" / "yade_impact").read_text(encoding="utf-8")
    (line,) = [line for line in hl.check(text).corrected if "in place of 0.6" in line and "ball" in line]
    assert "in place of 0.65: " in line


def test_no_softening_is_advised_that_is_hardly_one():
    gas = {"speed": 0.3, "packing_fraction": 0.3}
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    needed = hl.check(BEAD, law=law, **gas).rows[0].spring[2]
    verdict = hl.check(BEAD, law=law.replace(stiffness=1.03 * needed), **gas)
    assert verdict.admissible and "less than 1 %; 1 % takes nearly this stiffness." in verdict.sentence


@pytest.mark.parametrize(("restitution", "stiffness_ratio"), [(0.5, 1.0), (0.8, 0.9)])
def test_what_the_constant_rule_changes_is_said_with_its_sign(restitution, stiffness_ratio):
    friction = hl.Friction(1.0, stiffness_ratio=stiffness_ratio)
    law = hl.LinearDashpot(stiffness=1e6, restitution=restitution, friction=friction)
    verdict = hl.check(BEAD, law=law, speed=0.3, packing_fraction=0.2)
    errors = verdict.rows[0].error
    added = errors["constant"][0] - errors["law"][0]
    way = "faster" if added > 0.0 else "more slowly"
    assert abs(added) > 0.001 and re.search(rf"β0 \S+, which cools \S+ % {way}\)", verdict.sentence)


def test_no_steady_state_is_said_beside_unknown_speeds():
    """One pair is too dissipative for kinetic theory of shear; the others have a speed."""
    text = script(
        CLIPPED.replace("pair_coeff * *", "pair_coeff 1 1").replace("0.9", "0.3")
        + "\n" + CLIPPED.splitlines()[1].replace("* *", "2 2") + "\n" + CLIPPED.splitlines()[1].replace("* *", "1 2"),
        "create_atoms 2 random 100 8 box", "fix s all deform 1 xy erate 10 remap v",
        grains="set type * diameter 2e-3 density 2500",
    ).replace("create_box 1", "create_box 2")  # fmt: skip
    verdict = hl.check(text, packing_fraction=0.2)
    assert {row.types for row in verdict.rows if row.speed is None} == {("1", "1")}
    assert verdict.missing == ("speeds",) and "steady state" not in verdict.sentence


def test_no_speed_is_usual_in_lj_units():
    plain = hl.check(script(HERTZ, units="lj"), packing_fraction=0.3)
    assert [row.speed for row in plain.rows] == [None] and "lj units have no usual one" in " ".join(
        plain.remarks
    )


def test_shear_rates_in_lj_units_have_no_unit():
    verdict = hl.check(script(CLIPPED, units="lj"), packing_fraction=0.2, shear_rate=200.0)
    assert "under a shear rate of 200 (kinetic theory)" in verdict.sentence
    dense = hl.check(script(CLIPPED, units="lj"), packing_fraction=0.6, shear_rate=200.0)
    assert "No speed from a shear rate of 200:" in " ".join(dense.remarks)
    assert "No speed from a shear rate of 200/s:" in " ".join(
        hl.check(script(CLIPPED), packing_fraction=0.6, shear_rate=200.0).remarks
    )


def test_clumps_are_called_clumps():
    text = COLUMN + "O.bodies.appendClumped([sphere((0, 0, 1), .01), sphere((0, 0, 1.01), .01)])\nO.run(1)\n"
    assert "no spheres (sphere)" not in hl.check(text, speed=0.1).sentence
    assert "(appendClumped)" in hl.check(text, speed=0.1).sentence


@pytest.mark.slow
def test_without_a_speed_contacts_that_depend_on_it_are_shown_at_three(tmp_path):
    """They decide nothing, are said to be chosen, and are those in SI units whatever the script's are."""
    path = tmp_path / "in.hertz"
    for units, contact, grains in (
        ("si", HERTZ, "set type 1 diameter 2e-3 density 2500"),
        ("cgs", HERTZ.replace("1e7", "1e8"), "set type 1 diameter 0.2 density 2.5"),
    ):
        path.write_text(script(contact, units=units, grains=grains).replace("timestep 1e-7", "timestep 1e-6"))
        verdict = hl.check(path, packing_fraction=0.3)
        assert [row.speed for row in verdict.rows] == pytest.approx(
            [0.01, 0.1, 1.0]
        ) and verdict.speeds_chosen
        row = [hl.check(path, packing_fraction=0.3, speed=v).rows[0] for v in (0.01, 0.1, 1.0)]
        for word, other in zip(verdict.rows, row, strict=True):
            assert word.duration == pytest.approx(other.duration) and word.tc_nu == pytest.approx(other.tc_nu)
        assert verdict.admissible is None and verdict.missing == ("speeds",)
        assert "0.01, 0.1 and 1 m/s were chosen" in " ".join(verdict.remarks)
        assert not any("timestep" in line for line in verdict.corrected)
        text = run("check", path).stdout
        assert (
            len([line for line in text.splitlines() if re.match(r"1–1 R 1 mm, (0.01|0.1|1) m/s ", line)]) == 3
        )
    linear = hl.check(script(CLIPPED), packing_fraction=0.3)  # does not depend on the speed
    assert [row.speed for row in linear.rows] == [None] and not linear.speeds_chosen
    plain = hl.check(script(HERTZ, units="lj"), packing_fraction=0.3)
    assert [row.speed for row in plain.rows] == [None] and "lj units have no usual one" in " ".join(
        plain.remarks
    )
    law = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-5)
    assert hl.check(BEAD, law=law, packing_fraction=0.3).speeds_chosen
    # ε = 0 at the fastest of them is no reason for a No.
    stiff = hl.Viscoelastic(youngs_modulus=1e7, poisson_ratio=0.3, dissipative_time=1e-3)
    assert hl.check(BEAD, law=stiff, packing_fraction=0.3).admissible is not True


# --- command line -----------------------------------------------------------------------------------------------

#: The keys of the output, and the types of their values.
KEYS = {
    "code": str, "version": str | None, "units": str, "time_step": float | None, "contacts": list,
    "numerical_damping": float | None, "stages": list, "dump": list, "checked": list, "ignored": list,
    "invalidates": list, "unknown": list, "missing": list, "remarks": list, "corrected": list,
    "admissible": bool | None, "question": str, "sentence": str, "quantity": str | None, "restitution_error": float,
    "speeds_chosen": bool, "warnings": list, "inferred": list, "state": dict,
}  # fmt: skip
MAYBE = float | None
CONTACT = {
    "types": list, "stage": int, "wall": str | None, "model": str | None, "radius": MAYBE, "other_radius": MAYBE,
    "density": MAYBE, "restitution_asked": MAYBE, "restitution": MAYBE, "clipped": bool | None, "speed": MAYBE,
    "duration": MAYBE, "steps_per_contact": int | None, "restitution_error_of_step": MAYBE, "time_step": MAYBE,
    "rayleigh_time": MAYBE, "p_wave_time": MAYBE, "largest_overlap": MAYBE, "tc_nu": MAYBE, "delta_over_d": MAYBE,
    "softening": MAYBE, "softened_overlap": MAYBE, "heated_error": MAYBE, "sheared_error": MAYBE, "rule": str,
    "error": dict, "other_versions": list, "smooth_error": MAYBE, "extrapolated": str,
    "heated_error_bar": MAYBE, "sheared_error_bar": MAYBE, "friction": dict, "frictionless_error": MAYBE,
    "temperature_ratio": MAYBE,
}  # fmt: skip
FRICTION = {
    "coefficient": MAYBE, "model": str | None, "stiffness_ratio": MAYBE, "damping_ratio": MAYBE, "limit": str | None,
    "sticks_below": MAYBE, "slides_beyond": MAYBE, "tangential_restitution": list,
    "effective_tangential_restitution": MAYBE, "half_period": MAYBE, "steps_per_half_period": int | None,
    "tangential_restitution_error_of_step": MAYBE, "not_known": str | None, "other_versions": list,
    "changed_by_attraction": MAYBE, "changed_by_limit": MAYBE,
}  # fmt: skip
FINDING = {"what": str, "types": list | None, "where": str | None}
STAGE = {
    "number": int,
    "command": str,
    "time_step": MAYBE,
    "steps": int | None,
    "gravity": MAYBE,
    "units": str,
    "shaking": MAYBE,
}


def has_form(table: dict, form: dict) -> bool:
    return table.keys() == form.keys() and all(isinstance(table[key], form[key]) for key in form)


LIGGGHTS = """\
atom_style granular
units si
region reg block 0 1 0 1 0 1 units box
create_box 1 reg
fix m1 all property/global youngsModulus peratomtype 5e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.3
pair_style gran model hertz
pair_coeff * *
timestep 1e-5
create_atoms 1 random 10 1 reg
set group all diameter 2e-3 density 2500
fix integr all nve/sphere
run 1000
"""
UNSIZED = "read_data data.pack"
COLUMN = """
mat = O.materials.append(FrictMat(young=1e7, poisson=0.3, density=2600, frictionAngle=0, label='glass'))
O.materials.append(FrictMat(young=1e9, poisson=0.3, density=2600, frictionAngle=0, label='steel'))
O.bodies.append(sphere((0, 0, 0), 0.01, fixed=True, material='steel'))
O.bodies.append(sphere((0, 0, 0.03), 0.01, fixed=True, material='steel'))
O.bodies.append([sphere((0, 0, z), 0.01, material='glass') for z in (0.06, 0.09)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_FrictPhys()],
                    [Law2_ScGeom_FrictPhys_CundallStrack()]), NewtonIntegrator()]
O.dt = 1e-5
O.run(1000)
"""


@pytest.mark.parametrize(
    "text",
    [
        script(CLIPPED, WALL),
        script(HOOKE, WALL, grains=UNSIZED),
        script(HOOKE, "fix g all gravity 9.8 vector 0 0 -1", "run 10\ntimestep 2e-7"),
        script("pair_style granular\npair_coeff * * jkr 1e7 0.5 0.3 1.0"),
        script(f"pair_style granular\npair_coeff * * hooke 1e3 10 damping velocity {TANGENTIAL}"),
        COLUMN,
        "units lj\natom_style sphere\nfix d all drag 1 1 1 1 1 1\npair_style gran/hooke 1e5 NULL 50 NULL 0 0\nrun 1",
    ],
)
@pytest.mark.parametrize("options", [{}, {"speed": (0.1, 1.0), "packing_fraction": 0.2}])
def test_every_value_has_its_type(text, options):
    verdict = hl.check(text, **options).to_dict()
    assert has_form(verdict, KEYS) and json.loads(json.dumps(verdict, allow_nan=False)) == verdict
    assert all(has_form(stage, STAGE) for stage in verdict["stages"]) and not verdict["dump"]
    for key in ("checked", "ignored", "invalidates"):
        assert all(has_form(finding, FINDING) for finding in verdict[key])
    for key in ("unknown", "missing", "remarks", "corrected"):
        assert all(isinstance(line, str) for line in verdict[key])
    for contact in verdict["contacts"]:
        assert has_form(contact, CONTACT) and has_form(contact["friction"], FRICTION)
        assert contact["error"].keys() <= {"constant", "law", "tc", "soft"}
        assert all(len(pair) == 2 for pair in contact["error"].values())
        assert contact["types"][1] == "wall" or contact["wall"] is None
        assert contact["types"][1] != "wall" or (contact["other_radius"] is None and not contact["error"])


def contacts(text, **options):
    return hl.check(text, **options).to_dict()["contacts"]


def test_null_stands_for_what_is_not_known():
    # Nothing that is known depends on the speed.
    (unsized,) = contacts(script(HOOKE, grains=UNSIZED), speed=(0.1, 1.0), packing_fraction=0.2)
    assert unsized["restitution"] == pytest.approx(0.9) and unsized["speed"] is None
    assert [unsized[key] for key in ("radius", "duration", "steps_per_contact", "tc_nu")] == [None] * 4
    # A sticking contact has no ε; an overdamped one has ε = 0 and does not end.
    sticky = "pair_style granular\npair_coeff * * jkr 1e7 0.5 0.3 1.0"
    verdict = hl.check(script(sticky), speed=(0.1, 1.0)).to_dict()
    assert [contact["restitution"] for contact in verdict["contacts"]] == [None] and verdict["invalidates"]
    assert verdict["contacts"][0]["speed"] is None and verdict["admissible"] is False
    damped = f"pair_style granular\npair_coeff * * hooke 1e3 10 damping velocity {TANGENTIAL}"
    (row,) = contacts(script(damped), speed=0.1)
    assert row["restitution"] == 0.0 and row["duration"] is None and row["restitution_asked"] is None
    # Each pair has its smallest and its largest size.
    ranged = "set type 1 diameter 1e-3 density 2500\nfix p all pour 9 1 7 region box diam range 1e-3 2e-3 dens 2e3 2e3"
    sizes = [
        (row["types"], row["radius"], row["other_radius"])
        for row in contacts(script(HOOKE, WALL, grains=ranged))
    ]
    assert sizes == [
        ([1, 1], 5e-4, 5e-4),
        ([1, 1], 1e-3, 1e-3),
        ([1, "wall"], 5e-4, None),
        ([1, "wall"], 1e-3, None),
    ]
    # Types of YADE are labels; pairs that do not move are left out; the elastic contact is damped numerically.
    verdict = hl.check(COLUMN, speed=0.1).to_dict()
    assert [contact["types"] for contact in verdict["contacts"]] == [["glass", "glass"], ["glass", "steel"]]
    assert verdict["numerical_damping"] == 0.2 and verdict["contacts"][0]["restitution"] == pytest.approx(
        0.8165, abs=1e-4
    )
    # A change between runs makes another stage, and only such a change.
    text = script(HOOKE, "timestep 1e-6\nrun 1\nfix g all gravity 9 vector 0 0 -1\nrun 1")
    assert [contact["stage"] for contact in contacts(text)] == [1, 3] and len(
        hl.check(text).to_dict()["stages"]
    ) == 3


def test_a_contact_that_lasts_under_numerical_damping():
    """A wall and grains of unknown mass, for which an overdamped contact is tried; this search had no end."""
    text = COLUMN.replace("young=1e7, poisson=0.3", "young=1e7").replace(
        "FrictMat(", "ViscElMat(kn=1e4, cn=0.6, ks=1, cs=0, "
    )
    text = text.replace("Ip2_FrictMat_FrictMat_FrictPhys", "Ip2_ViscElMat_ViscElMat_ViscElPhys")
    text = text.replace("Law2_ScGeom_FrictPhys_CundallStrack", "Law2_ScGeom_ViscElPhys_Basic")
    text = text.replace("0.01, material='glass'", "radius(), material='glass'")
    assert [row.restitution for row in hl.check(text, speed=0.5).rows if row.types == ("glass", "glass")] == [
        None
    ]


def test_contacts_too_long_for_the_law_have_no_number(tmp_path):
    words = NUMBERS.replace("1e5", "1e2").split()
    text = run("check", *words).stdout
    assert "≫ 1 %" in text and "±" not in text and "is above 0.3" in " ".join(text.split())
    assert len(printed("check", *words)["contacts"][0]["error"]["constant"]) == 2


@pytest.mark.parametrize("damping", [1e-3, 0.5, 1e3, 1e8])
def test_an_unknown_mass_proves_nothing(damping):
    contact = f"pair_style granular\npair_coeff * * hooke 1e5 {damping:g} damping velocity {TANGENTIAL}"
    verdict = hl.check(script(contact, grains=UNSIZED), speed=1.0, packing_fraction=0.1)
    (row,) = verdict.rows
    assert row.restitution is None and row.steps_per_contact is None
    assert verdict.admissible is None and not verdict.invalidates and not verdict.remarks


def test_json_is_the_result(tmp_path):
    path = tmp_path / "in.box"
    path.write_text(script(CLIPPED, WALL))
    document = printed("check", path, "--speed", "0.1:1m/s", "--packing-fraction", "0.2")
    assert [contact["types"] for contact in document["contacts"]] == [
        [1, 1],
        [1, 1],
        [1, "wall"],
        [1, "wall"],
    ]
    assert (
        document["code"] == "lammps"
        and document["units"] == "si"
        and document["contacts"][0]["error"]["constant"]
    )
    assert document == hl.check(path, speed=(0.1, 1.0), packing_fraction=0.2).to_dict()
    path.write_text(script(CLIPPED, WALL).replace("random 100 ", "random 10 "))
    ds = hl.check(path, speed=(0.1, 1.0)).contacts
    assert (
        ds.sizes["contact"] == 4 and np.isnan(ds["tc_nu"]).all() and list(ds["types"].values)[2] == "1–wall"
    )


def test_the_report_of_a_pair_and_a_wall_has_at_most_fifteen_lines(tmp_path, monkeypatch):
    path = tmp_path / "in.box"
    path.write_text(
        script(CLIPPED.replace("0.9", "0.5"), f"{WALL} limit_damping", "fix g all gravity 9.8 vector 0 0 -1")
    )
    for width in (80, 120):
        monkeypatch.setenv("COLUMNS", str(width))
        for more in ([], ["--speed", "0.1:1"], ["--speed", "0.1:1", "--packing-fraction", "0.2"]):
            lines = run("check", path, *more).stdout.splitlines()
            assert len(lines) <= 15 and "…" not in "".join(lines)
        long = run("check", path, "--speed", "1", "--verbose").stdout
        assert "steps " in long and "overlap " in long
        assert len(long.splitlines()) > 15 and "line " in long


def test_a_wide_table_leaves_columns_out_and_breaks_no_number(tmp_path, monkeypatch):
    """Long labels of materials."""
    path = tmp_path / "long.py"
    path.write_text(COLUMN.replace("glass", "a_glass_of_long_name"))
    for width, steps in ((80, False), (120, True)):
        monkeypatch.setenv("COLUMNS", str(width))
        text = run("check", path, "--speed", "0.1:1", "--packing-fraction", "0.2").stdout
        (row,) = [line for line in text.splitlines() if line.startswith("a_glass_of_long_name–a_glass")]
        assert row.rstrip().endswith("%") and "±" in row and "…" not in text
        assert ("steps" in text.split("Checked")[0]) is steps
    path = tmp_path / "in.jkr"
    path.write_text(
        script("pair_style granular\npair_coeff * * jkr 1e7 0.5 0.3 1.0").replace("random 100 ", "random 10 ")
    )
    text = run("check", path).stdout
    assert "Contacts: 1–1 R 1 mm." in text and text.startswith("LAMMPS · si units")
    assert "(give --dump, or --speed and --packing-fraction)" in " ".join(text.split())


@pytest.mark.slow
def test_several_walls_have_names_and_each_remark_is_made_once(tmp_path):
    path = tmp_path / "in.walls"
    side = WALL.replace("floor", "side").replace("0.5", "0.8").replace("zplane 0 1", "xplane 0 1")
    path.write_text(script(CLIPPED.replace("0.9", "0.5"), WALL, side, "run 1\ntimestep 1e-5"))
    text = " ".join(run("check", path).stdout.split())
    assert "1–wall floor R 1 mm" in text and "1–wall side R 1 mm" in text
    assert text.count("ε given differs") == 1 and "These are of run 2" in text
    path = tmp_path / "log.liggghts"
    path.write_text(
        "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2021 by someone, git commit 123)\n" + LIGGGHTS
    )
    assert run("check", path).stdout.startswith("LIGGGHTS PUBLIC 3.8.0: gran model hertz")
    assert printed("check", path)["version"].startswith("LIGGGHTS-PUBLIC 3.8.0, compiled")


def test_exit_codes(tmp_path):
    hard, soft = (NUMBERS.replace("1e5", stiffness).split() for stiffness in ("1e6", "1e2"))
    assert "Yes: " in run("check", *hard, "--strict").stdout
    assert "No: " in run("check", *soft).stdout
    strict = run("check", *soft, "--strict", code=1)
    assert "No: " in strict.stdout and not strict.stderr
    assert json.loads(run("check", *soft, "--strict", "--json", code=1).stdout)["admissible"] is False
    path = tmp_path / "in.melt"
    path.write_text("units lj\natom_style atomic\npair_style lj/cut 2.5\npair_coeff 1 1 1 1 2.5\nrun 10\n")
    refused("check", path)
    refused("check", tmp_path / "none")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("", "give a file"),
        ("--radius 1mm", "density"),
        (f"{NUMBERS} --code lammps", "--code: must be left out"),
        (f"{NUMBERS} --var a=1", "--var: must be left out"),
        (NUMBERS.replace("0.3m/s", "3kg"), "--speed"),
        (NUMBERS.replace("0.3m/s", "2:1"), "--speed"),
        (NUMBERS.replace("0.3m/s", "0"), "--speed"),
        (NUMBERS.replace("fraction 0.3", "fraction 0.9"), "--packing-fraction"),
        ("file --dimension 2", "--dimension: got 2, must be left out"),
        (f"{NUMBERS} --version 22Jul2025", "--version: must be left out"),
        ("file --var a", "--var: got 'a', must be NAME=VALUE"),
    ],
)
def test_bad_numbers_are_refused_in_one_line(words, line):
    assert line in refused("check", *words.split())


WORDS = st.sampled_from(
    [
        *script(HERTZ, WALL).split(),
        "-1",
        "0",
        "1e400",
        "nan",
        "${x}",
        "$(1/0)",
        '"',
        "&\n",
        "\n",
        "*",
        "jkr",
        "½",
    ]
)


@draws(80)
@given(data=st.data())
def test_a_mangled_script_gives_a_verdict_or_one_line(data):
    words = script(HERTZ, WALL).replace("\n", " \n ").split(" ")
    for _ in range(data.draw(st.integers(1, 4))):
        k = data.draw(st.integers(0, len(words) - 1))
        words[k : k + data.draw(st.integers(0, 2))] = [data.draw(WORDS)] * data.draw(st.integers(0, 2))
    try:
        verdict = hl.check(" ".join(words), speed=0.3, packing_fraction=0.1)
    except ValueError as error:
        assert "\n" not in str(error)
    else:
        json.dumps(verdict.to_dict(), allow_nan=True)
        assert verdict.sentence and ("nan" not in verdict.sentence or verdict.unknown)
        assert verdict.contacts is not None


def test_fixed_grains_among_moving_ones():
    """Those that freeze in a region meet moving ones of their type with twice the effective mass."""
    text = (
        "units si\natom_style sphere\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n"
        "create_atoms 1 random 100 1 box\nset type 1 diameter 2e-3 density 2500\n"
        "pair_style gran/hooke 1e5 NULL 2e4 NULL 0 0\npair_coeff * *\n"
        "group low region box\nfix 1 low freeze\nfix 2 all nve/sphere\nrun 1\n"
    )
    free, fixed = hl.check(text, speed=1.0).rows
    assert (free.wall, fixed.wall) == (None, "fixed") and free.types == fixed.types
    assert fixed.restitution == pytest.approx(0.72384, abs=1e-4)  # 0.72393 in LAMMPS
    assert fixed.duration == pytest.approx(free.duration * math.sqrt(2.0), rel=0.01)


@pytest.mark.slow
def test_equal_walls_share_a_row(tmp_path):
    """Six walls with two sets of numbers take two rows; ``--verbose`` and ``--json`` have all."""
    wall = "fix w{0} all wall/gran hooke 1e5 NULL {1} NULL 0 0 {2}plane 0 NULL\n"
    path = tmp_path / "in.walls"
    walls = "".join(wall.format(k, 2e4 if k < 5 else 4e4, "xyz"[k % 3]) for k in range(6))
    path.write_text(
        "units si\natom_style sphere\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n"
        "create_atoms 1 random 100 1 box\nset type 1 diameter 2e-3 density 2500\n"
        f"pair_style gran/hooke 1e5 NULL 2e4 NULL 0 0\npair_coeff * *\n{walls}fix 2 all nve/sphere\nrun 1\n"
    )
    out = run("check", str(path), "--speed", "1").stdout
    assert [line.split()[:2] for line in out.splitlines() if "–wall" in line] == [
        ["1–wall", "w0,"],
        ["1–wall", "w5"],
    ]
    assert "w0, w1 and 3 more" in out and len(out.splitlines()) <= 15
    assert (
        sum(
            "–wall" in line
            for line in run("check", str(path), "--speed", "1", "--verbose").stdout.splitlines()
        )
        >= 6
    )
    assert len(hl.check(path, speed=1.0).rows) == 7


def test_long_lists_are_shortened(tmp_path):
    """Statements that are not understood: three of them, each cut, and the number of the others."""
    path = tmp_path / "in.unknown"
    walls = "".join(f"fix w{k} all wall/gran unheard_of_style {'1.0 ' * 40}\n" for k in range(9))
    path.write_text(
        "units si\natom_style sphere\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n"
        "create_atoms 1 random 100 1 box\nset type 1 diameter 2e-3 density 2500\n"
        f"pair_style gran/hooke 1e5 NULL 2e4 NULL 0 0\npair_coeff * *\n{walls}fix 2 all nve/sphere\nrun 1\n"
    )
    out = run("check", str(path), "--speed", "1").stdout
    assert "and 5 more" in out and len(out.splitlines()) <= 15
    assert "w8" in run("check", str(path), "--speed", "1", "--verbose").stdout


def test_unequal_grains_have_a_wider_error():
    """The law of the error is that of equal grains; ν depends on the composition of a mixture."""
    text = (
        "units si\natom_style sphere\nregion box block 0 1 0 1 0 1\ncreate_box 2 box\n"
        "create_atoms 1 random 100 1 box\ncreate_atoms 2 random 100 2 box\n"
        "set type 1 diameter 2e-3 density 2500\nset type 2 diameter 3e-3 density 2500\n"
        "pair_style gran/hooke 1e7 NULL 2e4 NULL 0 0\npair_coeff * *\nfix 2 all nve/sphere\nrun 1\n"
    )
    verdict = hl.check(text, speed=1.0, packing_fraction=0.1)
    bars = {row.types: row.error["constant"][1] / row.error["constant"][0] for row in verdict.rows}
    assert bars["1", "2"] >= 0.5 > 2.0 * max(bars["1", "1"], bars["2", "2"])
    assert any("Unequal grains" in note for note in verdict.remarks)
    # A pair of equal grains whose error is surely too large decides, whatever the wide bar of another.
    soft = hl.check(text.replace("1e7", "4e4"), speed=1.0, packing_fraction=0.1)
    assert soft.admissible is False


def test_the_law_of_cooling_does_not_judge_a_shaken_box():
    at_rest = hl.ParticleSystem.random(50, 0.05, 1e-3, 2500.0, 0.3, boundary="wall", gravity=9.81)
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    assert hl.check(at_rest, law=law).admissible is False
    verdict = hl.check(
        hl.ParticleSystem.random(50, 0.05, 1e-3, 2500.0, 0.3, boundary="wall", gravity=9.81,
                                 walls={"z-": hl.MovingWall(1e-3, 50.0)}), law=law
    )  # fmt: skip
    assert (verdict.admissible, "walls drive this box" in verdict.sentence) == (None, True)


@pytest.mark.parametrize(
    ("boundary", "rest"),
    [
        ("periodic", False),
        (["wall", "periodic", "periodic"], False),
        (["periodic", "periodic", "wall"], True),
    ],
)
def test_grains_rest_only_where_a_wall_stops_their_fall(boundary, rest):
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
    box = hl.ParticleSystem.random(60, 0.2, 1e-3, 2500.0, 0.3, boundary=boundary, gravity=9.81)
    assert ("rest on each other" in hl.check(box, law=law).sentence) is rest


def test_a_wall_that_is_only_displaced_drives_nothing():
    law = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
    box = hl.ParticleSystem.random(60, 0.2, 1e-3, 2500.0, 0.3, boundary="wall")
    moved = box.replace(walls={"z+": hl.MovingWall(offset=1e-4)})
    assert not moved.driven and hl.check(moved, law=law).admissible is True


@draws(80)
@given(
    log_floats(1e2, 1e9), st.floats(0.3, 0.99), st.floats(0.01, 0.5), log_floats(1e-3, 10.0), st.booleans()
)
def test_the_softest_stiffness_is_admissible(stiffness, restitution, phi, speed, hertz):
    """What the sentence offers or asks for gives the answer Yes, and 3 % less does not."""

    def found(value):
        law = hl.LinearDashpot(stiffness=value, restitution=restitution)
        if hertz:
            law = hl.Tsuji(elastic_prefactor=value, restitution=restitution)
        return hl.check(hl.Ball(1e-3, density=2500.0), law=law, packing_fraction=phi, speed=speed)

    _, _, softest = found(stiffness).rows[0].spring
    assert found(1.0001 * softest).admissible is True
    assert found(0.97 * softest).admissible is not True
    said = re.search(r"(?:soften to|takes) an? [a-z ]+ of (\S+) ", found(stiffness).sentence)
    assert said is None or softest <= float(said[1]) <= 1.1001 * softest


# --- friction -------------------------------------------------------------------------------------------------


def with_friction(code: str, mu: float, wall: float, stiffness: float, restitution: float) -> str:
    """A script with coefficients of friction between grains and at a wall."""
    if code == "liggghts":
        text = LIGGGHTS.replace("model hertz", "model hertz tangential history").replace(
            "5e6", f"{stiffness:g}"
        )
        friction = f"fix m4 all property/global coefficientFriction peratomtypepair 1 {mu:g}"
        return text.replace("peratomtypepair 1 0.3", f"peratomtypepair 1 {restitution:g}\n{friction}")
    if code == "yade":
        return COLUMN.replace("frictionAngle=0", f"frictionAngle={math.atan(mu):g}").replace(
            "1e7", f"{stiffness:g}"
        )
    contact = {
        "linear": f"hooke {stiffness:g} {restitution:g} damping coeff_restitution tangential linear_history 1e4 0.5 ",
        "mindlin": f"hertz/material {stiffness:g} {restitution:g} 0.3 damping tsuji tangential mindlin NULL 1.0 ",
        "plain": f"hooke {stiffness:g} {restitution:g} damping coeff_restitution tangential linear_nohistory 0.5 ",
    }
    if code in contact:
        pair = f"pair_style granular\npair_coeff * * {contact[code]}{mu:g}"
        return script(pair, f"fix w all wall/gran granular {contact[code]}{wall:g} zplane 0 1")
    return script(
        f"pair_style gran/hooke/history {stiffness:g} NULL 2e4 NULL {mu:g} 1\npair_coeff * *",
        f"fix w all wall/gran hooke/history {stiffness:g} NULL 2e4 NULL {wall:g} 1 zplane 0 1",
    )


@draws(20, few=4)
@given(
    code=st.sampled_from(["linear", "mindlin", "plain", "gran", "liggghts", "yade"]),
    mu=st.sampled_from([0.0, 0.0, 1e-6, 0.3, 5.0]),
    wall=st.sampled_from([0.0, 0.4]),
    stiffness=log_floats(1e3, 1e10),
    restitution=st.floats(0.3, 0.99),
    options=st.fixed_dictionaries(
        {}, optional={"speed": log_floats(1e-4, 3.0), "packing_fraction": st.floats(0.01, 0.6)}
    ),
    drive=st.sampled_from([{}, {}, {"power": 1e-7}, {"shear_rate": 50.0}]),
)
def test_with_friction_an_answer_has_its_number_or_cannot_be_said(
    code, mu, wall, stiffness, restitution, options, drive
):
    """The error of the cooling is known with a tangential spring, that of a driven gas with linear springs; that of
    walls that rub is not in the law.
    """
    options = {name: value for name, value in options.items() if not drive or name != "speed"}
    text = with_friction(code, mu, wall, stiffness, restitution)
    verdict = hl.check(text, **options, **drive)
    pairs = [row for row in verdict.rows if row.types[1] != "wall"]
    walls = [row for row in verdict.rows if row.types[1] == "wall"]
    assert all(row.friction.coefficient == pytest.approx(mu, rel=1e-5) for row in pairs)
    known = [row for row in walls if code not in ("liggghts", "yade")]
    assert all(row.friction.coefficient == pytest.approx(wall) for row in known)
    if any(row.friction.coefficient for row in walls):
        assert verdict.admissible is not True
    if mu > 0.0 and any(row.error for row in pairs):
        assert code != "plain" and all(row.rule == "law" for row in pairs)
        assert 0.5 <= 3.5 * pairs[0].friction.stiffness_ratio <= 7.0 and mu < 5.0
        value, bar = pairs[0].error["law"]
        if "power" in drive:
            value, bar = pairs[0].heated_error, pairs[0].heated_error_bar
        elif drive:
            value, bar = pairs[0].sheared_error, pairs[0].sheared_error_bar
        if value is not None and pairs[0].tc_nu <= 0.3 and not verdict.missing and len(pairs) == 1:
            assert "same friction" in verdict.sentence or "walls rub" in verdict.sentence
            assert verdict.admissible is not (abs(value) + bar > 0.01)
        assert value is None or bar > 0.0
        assert "shear_rate" in drive or pairs[0].smooth_error * (1.0 if drive else -1.0) > 0.0
    elif mu > 0.0:
        last = [cells([row], False, verdict.quantity)[-1] for row in verdict.rows]
        assert "±" not in "".join([verdict.sentence, *last]) and "1 % takes" not in verdict.sentence
        assert not any(
            row.error or row.softening or row.heated_error or row.sheared_error for row in verdict.rows
        )
        known = max((row.tc_nu or 0.0 for row in pairs), default=0.0)
        stuck = any(row.restitution == 0.0 for row in verdict.rows)
        assert verdict.admissible is (
            False if stuck or (known > 0.3 and "speeds" not in verdict.missing) else None
        )
        reasons = ("rub (μ = ", "not known (", "a gas of many grains")
        said = any(reason in verdict.sentence for reason in reasons)
        assert stuck or known > 0.3 or verdict.unknown or said
    elif not wall and code in ("linear", "plain"):
        smooth = re.sub(
            "tangential linear_.*? (0|0.4)( zplane|\n)", r"tangential linear_nohistory 0.0 0.0\2", text
        )
        assert hl.check(smooth, **options, **drive).sentence == verdict.sentence


def test_friction_in_words_and_numbers():
    """What of the answer stands without friction, and what still decides with it."""
    rough = with_friction("linear", 0.3, 0.0, 1e4, 0.7)
    verdict = hl.check(rough, speed=0.5, packing_fraction=0.2)
    assert verdict.admissible is False and verdict.sentence.startswith("No: event-driven cools 2.3 ± ")
    assert "the same friction (rule law or constant with μ 0.3 and β0 0.2" in verdict.sentence
    assert "without, it cools about 32 % too slowly" in verdict.sentence
    row = verdict.to_dict()["contacts"][0]
    smooth = hl.check(rough.replace("0.5 0.3", "0.5 0"), speed=0.5, packing_fraction=0.2)
    assert row["friction"]["coefficient"] == 0.3 and set(row["error"]) == {"law", "constant"}
    hard = hl.check(
        with_friction("linear", 0.3, 0.0, 1e4, 0.7).replace("0.5 0.3", "0.5 5"),
        speed=0.5,
        packing_fraction=0.2,
    )
    assert "not known with this friction; without it, it is about 2.5 % (too fast) at" in hard.sentence
    assert row["frictionless_error"] == pytest.approx(smooth.rows[0].error["constant"][0])
    assert smooth.admissible is False and "±" in smooth.sentence
    # Contacts that overlap in time, and whatever no event follows, decide all the same.
    soft = hl.check(with_friction("linear", 0.3, 0.0, 50, 0.7), speed=0.5, packing_fraction=0.2)
    assert (
        soft.admissible is False
        and "contacts overlap in time" in soft.sentence
        and "takes" not in soft.sentence
    )
    # One rough pair among smooth ones: the gas has no number.
    two = rough.replace("create_box 1", "create_box 2").replace(
        "set type", "create_atoms 2 random 9 1 box\nset type"
    )
    two = (
        two.replace("set type 1 ", "set type 1*2 ")
        + "pair_coeff 2 2 hooke 1e4 0.7 damping tsuji tangential linear_nohistory 0 0\nrun 1\n"
    )
    mixed = hl.check(two, speed=0.5, packing_fraction=0.2)
    assert "±" not in mixed.sentence and not any(row.error for row in mixed.rows)
    # Pairs without their own line have the geometric mean, as in LAMMPS; what is not in the script is not known.
    line = "pair_coeff {0} {0} hooke 1e6 0.9 damping tsuji tangential linear_history 1e4 0.5 {1}\n"
    alone = re.sub("pair_coeff [*12].*\n", "", two).replace("pair_style granular\n", "pair_style granular\n" + "".join(
        line.format(k, mu) for k, mu in ((1, 0.4), (2, 0.1))))  # fmt: skip
    rows = {row.types: row.friction.coefficient for row in hl.check(alone, speed=0.5).rows}
    assert [rows[types] for types in (("1", "1"), ("1", "2"), ("2", "2"))] == pytest.approx([0.4, 0.2, 0.1])
    unsaid = hl.check(LIGGGHTS.replace("model hertz", "model hertz tangential history"), speed=0.01)
    assert unsaid.rows[0].friction.coefficient is None and "rub (μ is not known)" in unsaid.sentence
    # Friction at walls only: the number of the gas stands, and Yes does not.
    wall = hl.check(with_friction("linear", 0.0, 0.3, 1e6, 0.9), speed=0.5, packing_fraction=0.2)
    assert wall.admissible is None and "±" in wall.sentence and "walls rub" in wall.sentence


# --- pressed and shaken boxes ---------------------------------------------------------------------------------

FALL = "fix g all gravity 9.81 vector 0 0 -1"
QUIET = {"speed": 0.01, "packing_fraction": 0.05}


@pytest.mark.parametrize(
    ("line", "pressed"),
    [
        *((f"fix d all deform 1 {words}", True) for words in (
            "x erate -1", "y trate -1e-3", "z vel -2", "x scale 0.5", "x final 0 0.9", "z delta 0.1 -0.1",
            "x erate -1 y erate 0.5", "x erate -1 y scale 1.5", "x scale 0.9 y scale 1.1", "xy erate 3 z vel -1",
        )),
        *((f"fix d all deform 1 {words}", False) for words in (
            "x erate 1", "z vel 2", "x scale 1.5", "x final 0 1.5", "x delta 0 0.1", "x erate -1 y erate 1",
            "x erate -1 y volume z volume", "x scale 0.5 y scale 2", "x wiggle 0.1 1", "xy erate 3", "xz vel 2",
        )),
        ("fix d all deform/pressure 1 x pressure 10 1", True),
        ("fix d all nph/sphere iso 1 1 1", True),
        ("fix d all npt/sphere temp 1 1 1 iso 1 1 1", True),
        ("fix d all press/berendsen iso 1 1 1", True),
        ("change_box all x scale 0.9 remap", True),
        ("change_box all x scale 1.1 remap", False),
        (f"variable top equal f_1*0.1\n{WALL.replace('zplane 0 1', 'zplane 0 v_top')}", True),
        ("region r block 0 1 0 1 0 1 move NULL NULL v_s\nvariable s equal c_1\n"
         f"{WALL.replace('zplane 0 1', 'region r')}", True),
    ],
)  # fmt: skip
def test_what_prescribes_a_pressure_or_shrinks_the_box_is_pressed(line, pressed):
    """Contacts of pressed grains last. A box that grows, or is sheared, does not press."""
    verdict = hl.check(script(CLIPPED, line), **QUIET)
    assert (verdict.admissible is False) is pressed
    assert (
        "pressed together" in verdict.sentence
        or "a barostat" in verdict.sentence
        or "and a barostat" in verdict.sentence
    ) is pressed
    judged_so = "the shear stress of event-driven" in verdict.sentence or line.startswith("change_box")
    assert pressed or verdict.admissible is None or judged_so


YADE_BOX = """
O.materials.append(FrictMat(young=1e9, frictionAngle=0))
sp = pack.SpherePack()
sp.makeCloud((0, 0, 0), (.1, .1, .1), rMean=.002)
sp.toSimulation()
O.bodies.append(aabbWalls([(0, 0, 0), (.1, .1, .1)], thickness=0))
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()], [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.9)],
                    [Law2_ScGeom_MindlinPhys_Mindlin()]), {engine} NewtonIntegrator(damping=0, gravity=(0, 0, {g}))]
O.dt = 1e-7
{more}
O.run(1000)
"""


@pytest.mark.parametrize(
    ("engine", "more", "pressed"),
    [
        ("PeriTriaxController(goal=(-1e5, -1e5, -1e5), stressMask=7),", "", True),
        ("PeriTriaxController(goal=(-.1, -.1, -.1), stressMask=0),", "", True),
        ("TriaxialStressController(goal1=-1e4),", "", True),
        ("PeriIsoCompressor(stresses=[1e4]),", "", True),
        ("UniaxialStrainer(strainRate=-.1),", "", True),
        ("ServoPIDController(target=10),", "", True),
        ("", "O.cell.velGrad = Matrix3(-.1, 0, 0, 0, 0, 0, 0, 0, 0)", True),
        ("", "O.cell.velGrad = Matrix3(-.1, 0, 0, 0, .1, 0, 0, 0, 0)", False),
        ("", "", False),
    ],
)
def test_controllers_of_yade_press(engine, more, pressed):
    verdict = hl.check(YADE_BOX.format(engine=engine, more=more, g=0), **QUIET)
    assert ("pressed together" in verdict.sentence) is (verdict.admissible is False) is pressed


def test_servo_walls_of_liggghts_press():
    servo = "fix m all mesh/surface/stress/servo file a.stl type 1 com 0 0 0 ctrlPV force axis 0 0 1 target_val 9\n"
    wall = "fix w all wall/gran model hertz mesh n_meshes 1 meshes m\nrun 1000"
    verdict = hl.check(LIGGGHTS.replace("5e6", "1e9").replace("run 1000", servo + wall), **QUIET)
    assert verdict.admissible is False and "pressed together (a servo" in verdict.sentence
    turning = hl.check(LIGGGHTS.replace("run 1000", servo.replace("force", "torque") + wall), **QUIET)
    assert "pressed together" not in turning.sentence


def test_a_dump_shows_whether_pressed_grains_are_in_contact(tmp_path):
    """Two frames: a gas, and touching grains."""
    for gap, last in ((3e-3, False), (1.9e-3, True)):
        path = tmp_path / f"dump.{last}"
        rows = "".join(f"{k + 1} 1 {gap * k} 0 0 {0.1 * (-1) ** k} 0 0 1e-3\n" for k in range(8))
        path.write_text(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n8\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n"
            f"ITEM: ATOMS id type x y z vx vy vz radius\n{rows}"
        )
        verdict = hl.check(script(CLIPPED, "fix d all deform 1 x scale 0.5"), dump=path)
        assert ("contacts on average in the dump" in verdict.sentence) is last
        assert verdict.admissible is (False if last else None)
        assert last or "fix deform x scale 0.5 drives this box" in verdict.sentence


SHAKEN = {  # a floor that shakes along an axis with amplitude and period, in each code
    "wall": lambda axis, size, time: script(CLIPPED, FALL, f"{WALL} wiggle {axis} {size} {time}"),
    "region": lambda axis, size, time: script(
        CLIPPED, FALL, f"variable s equal swiggle(0,{size},{time})",
        f"region r block 0 1 0 1 0 1 move {' '.join('v_s' if name == axis else 'NULL' for name in 'xyz')}",
        WALL.replace("zplane 0 1", "region r"),
    ),
    "formula": lambda axis, size, time: script(
        CLIPPED, FALL, f"variable s equal 0.01-{size}*cos(2*PI*(step+7)*dt/{time})",
        f"region r block 0 1 0 1 0 1 move {' '.join('v_s' if name == axis else 'NULL' for name in 'xyz')}",
        WALL.replace("zplane 0 1", "region r"),
    ),
    "some grains": lambda axis, size, time: script(
        CLIPPED, FALL, "region b block INF INF INF INF INF 0.01", "group low region b", "group high subtract all low",
        f"variable s equal {size}*sin(2*PI*time/{time})", "variable v equal 0",
        "fix mv low move variable " + " ".join("v_s" if name == axis else "NULL" for name in "xyz")
        + " " + " ".join("v_v" if name == axis else "NULL" for name in "xyz"),
    ).replace("fix move all", "fix move high"),
    "grains": lambda axis, size, time: script(CLIPPED, FALL, "group low type 2", "fix mv low move wiggle "
        + " ".join(str(size) if name == axis else "0" for name in "xyz") + f" {time}",
    ).replace("create_box 1", "create_box 2").replace("set type 1 ", "create_atoms 2 random 9 3 box\nset type 1*2 ")
     .replace("fix move all", "group high type 1\nfix move high"),
    "mesh": lambda axis, size, time: LIGGGHTS.replace("run 1000", f"{FALL}\nfix m all mesh/surface file a.stl type 1\n"
        f"fix mv all move/mesh mesh m wiggle amplitude {' '.join(str(size) if x == axis else '0' for x in 'xyz')} "
        f"period {time}\nfix w all wall/gran model hertz mesh n_meshes 1 meshes m\nrun 1000"),
    "yade": lambda axis, size, time: YADE_BOX.format(more="", g=-9.81, engine="HarmonicMotionEngine("
        f"A=({', '.join(str(size) if name == axis else '0' for name in 'xyz')}), "
        f"f=({', '.join(str(1.0 / time) if name == axis else '0' for name in 'xyz')}), ids=[4]),"),
    "cgs": lambda axis, size, time: script(
        CLIPPED.replace("1e5", "1e8"), FALL.replace("9.81", "981"),
        f"{WALL.replace('1e5', '1e8')} wiggle {axis} {1e2 * size} {time}",
        units="cgs", grains="set type 1 diameter 0.2 density 2.5"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("grains", "wall", "option"), [(0.3, 0.3, " --friction 0.3)"), (0.3, 0.5, None), (0.0, 0.0, ")")]
)
def test_the_comparison_of_a_shaken_box_has_its_friction(grains, wall, option):
    """One coefficient is an option of it; several are not, and no command is named."""
    text = SHAKEN["formula"]("z", 1e-3, 0.02)
    pair, side = (
        next(line for line in text.splitlines() if line.startswith(name))
        for name in ("pair_coeff", "fix floor")
    )
    for line, mu in ((pair, grains), (side, wall)):
        changed = re.sub(r"linear_nohistory \S+ \S+", f"linear_nohistory {mu} {mu}", line)
        text = text.replace(line, changed)
    sentence = hl.check(text, **QUIET).sentence
    assert ("gas compare" in sentence) is (option is not None)
    assert option is None or f"--shake 1mm:50Hz --gravity 9.81 --radius 1mm{option}" in sentence


@pytest.mark.parametrize("size", [2e-5, 1e-3])
def test_a_floor_of_grains_above_a_wall_that_does_not_move(size):
    """Up to Γ = 1 grains rest on it; beyond, whether they fall past it onto the wall is not known."""
    text = SHAKEN["some grains"]("z", size, 0.02).replace("fix move high", f"{WALL}\nfix move high")
    verdict = hl.check(text, **QUIET)
    shaking = verdict.stages[-1].shaking
    assert verdict.admissible is (None if shaking > 1.0 else False) and ("rest" in verdict.sentence) is (
        shaking < 1.0
    )


@pytest.mark.parametrize(
    "formula",
    [
        *(
            "1e-3*sin(100*time)^2",
            "1e-3*abs(sin(100*time))",
            "1e-3*time*sin(100*time)",
            "1e-3*sin(100*time)+0.1*time",
        ),
        *(
            "1e-3*sin(time*time)",
            "1e-3*sin(1)*time",
            "1e-3*sin(100*time",
            "v_none*sin(100*time)",
            "1e-3*sin(1)",
        ),
        *("1e-3*sin(100*time)+1e-3*sin(200*time)", "1e-3*sin(100*time)*cos(100*time)", "vdisplace(0,0.1)"),
    ],
)
def test_other_formulas_are_no_oscillation(formula):
    """A floor that moves, but neither its Γ nor that grains rest on it is said."""
    text = SHAKEN["formula"]("z", 1e-3, 0.02)
    shaken = hl.check(re.sub("variable s equal .*", f"variable s equal {formula}", text), **QUIET)
    assert shaken.stages[-1].shaking is None
    moves = "time" in formula or "vdisplace" in formula
    assert shaken.admissible is (None if moves else False) and ("walls drive" in shaken.sentence) is moves


@pytest.mark.parametrize("kind", SHAKEN)
@pytest.mark.parametrize(("axis", "size", "time"), [("z", 1e-3, 0.02), ("z", 5e-5, 0.02), ("x", 1e-3, 0.02)])
def test_a_floor_that_shakes_stronger_than_gravity_drives_a_gas(kind, axis, size, time):
    """Γ = A ω²/g along gravity; at Γ ≤ 1, and on a floor that shakes sideways, grains rest."""
    verdict = hl.check(SHAKEN[kind](axis, size, time), **QUIET)
    gamma = size * (2.0 * math.pi / time) ** 2 / 9.81 if axis == "z" else None
    assert verdict.stages[-1].shaking == (None if gamma is None else pytest.approx(gamma))
    if gamma is None:
        assert (
            verdict.admissible is False
            and "Γ" not in verdict.sentence
            and "rest or flow in lasting contact" in verdict.sentence
        )
    else:
        assert f"Γ = A ω²/g = {gamma:.3g}" in verdict.sentence
        assert verdict.admissible is (None if gamma > 1.0 else False)
        assert ("rest on each other" in verdict.sentence) is (gamma <= 1.0)
        assert ("hardlimit gas compare --shake 1mm:50Hz" in verdict.sentence) is (gamma > 1.0)
        assert verdict.quantity is None


def test_what_rests_before_it_is_shaken_does_not_decide():
    """Grains settle, then the floor shakes; and the other way round. A still floor below a shaken wall holds them."""
    shaking = f"unfix floor\n{WALL} wiggle z 0.001 0.02\nrun 100"
    first = script(CLIPPED, FALL, WALL)
    assert hl.check(first + shaking, **QUIET).admissible is None
    still = hl.check(
        script(CLIPPED, FALL, f"{WALL} wiggle z 0.001 0.02") + f"unfix floor\n{WALL}\nrun 100", **QUIET
    )
    assert still.admissible is False
    cylinder = WALL.replace("floor", "side").replace("zplane 0 1", "zcylinder 0.5 wiggle z 0.001 0.02")
    assert hl.check(script(CLIPPED, FALL, WALL, cylinder), **QUIET).admissible is False
    # Nothing falls: any moving wall supplies energy, unless it slides without friction.
    assert "walls drive" in hl.check(script(CLIPPED, f"{WALL} wiggle x 0.001 0.02"), **QUIET).sentence
    assert hl.check(script(CLIPPED, f"{WALL} shear x 1"), **QUIET).admissible is True
    # A stronger motion sideways does not hide the one along gravity.
    both = "HarmonicMotionEngine(A=(.01, 0, .001), f=(50, 0, 50), ids=[4]),"
    assert "Γ = A ω²/g = 10.1" in hl.check(YADE_BOX.format(engine=both, more="", g=-9.81), **QUIET).sentence
    rough = WALL.replace("0.0 0.0", "1.0 0.5")
    verdict = hl.check(script(CLIPPED, f"{rough} shear x 1"), **QUIET)
    assert (
        verdict.admissible is None
        and "grains rub (μ = 0.5)" in verdict.sentence
        and "gas compare" not in verdict.sentence
    )


def test_a_system_on_a_shaken_floor():
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.9)
    for wall, gamma in ((hl.MovingWall(1e-3, 50.0), 10.1), (hl.MovingWall(1e-5, 50.0), 0.101)):
        for name in ("z-", "x+"):
            box = hl.ParticleSystem.random(
                50, 0.05, 1e-3, 2500.0, 0.3, boundary="wall", gravity=9.81, walls={name: wall}
            )
            verdict = hl.check(box, law=law)
            assert verdict.admissible is (None if gamma > 1.0 and name == "z-" else False)
            assert (f"(Γ = A ω²/g = {gamma:.3g})" in verdict.sentence) is (name == "z-")


# --- driven gases -------------------------------------------------------------------------------------------


@draws(60)
@given(
    log_floats(1e-5, 1e-2), log_floats(1e2, 1e8), st.floats(0.5, 0.97), st.floats(0.02, 0.45),
    log_floats(1e-8, 1.0), st.booleans(), st.booleans(),
)  # fmt: skip
def test_the_steady_speed_balances_power_and_loss(radius, stiffness, restitution, phi, drive, sheared, hertz):
    """The speed is √(πT) of Enskog's balance, with the ε that the contact has at this speed."""
    ball = hl.Ball(radius, density=2500.0)
    law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    if hertz:
        law = hl.Viscoelastic(
            youngs_modulus=1e5 * stiffness, poisson_ratio=0.3, restitution=restitution, impact_speed=1.0
        )
    options = {"shear_rate": 1e5 * drive} if sheared else {"power": drive * ball.mass}
    verdict = hl.check(ball, law=law, packing_fraction=phi, **options)
    pair = next(row for row in verdict.rows if row.types == ("1", "1"))
    if pair.speed is None:
        assert (
            verdict.admissible is None
            and "speeds" in verdict.missing
            and "No speed from" in verdict.remarks[-1]
        )
        assert sheared or hertz  # out of the range of shear; or so slow that ε → 1
        return
    volume = 4.0 / 3.0 * math.pi * radius**3
    gas = theory.Gas(1, radius, ball.mass, volume / phi, 3)
    e = law.between(ball, ball).restitution(pair.speed)
    t = (
        gas.rotating(e, 0.0, 0.0).sheared_temperature(1e5 * drive)
        if sheared
        else gas.heated_temperature(drive * ball.mass, e)
    )
    assert pair.speed == pytest.approx(math.sqrt(math.pi * t), rel=1e-6)
    assert pair.restitution == pytest.approx(e, rel=1e-6)
    assert pair.tc_nu == pytest.approx(pair.duration * float(gas.collision_rate(t)), rel=1e-6)
    wall = next((row for row in verdict.rows if row.types[1] == "wall"), None)
    assert wall is None or wall.speed == pytest.approx(pair.speed / math.sqrt(2.0))
    assert "are those of the steady state under" in verdict.sentence
    # The quantity for which the box is run decides, not the cooling.
    assert verdict.quantity == ("stress" if sheared else "temperature")
    value, bar = (
        (pair.sheared_error, pair.sheared_error_bar)
        if sheared
        else (pair.heated_error, pair.heated_error_bar)
    )
    if pair.tc_nu > 0.3:
        assert verdict.admissible is False
    elif value is None:
        assert verdict.admissible is None
    else:
        law_of_error = error_law(packing_fraction=phi, restitution=pair.restitution, law=law, rule=pair.rule)
        own = (
            law_of_error.sheared_errors(pair.tc_nu).stress
            if sheared
            else law_of_error.heated_error(pair.tc_nu)
        )
        assert value == pytest.approx(own, rel=1e-6)
        low, high = abs(value) - bar, abs(value) + bar
        assert verdict.admissible is (False if low > 0.01 else True if high <= 0.01 else None)


@draws(40)
@given(st.sampled_from(sorted(hl.LAWS)), log_floats(1e-8, 1.0), st.booleans())
def test_elastic_grains_have_no_steady_state(name, drive, sheared):
    damping = {"viscoelastic": {"youngs_modulus": 1e7, "poisson_ratio": 0.3, "dissipative_time": 0.0}}
    law = hl.LAWS[name](
        **damping.get(name, {"restitution": 1.0}),
        **{"linear": {"stiffness": 1e5}, "tsuji": {"elastic_prefactor": 1e7}}.get(name, {}),
    )
    options = {"shear_rate": 1e4 * drive} if sheared else {"power": drive}
    verdict = hl.check(BEAD, law=law, packing_fraction=0.3, **options)
    assert verdict.admissible is None and "heat for ever" in verdict.remarks[-1]


def test_no_theory_has_shear_and_a_thermostat():
    box = hl.ParticleSystem.random(
        60, 0.2, 1e-3, 2500.0, 0.3, boundary=["periodic", "lees-edwards", "periodic"], shear_rate=10.0,
        thermostat=hl.RandomKicks(1e-6, 1e-4),
    )  # fmt: skip
    verdict = hl.check(box, law=hl.LinearDashpot(stiffness=1e5, restitution=0.9))
    assert verdict.admissible is None and "shear and a thermostat" in verdict.remarks[-1]


@pytest.mark.parametrize(
    "bath", [hl.RandomKicks(1e-6, 1e-4, rotational=1e-6), hl.Andersen(0.1, 1.0, rotational=0.1)]
)
def test_spins_of_smooth_grains_heat_nothing(bath):
    law, box = (
        hl.LinearDashpot(stiffness=1e5, restitution=0.9),
        hl.ParticleSystem.random(60, 0.2, 1e-3, 2500.0, 0.3),
    )
    turning, other = (
        hl.check(box.replace(thermostat=t), law=law) for t in (bath, replace(bath, rotational=None))
    )
    assert turning.rows[0].speed == pytest.approx(other.rows[0].speed, rel=1e-9)
    assert (
        turning.rows[0].heated_error == pytest.approx(other.rows[0].heated_error)
        and turning.admissible is True
    )
    alone = hl.check(box.replace(thermostat=hl.RandomKicks(0.0, 1e-4, rotational=1e-6)), law=law)
    assert alone.admissible is None and alone.remarks[-1].endswith("without friction move nothing.")


@pytest.mark.parametrize(("phi", "e"), [(0.1, 0.9), (0.3, 0.7)])
def test_the_steady_speed_is_that_of_heated_hard_spheres(phi, e):
    """A system with its thermostat, by simulation: 5 % of the speed, of which sampling 1 %. At rest at the start."""
    law = hl.LinearDashpot(stiffness=1e6, restitution=e)
    start = hl.ParticleSystem.random(300, phi, 1e-3, 2500.0, 0.2, seed=3)
    heated = start.replace(thermostat=hl.RandomKicks(3e-3, 2e-5, seed=2))
    speed = next(iter(hl.check(heated, law=law).rows)).speed
    free = 1.0 / float(theory.gas(start).collision_rate(speed**2 / math.pi))
    heated = heated.replace(thermostat=hl.RandomKicks(3e-3, 0.07 * free, seed=2))
    run = hl.event_driven(heated, restitution=e, until=150.0 * free, samples=300)
    simulated = math.sqrt(math.pi * float(run.series.granular_temperature[100:].mean()))
    assert simulated == pytest.approx(speed, rel=0.05)


def test_an_andersen_bath_is_colder_than_its_temperature():
    """A system in a bath, by simulation: 5 % of the speed."""
    law = hl.LinearDashpot(stiffness=1e6, restitution=0.7)
    bath = hl.Andersen(temperature=0.04, rate=20.0, seed=2)
    heated = hl.ParticleSystem.random(300, 0.2, 1e-3, 2500.0, 0.2, seed=3, thermostat=bath)
    verdict = hl.check(heated, law=law)
    speed = verdict.rows[0].speed
    assert speed < 0.8 * math.sqrt(math.pi * 0.04) and "the thermostat" in verdict.sentence
    run = hl.event_driven(heated, restitution=0.7, until=0.6, samples=300)
    assert math.sqrt(math.pi * float(run.series.granular_temperature[100:].mean())) == pytest.approx(
        speed, rel=0.05
    )


def test_scripts_take_a_power_or_a_shear_rate():
    """In cgs units the numbers are converted; the answer is that of the same script in SI units."""
    for options in ({"power": 1e-6}, {"shear_rate": 200.0}):
        verdict = hl.check(script(CLIPPED), packing_fraction=0.2, **options)
        cgs = script(CLIPPED.replace("1e5", "1e8"), units="cgs", grains="set type 1 diameter 0.2 density 2.5")
        other = hl.check(cgs, packing_fraction=0.2, **options)
        assert other.rows[0].speed == pytest.approx(verdict.rows[0].speed)
        assert other.sentence.split("Impacts")[1] == verdict.sentence.split("Impacts")[1]
    grains = hl.check(script(CLIPPED), packing_fraction=0.2, power=1e-6).rows[0]
    law = hl.LinearDashpot(stiffness=1e5, restitution=grains.restitution)
    ball = hl.check(BEAD, law=law, packing_fraction=0.2, power=1e-6)
    assert grains.speed == pytest.approx(ball.rows[0].speed)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"power": 1e-3, "speed": 1.0}, "speed | power: got 2 of them"),
        ({"power": 1e-3, "shear_rate": 1.0}, "power | shear_rate: got 2 of them"),
        ({"power": -1.0}, "power: got -1"),
        ({"shear_rate": 0.0}, "shear_rate: got 0"),
    ],
)
def test_a_bad_drive_is_refused(options, text):
    with pytest.raises(ValueError) as caught:
        hl.check(BEAD, law=hl.LinearDashpot(stiffness=1e5, restitution=0.9), packing_fraction=0.2, **options)
    assert str(caught.value).startswith(text)


def test_the_command_takes_a_power_or_a_shear_rate():
    numbers = NUMBERS.replace("--speed 0.3m/s ", "").split()
    watt = printed("check", *numbers, "--power", "1uW")
    assert watt["contacts"][0]["speed"] == pytest.approx(
        hl.check(BEAD, law=hl.LinearDashpot(stiffness=1e5, restitution=0.9), packing_fraction=0.3, power=1e-6)
        .rows[0]
        .speed
    )
    rates = [
        printed("check", *numbers, "--shear", text)["contacts"][0]["speed"]
        for text in ("100/s", "0.1/ms", "100")
    ]
    assert len(set(rates)) == 1
    assert "--speed | --power | --shear" in refused("check", *NUMBERS.split(), "--power", "1uW")


def test_a_sheared_script_is_judged_by_its_stress():
    """The rate of ``fix deform`` is that of ``shear_rate=``; with a speed, only the quantity is another one."""
    shear = "fix d all deform 1 {} remap v"
    own = hl.check(script(CLIPPED, shear.format("xy erate 200")), packing_fraction=0.2)
    assert own.sentence == hl.check(script(CLIPPED), packing_fraction=0.2, shear_rate=200.0).sentence
    assert own.quantity == "stress" and "the shear stress of event-driven is" in own.sentence
    box = hl.check(script(CLIPPED, shear.format("xy vel 200")), packing_fraction=0.2)  # an edge of 1 m
    assert box.rows[0].speed == pytest.approx(own.rows[0].speed)
    at = hl.check(script(CLIPPED, shear.format("xy erate 200")), packing_fraction=0.2, speed=0.3)
    assert at.rows[0].speed == 0.3 and at.quantity == "stress" and "Impacts" not in at.sentence
    cgs = CLIPPED.replace("1e5", "1e8")
    other = hl.check(
        script(cgs, shear.format("yz erate 200"), units="cgs", grains="set type 1 diameter 0.2 density 2.5"),
        packing_fraction=0.2,
    )
    assert other.sentence.replace("dyn/cm", "N/m").split(";")[0] == own.sentence.split(";")[0]
    # Two tilts, a tilt that oscillates and a shear with a thermostat have no law.
    for line in ("xy erate 2 xz erate 1", "xy wiggle 0.1 1", "xy erate 2\nfix l all langevin 1e17 1e17 1 7"):
        assert (
            hl.check(script(CLIPPED, shear.format(line)), packing_fraction=0.2, speed=0.1).admissible is None
        )
    dense = hl.check(script(CLIPPED, shear.format("xy erate 200")), packing_fraction=0.6, speed=0.01)
    assert dense.sentence == (
        "Cannot be said: the error of the shear stress is not known for these grains and this packing."
    )


def test_a_bath_of_langevin_is_judged_by_its_temperature():
    """Steady temperature and its error: a weak bath is that of heating at constant power, a strong one corrects it."""
    k, mass = 1.380649e-23, BEAD.mass
    errors = []
    for damp in (1e-4, 1.0, 1e6):
        verdict = hl.check(script(CLIPPED, f"fix l all langevin 1e17 1e17 {damp} 7"), packing_fraction=0.2)
        row, hot = verdict.rows[0], k * 1e17 / mass
        t = row.speed**2 / math.pi
        gas = theory.Gas(1, 1e-3, mass, BEAD.mass / 2500.0 / 0.2, 3)
        loss = (1.0 - row.restitution**2) * float(gas.collision_rate(t)) * t / 3.0
        assert 2.0 / damp * (hot - t) == pytest.approx(loss, rel=1e-6)
        law = error_law(packing_fraction=0.2, restitution=row.restitution)
        errors.append(row.heated_error / law.heated_error(row.tc_nu))
        # The error of the loss at this balance, to first order.
        share = 1.5 * (hot - t) / (t + 1.5 * (hot - t))
        assert errors[-1] == pytest.approx(share) and verdict.quantity == "temperature"
        assert "under the thermostat" in verdict.sentence and "cools" not in verdict.sentence
    assert errors[0] < 0.02 and errors[-1] > 0.99
    at = hl.check(script(CLIPPED, "fix l all langevin 1e17 1e17 1.0 7"), packing_fraction=0.2, speed=0.4)
    law = error_law(packing_fraction=0.2, restitution=at.rows[0].restitution)
    t, hot = 0.16 / math.pi, k * 1e17 / mass
    share = 1.5 * (hot - t) / (t + 1.5 * (hot - t))  # at the given speed as well
    assert at.rows[0].heated_error == pytest.approx(share * law.heated_error(at.rows[0].tc_nu))
    for line in ("1 2 1 7", "v_hot v_hot 1 7"):  # no steady temperature
        text = script(CLIPPED, f"variable hot equal step\nfix l all langevin {line}")
        assert "a thermostat (langevin)" in hl.check(text, packing_fraction=0.2, speed=0.1).sentence


@draws(60)
@given(
    log_floats(1e3, 1e8), st.floats(0.52, 0.97), st.floats(0.05, 0.45), log_floats(1e-6, 1e-1), st.booleans()
)
def test_the_softest_stiffness_of_a_driven_gas_is_admissible(stiffness, restitution, phi, drive, sheared):
    """As for a cooling gas, by the error of temperature or stress."""
    options = {"shear_rate": 1e3 * drive} if sheared else {"power": drive * BEAD.mass}

    def found(value):
        law = hl.LinearDashpot(stiffness=value, restitution=restitution)
        return hl.check(BEAD, law=law, packing_fraction=phi, **options)

    row = found(stiffness).rows[0]
    assert found(1.001 * row.spring[2]).admissible is True
    assert found(0.97 * row.spring[2]).admissible is not True


def test_a_variable_that_the_script_does_not_have_is_named(tmp_path):
    text = script(
        "variable k index 1e5\npair_style granular\npair_coeff * * hooke ${k} 0.9 damping coeff_restitution"
    )
    named = [note.what for note in hl.check(text, speed=0.1, variables={"K": "2e5"}).warnings]
    assert "the script has no variable K, which was given" in named
    (tmp_path / "in.contact").write_text(
        "pair_style granular\npair_coeff * * hooke ${k} 0.9 damping coeff_restitution\n"
    )
    (tmp_path / "in.box").write_text(script("include in.contact"))
    for source in (text, tmp_path / "in.box"):
        verdict = hl.check(source, speed=0.1, variables={"k": "2e5"})
        assert verdict.rows[0].spring[1] == 2e5 and not verdict.warnings
