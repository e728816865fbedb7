"""Settle beds in LAMMPS, and compare their overlap and longest stable step with those of ``hardlimit check``.

``python tools/verify_beds.py``: one line a bed, with the overlap of the lowest two layers, and the energies of motion
and of rotation after runs at 0.9 and 1.1 times the step that check calls the longest stable one. Some minutes a bed.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import hardlimit as hl
from hardlimit.boxes.lammps import program

COUNT, DIAMETER, DENSITY, WIDTH, HEIGHT = 900, 2e-3, 2500.0, 0.016, 0.14
MASS = np.pi / 6.0 * DENSITY * DIAMETER**3
STIFFNESS = 6e3
#: Model, ε, k_t/k_n and μ of each bed.
BEDS = {
    "hooke 2/7": ("hooke", 0.5, 2.0 / 7.0, 0.5),
    "hooke 1": ("hooke", 0.9, 1.0, 0.5),
    "hooke smooth": ("hooke", 0.7, 0.0, 0.0),
    "hertz": ("hertz", 0.5, 0.0, 0.5),
}
SHORT = 4e-6  #: time step while they settle [s]


def contact(model: str, restitution: float, ratio: float, friction: float) -> str:
    """The words of ``pair_coeff``."""
    if model == "hertz":
        tangential = f"mindlin_rescale NULL 1.0 {friction}"
        return f"hertz/material 2e7 {restitution} 0.25 damping coeff_restitution limit_damping tangential {tangential}"
    log = np.log(restitution)
    damping = -2.0 * log / np.hypot(np.pi, log) * np.sqrt(2.0 * STIFFNESS / MASS)
    springs = f"linear_history {ratio * STIFFNESS} 1.0 {friction}" if friction else "linear_nohistory 0 0"
    return f"hooke {STIFFNESS} {damping} damping mass_velocity limit_damping tangential {springs}"


def script(words: str, start: str, step: float, end: str) -> str:
    """The input: a box with a floor, grains by ``start``, and runs by ``end``."""
    return f"""units si
atom_style sphere
boundary p p f
newton off
comm_modify vel yes
region box block 0 {WIDTH} 0 {WIDTH} 0 {HEIGHT}
create_box 1 box
{start}
set group all diameter {DIAMETER} density {DENSITY}
pair_style granular
pair_coeff * * {words}
neighbor 4e-4 bin
fix pull all gravity 9.81 vector 0 0 -1
fix move all nve/sphere
fix floor all wall/gran granular {words} zplane 0 NULL
compute spin all erotate/sphere
thermo_style custom step ke c_spin
timestep {step}
{end}
"""


def run(text: str, folder: Path) -> str:
    """What LAMMPS prints for an input."""
    (folder / "in.bed").write_text(text)
    lmp = program.find(1)
    command, environment = lmp.command(1, "-in", "in.bed", "-log", "none"), lmp.environment()
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=True
    ).stdout


def positions(folder: Path) -> np.ndarray:
    """Those of the last frame of the dump."""
    lines = (folder / "dump.bed").read_text().rpartition("ITEM: ATOMS x y z\n")[2].split("\n")
    return np.array([line.split() for line in lines if line], float)


def overlap(at: np.ndarray, power: float) -> float:
    """Mean overlap over the radius of the lowest two layers, scaled to the pressure at the bottom."""
    inside = np.column_stack([np.mod(at[:, :2], WIDTH), at[:, 2]])
    i, j = cKDTree(inside, boxsize=[WIDTH, WIDTH, 0.0]).query_pairs(DIAMETER, output_type="ndarray").T
    apart = inside[i] - inside[j]
    apart[:, :2] -= WIDTH * np.round(apart[:, :2] / WIDTH)
    low, high = 0.7 * DIAMETER, 2.5 * DIAMETER
    height = 0.5 * (inside[i, 2] + inside[j, 2])
    depth = DIAMETER - np.linalg.norm(apart, axis=1)[(height > low) & (height < high)]
    above = (inside[:, 2] > 0.5 * (low + high)).sum()
    return float(depth.mean() / (0.5 * DIAMETER) * (len(at) / above) ** power)


def compared(name: str) -> str:
    """One line: overlap in LAMMPS and by check, and the energies at both steps."""
    words = contact(*BEDS[name])
    start = (
        f"region fill block 0 {WIDTH} 0 {WIDTH} {DIAMETER} 0.13\n"
        f"create_atoms 1 random {COUNT} 1 fill overlap {1.001 * DIAMETER} maxtry 1000"
    )
    dump = "write_dump all custom dump.bed x y z modify format float %.15g"
    settle = f"fix drag all viscous 2e-5\nrun {0.55 / SHORT:.0f}\nunfix drag\nrun {0.1 / SHORT:.0f}\n{dump}"
    with tempfile.TemporaryDirectory() as name_of_folder:
        folder = Path(name_of_folder)
        run(script(words, start, SHORT, settle), folder)
        at = positions(folder)
        state = hl.check(script(words, start, SHORT, settle)).state
        assert state.overlap and state.largest_stable_step
        grains = "\n".join(
            f"create_atoms 1 single {x % WIDTH!r} {y % WIDTH!r} {z!r} units box" for x, y, z in at.tolist()
        )
        energies = []
        for share in (0.9, 1.1):
            step = share * state.largest_stable_step
            end = f"run {0.06 / SHORT:.0f}\ntimestep {step}\nrun 20000"
            rows = [line.split() for line in run(script(words, grains, SHORT, end), folder).splitlines()]
            last = [row for row in rows if len(row) == 3 and row[0].isdigit()][-1]
            energies.append(f"{share}: {float(last[1]):.1e} and {float(last[2]):.1e} J")
    measured = overlap(at, 2.0 / 3.0 if words.startswith("hertz") else 1.0)
    return (
        f"{name}: overlap {measured:.3%} (check {state.overlap:.3%}), longest step {state.largest_stable_step:.3g} s, "
        f"energies at {', '.join(energies)}"
    )


if __name__ == "__main__":
    for bed in sys.argv[1:] or BEDS:
        print(compared(bed), flush=True)
