"""Text dumps of LAMMPS and LIGGGHTS: what is read from them, and which files are refused in one line."""

import gzip

import numpy as np
import pytest

import hardlimit as hl
from hardlimit.checking import dumps

GAS = hl.ParticleSystem.random(400, packing_fraction=0.2, radius=1e-3, density=2500.0, rms_speed=0.3, seed=1)
LAW = hl.LinearDashpot(stiffness=1e5, restitution=0.9)
BEAD = hl.Ball(1e-3, density=2500.0)


def text(
    system=GAS,
    columns="id type x y z vx vy vz radius",
    step=100,
    sides="pp pp pp",
    gaps=True,
    scaled=False,
    types=1,
):
    """A frame of a system; its grains are shuffled, and some numbers are left out."""
    n, edges = system.n, system.box
    at = system.positions / edges if scaled else system.positions
    values = {"id": 3 * np.arange(n) + 1 if gaps else np.arange(n) + 1, "type": np.broadcast_to(types, n)}
    for k, axis in enumerate("xyz"[: system.dimension]):
        values |= {axis + end: at[:, k] for end in ("", "s", "u")} | {f"v{axis}": system.velocities[:, k]}
    values |= {"radius": system.radius, "diameter": 2.0 * system.radius, "mass": system.mass}
    values["density"] = system.mass / (4 / 3 * np.pi * system.radius**3)
    rows = [
        " ".join(f"{values[name][i]:.12g}" for name in columns.split())
        for i in np.random.default_rng(1).permutation(n)
    ]
    bounds = [f"0 {edge:.12g}" for edge in (*edges, 1.0)[:3]]
    head = [
        "ITEM: TIMESTEP",
        str(step),
        "ITEM: NUMBER OF ATOMS",
        str(n),
        f"ITEM: BOX BOUNDS {sides}",
        *bounds,
    ]
    return "\n".join([*head, f"ITEM: ATOMS {columns} ", *rows, ""])


def written(folder, content, name="dump.box"):
    path = folder / name
    path.write_bytes(gzip.compress(content.encode())) if name.endswith(".gz") else path.write_text(content)
    return path


@pytest.mark.parametrize("name", ["dump.box", "dump.box.gz"])
@pytest.mark.parametrize(
    ("columns", "scaled"),
    [
        ("id type x y z vx vy vz radius", False),
        ("vz vy vx diameter mass zs ys xs id", True),
        ("xu yu zu vx vy vz radius", False),
    ],
)
def test_packing_and_temperature_of_any_columns(columns, scaled, name, tmp_path):
    frame = dumps.read(written(tmp_path, text(columns=columns, scaled=scaled), name))[0]
    state = dumps.state(frame, {}, 3)
    assert state.packing_fraction == pytest.approx(GAS.packing_fraction, rel=1e-9)
    assert state.temperature == pytest.approx(GAS.granular_temperature, rel=1e-9)
    assert (state.step, state.grains, state.coordination, state.largest_overlap) == (100, 400, 0.0, 0.0)
    assert state.mean_diameter == pytest.approx(2e-3)


def test_sizes_of_a_script_replace_a_missing_column(tmp_path):
    frame = dumps.read(written(tmp_path, text(columns="id type x y z vx vy vz")))[0]
    assert dumps.state(frame, {}, 3).packing_fraction is None
    assert dumps.state(frame, {"1": 1e-3}, 3).packing_fraction == pytest.approx(0.2)


def test_overlaps_reach_through_periodic_sides(tmp_path):
    """Two grains that touch through a side, a third that touches one of them, and walls without a second image."""
    places = np.array([[1e-4, 5e-3, 5e-3], [9e-3, 5e-3, 5e-3], [7.1e-3, 5e-3, 5e-3]])
    three = hl.ParticleSystem(places, np.zeros((3, 3)), 1e-3, 2500.0, box=1e-2, allowed_overlap=0.5)
    through = dumps.state(dumps.read(written(tmp_path, text(three)))[0], {}, 3)
    assert through.coordination == pytest.approx(4 / 3) and through.in_several_contacts == pytest.approx(
        1 / 3
    )
    assert through.largest_overlap == pytest.approx(0.9)
    walls = dumps.state(dumps.read(written(tmp_path, text(three, sides="ff ff ff")))[0], {}, 3)
    assert walls.coordination == pytest.approx(2 / 3) and walls.largest_overlap == pytest.approx(0.1)
    filled = (9e-3 - 1e-4 + 2e-3) * 2e-3 * 2e-3  # between the outermost grains, but within the box
    assert walls.packing_fraction == pytest.approx(3 * 4 / 3 * np.pi * 1e-9 / min(filled, 1e-2 * 4e-6))


