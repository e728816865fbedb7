"""Run scripts of tests/checking/data/states in LAMMPS, LIGGGHTS and YADE until their grains rest; write what they do.

    python tools/verify_states.py tests/data/script_states.csv

Requires LAMMPS of this environment or in PATH, and the programs ``liggghts`` and ``yade`` (Debian has both). The rows
of a missing code stay. The largest stable step is that up to which the kinetic energy does not grow by a factor of 3
or more in 1500 steps from the state at rest; it is bisected to 2 %. Overlaps are those of contacts more than two
diameters above the floor and below the top, each scaled to the pressure at the bottom: the second layer on a flat floor
has a tenth less. Those of shallow beds scatter by 8 %, and are means over beds from other random places. The grains at
rest are written beside the scripts as dumps.
"""

import gzip
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import recorded
from scipy.spatial import cKDTree

from hardlimit.boxes.lammps import program

SCRIPTS: Final = Path(__file__).parents[1] / "tests/checking/data/states"
STEPS: Final = 1500  #: of a trial
TOLERANCE: Final = 0.02
#: Lines that are given again after a restart: all but those that make grains, and the run.
ONCE: Final = re.compile(
    r"^(units|dimension|atom_style|boundary|newton|create_\w+|set|velocity|lattice|label|next|jump|run|timestep|thermo\w*"
    r"|fix \w+ all (pour|insert|particle)|unfix|region (seed|domain|reg|source)|write_\w+|communicate"
    r"|atom_modify)\b"
)
#: LIGGGHTS takes no other seeds.
PRIMES: Final = (86028157, 49979687, 67867979, 15485867, 15485917, 49979693, 67867967)


class Script(NamedTuple):
    """A script and what of it is measured."""

    name: str
    start: float  #: a stable time step [s]
    power: float = 1.0  #: of the pressure in the overlap
    sides: tuple[float, float] = (0.0, 0.0)  #: of a periodic box along x and y; 0 for walls
    growth: float = (
        3.0  #: of the kinetic energy in an unstable trial: a quiet bed is stirred a little by the restart
    )
    cone: bool = False  #: whether walls carry so much that the pressure is in proportion to the depth
    seeds: tuple[int, ...] = ()  #: of other beds whose overlaps are measured, too


SETTLED: Final = (
    Script("lammps_settled_bed", 1e-5, sides=(0.012, 0.012), seeds=tuple(range(4808, 6458, 97))),
    Script("lammps_settled_hertz", 1e-5, 2 / 3, (0.018, 0.018)),
    Script("lammps_two_sizes", 8e-6, sides=(0.02, 0.02), growth=10.0),
    Script("lammps_hertz_sizes", 8e-6, 2 / 3, (0.02, 0.02), 10.0),
    Script("lammps_hopper_loop", 4e-6, cone=True),
    Script("liggghts_settled_bed", 2e-5, 2 / 3, (0.012, 0.012), seeds=PRIMES),
    Script("liggghts_three_sizes", 1e-5, 2 / 3, (0.02, 0.02), 10.0),
    Script("liggghts_ring_shear", 1e-6, sides=(0.02, 0.01)),
    Script("yade_triaxial", 1e-7),
)


class State(NamedTuple):
    """Grains at rest."""

    positions: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    kind: np.ndarray
    box: tuple[float, float, float] = (0.0, 0.0, 0.0)  #: of a periodic cell


def output(command: list[str], folder: Path, environment: dict[str, str] | None = None) -> str:
    done = subprocess.run(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
    )
    if "ERROR" in done.stdout + done.stderr or (done.returncode and "yade" not in command[0]):
        raise SystemExit("\n".join((done.stdout + done.stderr).splitlines()[-6:]))
    return done.stdout


# --- the codes ----------------------------------------------------------------------------------------------------


