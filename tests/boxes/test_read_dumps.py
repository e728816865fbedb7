"""Systems from dumps of LAMMPS and LIGGGHTS and from OVITO's extended XYZ: what they contain, and one-line refusals."""

import gzip
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, lattice, refusal

DATA, EXAMPLES = Path(__file__).parent / "data" / "dumps", Path(__file__).parents[2] / "examples"
FACTS = tomllib.loads((DATA / "dumps.toml").read_text())
#: What the recorded dumps do not say. LAMMPS prints the rotational energy of solid spheres, also in two dimensions.
MISSING = {
    "dump.bed": {"density": 2500.0},
    "sheared.lammps.gz": {"shear_rate": 2.0},
    "disks.lammps.gz": {"inertia_factor": 0.4},
}
#: Units of energy [J].
ENERGY = {"si": 1.0, "cgs": 1e-7, "lj": 1.0, "micro": 1e-15}


def recorded(name):
    """A recorded dump; some are examples."""
    return next(folder / name for folder in (DATA, EXAMPLES) if (folder / name).exists())


def read(name, **options):
    units = {} if "gas" in name else {"units": FACTS[name]["units"]}  # that dump names them
    return hl.ParticleSystem.read(
        recorded(name), **({"allowed_overlap": 0.4} | units | MISSING.get(name, {}) | options)
    )


@pytest.mark.parametrize("name", FACTS)
def test_energies_and_contacts_are_those_that_the_program_printed(name):
    facts = FACTS[name]
    accuracy = {"dump.bed": 1e-5, "bed.liggghts": 1e-5, "disks.lammps.gz": 1e-5}.get(name, 1e-9)
    for k, (kinetic, rotational) in enumerate(zip(facts["kinetic"], facts["rotational"], strict=True)):
        system = read(name, frame=k)
        unit = ENERGY[facts["units"]]
        assert system.kinetic_energy == pytest.approx(kinetic * unit, rel=accuracy)
        if system.angular_velocities is not None:
            assert system.rotational_energy == pytest.approx(rotational * unit, rel=accuracy)
        touching = hl.measure.coordination(system).contacts.sum() - at_walls(system)
        assert abs(touching - facts["contacts"][k]) <= (2 if name == "dump.bed" else 0)  # has six digits


def at_walls(system):
    """Contacts of grains with walls."""
    return sum(
        int(
            (np.minimum(system.positions[:, k], system.box[k] - system.positions[:, k]) < system.radius).sum()
        )
        for k, side in enumerate(system.boundary)
        if side == "wall"
    )


def test_frames_one_after_the_other():
    name, options = "dump.gas.gz", {"allowed_overlap": 0.4}
    frames = hl.ParticleSystem.read_frames(recorded(name), **options)
    assert iter(frames) is frames
    assert (
        list(frames) == [read(name, frame=k) for k in range(3)] == [read(name, frame=k) for k in (-3, -2, -1)]
    )
    for frame in (3, -4):
        with pytest.raises(ValueError, match=rf"frame: got {frame}, must be in \[-3, 2\]"):
            read(name, frame=frame)
    at = [
        float(hl.measure.granular_temperature(system))
        for system in hl.ParticleSystem.read_frames(recorded(name), **options)
    ]
    assert at[0] > at[1] > at[2]


@pytest.mark.parametrize("suffix", [".xyz", ".gsd"])
def test_frames_of_other_formats(suffix, tmp_path):
    from hardlimit.boxes import files

    systems = [lattice(8, seed=k) for k in range(3)]
    path = files.write(tmp_path / f"run{suffix}", (system.as_frame(k) for k, system in enumerate(systems)))
    assert list(hl.ParticleSystem.read_frames(path)) == systems


# --- any columns ----------------------------------------------------------------------------------------------


