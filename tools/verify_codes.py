"""Run collisions of two spheres, and of a sphere and a wall, in LIGGGHTS, YADE, Kratos and MuJoCo; write the results.

    python tools/verify_codes.py --kratos-python PATH --mujoco-python PATH tests/data/code_restitution.csv

Each run takes the numbers that a user without knowledge of the code would take (``usual`` in ``hl.convert``), for
several restitutions and speeds. ``test_convert.py`` compares the results with the predictions of ``hardlimit``.
Requires the programs ``liggghts`` and ``yade`` in PATH (Debian has both), a Python with KratosDEMApplication and one
with mujoco (wheels). The rows of a missing code are left unchanged. The tests run LAMMPS themselves.
"""

import json
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import recorded

import hardlimit as hl
from hardlimit.convert import texts
from hardlimit.convert.codes import Code, Model, Pair, Written, code

RADIUS, DENSITY = 5e-4, 7850.0
RADII = (5e-4, 1e-3)  #: of the spheres of a bed
RESTITUTIONS = (0.3, 0.7, 0.9, 0.99)
SPEEDS = (0.1, 1.0)  #: only the last one at a wall
#: [N/m] and [Pa]; softer than real materials, so that runs are short.
STIFFNESS, MODULUS, POISSON = 1e4, 2.1e8, 0.3
STEPS = 1000  #: per contact
COLUMNS = ["code", "version", "model", "contact", "attraction", "speed", "numbers", "time_step"]
COLUMNS += ["restitution", "duration"]


@dataclass(frozen=True)
class Case:
    """One collision."""

    code: Code
    model: Model
    pair: Pair
    attraction: bool
    speed: float
    numbers: dict[str, float]
    time_step: float
    duration: float
    bed: str = ""  #: the input for all contacts of a bed; empty for a single contact

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of the two bodies [m]; at a wall twice that of the sphere."""
        return RADII[self.pair.first - 1], RADII[self.pair.second - 1]

    @property
    def types(self) -> tuple[int, int]:
        """Types of the two bodies in the input; the wall of a bed has the last type."""
        if not self.bed:
            return 1, 1
        return self.pair.first, len(RADII) + 1 if self.pair.wall else self.pair.second

    @property
    def contact(self) -> str:
        """The name of the contact in the file."""
        return f"bed, {self.pair.name}" if self.bed else "wall" if self.pair.wall else "pair"

    @property
    def gap(self) -> float:
        """Initial distance of the surfaces [m]: a few steps."""
        return 3.4 * self.time_step * self.speed

    @property
    def end(self) -> int:
        """Number of steps of the run, longer than the contact."""
        return round(1.6 * self.duration / self.time_step) + 20

    def text(self) -> str:
        """The input as the package writes it."""
        if self.bed:
            return self.bed
        return texts.written(
            self.code, self.model, [(self.pair, self.numbers)], self.attraction, self.time_step
        )


def spring(model: Model) -> dict[str, float]:
    """The elastic constants of a model's law."""
    if model.elastic == "hooke":
        return {"stiffness": STIFFNESS}
    return {"youngs_modulus": MODULUS, "poisson_ratio": POISSON}


def cases(name: str) -> Iterator[Case]:
    """All collisions of a code after which the bodies separate."""
    particle_code = code(name)
    for model in particle_code.models:
        if model.damping.formula == "none":
            continue
        for attraction in (False, True) if model.attracts == "unless" else (False,):
            for restitution in RESTITUTIONS:
                for speed in SPEEDS:
                    conversion = hl.convert(
                        hl.Ball(RADIUS, density=DENSITY),
                        restitution=restitution,
                        speed=speed,
                        **spring(model),
                    )
                    for contact in conversion.contacts[: 2 if speed == SPEEDS[-1] else 1]:
                        wall = contact.pair.endswith("wall")
                        pair = Pair(contact.pair, contact.effective_mass, contact.effective_radius, wall)
                        written = Written(model, pair, speed, attraction, POISSON)
                        numbers = written.usual_numbers(contact.stiffness, restitution)
                        numbers = numbers or written.numbers(contact.stiffness, restitution)
                        duration = written.force(numbers).collision(speed).duration
                        step = float(f"{duration / STEPS:.4g}")
                        yield Case(particle_code, model, pair, attraction, speed, numbers, step, duration)


