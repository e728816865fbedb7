"""Every argument of every public function against one table of invalid values.

Each value is refused with one line that names the parameter, or its acceptance is documented.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import chdir
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

import bad_values
import hardlimit as hl
from bad_values import BAD, Refuses, anything
from conftest import law_of, refusal, slow, typical
from hardlimit import plots
from hardlimit.boxes.theory import Gas
from hardlimit.column import files as column_files
from hardlimit.support import validation

BALL, LAW = bad_values.BALL, bad_values.LAW

EMPTY = {"empty list", "empty tuple", "empty array", "empty range"}
SIGNED = {"-1", "0"}

#: Labels that an argument accepts in addition to its valid value, according to its documentation.
ACCEPTED = {
    "number": SIGNED,
    "optional number": SIGNED | {"None"},
    "optional coefficient of friction": SIGNED | {"None", "infinity"},
    "one number for each": SIGNED,
    "optional number for each": SIGNED | {"None"},
    "optional numbers": SIGNED | EMPTY | {"None"},
    "numbers of any shape": SIGNED
    | EMPTY
    | {"two dimensions", "nested list", "DataArray of two dimensions", "DataFrame"},
    "law": {"law"},
    "optional law": {"law", "None"},
    "ball": {"Ball"},
    "body": {"Ball", "FLOOR"},
    "swept": SIGNED,
    "balls": set(),
    "optional balls": {"None"},
    "column": set(),
    "word": set(),
    "optional words": {"None"},
    "whole number": {"0"},
    "optional whole number": {"None"},
    "optional path of a store": {"None", "text", "NumPy text"},
    "path of a film": set(),
    "path of a box": set(),
    "optional path": {"None", "text", "NumPy text"},
    "optional word": {"None"},
    "optional count": {"None", "0"},
    "flag": {"True", "False"},
    "system": set(),
    "words": set(),
    "velocities": {"two dimensions", "nested list", "DataArray of two dimensions"},
    "positions": set(),
    "optional result": {"None"},
    "ball or balls": {"Ball"},
    "optional ball": {"None", "Ball"},
    "optional body": {"None", "Ball", "FLOOR"},
    "measurements": set(),
    "word or class of a law": {"class of a law"},
    "optional numbers by name": {"None"},
    "numbers": {"0"},
    "optional column": {"None"},
}


@dataclass(frozen=True)
class Argument:
    """One argument of one function: how to call it, what it accepts, a valid value."""

    function: str
    name: str
    kind: str
    call: Callable[..., Any]
    good: Any
    others: dict[str, Any] = field(default_factory=dict)
    told: str = ""  #: name in messages, if different

    def __str__(self) -> str:
        return f"{self.function}({self.name})"

    def __call__(self, value: Any) -> Any:
        return self.call(**{**self.others, self.name: value})


COLUMN = hl.Column.paper()
RESULT = hl.newton(COLUMN)
CONTACT = LAW.between(BALL)
PHYSICS = {"restitution": 0.5, "stiffness": 1e6, "effective_mass": 0.1}


def arguments() -> list[Argument]:
    n, o = "number", "optional number"
    listed = [
        Argument("Ball", "radius", n, hl.Ball, 0.1, {"mass": 1.0}),
        Argument("Ball", "mass", n, hl.Ball, 1.0, {"radius": 0.1}),
        Argument("Ball", "density", n, hl.Ball, 840.0, {"radius": 0.1}),
        Argument("Ball.resized", "radius", n, BALL.resized, 0.1),
        Argument("law.between", "ball", "ball", LAW.between, BALL),
        Argument("law.between", "other", "body", LAW.between, BALL, {"ball": BALL}),
        Argument("Contact.restitution", "speed", "numbers of any shape", CONTACT.restitution, 1.0),
        Argument("Contact.duration", "speed", "numbers of any shape", CONTACT.duration, 1.0),
        Argument("Contact.energy", "compression", "numbers of any shape", CONTACT.energy, 1e-3),
        Argument("Contact.force", "compression", "numbers of any shape", CONTACT.force, 1e-3),
        Argument("Contact.force", "rate", "numbers of any shape", CONTACT.force, 1.0, {"compression": 1e-3}),
        Argument("Result.trajectory", "times", "optional numbers", RESULT.trajectory, 1e-4),
        Argument("compare", "column", "column", hl.compare, COLUMN),
        *(
            Argument("usual_damping", name, "number", hl.usual_damping, value, PHYSICS)
            for name, value in PHYSICS.items()
        ),
    ]
    whole = {"balls": [BALL, BALL], "gaps": 1e-3, "height": 0.6, "law": LAW}
    kinds = {"balls": "balls", "gaps": "one number for each", "height": n, "law": "law",
             "velocities": "one number for each", "gravity": n}  # fmt: skip
    good = whole | {"velocities": -1.0, "gravity": 9.81}
    for name, kind in kinds.items():
        listed.append(Argument("Column", name, kind, hl.Column, good[name], whole))
        optional = f"optional {kind.removeprefix('one ')}"
        listed.append(Argument("Column.replace", name, optional, COLUMN.replace, good[name]))
    row = {"balls": [BALL, BALL], "velocities": [1.0, 0.0], "law": LAW, "gaps": 1e-3}
    for name in row:
        listed.append(Argument("Column.cradle", name, kinds[name], hl.Column.cradle, row[name], row))
    for name, value in {
        "gap": 1e-3,
        "radius_2": 0.02,
        "density": 840.0,
        "height": 1.0,
        "gravity": 9.81,
    }.items():
        listed.append(Argument("Column.paper", name, n, hl.Column.paper, value))
    for name, value in {"restitution": 0.5, "radius_ratio": 3.0, "radius_1": 0.2, "stiffness": 1e6}.items():
        listed.append(Argument("Column.paper", name, o, hl.Column.paper, value))
    listed.append(Argument("Column.paper", "law", "optional law", hl.Column.paper, LAW))
    for solve in (hl.newton, hl.adiabatic, hl.independent):
        listed.append(Argument(solve.__name__, "column", "column", solve, COLUMN))
        listed.append(Argument(solve.__name__, "until", o, solve, 1e-4, {"column": COLUMN}))
    listed.append(Argument("newton", "method", "word", hl.newton, "general", {"column": COLUMN}))
    listed.append(Argument("newton", "tolerance", n, hl.newton, 1e-12, {"column": COLUMN}))
    return [
        *listed,
        *arguments_of_sweep(),
        *arguments_of_approximations(),
        *arguments_of_film(),
        *arguments_of_grains(),
        *arguments_of_theory(),
        *arguments_of_fidelity(),
        *arguments_of_runs(),
        *arguments_of_conversions(),
        *arguments_of_fits(),
        *arguments_of_practice(),
        *(argument for kind in hl.LAWS for argument in arguments_of_law(kind)),
    ]


def arguments_of_sweep() -> list[Argument]:
    soft = hl.Column.paper(law=law_of("viscoelastic", 0.7))
    point = {"column": COLUMN, "gap": [1e-4]}
    listed = [
        Argument("sweep", "column", "column", sweep, COLUMN, point),
        Argument("sweep", "model", "word", sweep, "independent", point),
        Argument("sweep", "engine", "word", sweep, "cpu", point),
        Argument("sweep", "threads", "optional whole number", sweep, 2, point),
        Argument("sweep", "store", "optional path of a store", sweep, "map.zarr", point),
        Argument("sweep", "variables", "optional words", sweep, ["t_end"], point),
        Argument("sweep", "tolerance", "optional number", sweep, 1e-9, point | {"column": soft}),
    ]
    for name, value in {
        "gap": 1e-4,
        "radius_1": 0.1,
        "density": 840.0,
        "height": 0.6,
        "gravity": 9.81,
        "velocity": -1.0,
        "radius_ratio": 10.0,
        "restitution": 0.7,
        "stiffness_floor": 5e7,
    }.items():
        listed.append(Argument("sweep", name, "swept", sweep, value, {"column": COLUMN}))
    return listed


def sweep(store: Any = None, **others: Any) -> Any:
    """A sweep without its computing time, in an empty working directory."""
    with TemporaryDirectory() as folder, chdir(folder):
        ds = hl.sweep(store=store, **others).load()
    del ds.attrs["wall_time_s"]
    return ds


def arguments_of_approximations() -> list[Argument]:
    shape = "numbers of any shape"
    return [
        Argument("restitution_series", "x", shape, hl.restitution_series, 0.1),
        Argument("restitution_series", "terms", "whole number", hl.restitution_series, 5, {"x": 0.1}),
        Argument("restitution_pade", "x", shape, hl.restitution_pade, 0.1),
        Argument("restitution_pade", "numerator", "whole number", hl.restitution_pade, 1, {"x": 0.1}),
        Argument("restitution_pade", "denominator", "whole number", hl.restitution_pade, 4, {"x": 0.1}),
    ]


def arguments_of_theory() -> list[Argument]:
    sizes = {"n": 100, "radius": 1e-3, "mass": 1e-5, "volume": 1e-5, "dimension": 3}
    kinds = dict.fromkeys(sizes, "number") | {"n": "whole number", "dimension": "whole number"}
    gas_of, shape = Gas(**sizes), "numbers of any shape"
    start = {"time": 1.0, "temperature": 0.01, "restitution": 0.9}
    rubbing = {"restitution": 0.9, "friction": 0.5, "tangential_restitution": 0.3}
    critical = {"restitution": 0.9, "tangential_restitution": 0.3, "temperature_ratio": 1.0}
    gas_of_spins = gas_of.rotating(**rubbing)
    spun = {"time": 1.0, "temperature": 0.01, "rotational_temperature": 0.02}
    return [
        *(Argument("Gas", name, kinds[name], Gas, value, sizes) for name, value in sizes.items()),
        Argument("Gas.collision_rate", "temperature", shape, gas_of.collision_rate, 0.01),
        Argument("Gas.pressure", "temperature", shape, gas_of.pressure, 0.01),
        Argument("Gas.pressure", "restitution", "number", gas_of.pressure, 0.9, {"temperature": 0.01}),
        *(
            Argument("Gas.cooling", name, shape if name == "time" else "number", gas_of.cooling, value, start)
            for name, value in start.items()
        ),
        Argument("Gas", "inertia_factor", "optional number", Gas, 0.4, sizes),
        *(
            Argument("Gas.rotating", name, kind, gas_of.rotating, rubbing[name], rubbing)
            for name, kind in zip(
                rubbing, ("number", "optional coefficient of friction", "number"), strict=True
            )
        ),
        *(
            Argument("Gas.critical_friction", name, "number", gas_of.critical_friction, v, critical)
            for name, v in critical.items()
        ),
        Argument("RotatingGas.rates", "temperature_ratio", "number", gas_of_spins.rates, 1.0),
        Argument("RotatingGas.heated_temperature", "power", "number", gas_of_spins.heated_temperature, 1e-6),
        *(
            Argument(
                "RotatingGas.cooling",
                name,
                shape if name == "time" else "number",
                gas_of_spins.cooling,
                v,
                spun,
            )
            for name, v in spun.items()
        ),
    ]


def arguments_of_fidelity() -> list[Argument]:
    disks = hl.ParticleSystem.random(9, 0.2, 1e-3, 2500.0, 0.1, dimension=2)
    fidelity = hl.fidelity(disks, law=LAW, until=1e-3, models=["newton", "law"], samples=1)
    words = {"quantity": "pressure", "model": "law"}
    methods = [fidelity.difference, fidelity.final_difference, fidelity.is_significant]
    return [
        Argument("Fidelity.outcomes", "model", "word", fidelity.outcomes, "law"),
        *(
            Argument(f"Fidelity.{method.__name__}", name, "word", method, value, words)
            for method in methods
            for name, value in words.items()
        ),
    ]


def arguments_of_film() -> list[Argument]:
    def write_first(path: Path, pictures: Iterator[Any], rate: int) -> None:
        path.write_bytes(bytes(next(iter(pictures))))  # whole films have tests of their own

    def film(path: Any = "film.gif", **options: Any) -> Any:
        with (
            TemporaryDirectory() as folder,
            chdir(folder),
            mock.patch("hardlimit.plots.video.write_gif", write_first),
        ):
            return RESULT.animate(path, **({"width": 160, "frames_per_second": 1} | options))

    whole = "optional whole number"
    return [
        Argument("Result.animate", "path", "path of a film", film, "film.gif"),
        Argument("Result.animate", "ghost", "optional result", film, RESULT),
        Argument("Result.animate", "width", whole, film, 160),
        Argument("Result.animate", "frames_per_second", whole, film, 1),
    ]


DISKS = {
    "positions": [[0.01, 0.01], [0.03, 0.03]],
    "velocities": [[1.0, 1.0], [-1.0, -1.0]],  # they meet
    "radius": 1e-3,
    "mass": 1.0,
    "box": 0.05,
}


def arguments_of_grains() -> list[Argument]:
    system = hl.ParticleSystem(**DISKS)
    n, each, whole = "number", "one number for each", "whole number"
    kinds = {"positions": "positions", "velocities": "velocities", "radius": n, "mass": n, "density": n, "box": each,
             "boundary": "words", "gravity": each, "allowed_overlap": n, "inertia_factor": "optional number",
             "angular_velocities": "optional number for each"}  # fmt: skip
    good = DISKS | {"density": 2500.0, "boundary": "wall", "gravity": 9.81, "allowed_overlap": 1e-3,
                    "angular_velocities": [1.0, 2.0], "inertia_factor": 0.4}  # fmt: skip
    listed = []
    for name, kind in kinds.items():
        others = {key: value for key, value in DISKS.items() if (key, name) != ("mass", "density")}
        listed.append(Argument("ParticleSystem", name, kind, hl.ParticleSystem, good[name], others))
        if name not in ("allowed_overlap", "positions", "velocities", "boundary"):
            optional = f"optional {kind.removeprefix('one ').removeprefix('optional ')}"
            listed.append(Argument("ParticleSystem.replace", name, optional, system.replace, good[name]))
    random = {"n": 3, "packing_fraction": 0.1, "radius": 1e-3, "density": 2500.0, "rms_speed": 1.0}
    kinds = {"n": whole, "packing_fraction": n, "radius": n, "density": n, "rms_speed": n, "dimension": whole,
             "seed": whole, "boundary": "words", "gravity": each, "rms_spin": "optional number",
             "inertia_factor": "optional number"}  # fmt: skip
    good = random | {"dimension": 2, "seed": 1, "boundary": "wall", "gravity": 9.81, "rms_spin": "equal",
                     "inertia_factor": 0.4}  # fmt: skip
    for name, kind in kinds.items():
        listed.append(
            Argument("ParticleSystem.random", name, kind, hl.ParticleSystem.random, good[name], random)
        )

    def written(path: Any) -> Any:
        with TemporaryDirectory() as folder, chdir(folder):
            return system.write(path), hl.ParticleSystem.read(path)

    return [*listed, Argument("ParticleSystem.write", "path", "path of a box", written, "box.xyz")]


def arguments_of_runs() -> list[Argument]:
    def run(system: Any, **options: Any) -> Any:
        with TemporaryDirectory() as folder, chdir(folder):
            return hl.event_driven(system, **options)

    def move(system: Any, **options: Any) -> Any:
        until = options.get("until")
        if type(until) in (int, float) and 1e-2 < until < 1e12:
            options["until"] = 1e-2  # a valid time that would take hours of small steps
        with TemporaryDirectory() as folder, chdir(folder):
            return hl.molecular_dynamics(system, **({"engine": "steps"} | options))

    def take_elsewhere(system: Any, **options: Any) -> Any:
        with TemporaryDirectory() as folder:
            written = hl.lammps_input(system, folder, **options).read_text()
        return written.replace(folder.rpartition("/")[2], "FOLDER")

    system = hl.ParticleSystem(**DISKS)
    brief = {"system": system, "law": LAW, "until": 1e-4}
    short = {"system": system, "restitution": 0.9, "until": 1e-3}
    by_count = {"system": system, "restitution": 0.9, "max_collisions": 1}
    of_law = {"system": system, "until": 1e-3}
    tc = short | {"rule": "tc"}
    return [
        Argument("event_driven", "system", "system", run, system, short),
        Argument("event_driven", "law", "law", run, LAW, of_law),
        Argument("event_driven", "restitution", "number", run, 0.9, of_law),
        Argument("event_driven", "until", "optional number", run, 1e-3, by_count),
        Argument("event_driven", "max_collisions", "optional count", run, 1, short),
        Argument("event_driven", "rule", "optional word", run, "constant", short),
        Argument("event_driven", "contact_duration", "number", run, 1e-6, tc),
        Argument("event_driven", "samples", "whole number", run, 3, short),
        Argument("event_driven", "log", "flag", run, True, short),
        Argument("event_driven", "checkpoint", "optional path", run, "run.checkpoint", short),
        Argument("event_driven", "checkpoint_every", "number", run, 1.0, short),
        Argument("molecular_dynamics", "system", "system", move, system, brief),
        Argument("molecular_dynamics", "law", "law", move, LAW, brief),
        Argument("molecular_dynamics", "until", "number", move, 1e-4, brief),
        Argument("molecular_dynamics", "engine", "word", move, "steps", brief),
        Argument("molecular_dynamics", "restitution_error", "optional number", move, 1e-2, brief),
        Argument("molecular_dynamics", "time_step", "optional number", move, 1e-7, brief),
        Argument("molecular_dynamics", "threads", "optional whole number", move, 1, brief),
        Argument("molecular_dynamics", "samples", "whole number", move, 3, brief),
        Argument("molecular_dynamics", "log", "flag", move, True, brief),
        Argument("molecular_dynamics", "checkpoint", "optional path", move, "run.checkpoint", brief),
        Argument("molecular_dynamics", "checkpoint_every", "number", move, 1.0, brief),
        Argument("lammps_input", "system", "system", take_elsewhere, system, brief),
        Argument("lammps_input", "law", "law", take_elsewhere, LAW, brief),
        Argument("lammps_input", "until", "number", take_elsewhere, 1e-4, brief),
        Argument("lammps_input", "restitution_error", "optional number", take_elsewhere, 1e-2, brief),
        Argument("lammps_input", "time_step", "optional number", take_elsewhere, 1e-8, brief),
        Argument("lammps_input", "samples", "whole number", take_elsewhere, 3, brief),
        Argument("lammps_input", "log", "flag", take_elsewhere, True, brief),
    ]


def arguments_of_conversions() -> list[Argument]:
    n, o, w = "number", "optional number", "optional word"
    spring = {"balls": BALL, "restitution": 0.7, "stiffness": 1e5, "code": "mercurydpm"}
    sphere = {
        "balls": BALL,
        "restitution": 0.7,
        "youngs_modulus": 1e8,
        "poisson_ratio": 0.3,
        "code": "lammps",
    }
    bare = {"balls": BALL, "restitution": 0.7, "code": "mercurydpm"}
    written = {"text": "hooke 1e5 50 damping velocity", "ball": BALL, "code": "lammps"}
    return [
        Argument("convert", "balls", "ball or balls", hl.convert, BALL, spring),
        Argument("convert", "restitution", n, hl.convert, 0.7, spring),
        Argument("convert", "speed", n, hl.convert, 1.0, spring),
        Argument("convert", "stiffness", n, hl.convert, 1e5, bare),
        Argument("convert", "youngs_modulus", n, hl.convert, 1e8, bare | {"poisson_ratio": 0.3}),
        Argument("convert", "poisson_ratio", n, hl.convert, 0.3, sphere),
        Argument("convert", "duration", n, hl.convert, 1e-4, bare),
        Argument("convert", "compression", n, hl.convert, 1e-4, bare),
        Argument("convert", "law", w, hl.convert, "linear", spring),
        Argument("convert", "wall", "flag", hl.convert, True, spring),
        Argument("convert", "code", w, hl.convert, "lammps", spring),
        Argument("convert", "model", w, hl.convert, "hooke-restitution", spring | {"code": "lammps"}),
        Argument("convert", "attraction", "flag", hl.convert, False, spring),
        Argument("convert", "restitution_error", o, hl.convert, 1e-3, spring),
        Argument("convert", "time_step", o, hl.convert, 1e-7, spring),
        Argument("convert_back", "text", "word", hl.convert_back, written["text"], written, "input"),
        Argument("convert_back", "ball", "ball", hl.convert_back, BALL, written),
        Argument("convert_back", "other", "optional body", hl.convert_back, BALL, written),
        Argument("convert_back", "code", "word", hl.convert_back, "lammps", written),
        Argument("convert_back", "contact", "optional word", hl.convert_back, "1-1", written),
        Argument("convert_back", "speed", n, hl.convert_back, 1.0, written),
        Argument("convert_back", "restitution_error", o, hl.convert_back, 1e-3, written),
        Argument("convert_back", "time_step", o, hl.convert_back, 1e-7, written),
    ]


def arguments_of_fits() -> list[Argument]:
    speed, measured = np.linspace(0.5, 1.5, 6), np.linspace(0.7, 0.69, 6)
    data = hl.Impacts.of_restitution(speed, measured, 0.01)
    quick = {"data": data, "law": "tsuji", "compare": False}
    listed = [
        Argument("fit", "data", "measurements", hl.fit, data, quick),
        Argument("fit", "law", "word or class of a law", hl.fit, "tsuji", quick),
        Argument("fit", "fixed", "optional numbers by name", hl.fit, {}, quick),
        Argument("fit", "free", "optional words", hl.fit, ["restitution"], quick),
        Argument("fit", "ball", "optional ball", hl.fit, BALL, quick),
        Argument("fit", "other", "body", hl.fit, BALL, quick | {"ball": BALL}),
        Argument("fit", "scatter", "flag", hl.fit, False, quick),
        Argument("fit", "confidence", "number", hl.fit, 0.9, quick),
        Argument("fit", "compare", "flag", hl.fit, False, quick),
        Argument("read_measurements", "path", "word", read_rows, "rows.csv"),
        Argument("read_measurements", "column", "optional column", read_rows, COLUMN),
        Argument("read_measurements", "gravity", "number", read_rows, 9.81),
    ]
    rows = {"speed": speed, "restitution": measured, "restitution_error": 0.01, "speed_error": 0.01}
    return listed + [
        Argument("Impacts.of_restitution", name, "numbers", hl.Impacts.of_restitution, value, rows)
        for name, value in rows.items()
    ]


def read_rows(path: Any = "rows.csv", **options: Any) -> Any:
    with TemporaryDirectory() as folder, chdir(folder):
        Path("rows.csv").write_text("speed,restitution,restitution_error\n1.0,0.7,0.01\n2.0,0.69,0.01\n")
        try:
            return hl.read_measurements(path, **options)
        except (ValueError, FileNotFoundError) as error:  # a message may name the file instead
            raise ValueError(re.sub("^.*: (?=cannot be read|no such)", "path: ", str(error))) from None


def arguments_of_the_verdict() -> list[Argument]:
    gas = {"packing_fraction": 0.2, "restitution": 0.9}
    law = hl.error_law(**gas)
    kinds = {"packing_fraction": "number", "restitution": "number", "dimension": "whole number", "rule": "word",
             "law": "optional law"}  # fmt: skip
    good = gas | {"dimension": 2, "rule": "tc", "law": LAW}
    return [
        *(Argument("error_law", name, kind, hl.error_law, good[name], gas) for name, kind in kinds.items()),
        Argument("ErrorLaw.error", "tc_nu", "number", law.error, 0.1),
        Argument("ErrorLaw.error_bar", "tc_nu", "number", law.error_bar, 0.1),
        Argument("ErrorLaw.delta_over_d", "tc_nu", "number", law.delta_over_d, 0.1),
        Argument("ErrorLaw.largest_tc_nu", "error", "number", law.largest_tc_nu, 0.1),
    ]


def arguments_of_measurements() -> list[Argument]:
    m, system, whole = hl.measure, hl.ParticleSystem(**DISKS), "whole number"
    run = hl.event_driven(system, restitution=1.0, until=1e-3, samples=10, observe={"paths": m.paths})
    of = {"system": system}
    return [
        *(
            Argument(f"measure.{f.__name__}", "system", "system", f, system)
            for f in (m.rdf, m.coordination, m.a2, m.paths)
        ),
        Argument("measure.rdf", "bins", whole, m.rdf, 3, of),
        Argument("measure.rdf", "r_max", "optional number", m.rdf, 0.01, of),
        Argument("measure.rdf", "r_min", "number", m.rdf, 0.001, of),
        Argument("measure.coordination", "tolerance", "number", m.coordination, 0.1, of),
        Argument("measure.granular_temperature", "bins", whole, m.granular_temperature, 3, of),
        Argument("measure.profiles", "axis", "word", m.profiles, "y", of),
        Argument("measure.profiles", "bins", whole, m.profiles, 3, of | {"axis": "x"}),
        Argument("measure.msd", "paths", "system", m.msd, run.series.paths),
        Argument("measure.contact_value", "run", "system", m.contact_value, run),
        Argument("measure.plot", "measured", "system", m.plot, run.series.pressure),
    ]


def arguments_of_practice() -> list[Argument]:
    pile = {"n": 2, "law": LAW, "bottom_mass": 1.0, "model": "independent"}
    oblique = {"column": COLUMN, "offset": 1e-4}
    system = hl.ParticleSystem(**DISKS)
    brief = {
        "system": system,
        "law": LAW,
        "until": 1e-4,
        "models": ["newton", "constant"],
        "samples": 2,
        "restitution": 0.9,
    }
    n = "number"

    def measure(store: Any = None, **options: Any) -> Any:
        with TemporaryDirectory() as folder, chdir(folder):
            return hl.fidelity(store=store, **(brief | options))

    @cache
    def saved() -> bytes:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "run.checkpoint"
            hl.event_driven(system, restitution=0.9, until=1e-9, checkpoint=path)
            return path.read_bytes()

    def go_on(path: Any = "run.checkpoint", **options: Any) -> Any:
        with TemporaryDirectory() as folder, chdir(folder):
            Path("run.checkpoint").write_bytes(saved())
            return hl.resume(path, **options)

    return [
        Argument("stack", "n", "whole number", hl.stack, 2, pile),
        Argument("stack", "law", "law", hl.stack, LAW, pile),
        Argument("stack", "bottom_mass", n, hl.stack, 1.0, pile),
        Argument("stack", "top_mass", "optional number", hl.stack, 0.1, pile),
        Argument("stack", "ratio_limits", "numbers", hl.stack, (0.01, 1.0), pile),
        Argument("stack", "model", "word", hl.stack, "independent", pile),
        Argument("stack", "gaps", "one number for each", hl.stack, 1e-3, pile),
        Argument("stack", "density", "one number for each", hl.stack, 1000.0, pile),
        Argument("stack", "impact_speed", n, hl.stack, 1.0, pile),
        Argument("oblique_drop", "column", "column", hl.oblique_drop, COLUMN, oblique),
        Argument("oblique_drop", "offset", n, hl.oblique_drop, 1e-4, oblique),
        Argument("fidelity", "system", "system", measure, system),
        Argument("fidelity", "law", "law", measure, LAW),
        Argument("fidelity", "until", n, measure, 1e-4),
        Argument("fidelity", "models", "words", measure, ["newton", "constant"]),
        Argument("fidelity", "replicas", "whole number", measure, 1),
        Argument("fidelity", "samples", "whole number", measure, 2),
        Argument("fidelity", "restitution", "optional number", measure, 0.9),
        Argument("fidelity", "contact_duration", "optional number", measure, 1e-6),
        Argument("fidelity", "engine", "word", measure, "events"),
        Argument("fidelity", "seed", "whole number", measure, 1),
        Argument("fidelity", "workers", "whole number", measure, 1),
        Argument("resume", "until", "optional number", go_on, 1e-8),
        *arguments_of_the_verdict(),
        *arguments_of_measurements(),
        Argument("resume", "max_collisions", "optional count", go_on, 2),
    ]


def arguments_of_law(kind: str) -> list[Argument]:
    """Every parameter of a law in each of its alternatives, and in ``replace``."""
    law, listed = hl.LAWS[kind], []
    for choice in law.record["alternatives"]:
        parameters = {p["name"]: typical(p) for p in [*law.record["common"], *choice]}
        for name, value in parameters.items():
            rest = {key: other for key, other in parameters.items() if key != name}
            listed.append(Argument(law.__name__, name, "number", law, value, rest))
            listed.append(
                Argument(f"{law.__name__}.replace", name, "number", law(**parameters).replace, value)
            )
    return listed


ARGUMENTS = arguments()


def labels_of(argument: Argument, step: int) -> list[str]:
    """One of ``step`` bad values, so that each is given to some argument of this kind."""
    alike = [each for each in ARGUMENTS if each.kind == argument.kind]
    step = min(step, len(alike))
    return [*BAD][alike.index(argument) % step :: step]


def refusal_of(argument: Argument, value: object) -> str | None:
    """The message with which a value is refused: one line; None if it is accepted."""
    try:
        argument(value)
    except ValueError as error:
        assert "\n" not in str(error) and len(str(error)) < 300, str(error)
        return str(error)
    return None


@pytest.mark.parametrize("step", [5, slow(1)])
@pytest.mark.parametrize(
    # An accepted value makes a film.
    "argument",
    [slow(a) if a.function == "Result.animate" else a for a in ARGUMENTS],
    ids=str,
)
def test_bad_values_are_refused_or_documented(argument, step):
    assert argument(argument.good) is not None
    for label in labels_of(argument, step):
        try:
            message = refusal_of(argument, BAD[label]())
        except Exception as error:
            pytest.fail(f"{label}: {type(error).__name__}: {error}")
        if message is None:
            assert label in ACCEPTED[argument.kind], f"{label} was taken"
        else:
            named = message.partition(": ")[0]
            assert re.search(rf"\b{argument.told or argument.name}\b", named), (label, message)


@pytest.mark.slow
@settings(max_examples=200)
@given(st.sampled_from(ARGUMENTS), anything)
def test_any_object_is_taken_or_refused_in_one_line(argument, value):
    """The message names the parameter, or one that it makes invalid, such as the height for a ball's radius."""
    message = refusal_of(argument, value)
    assert message is None or re.match(r"[^:\n]+: \S", message), message


