"""The job of ``hardlimit gas``: a start, the rules of collision, an end, files; from a file and from options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from ..boxes import hard_spheres as runs
from ..boxes.checkpoint import checked_path
from ..boxes.files import FORMATS
from ..boxes.rules import Settings, checked_settings
from ..boxes.run import Keeping, Run, checked_samples, load
from ..boxes.system import ParticleSystem
from ..column import files as columns
from ..column.scenario import Column
from ..contact.contact import Law
from ..support import toml, units, validation
from .options import film, given_law_parameters, picture, writable

#: Units of what a random start takes; None where it takes no quantity.
RANDOM: Final = {
    "n": None,
    "packing_fraction": "1",
    "radius": "m",
    "density": "kg/m3",
    "rms_speed": "m/s",
    "dimension": None,
    "seed": None,
    "boundary": None,
    "gravity": "m/s2",
}
#: The gas without options: glass beads.
USUAL: Final = {"n": 1000, "packing_fraction": 0.3, "radius": 1e-3, "density": 2500.0, "rms_speed": 1.0}
USUAL_RESTITUTION: Final = 0.9
#: Collisions per particle that a run without an end is given time for, at the rate of its start.
USUAL_COLLISIONS: Final = 20
#: What changes a start from a file.
OF_THE_BOX: Final = ("boundary", "gravity")
#: Units of the arguments of ``hardlimit.event_driven``.
RUN: Final = {
    "restitution": "1",
    "rule": None,
    "contact_duration": "s",
    "until": "s",
    "max_collisions": None,
    "samples": None,
    "checkpoint": None,
    "checkpoint_every": "s",
}
OUTPUTS: Final = ("out", "save", "plot", "animate")


@dataclass(frozen=True)
class Job:
    """A run at its beginning, or where a checkpoint left it, and where its results go."""

    course: Run
    outputs: dict[str, Path | None]  #: "out", "save", "plot" and "animate"


def make_job(file: str | None, resume: str | None, given: dict[str, Any]) -> Job:
    """The job of a file, or of glass beads without one, changed by the options.

    Raises
    ------
    ValueError
        For anything that no run can be made of.
    """
    law_name, parameters = given.pop("law"), given_law_parameters(given)
    options = {name: value for name, value in given.items() if value not in (None, ())}
    if resume is not None:
        return _resumed(file, resume, options | parameters | ({"law": law_name} if law_name else {}))
    content = _changed(read(file), options)
    outputs = _checked_outputs(content["output"])
    settings, run = _rules(content, law_name, parameters)
    checkpoint = None if run["checkpoint"] is None else checked_path(run["checkpoint"])
    every = 60.0 if run["checkpoint_every"] is None else run["checkpoint_every"]
    every = validation.number("checkpoint_every", every, 0.0)
    samples = 100 if run["samples"] is None else run["samples"]
    samples = checked_samples(samples)
    end = runs.checked_end(run["until"], run["max_collisions"])
    _refuse_frames_without_end(outputs, end.until, end.max_collisions)
    system = start(content)
    if end.until is None and end.max_collisions is None:
        end = end._replace(until=usual_end(system))
    keeping = Keeping(samples, outputs["save"] is not None, checkpoint, every)
    return Job(runs.start(system, settings, end, keeping), outputs)


@dataclass(frozen=True)
class ContactJob:
    """A run under Newton's equations."""

    system: ParticleSystem
    law: Law
    until: float  #: [s]
    options: dict[str, Any]  #: samples and checkpoint, as far as they are given
    save: Path | None


