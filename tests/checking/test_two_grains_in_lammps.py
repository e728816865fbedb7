"""ε as ``check`` prints it, against ε of two grains that collide in LAMMPS, for each contact model and for walls."""

import csv
import math
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import hardlimit as hl
from conftest import DATA, slow
from hardlimit.boxes.lammps import program

try:
    PROGRAM = program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)
needs_lammps = pytest.mark.skipif(bool(MISSING), reason=MISSING)

GRANULAR = "pair_style granular\npair_coeff * * {} tangential linear_nohistory 0.0 0.0"
MATERIAL = "hertz/material 1e7 {} 0.3"
TANGENTIAL = "tangential linear_nohistory 0.0 0.0"


def mixed(first: str, second: str, damping: str) -> str:
    """Two types without a pair_coeff of their own."""
    lines = [
        f"pair_coeff {k} {k} {model} damping {damping} {TANGENTIAL}" for k, model in ((1, first), (2, second))
    ]
    return "\n".join(["pair_style granular", *lines])


#: Name → (lines of the contact, speed, radii, units). The walls are below.
PAIRS = {
    "hooke coeff_restitution": (GRANULAR.format("hooke 1e5 0.5 damping coeff_restitution"), 0.4),
    "hooke coeff_restitution limited": (
        GRANULAR.format("hooke 1e5 0.5 damping coeff_restitution limit_damping"),
        0.4,
    ),
    "hooke synchronized_verlet": (
        "pair_style granular\npair_coeff * * hooke 1e5 0.5 tangential linear_history 8e3 0 0.5 "
        "damping coeff_restitution synchronized_verlet",
        0.4,
    ),
    "hooke velocity": (GRANULAR.format("hooke 1e5 0.4 damping velocity"), 0.4),
    "hooke velocity limited": (GRANULAR.format("hooke 1e5 0.6 damping velocity limit_damping"), 0.4),
    "hooke mass_velocity": (GRANULAR.format("hooke 1e5 5e4 damping mass_velocity"), 1.0),
    "hooke viscoelastic": (GRANULAR.format("hooke 1e5 1e9"), 1.0),
    "hooke tsuji": (GRANULAR.format("hooke 1e5 0.6 damping tsuji"), 1.0),
    "hertz viscoelastic": (GRANULAR.format("hertz 1e7 2e8 damping viscoelastic limit_damping"), 0.5),
    "hertz velocity": (GRANULAR.format("hertz 1e7 0.1 damping velocity"), 2.0),
    "hertz mass_velocity limited": (
        GRANULAR.format("hertz 1e7 4e3 damping mass_velocity limit_damping"),
        0.1,
    ),
    "hertz coeff_restitution limited": (
        GRANULAR.format("hertz 1e7 0.3 damping coeff_restitution limit_damping"),
        0.5,
    ),
    "hertz tsuji": (GRANULAR.format("hertz 1e7 0.7 damping tsuji"), 0.5),
    "material viscoelastic": (GRANULAR.format(MATERIAL.format("1e8")), 0.5),
    "material coeff_restitution": (
        GRANULAR.format(f"{MATERIAL.format('0.8')} damping coeff_restitution"),
        0.5,
    ),
    "material tsuji limited": (GRANULAR.format(f"{MATERIAL.format('0.8')} damping tsuji limit_damping"), 0.5),
    "material velocity": (GRANULAR.format(f"{MATERIAL.format('0.03')} damping velocity"), 0.5),
    "material mass_velocity limited": (
        GRANULAR.format(f"{MATERIAL.format('4e3')} damping mass_velocity limit_damping"),
        0.5,
    ),
    "hooke mixed": (
        "pair_style granular\n"
        "pair_coeff 1 1 hooke 1e5 0.9 damping coeff_restitution tangential linear_nohistory 0.0 0.0\n"
        "pair_coeff 2 2 hooke 4e5 0.4 damping coeff_restitution tangential linear_nohistory 0.0 0.0",
        0.5,
    ),
    "hooke mixed, velocity": (mixed("hooke 1e5 0.2", "hooke 2e5 0.4", "velocity"), 0.5),
    "hertz mixed, viscoelastic": (mixed("hertz 1e7 2e7", "hertz 4e7 8e7", "viscoelastic"), 0.5),
    "material mixed, velocity": (
        mixed("hertz/material 1e7 0.01 0.3", "hertz/material 4e7 0.04 0.4", "velocity"),
        0.5,
    ),
    "jkr of constant 0": (GRANULAR.format("jkr 1e7 0.02 0.3 0 damping velocity"), 0.5),
    "dmt of constant 0": (GRANULAR.format("dmt 1e7 1e8 0.3 0.0"), 0.5),
    "jkr mixed, a constant of 0": (mixed("jkr 1e7 0.01 0.3 0", "jkr 4e7 0.04 0.4 3", "velocity"), 0.5),
    "hooke of one pair": (
        GRANULAR.format("hooke 1e5 0.9 damping coeff_restitution")
        + "\npair_coeff 1 2 hooke 4e5 0.4 damping coeff_restitution tangential linear_nohistory 0.0 0.0 limit_damping",
        0.5,
    ),
    "hertz undamped": (GRANULAR.format("hertz 1e7 0.0 damping velocity"), 0.5),
    "gran/hooke": ("pair_style gran/hooke 1e5 NULL 3e4 NULL 0.5 0\npair_coeff * *", 0.5),
    "gran/hooke/history limited": (
        "pair_style gran/hooke/history 1e5 NULL 3e4 NULL 0.5 1 limit_damping\npair_coeff * *",
        0.5,
    ),
    "gran/hertz/history": ("pair_style gran/hertz/history 1e7 NULL 1e8 NULL 0.5 1\npair_coeff * *", 0.5),
}
FEW = ("hooke mixed", "wall hertz/history", "freeze")
COEFFICIENT = GRANULAR.format("hooke 1e5 0.5 damping coeff_restitution")
UPPER = "group moving type 2\nfix move moving nve/sphere"
#: The lower grain does not move. Only ``fix freeze`` makes LAMMPS take it as infinitely heavy in its formulas.
STANDING = {
    "freeze": (COEFFICIENT, "group lower type 1\nfix hold lower freeze\nfix move all nve/sphere"),
    "not integrated": (COEFFICIENT, UPPER),
    "setforce": (COEFFICIENT, "group lower type 1\nfix move all nve/sphere\nfix hold lower setforce 0 0 0"),
    "fix move": (COEFFICIENT, f"group lower type 1\n{UPPER}\nfix hold lower move linear 0 0 0"),
    "gran/hertz/history, not integrated": (
        "pair_style gran/hertz/history 1e7 NULL 1e8 NULL 0.5 1\npair_coeff * *",
        UPPER,
    ),
}
WALLS = {
    "wall granular hooke": (
        "granular hooke 1e5 0.5 damping coeff_restitution tangential linear_nohistory 0.0 0.0 limit_damping",
        0.4,
    ),
    "wall granular material": (
        f"granular {MATERIAL.format('0.7')} damping tsuji tangential linear_nohistory 0.0 0.0 limit_damping",
        0.4,
    ),
    "wall material tsuji": (f"granular {MATERIAL.format('0.7')} damping tsuji {TANGENTIAL}", 0.4),
    "wall material velocity": (f"granular {MATERIAL.format('0.02')} damping velocity {TANGENTIAL}", 0.4),
    "wall material mass_velocity": (
        f"granular {MATERIAL.format('4e3')} damping mass_velocity {TANGENTIAL}",
        0.4,
    ),
    "wall material viscoelastic": (f"granular {MATERIAL.format('1e8')} {TANGENTIAL}", 0.4),
    "wall jkr of constant 0": (f"granular jkr 1e7 0.02 0.3 0 damping velocity {TANGENTIAL}", 0.4),
    "wall hertz/history": ("hertz/history 1e7 NULL 1e8 NULL 0.5 1", 0.5),
    "wall hooke limited": ("hooke 1e5 NULL 3e4 NULL 0.5 0 limit_damping", 0.5),
}