SPELLINGS: dict[str, Callable[[float], Any]] = {
    "NumPy scalar": np.float64,
    "array without dimensions": np.array,
    "DataArray without dimensions": xr.DataArray,
    "long double": np.longdouble,
    "Fraction": Fraction,
    "Decimal": Decimal,
    "one masked array without masked entries": lambda x: np.ma.array(x, mask=False),
}

NUMERIC = [a for a in ARGUMENTS if "number" in a.kind and isinstance(a.good, float)]


@cache
def plainly(place: int) -> str:
    argument = NUMERIC[place]
    return repr(argument(argument.good))


@pytest.mark.parametrize(("spelling", "step"), [("Decimal", 6), *(slow(s, 1) for s in SPELLINGS)])
def test_one_number_in_every_spelling(spelling, step):
    """Every numeric type that holds the same number gives the same result. The fast test takes every sixth argument."""
    for place, argument in [*enumerate(NUMERIC)][::step]:
        spelled = argument(SPELLINGS[spelling](argument.good))
        assert repr(spelled) == plainly(place), (argument, spelling)


def test_whole_numbers_are_numbers():
    for integer in (1, np.int64(1), np.uint8(1), np.array(1), Fraction(1), Decimal(1), np.float16(1)):
        assert hl.Ball(integer, mass=integer) == hl.Ball(1.0, mass=1.0)


