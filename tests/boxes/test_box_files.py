"""Particle systems in files: bit-identical round trip, exchange with other programs, rejection of damaged files."""

import math
import os
import sys
from pathlib import Path

import gsd.fl
import gsd.hoomd
import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st

import hardlimit as hl
from conftest import draws, lattice, refusal
from hardlimit.boxes import files

SUFFIXES = (".xyz", ".extxyz", ".gsd", ".data", ".lmp")
EXACT = (".xyz", ".gsd")


@st.composite
def systems(draw):
    """Random 2D and 3D systems with any boundaries and values over many decades."""
    d = draw(st.integers(2, 3))
    scale = 10.0 ** draw(st.integers(-6, 3))
    small = lattice(draw(st.integers(1, 20)), d, draw(st.integers(0, 2**32)), draw(st.floats(1.0, 10.0)))
    sides = [draw(st.sampled_from(["periodic", "wall"])) for _ in range(d)]
    gravity = [draw(st.sampled_from([0.0, -9.81, 1.0 / 3.0])) for _ in range(d)]
    lengths = {name: getattr(small, name) * scale for name in ("positions", "velocities", "radius", "box")}
    density = draw(st.sampled_from([2500.0, 1.0 / 3.0]))
    rotation = draw(rotations(small.n, d))
    drive = draw(drives(small.n, sides, lengths["box"][0]))
    return hl.ParticleSystem(
        **lengths, density=density, **({"boundary": sides, "gravity": gravity} | rotation | drive)
    )


THERMOSTATS = [
    hl.RandomKicks(power=1e-3, interval=5e-4, seed=3, kicks=7),
    hl.RandomKicks(power=1e-3, interval=5e-4, rotational=2e-3, seed=3, kicks=7),
    hl.Andersen(0.03, 300.0, rotational=1.0 / 3.0, kicks=7),
]


@st.composite
def drives(draw, n, sides, edge):
    """Walls that move, images that are displaced and slide, heat, or none of them."""
    kind = draw(st.sampled_from(["", "walls", "shear", "heat"]))
    if kind == "walls":
        wall = hl.MovingWall(
            1e-6 * edge, 1.0 / 3.0, draw(st.sampled_from(["sine", "parabola"])), 0.7, velocity=-0.1
        )
        return {"walls": {f"{'xyz'[axis]}-": wall for axis, side in enumerate(sides) if side == "wall"}}
    if kind == "shear":
        gradient = draw(st.integers(1, len(sides) - 1))
        sheared = ["lees-edwards" if axis == gradient else "periodic" for axis in range(len(sides))]
        displaced = edge * draw(st.sampled_from([0.0, 1.0 / 3.0]))
        return {"boundary": sheared, "shear_rate": 1.0 / 3.0, "shear_displacement": displaced, "gravity": 0.0}
    return {"thermostat": draw(st.sampled_from(THERMOSTATS))} if kind == "heat" and n > 1 else {}


