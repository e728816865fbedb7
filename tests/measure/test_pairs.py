"""Structure of states: g(r) against direct sums, freud and theory; coordination of lattices; rattlers."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, lattice, refusal, slow
from hardlimit.boxes import theory
from hardlimit.measure.pairs import _share


def points(n, dimension, boundary, seed, edges=None):
    """An ideal gas: points so small that they do not overlap."""
    rng = np.random.default_rng(seed)
    box = np.array(edges or rng.uniform(1.0, 2.0, dimension))
    at = rng.uniform(1e-9, box - 1e-9, (n, dimension))
    return hl.ParticleSystem(
        at, np.zeros((n, dimension)), 1e-9, 1.0, box=box, boundary=boundary, allowed_overlap=0.999
    )


def boundaries(dimension):
    return st.lists(st.sampled_from(["periodic", "wall"]), min_size=dimension, max_size=dimension)


@st.composite
def systems(draw, unequal=True):
    d = draw(st.sampled_from([2, 3]))
    spread = draw(st.sampled_from([1.0, 3.0])) if unequal else 1.0
    boundary, n, seed = draw(boundaries(d)), draw(st.integers(30, 80)), draw(st.integers(0, 99))
    return lattice(n=n, dimension=d, seed=seed, spread=spread, boundary=boundary)


def distances(system):
    """Distance of each pair, with the nearest images."""
    apart = system.positions[:, None] - system.positions[None]
    periodic = np.array(system.boundary) == "periodic"
    apart -= np.where(periodic, system.box * np.round(apart / system.box), 0.0)
    return np.sqrt((apart**2).sum(-1))[np.triu_indices(system.n, 1)]


@draws(40)
@given(system=systems(), bins=st.integers(1, 40))
def test_rdf_against_the_direct_sum(system, bins):
    """The counts of all pairs, exactly; the normalisation by quadrature over directions, to 1e-9."""
    g = hl.measure.rdf(system, bins=bins)
    r = g.bin_centers.values
    width = r[1] - r[0] if bins > 1 else 2.0 * r[0]
    edges = np.append(r - 0.5 * width, r[-1] + 0.5 * width)
    walls = np.array(system.boundary) == "wall"
    lengths = system.box - np.where(walls, 2.0 * system.radius.mean(), 0.0)
    expected = np.diff(_share(edges, lengths, walls)) * 0.5 * system.n * (system.n - 1)
    counts = np.histogram(distances(system), edges)[0]
    assert g.values * expected == pytest.approx(counts, abs=1e-6)
    assert g.attrs["units"] == "1" and g.bin_centers.attrs["units"] == "m"


@pytest.mark.parametrize("seed", range(12))
def test_structure_of_a_sheared_box_against_direct_sums(seed):
    """Images beyond the sides of the gradient are displaced. Some points lie on the sides themselves."""
    rng = np.random.default_rng(seed)
    d, n = 2 + seed % 2, 60
    box = rng.uniform(1.0, 2.0, d)
    at = rng.uniform(0.0, 1.0, (n, d)) * box
    at[:3, 1] = 0.0, box[1], box[1]
    sides = ("periodic", "lees-edwards", rng.choice(["periodic", "wall"]))[:d]
    at[:, 2:] = np.clip(at[:, 2:], 0.03, box[2:] - 0.03)
    system = hl.ParticleSystem(at, np.zeros((n, d)), 0.03, 1.0, box=box, boundary=sides, shear_rate=1.0,
                               shear_displacement=rng.uniform(0.0, box[0]), allowed_overlap=0.999)  # fmt: skip
    apart = at[:, None] - at[None]
    turns = np.round(apart[..., 1] / box[1])
    apart[..., 1] -= turns * box[1]
    apart[..., 0] -= turns * system.shear_displacement
    wraps = np.array(sides) == "periodic"
    apart -= np.where(wraps, box * np.round(apart / box), 0.0)
    distance = np.linalg.norm(apart, axis=2)
    g = hl.measure.rdf(system, bins=8)
    edges = np.linspace(0.0, g.bin_centers.values[0] * 16, 9)
    walls = np.array(sides) == "wall"
    expected = 0.5 * n * (n - 1) * np.diff(_share(edges, box - np.where(walls, 0.06, 0.0), walls))
    assert g.values * expected == pytest.approx(
        np.histogram(distance[np.triu_indices(n, 1)], edges)[0], abs=1e-6
    )
    contacts = hl.measure.coordination(system, tolerance=0.5).contacts.values
    on_walls = sum((np.abs(at[:, 2] - end) <= 0.045).astype(int) for end in (0.0, box[2])) if walls[-1] else 0
    assert (contacts == (distance <= 0.09).sum(axis=1) - 1 + on_walls).all()
    assert float(hl.measure.profiles(system, "y").packing_fraction.mean()) == pytest.approx(
        system.packing_fraction
    )
    moving = system.replace(velocities=rng.normal(size=(n, d)) + system.domain.mean_flow(at))
    assert float(hl.measure.granular_temperature(moving)) == pytest.approx(moving.granular_temperature)


@pytest.mark.parametrize("walled", [(0, 0), (1, 0), (1, 1), (0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1)])
def test_share_of_pairs_against_quadrature(walled):
    """d share/dr is the surface of a sphere times the mean of the product over random directions: Monte Carlo, 4 σ."""
    d, rng = len(walled), np.random.default_rng(1)
    lengths, walls = np.array([1.0, 1.3, 0.9][:d]), np.array(walled, bool)
    n = rng.normal(size=(200_000, d))
    n = np.abs(n / np.linalg.norm(n, axis=1)[:, None])
    for r in (0.2, 0.85):
        inside = np.prod(np.where(walls, 1.0 - r * n / lengths, 1.0), axis=1)
        slope = (
            _share(np.array(r + 1e-4), lengths, walls) - _share(np.array(r - 1e-4), lengths, walls)
        ) / 2e-4
        surface = {2: 2.0 * math.pi * r, 3: 4.0 * math.pi * r * r}[d] / lengths.prod()
        error = inside.std() / math.sqrt(len(n))
        assert abs(slope / surface - inside.mean()) < 4.0 * error + 1e-7


@pytest.mark.parametrize("walled", ["pp", "wp", "ww", "ppp", "pwp", "wpw", "www"])
def test_an_ideal_gas_gives_one_also_between_walls(walled):
    """Mean of 60 boxes with 150 points in 12 bins up to the limit: within 4.5 standard errors of 1, some 1 % each."""
    boundary = [{"p": "periodic", "w": "wall"}[side] for side in walled]
    edges = [1.0, 1.3, 0.9][: len(walled)]
    limit = min(edge if side == "wall" else 0.5 * edge for edge, side in zip(edges, boundary, strict=True))
    boxes = (points(150, len(walled), boundary, seed, edges) for seed in range(60))
    densities = np.array([hl.measure.rdf(box, bins=12, r_max=limit * (1.0 - 1e-8)) for box in boxes])
    assert np.all(np.abs(densities.mean(0) - 1.0) < 4.5 * densities.std(0, ddof=1) / math.sqrt(60))
    assert np.all(np.abs(densities.mean(0)[2:] - 1.0) < 0.04)


def test_rdf_against_freud():
    """freud.density.RDF of periodic boxes, to 1e-5; its distances are in single precision, so that a pair may be in the
    next bin."""
    freud = pytest.importorskip("freud")
    for d in (2, 3):
        system = hl.ParticleSystem.random(400, 0.3, (0.8e-3, 1.2e-3), 2500.0, 1.0, dimension=d, seed=d)
        edge = float(system.box[0])
        at = np.zeros((system.n, 3))
        at[:, :d] = system.positions / edge - 0.5
        box = freud.box.Box.square(1.0) if d == 2 else freud.box.Box.cube(1.0)
        rdf = freud.density.RDF(bins=37, r_max=0.45, normalization_mode="finite_size")
        rdf.compute((box, at))
        g = hl.measure.rdf(system, bins=37, r_max=0.45 * edge)
        assert g.bin_centers.values / edge == pytest.approx(rdf.bin_centers, rel=1e-6)
        different = np.abs(g.values - rdf.rdf) > 1e-5 * g.values
        assert different.sum() <= 2 and g.values == pytest.approx(rdf.rdf, rel=0.02)


@pytest.mark.parametrize("d, packing_fraction", [slow(3, 0.1), slow(3, 0.3), (2, 0.4)])
def test_contact_value_of_a_fluid(d, packing_fraction):
    """g(d+) from bins, χ from the collision rate, and Carnahan–Starling's or Henderson's χ (errors 0.3 and 1 %, and
    O(1/N)) agree within 4 standard errors."""
    start = hl.ParticleSystem.random(500, packing_fraction, 1e-3, 2500.0, 1.0, dimension=d, seed=3)
    fluid = hl.event_driven(start, restitution=1.0, max_collisions=15_000).system
    # Half of the free bins: g falls off steeply, and a parabola in r fits its logarithm.
    look = partial(hl.measure.rdf, r_min=2e-3, r_max=2.4e-3, bins=8)
    until = fluid_time(fluid, 60.0)
    run = hl.event_driven(fluid, restitution=1.0, until=until, samples=120, observe={"rdf": look})
    chi = hl.measure.contact_value(run)
    blocks = run.series.rdf.values[1:].reshape(10, 12, 8).mean(axis=1)
    x = run.series.bin_centers.values / 2e-3 - 1.0
    limits = [math.exp(np.polyfit(x, np.log(block), 2)[-1]) for block in blocks]
    limit, error = np.mean(limits), np.std(limits, ddof=1) / math.sqrt(10)
    exact = theory.gas(fluid).contact_value
    assert chi.mean.error < 0.015 * exact and error < 0.03 * exact
    assert abs(chi.mean.value - exact) < 4.0 * chi.mean.error + (0.01 if d == 2 else 0.004) * exact
    assert abs(limit - chi.mean.value) < 4.0 * math.hypot(error, chi.mean.error)


def fluid_time(system, collisions):
    """Time in which a particle collides so often [s]."""
    return collisions / float(theory.gas(system).collision_rate(system.granular_temperature))


def test_contact_value_is_refused_where_it_means_nothing():
    walled = hl.event_driven(lattice(boundary="wall"), restitution=1.0, until=1e-3, samples=5)
    assert "must be of equal particles in a periodic box" in refusal(lambda: hl.measure.contact_value(walled))
    still = lattice().replace(velocities=np.zeros((27, 3)))
    run = hl.event_driven(still, restitution=1.0, until=1.0, samples=5)
    assert refusal(lambda: hl.measure.contact_value(run)).startswith(
        "run: got a system without relative motion"
    )
    assert refusal(lambda: hl.measure.contact_value(3)).startswith("run: got 3")


# --- contacts -----------------------------------------------------------------------------------------------


def crystal(basis, cells, edges, boundary="periodic", radius=0.5, shift=0.0):
    """A lattice with this basis, in units of the cell's edges."""
    d = len(edges)
    corners = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), -1).reshape(-1, 1, d)
    at = ((corners + np.array(basis)).reshape(-1, d)) * edges + shift
    return hl.ParticleSystem(at, 0.0 * at, radius, 1.0, box=np.array(cells) * edges, boundary=boundary)


