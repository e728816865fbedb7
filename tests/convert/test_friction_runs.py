"""convert with friction, run in LAMMPS, LIGGGHTS and YADE: the input as it is written gives the β that is said.

Thirty grains meet a wall, or others, at random angles, a random share of the tangential velocity being spin.
"""

import subprocess
from dataclasses import dataclass
from shutil import which

import numpy as np
import pytest

import hardlimit as hl
from conftest import slow
from hardlimit.boxes.lammps import program
from hardlimit.contact import frictional_contact
from hardlimit.convert import codes, texts
from hardlimit.convert.conversion import placeholders
from hardlimit.convert.friction import contact_of
from hardlimit.convert.tangential import NormalContact, models_of

BALL = hl.Ball(radius=5e-4, density=2500.0)
SPEED = 0.03
COUNT = 30
#: Steps of a contact.
STEPS = 3000
#: Distance of the surfaces at the start, in steps.
GAP = 2.3
MU, BETA = 0.5, 0.33
#: Largest difference of β: that of time steps, and of the turning of pairs.
LARGEST = 2e-3
STIFF = {"hooke": {"stiffness": 1e5}, "hertz": {"youngs_modulus": 1e9, "poisson_ratio": 0.3}}

try:
    program.find(1)
    MISSING = ""
except ImportError as error:
    MISSING = str(error)


@dataclass
class Impacts:
    """Where grains are and how they move: along x and z, spinning about y."""

    tangents: np.ndarray  # tan γ
    share: np.ndarray  # of the tangential velocity that is spin; most of it, so that pairs hardly turn

    @classmethod
    def random(cls, seed):
        draw = np.random.default_rng(seed)
        tangents = np.tan(np.radians(draw.uniform(1.0, 88.0, COUNT)))
        return cls(tangents, 1.0 - draw.uniform(0.0, 1.0, COUNT) / np.maximum(2.0 * tangents, 1.0))

    @property
    def velocity(self):
        """Of the surfaces along x, relative to the other body."""
        return (1.0 - self.share) * self.tangents * SPEED

    @property
    def spin(self):
        """About y, of both bodies together: g_x = v_x − R ω_y for a grain above the other body."""
        return -self.share * self.tangents * SPEED / BALL.radius

    def restitution(self, velocity, spin):
        """β from velocities and spins after; a row for each body, relative to the other one."""
        return -(velocity - BALL.radius * spin) / (self.tangents * SPEED)


def conversion(name, model, wanted=BETA, **more):
    source = codes.code(name).model(model)
    options = {"restitution": 1.0 if source.damping.formula == "none" else 0.7, "speed": SPEED, **more}
    return hl.convert(
        BALL,
        code=name,
        model=model,
        friction=MU,
        tangential_restitution=wanted,
        **STIFF[source.elastic],
        **options,
    )


def expected(converted, wall, impacts):
    """β of the numbers in the input, by the exact contact."""
    (model,) = converted.models
    row = model.contacts[1 if wall else 0]
    pair = codes.Pair(row.pair, *((1.0, 1.0) if wall else (0.5, 0.5)), wall)
    pair = codes.Pair(row.pair, pair.mass * BALL.mass, pair.radius * BALL.radius, wall)
    written = codes.Written(model.model, pair, SPEED, model.attraction)
    force = written.force(row.numbers)
    form = models_of(model.code.name)[row.friction.model]
    terms = form.terms(
        {**dict.fromkeys(form.numbers), **row.friction.numbers}, NormalContact(written, row.numbers, force)
    )
    contact = contact_of(force, terms)
    beta = frictional_contact.tangential_restitution(contact, SPEED, np.arctan(impacts.tangents))
    return beta, force.collision(SPEED).duration


def text_of(converted, wall):
    """The input of one contact."""
    (model,) = converted.models
    row = model.contacts[1 if wall else 0]
    numbers = {**row.numbers, **placeholders(row.friction, converted.wanted)}
    contact = codes.Pair(row.pair, 0.0, 0.0, wall), numbers
    return texts.written(model.code, model.model, [contact], model.attraction, row.time_step, model.friction)