@st.composite
def rotations(draw, n, d):
    """No spins, or spins over many decades with any moments of inertia."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    speed = draw(st.sampled_from([0.0, 1e-320, 1e-20, 1.0, 1e20]))
    factors = {"solid": None, "same": draw(st.floats(1e-6, 1.0)), "other": rng.uniform(0.1, 1.0, n)}
    spins = {"angular_velocities": speed * rng.normal(size=(n, 3) if d == 3 else n)}
    rotation = {"inertia_factor": factors[draw(st.sampled_from([*factors]))]}
    return rotation | (spins if draw(st.booleans()) else {})


@draws(200, few=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(systems(), st.sampled_from(SUFFIXES))
def test_every_bit_comes_back(tmp_path, system, suffix):
    path = tmp_path / f"box{suffix}"
    solid = {2: 0.5, 3: 0.4}[system.dimension]
    other = system.inertia_factor is not None and bool((system.inertia_factor != solid).any())
    unknown = {"inertia_factor": other, "walls": system.walls, "thermostat": system.thermostat is not None}
    if suffix in (".data", ".lmp") and any(unknown.values()):
        parameter, got, _ = refusal(lambda: system.write(path)).partition(": got ")
        assert got and unknown[parameter]
        return
    assert system.write(path) == path
    assert hl.ParticleSystem.read(path) == system
    assert [name.name for name in tmp_path.iterdir() if "unfinished" in name.name] == []


@pytest.mark.parametrize("suffix", EXACT)
def test_masses_of_any_origin_come_back(tmp_path, suffix):
    rng = np.random.default_rng(1)
    system = lattice(20).replace(mass=rng.uniform(1e-6, 1e-5, 20))
    assert hl.ParticleSystem.read(system.write(tmp_path / f"box{suffix}")) == system


def test_lammps_keeps_masses_to_rounding(tmp_path):
    """The format stores densities, from which a mass is recovered only to rounding."""
    system = lattice(200).replace(mass=np.random.default_rng(1).uniform(1e-6, 1e-5, 200))
    back = hl.ParticleSystem.read(system.write(tmp_path / "box.data"))
    assert np.max(np.abs(back.mass / system.mass - 1.0)) < 3e-16
    assert np.mean(back.mass == system.mass) > 0.5


@pytest.mark.parametrize("suffix", EXACT)
@pytest.mark.parametrize("plain_first", [False, True])
def test_frames_of_a_trajectory(tmp_path, suffix, plain_first):
    """Each with its own values, also where only some frames have spins or moving walls."""
    path = tmp_path / f"run{suffix}"
    spins = {"angular_velocities": np.ones((8, 3)), "inertia_factor": 0.7}
    driven = {"walls": {"x-": hl.MovingWall(1e-5, 50.0)}, "boundary": ("wall", "periodic", "periodic")}
    kinds = [{}, spins, {}, driven] if plain_first else [spins | driven, {}, spins, driven]
    frames = [lattice(8, seed=i, **changes) for i, changes in enumerate(kinds)]
    files.write(path, (system.as_frame(0.5 * i) for i, system in enumerate(frames)))
    assert [hl.ParticleSystem.read(path, frame=i) for i in range(4)] == frames
    assert hl.ParticleSystem.read(path) == hl.ParticleSystem.read(path, frame=-1) == frames[3]
    for frame in (4, -5):
        with pytest.raises(ValueError, match=rf"frame: got {frame}, must be in \[-4, 3\]"):
            hl.ParticleSystem.read(path, frame=frame)


# --- other programs -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
def test_ase_reads_extended_xyz(tmp_path, dimension):
    import ase.io

    system = lattice(9, dimension, gravity=9.81, boundary=["wall", *["periodic"] * (dimension - 1)])
    path = tmp_path / "box.xyz"
    files.write(path, [system.as_frame(0.25), system.as_frame(0.5)])
    first, second = ase.io.read(path, index=":")
    assert (first.info["Time"], second.info["Time"]) == (0.25, 0.5)
    assert np.array_equal(second.get_positions()[:, :dimension], system.positions)
    assert np.array_equal(second.arrays["velo"][:, :dimension], system.velocities)
    assert np.array_equal(second.arrays["radius"], system.radius)
    assert np.array_equal(second.arrays["mass"], system.mass)
    assert np.array_equal(second.cell.lengths()[:dimension], system.box)
    assert second.pbc.tolist() == [False, True, dimension == 3]
    assert second.info["gravity"].tolist() == [*system.gravity, 0.0][:3]


def test_what_another_program_writes_as_extended_xyz(tmp_path):
    import ase.io

    system = lattice(8)
    atoms = ase.Atoms("X8", positions=system.positions, cell=system.box, pbc=[True, True, False])
    atoms.arrays |= {"velo": np.array(system.velocities), "radius": np.array(system.radius)}
    atoms.arrays["mass"] = np.full(8, 1.0)
    ase.io.write(tmp_path / "other.xyz", atoms, columns=["symbols", "positions", "radius", "mass", "velo"])
    back = hl.ParticleSystem.read(tmp_path / "other.xyz")
    assert back.boundary == ("periodic", "periodic", "wall") and back.n == 8
    assert back.positions == pytest.approx(system.positions, abs=1e-8)
    assert back.velocities == pytest.approx(system.velocities, abs=1e-8)


@pytest.mark.parametrize("dimension", [2, 3])
def test_gsd_is_the_schema_of_hoomd(tmp_path, dimension):
    system = lattice(9, dimension)
    with gsd.hoomd.open(system.write(tmp_path / "box.gsd")) as file:
        frame = file[0]
    frame.validate()
    assert frame.configuration.dimensions == dimension and frame.particles.N == 9
    middle = np.asarray(system.positions) - 0.5 * np.asarray(system.box)
    assert np.array_equal(frame.particles.position[:, :dimension], middle.astype(np.float32))
    assert np.array_equal(frame.particles.diameter, (2.0 * system.radius).astype(np.float32))
    assert np.array_equal(frame.particles.velocity[:, :dimension], system.velocities.astype(np.float32))


def test_what_another_program_writes_as_gsd(tmp_path):
    """A file in single precision, whose touching particles overlap by its rounding error."""
    at = np.array([[0.1, 0.5, 0.5], [0.1 + 2e-3, 0.5, 0.5]]) - 0.5
    frame = gsd.hoomd.Frame()
    frame.configuration.box = [1, 1, 1, 0, 0, 0]
    frame.particles.N = 2
    frame.particles.position = at
    frame.particles.diameter = [2e-3, 2e-3]
    with gsd.hoomd.open(tmp_path / "other.gsd", "w") as file:
        file.append(frame)
    system = hl.ParticleSystem.read(tmp_path / "other.gsd")
    assert system.positions == pytest.approx(at + 0.5, abs=1e-7)
    assert system.mass.tolist() == [1.0, 1.0] and not system.velocities.any()


def rotated(q, v):
    """Vectors (N, 3) turned by unit quaternions (N, 4), by the matrix of each."""
    w, x, y, z = q.T
    matrix = np.array(
        [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    )  # fmt: skip
    return np.einsum("ijn,nj->ni", matrix, v)


@pytest.mark.parametrize("dimension", [2, 3])
def test_spins_of_hoomd(tmp_path, dimension):
    """Turned particles: p = 2 q s with the angular momentum s in the frame of the body, Kamberaj et al. (2005).

    In a plane only I_z counts.
    """
    n, rng = 6, np.random.default_rng(3)
    system = lattice(n, dimension, spread=2.0)
    q, spin = rng.normal(size=(n, 4)), rng.normal(size=(n, 3))
    if dimension == 2:
        q[:, 1:3], spin[:, :2] = 0.0, 0.0
    q /= np.linalg.norm(q, axis=1)[:, None]
    factor = rng.uniform(0.2, 1.0, n)
    inertia = factor * system.mass * system.radius**2
    body = inertia[:, None] * rotated(q * [1.0, -1.0, -1.0, -1.0], spin)
    frame = gsd.hoomd.Frame()
    frame.configuration.box = [*system.box, *[1.0] * (3 - dimension), 0, 0, 0]
    frame.configuration.dimensions = dimension
    frame.particles.N, frame.particles.mass, frame.particles.diameter = n, system.mass, 2.0 * system.radius
    frame.particles.position = np.zeros((n, 3))
    frame.particles.position[:, :dimension] = system.positions - 0.5 * system.box
    frame.particles.orientation = q
    scalar, vector = -(q[:, 1:] * body).sum(1), q[:, :1] * body + np.cross(q[:, 1:], body)
    frame.particles.angmom = 2.0 * np.column_stack([scalar, vector])
    frame.particles.moment_inertia = np.repeat(inertia[:, None], 3, 1)
    if dimension == 2:
        frame.particles.moment_inertia[:, :2] = 0.0

    def written(**changed):
        for name, value in changed.items():
            setattr(frame.particles, name, value)
        with gsd.hoomd.open(tmp_path / "other.gsd", "w") as file:
            file.append(frame)
        return tmp_path / "other.gsd"

    back = hl.ParticleSystem.read(written())
    assert back.angular_velocities == pytest.approx(
        spin if dimension == 3 else spin[:, 2], rel=1e-5, abs=1e-6
    )
    assert back.inertia_factor == pytest.approx(factor, rel=1e-6)
    moments = frame.particles.moment_inertia.copy()
    moments[1, 2] *= 10.0
    assert "moment_inertia[1]: got [" in refused(written(moment_inertia=moments))
    for still in ({"angmom": np.zeros((n, 4))}, {"moment_inertia": np.zeros((n, 3))}):
        assert hl.ParticleSystem.read(written(**still)).angular_velocities is None


def test_spins_in_the_schema_of_hoomd(tmp_path):
    """No orientation, and angular momenta 2 (0, I ω)."""
    system = lattice(4, 2, angular_velocities=[1.0, -2.0, 0.0, 3.0], inertia_factor=0.5)
    with gsd.hoomd.open(system.write(tmp_path / "box.gsd")) as file:
        particles = file[0].particles
    assert (particles.orientation == [1.0, 0.0, 0.0, 0.0]).all() and not particles.angmom[:, :3].any()
    inertia = 0.5 * system.mass * system.radius**2
    assert particles.angmom[:, 3] == pytest.approx(2.0 * inertia * system.angular_velocities, rel=1e-6)
    assert particles.moment_inertia == pytest.approx(np.repeat(inertia[:, None], 3, 1), rel=1e-6)


def test_ase_reads_spins_of_extended_xyz(tmp_path):
    import ase.io

    system = lattice(9, 2, angular_velocities=np.arange(9.0), inertia_factor=0.25)
    atoms = ase.io.read(system.write(tmp_path / "box.xyz"))
    assert atoms.arrays["angular_velocity"].tolist() == [[0.0, 0.0, float(i)] for i in range(9)]
    assert atoms.arrays["inertia_factor"].tolist() == [0.25] * 9


def test_a_changed_gsd_file_is_not_believed(tmp_path):
    path = lattice(8).write(tmp_path / "box.gsd")
    with gsd.hoomd.open(path) as file:
        frame = file[0]
    frame.particles.position[3, 0] += 1e-4
    with gsd.hoomd.open(path, "w") as file:
        file.append(frame)
    with pytest.raises(ValueError, match=r"box\.gsd: log: must equal the values in single precision"):
        hl.ParticleSystem.read(path)


def test_gsd_is_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gsd.hoomd", None)
    monkeypatch.setitem(sys.modules, "gsd", None)
    with pytest.raises(ValueError, match=r"a \.gsd file requires .*: pip install 'hardlimit\[files\]'"):
        lattice(8).write(tmp_path / "box.gsd")
    assert list(tmp_path.iterdir()) == []


LAMMPS = """LAMMPS data file of someone else