class Lammps:
    """LAMMPS."""

    restart = "newton off\nread_restart settled\ncomm_modify vel yes\n"
    columns = "id type x y z radius mass"

    def __init__(self, script: Script, folder: Path) -> None:
        self.script, self.folder = script, folder
        text = (SCRIPTS / script.name).read_text(encoding="utf-8").partition("\nunfix lid")[0]
        self.text = re.sub(r"&\s*\n", " ", text)
        for path in SCRIPTS.glob("*.inc"):
            shutil.copy(path, folder)

    def run(self, text: str) -> str:
        (self.folder / "in.script").write_text(text, encoding="utf-8")
        lammps = program.find(1)
        return output([lammps.path, "-in", "in.script", "-log", "none"], self.folder, lammps.environment())

    def version(self) -> str:
        lammps = program.find(1)
        return re.search(
            r"Simulator - (\d+ \w+ \d+)", output([lammps.path, "-h"], self.folder, lammps.environment())
        )[1]

    def settle(self) -> State:
        """The grains after the run of the script and 40000 steps more."""
        poured = "".join(
            f"unfix {name}\n" for name in re.findall(r"^fix (\w+) all pour", self.text, re.MULTILINE)
        )
        text = f"{self.text}\n{poured}timestep {self.script.start!r}\nrun 40000"
        form = "dump_modify last format float %.17g\n" if type(self) is Lammps else ""
        dump = f"dump last all custom 1 last.dump {self.columns}\n{form}"
        self.run(f"{text}\nthermo 1000\n{dump}run 0\nwrite_restart settled\n")
        table = np.loadtxt(self.folder / "last.dump", skiprows=9)
        return State(table[:, 2:5], table[:, 5], table[:, 6], table[:, 1], (*self.script.sides, 0.0))

    def energies(self, step: float) -> list[float]:
        """The kinetic energy from the state at rest on."""
        again = "\n".join(line for line in self.text.splitlines() if not ONCE.match(line))
        again = again.replace("fix_modify pull energy yes", "")
        text = (
            f"{self.restart}{again}\ntimestep {step!r}\nthermo_style custom step ke\nthermo 50\n"
            f"thermo_modify lost ignore norm no\nrun {STEPS}\n"
        )
        table = re.findall(r"^\s*\d+\s+(-?(?:\d\S*|nan|inf))\s*$", self.run(text), re.MULTILINE)
        return [float(value) for value in table]


class Liggghts(Lammps):
    """LIGGGHTS."""

    restart = "atom_style granular\natom_modify map array\nnewton off\ncommunicate single vel yes\n"
    restart += "read_restart settled\n"

    def run(self, text: str) -> str:
        (self.folder / "in.script").write_text(text, encoding="utf-8")
        return output(["liggghts", "-in", "in.script", "-log", "none"], self.folder)

    def version(self) -> str:
        return "3.8.0 (Debian)"


YADE: Final = r"""
import numpy as np
_spheres = [b for b in O.bodies if isinstance(b.shape, Sphere)]
np.savetxt("last.txt", [[*b.state.pos, b.shape.radius, b.state.mass] for b in _spheres])
np.savetxt("box.txt", O.cell.size if O.periodic else (0, 0, 0))
print("STRESS", -getStress().trace() / 3.0)
O.save("settled.yade.gz")
"""
TRIAL: Final = r"""
O.load("settled.yade.gz")
O.dt = {step}
for _ in range(30):
    print("ENERGY", kineticEnergy(), flush=True)
    O.run({steps} // 30, True)
print("ENERGY", kineticEnergy(), flush=True)
"""


class Yade(Lammps):
    """YADE."""

    def run(self, text: str) -> str:
        (self.folder / "script.py").write_text(text, encoding="utf-8")
        return output(["yade", "-n", "-x", "script.py"], self.folder)

    def version(self) -> str:
        return "2023.02a (Debian)"

    def settle(self) -> State:
        text = self.text.partition("triax.goal = ")[0]
        text = text.replace("O.run(5000, True)", "O.run(60000, True)")
        print("pressure", re.findall(r"STRESS (\S+)", self.run(f"{text}\n{YADE}")), flush=True)
        table = np.loadtxt(self.folder / "last.txt")
        box = tuple(map(float, np.loadtxt(self.folder / "box.txt")))
        return State(table[:, :3], table[:, 3], table[:, 4], np.ones(len(table)), box)

    def energies(self, step: float) -> list[float]:
        said = self.run(TRIAL.format(step=repr(step), steps=STEPS))
        return [float(value) for value in re.findall(r"ENERGY (\S+)", said)]


CODES: Final[dict[str, type[Lammps]]] = {"lammps": Lammps, "liggghts": Liggghts, "yade": Yade}


def write_dump(state: State, path: Path) -> None:
    """The grains as a dump of LAMMPS."""
    low, high = (
        (state.positions - state.radius[:, None]).min(0),
        (state.positions + state.radius[:, None]).max(0),
    )
    ends = [(0.0, side) if side else (a, b) for side, a, b in zip(state.box, low, high, strict=True)]
    lines = ["ITEM: TIMESTEP", "0", "ITEM: NUMBER OF ATOMS", str(len(state.radius))]
    lines.append(f"ITEM: BOX BOUNDS {' '.join('pp' if side else 'ff' for side in state.box)}")
    lines += [f"{a:.9g} {b:.9g}" for a, b in ends]
    lines.append("ITEM: ATOMS id type x y z radius mass")
    rows = zip(state.kind, state.positions, state.radius, state.mass, strict=True)
    for k, (kind, (x, y, z), radius, mass) in enumerate(rows, 1):
        lines.append(f"{k} {kind:.0f} {x:.10g} {y:.10g} {z:.10g} {radius:.9g} {mass:.9g}")
    path.write_bytes(gzip.compress("\n".join([*lines, ""]).encode(), mtime=0))