def dumped(system, columns, rng, sides=None, low=(0.0, 0.0, 0.0), digits=17, step=0, tilt=None):
    """A frame of a dump: its grains are shuffled, their ids have gaps, its box begins anywhere."""
    n, d = system.n, system.dimension
    edges = np.array([*system.box, 1.0][:3])
    low = np.array(low)
    ids = np.sort(rng.choice(10 * n, n, replace=False)) + 1
    at = np.zeros((n, 3))
    at[:, :d] = system.positions
    lengths = dict(zip(("xy", "xz", "yz"), tilt or (0.0, 0.0, 0.0), strict=True))
    shares = at / edges
    shares[:, 0] -= (lengths["xy"] * at[:, 1] / edges[1] + lengths["xz"] * at[:, 2] / edges[2]) / edges[0]
    turns = rng.integers(-2, 3, (n, 3)) * np.array(
        [side == "periodic" for side in (*system.boundary, "wall")[:3]]
    )
    if tilt:  # as LAMMPS folds them into the tilted box
        shares[:, 0] %= 1.0
        at[:, 0] = (
            shares[:, 0] * edges[0]
            + lengths["xy"] * at[:, 1] / edges[1]
            + lengths["xz"] * at[:, 2] / edges[2]
        )
    values = {"id": ids, "type": 1 + np.arange(n) % 2, "radius": system.radius, "diameter": 2 * system.radius}
    values |= {
        "mass": system.mass,
        "density": system.density,
        "c_1[2]": rng.normal(size=n),
        "fx": rng.normal(size=n),
    }
    spins = np.zeros((n, 3)) if system.angular_velocities is None else system.angular_velocities
    spins = spins if spins.ndim == 2 else np.column_stack([np.zeros((n, 2)), spins])
    speeds = np.zeros((n, 3))
    speeds[:, :d] = system.velocities
    for k, axis in enumerate("xyz"):
        values |= {f"v{axis}": speeds[:, k], f"omega{axis}": spins[:, k]}
        values |= {f"angmom{axis}": spins[:, k] * system.inertia}
        values |= {axis: low[k] + at[:, k], f"{axis}u": low[k] + at[:, k] + turns[:, k] * edges[k]}
        values |= {f"{axis}s": shares[:, k], f"{axis}su": shares[:, k] + turns[:, k]}
    rows = [" ".join(f"{values[name][i]:.{digits}g}" for name in columns) for i in rng.permutation(n)]
    words = " ".join(sides or [{"wall": "ff"}.get(side, "pp") for side in (*system.boundary, "periodic")[:3]])
    high = low + edges
    if tilt:
        low, high = low.copy(), high.copy()
        low[0] += min(0.0, *tilt)
        high[0] += max(0.0, *tilt)
    ends = [f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True)]
    if tilt:
        words, ends = f"xy xz yz {words}", [f"{end} {t!r}" for end, t in zip(ends, tilt, strict=True)]
    head = ["ITEM: TIMESTEP", str(step), "ITEM: NUMBER OF ATOMS", str(n), f"ITEM: BOX BOUNDS {words}", *ends]
    return "\n".join([*head, f"ITEM: ATOMS {' '.join(columns)} ", *rows, ""])


def written(folder, content, name="dump.box"):
    path = folder / name
    path.write_bytes(gzip.compress(content.encode()) if name.endswith(".gz") else content.encode())
    return path