def make_contact_job(file: str | None, given: dict[str, Any]) -> ContactJob:
    """The job of a file, or of glass beads without one, changed by the options.

    Raises
    ------
    ValueError
        For anything that no run can be made of.
    """
    law_name, parameters = given.pop("law"), given_law_parameters(given)
    content = _changed(read(file), {name: v for name, v in given.items() if v not in (None, ())})
    run = content["event_driven"]
    for name in ("restitution", "rule", "contact_duration", "max_collisions"):
        if name in run:
            raise ValueError(f"{name}: must be left out with --engine")
    outputs = _checked_outputs(content["output"])
    for name in ("out", "plot", "animate"):
        if outputs[name] is not None:
            raise ValueError(f"--{name}: must be left out with --engine")
    law = content["law"]
    if law_name is not None or parameters:
        law = law_of(law, law_name, parameters)
    if law is None:
        raise ValueError("--law: must be given with --engine, with its parameters")
    system = start(content)
    until = run.pop("until", None)
    return ContactJob(system, law, usual_end(system) if until is None else until, run, outputs["save"])


def _changed(content: dict[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a job, changed by options."""
    for table, names in (("random", RANDOM), ("event_driven", RUN), ("output", dict.fromkeys(OUTPUTS))):
        content[table] |= {name: options[name] for name in names if name in options}
    return content


def _resumed(file: str | None, path: str, options: dict[str, Any]) -> Job:
    """A run from its checkpoint, which holds everything but a new end and the files to write."""
    outputs = _checked_outputs({name: options.pop(name, None) for name in OUTPUTS})
    end = {name: options.pop(name, None) for name in ("until", "max_collisions")}
    strange = "FILE" if file is not None else f"--{next(iter(options), '').replace('_', '-')}"
    if file is not None or options:
        raise ValueError(f"{strange}: must be left out with --resume: the checkpoint holds it")
    course = load(path)
    if any(value is not None for value in end.values()):
        course.set_end(*runs.later_end(course, **end))
    _refuse_frames_without_end(outputs, course.target.until, course.target.max_collisions)
    return Job(course, outputs)


# --- files --------------------------------------------------------------------------------------------------


def read(file: str | None) -> dict[str, Any]:
    """The content of a job file by table; a start from a file of particles is under "start"."""
    content: dict[str, Any] = {"start": None, "law": None, "random": {}, "event_driven": {}, "output": {}}
    if file is None:
        return content
    ending = Path(file).suffix.lower()
    if ending in FORMATS:
        return content | {"start": file}
    if ending != ".toml":
        raise ValueError(
            f"FILE: got {validation.shown(file)}, must end in {validation.any_of(['.toml', *FORMATS])}"
        )
    found = toml.read(file)
    return columns.prefixed(f"{file}: ", lambda: _from_tables(found, Path(file).parent, content))


def _from_tables(found: Mapping[str, Any], folder: Path, content: dict[str, Any]) -> dict[str, Any]:
    """The tables of a job file; names of files in it are relative to its folder."""
    from msgspec import structs

    table = toml.convert(found, _schema())
    for name, kinds in (("random", RANDOM), ("event_driven", RUN), ("output", dict.fromkeys(OUTPUTS))):
        inner = getattr(table, name)
        if inner is not None:
            given = {key: value for key, value in structs.asdict(inner).items() if value is not None}
            content[name] = {key: _quantity(f"{name}.{key}", v, kinds[key]) for key, v in given.items()}
    if table.law is not None:
        content["law"] = columns.law_from_table("law.", table.law)
    if table.start is not None:
        if content["random"].keys() - set(OF_THE_BOX):
            raise ValueError("start | random: got both, must be one file or one random start")
        content["start"] = str(folder / table.start)
    return content


def _schema() -> Any:
    """The structure of a job file."""
    from msgspec import defstruct

    from ..column.schema import Quantity, any_law

    whole, text = int | None, str | None
    kinds: dict[str, Any] = {
        "n": whole,
        "dimension": whole,
        "seed": whole,
        "samples": whole,
        "max_collisions": whole,
        "rule": text,
        "checkpoint": text,
        "boundary": str | list[str] | None,
        "radius": Quantity | list[Quantity] | None,
        "density": Quantity | list[Quantity] | None,
        "gravity": Quantity | list[Quantity] | None,
    }

    def of(name: str, keys: Any) -> Any:
        fields = [
            (key, kinds.get(key, text if name == "OutputTable" else Quantity | None), None) for key in keys
        ]
        return defstruct(name, fields, forbid_unknown_fields=True)

    return defstruct(
        "GasTable",
        [
            ("start", text, None),
            ("random", of("RandomTable", RANDOM) | None, None),
            ("law", any_law() | None, None),
            ("event_driven", of("RunTable", RUN) | None, None),
            ("output", of("OutputTable", OUTPUTS) | None, None),
        ],
        forbid_unknown_fields=True,
    )


def _quantity(name: str, value: Any, unit: str | None) -> Any:
    """The number, or the one that a text gives with its unit; of a list each."""
    if unit is None:
        return value
    if isinstance(value, list):
        return [_quantity(f"{name}[{i}]", one, unit) for i, one in enumerate(value)]
    return units.with_unit(name, value, unit) if isinstance(value, str) else value


# --- the parts of a job -------------------------------------------------------------------------------------


def start(content: Mapping[str, Any]) -> ParticleSystem:
    """The particles: from a file, its box changed by options, or at random."""
    given = {name: single(value) for name, value in content["random"].items()}
    if content["start"] is not None:
        strange = [name for name in given if name not in OF_THE_BOX]
        if strange:
            raise ValueError(f"{strange[0]}: must be left out with a start from a file")
        system = ParticleSystem.read(content["start"])
        return system.replace(**given) if given else system
    return ParticleSystem.random(**(USUAL | given), progress=True)


def single(value: Any) -> Any:
    """A list of one, which an option that may be repeated makes, is that one."""
    return value[0] if isinstance(value, list | tuple) and len(value) == 1 else value


def _rules(
    content: Mapping[str, Any], law_name: str | None, parameters: dict[str, float]
) -> tuple[Settings, dict[str, Any]]:
    """What the collisions obey, and the rest of what a run takes."""
    run: dict[str, Any] = dict.fromkeys(RUN) | content["event_driven"]
    law, restitution = content["law"], run.pop("restitution")
    if law is not None and restitution is not None:
        raise ValueError("law | event_driven.restitution: got both, must be exactly one of them")
    if law_name is not None or law is not None or parameters.keys() - {"restitution"}:
        law, restitution = law_of(law, law_name, parameters), None
    else:
        restitution = parameters.get("restitution", USUAL_RESTITUTION if restitution is None else restitution)
    return checked_settings(law, restitution, run.pop("rule"), run.pop("contact_duration")), run


def law_of(present: Law | None, name: str | None, parameters: Mapping[str, float]) -> Law:
    """Another law, or other parameters of the present one."""
    base = columns.of_column(Column.paper())
    scenario = replace(base, laws=() if present is None else (present,))
    if name is None and not parameters:
        return scenario.laws[0]
    if present is not None or name is not None:
        return columns.with_law(scenario, name, parameters).laws[0]
    return columns.law_with(None, parameters)(**parameters)


def usual_end(system: ParticleSystem) -> float:
    """Time [s] for some collisions of every particle, as a round number."""
    return float(f"{runs.expected_duration(system, USUAL_COLLISIONS * system.n // 2):.2g}")


def _checked_outputs(given: Mapping[str, Any]) -> dict[str, Path | None]:
    trajectories = [ending for ending, kind in FORMATS.items() if kind is not FORMATS[".data"]]
    return {
        "out": writable("out", given.get("out"), *trajectories),
        "save": writable("save", given.get("save"), ".nc"),
        "plot": picture("plot", given.get("plot")),
        "animate": film("animate", given.get("animate")),
    }


def _refuse_frames_without_end(outputs: Mapping[str, Path | None], until: Any, max_collisions: Any) -> None:
    """Frames are equally spaced, which takes an end in time."""
    for name in ("out", "animate"):
        if outputs[name] is not None and until is None and max_collisions is not None:
            raise ValueError(f"--{name}: needs --until, must have an end in time to space the frames by")