# ---- the conversions themselves ----------------------------------------------------------------------------

LISTS = {
    "list": list,
    "tuple": tuple,
    "array": np.array,
    "DataArray": xr.DataArray,
    "Series": pd.Series,
    "masked array without masked entries": np.ma.array,
    "array read backwards": lambda x: np.array(x[::-1])[::-1],
    "single precision": lambda x: np.array(x, dtype=np.float32),
    "list of NumPy scalars": lambda x: [np.float64(v) for v in x],
    "list of Fractions": lambda x: [Fraction(v) for v in x],
}


@pytest.mark.parametrize("kind", LISTS)
def test_arrays_of_every_kind(kind):
    values = [0.5, 2.0, 0.25]
    array = validation.array("x", LISTS[kind](values), lowest=0.0)
    assert type(array) is np.ndarray and array.dtype == np.float64 and array.flags.c_contiguous
    assert array.tolist() == values
    assert validation.numbers("x", LISTS[kind](values), 3) == tuple(values)


def test_bad_arrays():
    """All are refused but these numbers."""
    for label, value in BAD.items():
        if label in ("-1", "0"):
            assert validation.array("x", value()).shape == ()
        else:
            message = refusal(lambda value=value: validation.array("x", value()))
            assert message.startswith("x: got "), label


