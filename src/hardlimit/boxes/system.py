"""``ParticleSystem``: spheres or disks in a box, with their positions and velocities."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from ..support import html, validation
from ..support.formatting import digits, listed
from ..support.progress import Report, reporter
from . import files, spins, starts
from .box import (
    AXES,
    LARGEST,
    LENGTHS,
    Box,
    Floats,
    Vector,
    checked_boundary,
    checked_edges,
    checked_gravity,
    checked_shear,
    read_only,
)
from .files.frame import Frame
from .thermostats import Andersen, RandomKicks, as_entry, checked_thermostat, from_entry
from .walls import MovingWall, as_entries, checked_walls, from_entries

if TYPE_CHECKING:
    import xarray as xr

#: Overlaps up to this, relative to the sum of the radii, count as touching.
ROUNDING: Final = 1e-9


@validation.sealed("write a function of a ParticleSystem")
@dataclass(frozen=True, init=False, repr=False, eq=False)
class ParticleSystem:
    """Spheres (3-D) or disks (2-D) in a box that runs from 0 to its edges.

    Systems are immutable and their arrays read-only; :meth:`replace` makes a changed copy. Two systems are equal if all
    their values are.

    Parameters
    ----------
    positions : (N, d) numbers [m]
        Centres of the particles, d = 2 or 3. Along a periodic axis a centre lies in [0, edge]; between walls the whole
        particle does.
    velocities : (N, d) numbers [m/s]
    radius : number or N numbers [m]
    density : number or N numbers [kg/m³]
        Disks also get the mass of a sphere: they are a monolayer.
    mass : number or N numbers [kg]
        Give exactly one of ``density`` and ``mass``.
    box : d numbers [m]
        Edges, or one number for all of them. A periodic edge is at least four times the largest radius, so that no
        particle touches two images of another one; an edge between walls at least twice.
    boundary : "periodic", "wall", "lees-edwards", or one of them for each axis
        With "lees-edwards" along one axis y (not the first), the box is sheared: the mean flow is
        v_x = shear_rate · (y − L/2) along the first axis, which is periodic. The edge L is at least five times the
        largest radius. Velocities are those in the laboratory. A particle that leaves through the far side comes back
        with v_x − shear_rate · L.
    gravity : number or d numbers [m/s²]
        A vector, or one number for an acceleration against the last axis. 0 along flow and gradient of a sheared box.
        Along a periodic axis all particles fall together, without end; ``repr`` says so.
    walls : mapping of "x-", "x+", … "z+" to MovingWall, optional
        The walls that move, by axis and end: ``{"z-": hl.MovingWall(amplitude=1e-3, frequency=50.0)}`` shakes the
        floor. The box is that of the rest places.
    thermostat : RandomKicks or Andersen, optional
        Heats or thermalizes the particles.
    shear_rate : number [1/s]
        Of a box with a "lees-edwards" boundary; of either sign.
    shear_displacement : number [m]
        Displacement of the images beyond the far side of a sheared box along x, modulo the edge. 0: all images are
        aligned. A state of a run has that of its time, so that a new run goes on from there.
    allowed_overlap : float
        Largest accepted overlap, relative to the sum of the radii (at a wall, to the radius). The default allows for
        rounding errors. Particles in contact under Newton's equations overlap by more.
    angular_velocities : (N, 3) numbers, in 2-D N numbers, optional [rad/s]
        Spins; in 2-D about the normal of the plane, positive from x to y. 0 by default. Only friction changes them.
    inertia_factor : number or N numbers, optional
        q of the moment of inertia q m R², from 1e-6 to 1: 2/5 for solid spheres, 1/2 for solid disks (defaults), 2/3
        for hollow spheres.

    Raises
    ------
    ValueError
        If a value is outside its range or has another shape, a particle lies outside the box, or two overlap; names
        them.

    Notes
    -----
    The granular temperature is that of Goldhirsch, Powder Technol. 182, 130 (2008). The boundary is that of Lees &
    Edwards, J. Phys. C 5, 1921 (1972).

    Examples
    --------
    >>> at, moving = [[0.02, 0.05], [0.04, 0.05]], [[0.1, 0.0], [-0.1, 0.0]]
    >>> hl.ParticleSystem(at, moving, radius=0.005, density=2500.0, box=0.1)
    <ParticleSystem of 2 disks, packing fraction 0.015708, box 0.1 × 0.1 m, periodic>
    >>> hl.ParticleSystem(at, moving, radius=0.015, density=2500.0, box=0.1)
    Traceback (most recent call last):
    ValueError: positions: particles 0 and 1 overlap, gap -0.01 m, ...
    """

    positions: Floats  #: (N, d) [m]
    velocities: Floats  #: (N, d) [m/s]
    radius: Floats  #: (N,) [m]
    mass: Floats  #: (N,) [kg]
    box: Floats  #: (d,) [m]
    boundary: tuple[str, ...]  #: ``"periodic"``, ``"wall"`` or ``"lees-edwards"`` for each axis
    gravity: Floats  #: (d,) [m/s²]
    walls: Mapping[str, MovingWall]  #: the walls that move
    thermostat: RandomKicks | Andersen | None
    shear_rate: float  #: of a Lees–Edwards boundary [1/s]
    shear_displacement: float  #: of the images beyond its far side, in [0, edge) [m]
    #: (N, 3), in 2-D (N,) [rad/s]; None unless it or ``inertia_factor`` was given, or friction acts in the run
    angular_velocities: Floats | None = None
    inertia_factor: Floats | None = (
        None  #: (N,), q of the moment of inertia q m R²; None without angular velocities
    )

    _unfolded = None  # positions along the unfolded paths (N, d) [m], in a state of a run

    def __init__(
        self,
        positions: ArrayLike,
        velocities: ArrayLike,
        radius: float | ArrayLike,
        density: float | ArrayLike | None = None,
        mass: float | ArrayLike | None = None,
        *,
        box: Vector,
        boundary: str | Sequence[str] = "periodic",
        gravity: Vector = 0.0,
        walls: Mapping[str, MovingWall] | None = None,
        thermostat: RandomKicks | Andersen | None = None,
        shear_rate: float = 0.0,
        shear_displacement: float = 0.0,
        allowed_overlap: float = ROUNDING,
        angular_velocities: ArrayLike | None = None,
        inertia_factor: float | ArrayLike | None = None,
    ) -> None:
        parameter = validation.exactly_one(density=density, mass=mass)
        at = validation.rows("positions", positions, (2, 3))
        n, d = at.shape
        size = validation.each("radius", radius, n, **LENGTHS)
        amount = validation.each(parameter, density if parameter == "density" else mass, n, lowest=0.0)
        sides, edges, pull = checked_boundary(boundary, d), checked_edges(box, d), checked_gravity(gravity, d)
        rate, displacement = checked_shear(sides, shear_rate, shear_displacement, edges, pull)
        self._set(
            positions=at,
            velocities=_checked_velocities(velocities, n, d),
            radius=size,
            mass=starts.checked_masses(parameter, amount, size),
            box=edges,
            boundary=sides,
            gravity=pull,
            walls=checked_walls(walls, sides),
            thermostat=checked_thermostat(thermostat, n, sheared="lees-edwards" in sides),
            shear_rate=rate,
            shear_displacement=displacement,
            **spins.checked(angular_velocities, inertia_factor, n, d),
        )
        allowed = validation.number("allowed_overlap", allowed_overlap, 0.0, 1.0, lowest_allowed=True)
        self._check_geometry(allowed)

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False
            if isinstance(value, dict):
                value = MappingProxyType(value)
            object.__setattr__(self, name, value)

    @classmethod
    def _of(cls, **values: Any) -> ParticleSystem:
        """A system of values that are already checked. Keeps the arrays and makes them read-only."""
        self = cls.__new__(cls)
        self._set(**values)
        return self

    def _values(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def _moved(
        self,
        positions: Floats,
        velocities: Floats,
        time: float = 0.0,
        unfolded: Floats | None = None,
        angular_velocities: Floats | None = None,
    ) -> ParticleSystem:
        """The same particles with other positions and velocities, unchecked, after a time in which walls and images
        move [s]. Angular velocities that are None do not change."""
        new = {
            "positions": positions,
            "velocities": velocities,
            "walls": {name: wall.after(time) for name, wall in self.walls.items()},
            "shear_displacement": self.domain.displacement_after(time),
        }
        if angular_velocities is not None:
            new |= {"angular_velocities": angular_velocities, "inertia_factor": self._inertia_factor}
        return self._of(**self._values() | new, _unfolded=unfolded)

    @property
    def driven(self) -> bool:
        """Whether walls move, a thermostat heats or the box is sheared, so that it may reach a steady state."""
        return self._walls_move or self.thermostat is not None or self.shear_rate != 0.0

    @property
    def _walls_move(self) -> bool:
        return any(wall.fastest > 0.0 for wall in self.walls.values())

    @cached_property
    def domain(self) -> Box:
        """The box with its boundaries and gravity.

        :meta private:
        """
        shear = (self.shear_rate, self.shear_displacement)
        return Box(self.box, self.boundary, self.gravity, self.walls, *shear)

    def _check_geometry(self, allowed_overlap: float) -> None:
        self.domain.check_size(float(self.radius.max()))
        _check_inside(self, allowed_overlap)
        first, second, gap = self._deepest_overlap
        apart = float(self.radius[first] + self.radius[second])
        if first >= 0 and -gap > allowed_overlap * apart:
            raise ValueError(
                f"positions: particles {first} and {second} overlap, gap {gap:.6g} m, must be >= "
                f"{validation.at_least(0.0 - allowed_overlap * apart)} m, {allowed_overlap:g} of the sum of the radii, "
                f"{apart:.6g} m; allowed_overlap= accepts more, {validation.at_least(-gap / apart)} here"
            )

    @classmethod
    def random(
        cls,
        n: int,
        packing_fraction: float,
        radius: float | Sequence[float],
        density: float | ArrayLike,
        rms_speed: float,
        *,
        dimension: int = 3,
        seed: int = 0,
        boundary: str | Sequence[str] = "periodic",
        gravity: Vector = 0.0,
        walls: Mapping[str, MovingWall] | None = None,
        thermostat: RandomKicks | Andersen | None = None,
        shear_rate: float = 0.0,
        rms_spin: float | Literal["equal"] | None = None,
        inertia_factor: float | ArrayLike | None = None,
        progress: bool | Report | None = None,
    ) -> ParticleSystem:
        """Particles at random positions without overlap, with Maxwell's velocities.

        The box has equal edges. Dense systems are grown by the event-driven engine (Lubachevsky & Stillinger, J. Stat.
        Phys. 60, 561 (1990)). The positions are disordered, but not in equilibrium: let an elastic gas collide some
        tens of times per particle before you measure.

        Parameters
        ----------
        n : int
            Number of particles.
        packing_fraction : float
            Fraction of the box that the particles fill; at most 0.62 in 3-D and 0.82 in 2-D.
        radius : float, N numbers, or (smallest, largest) [m]
            Two numbers are the limits of a uniform distribution, unless n is 2.
        rms_speed : float [m/s]
            Root mean square of the speeds; the sample has exactly this value. The total momentum along periodic axes is
            zero. In a sheared box these are the velocities relative to the mean flow, which is added to them.
        dimension : int
            2 or 3.
        seed : int
            The same seed gives the same bits. Spins change none of the other values.
        rms_spin : float or "equal", optional [rad/s]
            Root mean square of ω; the sample has exactly this value, and the same mean rotational energy for small
            and large particles. The total is not zero, because friction does not conserve it. ``"equal"``: the
            rotational temperature is the granular temperature. In a sheared box these are spins relative to the
            rotation of the mean flow, half of its vorticity (−shear_rate/2 about z with the gradient along y), which is
            added. By default particles have no spins.
        inertia_factor : number or N numbers, optional
            As for the system; without ``rms_spin`` the particles do not spin.
        progress : bool or callable(done, total), optional
            True shows a bar. A function gets the growth of the particles, in thousandths.

        Raises
        ------
        ValueError
            If a value is outside its range, or the box would be too small because there are too few particles.

        Examples
        --------
        >>> hl.ParticleSystem.random(100, 0.1, radius=1e-3, density=2500.0, rms_speed=0.1)
        <ParticleSystem of 100 spheres, packing fraction 0.1, box ... m, periodic>
        """
        count = starts.count(n)
        d = validation.whole("dimension", dimension, 2, 3)
        sides = checked_boundary(boundary, d)
        pull = checked_gravity(gravity, d)
        limits = {"lowest_allowed": True, "highest_allowed": True}
        speed = validation.number("rms_speed", rms_speed, 0.0, LARGEST, **limits)
        generators = starts.Generators(seed)
        size = starts.radii(radius, count, generators)
        mass = starts.checked_masses("density", validation.each("density", density, count, lowest=0.0), size)
        moving = checked_walls(walls, sides)
        edges = np.full(d, starts.edge(packing_fraction, size, d))
        rate, _ = checked_shear(sides, shear_rate, 0.0, edges, pull)
        box = Box(edges, sides, pull, moving, rate)
        starts.check_size(box, size)
        velocities = starts.velocities(mass, d, speed, box.wraps, generators)
        rotation = starts.rotation(mass, size, velocities, box, rms_spin, inertia_factor, generators)
        with reporter(progress, "random start", "") as report:
            positions = starts.positions(size, box, generators, report)
        if rate:
            velocities += box.mean_flow(positions)
        values = {"positions": positions, "velocities": velocities, "radius": size, "mass": mass}
        return cls._of(
            **values,
            box=box.edges,
            boundary=sides,
            gravity=pull,
            walls=moving,
            thermostat=checked_thermostat(thermostat, n, sheared="lees-edwards" in sides),
            shear_rate=rate,
            shear_displacement=0.0,
            **rotation,
        )

    @classmethod
    def read(
        cls,
        path: str | Path,
        *,
        frame: int = -1,
        units: str | None = None,
        velocities: float | ArrayLike | None = None,
        radius: files.OfTypes | None = None,
        density: files.OfTypes | None = None,
        inertia_factor: float | ArrayLike | None = None,
        boundary: str | Sequence[str] | None = None,
        gravity: Vector | None = None,
        shear_rate: float | None = None,
        allowed_overlap: float | None = None,
    ) -> ParticleSystem:
        """Read a system from a file: extended XYZ (.xyz, .extxyz), GSD (.gsd), LAMMPS data (.data, .lmp), or a text
        dump of LAMMPS or LIGGGHTS with any name, also compressed (.gz).

        Velocities, radii, densities or masses and spins are read as far as the file has them. Particles are sorted by
        their ids, if there are any. In dumps, sides ``pp`` are periodic and ``ff`` walls at the ends of the
        box; positions beyond a periodic side are folded back. Disks are particles at rest in z = 0, or without z.

        Parameters
        ----------
        path : path
        frame : int
            Index of the frame in a trajectory; the last one by default. Frames of a dump without grains do not count.
        units : {"lj", "si", "cgs", "micro", "nano"}, optional
            Units of the file, by LAMMPS' names; SI by default, for LAMMPS data and dumps those that they name. ``"lj"``
            leaves numbers as they are.
        velocities : number or (N, d) numbers, optional [m/s]
            Where the file has none, such as 0 if only the structure is measured; else it must be left out.
        radius : number, N numbers or a mapping of types to numbers, optional [m]
            Where the file has none; else it must be left out.
        density : as radius, optional [kg/m³]
            Where the file has neither densities nor masses.
        inertia_factor : number or N numbers, optional
            As for the system, in place of that of the file. LAMMPS' disks have 2/5, or 1/2 with the word ``disc``.
        boundary : str or one for each axis, optional
            As for the system, in place of that of the file. Walls stand at the sides of the box, or farther out, where
            the outermost particles end.
        gravity : number or d numbers, optional [m/s²]
            As for the system, in place of that of the file.
        shear_rate : number, optional [1/s]
            Of a box that tilts, in files of other programs; it becomes one with the boundary of Lees and Edwards. Tilts
            xy or xz alone have one. Velocities must be those in the laboratory, as with LAMMPS' ``fix deform … remap
            v``.
        allowed_overlap : float, optional
            As for the system. The default allows for rounding errors, also those of the digits of a file.

        Raises
        ------
        ValueError
            If the file cannot be read, is damaged, lacks something, or contains an invalid system; names it.
        FileNotFoundError
            If there is no such file.
        """
        options = files.Options(
            units, velocities, radius, density, boundary, gravity, shear_rate, inertia_factor
        )
        return cls._from_file(path, *files.read(path, frame, options), allowed_overlap)

    @classmethod
    def read_frames(
        cls,
        path: str | Path,
        *,
        units: str | None = None,
        velocities: float | ArrayLike | None = None,
        radius: files.OfTypes | None = None,
        density: files.OfTypes | None = None,
        inertia_factor: float | ArrayLike | None = None,
        boundary: str | Sequence[str] | None = None,
        gravity: Vector | None = None,
        shear_rate: float | None = None,
        allowed_overlap: float | None = None,
    ) -> Iterator[ParticleSystem]:
        """All frames of a file, one after the other, as an iterator that reads each when it is its turn.

        Parameters and errors are those of :meth:`ParticleSystem.read`.
        """
        options = files.Options(
            units, velocities, radius, density, boundary, gravity, shear_rate, inertia_factor
        )
        for arguments, rounding in files.frames(path, options):
            yield cls._from_file(path, arguments, rounding, allowed_overlap)

    @classmethod
    def _from_file(
        cls, path: str | Path, arguments: dict[str, Any], rounding: float, allowed_overlap: float | None
    ) -> ParticleSystem:
        allowed = max(ROUNDING, rounding) if allowed_overlap is None else allowed_overlap
        unfolded = arguments.pop("unfolded", None)
        try:
            system = cls(**arguments, allowed_overlap=allowed)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        if unfolded is not None:
            system._set(_unfolded=unfolded)
        return system

    def write(self, path: str | Path) -> Path:
        """Write the system as extended XYZ, GSD or LAMMPS data, by the ending of ``path``.

        :meth:`read` returns the same numbers to the last bit, except masses in LAMMPS data: the file has densities, and
        some masses have a rounding error. LAMMPS data has the moments of inertia of solid bodies only. An existing file
        is replaced when the new one is complete.

        Parameters
        ----------
        path : path
            Ends in .xyz, .extxyz, .gsd, .data or .lmp.

        Raises
        ------
        ValueError
            If the ending is unknown, the format is not installed, or it cannot hold a value of the system.
        OSError
            If the file cannot be written; names it.
        """
        return files.write(path, [self.as_frame()])

    def as_frame(self, time: float = 0.0) -> Frame:
        """The system at ``time`` [s] as a frame for files.

        :meta private:
        """
        return Frame(**self._values(), time=time)

    def replace(
        self,
        *,
        positions: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
        radius: float | ArrayLike | None = None,
        density: float | ArrayLike | None = None,
        mass: float | ArrayLike | None = None,
        box: Vector | None = None,
        boundary: str | Sequence[str] | None = None,
        gravity: Vector | None = None,
        walls: Mapping[str, MovingWall] | None = None,
        thermostat: RandomKicks | Andersen | Literal["keep"] | None = "keep",
        shear_rate: float | None = None,
        shear_displacement: float | None = None,
        angular_velocities: ArrayLike | None = None,
        inertia_factor: float | ArrayLike | None = None,
        allowed_overlap: float | None = None,
    ) -> ParticleSystem:
        """A copy with the given values changed and all others kept, including the masses.

        Errors are those of the system itself. By default existing overlaps are accepted unless positions, radius, box,
        boundary, walls or the displacement of images change. Another shear rate leaves the velocities as they are. Rate
        and displacement are dropped with the Lees–Edwards boundary.
        """
        if density is not None and mass is not None:
            raise ValueError("density | mass: got both, must be at most one of them")
        new = {
            "positions": positions,
            "radius": radius,
            "box": box,
            "boundary": boundary,
            "walls": walls,
            "shear_displacement": shear_displacement,
        }
        rotation = {"angular_velocities": angular_velocities, "inertia_factor": inertia_factor}
        kept: dict[str, Any] = {
            name: getattr(self, name) if value is None else value for name, value in (new | rotation).items()
        }
        moved = any(value is not None for value in new.values())
        kept["shear_rate"] = self.shear_rate if shear_rate is None else shear_rate
        if boundary is not None and "lees-edwards" not in checked_boundary(boundary, self.dimension):
            flow = {"shear_rate": shear_rate, "shear_displacement": shear_displacement}
            kept |= {name: 0.0 if value is None else value for name, value in flow.items()}
        return ParticleSystem(
            velocities=self.velocities if velocities is None else velocities,
            density=density,
            mass=self.mass if density is None and mass is None else mass,
            gravity=self.gravity if gravity is None else gravity,
            thermostat=self.thermostat
            if isinstance(thermostat, str) and thermostat == "keep"
            else thermostat,
            allowed_overlap=self._accepted(allowed_overlap, moved),
            **kept,
        )

    def _accepted(self, allowed_overlap: float | None, moved: bool) -> float:
        """The overlap that a changed copy may have."""
        if allowed_overlap is not None:
            return allowed_overlap
        return ROUNDING if moved else self.largest_overlap

    @property
    def largest_overlap(self) -> float:
        """Largest overlap relative to the sum of the radii (at a wall, to the radius), at least that of touching.

        :meta private:
        """
        return max(ROUNDING, self._deepest_relative_overlap)

    @cached_property
    def _deepest_overlap(self) -> tuple[int, int, float]:
        """The two particles with the deepest overlap (−1 each for a single particle), and their gap [m]."""
        radius = np.ascontiguousarray(self.radius)
        return _core.deepest_overlap(self.domain.of_core(), self.positions, radius)

    @cached_property
    def _deepest_relative_overlap(self) -> float:
        """The deepest overlap, relative to the sum of the radii (at a wall, to the radius), rounded up."""
        first, second, gap = self._deepest_overlap
        deepest = -gap / float(self.radius[first] + self.radius[second])
        for _, axis, upper in self.domain.walls():
            x, (low, high) = self.positions[:, axis], self.domain.limits(axis)
            inside = (high - x if upper else x - low) / self.radius
            deepest = max(deepest, 1.0 - float(inside.min()))
        return math.nextafter(deepest, 1.0) * (1.0 + 1e-12)

    # --- properties -----------------------------------------------------------------------------------------

    @property
    def n(self) -> int:
        """Number of particles N."""
        return len(self.positions)

    @property
    def dimension(self) -> int:
        """Dimension d: 2 for disks, 3 for spheres."""
        return int(self.positions.shape[1])

    @property
    def unfolded_positions(self) -> Floats:
        """Positions along the paths since the start of the run (N, d) [m], not folded back into the box.

        In a system that is no state of a run they are the positions; of a dump that has them (``xu yu zu`` or ``ix iy
        iz``) they are in its coordinates. They are no part of the value of a system: equality ignores them, and
        :meth:`replace` and :meth:`write` drop them.
        """
        return self.positions if self._unfolded is None else self._unfolded

    @property
    def density(self) -> Floats:
        """Mass divided by the volume of the sphere (N,) [kg/m³]."""
        return read_only(self.mass / (4.0 / 3.0 * math.pi * self.radius**3))

    @cached_property
    def packing_fraction(self) -> float:
        """Fraction of the box that the particles fill, by volume in 3-D and by area in 2-D."""
        return starts.solid_volume(self.radius, self.dimension) / self.domain.volume

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy Σ m v²/2 [J]."""
        return 0.5 * float(np.einsum("i,ij,ij->", self.mass, self.velocities, self.velocities))

    @property
    def inertia(self) -> Floats:
        """Moments of inertia q m R² (N,) [kg m²]; those of solid bodies unless ``inertia_factor`` is given."""
        return read_only(self._inertia_factor * self.mass * self.radius**2)

    @property
    def _inertia_factor(self) -> Floats:
        """q of each particle, also without spins."""
        return spins.solid(self.n, self.dimension) if self.inertia_factor is None else self.inertia_factor

    @property
    def rotational_energy(self) -> float:
        """Rotational energy Σ I ω²/2 [J]."""
        return spins.energy(self.angular_velocities, self.inertia)

    @property
    def rotational_temperature(self) -> float:
        """Rotational temperature T_r = Σ I ω²/(f Σ m) [m²/s²], f = 3 axes of rotation of spheres, 1 of disks."""
        axes = spins.AXES_OF_ROTATION[self.dimension]
        return 2.0 * self.rotational_energy / (axes * float(self.mass.sum()))

    @property
    def momentum(self) -> Floats:
        """Total momentum Σ m v (d,) [kg m/s]."""
        return read_only(self.mass @ self.velocities)

    @property
    def granular_temperature(self) -> float:
        """Granular temperature T = Σ m|v − V|²/(d Σ m) [m²/s²], with the velocity V of the centre of mass; in a sheared
        box v is relative to the mean flow."""
        total = float(self.mass.sum())
        relative = self.velocities - self.momentum / total
        if self.domain.gradient is not None:
            relative = self.velocities - self.domain.mean_flow(self.positions)
            relative -= self.mass @ relative / total
        return float(np.einsum("i,ij,ij->", self.mass, relative, relative)) / (self.dimension * total)

    @property
    def dataset(self) -> xr.Dataset:
        """Dataset over ``particle`` and ``axis``: ``position``, ``velocity``, ``radius`` and ``mass``, with units;
        ``angular_velocity`` and ``inertia_factor`` if there are any."""
        import xarray as xr

        data = {
            "position": (("particle", "axis"), self.positions, {"units": "m"}),
            "velocity": (("particle", "axis"), self.velocities, {"units": "m/s"}),
            "radius": ("particle", self.radius, {"units": "m"}),
            "mass": ("particle", self.mass, {"units": "kg"}),
            "box": ("axis", self.box, {"units": "m", "long_name": "edges, the box runs from 0"}),
            "gravity": ("axis", self.gravity, {"units": "m/s2"}),
            "boundary": ("axis", list(self.boundary), {"long_name": "sides of the box"}),
        }
        if self.angular_velocities is not None:
            dims = ("particle", "axis")[: self.angular_velocities.ndim]
            data["angular_velocity"] = (dims, self.angular_velocities, {"units": "rad/s"})
            data["inertia_factor"] = (
                "particle",
                self.inertia_factor,
                {"units": "1", "long_name": "I/(m R²)"},
            )
        coordinates = {"particle": np.arange(self.n), "axis": list(AXES[: self.dimension])}
        about: dict[str, Any] = {"title": f"Box of {self.n} grains", "source": f"hardlimit {_core.version}"}
        about |= {f"wall {name}": repr(wall) for name, wall in self.walls.items()}
        about |= {} if self.thermostat is None else {"thermostat": repr(self.thermostat)}
        if self.domain.gradient is not None:
            about |= {"shear_rate": self.shear_rate, "shear_displacement": self.shear_displacement}
        return xr.Dataset(data, coordinates, about | {"packing_fraction": self.packing_fraction})

    # --- as a value -----------------------------------------------------------------------------------------

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ParticleSystem):
            return NotImplemented
        theirs = other._values()
        if self.walls != theirs.pop("walls") or self.thermostat != theirs.pop("thermostat"):
            return False
        return all(
            a is getattr(self, name) or np.array_equal(a, getattr(self, name)) for name, a in theirs.items()
        )

    def __hash__(self) -> int:
        return self._digest

    def _drive(self) -> str:
        """Boundary, moving walls, thermostat and shear, with all digits."""
        drive = (self.boundary, as_entries(self.walls), self.thermostat)
        sheared = self.domain.gradient is not None
        return repr((*drive, self.shear_rate, self.shear_displacement) if sheared else drive)

    @cached_property
    def _digest(self) -> int:
        # Adding 0 turns −0, which equals 0, into 0.
        parts = (
            (value + 0.0).tobytes() for value in self._values().values() if isinstance(value, np.ndarray)
        )
        digest = hashlib.blake2b(self._drive().encode() + b"".join(parts), digest_size=8)
        return int.from_bytes(digest.digest(), "little", signed=True)

    def __reduce__(self) -> tuple[Any, ...]:
        values = self._values() | {"walls": dict(self.walls)}
        return partial(ParticleSystem._of, **values, _unfolded=self._unfolded), ()

    def entries(self) -> dict[str, Any]:
        """Boundary, shear, moving walls and thermostat, for JSON.

        :meta private:
        """
        return {
            "boundary": list(self.boundary),
            "shear": [self.shear_rate, self.shear_displacement],
            "walls": as_entries(self.walls),
            "thermostat": as_entry(self.thermostat),
        }

    @classmethod
    def from_entries(cls, entries: Mapping[str, Any], **arrays: Floats | None) -> ParticleSystem:
        """The system of :meth:`entries` and its arrays. Raises KeyError, TypeError or ValueError for damaged ones.

        :meta private:
        """
        arrays = {**spins.NONE, **arrays}
        return cls._of(
            boundary=tuple(entries["boundary"]),
            shear_rate=float(entries["shear"][0]),
            shear_displacement=float(entries["shear"][1]),
            walls=from_entries(entries["walls"]),
            thermostat=from_entry(entries["thermostat"]),
            **arrays,
        )

    def __repr__(self) -> str:
        sides = "/".join(dict.fromkeys(self.boundary))
        sides += f", in free fall along {_falls_along(self)}" if self.domain.common_fall.any() else ""
        return (
            f"<ParticleSystem of {self.count()}, packing fraction {self.packing_fraction:.6g}, "
            f"box {_times(self.box)} m, {sides}>"
        )

    def count(self) -> str:
        """The number of particles as text, such as ``10 disks``.

        :meta private:
        """
        return f"{self.n} {'spheres' if self.dimension == 3 else 'disks'}"

    def _repr_html_(self) -> str:
        return html.table(f"{self.count()} in a box", ["", ""], [list(row) for row in described(self)])