def bodies(wall, impacts, gap):
    """Grain by grain: y, z, velocity along x and z, spin about y. In a row along y, far apart."""
    radius, half = BALL.radius, 0.5 * SPEED
    for k in range(COUNT):
        y, v, w = 4.0 * radius * (k - 0.5 * COUNT), float(impacts.velocity[k]), float(impacts.spin[k])
        if wall:
            yield y, radius + gap, v, -SPEED, w
        else:
            yield y, 0.0, -0.5 * v, half, 0.5 * w
            yield y, 2.0 * radius + gap, 0.5 * v, -half, 0.5 * w


def largest_error(converted, wall, rows_of, folder, count=STEPS):
    """The largest difference of β; ``rows_of`` runs the code, and returns velocity along x and spin of each grain."""
    impacts = Impacts.random(7)
    beta, duration = expected(converted, wall, impacts)
    step = duration / count
    grains = list(bodies(wall, impacts, GAP * SPEED * step))
    velocity, spin = rows_of(text_of(converted, wall), wall, grains, step, int(1.3 * count), folder).T
    if not wall:
        velocity, spin = velocity[1::2] - velocity[::2], spin[1::2] + spin[::2]
    return np.abs(impacts.restitution(velocity, spin) - beta).max()


def cases(name, *fast):
    """All models with a pair and a wall; only some of them where tests are fast."""
    every = [(model.name, wall) for model in codes.code(name).models for wall in (False, True)]
    return [case if case in fast else slow(*case) for case in every]


# --- LAMMPS -------------------------------------------------------------------------------------------------


def run(command, script, lines, folder, environment=None):
    (folder / script).write_text("\n".join(lines) + "\n")
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, (done.stdout + done.stderr)[-1500:]
    return done.stdout


def lammps(text, wall, grains, time_step, steps, folder):
    size = (COUNT + 1) * 4.0 * BALL.radius
    lines = [
        "units si",
        "atom_style sphere",
        "boundary f f f",
        "comm_modify vel yes",
        "atom_modify map array",
    ]
    lines += [f"region box block {-size} {size} {-size} {size} {-size} {size}", "create_box 1 box"]
    lines += ["neighbor 0.0002 bin", "neigh_modify delay 0"]
    lines += ["pair_style zero 0.002", "pair_coeff * *"] if wall else []
    lines += [f"create_atoms 1 single 0 {y!r} {z!r}" for y, z, *_ in grains]
    for k, (_, _, vx, vz, wy) in enumerate(grains):
        lines += [f"set atom {k + 1} diameter {2 * BALL.radius} density {BALL.density} vx {vx!r} vz {vz!r}"]
        lines += [f"set atom {k + 1} omega 0 {wy!r} 0"]
    lines += [line for line in text.splitlines() if not (wall and line.startswith("pair"))]
    lines += [f"timestep {time_step!r}", "fix move all nve/sphere", f"run {steps}"]
    lines += ['write_dump all custom end.txt id vx omegay modify sort id format line "%d %.15g %.15g"']
    lmp = program.find(1)
    run(lmp.command(1, "-in", "in.many", "-log", "none"), "in.many", lines, folder, lmp.environment())
    return np.loadtxt(folder / "end.txt", skiprows=9)[:, 1:]


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize(
    "model,wall", cases("lammps", ("hooke-restitution", False), ("gran-hooke", True), ("hertz-tsuji", True))
)
def test_lammps_has_the_tangential_restitution(model, wall, tmp_path):
    assert largest_error(conversion("lammps", model), wall, lammps, tmp_path) < LARGEST


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("wall", [slow(False), True])
@pytest.mark.parametrize("model", ["hooke-restitution", slow("hertz-tsuji")])
def test_lammps_with_a_force_that_attracts_at_the_end(model, wall, tmp_path):
    """--attraction: |F_n| limits friction there too. Where F_n passes zero, the limit at the nearest step leaves a rest
    of the spring, which acts until the end. It changes a velocity, so its Δβ is largest near head-on, here at 1.5°; it
    is in proportion to the step and depends on where the steps fall: 1.2 to 6.4 times 1e-3 at 3000 steps."""
    converted = conversion("lammps", model, attraction=True)
    assert converted.models[0].attraction and "limit_damping" not in text_of(converted, wall)
    assert largest_error(converted, wall, lammps, tmp_path, 4 * STEPS) < LARGEST


# --- LIGGGHTS -----------------------------------------------------------------------------------------------


