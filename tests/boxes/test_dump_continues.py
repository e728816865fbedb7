"""A state of LAMMPS that is read from a dump goes on as in LAMMPS, through contacts that are in progress."""

import subprocess

import numpy as np
import pytest

import hardlimit as hl
from box_engines import needs_lammps
from hardlimit.boxes.lammps import program

#: Smooth grains between floor and lid in cgs units: 1e5 dyn/cm, 2 g/s.
SCRIPT = """
units cgs
atom_style sphere
boundary p p f
newton off
comm_modify vel yes
region box block -1 0 0 1 -0.5 1
create_box 1 box
region fill block -1 0 0 1 -0.4 0.9
create_atoms 1 random 120 11 fill overlap 0.12 maxtry 4000
set type 1 diameter 0.12 density 2.5
velocity all create 1.0 7 dist gaussian
velocity all scale 1e16
pair_style granular
pair_coeff * * hooke 1e5 2.0 damping velocity limit_damping tangential linear_nohistory 0 0
fix 1 all nve/sphere
fix 2 all gravity 981 vector 0 0 -1
fix 3 all wall/gran granular hooke 1e5 2.0 damping velocity limit_damping tangential linear_nohistory 0 0 zplane -0.5 1
timestep 2e-7
run 5000
dump 1 all custom 5000 dump.gas.gz id type zs ys xs vx vy vz diameter
dump_modify 1 format float %.15g units yes
run 5000
"""


@needs_lammps
@pytest.mark.slow
def test_a_state_goes_on_as_in_lammps(tmp_path):
    (tmp_path / "in.gas").write_text(SCRIPT)
    lmp = program.find(1)
    command = lmp.command(1, "-in", "in.gas", "-log", "none", "-screen", "none")
    subprocess.run(command, cwd=tmp_path, env=lmp.environment(), check=True)
    options = {"density": 2500.0, "gravity": 9.81, "allowed_overlap": 0.1}
    start, end = hl.ParticleSystem.read_frames(tmp_path / "dump.gas.gz", **options)
    law = hl.LinearDashpot(stiffness=100.0, damping=2e-3)
    speed = float(np.sqrt(np.mean(start.velocities**2)))
    for engine in ("events", "steps"):
        run = hl.molecular_dynamics(start, law=law, until=1e-3, engine=engine, samples=2)
        assert run.series.n_in_contact.values[0] >= 1 and run.n_contacts > 10
        apart = run.system.positions - end.positions
        apart -= np.where(start.domain.wraps, start.box * np.round(apart / start.box), 0.0)
        assert np.abs(apart).max() < 2e-4 * start.radius[0]
        assert np.abs(run.system.velocities - end.velocities).max() < 2e-3 * speed