def test_impact_speeds_are_those_of_a_maxwellian_gas(tmp_path):
    """Percentiles of g at the density g exp(−g²/4T), whose mean is √(πT)."""
    state = dumps.state(dumps.read(written(tmp_path, text()))[0], {}, 3)
    t = state.temperature
    g = np.sqrt(-4 * t * np.log(np.random.default_rng(2).random(200_000)))
    assert np.quantile(g, [0.1, 0.5, 0.9]) == pytest.approx(state.speeds, rel=0.01)
    assert g.mean() == pytest.approx(state.mean_speed, rel=0.01)


def test_the_hottest_frame_decides(tmp_path):
    cold = GAS.replace(velocities=0.1 * GAS.velocities)
    path = written(tmp_path, text(cold, step=0) + text(step=10) + "\n" + text(cold, step=20))
    several = hl.check(BEAD, law=LAW, dump=path)
    alone = hl.check(BEAD, law=LAW, dump=written(tmp_path, text(), "one"))
    assert len(several.states) == 3 and several.sentence == alone.sentence
    assert [row.speed for row in several.rows] == [row.speed for row in alone.rows]
    direct = hl.check(GAS, law=LAW)
    assert direct.rows[0].tc_nu == pytest.approx(alone.rows[0].tc_nu, rel=1e-6)
    many = written(tmp_path, "".join(text(step=k) for k in range(45)), "many")
    assert len(hl.check(BEAD, law=LAW, dump=many).states) == dumps.MAX_FRAMES


def test_lasting_contacts_are_found(tmp_path):
    """A packing of touching grains is no gas."""
    places = 1.99e-3 * np.stack(np.meshgrid(*[np.arange(6)] * 3), -1).reshape(-1, 3)
    packed = hl.ParticleSystem(
        places + 1e-3, 1e-3 * np.ones((216, 3)), 1e-3, 2500.0, box=6 * 1.99e-3, allowed_overlap=0.1
    )
    verdict = hl.check(BEAD, law=LAW, dump=written(tmp_path, text(packed)))
    assert verdict.admissible is False and "6 contacts on average" in verdict.sentence


BAD = {
    "triclinic": text().replace("BOX BOUNDS pp pp pp", "BOX BOUNDS xy xz yz pp pp pp"),
    "general triclinic": text().replace("BOX BOUNDS pp pp pp", "BOX BOUNDS abc origin pp pp pp"),
    "cut off": text()[:-2000].rsplit("\n", 1)[0],
    "empty": "",
    "no dump": "x y z\n1 2 3\n",
    "words": text().replace("ITEM: ATOMS id type x", "ITEM: ATOMS id type radius2 y").replace(" 1 ", " H "),
    "no step": text().replace("100\n", "many\n", 1),
    "nan": text().replace("0.001\n", "nan\n", 1),
    "binary": "\x00\x01ITEM",
    "no count": text().replace("NUMBER OF ATOMS\n400", "NUMBER OF ATOMS\n-1"),
    "flat": text().replace(f"0 {GAS.box[0]:.12g}", "0 0"),
}


@pytest.mark.parametrize("name", BAD)
def test_other_files_are_refused_in_one_line(name, tmp_path):
    path = written(tmp_path, BAD[name])
    try:
        dumps.read(path)
    except ValueError as error:
        assert str(error).startswith("dump: got ") and "\n" not in str(error)
    else:
        assert name == "words"  # types may be words
    with pytest.raises(ValueError, match=r"\Adump: got .*, cannot be read: .*\Z"):
        dumps.read(tmp_path)
    for missing in (tmp_path / "none", tmp_path / "x.gz"):
        with pytest.raises(FileNotFoundError, match=r"\Adump: .*: no such file\Z"):
            dumps.read(missing)


@pytest.mark.parametrize(
    "columns", ["id x y z vx vy vz radius mass", "type id x y z vx vy vz diameter density"]
)
def test_sizes_and_masses_of_a_dump_replace_missing_ones(columns, tmp_path):
    """A script that reads its grains from a file has neither."""
    script = (
        "units si\natom_style sphere\nread_data data.none\npair_style gran/hooke 1e5 NULL 2e4 NULL 0 0\n"
        "pair_coeff * *\nfix 1 all nve/sphere\ntimestep 1e-7\nrun 1\n"
    )
    content = text(columns=columns.replace("density", "mass"))
    if "density" in columns:  # of each grain, in place of its mass
        content = "\n".join(
            " ".join([*line.split()[:-1], "2500"]) if len(line.split()) == 10 else line
            for line in content.replace(" mass ", " density ").splitlines()
        )
    verdict = hl.check(script, dump=written(tmp_path, content, "dump.gas.gz"))
    (row, *_) = verdict.rows
    assert (row.radius, row.density) == (pytest.approx(1e-3), pytest.approx(2500.0))
    assert row.restitution is not None and row.steps_per_contact and row.tc_nu
    assert not verdict.missing and not verdict.unknown and verdict.admissible is not None


