"""A job for LAMMPS and its folder, with the input, the particles and the settings needed to read the results."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from ... import _core
from ...support import saving, validation
from ..files import lammps_data
from ..rules import law_entry, law_from
from ..spins import solid
from ..system import ParticleSystem
from .forces import Types, between, rotation_of, types_of
from .script import Plan, script

INPUT: Final = "in.hardlimit"
START: Final = "start.data"
SETTINGS: Final = "hardlimit.json"
#: Files that LAMMPS writes.
LOG: Final = "log.lammps"
PAIRS: Final = "pairs.dump"
WALLS: Final = "walls.dump"
MOTION: Final = "motion.dump"
END: Final = "end.dump"


@dataclass(frozen=True)
class Job:
    """System, law and plan of a run."""

    system: ParticleSystem
    law: Any
    plan: Plan


def write(job: Job, folder: Path) -> Path:
    """Write the files of a job to an existing folder; returns the path of the input script."""
    types = types_of(job.system, job.law)
    rotation, header = rotation_of(job.system, job.law), _header(job, folder)
    text = script(job.system, types, _coefficients(job, types), job.plan, header, rotation)
    frame, factor = job.system.as_frame(), job.system.inertia_factor
    if factor is not None:  # the script has it; the format has that of solid bodies only
        frame = replace(frame, inertia_factor=solid(job.system.n, job.system.dimension))
    with saving.whole(folder / START) as unfinished:
        lammps_data.write(unfinished, frame, types.of_particle + 1)
    settings: dict[str, Any] = {"version": _core.version, "law": law_entry(job.law), "plan": vars(job.plan)}
    if factor is not None:
        settings["inertia_factor"] = factor.tolist() if np.ptp(factor) else float(factor[0])
    saving.write(folder / SETTINGS, json.dumps(settings, indent=1).encode())
    saving.write(folder / INPUT, text.encode())
    return folder / INPUT


def _coefficients(job: Job, types: Types) -> Mapping[tuple[int, int | None], str]:
    """The coefficients for each pair of types, and for each type at a wall."""
    coefficients: dict[tuple[int, int | None], str] = {}
    wall = (float("inf"), float("inf"))
    for i, body in enumerate(types.bodies):
        coefficients[i, None] = between(job.law, body, wall)
        for j, other in enumerate(types.bodies[i:], start=i):
            coefficients[i, j] = between(job.law, body, other)
    return coefficients


def _header(job: Job, folder: Path) -> list[str]:
    plan = job.plan
    return [
        f"Newton's equations of a box of grains, written by hardlimit {_core.version}; SI units",
        f"{job.system!r}",
        f"{job.law!r}",
        f"until {plan.until:.9g} s, {plan.n_steps} steps of {plan.time_step:.9g} s, {plan.samples} samples",
        "",
        f"run:        mpiexec -n 4 lmp -in {INPUT}     in this folder; LAMMPS of 22 Jul 2025 or newer with GRANULAR",
        f"afterwards: hardlimit.lammps_result({folder.name!r})     in Python",
    ]


def read(folder: Path) -> Job:
    """Read the job from its folder."""
    path = folder / SETTINGS
    try:
        settings = json.loads(path.read_text(encoding="utf-8"))
        law, plan = law_from(settings["law"]), Plan(**settings["plan"])
        factor = settings.get("inertia_factor")
    except OSError as error:
        raise validation.unreadable(path, error) from None
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: damaged: {validation.shown(str(error))}") from None
    system = ParticleSystem.read(folder / START, allowed_overlap=1.0 - 1e-9)
    return Job(system if factor is None else system.replace(inertia_factor=factor), law, plan)