def test_shapes_of_arrays():
    assert validation.array("x", 3).shape == ()
    assert validation.array("x", [[1, 2], [3, 4]], ndim=2).tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert validation.array("x", np.ones((2, 3, 4)), ndim=None).shape == (2, 3, 4)
    assert validation.array("x", [], empty_allowed=True).shape == (0,)
    with pytest.raises(ValueError, match="x: got 3 dimensions, must be a number or an array of numbers"):
        validation.array("x", np.ones((2, 3, 4)), ndim=2)
    with pytest.raises(ValueError, match=r"^x: got 2, must be in \[0, 1\)$"):
        validation.array("x", [0.0, 0.5, 2.0], lowest=0.0, highest=1.0, lowest_allowed=True)
    with pytest.raises(ValueError, match=r"^x: got 0, must be in \(0, 1\)$"):
        validation.array("x", [0.0, 0.5], lowest=0.0, highest=1.0)


@pytest.mark.parametrize(
    "value", [1.0, True, "1", None, 0, 11, 10**400, np.timedelta64(3, "s"), 1.5, np.float64(2)]
)
def test_whole_refuses(value):
    with pytest.raises(ValueError, match=r"^n: got .*, must be a whole number in \[1, 10\]$"):
        validation.whole("n", value, 1, 10)