def bed_cases(name: str) -> Iterator[Case]:
    """Every contact of a bed of two sizes and a wall with one common input, for ε = 0.7."""
    particle_code = code(name)
    balls = [hl.Ball(radius, density=DENSITY) for radius in RADII]
    for model in particle_code.models:
        if not model.input.matrix:
            continue
        conversion = hl.convert(balls, restitution=0.7, **spring(model), code=name, model=model.name)
        for row in conversion.models[0].contacts:
            wall = row.pair.endswith("wall")
            first, second = (int(x) for x in re.findall(r"\d", row.pair + (row.pair[0] if wall else "")))
            contact = next(contact for contact in conversion.contacts if contact.pair == row.pair)
            pair = Pair(row.pair, contact.effective_mass, contact.effective_radius, wall, first, second)
            duration = Written(model, pair, 1.0).force(row.numbers).collision(1.0).duration
            step = float(f"{duration / STEPS:.4g}")
            yield Case(particle_code, model, pair, False, 1.0, row.numbers, step, duration, conversion.text)


@dataclass(frozen=True)
class Measured:
    """Result of a run."""

    restitution: float
    duration: float  #: [s] from the first to the last step in which the velocity changed

    @classmethod
    def of(cls, velocities: list[float], time_step: float) -> "Measured":
        """From the relative velocity at the start and after each step, in units of the impact velocity."""
        changed = [k for k in range(1, len(velocities)) if velocities[k] != velocities[k - 1]]
        return cls(velocities[-1], (changed[-1] - changed[0] + 1) * time_step)


def liggghts(case: Case, folder: Path) -> Measured:
    """One run."""
    half = 20.0 * RADIUS
    (a, b), (i, j) = case.radii, case.types
    away = 0.3 * half if case.bed else 0  # from the floor of the bed
    first, second = (-case.speed, 0.0) if case.pair.wall else (0.5 * case.speed, -0.5 * case.speed)
    body = [
        "units si",
        "atom_style granular",
        "boundary f f f",
        "newton off",
        "communicate single vel yes",
        "atom_modify map array",
        f"region box block {-half} {half} {-half} {half} {-half} {half} units box",
        f"create_box {max(i, j, len(RADII) + 1 if case.bed else 1)} box",
        "neighbor 0.0005 bin",
        "neigh_modify delay 0",
        *(line for line in case.text().splitlines() if line.startswith("fix m")),
        *(line for line in case.text().splitlines() if not line.startswith(("fix m", "timestep"))),
        f"timestep {case.time_step!r}",
    ]
    if case.pair.wall:
        body += [
            f"create_atoms {i} single 0 0 {a + case.gap!r} units box",
            f"set atom 1 diameter {2 * a} density {DENSITY} vz {first!r}",
            f"variable v equal vz[1]/{case.speed}",
        ]
    else:
        body += [
            f"create_atoms {i} single 0 0 {away} units box",
            f"create_atoms {j} single {a + b + case.gap!r} 0 {away} units box",
            f"set atom 1 diameter {2 * a} density {DENSITY} vx {first!r}",
            f"set atom 2 diameter {2 * b} density {DENSITY} vx {second!r}",
            f"variable v equal (vx[2]-vx[1])/{case.speed}",
        ]
    count = 1 if case.pair.wall else 2
    for k in range(len(RADII) if case.bed else 0):  # each type must occur
        body.append(f"create_atoms {k + 1} single 0 {0.6 * half!r} {(-1) ** k * 0.6 * half!r} units box")
        body.append(f"set atom {count + k + 1} diameter {RADII[k]} density {DENSITY}")
    body += [
        "fix move all nve/sphere",
        "thermo_style custom step v_v",
        "thermo_modify format 2 'RESULT %.17g' lost ignore",
        "thermo 1",
        f"run {case.end}",
    ]
    (folder / "in.two").write_text("\n".join(body) + "\n")
    speeds = results(["liggghts", "-in", "in.two", "-log", "none"], folder)
    return Measured.of(speeds, case.time_step)