def script(
    lines: str,
    speed: float,
    step: float,
    steps: int,
    wall: str = "",
    radii=(1e-3, 1.5e-3),
    fixes: str = "fix move all nve/sphere",
) -> str:
    """Two grains on a line, or one above a wall, that touch after a few steps."""
    r1, r2 = radii
    gap = 3.5 * speed * step
    grains = [
        f"create_atoms 1 single 0 0 {0 if not wall else r1 + gap:.15g}",
        f"set type 1 diameter {2 * r1:.15g} density 2500",
    ]
    velocity = [f"velocity all set 0 0 {-speed:.15g}"] if wall else []
    if not wall:
        grains += [
            f"create_atoms 2 single 0 0 {r1 + r2 + gap:.15g}",
            f"set type 2 diameter {2 * r2:.15g} density 2500",
        ]
        velocity = ["group upper id 2", "velocity all set 0 0 0", f"velocity upper set 0 0 {-speed:.15g}"]
    floor = [f"fix floor all wall/gran {wall} zplane 0.0 NULL"] if wall else []
    last = "$(vz[1])" if wall else "$(vz[2]-vz[1])"
    return "\n".join(
        [
            "units si\natom_style sphere\natom_modify map array\nboundary f f f\nnewton off\ncomm_modify vel yes",
            "region box block -0.01 0.01 -0.01 0.01 -0.01 0.02\ncreate_box 2 box",
            *grains,
            lines,
            *floor,
            *velocity,
            f"timestep {step:.15g}\n{fixes}\nrun {steps}",
            f'print "SEPARATION {last}"\n',
        ]
    )


