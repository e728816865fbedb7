"""Largest stable time step: pairs and lattices by hand; packings against velocity Verlet in NumPy and LAMMPS."""

import math
import re
import subprocess

import numpy as np
import pytest

import hardlimit as hl
from conftest import refusal, slow
from hardlimit.boxes.lammps import program

try:
    LAMMPS, MISSING = program.find(1), ""
except ImportError as error:
    LAMMPS, MISSING = None, str(error)

#: k_t/k, γ_t/γ, μ and γ [kg/s] of the laws with k = 1 N/m for the packings.
LAWS = {
    "smooth": (0.0, 0.0, 0.0, 0.0),
    "damped": (0.0, 0.0, 0.0, 0.3),
    "friction": (2.0 / 7.0, 0.0, 0.5, 0.0),
    "friction damped": (2.0 / 7.0, 0.0, 0.5, 0.3),
    "all": (1.0, 1.0, 5.0, 0.3),
}


def law_of(ratio=0.0, damping_ratio=0.0, mu=0.5, damping=0.0, stiffness=1.0):
    friction = hl.Friction(mu, stiffness_ratio=ratio, damping_ratio=damping_ratio) if ratio else None
    return hl.LinearDashpot(stiffness=stiffness, damping=damping, friction=friction)


def step_of(system, law, **options):
    return float(hl.measure.largest_stable_time_step(system, law, **options).time_step)


def frequency(system, law):
    return float(hl.measure.largest_stable_time_step(system, law).frequency)