YADE_HEAD = """
from yade import *

def tell(speed, wall):
    v = [b.state.vel for b in O.bodies]
    print("RESULT", (v[0][2] if wall else v[1][0] - v[0][0]) / speed)
"""
YADE = """
O.reset()
{material}
for body in [{first}] if {wall} else [{first}, {second}]:
    O.bodies.append(sphere(body[0], body[1], material=body[2]))
    O.bodies[-1].state.vel = body[3]
    O.bodies[-1].state.mass = {density} * 4.0 / 3.0 * 3.141592653589793 * body[1] ** 3
if {wall}:
    O.bodies.append(utils.wall((0, 0, 0), axis=2, material={wall_material}))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [{physics}], [{law}]),
    NewtonIntegrator(damping=0),
    PyRunner(iterPeriod=1, initRun=True, command="tell({speed}, {wall})"),
]
O.dt = {dt}
O.run({end}, True)
"""


def yade_lines(case: Case) -> str:
    """The script of one run."""
    lines = case.text().splitlines()
    hertz = case.model.elastic == "hertz"
    (a, b), (i, j) = case.radii, case.types
    v = case.speed
    if case.pair.wall:
        first = ((0.0, 0.0, a + case.gap), a, i - 1, (0.0, 0.0, -v))
    else:
        first = ((0.0, 0.0, 0.0), a, i - 1, (0.5 * v, 0.0, 0.0))
    return YADE.format(
        material=next(line for line in lines if "O.materials" in line),
        density=DENSITY,
        first=first,
        second=((a + b + case.gap, 0.0, 0.0), b, j - 1, (-0.5 * v, 0.0, 0.0)),
        wall_material=j - 1,
        speed=v,
        wall=case.pair.wall,
        physics=next((x for x in lines if x.startswith("Ip2")), "Ip2_ViscElMat_ViscElMat_ViscElPhys()"),
        law="Law2_ScGeom_MindlinPhys_Mindlin()" if hertz else "Law2_ScGeom_ViscElPhys_Basic()",
        dt=repr(case.time_step),
        end=case.end,
    )


def yade(cases: list[Case], folder: Path) -> list[Measured]:
    """All runs in one process, because YADE starts slowly."""
    (folder / "two.py").write_text(YADE_HEAD + "".join(map(yade_lines, cases)))
    speeds = iter(results(["yade", "-n", "-x", "two.py"], folder))
    return [Measured.of([next(speeds) for _ in range(case.end)], case.time_step) for case in cases]


EMPTY = "Begin ModelPartData\nEnd ModelPartData\nBegin Properties 0\nEnd Properties\n"


def block(name: str, lines: list[str]) -> str:
    """A block in the mesh format of Kratos."""
    return "\n".join([f"Begin {name}", *lines, f"End {name.split()[0]}", ""])


def part(name: str, **members: list[str]) -> str:
    """A part of a model that can have a material."""
    return block(f"SubModelPart {name}", [block(f"SubModelPart{kind}", ids) for kind, ids in members.items()])


def spheres(x: list[float], velocities: list[float]) -> str:
    """Spheres on the x axis."""
    numbers = [str(i + 1) for i in range(len(x))]
    return (
        block("Nodes", [f"{i} {at!r} 0.0 0.0" for i, at in zip(numbers, x, strict=True)])
        + block("Elements SphericParticle3D", [f"{i} 0 {i}" for i in numbers])
        + block("NodalData RADIUS", [f"{i} 0 {RADIUS!r}" for i in numbers])
        + block("NodalData VELOCITY_X", [f"{i} 0 {v!r}" for i, v in zip(numbers, velocities, strict=True)])
        + part("All", Nodes=numbers, Elements=numbers)
    )


def wall() -> str:
    """A square in the plane x = 0, much wider than the sphere."""
    wide = 20.0 * RADIUS
    corners = [(-wide, -wide), (wide, -wide), (wide, wide), (-wide, wide)]
    numbers = [str(11 + i) for i in range(4)]
    return (
        block("Nodes", [f"{i} 0.0 {y!r} {z!r}" for i, (y, z) in zip(numbers, corners, strict=True)])
        + block("Conditions RigidFace3D4N", [f"1 0 {' '.join(numbers)}"])
        + part("Wall", Nodes=numbers, Conditions=["1"])
    )