def measured(text: str, folder) -> float:
    """The separation velocity in LAMMPS; writes in.script and log.lammps."""
    (folder / "in.script").write_text(text, encoding="utf-8")
    command = PROGRAM.command(1, "-in", "in.script", "-log", "log.lammps", "-screen", "none")
    subprocess.run(command, cwd=folder, env=PROGRAM.environment(), check=True, capture_output=True)
    log = (folder / "log.lammps").read_text(encoding="utf-8")
    return float(re.search(r"^SEPARATION (\S+)", log, re.M)[1])


def row(name: str, source, speed: float):
    """The contact of a setting as ``check`` prints it."""
    kind = ("1", "wall") if name in WALLS else ("1", "2")
    return next(row for row in hl.check(source, speed=speed).rows if row.types == kind)


def settled(name: str, steps: int) -> tuple[str, float, float]:
    """The script of a setting, its speed, and its step of about a 4000th of the contact."""
    wall, fixes = name in WALLS, "fix move all nve/sphere"
    if name in STANDING:
        (lines, fixes), speed = STANDING[name], 0.5
    else:
        lines, speed = (WALLS if wall else PAIRS)[name]
    of_wall = lines if wall else ""
    lines = GRANULAR.format("hooke 1e5 0.5 damping velocity") if wall else lines
    duration = row(name, script(lines, speed, 1e-8, 1, of_wall, fixes=fixes), speed).duration
    step = float(f"{duration / 4000:.6g}")
    return script(lines, speed, step, steps, of_wall, fixes=fixes), speed, step


def compared(name: str, folder) -> tuple[float, float, float]:
    """ε of the log, of the script and measured."""
    text, speed, _ = settled(name, 4600)
    separation = measured(text, folder)
    of_log, of_script = (row(name, folder / file, speed) for file in ("log.lammps", "in.script"))
    return of_log.restitution, of_script.restitution, separation / speed


@needs_lammps
@pytest.mark.parametrize("name", [n if n in FEW else slow(n) for n in (*PAIRS, *WALLS, *STANDING)])
def test_restitution_is_that_of_two_grains_in_lammps(name, tmp_path):
    """The version in the log decides between formulas; a script is checked as for the newest version."""
    of_log, of_script, real = compared(name, tmp_path)
    assert of_log == pytest.approx(real, abs=2e-3)
    if "tsuji" not in (WALLS.get(name) or STANDING.get(name) or PAIRS[name])[0]:
        assert of_script == of_log


with (DATA / "lammps_versions.csv").open(encoding="utf-8") as file:
    RECORDED = [tuple(record.values()) for record in csv.DictReader(file)]
#: One row for each formula that differs between versions.
CHANGED = ("wall material velocity", "hertz tsuji", "material mixed, velocity", "wall jkr of constant 0")