2 atoms
1 atom types

-0.01 0.01 xlo xhi   # a comment
0 0.02 ylo yhi
0 0.02 zlo zhi

Masses

1 1

Atoms # sphere

2 1 0.002 2500 0.005 0.01 0.01 0 0 0
1 1 0.001 1000 -0.005 0.01 0.01 0 1 0

Velocities

1 1 2 3 0 0 0
2 4 5 6 0 0 0
"""


def test_lammps_data_of_another_program(tmp_path):
    path = tmp_path / "other.data"
    path.write_text(LAMMPS)
    system = hl.ParticleSystem.read(path)
    assert system.positions[:, 0].tolist() == [0.005, 0.015]
    assert system.velocities[:, 2].tolist() == [3.0, 6.0]
    assert system.mass.tolist() == [hl.Ball(0.5e-3, density=1000.0).mass, hl.Ball(1e-3, density=2500.0).mass]
    assert system.boundary == ("periodic",) * 3 and system.box.tolist() == [0.02] * 3


def test_spins_in_lammps_data(tmp_path):
    """In the last three columns of velocities; those of LAMMPS' own files in their units of time."""
    path = tmp_path / "other.data"
    spinning = LAMMPS.replace("1 1 2 3 0 0 0", "1 1 2 3 5 6 7")
    path.write_text(spinning)
    system = hl.ParticleSystem.read(path)
    assert system.angular_velocities.tolist() == [[5.0, 6.0, 7.0], [0.0] * 3]
    assert system.inertia_factor.tolist() == [0.4, 0.4]
    path.write_text(f"{WRITE_DATA}, units = nano\n{spinning.partition(chr(10))[2]}")
    assert hl.ParticleSystem.read(path).angular_velocities[0].tolist() == [5e9, 6e9, 7e9]
    path.write_text(LAMMPS)
    assert hl.ParticleSystem.read(path).angular_velocities is None