def described(system: ParticleSystem) -> list[tuple[str, str]]:
    """Labels and values for the table of a system."""
    overlap = system.largest_overlap
    rows = [
        ("box [m]", _times(system.box)),
        ("sides", ", ".join(f"{axis} {side}" for axis, side in zip(AXES, system.boundary, strict=False))),
        ("packing fraction φ", digits(system.packing_fraction)),
        *([("largest overlap, of the sum of radii", digits(overlap, 3))] if overlap > ROUNDING else []),
        ("radius [m]", _between(system.radius)),
        ("mass [kg]", _between(system.mass)),
        ("granular temperature [m²/s²]", digits(system.granular_temperature)),
        ("kinetic energy [J]", digits(system.kinetic_energy)),
    ]
    if system.angular_velocities is not None:
        rows.append(("rotational energy [J]", digits(system.rotational_energy)))
        rows.append(("rotational temperature [m²/s²]", digits(system.rotational_temperature)))
    if system.gravity.any():
        rows.append(("gravity [m/s²]", "(" + ", ".join(f"{g:.6g}" for g in system.gravity) + ")"))
    if system.domain.common_fall.any():
        rows.append(
            (f"free fall along {_falls_along(system)}", "of all together, without end: no wall there")
        )
    if system.domain.gradient is not None:
        rows.append(("shear rate [1/s]", digits(system.shear_rate)))
    rows += [(f"wall {name}", wall.report()) for name, wall in system.walls.items()]
    rows += [] if system.thermostat is None else [("thermostat", system.thermostat.report())]
    return rows


