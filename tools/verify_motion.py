"""Run scripts of tests/checking/data/states in LAMMPS, LIGGGHTS and YADE, and write how walls and grains really move.

    python tools/verify_motion.py tests/data/script_motions.csv [--only NAME]

Shaken plates: amplitude and angular frequency of a sine through the places of the wall; Γ and S follow. Flows: the
shear rate, by a line through the velocities over the depth, and the pressure in the middle, from the weight above; the
inertial number follows. Requires LAMMPS, ``liggghts`` and ``yade``; rows of a missing code stay.
"""

import itertools
import math
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import recorded
import scipy
from verify_states import CODES, SCRIPTS, Lammps, Script, largest_stable

#: Facets of a cylinder.
FACETS: Final = 48
#: Lines that make YADE print where the plate is.
WATCH: Final = """
for _ in range(400):
    print("PLACE", O.time, O.bodies[plate].state.pos[2], flush=True)
    O.run(250, True)
"""


class Motion(NamedTuple):
    """What is measured of a script, and how."""

    name: str
    measure: Callable[[Lammps], dict[str, float]]


# --- walls that oscillate ------------------------------------------------------------------------------------------


def shaken(times: np.ndarray, places: np.ndarray, gravity: float, diameter: float) -> dict[str, float]:
    """Γ and S of the sine through these places."""

    def fitted(omega: float) -> tuple[np.ndarray, float]:
        design = np.column_stack([np.ones_like(times), np.cos(omega * times), np.sin(omega * times)])
        parts, *_ = np.linalg.lstsq(design, places)
        return parts, float(np.sum((design @ parts - places) ** 2))

    grid = 2.0 * math.pi / float(np.ptp(times)) * np.linspace(0.5, 12.0, 2000)
    start = min(grid, key=lambda omega: fitted(omega)[1])
    width = grid[1] - grid[0]
    omega = float(
        scipy.optimize.minimize_scalar(
            lambda w: fitted(w)[1], bounds=(start - width, start + width), method="bounded"
        ).x
    )
    parts, residual = fitted(omega)
    amplitude = float(np.hypot(*parts[1:]))
    print("residual over amplitude", math.sqrt(residual / len(times)) / amplitude, flush=True)
    return {
        "gamma": amplitude * omega**2 / gravity,
        "strength": (amplitude * omega) ** 2 / (gravity * diameter),
    }


def plate_in_lammps(code: Lammps) -> dict[str, float]:
    """From the place where the wall touches a large grain that does not move, in place of the others."""
    probe = "create_atoms 1 single 0.005 0.005 0.0024 units box\nset type 1 diameter 5e-3 density 2500"
    text = code.text.replace("create_atoms 1 region seed", "").replace(
        "set type 1 diameter 1e-3 density 2500", probe
    )
    text = text.replace("wiggle z $A $T", "wiggle z $A $T contacts")
    dump = "dump touch all custom 500 touch.dump f_plate[1] f_plate[7]\ndump_modify touch format float %.12g"
    code.run(text.replace("run 1000000", f"fix stop all freeze\n{dump}\nrun 200000"))
    rows = [(step, *table[0]) for step, table in frames(code.folder / "touch.dump")]
    times, touches, places = np.array([row for row in rows if row[1] > 0.0]).T
    print("samples", len(times), "of", len(rows), touches.min(), flush=True)
    return shaken(5e-7 * times, places, 9.81, 1e-3)


def plate_in_liggghts(code: Lammps) -> dict[str, float]:
    """From the corners of the mesh, in cgs units."""
    (code.folder / "plate.stl").write_text(recorded.floor(2.0, 1.0))
    code.run(code.text.replace("run 100000", "dump mesh all mesh/stl 500 plate_*.txt\nrun 60000"))
    steps, places = [], []
    for path in code.folder.glob("plate_*.txt"):
        heights = re.findall(r"vertex \S+ \S+ (\S+)", path.read_text())
        steps.append(int(path.stem.rpartition("_")[2]))
        places.append(np.mean([float(height) for height in heights]))
    return shaken(2e-6 * np.array(steps), np.array(places), 981.0, 0.2)


def plate_in_yade(code: Lammps) -> dict[str, float]:
    """From the place of the body."""
    rows = re.findall(r"PLACE (\S+) (\S+)", code.run(code.text.replace("O.run(100000, True)", WATCH)))
    times, places = np.array(rows, float).T
    return shaken(times, places, 9.81, 2e-3)


# --- flows -----------------------------------------------------------------------------------------------------


def frames(path: Path) -> list[tuple[int, np.ndarray]]:
    """Step and rows of each frame of a dump."""
    blocks = path.read_text().split("ITEM: TIMESTEP\n")[1:]
    tables = [
        (int(block.split("\n")[0]), block.partition("ITEM: ATOMS")[2].split("\n")[1:]) for block in blocks
    ]
    return [(step, np.array([line.split() for line in rows if line], float)) for step, rows in tables]