@pytest.mark.parametrize(
    "version,name,restitution,duration",
    [
        record if record[1] in CHANGED and not record[0].startswith("29 Aug") else slow(*record)
        for record in RECORDED
    ],
)
def test_the_version_in_a_log_decides_between_formulas(version, name, restitution, duration):
    """Against runs of several versions, written by ``tools/verify_versions.py``."""
    text, speed, _ = settled(name, 4600)
    contact = row(name, f"LAMMPS ({version})\n{text}", speed)
    if (
        "2022" in version and name == "material mixed, velocity"
    ):  # memory that was not set, so that k is in N/m
        assert contact.restitution is None
        return
    assert contact.restitution == pytest.approx(float(restitution), abs=2e-3)
    assert contact.duration == pytest.approx(float(duration), rel=3e-3)
    assert not contact.other_versions


@pytest.mark.parametrize(
    "name", ["wall material velocity", "wall material tsuji", "hertz tsuji", "hooke velocity"]
)
def test_both_numbers_are_given_where_the_version_is_not_known(name):
    """They are those of logs of these versions."""
    text, speed, _ = settled(name, 4600)
    newest = row(name, text, speed)
    versions = {"2 Sep 2026": "22 Jul 2025", "28 Mar 2023": "23 Jun 2022"}
    for version in newest.other_versions:
        logged = row(name, f"LAMMPS ({versions[version.before]})\n{text}", speed)
        assert (version.restitution, version.duration) == (logged.restitution, logged.duration)
        assert version.restitution != newest.restitution
    befores = [version.before for version in newest.other_versions]
    assert befores == [
        limit for limit, part in (("2 Sep 2026", "tsuji"), ("28 Mar 2023", "wall material")) if part in name
    ]
    remarks = " ".join(hl.check(text, speed=speed).remarks)
    assert all(f"LAMMPS before {limit}: " in remarks for limit in befores)


@needs_lammps
@pytest.mark.slow
def test_friction_makes_the_example_cool_faster(tmp_path):
    """What README says of its example: √(T(0)/T) of translation grows 1.6 to 2 times faster with μ = 0.3.

    Event-driven with the same friction follows within some per cent.
    """
    text = (Path(__file__).parents[2] / "examples" / "in.granular_gas").read_text("utf-8")
    text = re.sub(r"fix +walls[^\n]*&\n[^\n]*\n", "", text).replace("boundary        p p f", "boundary p p p")
    text = text.replace("run             100000", "thermo 200\nthermo_style custom step time ke\nrun 7000")
    rates = []
    for mu in ("0.3", "0"):
        (tmp_path / "in.gas").write_text(text.replace("0.5 0.3 limit", f"0.5 {mu} limit"), encoding="utf-8")
        command = PROGRAM.command(1, "-in", "in.gas", "-log", "log.gas", "-screen", "none")
        subprocess.run(command, cwd=tmp_path, env=PROGRAM.environment(), check=True, capture_output=True)
        lines = (tmp_path / "log.gas").read_text("utf-8").splitlines()
        rows = [line.split() for line in lines if re.fullmatch(r"\s*\d+\s+\S+\s+\S+\s*", line)]
        time, energy = np.array([[float(word) for word in row[1:]] for row in rows]).T
        grown = np.sqrt(energy[0] / energy) - 1.0
        rates.append([size / float(np.interp(size, grown, time)) for size in (0.5, 1.0, 1.9)])
    gas = hl.ParticleSystem.random(
        2000,
        packing_fraction=0.2014,
        radius=1e-3,
        density=2500.0,
        rms_speed=math.sqrt(3.0 * 1.380649e-6 / 1.0472e-5),
    )
    law = hl.LinearDashpot(
        stiffness=1e4, damping=0.0516263, friction=hl.Friction(0.3, stiffness_ratio=0.2857, damping_ratio=0.5)
    )
    series = hl.event_driven(gas, law=law, until=0.03, samples=300).series
    temperature = series["granular_temperature"].values
    grown = np.sqrt(temperature[0] / temperature) - 1.0
    hard = [size / float(np.interp(size, grown, series.time)) for size in (0.5, 1.0, 1.9)]
    assert hard == pytest.approx(np.multiply(rates[0], 1.07), rel=0.12)
    ratio = np.divide(*rates)
    assert (ratio > 1.6).all() and (ratio < 2.0).all() and (np.diff(ratio) < 0.0).all()