@pytest.mark.parametrize("value", [3, np.int8(3), np.uint64(3)])
def test_whole_takes(value):
    assert validation.whole("n", value, 1, 10) == 3 and type(validation.whole("n", value, 1, 10)) is int


def test_values_in_messages_are_short():
    assert validation.shown("a\nb" * 1000).count("\n") == 0 and len(validation.shown("a" * 1000)) <= 60
    assert validation.shown(Refuses()) == "a Refuses" and validation.shown(10**5000) == "a int"


# --- files --------------------------------------------------------------------------------------------------

SYSTEM = hl.ParticleSystem([[0.02, 0.05], [0.04, 0.05]], np.zeros((2, 2)), 0.005, density=2500.0, box=0.1)
#: Every public function that reads a file.
READERS: dict[str, Callable[[str], Any]] = {
    "ParticleSystem.read, xyz": lambda path: hl.ParticleSystem.read(path + ".xyz"),
    "ParticleSystem.read, data": lambda path: hl.ParticleSystem.read(path + ".data"),
    "ParticleSystem.read, gsd": lambda path: hl.ParticleSystem.read(path + ".gsd"),
    "ParticleSystem.read, dump": lambda path: hl.ParticleSystem.read(path + ".lammpstrj"),
    "ParticleSystem.read_frames": lambda path: list(hl.ParticleSystem.read_frames(path + ".gz")),
    "read_measurements": hl.read_measurements,
    "resume": hl.resume,
    "load": lambda path: hl.load(path + ".nc"),
    "lammps_result": hl.lammps_result,
    "check": hl.check,
    "check, dump": lambda path: hl.check(BALL, law=LAW, dump=path),
    "column": column_files.read,
}
#: Every public function that writes one.
WRITERS: dict[str, Callable[[str], Any]] = {
    "ParticleSystem.write": lambda path: SYSTEM.write(path + ".xyz"),
    "ParticleResult.save": lambda path: hl.event_driven(SYSTEM, restitution=0.9, until=0.0).save(
        path + ".nc"
    ),
    "Fidelity.save": lambda path: hl.fidelity(SYSTEM, law=LAW, until=0.0).save(path + ".nc"),
    "checkpoint": lambda path: hl.event_driven(SYSTEM, restitution=0.9, until=0.0, checkpoint=path),
    "fidelity, store": lambda path: hl.fidelity(SYSTEM, law=LAW, until=0.0, store=path),
    "sweep, store": lambda path: hl.sweep(COLUMN, restitution=[0.5, 0.6], store=path),
    "lammps_input": lambda path: hl.lammps_input(SYSTEM, path, law=LAW, until=1e-6),
    "animate": lambda path: hl.newton(COLUMN).animate(path + ".gif"),
    "plots.save": lambda path: plots.save(Figure(), path + ".png"),
    "column": lambda path: column_files.write(COLUMN, path + ".toml"),
}


@pytest.mark.parametrize("reader", READERS)
def test_a_missing_file_is_a_file_not_found_error(reader: str, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"\A[^\n]*none[^\n]*: no such file\Z"):
        READERS[reader](str(tmp_path / "none"))


@pytest.mark.parametrize("name", [*READERS, *WRITERS])
def test_paths_with_control_characters_are_refused(name: str, tmp_path: Path) -> None:
    """In one line that names the parameter, and nothing is written."""
    refused = r"\A\w+: got [^\n]*, must be a path without control characters\Z"
    for character in "\0\r\x1b" + "\n" * (name != "check"):  # a text of several lines is a script
        with pytest.raises(ValueError, match=refused):
            (READERS | WRITERS)[name](str(tmp_path / f"a{character}b"))
    assert list(tmp_path.iterdir()) == []