def profile(depth: np.ndarray, speed: np.ndarray, ends: tuple[float, float]) -> float:
    """Slope of the speed over the depth between two depths."""
    among = (depth > ends[0]) & (depth < ends[1])
    return abs(float(np.polyfit(depth[among], speed[among], 1)[0]))


def chute_in_lammps(code: Lammps) -> dict[str, float]:
    """Mean of the last frames; the middle of the layer, in ``lj`` units: g = 1, d = 1, the density is 1."""
    rough = "rough" in code.script.name
    end, steps, area = ("run 240000", 240000, 48.0) if rough else ("run 100000", 400000, 50.0)
    code.run(code.text.replace(end, f"dump last flow custom 2000 last.dump x y z vx mass\nrun {steps}"))
    last = frames(code.folder / "last.dump")[-50:]
    rows = np.concatenate([rows for _, rows in last])
    top, bottom = float(np.quantile(rows[:, 2], 0.98)), float(rows[:, 2].min())
    middle, reach = 0.5 * (top + bottom), 0.25 * (top - bottom)
    rate = profile(rows[:, 2], rows[:, 3], (middle - reach, middle + reach))
    above = rows[rows[:, 2] > middle, 4].sum() / len(last)
    pressure = above * math.cos(math.radians(24.0)) / area
    return {"shear_rate": rate, "pressure": pressure, "inertial_number": rate / math.sqrt(pressure)}


def drum_in_lammps(code: Lammps) -> dict[str, float]:
    """Of beads of 2 mm in a slice of 1 cm."""
    dump = "dump last all custom 2000 last.dump x y vx vy mass\nrun 400000"
    code.run(code.text.replace("run 400000", dump))
    return flowing_layer([rows for _, rows in frames(code.folder / "last.dump")[-120:]], 0.01)


def drum_in_liggghts(code: Lammps) -> dict[str, float]:
    """The same in a slice of 8 mm; the last quarter of a turn."""
    around = [0.02 * np.exp(2j * math.pi * k / FACETS) for k in range(FACETS + 1)]
    corners = [[f"{w.real:.8g} {y} {w.imag:.8g}" for y in (0, 0.008)] for w in around]
    facets = []
    for (a, b), (c, d) in itertools.pairwise(corners):
        for three in ((a, b, c), (b, d, c)):
            vertices = "\n".join(f"vertex {corner}" for corner in three)
            facets.append(f"facet normal 0 0 1\nouter loop\n{vertices}\nendloop\nendfacet\n")
    (code.folder / "cylinder.stl").write_text(f"solid drum\n{''.join(facets)}endsolid drum\n")
    dump = "dump last all custom 1000 last.dump x z vx vz mass\nrun 200000"
    code.run(code.text.replace("run 200000", dump))
    return flowing_layer([rows for _, rows in frames(code.folder / "last.dump")[-100:]], 0.008)


def flowing_layer(last: list[np.ndarray], thickness: float) -> dict[str, float]:
    """Below the free surface in the middle of a drum: the surface is a line through the highest grains.

    ``last``: places in the plane, velocities and masses in each frame. Of beads of 2 mm, in SI units.
    """
    rows = np.concatenate(last)
    slope = surface(rows)
    along, down = np.array([1.0, slope]), np.array([slope, -1.0])
    along, down = along / np.hypot(*along), down / np.hypot(*down)
    at, depth = rows[:, :2] @ along, rows[:, :2] @ down
    middle = float(np.median(at))
    near = np.abs(at - middle) < 4e-3
    depth = depth - np.quantile(depth[near], 0.01)
    rate = profile(depth[near], rows[near, 2:4] @ along, (0.0, 4e-3))
    above = rows[near & (depth < 2e-3), 4].sum() / len(last) / (8e-3 * thickness)
    pressure = above * 9.81 * abs(down[1])
    print("slope", math.degrees(math.atan(slope)), flush=True)
    return {
        "shear_rate": rate,
        "pressure": pressure,
        "inertial_number": rate * 2e-3 * math.sqrt(2500.0 / pressure),
    }


def box_in_lammps(code: Lammps) -> dict[str, float]:
    """Means from a strain of 2 to one of 6, without the mean flow; overlaps are those of all contacts."""
    shutil.copy(SCRIPTS / "dense.data", code.folder)
    lines = [
        "compute flow all temp/deform",
        "compute p all pressure flow",
        "compute apart all pair/local dist",
        "compute near all reduce ave c_apart inputs local",
        "fix mean all ave/time 100 500 50000 c_p c_p[4] c_near file means.txt",
    ]
    code.run(code.text.replace("run 150000", "run 50000\n" + "\n".join([*lines, "run 100000"])))
    pressure, stress, apart = np.loadtxt(code.folder / "means.txt")[-2:, 1:].mean(0)
    return {
        "shear_rate": 10.0,
        "pressure": pressure,
        "inertial_number": 10.0 * 1e-3 * math.sqrt(2500.0 / pressure),
        "stress_ratio": -stress / pressure,
        "overlap": (1e-3 - apart) / 5e-4,
    }