WRITE_DATA = "LAMMPS data file via write_data, version 2 Aug 2023, timestep = 10"
#: Units of length, density and speed in SI.
OTHER_UNITS = {
    "cgs": (1e-2, 1e3, 1e-2),
    "micro": (1e-6, 1e3, 1.0),
    "nano": (1e-9, 1e6, 1.0),
    "lj": (1.0, 1.0, 1.0),
}


def in_units(length, density, speed):
    """``LAMMPS`` with its numbers in other units."""
    converted = []
    for line in LAMMPS.splitlines()[1:]:
        words = line.split()
        kinds = {"xlo": "LL", "ylo": "LL", "zlo": "LL"}.get(words[2] if len(words) > 2 else "", "")
        kinds = kinds or {10: "..LDLLL", 7: ".VVV"}.get(len(words), "")
        for k, kind in enumerate(kinds):
            if kind != ".":
                words[k] = repr(float(words[k]) / {"L": length, "D": density, "V": speed}[kind])
        converted.append(" ".join(words) if kinds else line)
    return "\n".join([*converted, ""])


@pytest.mark.parametrize("units", OTHER_UNITS)
def test_lammps_data_in_other_units(units, tmp_path):
    """As ``write_data`` of LAMMPS names them in the first line."""
    path, si = tmp_path / "box.data", tmp_path / "si.data"
    path.write_text(f"{WRITE_DATA}, units = {units}\n{in_units(*OTHER_UNITS[units])}")
    si.write_text(LAMMPS)
    system, expected = hl.ParticleSystem.read(path), hl.ParticleSystem.read(si)
    for name in ("positions", "velocities", "radius", "mass", "box"):
        assert getattr(system, name) == pytest.approx(getattr(expected, name), rel=1e-12), name