KRATOS = """
import sys
import KratosMultiphysics as Kratos
from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage

class Stage(DEMAnalysisStage):
    def tell(self):
        found = [node.GetSolutionStepValue(Kratos.VELOCITY_X) for node in self.spheres_model_part.Nodes]
        print("RESULT", (found[-1] - (found[0] if len(found) > 1 else 0.0)) / float(sys.argv[1]))

    def Initialize(self):
        super().Initialize()
        self.tell()

    def FinalizeSolutionStep(self):
        super().FinalizeSolutionStep()
        self.tell()

Stage(Kratos.Model(), Kratos.Parameters(open("parameters.json").read())).Run()
"""


def kratos(case: Case, folder: Path, python: str) -> Measured:
    """One run."""
    at_wall = case.pair.wall
    if at_wall:
        bodies, faces = spheres([RADIUS + case.gap], [-case.speed]), wall()
    else:
        bodies = spheres([0.0, 2 * RADIUS + case.gap], [0.5 * case.speed, -0.5 * case.speed])
        faces = ""
    for name, content in {"": bodies, "_FEM_boundary": faces, "_Clusters": "", "_Inlet": ""}.items():
        (folder / f"twoDEM{name}.mdpa").write_text(EMPTY + content)
    none = ("STATIC_FRICTION", "DYNAMIC_FRICTION", "ROLLING_FRICTION", "ROLLING_FRICTION_WITH_WALLS")
    material = {
        "PARTICLE_DENSITY": DENSITY,
        "YOUNG_MODULUS": case.numbers["youngs_modulus"],
        "POISSON_RATIO": case.numbers["poisson_ratio"],
    }
    relation = {
        **dict.fromkeys(none, 0.0),
        "FRICTION_DECAY": 500.0,
        "COEFFICIENT_OF_RESTITUTION": case.numbers["restitution"],
        "DEM_DISCONTINUUM_CONSTITUTIVE_LAW_NAME": case.model.title,
    }
    materials = {
        "materials": [{"material_name": "m", "material_id": 1, "Variables": material}],
        "material_relations": [
            {"material_names_list": ["m", "m"], "material_ids_list": [1, 1], "Variables": relation}
        ],
        "material_assignation_table": [
            ["SpheresPart.All", "m"],
            *([["RigidFacePart.Wall", "m"]] if at_wall else []),
        ],
    }
    (folder / "MaterialsDEM.json").write_text(json.dumps(materials))
    end = case.end * case.time_step
    parameters = {
        "Dimension": 3,
        "problem_name": "two",
        "MaxTimeStep": case.time_step,
        "FinalTime": end,
        "OutputTimeStep": end,
        **{f"Gravity{axis}": 0.0 for axis in "XYZ"},
        "BoundingBoxOption": False,
        "NeighbourSearchFrequency": 1,
        "TranslationalIntegrationScheme": "Symplectic_Euler",
        "do_print_results_option": False,
        "post_vtk_option": False,
        "RotationOption": False,
        "solver_settings": {
            "RemoveBallsInitiallyTouchingWalls": False,
            "strategy": "sphere_strategy",
            "material_import_settings": {"materials_filename": "MaterialsDEM.json"},
        },
    }
    (folder / "parameters.json").write_text(json.dumps(parameters))
    (folder / "two.py").write_text(KRATOS)
    return Measured.of(results([python, "two.py", repr(case.speed)], folder), case.time_step)


MUJOCO = """
import sys
import mujoco

model = mujoco.MjModel.from_xml_path("two.xml")
data = mujoco.MjData(model)
speed = float(sys.argv[1])
axes = [2, 8][: model.nv // 6]
data.qvel[axes[0]] = speed * (0.5 if len(axes) == 2 else -1.0)
data.qvel[axes[1:]] = -0.5 * speed
for step in range(int(sys.argv[2]) + 1):
    found = data.qvel[axes]
    print("RESULT", repr(float(found[-1] - (found[0] if len(axes) == 2 else 0.0)) / speed))
    mujoco.mj_step(model, data)
"""


