"""``hardlimit gas compare``: one start through Newton's equations and each rule for hard spheres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click

from ..boxes.system import ParticleSystem, described
from ..contact.contact import Law
from ..contact.laws import LinearDashpot
from ..fidelity_study import MODELS, Fidelity, fidelity
from ..support import machine, validation
from . import gas_job
from .options import (
    dpi_option,
    given_law_parameters,
    law_options,
    options,
    output_option,
    picture,
    quantity_option,
    writable,
)
from .printing import console, digits, plain, print_json, show, table
from .program import Command

#: The law without options, of glass beads: softer than glass, t_c ν about 0.02.
USUAL_STIFFNESS: Final = 1e6
USUAL_REPLICAS: Final = 8
#: What counts of a job's table [event_driven].
OF_A_JOB: Final = ("until", "samples", "restitution", "contact_duration")

compare_options = options(
    click.option(
        "--models",
        multiple=True,
        help=f"Model, repeated: {' | '.join(MODELS)}; newton is there always.  [default: all]",
    ),
    quantity_option(
        "--contact-duration",
        unit="s",
        help="Contact duration of the rule tc [s].  [default: that of the law]",
    ),
    quantity_option(
        "--until", unit="s", help="End of each run [s].  [default: some 20 collisions per particle]"
    ),
    click.option("--samples", type=int, help="Equal spacings in time.  [default: 100]"),
    click.option(
        "--engine", help="How Newton’s equations are solved: auto | events | steps.  [default: auto]"
    ),
    click.option(
        "--replicas",
        type=int,
        help=f"Number of starts; error bars come from them.  [default: {USUAL_REPLICAS}]",
    ),
    click.option(
        "--resolution",
        type=float,
        help="Relative difference that should be told apart; the sentence says how many replicas that would take.  "
        "[default: 0.01]",
    ),
    click.option("--workers", type=int, help="Number of processes.  [default: one for each processor]"),
    click.option(
        "--scheduler", help="Address of a scheduler of dask.distributed, instead of processes here."
    ),
    output_option("--store", "File that keeps finished replicas; the same call goes on."),
    output_option("--out", "Means and replicas as NetCDF.", "FILE.nc"),
    output_option("--plot", "Differences over time (png, pdf, …)."),
    dpi_option,
    click.option("--json", "as_json", is_flag=True, help="Print JSON."),
)


def make_command(start_options: Callable[[Any], Any]) -> click.Command:
    """The command, with the options of a start that ``hardlimit gas`` has."""

    @click.command(
        "compare",
        cls=Command,
        epilog="\b\nExample:\n  hardlimit gas compare --n 500 --stiffness 2e5 --restitution 0.9 --plot compare.png",
    )
    @click.argument("file", required=False, metavar="[FILE]")
    @start_options
    @law_options()
    @compare_options
    def compare(file: str | None, dpi: float | None, as_json: bool, **given: Any) -> None:
        """How far is each rule for hard spheres from Newton's equations?

        FILE, start and law are as for hardlimit gas; without a law contacts are linear, with a stiffness of 1e6 N/m
        and a restitution of 0.9 unless given. Every replica starts from another random state, or, with particles from
        a FILE, another equilibrium state of them. Of a job, start, law, until, samples, restitution and contact
        duration count.
        """
        job = make_job(file, given)
        found = fidelity(job.source, law=job.law, **job.run, progress=True)
        written = []
        if job.outputs["out"]:
            written.append(found.save(job.outputs["out"]))
        if job.outputs["plot"]:
            from .. import plots

            written.append(plots.save(found.plot(), job.outputs["plot"], dpi))
        if as_json:
            print_json(as_mapping(found, written))
        else:
            print_report(job.start, found, written)

    return compare


# --- the job ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RandomStarts:
    """A random start for each seed."""

    given: dict[str, Any]

    def __call__(self, seed: int) -> ParticleSystem:
        return ParticleSystem.random(**(self.given | {"seed": seed}))


@dataclass(frozen=True)
class Job:
    """What is compared, and where it goes."""

    source: ParticleSystem | RandomStarts
    start: ParticleSystem  #: of replica 0
    law: Law
    run: dict[str, Any]  #: further arguments of ``hl.fidelity``
    outputs: dict[str, Path | None]  #: "out" and "plot"


def make_job(file: str | None, given: dict[str, Any]) -> Job:
    """The comparison that file and options ask for.

    Raises
    ------
    ValueError
        For anything that cannot be compared.
    """
    law_name, parameters = given.pop("law"), given_law_parameters(given)
    options = {name: value for name, value in given.items() if value not in (None, ())}
    outputs = {
        "out": writable("out", options.pop("out", None), ".nc"),
        "plot": picture("plot", options.pop("plot", None)),
    }
    content = gas_job.read(file)
    content["random"] |= {name: options.pop(name) for name in gas_job.RANDOM if name in options}
    run = {name: value for name, value in content["event_driven"].items() if name in OF_A_JOB}
    law = _law(content["law"], law_name, parameters, run.pop("restitution", None))
    run |= options
    if "models" in run:
        run["models"] = tuple(dict.fromkeys(("newton", *run["models"])))
    source, start = _source(content)
    if "until" not in run:
        run["until"] = gas_job.usual_end(start)
    if isinstance(source, RandomStarts):
        run["seed"] = source.given.get("seed", 0)
    run.setdefault("replicas", USUAL_REPLICAS)
    if "scheduler" not in run:
        run.setdefault("workers", machine.processors())
    return Job(source, start, law, run, outputs)


def _source(content: dict[str, Any]) -> tuple[ParticleSystem | RandomStarts, ParticleSystem]:
    """What makes the starts, and the first of them."""
    if content["start"] is not None:
        system = gas_job.start(content)
        return system, system
    random = {name: gas_job.single(value) for name, value in content["random"].items()}
    source = RandomStarts(gas_job.USUAL | random)
    return source, source(validation.whole("seed", random.get("seed", 0), 0, 2**62))


def _law(present: Law | None, name: str | None, parameters: dict[str, float], of_job: float | None) -> Law:
    """The law of file and options; the linear one with what is not given as usual."""
    if present is None and of_job is not None:
        parameters = {"restitution": of_job} | parameters
    usual = {"stiffness": USUAL_STIFFNESS, "restitution": gas_job.USUAL_RESTITUTION}
    linear = name in (None, LinearDashpot.record["name"])
    if present is None and linear and parameters.keys() <= usual.keys():
        return LinearDashpot(**(usual | parameters))
    return gas_job.law_of(present, name, parameters)


# --- what is printed ----------------------------------------------------------------------------------------


def print_report(start: ParticleSystem, found: Fidelity, files: list[Path]) -> None:
    """The system, differences at the end, when they left their bars, one sentence."""
    from ..fidelity_study import report as words

    out = console()
    what = "spheres" if start.dimension == 3 else "disks"
    rows = [[label, text] for label, text in described(start)]
    rows += [["law", repr(found.plan.law)], ["contact duration t_c [s]", digits(found.contact_duration, 4)]]
    rows += [["t_c ν, mean of the run", digits(found.tc_nu, 3)], ["replicas", str(found.n_replicas)]]
    show(out, f"{start.n} {what}", table(["", ""], rows))
    if len(found.models) > 1:
        head, body = words.table(found)
        below = words.legend(found) if found.n_replicas > 1 else "no error bars"
        show(out, "Difference from Newton’s equations at the end [%]", table(head, body), below)
        left = words.departures(found)
        if left:
            show(out, "First told apart after [t_c], by [%]", table(head, left))
    head, body = words.contacts(found)
    show(out, "Contacts", table(head, body))
    out.print(found.summary(), markup=False)
    for path in files:
        out.print(f"written to {path}", markup=False)


def as_mapping(found: Fidelity, files: list[Path]) -> dict[str, Any]:
    """The sentence, and means and differences with their errors, in SI units."""
    ds = found.dataset
    content: dict[str, Any] = plain(
        {
            **{name: value for name, value in ds.attrs.items() if name not in ("title", "source")},
            "models": found.models,
            "coordinates": {name: ds[name].values for name in ds.coords},
            "variables": {
                name: {"dims": v.dims, "units": v.attrs["units"], "values": v.values}
                for name, v in ds.data_vars.items()
            },
            "outcomes": {model: found.outcomes(model) for model in found.models},
            "files": files,
        }
    )
    return content