@st.composite
def states(draw):
    """A system, columns that describe it, and what of it they lack."""
    d = draw(st.sampled_from([2, 3]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    sides = [draw(st.sampled_from(["periodic", "wall"])) for _ in range(d)]
    spinning = draw(st.sampled_from(["omega", "angmom", None]))
    system = lattice(draw(st.integers(1, 20)), d, draw(st.integers(0, 2**32)), 3.0, boundary=sides)
    if spinning:
        system = system.replace(angular_velocities=rng.normal(size=(system.n, 3) if d == 3 else system.n))
    places = draw(st.sampled_from(["{}", "{}s", "{}u", "{}su"]))
    axes = "xyz"[: d if draw(st.booleans()) else 3]
    columns = ["id", *(places.format(axis) for axis in axes), *(f"v{axis}" for axis in axes)]
    columns += [f"{spinning}{axis}" for axis in "xyz"] if spinning else []
    size, mass = (
        draw(st.sampled_from(["radius", "diameter", None])),
        draw(st.sampled_from(["mass", "density", None])),
    )
    columns += [name for name in (size, mass) if name]
    lacks = {} if size else {"radius": system.radius}
    lacks |= {} if mass else {"density": system.density}
    columns += draw(st.lists(st.sampled_from(["type", "fx", "c_1[2]"]), unique=True))
    low = [draw(st.sampled_from([0.0, -1.0, 0.125])) for _ in range(d)] + [0.0] * (3 - d)
    return system, list(rng.permutation(columns)), lacks, low, rng


@draws(200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(states(), st.sampled_from(["dump.1", "box.lammpstrj", "grains.gz"]))
def test_any_columns(tmp_path, state, name):
    system, columns, lacks, low, rng = state
    path = written(tmp_path, dumped(system, columns, rng, low=low), name)
    back = hl.ParticleSystem.read(path, **lacks)
    assert back.boundary == system.boundary and back.dimension == system.dimension
    apart = back.positions - system.positions
    wraps = np.array(system.domain.wraps)
    apart -= np.where(wraps, system.box * np.round(apart / system.box), 0.0)
    assert np.abs(apart).max() < 1e-13
    assert back.velocities == pytest.approx(np.asarray(system.velocities), rel=1e-15)
    for name_of in ("radius", "mass", "box", "density"):
        assert getattr(back, name_of) == pytest.approx(np.asarray(getattr(system, name_of)), rel=1e-12), (
            name_of
        )
    if system.angular_velocities is None:
        assert back.angular_velocities is None
    else:
        assert back.angular_velocities == pytest.approx(np.asarray(system.angular_velocities), rel=1e-12)


@draws(60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**32), st.sampled_from([1, 2]), st.sampled_from(["{}", "{}s"]), st.booleans())
def test_a_tilted_box_is_that_of_lees_and_edwards(tmp_path, seed, gradient, places, flips):
    rng = np.random.default_rng(seed)
    system = lattice(27, 3, seed % 1000, 2.0)
    sides = ["periodic"] * 3
    sides[gradient] = "lees-edwards"
    shift = float(rng.uniform(0.0, system.box[0]))
    system = system.replace(boundary=sides, shear_rate=5.0, shear_displacement=shift)
    system = system.replace(velocities=0.01 * system.velocities + system.domain.mean_flow(system.positions))
    tilt = [0.0, 0.0, 0.0]
    tilt[gradient - 1] = shift - (float(system.box[0]) if flips else 0.0)
    columns = ["id", *map(places.format, "xyz"), "vx", "vy", "vz", "radius", "mass"]
    path = written(tmp_path, dumped(system, columns, rng, low=(0.5, 0.0, -1.0), tilt=tilt))
    back = hl.ParticleSystem.read(path, shear_rate=5.0)
    assert back.boundary == system.boundary and back.shear_rate == 5.0
    assert math.remainder(back.shear_displacement - shift, system.box[0]) == pytest.approx(0.0, abs=1e-14)
    apart = back.positions - system.positions
    assert np.abs(apart - system.box * np.round(apart / system.box)).max() < 1e-13
    assert back.velocities == pytest.approx(np.asarray(system.velocities), rel=1e-12)
    assert back.granular_temperature == pytest.approx(system.granular_temperature, rel=1e-9)


HEAD = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS {}\n{}\nITEM: ATOMS {}\n{}\n"
CUBE = "0 0.1\n0 0.1\n0 0.1"
COLUMNS = "id x y z vx vy vz radius density"


def frame(*rows, columns=COLUMNS, sides="pp pp pp", box=CUBE):
    """A frame of a few grains."""
    return HEAD.format(len(rows), sides, box, columns, "\n".join(rows))


TWO = frame("1 .05 .05 .02 1 0 0 .005 1", "2 .05 .05 .08 0 1 0 .005 1")


def test_a_grain_just_beyond_the_gradient_has_the_velocity_of_its_image(tmp_path):
    """LAMMPS changes the velocity when it folds the grain back, not before."""
    tilted = {"sides": "xy xz yz pp pp pp", "box": "0 0.12 0.02\n0 0.1 0\n0 0.1 0"}
    path = written(tmp_path, frame("1 0.05 0.101 0.05 1 2 3 0.005 1", **tilted))
    system = hl.ParticleSystem.read(path, shear_rate=3.0)
    assert system.positions[0] == pytest.approx([0.03, 0.001, 0.05])
    assert system.velocities[0] == pytest.approx([1.0 - 0.3, 2.0, 3.0])
    assert system.box == pytest.approx([0.1] * 3) and system.shear_displacement == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("units", "length", "mass", "time"),
    [
        ("lj", 1, 1, 1),
        ("si", 1, 1, 1),
        ("cgs", 1e-2, 1e-3, 1),
        ("micro", 1e-6, 1e-15, 1e-6),
        ("nano", 1e-9, 1e-21, 1e-9),
    ],
)
@pytest.mark.parametrize("named", [False, True])
def test_units(units, length, mass, time, named, tmp_path):
    content = frame(
        "4 0.01 0.02 0.03 1 2 3 7 8 9 0.005 2", columns="id x y z vx vy vz omegax omegay omegaz radius mass"
    )
    path = written(
        tmp_path, (f"ITEM: UNITS\n{units}\nITEM: TIME\n0.5\n" if named else "") + content + content
    )
    system = hl.ParticleSystem.read(path, **({} if named else {"units": units}), gravity=9.81)
    assert system.positions[0] == pytest.approx(length * np.array([0.01, 0.02, 0.03]))
    assert system.velocities[0] == pytest.approx(length / time * np.array([1.0, 2.0, 3.0]))
    assert system.angular_velocities[0] == pytest.approx(np.array([7.0, 8.0, 9.0]) / time)
    assert (system.radius[0], system.mass[0], system.gravity[2]) == pytest.approx(
        (0.005 * length, 2 * mass, -9.81)
    )
    if named:
        other = "cgs" if units == "lj" else "lj"
        assert f"units: got '{other}', must be left out: the file is in {units} units" in refused(
            path, units=other
        )
        assert hl.ParticleSystem.read(path, units=units, gravity=9.81) == system


def test_angular_momenta_in_other_units(tmp_path):
    """ω = L/(q m R²), with everything in the units of the file."""
    columns = "id x y z vx vy vz angmomx angmomy angmomz radius mass"
    path = written(
        tmp_path, frame("4 0.01 0.02 0.03 1 2 3 0 0 8 0.5 2", columns=columns, box="0 9\n0 9\n0 9")
    )
    for units, time in (("cgs", 1.0), ("micro", 1e-6)):
        system = hl.ParticleSystem.read(path, units=units)
        assert system.angular_velocities[0] == pytest.approx([0.0, 0.0, 8.0 / (0.4 * 2.0 * 0.25) / time])
        other = hl.ParticleSystem.read(path, units=units, inertia_factor=0.5)
        assert other.angular_velocities[0, 2] == pytest.approx(64.0 / 2 / time)


@pytest.mark.parametrize(
    ("row", "sides", "dimension"),
    [
        ("0 1 2 0 0 0 0", "pp pp pp", 2),
        ("0 1 2 3 0 0 0", "pp pp pp", 3),  # leaves the plane
        ("0 1 2 0 0 5 0", "pp pp pp", 3),  # spins about y
        ("0.001 1 2 0 0 0 0", "pp pp pp", 3),
        ("0 1 2 0 0 0 0", "pp pp ff", 3),
    ],
)
def test_disks_are_at_rest_in_their_plane(row, sides, dimension, tmp_path):
    columns = "id x y z vx vy vz omegax omegay omegaz radius density"
    content = frame(f"1 .05 .05 {row} .005 1", columns=columns, sides=sides, box="0 .1\n0 .1\n-.05 .05")
    system = hl.ParticleSystem.read(written(tmp_path, content))
    assert system.dimension == dimension
    assert system.angular_velocities.ndim == dimension - 1


def test_sizes_by_type(tmp_path):
    path = written(
        tmp_path, frame("9 2 .05 .05 .05 0 0 0", "3 1 .02 .02 .02 0 0 0", columns="id type x y z vx vy vz")
    )
    system = hl.ParticleSystem.read(path, radius={1: 0.001, 2: 0.002}, density={"1": 2500, "2": 1000.0})
    assert system.radius.tolist() == [0.001, 0.002] and system.density == pytest.approx([2500.0, 1000.0])
    assert "radius: got no value for type 2, must have one for each" in refused(
        path, radius={1: 0.001}, density=1.0
    )
    assert "radius: got 1 values, must be 2" in refused(path, radius=[0.1], density=1.0)


def test_contents_may_lie_outside_or_touch_within_the_digits(tmp_path):
    """Grains beyond a periodic side, and two whose distance is rounded to six digits."""
    rows = ["1 -0.0123456 0.05 0.05 0 0 0 0.001 1", "2 0.0896544 0.05 0.05 0 0 0 0.00100001 1"]
    path = written(tmp_path, frame(*rows))
    system = hl.ParticleSystem.read(path)
    assert system.positions[:, 0] == pytest.approx([0.0876544, 0.0896544])
    deeper = rows[1].replace("0.0896544", "0.0896539")
    assert "particles 0 and 1 overlap" in refused(written(tmp_path, frame(rows[0], deeper)))


def test_structure_without_velocities(tmp_path):
    """As LAMMPS' dump atom has it."""
    system = lattice(27, 3, 1)
    path = written(tmp_path, dumped(system, ["id", "type", "xs", "ys", "zs"], np.random.default_rng(1)))
    still = hl.ParticleSystem.read(path, velocities=0, radius=system.radius, density=2500.0)
    assert not still.velocities.any()
    assert hl.measure.rdf(still, bins=20).values == pytest.approx(hl.measure.rdf(system, bins=20).values)
    assert "velocities: missing in the file; velocities= gives it" in refused(path, radius=1.0, density=1.0)


@pytest.mark.parametrize(
    "columns", ["x y z ix iy iz", "xu yu zu", "xsu ysu zsu", "xs ys zs ix iy iz", "x y z xu yu zu"]
)
def test_unfolded_paths(columns, tmp_path):
    """Displacements through periodic sides count; walls around each frame do not shift one against the other."""
    first = {"x": 0.09, "y": 0.05, "z": 0.05, "xs": 0.9, "ys": 0.5, "zs": 0.5}
    last = first | {"x": 0.02, "xs": 0.2, "z": 0.001, "zs": 0.01}  # in the lower wall
    rows = []
    for values, turns in ((first, 0), (last, 3)):
        images = {"ix": turns, "iy": 0, "iz": 0}
        unfolded = {axis + "u": values[axis] + 0.1 * images[f"i{axis}"] for axis in "xyz"}
        shares = {axis + "su": values[f"{axis}s"] + images[f"i{axis}"] for axis in "xyz"}
        known = values | images | unfolded | shares
        rows.append(" ".join(["1", *(repr(known[name]) for name in columns.split()), "0 0 0 0.005 1"]))
    content = "".join(frame(row, columns=f"id {columns} vx vy vz radius density") for row in rows)
    path = written(tmp_path, content)
    for boundary in (None, ["periodic", "wall", "wall"]):
        systems = list(hl.ParticleSystem.read_frames(path, boundary=boundary))
        assert [system.positions[0, 0] for system in systems] == pytest.approx([0.09, 0.02])
        walked = systems[1].unfolded_positions - systems[0].unfolded_positions
        assert walked[0] == pytest.approx([0.23, 0.0, -0.049], abs=1e-12)


# --- walls ----------------------------------------------------------------------------------------------------


def test_walls_around_a_state(tmp_path):
    """They stand at the sides of the box, or where the outermost grains end."""
    path = written(tmp_path, frame("1 .05 .05 0.002 0 0 1 0.005 1", "2 .05 .05 .05 0 0 0 0.005 1"))
    assert hl.ParticleSystem.read(path).boundary == ("periodic",) * 3
    sides = ["periodic", "periodic", "wall"]
    system = hl.ParticleSystem.read(path, boundary=sides, gravity=9.81)
    assert system.boundary == tuple(sides) and system.gravity.tolist() == [0.0, 0.0, -9.81]
    assert system.box == pytest.approx([0.1, 0.1, 0.103]) and system.positions[:, 2] == pytest.approx(
        [0.005, 0.053]
    )
    run = hl.event_driven(system, restitution=0.5, until=0.01)
    assert run.outcome == "ok"
    again = hl.ParticleSystem.read(system.write(tmp_path / "box.xyz"), boundary="wall", gravity=0.0)
    assert (
        again.boundary == ("wall",) * 3 and not again.gravity.any() and again.box == pytest.approx(system.box)
    )


def test_a_box_that_shrinks_to_its_grains_has_no_walls(tmp_path):
    rows = ["1 .05 .05 0.0 0 0 0 0.005 1", "2 .05 .05 .1 0 0 0 0.005 1"]
    path = written(tmp_path, frame(*rows, sides="pp pp fs"))
    assert "boundary: got the sides fs along z, where the box shrinks to its particles" in refused(path)
    assert "got the sides fs along z" in refused(path, boundary="periodic")
    system = hl.ParticleSystem.read(path, boundary=["periodic", "periodic", "wall"])
    assert system.box == pytest.approx([0.1, 0.1, 0.11]) and system.positions[:, 2] == pytest.approx(
        [0.005, 0.105]
    )


def test_a_grain_in_a_wall_is_named(tmp_path):
    path = written(tmp_path, frame("1 .05 .05 0.0049 0 0 0 0.005 1", sides="pp pp ff"))
    message = refused(path)
    assert (
        "positions[0]: got z = 0.0049, must be in [" in message and "allowed_overlap= accepts more" in message
    )
    assert hl.ParticleSystem.read(path, allowed_overlap=0.03).boundary[2] == "wall"
    assert "allowed_overlap" not in refused(
        written(tmp_path, frame("1 .05 .05 0.2 0 0 0 0.005 1", sides="pp pp ff"))
    )


def test_frames_without_grains_do_not_count(tmp_path):
    """A pour begins with them."""
    empty = frame().replace("radius density\n\n", "radius density\n")
    path = written(tmp_path, empty + TWO + empty + frame("1 .05 .05 .05 0 0 0 .005 1"))
    assert [system.n for system in hl.ParticleSystem.read_frames(path)] == [2, 1]
    assert [hl.ParticleSystem.read(path, frame=k).n for k in (0, 1, -1, -2)] == [2, 1, 1, 2]
    law = hl.LinearDashpot(stiffness=1e3, restitution=0.9)
    assert len(hl.check(hl.Ball(5e-3, density=1.0), law=law, dump=path).states) == 2


# --- refusals -------------------------------------------------------------------------------------------------


def refused(path, **options):
    message = refusal(lambda: hl.ParticleSystem.read(path, **options))
    assert path.name in message and len(message) < 450, message
    return message


RATE = {"shear_rate": 1.0}


def tilted(*ends, columns="x y z"):
    """The two grains in a box with other limits."""
    content = TWO.replace("pp pp pp", "xy xz yz pp pp pp").replace("x y z vx", f"{columns} vx")
    return content.replace(CUBE, "\n".join(ends))


BAD = {
    "no velocities": (
        frame("1 .05 .05 .05", columns="id x y z"),
        {},
        "velocities: missing in the file; velocities= gives",
    ),
    "no places": (frame("1 0 0 0", columns="id vx vy vz"), {}, "must have the columns x y z"),
    "no radius": (TWO.replace("radius", "q"), {}, "radius: missing in the file; radius= gives it"),
    "no density": (TWO.replace("density", "q"), {}, "density: missing in the file; density= gives it"),
    "velocities twice": (TWO, {"velocities": 0}, "velocities: got array([[0., 0., 0.]"),
    "velocities of one": (
        TWO.replace("vx", "q"),
        {"velocities": [[0, 0, 0]]},
        "velocities: got shape (1, 3)",
    ),
    "radius twice": (TWO, {"radius": 0.1}, "radius: got 0.1, must be left out: the file has a radius"),
    "mass and density": (TWO.replace("density", "mass"), {"density": 1.0}, "the file has a mass"),
    "id twice": (TWO.replace("\n2 ", "\n1 "), {}, "id: got 1 twice, must be another number"),
    "some spins": (
        TWO.replace("density", "omegax"),
        {"density": 1},
        "must have omegax omegay omegaz or none",
    ),
    "no such units": (TWO, {"units": "real"}, "units: got 'real', must be lj, si, cgs, micro or nano"),
    "units of atoms": (f"ITEM: UNITS\nmetal\n{TWO}", {}, "units: got 'metal', must be"),
    "a tilted box": (tilted("0 .1 0", "0 .1 0", "0 .1 0"), {}, "shear_rate: missing for a box that tilts"),
    "tilts along y": (tilted("0 .1 0", "0 .12 0", "0 .1 .02"), RATE, "must be xy or xz alone"),
    "two tilts": (tilted("0 .14 .02", "0 .1 .02", "0 .1 0"), RATE, "must be xy or xz alone"),
    "unwrapped": (
        tilted("0 .12 .02", "0 .1 0", "0 .1 0", columns="xu yu zu"),
        RATE,
        "must have the columns x y z or",
    ),
    "general": (TWO.replace("pp pp pp", "abc origin pp pp pp"), {}, "general triclinic"),
    "a rate without tilt": (TWO, RATE, "shear_rate: got 1.0, must be left out"),
    "local": (TWO.replace("ATOMS", "ENTRIES"), {}, "must be a text dump"),
    "half a box": (TWO.replace(CUBE, "0 1\n0 1"), {}, "must be a text dump"),
    "no frame": (TWO, {"frame": 1}, "frame: got 1, must be in [-1, 0]"),
    "boundary": (TWO, {"boundary": "open"}, "boundary: got 'open', must be one of periodic"),
    "negative": (TWO.replace(" .005 ", " -1 "), {}, "radius[0]: got -1, must be"),
    "columns twice": (TWO.replace("density", "x"), {}, "has 9 columns for the names"),
    "short": (TWO.replace(" .005 1", " .005"), {}, "has 8 columns for the names id x y z"),
    "one short": (
        TWO.replace(" .005 1\n", " .005\n", 2).replace(" .005\n", " .005 1\n", 1),
        {},
        "missing numbers",
    ),
    "one long": (
        TWO.replace(" .005 1\n", " .005 1 1\n", 2).replace(" .005 1 1\n", " .005 1\n", 1),
        {},
        "not numbers",
    ),
    "superquadrics": (TWO.replace("id", "shapex"), {}, "got the column shapex, must be of spheres"),
    "no grains": (frame(), {}, "must have a frame with ITEM: ATOMS and grains"),
    "words": (TWO.replace(" .005 1", " .005 heavy"), {}, "not numbers"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_read_is_refused_in_one_line(name, tmp_path):
    content, options, message = BAD[name]
    assert message in refused(written(tmp_path, content), **options)


def test_velocities_without_the_flow_are_refused(tmp_path):
    """As with LAMMPS' remap x: the slope of v_x is not the shear rate."""
    rng = np.random.default_rng(1)
    system = lattice(64, 3, 1, 2.0)
    columns = ["id", "x", "y", "z", "vx", "vy", "vz", "radius", "mass"]
    path = written(tmp_path, dumped(system, columns, rng, tilt=[1e-4, 0.0, 0.0]))
    flow = 1e3 * float(np.abs(system.velocities).max()) / float(system.box[1])
    assert "shear_rate: got " in refused(path, shear_rate=flow) and "slope of the velocities" in refused(
        path, shear_rate=flow
    )
    assert hl.ParticleSystem.read(path, shear_rate=0.0).shear_displacement == pytest.approx(1e-4)


@draws(400, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damaged_dumps_are_read_right_or_refused(tmp_path, data):
    """A truncated dump, or one with replaced bytes or words, compressed or not."""
    name = data.draw(st.sampled_from([*FACTS]))
    content = bytearray(recorded(name).read_bytes())
    if name.endswith(".gz") and data.draw(st.booleans()):
        content = bytearray(gzip.decompress(bytes(content)))
    for _ in range(data.draw(st.integers(1, 4))):
        match data.draw(st.sampled_from(["cut", "byte", "word", "line"])):
            case "cut":
                del content[data.draw(st.integers(0, max(len(content) - 1, 0))) :]
            case "byte" if content:
                content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
            case kind:
                parts = bytes(content).split(b" " if kind == "word" else b"\n")
                other = data.draw(
                    st.sampled_from([b"", b"nan", b"1e400", b"-1", b"ITEM:", b"ITEM: UNITS", b"999999999999"])
                )
                parts[data.draw(st.integers(0, min(len(parts) - 1, 40)))] = other
                content = bytearray((b" " if kind == "word" else b"\n").join(parts))
    path = tmp_path / "dump.spoiled"
    path.write_bytes(content)
    options = {"allowed_overlap": 0.4, "frame": data.draw(st.sampled_from([-1, 0]))} | MISSING.get(name, {})
    try:
        system = hl.ParticleSystem.read(path, **options)
    except ValueError as error:
        assert "\n" not in str(error) and len(str(error)) < 500
    else:
        assert system.n >= 1 and math.isfinite(system.kinetic_energy)


# --- extended XYZ of OVITO --------------------------------------------------------------------------------------

OVITO = """2
Lattice="0.1 0 0 0 0.1 0 0 0 0.2" Origin="-0.05 -0.05 0" Properties=species:S:1:id:I:1:pos:R:3:velo:R:3:radius:R:1{}
2 12 -0.01 0.02 0.03 1 2 3 0.004{}
1 3 -0.049 0.02 0.21 4 5 6 0.005{}
"""


def test_extended_xyz_of_ovito(tmp_path):
    """Names of its columns as its exporter writes them; positions may lie beyond periodic sides."""
    path = written(tmp_path, OVITO.format("", "", ""), "ovito.xyz")
    system = hl.ParticleSystem.read(path, density={1: 1000.0, 2: 2000.0})
    assert system.positions == pytest.approx(np.array([[0.001, 0.07, 0.01], [0.04, 0.07, 0.03]]))
    assert system.radius.tolist() == [0.005, 0.004] and system.density == pytest.approx([1000.0, 2000.0])
    assert system.box.tolist() == [0.1, 0.1, 0.2] and system.boundary == ("periodic",) * 3
    assert "density: missing in the file; density= gives it" in refused(path)
    assert hl.ParticleSystem.read(path, density=1.0, units="cgs").box[0] == pytest.approx(1e-3)
    spins = OVITO.format(':mass:R:1:omega:R:3 pbc="1 1 0"', " 7 1 0 0", " 8 0 2 0")
    turning = hl.ParticleSystem.read(written(tmp_path, spins.replace(" 0.21 ", " 0.11 "), "ovito.xyz"))
    assert turning.angular_velocities.tolist() == [[0.0, 2.0, 0.0], [1.0, 0.0, 0.0]]
    assert turning.mass.tolist() == [8.0, 7.0] and turning.boundary[2] == "wall"


def test_a_tilted_cell_of_ovito(tmp_path):
    content = OVITO.format("", "", "").replace("0 0.1 0 0 0 0.2", "0.02 0.1 0 0 0 0.2")
    path = written(tmp_path, content, "ovito.xyz")
    assert "shear_rate: missing for a box that tilts" in refused(path, density=1.0)
    system = hl.ParticleSystem.read(path, density=1.0, shear_rate=0.0)
    assert system.boundary == ("periodic", "lees-edwards", "periodic")
    assert system.shear_displacement == pytest.approx(0.02)
    for bad in ('"0.1 0.02 0', '"0.1 0 0.02'):
        other = OVITO.format("", "", "").replace('"0.1 0 0', bad)
        assert "Lattice: must be a box along the axes" in refused(
            written(tmp_path, other, "o.xyz"), density=1.0
        )


def test_a_tilted_box_of_lammps_data(tmp_path):
    """As write_data has it."""
    content = (
        "LAMMPS data file via write_data, units = lj\n\n1 atoms\n1 atom types\n\n0 0.1 xlo xhi\n0 0.1 ylo yhi\n"
        "0 0.1 zlo zhi\n0.02 0 0 xy xz yz\n\nAtoms # sphere\n\n1 1 0.01 2 0.11 0.05 0.05 0 0 0\n\nVelocities\n\n"
        "1 1 0 0 0 0 0\n"
    )
    path = written(tmp_path, content, "box.data")
    assert "shear_rate: missing for a box that tilts" in refused(path)
    system = hl.ParticleSystem.read(path, shear_rate=2.0)
    assert system.positions[0] == pytest.approx([0.01, 0.05, 0.05]) and system.shear_displacement == 0.02