# --- what is measured ---------------------------------------------------------------------------------------------


def stable(code: Lammps, step: float) -> bool:
    """Whether the energy does not grow."""
    energies = np.array(code.energies(step))
    return bool(
        np.isfinite(energies).all() and energies.max() <= code.script.growth * max(energies[0], 1e-300)
    )


def largest_stable(is_stable: Callable[[float], bool], start: float) -> float:
    """The largest stable step, bisected from one that is stable."""
    low = high = start
    while is_stable(high):
        low, high = high, 2.0 * high
    if low == high:
        raise SystemExit(f"{start} is not stable")
    while high > (1.0 + TOLERANCE) * low:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if is_stable(middle) else (low, middle)
    return (low * high) ** 0.5


def overlaps(state: State, script: Script) -> dict[str, float]:
    """Height of the bed, contacts of a grain, and mean overlap over the radius at the pressure of the bottom."""
    x, r = state.positions.copy(), state.radius
    box = np.array([side or 1e3 for side in state.box])
    x += np.where(np.array(state.box) > 0.0, 0.0, 500.0)
    pairs = np.array(sorted(cKDTree(x % box, boxsize=box).query_pairs(2.0 * r.max())))
    i, j = pairs.T
    apart = x[i] - x[j]
    apart -= box * np.round(apart / box)
    depth = r[i] + r[j] - np.linalg.norm(apart, axis=1)
    smaller, touching = np.minimum(r[i], r[j]), depth > 0.0
    z, top = state.positions[:, 2], float((state.positions[:, 2] + r).max())
    if state.box[2]:
        weight = np.ones(len(pairs))
    else:
        at = 0.5 * (z[i] + z[j])
        above = np.array([top - height if script.cone else state.mass[z > height].sum() for height in at])
        whole = top - float((z - r).min()) if script.cone else state.mass.sum()
        weight = (whole / np.maximum(above, 1e-300)) ** script.power
        touching &= (at > float((z - r).min()) + 4.0 * r.max()) & (at < top - 4.0 * r.max())
    return {
        "grains": len(r),
        "height": top - float((z - r).min()),
        "mass": float(state.mass.sum()),
        "coordination": 2.0 * float((depth > 0.0).sum()) / len(r),
        "overlap": float((weight * depth / smaller)[touching].mean()) if touching.any() else float("nan"),
        "samples": int(touching.sum()),
    }


def over_beds(code: Lammps, first: float) -> dict[str, float]:
    """The mean overlap of this bed and of those with the other seeds, and its standard error."""
    overlap, text = [first], code.text
    for seed in code.script.seeds:
        code.text = re.sub(r"(pour \d+ 1|pack seed) \d+", rf"\1 {seed}", text)
        overlap.append(overlaps(code.settle(), code.script)["overlap"])
    code.text = text
    code.settle()  # whose restart the trials of time steps take
    error = float(np.std(overlap, ddof=1)) / len(overlap) ** 0.5
    return {"overlap": float(np.mean(overlap)), "beds": len(overlap), "overlap_error": error}


def main() -> None:
    arguments = recorded.arguments(__doc__)
    rows = recorded.rows_of(arguments.file)
    names = [
        "script",
        "version",
        "grains",
        "height",
        "mass",
        "coordination",
        "overlap",
        "samples",
        "beds",
        "overlap_error",
        "largest_stable_step",
    ]
    for script in SETTLED:
        kind = script.name.split("_")[0]
        if arguments.only not in script.name or (kind != "lammps" and not shutil.which(kind)):
            continue
        with tempfile.TemporaryDirectory() as folder:
            code = CODES[kind](script, Path(folder))
            state = code.settle()
            write_dump(state, SCRIPTS / f"{script.name}.dump.gz")
            numbers = overlaps(state, script) | {"beds": 1.0, "overlap_error": float("nan")}
            if script.seeds:
                numbers |= over_beds(code, numbers["overlap"])
            print(script.name, numbers, flush=True)
            step = largest_stable(lambda h, code=code: stable(code, h), script.start)  # type: ignore[misc]
            values = {name: f"{value:.4g}" for name, value in numbers.items()}
            values["overlap_error"] = values["overlap_error"].replace("nan", "")
            rows[script.name] = {"script": script.name, "version": code.version(), **values}
            rows[script.name]["largest_stable_step"] = f"{step:.3g}"
            print(script.name, rows[script.name], flush=True)
        recorded.write(arguments.file, names, (rows[each.name] for each in SETTLED if each.name in rows))


if __name__ == "__main__":
    main()