def mujoco(case: Case, folder: Path, python: str) -> Measured:
    """One run; the balls move along z, without gravity."""
    at_wall = case.pair.wall
    heights = [RADIUS + case.gap] if at_wall else [0.0, 2 * RADIUS + case.gap]
    # The input has one line for a pair of equal balls.
    names = ["ball1"] if at_wall else ["ball1", "other"]
    lines = [line.replace('geom2="ball1"', 'geom2="other"') for line in case.text().splitlines()]
    balls = [
        f'<body pos="0 0 {z!r}"><freejoint/><geom name="{name}" type="sphere" size="{RADIUS}" density="{DENSITY}"/>'
        "</body>"
        for name, z in zip(names, heights, strict=True)
    ]
    floor = ['<geom name="floor" type="plane" size="1 1 1"/>'] if at_wall else []
    body = ["<worldbody>", *floor, *balls, "</worldbody>"]
    # The time step with all digits; the text rounds it.
    lines = [re.sub(r'timestep="[^"]*"', f'timestep="{case.time_step!r}" gravity="0 0 0"', x) for x in lines]
    (folder / "two.xml").write_text("\n".join(["<mujoco>", *body, *lines, "</mujoco>"]))
    (folder / "two.py").write_text(MUJOCO)
    return Measured.of(results([python, "two.py", repr(case.speed), str(case.end)], folder), case.time_step)


def results(command: list[str], folder: Path) -> list[float]:
    """The numbers after RESULT in the output of a program."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    numbers = re.findall(r"RESULT (\S+) *$", done.stdout, re.MULTILINE)
    if not numbers:
        raise RuntimeError(f"{command[0]}: {(done.stdout + done.stderr)[-800:]}")
    return [float(number) for number in numbers]


Runs = Callable[[list[Case], Path], list[Measured]]


def each(run: Callable[[Case, Path], Measured]) -> Runs:
    """Run the cases one after the other."""
    return lambda cases, folder: [run(case, folder) for case in cases]


def rows(name: str, run: Runs) -> Iterator[dict[str, object]]:
    """One row of the file for each case."""
    listed = [*cases(name), *bed_cases(name)]
    with tempfile.TemporaryDirectory() as folder:
        measurements = run(listed, Path(folder))
    for case, measured in zip(listed, measurements, strict=True):
        numbers = {key: float(f"{value:.12g}") for key, value in case.numbers.items()}
        yield {
            "code": name,
            "version": case.code.version,
            "model": case.model.name,
            "contact": case.contact,
            "attraction": int(case.model.powers(case.attraction).attracts),
            "speed": case.speed,
            "numbers": json.dumps(numbers),
            "time_step": case.time_step,
            "restitution": f"{measured.restitution:.9g}",
            "duration": f"{measured.duration:.5g}",
        }


def write(path: Path, lines: list[dict[str, object]]) -> None:
    """Replace the rows of the same code in the file."""
    known = recorded.all_rows_of(path, "code") | {str(lines[0]["code"]): lines}
    recorded.write(path, COLUMNS, (row for name in sorted(known) for row in known[name]))


def main() -> None:
    parser = recorded.command_line(__doc__)
    parser.add_argument("--kratos-python", help="a Python with the wheel KratosDEMApplication")
    parser.add_argument("--mujoco-python", help="a Python with the wheel mujoco")
    arguments = parser.parse_args()
    runs: dict[str, Iterator[dict[str, object]]] = {}
    if shutil.which("liggghts"):
        runs["liggghts"] = rows("liggghts", each(liggghts))
    if shutil.which("yade"):
        runs["yade"] = rows("yade", yade)
    if arguments.kratos_python:
        python = arguments.kratos_python
        runs["kratos"] = rows("kratos", each(lambda case, folder: kratos(case, folder, python)))
    if arguments.mujoco_python:
        simulator = arguments.mujoco_python
        runs["mujoco"] = rows("mujoco", each(lambda case, folder: mujoco(case, folder, simulator)))
    for name, lines in runs.items():
        write(arguments.file, list(lines))
        print(f"{name}: done", flush=True)


if __name__ == "__main__":
    main()
