"""β from what the reader and the models make of a script, against grains that collide in LAMMPS at 30 random angles."""

import csv
import zlib

import numpy as np
import pytest
from oblique_in_lammps import Setting, contact_of, measured, prepared

from conftest import DATA, slow
from hardlimit.boxes.lammps import program

try:
    PROGRAM = program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)
needs_lammps = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def pair(words: str) -> str:
    return f"pair_style granular\npair_coeff * * {words}"


def gran(words: str) -> str:
    return f"pair_style gran/{words}\npair_coeff * *"


MATERIAL = "hertz/material 1e8 {} 0.3 damping {} tangential {}"
#: Normal models with damping, and γ_t by x_t.
DAMPED = {
    "velocity": "hooke 1e5 0.4 damping velocity",
    "mass_velocity": "hooke 1e5 5e4 damping mass_velocity",
    "coeff_restitution": "hooke 1e5 0.7 damping coeff_restitution",
    "tsuji": "hooke 1e5 0.7 damping tsuji",
    "viscoelastic": "hooke 1e5 1e9",
    "hertz coeff_restitution": "hertz 1e8 0.7 damping coeff_restitution",
}
MINDLIN = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")

SETTINGS: dict[str, Setting] = {
    "gran/hooke": Setting(gran("hooke 1e5 NULL 5e4 NULL 0.5 1")),
    "gran/hooke dampflag 0": Setting(gran("hooke 1e5 NULL 5e4 4e4 0.5 0")),
    "gran/hooke/history": Setting(gran("hooke/history 1e5 NULL 5e4 NULL 0.5 1")),
    "gran/hooke/history limited": Setting(gran("hooke/history 1e5 9e4 5e4 4e4 0.5 1 limit_damping")),
    "gran/hooke/history dampflag 0": Setting(gran("hooke/history 1e5 9e4 5e4 4e4 0.3 0 limit_damping")),
    "gran/hooke/history elastic": Setting(gran("hooke/history 1e5 9e4 0 NULL 0.5 1")),
    "gran/hertz/history": Setting(gran("hertz/history 1e8 NULL 1e9 NULL 0.5 1")),
    "gran/hertz/history limited": Setting(gran("hertz/history 1e8 9e7 1e9 2e9 0.5 1 limit_damping")),
    "gran/hertz/history dampflag 0": Setting(gran("hertz/history 1e8 9e7 1e8 2e9 0.2 0")),
    "wall hooke": Setting("hooke 1e5 NULL 5e4 NULL 0.5 1", wall=True),
    **{
        f"{where}{name} {model.split()[0]}{limit}": Setting(
            words if wall else pair(words.removeprefix("granular ")), wall
        )
        for where, wall in (("pair ", False), ("wall ", True))
        for limit in ("", " limit_damping")
        for name, normal in DAMPED.items()
        for model in ("linear_nohistory 0.8 0.5", "linear_history 9e4 0.8 0.5")
        for words in (f"granular {normal} tangential {model}{limit}",)
    },
    **{
        f"{where}{model} {damping}": Setting(words if wall else pair(words.removeprefix("granular ")), wall)
        for where, wall in (("pair ", False), ("wall ", True))
        for model in MINDLIN
        for damping, number, ratio in (
            ("velocity", "0", "0.7"),  # undamped
            ("viscoelastic", "2e9", "0.6"),
            ("coeff_restitution", "0.8", "0.6" if "force" in model else "0"),
            ("tsuji", "0.8", "0"),
        )
        for words in (f"granular {MATERIAL.format(number, damping, f'{model} NULL {ratio} 0.4')}",)
    },
    "mindlin of a hooke force": Setting(
        pair("hooke 1e5 0.9 damping coeff_restitution tangential mindlin_rescale/force 9e8 0.3 0.5")
    ),
    "mindlin number": Setting(
        pair("hertz 1e8 0.9 damping coeff_restitution tangential mindlin/force 9e7 0 0.5")
    ),
    "mixed linear": Setting(
        "pair_style granular\n"
        "pair_coeff 1 1 hooke 1e5 0.9 damping coeff_restitution tangential linear_history 5e4 0.5 0.2\n"
        "pair_coeff 2 2 hooke 4e5 0.5 damping coeff_restitution tangential linear_history 8e4 0.9 0.6 limit_damping"
    ),
    "mixed mindlin": Setting(
        "pair_style granular\n"
        "pair_coeff 1 1 hertz/material 1e8 0.9 0.3 damping coeff_restitution tangential mindlin/force NULL 0.5 0.2\n"
        "pair_coeff 2 2 hertz/material 3e8 0.7 0.1 damping coeff_restitution tangential mindlin/force NULL 0.9 0.6"
    ),
    "mixed mindlin with a number": Setting(
        "pair_style granular\n"
        "pair_coeff 1 1 hertz/material 1e8 0 0.3 damping velocity tangential mindlin NULL 0 0.2\n"
        "pair_coeff 2 2 hertz/material 3e8 0 0.1 damping velocity tangential mindlin 1e8 0 0.6"
    ),
    "jkr of constant 0": Setting(
        pair("jkr 1e8 0 0.3 0 damping velocity tangential mindlin_rescale/force NULL 0 0.4")
    ),
    "spins as spheres": Setting(gran("hooke/history 1e5 9e4 5e4 4e4 0.5 1 limit_damping"), dimension=2),
    "spins as disks": Setting(
        gran("hooke/history 1e5 9e4 5e4 4e4 0.5 1 limit_damping"), dimension=2, move="nve/sphere disc"
    ),
    "variables": Setting(
        "variable kt equal 9e4\nvariable mu index 0.5\n"
        + pair("hooke 1e5 0.7 damping coeff_restitution tangential linear_history ${kt} $(v_mu/2) ${mu}")
    ),
    "hybrid": Setting(
        "pair_style hybrid gran/hooke/history 1e5 9e4 5e4 4e4 0.5 1 granular\npair_coeff * * gran/hooke/history\n"
        "pair_coeff 1 2 granular hooke 1e5 0.7 damping coeff_restitution tangential linear_history 3e4 0.5 0.3"
    ),
}
#: Walls and models with the error of 2023 to 2026. A spring that is lost at each slip is sensitive to the time of slip.
SCALED = {
    "wall hooke/history": Setting("hooke/history 1e5 9e4 5e4 2e4 0.5 1", wall=True, overlap=1e-3),
    "wall hooke/history elastic": Setting("hooke/history 1e5 9e4 1e-3 0 0.5 0", wall=True, overlap=1e-3),
    "wall hooke/history lj": Setting(
        *("hooke/history 2e5 NULL 50 NULL 0.5 0", True, "lj", (0.5, 0.5), 1.0, 1e-3)
    ),
    "wall hertz/history": Setting("hertz/history 1e8 9e7 1e7 0 0.5 0", wall=True, overlap=1e-3),
    "wall hertz/history lj": Setting(
        *("hertz/history 2e5 NULL 50 NULL 0.5 0", True, "lj", (0.5, 0.5), 1.0, 1e-3)
    ),
    "linear_history_classic": Setting(
        pair("hooke 1e5 0.4 damping velocity tangential linear_history_classic 5e4 0.3 0.5 limit_damping")
    ),
    "mindlin_classic": Setting(pair(MATERIAL.format("0", "velocity", "mindlin_classic 8e7 0 0.5"))),
}
#: Those whose spring is lost at each slip; of these, a few angles are left out.
LOST = ("wall hertz/history", "wall hertz/history lj", "mindlin_classic")
#: Angles of a setting in tests/data/friction_lammps.csv.
RECORDED_ANGLES = 6
FEW = ("gran/hooke/history", "mixed mindlin", "wall hooke/history lj", "spins as disks")