FCC = [(0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)]
LATTICES = {
    "cubic": (crystal([(0, 0, 0)], (4, 4, 4), [1.0] * 3), 6),
    "bcc": (crystal([(0, 0, 0), (0.5, 0.5, 0.5)], (3, 3, 3), [2.0 / math.sqrt(3.0)] * 3), 8),
    "fcc": (crystal(FCC, (3, 3, 3), [math.sqrt(2.0)] * 3), 12),
    "square": (crystal([(0, 0)], (5, 4), [1.0, 1.0]), 4),
    "hexagonal": (crystal([(0, 0), (0.5, 0.5)], (4, 3), [1.0, math.sqrt(3.0)]), 6),
    "cubic between walls": (crystal([(0.5, 0.5, 0.5)], (4, 4, 4), [1.0] * 3, "wall"), 6),
}


@pytest.mark.parametrize("name", LATTICES)
def test_coordination_of_lattices(name):
    system, neighbours = LATTICES[name]
    contacts = hl.measure.coordination(system)
    assert (
        contacts.contacts == neighbours
    ).all() and contacts.coordination == neighbours == contacts.backbone_coordination
    assert contacts.rattlers == 0.0 and not contacts.rattler.any() and contacts.contacts.attrs["units"] == "1"
    apart = hl.measure.coordination(system.replace(radius=0.499))
    assert apart.coordination == 0.0 and apart.rattlers == 1.0 and np.isnan(apart.backbone_coordination)
    assert hl.measure.coordination(system.replace(radius=0.499), tolerance=3e-3).coordination == neighbours