def touching(positions, radius=0.5, box=8.0, **values):
    """Grains at rest that overlap."""
    rest = np.zeros_like(np.asarray(positions, float))
    return hl.ParticleSystem(
        positions, rest, radius, box=box, **({"mass": 1.0, "allowed_overlap": 0.3} | values)
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("q", [0.2, 0.4, 2.0 / 3.0])
def test_two_unequal_grains(dimension, q):
    """The larger of the frequencies of the normal motion and of that of the surfaces."""
    radius, mass = np.array([0.5, 1.25]), np.array([1.0, 3.0])
    apart = 1.7 * np.array([0.6, 0.8, 0.0])[:dimension]
    pair = touching([[4.0] * dimension, apart + 4.0], radius, mass=mass, inertia_factor=q)
    arms = radius * 1.7 / radius.sum()
    across = (1.0 / mass).sum() + (arms**2 / (q * mass * radius**2)).sum()
    for ratio in (0.0, 0.1, 0.5, 1.0):
        expected = math.sqrt(max((1.0 / mass).sum(), ratio * across))
        assert frequency(pair, law_of(ratio)) == pytest.approx(expected, rel=1e-12)


def test_a_dashpot_shortens_the_step_of_a_pair():
    """2/ω (√(1 + ζ²) − ζ) for every ζ; the tangential one decides if it is stiffer or more damped."""
    pair = touching([[4.0, 4.0], [4.98, 4.0]])
    for zeta in (0.01, 0.3, 1.0, 5.0):
        damping = 2.0 * zeta * math.sqrt(0.5)
        expected = math.sqrt(2.0) * (math.sqrt(1.0 + zeta**2) - zeta)
        assert step_of(pair, law_of(damping=damping)) == pytest.approx(expected, rel=1e-9)
    square = 2.0 + 4.0 * 0.98**2  # of the surfaces, disks
    zeta = 0.5 / (2.0 * math.sqrt(square)) * square
    expected = 2.0 / math.sqrt(square) * (math.sqrt(1.0 + zeta**2) - zeta)
    assert step_of(pair, law_of(1.0, 1.0, damping=0.5)) == pytest.approx(expected, rel=1e-9)


def test_a_grain_on_a_wall_and_none_in_contact():
    ball = touching([[4.0, 4.0, 0.49]], boundary=("periodic", "periodic", "wall"))
    assert frequency(ball, law_of()) == pytest.approx(1.0, rel=1e-12)
    assert frequency(ball, law_of(0.5)) == pytest.approx(math.sqrt(0.5 * 3.5), rel=1e-12)
    free = hl.measure.largest_stable_time_step(touching([[4.0, 4.0, 4.0]]), law_of())
    assert (float(free.time_step), float(free.frequency), float(free.coordination)) == (math.inf, 0.0, 0.0)
    assert step_of(touching([[4.0, 4.0, 0.51]], boundary="wall"), law_of(), tolerance=0.03) == 2.0


def test_stiffness_of_hertz_is_that_at_the_compression():
    """ω² = (2/m) dF/dξ, F = ρ ξ^(3/2), and Mindlin's k_t = ratio · dF/dξ."""
    pair = touching([[4.0, 4.0, 4.0], [4.96, 4.0, 4.0]])
    law = hl.Viscoelastic(
        youngs_modulus=1e3, poisson_ratio=0.3, dissipative_time=0.0, friction=hl.Friction(0.5)
    )
    rho = law.between(hl.Ball(0.5, mass=1.0), hl.Ball(0.5, mass=1.0)).elastic_prefactor
    slope = 1.5 * rho * math.sqrt(0.04)
    square = 2.0 + 2.0 * 0.96**2 / 0.4
    expected = math.sqrt(slope * max(2.0, law.friction.stiffness_ratio * square))
    assert frequency(pair, law) == pytest.approx(expected, rel=1e-9)


def grid(sides, spacing=0.99):
    points = np.stack(np.meshgrid(*(np.arange(n) for n in sides), indexing="ij"), -1).reshape(-1, len(sides))
    return touching((points + 0.5) * spacing, box=spacing * np.array(sides))


@pytest.mark.parametrize("ratio", [0.0, 2.0 / 7.0, 0.9, 1.0])
def test_lattices(ratio):
    """Opposite neighbours, or all spins alike: the fastest modes of a chain, a square and a cubic lattice."""
    arm = 0.99**2
    chain = touching(np.stack([0.99 * np.arange(12) + 0.3, np.full(12, 4.0)], axis=1), box=[12 * 0.99, 8.0])
    square, cubic = grid((6, 8)), grid((4, 4, 6))
    for system, expected in (
        (chain, max(4.0, ratio * 8.0 * arm, 4.0 * ratio)),
        (square, max(4.0 + 4.0 * ratio, 16.0 * ratio * arm)),
        (cubic, max(4.0 + 8.0 * ratio, 20.0 * ratio * arm)),
    ):
        assert frequency(system, law_of(ratio)) == pytest.approx(math.sqrt(expected), rel=1e-7)


def test_close_packed_lattice():
    """Smooth spheres: ω² = 8 k/m at the edge of the zone; with k_t = k all spins alike, (4/3)(z/q) k/m, z = 12."""
    side = 0.99 * math.sqrt(2.0)
    cell = np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) * 0.5 + 0.25
    corners = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    system = touching((corners + cell).reshape(-1, 3) * side, box=4.0 * side)
    result = hl.measure.largest_stable_time_step(system, law_of())
    assert float(result.frequency) == pytest.approx(math.sqrt(8.0), rel=1e-7)
    assert (float(result.coordination), int(result.largest_coordination)) == (12.0, 12)
    assert frequency(system, law_of(1.0)) == pytest.approx(math.sqrt(40.0) * 0.99, rel=1e-7)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_contact_across_a_sheared_boundary(dimension):
    """The image of a grain beyond the edge of the gradient is displaced along x."""
    box = np.full(dimension, 6.0)
    positions = np.full((2, dimension), 3.0)
    positions[0, :2], positions[1, :2] = (1.0, 0.2), (1.0 + 0.588 + 2.5, 0.2 - 0.784 + 6.0)
    sides = ("periodic", "lees-edwards", "periodic")[:dimension]
    pair = touching(positions, box=box, boundary=sides, shear_rate=1e-3, shear_displacement=2.5)
    assert frequency(pair, law_of()) == pytest.approx(math.sqrt(2.0), rel=1e-12)
    square = 2.0 + 2.0 * 0.98**2 / (0.5 if dimension == 2 else 0.4)
    assert frequency(pair, law_of(1.0)) == pytest.approx(math.sqrt(square), rel=1e-12)


