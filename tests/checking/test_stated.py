"""What a script says is used, numbers beside it fill what is missing, and each inferred value is said."""

import pytest

import hardlimit as hl
from command_line import refused, run

FRICTIONLESS = "tangential linear_nohistory 0.0 0.0"
PAIR = f"pair_style granular\npair_coeff * * hooke 1e5 0.9 damping coeff_restitution {FRICTIONLESS}"
WITHOUT_SIZES = (
    f"units si\natom_style sphere\nread_data grains.data\n{PAIR}\nfix move all nve/sphere\nrun 100\n"
)


def saved(tmp_path, text, name="in.box"):
    """The path of a script."""
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


# --- the question, and numbers beside a script ------------------------------------------------------------------


def test_the_answer_begins_with_its_question(tmp_path):
    path = saved(tmp_path, WITHOUT_SIZES)
    verdict = hl.check(path, speed=0.3, packing_fraction=0.3)
    assert verdict.question == "May an event-driven simulation replace this?"
    assert str(verdict) == f"{verdict.question} {verdict.sentence}"
    assert verdict.to_dict()["question"] == verdict.question
    assert f"{verdict.question} Cannot be said: " in " ".join(run("check", path).stdout.split())


def test_numbers_beside_a_script_fill_what_it_does_not_say(tmp_path):
    """The same contacts as those of a script that states them; the file of their sizes need not be there."""
    path = saved(tmp_path, WITHOUT_SIZES)
    known = "set type 1 diameter 2e-3 density 2500"
    stated = WITHOUT_SIZES.replace("read_data grains.data", f"create_atoms 1 single 0 0 0\n{known}")
    options = {"speed": 0.3, "packing_fraction": 0.3}
    wanted = hl.check(stated.replace("run", "timestep 1e-6\nrun"), **options)
    verdict = hl.check(path, radius=1e-3, density=2500.0, time_step=1e-6, **options)
    assert verdict.rows == wanted.rows and not verdict.unknown and "within the error bar" in verdict.sentence
    by_mass = hl.check(
        path, radius=1e-3, mass=wanted.rows[0].density * 4e-9 / 3 * 3.141592653589793, **options
    )
    assert by_mass.rows[0].duration == pytest.approx(wanted.rows[0].duration)
    partly = hl.check(path, radius=1e-3, **options)
    assert partly.missing == ("masses",) and "--density" in partly.sentence
    for numbers in ({"radius": 1e-3}, {"density": 1.0}, {"mass": 1.0}):
        with pytest.raises(ValueError, match="must be left out: the script states that of all grains"):
            hl.check(stated, **numbers)
    with pytest.raises(ValueError, match=r"density \| mass: got both"):
        hl.check(path, density=1.0, mass=1.0)
    assert "--law" in refused("check", path, "--law", "linear")


def test_numbers_beside_a_script_have_its_units():
    """In cgs and micro units, lengths, densities and times are converted; in lj units they are taken as they are."""
    for units, length, density, time in (
        ("cgs", 1e-2, 1e3, 1.0),
        ("micro", 1e-6, 1e3, 1e-6),
        ("lj", 1, 1, 1),
    ):
        text = WITHOUT_SIZES.replace("units si", f"units {units}")
        row = hl.check(text, radius=2 * length, density=3 * density, time_step=4e-7 * time, speed=0.1).rows[0]
        same = text.replace(
            "read_data grains.data", "create_atoms 1 single 0 0 0\nset type 1 diameter 4 density 3"
        )
        other = hl.check(same.replace("run", "timestep 4e-7\nrun"), speed=0.1).rows[0]
        assert (row.duration, row.radius, row.steps_per_contact) == pytest.approx(
            (other.duration, other.radius, other.steps_per_contact)
        )


# --- the version of the code ------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["22Jul2025", "22 Jul 2025", "22-Jul-2025_update2", "4Feb2025"])
def test_a_version_is_taken_as_that_of_a_log(version):
    """Tsuji's damping changed on 2 Sep 2026: before, the ε that is printed beside it is the only one."""
    text = WITHOUT_SIZES.replace("read_data grains.data", "create_atoms 1 single 0 0 0").replace(
        "hooke 1e5 0.9 damping coeff_restitution", "hertz 1e5 0.5 damping tsuji"
    )
    newest, old = hl.check(text, speed=0.1), hl.check(text, speed=0.1, version=version)
    (other,) = newest.rows[0].other_versions
    assert other.before == "2 Sep 2026" and not old.rows[0].other_versions
    assert old.rows[0].restitution == pytest.approx(other.restitution) != newest.rows[0].restitution
    assert any("before 2 Sep 2026" in remark for remark in newest.remarks)
    assert not any("before" in remark for remark in old.remarks)
    log = f"LAMMPS (22 Jul 2025)\n{text}Loop time of 1 on 1 procs\n"
    assert hl.check(log, speed=0.1).rows == old.rows
    assert hl.check(log, speed=0.1, version="3Sep2026").rows[0].restitution == newest.rows[0].restitution


@pytest.mark.parametrize(
    ("version", "code"), [("3.8.0", "lammps"), ("", "lammps"), ("22Jul2025", "liggghts")]
)
def test_a_version_is_one_of_the_code(version, code, tmp_path):
    with pytest.raises(ValueError, match=r"version: got .*, must be one such as"):
        hl.check(WITHOUT_SIZES, code=code, version=version)
    with pytest.raises(ValueError, match="version: got '22Jul2025', must be left out without a script"):
        hl.check(
            hl.Ball(1e-3, density=1.0),
            law=hl.LinearDashpot(stiffness=1.0, restitution=1.0),
            version="22Jul2025",
        )


def test_yade_before_2023_has_another_force():
    text = """
O.materials.append(FrictMat(young=1e7, poisson=0.2, density=2500, frictionAngle=0))
O.bodies.append([sphere((0, 0, 0), 1e-3), sphere((0, 0, 3e-3), 1e-3)])
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Sphere_Aabb()]), InteractionLoop([Ig2_Sphere_Sphere_ScGeom()],
    [Ip2_FrictMat_FrictMat_MindlinPhys(en=0.5, es=0.5)], [Law2_ScGeom_MindlinPhys_Mindlin()]),
    NewtonIntegrator(damping=0)]
O.dt = 1e-6
O.run(100)
"""
    newest, old = hl.check(text, speed=0.1).rows[0], hl.check(text, speed=0.1, version="2022.01a").rows[0]
    assert old.restitution == pytest.approx(newest.other_versions[0].restitution, abs=1e-6)
    assert old.duration > 1.02 * newest.duration and not old.other_versions