def _falls_along(system: ParticleSystem) -> str:
    """The periodic axes along which gravity acts."""
    fall = system.domain.common_fall
    return listed([axis for axis, g in zip(AXES, fall.tolist(), strict=False) if g], "and")


def _times(box: Floats) -> str:
    return " × ".join(f"{edge:.6g}" for edge in box)


def _between(values: Floats) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.6g}" if low == high else f"{low:.6g} … {high:.6g}"


# --- checks of the input ------------------------------------------------------------------------------------


def _checked_velocities(velocities: Any, n: int, d: int) -> Floats:
    checked = validation.rows("velocities", velocities, (d,))
    if len(checked) != n:
        raise ValueError(f"velocities: got shape {checked.shape}, must be ({n}, {d}) as the positions")
    if np.abs(checked).max() > LARGEST:
        raise ValueError(f"velocities: got {np.abs(checked).max():.16g}, must be at most {LARGEST:g}")
    return checked


def _check_inside(system: ParticleSystem, allowed_overlap: float) -> None:
    for axis, side in enumerate(system.boundary):
        x, (low, high) = system.positions[:, axis], system.domain.limits(axis)
        inner = system.radius * (1.0 - allowed_overlap) if side == "wall" else np.broadcast_to(0.0, system.n)
        good = (x >= low + inner) & (x <= high - inner)
        if not good.all():
            bad = int(np.argmin(good))
            where = "with its whole radius between the walls" if side == "wall" else "in the box"
            if side == "wall" and low <= x[bad] <= high:
                where += "; allowed_overlap= accepts more"
            accepted = validation.describe_range(
                float(low + inner[bad]), float(high - inner[bad]), True, True
            )
            raise ValueError(
                f"positions[{bad}]: got {AXES[axis]} = {x[bad]:.16g}, must be {accepted}, {where}"
            )