def test_rattlers_are_removed_repeatedly():
    """Between walls a block of disks holds; a disk in a hollow of it has two contacts, three with one more on top. A
    block without walls comes apart from its corners."""
    block = crystal([(0.5, 0.5)], (4, 4), [1.0, 1.0]).positions
    hollow = [1.0, 3.5 + math.sqrt(0.75)]
    at = np.vstack([block, [hollow, np.add(hollow, [0.0, 1.0])]])
    contacts = hl.measure.coordination(
        hl.ParticleSystem(at, 0.0 * at, 0.5, 1.0, box=[4.0, 6.0], boundary="wall")
    )
    assert contacts.contacts.values[16:].tolist() == [3, 1]
    assert contacts.rattler.values.tolist() == [False] * 16 + [True] * 2
    # Three rows of four have 4 contacts, the upper row has 3; two of it have one more with the disk in the hollow.
    assert (
        contacts.backbone_coordination == (12 * 4 + 4 * 3) / 16
        and contacts.coordination == (12 * 4 + 4 * 3 + 2 + 4) / 18
    )
    free = hl.measure.coordination(hl.ParticleSystem(block + 4.0, 0.0 * block, 0.5, 1.0, box=20.0))
    assert free.contacts.max() == 4 and free.rattlers == 1.0