def tangents(name: str, count: int = 30) -> np.ndarray:
    """tan γ of random angles from 3° to 80°."""
    draw = np.random.default_rng(zlib.crc32(name.encode()))
    return np.tan(np.radians(np.sort(draw.uniform(3.0, 80.0, count))))


def types_of(setting: Setting) -> tuple[str, str]:
    return ("1", "wall") if setting.wall else ("1", "2")


def close(name: str, computed: np.ndarray, real: np.ndarray) -> bool:
    """Whether β agrees within 0.002 at all angles, or within 0.03 at three quarters of them if springs are lost."""
    wrong = np.abs(computed - real)
    return bool(np.quantile(wrong, 0.75) < 3e-2 if name in LOST else wrong.max() < 2e-3)


@needs_lammps
@pytest.mark.parametrize("name", [n if n in FEW else slow(n) for n in (*SETTINGS, *SCALED)])
def test_tangential_restitution_is_that_of_lammps(name, tmp_path):
    setting = (SETTINGS | SCALED)[name]
    angles = tangents(name)
    speed, *_ = prepared(setting, tmp_path, angles)
    real = measured(setting, tmp_path, speed, angles, PROGRAM)
    contact = contact_of(tmp_path / "log.lammps", setting, types_of(setting))
    computed = contact.restitution(contact.tangential, speed, angles)
    assert close(name, computed, real)
    if name in SETTINGS:
        script = contact_of(tmp_path / "in.script", setting, types_of(setting))
        assert script.tangential == contact.tangential


def recorded() -> dict[tuple[str, str], list[tuple[float, float]]]:
    """tan γ and β by version and setting."""
    rows: dict[tuple[str, str], list[tuple[float, float]]] = {}
    with (DATA / "friction_lammps.csv").open(encoding="utf-8") as file:
        for version, setting, tangent, beta in list(csv.reader(file))[1:]:
            rows.setdefault((version, setting), []).append((float(tangent), float(beta)))
    return rows


RECORDED = recorded()


VERSIONS = sorted({version for version, _ in RECORDED})
#: Settings that versions know differently, and others.
CHANGED = (
    "wall hooke",
    "wall hooke/history lj",
    "wall mindlin/force tsuji",
    "pair mindlin_rescale/force tsuji",
)


@pytest.mark.parametrize("version,every", [(v, False) for v in VERSIONS] + [slow(v, True) for v in VERSIONS])
def test_tangential_restitution_is_that_of_recorded_versions(version, every, tmp_path):
    """Against runs of several versions, written by ``tools/verify_lammps_friction.py``."""
    wrong = []
    for (of, name), rows in RECORDED.items():
        if not every and name not in CHANGED:
            continue
        # A log repeats a command with the values of variables; older versions do not mix as the newest one does.
        if of != version or name == "variables" or ("mixed" in name and "2022" in version):
            continue
        setting, (angles, real) = (SETTINGS | SCALED)[name], np.array(rows).T
        speed, *_ = prepared(setting, tmp_path, angles)
        log = tmp_path / "log.lammps"
        log.write_text(f"LAMMPS ({version})\n{(tmp_path / 'in.script').read_text()}")
        contact = contact_of(log, setting, types_of(setting))
        computed = contact.restitution(contact.tangential, speed, angles)
        if not close(name, computed, real):
            wrong.append((name, np.abs(computed - real).max()))
    assert not wrong