def liggghts(text, wall, grains, time_step, steps, folder):
    size = (COUNT + 1) * 4.0 * BALL.radius
    first = [line for line in text.splitlines() if line.endswith("_particles yes")]
    lines = [*first, "units si", "atom_style granular", "atom_modify map array", "boundary f f f"]
    lines += ["newton off", "communicate single vel yes"]
    lines += [f"region box block {-size} {size} {-size} {size} {-size} {size} units box", "create_box 1 box"]
    lines += ["neighbor 0.0002 bin", "neigh_modify delay 0"]
    lines += [line for line in text.splitlines() if line not in first]
    for k, (y, z, vx, vz, wy) in enumerate(grains):
        lines += [f"create_atoms 1 single 0 {y!r} {z!r} units box"]
        lines += [f"set atom {k + 1} diameter {2 * BALL.radius} density {BALL.density}"]
        lines += [f"set atom {k + 1} vx {vx!r} vz {vz!r} omegay {wy!r}"]
    lines += [f"timestep {time_step!r}", "fix move all nve/sphere"]
    lines += [f"dump end all custom {steps} end.txt id vx omegay", 'dump_modify end format "%d %.15g %.15g"']
    lines += ["thermo 1000000", f"run {steps}"]
    run(["liggghts", "-in", "in.many", "-log", "none"], "in.many", lines, folder)
    dump = (folder / "end.txt").read_text().rpartition("ITEM: ATOMS")[2].splitlines()[1:]
    return np.array(sorted([float(x) for x in line.split()] for line in dump))[:, 1:]


@pytest.mark.skipif(which("liggghts") is None, reason="liggghts is not installed")
@pytest.mark.parametrize("model,wall", cases("liggghts", ("hooke-stiffness", False), ("hertz", True)))
def test_liggghts_has_the_tangential_restitution(model, wall, tmp_path):
    wanted = 0.2957117207 if model == "hooke" else BETA  # one of four that this model can have
    assert largest_error(conversion("liggghts", model, wanted), wall, liggghts, tmp_path) < LARGEST


# --- YADE ---------------------------------------------------------------------------------------------------

LAWS = {
    "ViscElPhys": "ViscElPhys_Basic",
    "MindlinPhys": "MindlinPhys_Mindlin",
    "FrictPhys": "FrictPhys_CundallStrack",
}
YADE = """
import os
for y, z, vx, vz, wy in {grains!r}:
    O.bodies.append(sphere((0, y, z), {radius!r}, material=0))
    O.bodies[-1].state.vel, O.bodies[-1].state.angVel = (vx, 0, vz), (0, wy, 0)
grains = list(O.bodies)
{wall}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()], [{physics}], [Law2_ScGeom_{law}()]),
    NewtonIntegrator(damping=0),
]
O.dt = {time_step!r}
O.run({steps}, True)
for body in grains:
    print("RESULT", repr(body.state.vel[0]), repr(body.state.angVel[1]), flush=True)
os._exit(0)
"""


def yade(text, wall, grains, time_step, steps, folder):
    materials = [line for line in text.splitlines() if "O.materials" in line and not line.startswith("#")]
    physics = next(
        (line for line in text.splitlines() if line.startswith("Ip2_")),
        "Ip2_ViscElMat_ViscElMat_ViscElPhys()",
    )
    (law,) = (full for name, full in LAWS.items() if f"_{name}(" in physics)
    script = YADE.format(
        grains=grains,
        radius=BALL.radius,
        wall="O.bodies.append(utils.wall((0, 0, 0), 2, material=0))" if wall else "",
        physics=physics,
        law=law,
        time_step=time_step,
        steps=steps,
    )
    lines = [*materials, f"O.materials[0].density = {BALL.density}", script]
    said = run(["yade", "-n", "-x", "script.py"], "script.py", lines, folder)
    return np.array([line.split()[1:] for line in said.splitlines() if line.startswith("RESULT")], float)


@pytest.mark.skipif(which("yade") is None, reason="yade is not installed")
@pytest.mark.parametrize("model,wall", cases("yade", ("viscel", True)))
def test_yade_has_the_tangential_restitution(model, wall, tmp_path):
    assert largest_error(conversion("yade", model), wall, yade, tmp_path) < LARGEST