@draws(30)
@given(system=systems(), tolerance=st.floats(0.0, 1.0))
def test_contacts_against_the_direct_sum(system, tolerance):
    contacts = hl.measure.coordination(system, tolerance=tolerance)
    first, second = np.triu_indices(system.n, 1)
    near = distances(system) <= (1.0 + tolerance) * (system.radius[first] + system.radius[second])
    counts = np.bincount(np.concatenate([first[near], second[near]]), minlength=system.n)
    for axis, side in enumerate(system.boundary):
        x = system.positions[:, axis]
        for gap in (x - system.radius, system.box[axis] - x - system.radius) if side == "wall" else ():
            counts += gap <= tolerance * system.radius
    assert np.array_equal(contacts.contacts, counts)
    backbone = counts[~contacts.rattler.values]
    assert len(backbone) == 0 or backbone.min() >= system.dimension + 1


@pytest.mark.parametrize("seed", range(8))
def test_a_neighbour_counts_once_in_a_sheared_box(seed):
    """Also where it and an image of it are both near, in a box of five radii: against all images."""
    rng = np.random.default_rng(seed)
    n, d = 12, 2 + seed % 2
    box = np.array([0.8, 0.5, 0.8])[:d]
    at, shift = rng.uniform(0.0, 1.0, (n, d)) * box, rng.uniform(0.0, box[0])
    sides = ("periodic", "lees-edwards", "periodic")[:d]
    system = hl.ParticleSystem(at, np.zeros((n, d)), 0.1, 1.0, box=box, boundary=sides, shear_rate=1.0,
                               shear_displacement=shift, allowed_overlap=0.9999)  # fmt: skip
    turns = np.stack(np.meshgrid(*[[-1, 0, 1]] * d, indexing="ij"), -1).reshape(-1, d)
    images = turns * box + np.where(np.arange(d) == 0, turns[:, 1:2] * shift, 0.0)
    images = np.concatenate([images, images + box * (np.arange(d) == 0), images - box * (np.arange(d) == 0)])
    apart = np.linalg.norm(at[:, None, None] - at[None, :, None] - images, axis=-1)
    for tolerance in (0.5, 1.0):
        near = (apart <= 0.2 * (1.0 + tolerance)).any(axis=-1) & ~np.eye(n, dtype=bool)
        assert (hl.measure.coordination(system, tolerance=tolerance).contacts == near.sum(axis=1)).all()


def test_walls_that_move_count_where_they_are():
    """A wall that is 1 mm inside the box is the same as a shorter box."""
    moved = lattice(boundary=["periodic", "periodic", "wall"]).replace(radius=0.5e-3)
    shorter = moved.replace(box=moved.box - [0.0, 0.0, 1e-3], positions=moved.positions * [1.0, 1.0, 0.85])
    walls = {"z+": hl.MovingWall(velocity=1.0, offset=-1e-3)}
    moved = moved.replace(positions=shorter.positions, walls=walls)
    assert hl.measure.coordination(moved, tolerance=1.0).identical(
        hl.measure.coordination(shorter, tolerance=1.0)
    )
    assert hl.measure.rdf(moved).values == pytest.approx(hl.measure.rdf(shorter).values, rel=1e-12)
    out = moved.replace(
        walls={"z+": hl.MovingWall(velocity=1.0, offset=1e-3)},
        positions=moved.positions + np.array([0.0, 0.0, 2e-3]),
    )
    assert float(hl.measure.profiles(out, "z").number_density.mean() * np.prod(out.box)) == pytest.approx(
        out.n
    )


def test_what_is_outside_the_range_is_refused():
    system = lattice(boundary=["wall", "periodic", "periodic"])
    limit = 0.5 * system.box[1]
    assert "r_max: got" in refusal(lambda: hl.measure.rdf(system, r_max=1.001 * limit))
    for bounds in ({"r_max": 1e-200}, {"r_min": 2e-3, "r_max": math.nextafter(2e-3, 1.0)}):
        assert "every bin has a volume" in refusal(lambda at=bounds: hl.measure.rdf(system, **at))
    hl.measure.rdf(system, r_max=limit)
    walls = lattice(boundary="wall")
    assert "r_max: got" in refusal(lambda: hl.measure.rdf(walls, r_max=float(walls.box[0])))
    hl.measure.rdf(walls, r_max=float(walls.box[0]) - 2e-3)
    assert refusal(lambda: hl.measure.rdf(system, bins=0)).startswith("bins: got 0")
    assert refusal(lambda: hl.measure.rdf(3)).startswith("system: got 3")
    assert refusal(lambda: hl.measure.rdf(lattice(n=1))).startswith("system: got one particle")
    assert refusal(lambda: hl.measure.coordination(system, tolerance=-1.0)).startswith("tolerance: got -1,")