def test_lammps_data_in_units_that_are_not_mechanical_are_refused(tmp_path):
    path = tmp_path / "box.data"
    path.write_text(f"{WRITE_DATA}, units = real\n{in_units(1.0, 1.0, 1.0)}")
    assert "units: got 'real', must be lj, si, cgs, micro or nano" in refused(path)


# --- invalid files ------------------------------------------------------------------------------------------


def refused(path, **options):
    """The error message for a file; one line that names the file."""
    with pytest.raises(ValueError) as refusal:
        hl.ParticleSystem.read(path, **options)
    text = str(refusal.value)
    assert "\n" not in text and len(text) < 400 and path.name in text, text
    return text


def edited(tmp_path, suffix, old, new, **changes):
    """A file with one item changed."""
    path = lattice(8, **changes).write(tmp_path / f"bad{suffix}")
    content = path.read_text()
    assert old in content
    path.write_text(content.replace(old, new, 1))
    return path


@pytest.mark.parametrize("suffix", [".xyz", ".data"])
def test_bad_values_in_a_file(tmp_path, suffix):
    system = lattice(8)
    x = repr(float(system.positions[2, 0]))
    assert "positions[2]" in refused(edited(tmp_path, suffix, x, "nan"))
    assert "positions[2]: got x = 0.5, must be in [0," in refused(edited(tmp_path, suffix, x, "0.5"))
    title = {".xyz": "particles: ", ".data": "Atoms: "}[suffix]
    assert title in refused(edited(tmp_path, suffix, x, "3,5"))
    place = " ".join(repr(float(v)) for v in system.positions[2])
    other = " ".join(repr(float(v)) for v in system.positions[5])
    assert "particles 2 and 5 overlap" in refused(edited(tmp_path, suffix, place, other))