def test_units():
    """The step scales with √(m/k)."""
    system = packing(20, 0)
    scaled = system.replace(mass=3.0 * system.mass)
    assert step_of(scaled, law_of(0.5, stiffness=2.0)) == pytest.approx(
        step_of(system, law_of(0.5)) * math.sqrt(1.5), rel=1e-8
    )


def test_refusals():
    pair = touching([[4.0, 4.0], [4.98, 4.0]])
    said = refusal(lambda: hl.measure.largest_stable_time_step(pair, law_of(), tolerance=2.0))
    assert said.startswith("tolerance: got 2, must be in [0, 1]")
    assert "must be a ParticleSystem" in refusal(lambda: hl.measure.largest_stable_time_step(3, law_of()))
    assert refusal(lambda: hl.measure.largest_stable_time_step(pair, 3)).startswith("law: got 3")


def packing(n, seed, spread=0.2):
    """Compressed spheres in a periodic box, at rest."""
    limits = 0.5 - 0.5 * spread, 0.5 + 0.5 * spread
    start = hl.ParticleSystem.random(n, 0.6, limits, 6.0 / math.pi, 0.01, seed=seed)
    still = np.zeros_like(start.positions)
    grown = hl.ParticleSystem(
        start.positions, still, 1.03 * start.radius, density=6.0 / math.pi, box=start.box, allowed_overlap=0.1
    )
    law = hl.LinearDashpot(stiffness=1.0, restitution=0.2)
    with pytest.warns(hl.CompressionWarning):
        run = hl.molecular_dynamics(grown, law=law, until=400.0, engine="steps", samples=1, threads=1)
    return run.system


def verlet(system, values, step, steps=200):
    """Kinetic energy after small random velocities, with forces at the velocities of half a step before."""
    ratio, damping_ratio, mu, damping = values
    n, radius, mass, inertia = system.n, system.radius, system.mass[:, None], system.inertia[:, None]
    i, j = np.triu_indices(n, 1)
    x, spring = system.positions.copy(), np.zeros((len(i), 3))
    v, w = 1e-7 * np.random.default_rng(1).standard_normal((2, n, 3))
    for _ in range(steps):
        apart = x[j] - x[i]
        apart -= system.box * np.round(apart / system.box)
        r = np.linalg.norm(apart, axis=1)
        normal, overlap = apart / r[:, None], radius[i] + radius[j] - r
        arm = r / (radius[i] + radius[j])
        a, b = (radius[i] * arm)[:, None], (radius[j] * arm)[:, None]
        g = v[j] - v[i] - np.cross(a * w[i] + b * w[j], normal)
        along = np.einsum("ij,ij->i", g, normal)
        g -= along[:, None] * normal
        force = np.where(overlap > 0.0, np.maximum(overlap - damping * along, 0.0), 0.0)
        spring = np.where((overlap > 0.0)[:, None], spring + step * g, 0.0)
        spring -= np.einsum("ij,ij->i", spring, normal)[:, None] * normal
        rubs = ratio * spring + damping * damping_ratio * g
        rubs *= np.minimum(1.0, mu * force / (np.linalg.norm(rubs, axis=1) + 1e-300))[:, None]
        total, turn = force[:, None] * normal - rubs, np.cross(normal, rubs)
        for body, pull, twist in ((j, total, b * turn), (i, -total, a * turn)):
            np.add.at(v, body, step * pull / mass[body])
            np.add.at(w, body, step * twist / inertia[body])
        x += step * v
    return 0.5 * float((mass * v**2).sum() + (inertia * w**2).sum())