#: Lines that make YADE print pressure, shear stress, overlap over the smaller radius and temperature at equal strains.
CELL: Final = """
import numpy as np

def numbers():
    grains = [b for b in O.bodies if isinstance(b.shape, Sphere)]
    at, v = (np.array([list(x) for x in part]) for part in zip(*[(b.state.pos, b.state.vel) for b in grains]))
    mass = np.array([b.state.mass for b in grains])
    own = v - at @ np.array(O.cell.velGrad).reshape(3, 3).T
    stress = np.array(getStress()).reshape(3, 3) - own.T @ (mass[:, None] * own) / O.cell.volume
    depths = [i.geom.penetrationDepth / min(i.geom.refR1, i.geom.refR2) for i in O.interactions if i.isReal]
    heat = mass @ (own**2).sum(1) / (3 * len(grains))
    return -np.trace(stress) / 3, stress[0, 1], np.mean([x for x in depths if x > 0] or [0]), heat

def shear(samples, steps):
    for _ in range(samples):
        for _ in range(10):
            O.run(steps, True)
            print("NUMBERS", *numbers(), flush=True)
        O.cell.flipCell()
"""


def cell_in_yade(code: Lammps) -> dict[str, float]:
    """Means from a strain of 1 to one of 5, and the step from which on grains get hotter, from the last state on."""
    shutil.copy(SCRIPTS / "dense.txt", code.folder)
    start, _, run = code.text.partition("for _ in range(50):")
    assert run, "the run of the script has changed"

    def table(text: str) -> np.ndarray:
        return np.array(re.findall(r"NUMBERS (\S+) (\S+) (\S+) (\S+)", text), float)

    said = table(code.run(f'{start}{CELL}shear(50, 125)\nO.save("sheared.yade.gz")'))[100:]
    for part in np.split(said, 4):
        print("pressure, stress ratio", part[:, 0].mean(), part[:, 1].sum() / part[:, 0].sum(), flush=True)
    pressure, stress, overlap, heat = said.mean(0)

    def cool(step: float) -> bool:
        """Whether grains have less than twice the mean temperature from a strain of 0.2 to one of 1."""
        again = f'{CELL}O.load("sheared.yade.gz")\nO.dt = {step!r}\nshear(10, {round(0.001 / step)})'
        last = table(code.run(again))[20:, 3]
        print("step, temperature over the mean", step, last.mean() / heat, flush=True)
        return len(last) == 80 and bool(np.isfinite(last).all()) and float(last.mean()) < 2.0 * heat

    return {
        "shear_rate": 10.0,
        "pressure": pressure,
        "inertial_number": 10.0 * 1e-3 * math.sqrt(2500.0 / pressure),
        "stress_ratio": stress / pressure,
        "overlap": overlap,
        "largest_stable_step": largest_stable(cool, 8e-6),
    }


def surface(rows: np.ndarray) -> float:
    """Slope of the line through the highest grains of columns in the middle of a heap."""
    edges = np.quantile(rows[:, 0], np.linspace(0.2, 0.8, 9))
    columns = [rows[(rows[:, 0] > low) & (rows[:, 0] < high)] for low, high in itertools.pairwise(edges)]
    tops = [(float(c[:, 0].mean()), float(np.quantile(c[:, 1], 0.98))) for c in columns]
    return float(np.polyfit(*np.array(tops).T, 1)[0])


MOTIONS: Final = (
    Motion("lammps_vibrated_bed", plate_in_lammps),
    Motion("liggghts_shaken_plate", plate_in_liggghts),
    Motion("yade_shaken_bed", plate_in_yade),
    Motion("lammps_chute", chute_in_lammps),
    Motion("lammps_rough_chute", chute_in_lammps),
    Motion("lammps_turning_drum", drum_in_lammps),
    Motion("lammps_dense_shear", box_in_lammps),
    Motion("liggghts_rolling_drum", drum_in_liggghts),
    Motion("yade_dense_shear", cell_in_yade),
)
COLUMNS: Final = (
    "script",
    "version",
    "gamma",
    "strength",
    "shear_rate",
    "pressure",
    "inertial_number",
    "stress_ratio",
    "overlap",
    "largest_stable_step",
)


def main() -> None:
    arguments = recorded.arguments(__doc__)
    rows = recorded.rows_of(arguments.file)
    for motion in MOTIONS:
        kind = motion.name.split("_")[0]
        if arguments.only not in motion.name or (kind != "lammps" and not shutil.which(kind)):
            continue
        with tempfile.TemporaryDirectory() as folder:
            code = CODES[kind](Script(motion.name, 0.0), Path(folder))
            values = {name: f"{value:.4g}" for name, value in motion.measure(code).items()}
            rows[motion.name] = {"script": motion.name, "version": code.version(), **values}
            print(rows[motion.name], flush=True)
        recorded.write(arguments.file, COLUMNS, (rows[each.name] for each in MOTIONS if each.name in rows))


if __name__ == "__main__":
    main()