BAD = {".xyz": {
    "no columns": ("Properties=", "Columns=", "Properties: must contain pos:R:3, and may contain velo:R:3"),
    "no radius": (":radius:R:1", ":size:R:1", "radius: missing in the file; radius= gives it"),
    "wide": ("pos:R:3", "pos:R:x", "Properties: got"),
    "no cell": ("Lattice=", "Cell=", "Lattice: got nothing, must be 9 numbers"),
    "tilted": ('Lattice="0.006 0.0', 'Lattice="0.006 0.1', "Lattice | Origin: must be a box along the axes"),
    "text in the cell": ('Lattice="0.006', 'Lattice="a', "Lattice: got"),
    "sides": ('pbc="T T T"', 'pbc="T T"', "pbc: got 'T T', must be T or F for each axis"),
    "dimension": ("dimension=3", "dimension=5", "dimension: got '5', must be 2 or 3"),
    "plane": ("dimension=3", "dimension=2", "dimension: got 2, must be 3 for particles with z ≠ 0"),
    "more": ("8\n", "9\n", "number of particles: got 9, must be >= 1 and the number of its lines, 8"),
    "fewer": ("8\n", "7\n", "number of particles: got 'X "),
    "no count": ("8\n", "eight\n", "number of particles: got 'eight', must be a whole number"),
    "a huge count": ("8\n", "999999999999\n", "number of particles: got 999999999999, must be"),
    "a short line": ("\nX ", "\nX 1 2\nX ", ""),
}, ".data": {
    "no atoms": ("8 atoms", "8 grains", "header: must contain the number of atoms once"),
    "more": ("8 atoms", "9 atoms", "Atoms: got 8 lines, must be 9"),
    "no edge": ("xlo xhi", "xlow xhigh", "header: must contain a line such as '0 1 xlo xhi'"),
    "edge": ("0.0 0.006 xlo", "0.0 nan xlo", "xlo xhi: got 'nan', must be a finite number"),
    "inside out": ("0.0 0.006 xlo", "0.006 0.0 xlo", "box[0]: got -0.006"),
    "tilted": ("8 atoms", "8 atoms\n0 0 0 xy xz yz", "header: got a tilted box"),
    "style": ("# sphere", "# charge", "Atoms: got the style 'charge', must be sphere"),
    "twice": ("Velocities", "Atoms", "Atoms: got two sections"),
    "no velocities": ("Velocities", "Speeds", "Velocities: missing"),
    "the same number": ("\n3 1 ", "\n2 1 ", "Atoms: got an atom twice"),
    "first line": ("boundary p p p", "boundary p p", "first line: must contain a boundary"),
    "no rate": ("boundary p p p", "boundary p l p", "first line: must contain a shear rate and a displacement"),
    "no gradient": ("0.0 0.0 0.0\n", "0.0 0.0 0.0, shear rate 3.0, displacement 0.0\n", "must contain a shear rate"),
}}  # fmt: skip


@pytest.mark.parametrize(("suffix", "which"), [(suffix, which) for suffix in BAD for which in BAD[suffix]])
def test_bad_text_files(tmp_path, suffix, which):
    old, new, message = BAD[suffix][which]
    assert message in refused(edited(tmp_path, suffix, old, new))


@pytest.mark.parametrize(
    ("suffix", "dimension", "old", "new", "message"),
    [(".xyz", 3, ":inertia_factor:R:1", ":more:R:1", ""), (".xyz", 3, "7.0 0.4\n", "7.0\n", "particles: "),
     (".xyz", 3, "angular_velocity:R:3:inertia", "angular_velocity:R:2:more:R:1:inertia", "Properties: must contain"),
     (".xyz", 3, "7.0 0.4\n", "nan 0.4\n", "angular_velocities[2]: got [5.0, 6.0, nan]"),
     (".xyz", 3, "7.0 0.4\n", "7.0 4.0\n", "inertia_factor[2]: got 4, must be in [1e-06, 1]"),
     (".xyz", 2, "0.0 0.0 7.0", "5.0 0.0 7.0", "dimension: got 2, must be 3 for particles that spin about x or y"),
     (".data", 2, "0.0 0.0 7.0", "5.0 0.0 7.0", "dimension: got 2, must be 3 for particles that spin about x or y"),
     (".data", 3, "5.0 6.0 7.0", "5.0 6.0 1e40", "angular_velocities[2]: got [5.0, 6.0, 1e+40]"),
     (".data", 3, "5.0 6.0 7.0", "5.0 6.0", "Velocities: ")],
)  # fmt: skip
def test_bad_spins_in_a_file(tmp_path, suffix, dimension, old, new, message):
    spins = np.zeros((8, 3))
    spins[2] = [5.0, 6.0, 7.0]
    spins = spins if dimension == 3 else spins[:, 2]
    path = edited(tmp_path, suffix, old, new, dimension=dimension, angular_velocities=spins)
    if message:
        assert message in refused(path)
    else:
        assert hl.ParticleSystem.read(path) == lattice(8, angular_velocities=spins)


def test_lammps_data_with_spins_of_four_columns(tmp_path):
    path = lattice(1, angular_velocities=np.zeros((1, 3))).write(tmp_path / "box.data")
    path.write_text(path.read_text().removesuffix(" 0.0 0.0 0.0\n") + "\n")
    assert "Velocities: got 4 columns, must be 7 for particles with spins" in refused(path)