@pytest.mark.parametrize("values", [LAWS["smooth"], slow(LAWS["all"])], ids=str)
def test_velocity_verlet_is_stable_below_and_not_above(values):
    """Within two per cent of the limit, in a packing of unequal grains."""
    system = packing(25, 0)
    step = step_of(system, law_of(*values), tolerance=0.0)
    below, above = (verlet(system, values, factor * step) for factor in (0.98, 1.02))
    assert above > 1e3 * below


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.0001, 0.5])
@pytest.mark.parametrize("name", LAWS)
def test_velocity_verlet_with_every_kind_of_force(name, spread):
    system = packing(50, 1, spread)
    step = step_of(system, law_of(*LAWS[name]), tolerance=0.0)
    below, above = (verlet(system, LAWS[name], factor * step, 400) for factor in (0.98, 1.02))
    assert below < 3e-9 and above > 30.0 * below


@pytest.mark.slow
@pytest.mark.parametrize(
    "values", [*LAWS.values(), (2.0 / 7.0, 1.0, 0.5, 0.36), (1.0, 1.0, 5.0, 1.0)], ids=str
)
def test_our_steps_are_stable_by_default(values):
    """Small random velocities do not grow, also with strong dashpots along the surfaces."""
    system = packing(40, 3)
    velocities = 1e-7 * np.random.default_rng(1).standard_normal(system.positions.shape)
    run = hl.molecular_dynamics(
        system.replace(velocities=velocities),
        law=law_of(*values),
        until=20.0,
        engine="steps",
        samples=4,
        threads=1,
    )
    assert float(run.series.kinetic_energy[-1]) < 1e-10


def kinetic_energy_in_lammps(system, values, step, folder):
    """Kinetic energy per grain after 400 steps from small random velocities."""
    ratio, damping_ratio, mu, damping = values
    rows = "\n".join(
        f"{i} 1 {2 * r:.17g} {m / (math.pi / 0.75 * r**3):.17g} {x:.17g} {y:.17g} {z:.17g}"
        for i, (r, m, (x, y, z)) in enumerate(
            zip(system.radius, system.mass, system.positions, strict=True), 1
        )
    )
    edges = "\n".join(
        f"0 {edge:.17g} {axis}lo {axis}hi" for edge, axis in zip(system.box, "xyz", strict=True)
    )
    (folder / "grains.data").write_text(
        f"#\n\n{system.n} atoms\n1 atom types\n{edges}\n\nAtoms # sphere\n\n{rows}\n"
    )
    across = f"linear_history {ratio} {damping_ratio} {mu}" if ratio else "linear_nohistory 0 0"
    (folder / "in.grains").write_text(f"""units lj
atom_style sphere
newton off
comm_modify vel yes
read_data grains.data
velocity all create 1e-14 1 loop all
pair_style granular
pair_coeff * * hooke 1.0 {damping} damping velocity tangential {across}
neighbor 0.3 bin
neigh_modify delay 0
fix move all nve/sphere
timestep {step:.17g}
run 400
print "energy $(ke)"
""")
    done = subprocess.run(
        LAMMPS.command(1, "-in", "in.grains"),
        cwd=folder, env=LAMMPS.environment(), capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(re.search(r"^energy (\S+)", done.stdout, re.MULTILINE)[1])


@pytest.mark.slow
@pytest.mark.skipif(bool(MISSING), reason=MISSING)
@pytest.mark.parametrize("name", LAWS)
def test_lammps_is_stable_below_and_not_above(name, tmp_path):
    system = packing(50, 2)
    step = step_of(system, law_of(*LAWS[name]), tolerance=0.0)
    below, above = (
        kinetic_energy_in_lammps(system, LAWS[name], factor * step, tmp_path) for factor in (0.95, 1.05)
    )
    assert below < 1e-9 and above > 100.0 * below
