"""Write the input script of LAMMPS."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..box import AXES, component_axes
from ..system import ParticleSystem
from .forces import Rotation, Types, factor_of

#: Limits of the skin of the neighbour list, in mean radii. Between them, the skin is half the mean gap of neighbours.
SKINS: Final = (0.1, 1.0)
NUMBERS: Final = "format float %.17g"
MOVING: Final = "id x y z vx vy vz"
SPIN: Final = "omegax omegay omegaz"


@dataclass(frozen=True)
class Plan:
    """End, time step, samples and log of a run."""

    until: float  #: [s]
    samples: int  #: intervals between samples of the series
    per_sample: int  #: number of steps between two samples
    time_step: float  #: [s]
    log: bool  #: whether contacts are written at every step, not only at the samples

    @property
    def n_steps(self) -> int:
        """Number of steps of the whole run."""
        return self.samples * self.per_sample if self.until > 0.0 else 0


def script(
    system: ParticleSystem,
    types: Types,
    coefficients: Mapping[tuple[int, int | None], str],
    plan: Plan,
    header: Sequence[str],
    rotation: Rotation | None,
) -> str:
    """The input script. The keys of ``coefficients`` are pairs (i, j) of types, or (i, None) for a type and a wall.

    ``rotation`` is None without friction; it is not integrated then.
    """
    parts = [
        [f"# {line}".rstrip() for line in header],
        _box(system),
        _forces(coefficients),
        _walls(system, types, coefficients, rotation),
        _motion(system, plan, rotation),
        [*_output(system, types, plan, rotation), *_contacts(system, plan, rotation)],
        _run(system, plan, rotation),
    ]
    return "\n".join(line for part in parts for line in [*part, ""]).replace("\n\n\n", "\n\n")


def _box(system: ParticleSystem) -> list[str]:
    sides = " ".join("f" if side == "wall" else "p" for side in system.boundary)
    return [
        "# the box and its particles",
        "units si",
        f"dimension {system.dimension}",
        f"boundary {sides}{' p' if system.dimension == 2 else ''}",
        "atom_style sphere",
        "newton on",
        "comm_modify vel yes",
        "read_data start.data",
        f"neighbor {skin(system):.6g} bin",
        "neigh_modify delay 0 every 1 check yes",
    ]


def _forces(coefficients: Mapping[tuple[int, int | None], str]) -> list[str]:
    pairs = [f"pair_coeff {i + 1} {j + 1} {text}" for (i, j), text in coefficients.items() if j is not None]
    return ["# forces", "pair_style granular", *pairs]


def skin(system: ParticleSystem) -> float:
    """Skin of the neighbour list [m]."""
    mean = float(system.radius.mean())
    spacing = (system.domain.volume / system.n) ** (1.0 / system.dimension)
    return float(mean * np.clip(0.5 * (spacing / mean - 2.0), *SKINS))


def _walls(
    system: ParticleSystem,
    types: Types,
    coefficients: Mapping[tuple[int, int | None], str],
    rotation: Rotation | None,
) -> Iterator[str]:
    """One command for each wall, since LAMMPS uses only the nearer one of two walls in one command."""
    told = " contacts" if rotation else ""
    if "wall" not in system.boundary:
        return
    yield "# walls"
    for i in range(len(types)):
        group = "all" if len(types) == 1 else f"type{i + 1}"
        if group != "all":
            yield f"group {group} type {i + 1}"
        for axis, name in enumerate(AXES[: system.dimension]):
            if system.boundary[axis] == "wall":
                wall = f"{group} wall/gran granular {coefficients[i, None]} {name}plane"
                yield f"fix {name}low{i + 1} {wall} 0.0 NULL{told}"
                yield f"fix {name}high{i + 1} {wall} NULL {float(system.box[axis])!r}{told}"


def _motion(system: ParticleSystem, plan: Plan, rotation: Rotation | None) -> Iterator[str]:
    """Gravity and time integration."""
    yield "# motion"
    pull = system.gravity - system.domain.common_fall
    if pull.any():
        size = float(np.sqrt(pull @ pull))
        along = " ".join(map(repr, [*pull.tolist(), 0.0][:3]))
        yield f"fix pull all gravity {size!r} vector {along}"
    if (gradient := system.domain.gradient) is not None:
        yield "# Lees–Edwards boundary: images move as the box tilts"
        # With flips, LAMMPS would leave the velocities of particles that have just crossed a side as they were.
        yield f"fix shear all deform 1 x{AXES[gradient]} erate {system.shear_rate!r} remap v flip no"
    yield "fix move all nve" + (f"/sphere{rotation.disc}" if rotation else "")
    if system.dimension == 2:
        yield "fix plane all enforce2d"
    yield f"timestep {plan.time_step!r}"


def _output(system: ParticleSystem, types: Types, plan: Plan, rotation: Rotation | None) -> Iterator[str]:
    yield "# at each sample: energies, momentum, Σ m v⊗v, virial of pairs as a mean over the steps since the last one"
    yield "variable none equal 0.0"
    commands, columns = _kinetic(system, plan)
    yield from commands
    yield "compute virial all pressure NULL pair"
    yield f"fix virial all {_mean(plan)} {_list('c_virial', 6)}"
    if system.gravity.any():  # the energy of fix gravity uses positions that jump at periodic boundaries
        yield "compute path all property/atom xu yu zu"
        lifted = "".join(f"{-g:+.17g}*c_path[{axis + 1}]" for axis, g in enumerate(system.gravity.tolist()))
        yield f'variable lifted atom "mass*({lifted})"'
        yield "compute potential all reduce sum v_lifted"
    yield f"variable potential equal {'c_potential' if system.gravity.any() else '0.0'}"
    turning = torque = " ".join(["v_none"] * 4)
    if rotation:
        yield from _rotation(system)
        turning = _list("c_turning", 4)
        if walls := _walls_of(system):
            yield from _wall_torques(system, walls, types, plan)
            torque = _list("f_torque", 4)
    yield f"thermo_style custom step {columns} v_potential {_list('f_virial', 6)} {turning} {torque}"
    yield f"thermo_modify line one lost error flush yes {NUMBERS}"
    yield f"thermo {plan.per_sample}"


def _run(system: ParticleSystem, plan: Plan, rotation: Rotation | None) -> Iterator[str]:
    yield f"run {plan.n_steps}"
    crossings = f"i{AXES[system.domain.gradient or 1]}"  # through the sides of a sheared box
    state = f"xu yu zu vx vy vz {crossings}{f' {SPIN}' if rotation else ''}"
    yield f"write_dump all custom end.dump id {state} modify sort id {NUMBERS}"


def _rotation(system: ParticleSystem) -> Iterator[str]:
    """Commands for the rotational energy and the spin; ``compute erotate/sphere`` takes disks for spheres."""
    yield "# with friction: rotational energy and spin, and at walls the torques of these"
    yield "compute omega all property/atom omegax omegay omegaz"
    yield f'variable inertia atom "{float(factor_of(system)[0])!r}*mass*radius*radius"'
    omega = [f"c_omega[{k}]" for k in (1, 2, 3)]
    yield f'variable rotation atom "0.5*v_inertia*({"+".join(f"{w}*{w}" for w in omega)})"'
    for axis, w in zip(AXES, omega, strict=True):
        yield f'variable spin{axis} atom "v_inertia*{w}"'
    yield "compute turning all reduce sum v_rotation v_spinx v_spiny v_spinz"


def _wall_torques(
    system: ParticleSystem, walls: list[tuple[int, bool, str]], types: Types, plan: Plan
) -> Iterator[str]:
    """Commands for the forces of walls on particles, and for means of sums since the last sample: of their torques, and
    of the power of their forces on a mean flow."""
    torque: list[list[str]] = [[], [], []]
    for axis, upper, wall in walls:
        for k, along in enumerate(AXES):
            parts = "+".join(f"f_{wall}{i + 1}[{2 + k}]" for i in range(len(types)))
            yield f'variable {wall}{along} atom "{parts}"'
        second, third = (axis + 1) % 3, (axis + 2) % 3  # e × F at the upper wall, −e × F at the lower one
        torque[second].append(f"{'-' if upper else '+'}v_{wall}{AXES[third]}")
        torque[third].append(f"{'+' if upper else '-'}v_{wall}{AXES[second]}")
    for name, signed in zip(AXES, torque, strict=True):
        yield f'variable torque{name} atom "radius*(0.0{"".join(signed)})"'
    flow = "0.0" if system.domain.gradient is None else _mean_flow(system, system.domain.gradient)
    along = "+".join(f"v_{wall}x" for _, _, wall in walls)
    yield f'variable flowing atom "({flow})*({along})"'
    yield "compute torque all reduce sum v_torquex v_torquey v_torquez v_flowing"
    yield f"fix torque all {_mean(plan)} {_list('c_torque', 4)}"


def _walls_of(system: ParticleSystem) -> list[tuple[int, bool, str]]:
    """Axis, whether it is the upper one, and name of each wall."""
    return [
        (axis, upper, AXES[axis] + ("high" if upper else "low")) for _, axis, upper in system.domain.walls()
    ]


def _contacts(system: ParticleSystem, plan: Plan, rotation: Rotation | None) -> Iterator[str]:
    """Dumps of the overlaps. With friction they have tangential forces, and all that tells the slip at walls."""
    every = 1 if plan.log else plan.per_sample
    yield f"# contacts, {'at every step' if plan.log else 'at each sample'}"
    forces = "p1 p2 p3 p10 p11 p12 " if rotation else ""
    yield "compute pair all property/local patom1 patom2 cutoff radius"
    yield f"compute force all pair/local dist force {forces}cutoff radius"
    columns = f"{_list('c_pair', 2)} {_list('c_force', 2 + len(forces.split()))}"
    yield f"dump pairs all local {every} pairs.dump {columns}"
    yield f"dump_modify pairs {NUMBERS}"
    if "wall" in system.boundary:
        yield f'variable touches atom "{_touches(system)}"'
        columns = " ".join(f"v_{wall}{along}" for _, _, wall in _walls_of(system) for along in AXES)
        columns = f"{MOVING} {SPIN} {columns}" if rotation else MOVING
        yield f"dump walls all custom {every} walls.dump {columns}"
        yield f"dump_modify walls thresh v_touches > 0 {NUMBERS}"
    if rotation and rotation.damped:
        yield "# motion of what touches, for the damping beside springs"
        yield "compute touching all contact/atom"
        yield f"dump motion all custom {plan.per_sample} motion.dump {MOVING} {SPIN}"
        yield f"dump_modify motion thresh c_touching > 0 {NUMBERS}"


def _mean(plan: Plan) -> str:
    return f"ave/time 1 {plan.per_sample} {plan.per_sample}"


def _kinetic(system: ParticleSystem, plan: Plan) -> tuple[list[str], str]:
    """Commands and columns of the log: kinetic energy, momentum, Σ m v⊗v, and two columns for a sheared box.

    These are the momentum of the mean flow, and the component of Σ m v⊗v along flow and gradient as a mean over the
    steps since the last sample; 0 without shear. In a sheared box Σ m v⊗v is that relative to the mean flow.
    """
    commands = [f"variable p{axis} equal vcm(all,{axis})*mass(all)" for axis in AXES]
    axis = system.domain.gradient
    if axis is None:
        return [*commands, "compute kinetic all ke", "compute moving all temp"], (
            f"c_kinetic v_px v_py v_pz {_list('c_moving', 6)} v_none v_none"
        )
    y, edge, rate = AXES[axis], float(system.box[axis]), system.shear_rate
    # LAMMPS maps particles back into the box only when it renews its neighbour lists.
    velocities = {
        "inside": f"vx-floor({y}/{edge!r})*({rate * edge!r})",
        "relative": f"vx-{_mean_flow(system, axis)}",
    }
    c = ["v_relative", "vy", "vz"]
    sums = [
        *(f"mass*{c[i]}*{c[j]}" for i, j in zip(*component_axes(3), strict=True)),
        "0.5*mass*(v_inside*v_inside+vy*vy+vz*vz)",
        "mass*v_inside",
        "mass*(v_inside-v_relative)",
    ]
    atoms = velocities | {f"sum{k}": text for k, text in enumerate(sums, 1)}
    names = " ".join(f"v_sum{k}" for k in range(1, len(sums) + 1))
    commands += [f'variable {name} atom "{text}"' for name, text in atoms.items()]
    commands += [
        f"compute sums all reduce sum {names}",
        f"fix across all {_mean(plan)} c_sums[{3 + axis}]",
    ]
    return commands, f"c_sums[7] c_sums[8] v_py v_pz {_list('c_sums', 6)} c_sums[9] f_across"


def _mean_flow(system: ParticleSystem, axis: int) -> str:
    return f"({system.shear_rate!r})*({AXES[axis]}-{0.5 * float(system.box[axis])!r})"


def _list(name: str, count: int) -> str:
    return " ".join(f"{name}[{k}]" for k in range(1, count + 1))


def _touches(system: ParticleSystem) -> str:
    """A formula for LAMMPS that is true for particles that overlap a wall."""
    sides = zip(AXES, system.box.tolist(), system.boundary, strict=False)
    return "||".join(f"{x}<radius||{x}>{edge!r}-radius" for x, edge, side in sides if side == "wall")
