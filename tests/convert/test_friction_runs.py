"""convert with friction, run in LAMMPS, LIGGGHTS and YADE: the input as it is written gives the β that is said.

Thirty grains meet a wall, or others, at random angles, a random share of the tangential velocity being spin.
"""

import math
import subprocess
from dataclasses import dataclass
from shutil import which

import numpy as np
import pytest

import hardlimit as hl
from conftest import slow
from hardlimit.boxes.lammps import program
from hardlimit.convert import codes
from hardlimit.convert.friction import KAPPA, frictional_contact
from hardlimit.convert.tangential import NormalContact, models_of

BALL = hl.Ball(radius=5e-4, density=2500.0)
SPEED = 0.03
COUNT = 30
#: Steps of a contact.
STEPS = 3000
#: Distance of the surfaces at the start, in steps.
GAP = 2.3
MU, BETA = 0.5, 0.33
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


def conversion(name, model, wanted=BETA):
    source = codes.code(name).model(model)
    options = {"restitution": 1.0 if source.damping.formula == "none" else 0.7, "speed": SPEED}
    return hl.convert(
        BALL, code=name, model=model, friction=MU, tangential_restitution=wanted, **STIFF[source.elastic], **options
    )


def expected(converted, wall, impacts):
    """β of the numbers in the input, by the exact contact."""
    (model,) = converted.models
    row = model.contacts[1 if wall else 0]
    pair = codes.Pair(row.pair, *((1.0, 1.0) if wall else (0.5, 0.5)), wall)
    pair = codes.Pair(row.pair, pair.mass * BALL.mass, pair.radius * BALL.radius, wall)
    written = codes.Written(model.model, pair, SPEED)
    force = written.force(row.numbers)
    form = models_of(model.code.name)[row.friction.model]
    terms = form.terms(
        {**dict.fromkeys(form.numbers), **row.friction.numbers}, NormalContact(written, row.numbers, force)
    )
    contact = frictional_contact(force, terms)
    return contact.tangential_restitution(SPEED, np.arctan(impacts.tangents)), force.collision(SPEED).duration


# --- LAMMPS -------------------------------------------------------------------------------------------------


def lammps_lines(text, wall, impacts, time_step, end):
    """Grains in a row along y, far apart."""
    radius, gap = BALL.radius, GAP * SPEED * time_step
    size = (COUNT + 1) * 4.0 * radius
    lines = ["units si", "atom_style sphere", "boundary f f f", "comm_modify vel yes", "atom_modify map array"]
    lines += [f"region box block {-size} {size} {-size} {size} {-size} {size}", "create_box 1 box"]
    lines += ["neighbor 0.0002 bin", "neigh_modify delay 0"]
    lines += ["pair_style zero 0.002", "pair_coeff * *"] if wall else []
    places, number = [], 0
    for k in range(COUNT):
        y = 4.0 * radius * (k - 0.5 * COUNT)
        v, w = float(impacts.velocity[k]), float(impacts.spin[k])
        bodies = [(radius + gap, v, -SPEED, w)]
        if not wall:
            bodies = [(0.0, -0.5 * v, 0.5 * SPEED, 0.5 * w), (2.0 * radius + gap, 0.5 * v, -0.5 * SPEED, 0.5 * w)]
        for z, vx, vz, wy in bodies:
            number += 1
            lines += [f"create_atoms 1 single 0 {y!r} {z!r}"]
            places += [f"set atom {number} diameter {2 * radius} density {BALL.density} vx {vx!r} vz {vz!r}"]
            places += [f"set atom {number} omega 0 {wy!r} 0"]
    kept = ("group", "fix") if wall else ("pair",)
    lines += [*places, *(line for line in text.splitlines() if line.startswith(kept)), f"timestep {time_step!r}"]
    lines += ["fix move all nve/sphere", f"run {end}"]
    dump = 'write_dump all custom end.txt id vx omegay modify sort id format line "%d %.15g %.15g"'
    return [*lines, dump]


def lammps_cases():
    """All models with a pair and a wall; two of them where tests are fast."""
    every = [(model.name, wall) for model in codes.code("lammps").models for wall in (False, True)]
    fast = [("hooke-restitution", False), ("gran-hooke", True)]
    return [case if case in fast else pytest.param(*case, marks=pytest.mark.slow) for case in every]


def surface(rows, wall, impacts):
    """β from velocities and spins at the end, those of both bodies one after the other."""
    velocity, spin = rows.T
    if not wall:
        velocity, spin = velocity[1::2] - velocity[::2], spin[1::2] + spin[::2]
    return impacts.restitution(velocity, spin)


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("name,wall", lammps_cases())
def test_lammps_has_the_tangential_restitution(name, wall, tmp_path):
    converted = conversion("lammps", name)
    impacts = Impacts.random(7)
    beta, duration = expected(converted, wall, impacts)
    lines = lammps_lines(converted.text, wall, impacts, duration / STEPS, int(1.3 * STEPS))
    (tmp_path / "in.many").write_text("\n".join(lines) + "\n")
    lmp = program.find(1)
    command = lmp.command(1, "-in", "in.many", "-log", "none")
    done = subprocess.run(command, cwd=tmp_path, env=lmp.environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-800:]
    rows = np.loadtxt(tmp_path / "end.txt", skiprows=9)[:, 1:]
    error = np.abs(surface(rows, wall, impacts) - beta)
    print(name, wall, error.max(), np.degrees(np.arctan(impacts.tangents[error.argmax()])))
    assert error.max() < 2e-3
