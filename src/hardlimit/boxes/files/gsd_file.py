"""GSD files, the binary trajectory format of HOOMD-blue, read and written with the library gsd.

The format has single precision, and its origin is in the middle of the box. We store the same values in double
precision under ``log``, so that a system is read back to the last bit. Walls, their motion and gravity, which GSD does
not have, are stored there as well. OVITO can read the files.

Spheres have no orientation: the quaternion q of the format keeps its default, 1. Angular momenta L are stored as
HOOMD-blue does, p = 2 q s with s = (0, L) in the frame of the body (Kamberaj, Li & Hansen, J. Chem. Phys. 122, 224114
(2005)).
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from ...support import saving
from .. import spins
from ..thermostats import as_entry, from_entry
from ..walls import as_entries, from_entries
from .frame import Append, Floats, Found, Frame, boundary_of, check_frame, three

#: Names under ``log`` of the values in double precision.
OF_PARTICLES: Final = {
    name: f"particles/hardlimit/{name}" for name in ("positions", "velocities", "radius", "mass")
}
OF_BOX: Final = {name: f"hardlimit/{name}" for name in ("box", "periodic", "gravity", "time")}

#: The same of particles with spins; empty without.
OF_SPINS: Final = {name: f"particles/hardlimit/{name}" for name in ("angular_velocities", "inertia_factor")}
#: Moving walls, thermostat and shear under ``log``, as JSON.
DRIVING: Final = "hardlimit/driving"


def _library() -> Any:
    try:
        import gsd.hoomd
    except ImportError:
        raise ValueError("a .gsd file requires the library gsd: pip install 'hardlimit[files]'") from None
    return gsd.hoomd


@contextmanager
def appender(path: Path, more: bool = False) -> Iterator[Append]:
    """Frames of a new file, or ``more`` of an existing one, each with the index that makes it readable."""
    library = _library()
    with library.open(str(path), "r+" if more else "w") as file:

        def append(frame: Frame) -> None:
            file.append(_made(library.Frame(), len(file), frame))
            file.flush()

        yield append


def times(path: Path) -> list[float]:
    """Times of all complete frames [s]."""
    try:
        with _library().open(str(path), "r") as file:
            name = f"log/{OF_BOX['time']}"
            return [float(file.file.read_chunk(frame=k, name=name)[0]) for k in range(len(file))]
    except (RuntimeError, OSError, KeyError):  # no GSD file, or one of another program
        return []


def cut(path: Path, keep: int) -> None:
    """Remove all but the first frames; GSD files can only grow, so that they are copied."""
    library = _library()
    with library.open(str(path), "r") as old:
        if len(old) == keep:
            return
        with saving.whole(path) as unfinished, library.open(str(unfinished), "w") as file:
            file.extend(old[k] for k in range(keep))


def _made(snapshot: Any, step: int, frame: Frame) -> Any:
    """A frame of the library gsd."""
    snapshot.configuration.step = step
    snapshot.configuration.dimensions = len(frame.box)
    snapshot.configuration.box = [*_single(three(frame.box)), 0.0, 0.0, 0.0]
    snapshot.particles.N = len(frame.positions)
    for name, values in _in_single(vars(frame)).items():
        setattr(snapshot.particles, name, values)
    for name, key in OF_PARTICLES.items():
        snapshot.log[key] = np.ascontiguousarray(getattr(frame, name))
    snapshot.log[OF_BOX["box"]] = np.array(frame.box)
    wraps, shear = frame.sides
    snapshot.log[OF_BOX["periodic"]] = np.array(wraps, np.uint8)
    snapshot.log[OF_BOX["gravity"]] = np.array(frame.gravity)
    snapshot.log[OF_BOX["time"]] = np.array([frame.time])
    driving: dict[str, Any] = {"walls": as_entries(frame.walls), "thermostat": as_entry(frame.thermostat)}
    if shear:
        driving["shear"] = shear
    # A value that only some frames omit would be that of the first frame.
    for name, key in OF_SPINS.items():
        values = getattr(frame, name)
        snapshot.log[key] = np.empty(0) if values is None else np.ascontiguousarray(values)
    snapshot.log[DRIVING] = np.frombuffer(json.dumps(driving).encode(), np.uint8)
    return snapshot


def _single(values: Floats) -> Any:
    with np.errstate(over="ignore"):
        single = values.astype(np.float32)
    if not np.isfinite(single).all():
        raise ValueError("got a value too large for GSD, must be below 3.4e38 (single precision)")
    return single


def _in_single(values: dict[str, Any]) -> dict[str, Any]:
    """The values of particles in single precision: angular momenta as 2 (0, I ω), about the axes of the box."""
    n = len(values["positions"])
    momentum, inertia = np.zeros((n, 4)), np.zeros((n, 3))
    if values.get("angular_velocities") is not None:
        inertia[:] = (values["inertia_factor"] * values["mass"] * values["radius"] ** 2)[:, None]
        momentum[:, 1:] = 2.0 * inertia * spins.for_core(values["angular_velocities"])
    return {
        "position": _single(three(values["positions"] - 0.5 * values["box"])),
        "velocity": _single(three(values["velocities"])),
        "diameter": _single(2.0 * values["radius"]),
        "mass": _single(values["mass"]),
        "moment_inertia": _single(inertia),
        "angmom": _single(momentum),
    }


def read(path: Path, frame: int) -> Found:
    library = _library()
    try:
        with library.open(str(path), "r") as file:
            count = len(file)
            check_frame(frame, count)
            for index in {0, frame % count}:  # a frame omits values that equal those of the first frame
                _check_counts(file.file, index, path.stat().st_size)
            snapshot = file[frame % count]
    except (RuntimeError, OSError, KeyError, TypeError, AssertionError) as error:
        raise ValueError(f"not a GSD file of particles, or damaged: {_line(error)}") from None
    tilted = np.any(snapshot.configuration.box[3:])
    if snapshot.particles.N == 0 or tilted:
        raise ValueError(
            f"got {'a tilted box' if tilted else 'no particles'}, must be particles in a box along the axes"
        )
    if OF_PARTICLES["positions"] in snapshot.log:
        return _in_double(snapshot)
    return _of_another_program(snapshot)


def frames(path: Path) -> Iterator[Found]:
    """All frames, one after the other."""
    yield read(path, 0)
    with _library().open(str(path), "r") as file:
        count = len(file)
    yield from (read(path, frame) for frame in range(1, count))


def _check_counts(file: Any, frame: int, size: int) -> None:
    """Refuse impossible numbers of particles or bonds before gsd allocates memory for them."""
    for what in ("particles", "bonds", "angles", "dihedrals", "impropers", "constraints", "pairs"):
        name = f"{what}/N"
        if file.chunk_exists(frame=frame, name=name):
            count = file.read_chunk(frame=frame, name=name)
            if count.size != 1 or not 0 <= int(count.flat[0]) <= size // 4:
                raise ValueError(
                    f"{name}: got {count.flat[0] if count.size else 'nothing'}, must fit into the size of the file"
                )


def _line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def _in_double(snapshot: Any) -> Found:
    """The values under ``log``; refused if the values in single precision differ from them."""
    missing = [key for key in (*OF_PARTICLES.values(), *OF_BOX.values()) if key not in snapshot.log]
    if missing:
        raise ValueError(f"log: must contain {missing[0]}")
    values = {name: snapshot.log[key] for name, key in (OF_PARTICLES | OF_BOX).items()}
    rotation = {name: snapshot.log[key] for name, key in OF_SPINS.items() if key in snapshot.log}
    values |= {name: array for name, array in rotation.items() if array.size}
    try:
        single = _in_single(values)
        same = all(np.array_equal(getattr(snapshot.particles, name), single[name]) for name in single)
    except (KeyError, ValueError):  # only one of the spins and their inertia, or shapes that do not match
        same = False
    if not same:
        raise ValueError(
            "log: must equal the values in single precision; another program has changed one of them"
        )
    values.pop("time")
    shear = None
    try:
        if DRIVING in snapshot.log:
            driving = json.loads(bytes(snapshot.log[DRIVING]))
            values["walls"] = from_entries(driving["walls"])
            values["thermostat"] = from_entry(driving["thermostat"])
            shear = driving.get("shear")
        return Found(values | boundary_of(values.pop("periodic"), shear), units="si")
    except (KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"log: {DRIVING} is damaged: {_line(error)}") from None


def _of_another_program(snapshot: Any) -> Found:
    """A frame written by another program: single precision, all axes periodic."""
    d = snapshot.configuration.dimensions
    p = snapshot.particles
    box = snapshot.configuration.box[:d].astype(np.float64)
    positions = p.position[:, :d].astype(np.float64) + 0.5 * box
    rounding = float(np.finfo(np.float32).eps) * box
    just_outside = (positions > -rounding) & (positions < box + rounding)
    positions = np.where(just_outside, np.clip(positions, 0.0, box), positions)
    arguments = {
        "positions": positions,
        "velocities": p.velocity[:, :d].astype(np.float64),
        "radius": 0.5 * p.diameter.astype(np.float64),
        "mass": p.mass.astype(np.float64),
        "box": box,
    }
    arguments |= _rotation(p, arguments["mass"] * arguments["radius"] ** 2, d)
    return Found(arguments, rounding=float(rounding.max()))


def _rotation(particles: Any, unit: Floats, d: int) -> dict[str, Floats]:
    """Spins of a frame of another program, and I over ``unit``, m R²; nothing if the particles do not rotate.

    HOOMD-blue turns a particle about the axes with a moment of inertia; in two dimensions about z only.
    """
    shapes = {"moment_inertia": 3, "orientation": 4, "angmom": 4}
    moments, q, p = (getattr(particles, name).astype(np.float64) for name in shapes)
    for (name, width), array in zip(shapes.items(), (moments, q, p), strict=True):
        if array.shape != (len(unit), width):
            raise ValueError(f"{name}: got shape {array.shape}, must be {(len(unit), width)}")
    inertia = moments[:, 2]
    with np.errstate(all="ignore"):
        factor = inertia / unit
    good = (factor >= spins.SMALLEST) & (factor <= spins.HIGHEST * (1.0 + 1e-6))
    if d == 3:
        good &= (moments == inertia[:, None]).all(axis=1)
    if not good.all():
        if p.any() and moments.any():
            bad = int(np.argmin(good))
            raise ValueError(
                f"moment_inertia[{bad}]: got {moments[bad].tolist()}, must be q m R² about all axes for particles that "
                f"spin, q in [{spins.SMALLEST:g}, {spins.HIGHEST:g}]"
            )
        return {}
    # The vector part of p q*/2 is L along the axes of the box. The length of q is only nearly 1.
    vector = q[:, :1] * p[:, 1:] - p[:, :1] * q[:, 1:] - np.cross(p[:, 1:], q[:, 1:])
    with np.errstate(all="ignore"):  # the system refuses what is not finite
        turning = 0.5 * vector / (q * q).sum(axis=1)[:, None] / inertia[:, None]
    return {
        "angular_velocities": turning if d == 3 else turning[:, 2].copy(),
        "inertia_factor": np.minimum(factor, spins.HIGHEST),
    }