def test_types_that_only_the_dump_shows_are_examined(tmp_path):
    """Half of the grains are large, and their contacts last longest."""
    large = np.arange(400) % 2
    two = GAS.replace(radius=np.where(large, 1e-3, 2e-4), density=2500.0)
    dump = written(tmp_path, text(two, types=1 + large))
    pair = "hooke 2e4 0.9 damping coeff_restitution\n"
    script = f"units si\natom_style sphere\nread_restart old\npair_style granular\npair_coeff * * {pair}"
    run = "timestep 1e-7\nfix 1 all nve/sphere\nrun 100\n"
    verdict = hl.check(script + run, dump=dump)
    assert {row.types for row in verdict.rows} == {("1", "1"), ("1", "2"), ("2", "2")}
    assert verdict.sentence == hl.check(f"{script}pair_coeff 2 2 {pair}{run}", dump=dump).sentence
    grains = "region all block 0 1 0 1 0 1\ncreate_box 1 all\ncreate_atoms 1 single 0 0 0\nset type 1 diameter 2e-3"
    other = hl.check(script.replace("read_restart old", grains) + run, dump=dump)
    assert other.admissible is not True
    assert "grains of type 2 are in the dump, but not in the script" in [
        quote.what for quote in other.unknown
    ]


def test_temperature_counts_masses(tmp_path):
    """Light and heavy grains in equipartition. Densities are columns of the dump, or those of the script."""
    density = np.where(heavy := np.arange(400) % 2, 8000.0, 1000.0)
    mixed = GAS.replace(density=density, velocities=GAS.velocities / np.sqrt(density)[:, None])
    columns = "id type x y z vx vy vz"
    for more, *known in (
        ["radius mass"],
        ["radius density"],
        ["", {"1": 1e-3, "2": 1e-3}, {"1": 1000.0, "2": 8000.0}],
    ):
        frame = dumps.read(written(tmp_path, text(mixed, f"{columns} {more}", types=1 + heavy)))[0]
        radii, densities = known or ({}, {})
        temperature = dumps.state(frame, radii, 3, densities).temperature
        assert temperature == pytest.approx(mixed.granular_temperature, rel=1e-9)
    script = (
        "units si\natom_style sphere\nregion all block 0 1 0 1 0 1\ncreate_box 2 all\n"
        "create_atoms 1 single 0 0 0\ncreate_atoms 2 single 0 0 1\nset type 1 diameter 2e-3 density 1000\n"
        "set type 2 diameter 2e-3 density 8000\npair_style granular\n"
        "pair_coeff * * hooke 2e4 0.9 damping coeff_restitution\ntimestep 1e-7\nfix 1 all nve/sphere\nrun 100\n"
    )
    dump = written(tmp_path, text(mixed, columns, types=1 + heavy))
    assert hl.check(script, dump=dump).states[0].temperature == pytest.approx(
        mixed.granular_temperature, rel=1e-9
    )


@pytest.mark.parametrize("scaled", [False, True])
def test_a_dump_of_disks_needs_no_third_column(scaled, tmp_path):
    disks = hl.ParticleSystem.random(200, 0.3, 1e-3, 2500.0, rms_speed=0.3, dimension=2)
    columns = "id type xs ys vx vy radius" if scaled else "id type x y vx vy radius"
    state = dumps.state(dumps.read(written(tmp_path, text(disks, columns, scaled=scaled)))[0], {}, 2)
    assert state.temperature == pytest.approx(disks.granular_temperature, rel=1e-9)
    assert state.packing_fraction == pytest.approx(0.3) and state.coordination == 0.0


@pytest.mark.parametrize("slope", [0.0, 0.25])
@pytest.mark.parametrize("down", [-1.0, 1.0])
def test_the_column_in_a_round_box_is_weighed(slope, down, tmp_path):
    """A cylinder and a cone do not fill the corners of the box around them, and a cone has fewer grains below."""
    points = np.random.default_rng(5).uniform((-0.01, -0.01, 0.0), (0.01, 0.01, 0.02), (6000, 3))
    points = points[np.hypot(points[:, 0], points[:, 1]) < 0.01 + slope * (points[:, 2] - 0.02)]
    rows = "".join(f"{k} 1 {x} {y} {-down * z} 5e-4 1e-5\n" for k, (x, y, z) in enumerate(points, 1))
    path, ends = tmp_path / "dump.round", "-0.05 0.05\n" * 3
    path.write_text(
        f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{len(points)}\nITEM: BOX BOUNDS ff ff ff\n{ends}"
        f"ITEM: ATOMS id type x y z radius mass\n{rows}"
    )
    bed = dumps.bed(dumps.read(path)[-1], {}, {}, (0.0, 0.0, down), 3)
    assert bed.walled and bed.mass == pytest.approx(6000 * 1e-5 / 0.02**2, rel=0.1)