@draws(300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data(), st.sampled_from([".xyz", ".gsd", ".data"]))
def test_damaged_files_are_read_right_or_refused(tmp_path, data, suffix):
    """A truncated file, or one with replaced bytes, gives a valid system or a one-line error that names the file."""
    spins = {"angular_velocities": [[1.0, -2.0, 3.0]] * 4} if data.draw(st.booleans()) else {}
    path = lattice(4, **spins).write(tmp_path / f"spoiled{suffix}")
    content = bytearray(path.read_bytes())
    if data.draw(st.booleans()):
        del content[data.draw(st.integers(0, len(content) - 1)) :]
    else:
        for _ in range(data.draw(st.integers(1, 8))):
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    try:
        system = hl.ParticleSystem.read(path)
    except ValueError as error:
        assert "\n" not in str(error) and path.name in str(error) and len(str(error)) < 500
    else:
        assert system.n >= 1 and math.isfinite(system.kinetic_energy)


@pytest.mark.parametrize(
    "driving",
    ["{", "[]", "3", '{"walls": []}', '{"walls": {}, "thermostat": 3}', '{"thermostat": null}',
     '{"walls": [], "thermostat": null, "shear": 3}', '{"walls": [], "thermostat": null, "shear": [[], 1, 2]}',
     "[" * 100_000],
)  # fmt: skip
def test_damaged_driving(tmp_path, driving):
    """JSON that another program has changed."""
    path = lattice(4).write(tmp_path / "driven.gsd")
    with gsd.hoomd.open(str(path), "r") as file:
        frame = file[0]
    frame.log["hardlimit/driving"] = np.frombuffer(driving.encode(), np.uint8)
    with gsd.hoomd.open(str(path), "w") as file:
        file.append(frame)
    refused(path)


@pytest.mark.parametrize("name", ["particles/N", "bonds/N"])
def test_a_damaged_count_takes_no_memory(tmp_path, name):
    """4e9 particles in a file of 1 kB: gsd would fill 50 GB with default values."""
    path = tmp_path / "huge.gsd"
    with gsd.fl.open(str(path), "w", "hardlimit", "hoomd", [1, 4]) as file:
        file.write_chunk(name, np.array([4_000_000_000], np.uint32))
        file.end_frame()
    assert f"{name}: got 4000000000, must fit into the size of the file" in refused(path)


def test_files_that_are_none(tmp_path):
    folder = tmp_path / "folder.gsd"
    folder.mkdir()
    assert "cannot be read: not a file" in refused(folder)
    for suffix in (".xyz", ".gsd", ".data"):
        empty = tmp_path / f"empty{suffix}"
        empty.write_bytes(b"")
        refused(empty)
        noise = tmp_path / f"noise{suffix}"
        noise.write_bytes(os.urandom(5000))
        refused(noise)
    for path in (3, None, b"box.xyz"):
        with pytest.raises(ValueError, match=r"^path: got .*, must be a path"):
            hl.ParticleSystem.read(path)
    for path in ("box.pdb", "box", ""):
        with pytest.raises(ValueError, match=r"^path: got .*, must end in \.xyz, "):
            hl.ParticleSystem.read(path)


@pytest.mark.parametrize("suffix", EXACT)
def test_a_failure_leaves_the_former_file(tmp_path, suffix):
    path = lattice(8, seed=1).write(tmp_path / f"box{suffix}")

    def frames():
        yield lattice(8, seed=2).as_frame()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write(path, frames())
    assert hl.ParticleSystem.read(path) == lattice(8, seed=1)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_lammps_holds_one_frame(tmp_path):
    with pytest.raises(ValueError, match="got a second frame, must be one in LAMMPS data"):
        files.write(tmp_path / "box.data", [lattice(8).as_frame()] * 2)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".xyz", ".gsd", ".data"])
def test_a_folder_that_cannot_be_written(suffix):
    with pytest.raises(OSError, match="cannot be written"):
        lattice(8).write(Path("/proc/none") / f"box{suffix}")


def test_single_precision_has_a_range(tmp_path):
    large = lattice(8)
    large = large.replace(mass=1e50 * large.mass)
    with pytest.raises(ValueError, match="got a value too large for GSD"):
        large.write(tmp_path / "box.gsd")
    assert list(tmp_path.iterdir()) == []
    assert hl.ParticleSystem.read(large.write(tmp_path / "box.xyz")) == large
