"""Logs give the same as the scripts from which they come."""

import dataclasses

import pytest

from hardlimit.checking.scripts import read

SCRIPT = """# three stiffnesses
variable k index 1e5 2e5
variable d equal 0.02
atom_style sphere
region box block 0 1 0 1 0 1
create_box 1 box
pair_style granular
label again
pair_coeff * * hooke ${k} &
   0.5 damping coeff_restitution # not $d
fix ins all pour 10 1 1 region box diam range $d $(2*v_d) dens 2500 2500
fix grav all gravity $(9.8+0.01:%.2f) vector 0 0 -1
print "pair_coeff of ${k}"
run 100
next k
jump SELF again
if "$d > 0.01" then "timestep 1e-5"
run 50
"""
#: What LAMMPS writes for this script: each command, and the same command after each replacement of a variable.
LOG = """LAMMPS (22 Jul 2025 - Update 1)
OMP_NUM_THREADS environment is not set. Defaulting to 1 thread. (src/comm.cpp:99)
  using 1 OpenMP thread(s) per MPI task
# three stiffnesses
variable k index 1e5 2e5
variable d equal 0.02
atom_style sphere
region box block 0 1 0 1 0 1
create_box 1 box
Created orthogonal box = (0 0 0) to (1 1 1)
  1 by 1 by 1 MPI processor grid
pair_style granular
label again
pair_coeff * * hooke ${k}    0.5 damping coeff_restitution # not $d
pair_coeff * * hooke 1e5    0.5 damping coeff_restitution
fix ins all pour 10 1 1 region box diam range $d $(2*v_d) dens 2500 2500
fix ins all pour 10 1 1 region box diam range 0.02 $(2*v_d) dens 2500 2500
fix ins all pour 10 1 1 region box diam range 0.02 0.04000000000000000083 dens 2500 2500
Particle insertion: 100 every 100 steps, 10 by step 1
fix grav all gravity $(9.8+0.01:%.2f) vector 0 0 -1
fix grav all gravity 9.81 vector 0 0 -1
print "pair_coeff of ${k}"
pair_coeff of 1e5
run 100
Per MPI rank memory allocation (min/avg/max) = 3.1 | 3.1 | 3.1 Mbytes
   Step          Temp
         0   0
       100   1.5
Loop time of 0.01 on 1 procs for 100 steps with 10 atoms

next k
jump SELF again
pair_coeff * * hooke ${k}    0.5 damping coeff_restitution # not $d
pair_coeff * * hooke 2e5    0.5 damping coeff_restitution
fix ins all pour 10 1 1 region box diam range $d $(2*v_d) dens 2500 2500
fix ins all pour 10 1 1 region box diam range 0.02 $(2*v_d) dens 2500 2500
fix ins all pour 10 1 1 region box diam range 0.02 0.04000000000000000083 dens 2500 2500
fix grav all gravity $(9.8+0.01:%.2f) vector 0 0 -1
fix grav all gravity 9.81 vector 0 0 -1
print "pair_coeff of ${k}"
pair_coeff of 2e5
run 100
WARNING: something about a fix
  create_atoms CPU = 0.001 seconds
next k
jump SELF again
if "$d > 0.01" then "timestep 1e-5"
timestep 1e-5
run 50
Total wall time: 0:00:00
"""


def plain(description):
    """A description without places, which differ."""
    stages = []
    for stage in description.stages:
        contacts = [
            (c.types, c.wall, {name: s.words for name, s in c.settings.items()}) for c in stage.contacts
        ]
        stages.append(dataclasses.replace(stage, quote=None, contacts=contacts))
    notes = [
        [(note.what, note.types) for note in part] for part in (description.ignored, description.invalidates)
    ]
    return stages, notes, description.unknown


def test_a_log_gives_the_same_as_its_script():
    script, log = read(SCRIPT), read(LOG)
    assert plain(script) == plain(log)
    assert (script.version, log.version) == (None, "22 Jul 2025 - Update 1")
    assert [stage.contacts[0].settings["normal"].words[1] for stage in log.stages] == ["1e5", "2e5", "2e5"]
    assert log.stages[0].grains["1"].radii == pytest.approx((0.01, 0.02)) and log.stages[2].time_step == 1e-5
    quote = log.stages[0].contacts[0].quotes[0]
    assert LOG.splitlines()[quote.line - 1].startswith("pair_coeff * * hooke ${k}")


def test_a_log_in_a_file(tmp_path):
    path = tmp_path / "log.lammps"
    path.write_text(LOG.replace("\n", "\r\n"))
    assert plain(read(path)) == plain(read(LOG))
    assert read(path).stages[0].quote.file == "log.lammps"


@pytest.mark.parametrize("before", [3, 80])
@pytest.mark.parametrize("headed", [True, False])
def test_logs_that_begin_later_or_with_lines_of_another_program(before, headed):
    """The command ``log`` begins a file without a header; a capture of the screen may begin with those of OpenFOAM."""
    foam = "/*---*\\\n| \\\\ / F ield | OpenFOAM: The Open Source CFD Toolbox |\nCreate time\n// it's only 'one\n"
    first, rest = LOG.split("\n", 1)
    log = foam * (before // 4 + 1) * headed + (f"{first}\n" if headed else "units lj\n") + rest
    log = log.replace("WARNING: something", "WARNING: it doesn't")
    script, description = read(SCRIPT), read(log)
    assert plain(description)[0] == [
        dataclasses.replace(stage, units_given=not headed) for stage in plain(script)[0]
    ]
    assert description.version == ("22 Jul 2025 - Update 1" if headed else None) and not description.unknown
    (late,) = read(rest).unknown
    assert late.text == "units: the log begins after them"


def test_logs_of_liggghts():
    log = """LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0, compiled 2022-01-01-00:00:00 by someone, git commit unknown)
variable e equal 0.9
units si
create_box 1 box
fix m1 all property/global youngsModulus peratomtype 5.e6
fix m2 all property/global poissonsRatio peratomtype 0.45
fix m3 all property/global coefficientRestitution peratomtypepair 1 ${e}
fix m3 all property/global coefficientRestitution peratomtypepair 1 0.9
pair_style gran model hertz tangential history
pair_coeff * *
create_atoms 1 single 0 0 0
Created 1 atoms
run 1
Setting up run at Sat Jan  1 00:00:00 2022
"""
    description = read(log)
    assert description.code == "liggghts" and description.version.startswith("LIGGGHTS-PUBLIC 3.8.0")
    assert description.stages[0].contacts[0].settings["coefficientRestitution"].words == ("0.9",)


def test_a_log_without_commands_is_refused():
    with pytest.raises(ValueError, match="no granular contacts"):
        read("LAMMPS (22 Jul 2025)\nStep Temp\n 1 2\n")
