"""``hardlimit check``: what a script's contacts really do, and whether event-driven simulation may replace it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ..boxes import spins
from ..boxes.error_law import MEASURED_TC_NU
from ..checking import state_words
from ..checking.answer import Question, given_by, judged, stiffness
from ..checking.checking import check as checked
from ..checking.contacts import CheckedContact
from ..checking.expectation import ACCEPTED
from ..checking.friction_words import but_for_steps, words
from ..checking.result import Finding, Verdict
from ..column import files
from ..contact.balls import Ball
from ..convert.codes import code as code_of
from ..support.formatting import digits, length, listed, percent, percent_with_error, quantity
from .options import (
    Quantity,
    friction_options,
    json_option,
    law_options,
    options,
    quantity_option,
    quantity_options,
    spelled,
    take_friction,
    take_law,
)
from .printing import console, print_json
from .program import FAILURE, Command

EXAMPLES = """\
\b
Example:
  hardlimit check --radius 1mm --density 2500 --stiffness 1e5 --restitution 0.9 \\
      --speed 0.3m/s --packing-fraction 0.3
  hardlimit check in.box --speed 0.1:2m/s --packing-fraction 0.3
  hardlimit check log.lammps --dump dump.box.gz"""

CODES = ("lammps", "liggghts", "yade")
#: A corrected time step without a reason of its own.
STEP = re.compile(r"timestep|O\.dt = ")
OWN_STEP = re.compile(r"(timestep|O\.dt = )(?!.*  # (?!\w+ units))")
#: Options whose names are not those of their arguments.
OPTIONS = {"variables": "--var", "shear_rate": "--shear"}
#: Arguments beside a script or numbers, and those of which only one may be given.
EXCLUSIVE = (("speed", "power", "shear_rate"), ("pressure", "height"))
CONDITIONS = (
    "dump",
    "packing_fraction",
    "restitution_error",
    *(name for names in EXCLUSIVE for name in names),
)
#: Largest number of rows without ``--verbose``.
MAX_ROWS = 8
#: Most findings in a list, and most characters of each, without ``--verbose``.
MAX_FINDINGS, LONGEST = 4, 60
#: Error of cooling where the law of the error does not hold.
FAR = f"≫ {percent(ACCEPTED)}"
#: Errors of ε below this are not written out.
SMALLEST_ERROR = 1e-4


class SpeedRange(Quantity):
    """A speed, or the lowest and the highest one as in ``0.1:2m/s``."""

    def read(self, option: str, text: str) -> float | tuple[float, float]:
        low, between, high = text.rpartition(":")
        top: float = super().read(option, high)
        unit = high.lstrip("+-0123456789.eE ")
        bare = low and not low.strip(" +-0123456789.eE")
        return (super().read(option, low + unit if bare else low), top) if between else top


def variable(ctx: click.Context, param: click.Parameter, texts: Sequence[str]) -> dict[str, str]:
    """The variables of ``--var NAME=VALUE``."""
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise click.UsageError(f"--var: got {text!r}, must be NAME=VALUE", ctx)
        values[name] = value
    return values


script_options = options(
    click.option(
        "--dump", metavar="FILE", help="Text dump of LAMMPS or LIGGGHTS, also .gz: packing, speeds, contacts."
    ),
    click.option(
        "--speed",
        type=SpeedRange("m/s"),
        metavar="SPEED[:SPEED]",
        help="Mean impact speed, or lowest and highest [m/s]; as in the script if it is in lj units.",
    ),
    quantity_option("--power", unit="W", help="Heating power of each grain [W] instead of the speed."),
    quantity_option("--shear", "shear_rate", unit="1/s", help="Shear rate [1/s] instead of the speed."),
    quantity_options(
        ("--packing-fraction", "1", "Packing fraction φ, instead of that of the dump."),
        ("--pressure", "Pa", "Pressure on grains at rest [Pa]; as in the script if it is in lj units."),
        ("--height", "m", "Height of the bed [m], instead of the pressure at its bottom."),
        (
            "--restitution-error",
            "1",
            "Error of ε that a time step may cause: that of the corrected lines.  [default: 0.001]",
        ),
    ),
    click.option(
        "--var",
        "variables",
        multiple=True,
        callback=variable,
        metavar="NAME=VALUE",
        help="Variable of the script, as on the command line of its code.",
    ),
    click.option(
        "--code", type=click.Choice(CODES), help="Code of the script.  [default: found in the script]"
    ),
    click.option(
        "--version",
        metavar="VERSION",
        help="Version of this code, such as 22Jul2025.  [default: that of a log]",
    ),
)
number_options = options(
    quantity_options(
        ("--radius", "m", "Radius [m] of the grains, if the script has none."),
        ("--density", "kg/m3", "Density [kg/m³] of the grains, if the script has none."),
        ("--mass", "kg", "Mass [kg] of a grain instead of the density."),
        ("--time-step", "s", "Time step [s] to check, instead of the script's."),
    ),
    click.option("--dimension", type=click.Choice(["2", "3"]), help="Solid disks or spheres.  [default: 3]"),
)


@click.command(cls=Command, aliases={name: "FILE" for name in ("file", "script", "source")}, epilog=EXAMPLES)
@click.argument("file", required=False)
@script_options
@number_options
@law_options()
@friction_options()
@click.option("--strict", is_flag=True, help="Exit with code 1 if the answer is no.")
@click.option("--verbose", is_flag=True, help="Print everything: each speed, all rules, quoted lines.")
@json_option()
def check(file: str | None, strict: bool, verbose: bool, as_json: bool, **numbers: Any) -> None:
    """Check what a script's contacts do, and if events may replace it.

    Reads a script or, better, a log of LAMMPS, LIGGGHTS or YADE; nothing in it is executed. For each pair of types and
    each wall, it prints the restitution that the code really gives, the duration, the steps per contact with the error
    that they cause, and the error of event-driven cooling. Without a file, it checks numbers.
    """
    conditions = {name: numbers.pop(name) for name in CONDITIONS}
    for names in EXCLUSIVE:
        if sum(conditions[name] is not None for name in names) > 1:
            options = " | ".join(OPTIONS.get(name, spelled(name)) for name in names)
            raise ValueError(f"{options}: must be at most one of them")
    scripted = {name: numbers.pop(name) for name in ("code", "version", "variables")}
    if file is None:
        verdict = from_numbers(numbers, scripted, conditions)
    else:
        known = {name: numbers.pop(name) for name in ("radius", "density", "mass", "time_step")}
        for name, value in numbers.items():
            if value is not None:
                raise ValueError(f"{spelled(name)}: got {value}, must be left out with a file")
        verdict = checked(Path(file), **scripted, **known, **conditions)
    if as_json:
        print_json(verdict.to_dict())
    else:
        report(verdict, verbose)
    if strict and verdict.admissible is False:
        click.get_current_context().exit(FAILURE)


def from_numbers(numbers: dict[str, Any], scripted: dict[str, Any], conditions: dict[str, Any]) -> Verdict:
    """The check of equal grains under one of our laws."""
    name, parameters = take_law(numbers)
    if numbers["radius"] is None:
        raise ValueError("give a file, or --radius with --density, a stiffness and --restitution")
    for argument, value in scripted.items():
        if value not in (None, {}):
            raise ValueError(f"{OPTIONS.get(argument, spelled(argument))}: must be left out without a file")
    dimension = int(numbers["dimension"] or 3)
    factor = spins.SOLID[dimension]
    ball = Ball(numbers["radius"], numbers["density"], numbers["mass"], inertia_factor=factor)
    law = take_friction(files.changed_law(None, name, parameters), numbers)
    return checked(ball, law=law, time_step=numbers["time_step"], dimension=dimension, **conditions)


# --- output -------------------------------------------------------------------------------------------------


def report(verdict: Verdict, verbose: bool) -> None:
    """The table of contacts, what was checked, the answer, and corrected lines."""
    last = max((row.stage for row in verdict.rows), default=1)
    rows = verdict.rows if verbose else [row for row in verdict.rows if row.stage == last]
    groups = list(grouped(rows, verdict.speeds_chosen))
    say(title(verdict), style="bold")
    groups = groups if verbose else merged(groups)
    shown = groups if verbose else groups[:MAX_ROWS]
    if shown:
        stages = verbose and last > 1
        walls = {
            g[0].types: {group[0].wall for group in groups if group[0].types == g[0].types} for g in groups
        }
        lines = [
            [
                str(g[0].stage),
                labelled(g[0], verdict, len(walls[g[0].types]) > 1),
                *cells(g, verdict.has_plain(g[0]), verdict.quantity),
            ]
            for g in shown
        ]
        table(["run", "contact", *HEAD, WORSE.get(verdict.quantity or "", "")], lines, stages)
    if hidden := len(groups) - len(shown):
        say(f"… and {hidden} more contact{'s' * (hidden > 1)}: --verbose")
    if not verbose and len({row.stage for row in verdict.rows}) > 1:
        which = f"run {last}{units_of(verdict, last)}"
        say(f"Settings change between runs. These are of {which}; --verbose has the others.")
    say_first(friction_lines(groups, verdict), MAX_ROWS, verbose)
    say_first(list(warnings(verdict.warnings, verbose)), MAX_FINDINGS, verbose)
    if remarks := [*map(str, verdict.inferred), *verdict.remarks]:
        say(" ".join(remarks))
    if verbose:
        details(verdict)
        for line in state_words.details(verdict):
            say(line)
    if summary := lists(verdict, verbose):
        say(summary)
    more = " More: --verbose." if verdict.admissible is False and not verbose else ""
    corrected = corrections(verdict)
    if corrected:  # a quoted statement stands alone
        corrected = (" " if verdict.sentence.endswith(".") or more else "\n") + corrected
    say(f"{verdict}{more}{corrected}", style="bold")
    for line in verdict.corrected:
        click.echo(f"  {line}")


def say_first(paragraphs: Sequence[str], most: int, verbose: bool) -> None:
    """Print the first paragraphs, or all."""
    few = paragraphs if verbose else paragraphs[:most]
    for paragraph in few:
        say(paragraph)
    if len(few) < len(paragraphs):
        say(f"… and {len(paragraphs) - len(few)} more: --verbose")


def friction_lines(groups: Sequence[list[CheckedContact]], verdict: Verdict) -> list[str]:
    """What friction does in each contact, at its highest speed; contacts with the same numbers share a line."""
    last = {(rows[0].stage, name(rows[0], True, True)): rows[-1] for rows in groups}
    lines: dict[str, list[CheckedContact]] = {}
    for row in last.values():
        if text := but_for_steps(row.friction):
            lines.setdefault(text, []).append(row)
    pairs = [{"–".join(row.types) for row in rows} for rows in lines.values()]
    texts = []
    for rows, own in zip(lines.values(), pairs, strict=True):
        apart = any(own & others for others in pairs if others is not own)
        names = list(
            dict.fromkeys(labelled(row, verdict, True) if apart else "–".join(row.types) for row in rows)
        )
        more = " …" * (len(names) > MAX_FINDINGS)
        texts.append(f"{', '.join(names[:MAX_FINDINGS])}{more}  {words([row.friction for row in rows])}")
    return texts


def warnings(findings: Sequence[Finding], verbose: bool) -> Iterator[str]:
    """Each warning once: with its contacts, or if ``verbose`` with its first place in the script, and minor ones."""
    same: dict[str, list[Finding]] = {}
    for finding in findings:
        if verbose or not finding.minor:
            same.setdefault(finding.what, []).append(finding)
    for what, each in same.items():
        pairs = list(
            dict.fromkeys("–".join(finding.types) for finding in each if finding.types and not finding.where)
        )
        of = f"{', '.join(pairs[:MAX_FINDINGS])}{' …' * (len(pairs) > MAX_FINDINGS)}: " if pairs else ""
        where = f" ({each[0].where})" if verbose and each[0].where else ""
        yield f"Warning: {of}{what}{where}."


def corrections(verdict: Verdict) -> str:
    """What the corrected lines are for; empty if there are none."""
    if not verdict.corrected:
        return ""
    step = any(OWN_STEP.match(line) for line in verdict.corrected)
    of = f" (time step for an error of ε of {digits(verdict.restitution_error, 2)})" if step else " (for ε)"
    if all(STEP.match(line) for line in verdict.corrected) and not step:
        of = ""  # which say what they are for
    return f"Corrected lines{of}:"


def labelled(row: CheckedContact, verdict: Verdict, walls: bool) -> str:
    """The name of a contact, with its speed if it was chosen."""
    text = name(row, verdict.has_plain(row), walls)
    return f"{text}, {digits(row.speed, 3)} m/s" if verdict.speeds_chosen and row.speed is not None else text


def units_of(verdict: Verdict, run: int) -> str:
    """The units of a run of a script with several."""
    return (
        f" ({verdict.stages[run - 1].units} units)"
        if len({stage.units for stage in verdict.stages}) > 1
        else ""
    )


HEAD = [
    "ε\nasked",
    "ε\ngiven",
    "t_c",
    "steps",
    "error\nof ε",
    "error\nof β",
    "over-\nlap",
    "t_c ν",
]
#: The head of the error that decides.
WORSE = {"cooling": "cools\nfaster by", "temperature": "hotter\nby", "stress": "stress\nhigher by"}
#: Columns that a table leaves out if it is too wide, the first first.
SPARE = ["steps", "over-\nlap", "error\nof β", "error\nof ε", "t_c"]


def table(head: Sequence[str], rows: Sequence[Sequence[str]], stages: bool) -> None:
    """Print the contacts without the columns of which nothing is known, and without the last of ``SPARE`` if too wide.

    ``--verbose`` has all numbers of each contact.
    """
    from rich.table import Table
    from rich.text import Text

    kept = [k for k in range(len(head)) if (k or stages) and (k < 2 or any(row[k] != "–" for row in rows))]
    if kept[-1] == 1:
        say(f"Contacts: {', '.join(row[1] for row in rows)}.")
        return
    spare = [head.index(name) for name in SPARE]
    while (gap := room(head, rows, kept)) < 1 and spare:
        kept = [k for k in kept if k != spare[0]]
        del spare[0]
    sheet = Table(box=None, pad_edge=False, padding=(0, min(max(gap, 1), 2), 0, 0))
    for k in kept:
        sheet.add_column(Text(head[k]), justify="left" if k < 2 else "right", no_wrap=True, vertical="bottom")
    for row in rows:
        sheet.add_row(*(Text(row[k]) for k in kept))
    console().print(sheet)


def room(head: Sequence[str], rows: Sequence[Sequence[str]], kept: Sequence[int]) -> int:
    """Blanks between these columns with which they fill the terminal; negative if they do not fit."""
    widths = [
        max(len(part) for text in (head[k], *(row[k] for row in rows)) for part in text.split("\n"))
        for k in kept
    ]
    return (console().width - sum(widths)) // max(1, len(kept) - 1)


def say(text: str, style: str = "") -> None:
    """Print a paragraph."""
    from rich.text import Text

    console().print(Text(text, style=style))


def title(verdict: Verdict) -> str:
    """Code, models, units and time step."""
    names = list(dict.fromkeys(row.model for row in verdict.rows if row.model))
    if verdict.code is None:
        parts = [f"{listed(names)} law" if names else ""]
    else:
        known = code_of(verdict.code)
        titles = [
            known.model(name).title.removeprefix("pair_style ").replace(", damping", ",") for name in names
        ]
        what = titles[0] if len(titles) == 1 else listed(names) if names else ""
        version = (verdict.version or "").partition(",")[0].removeprefix(f"{known.title}-")
        parts = [f"{known.title}{f' {version}:' if version else ''} {what}".strip(" :")]
        if verdict.code != "yade":  # YADE has SI units only
            every = list(dict.fromkeys([*(stage.units for stage in verdict.stages), verdict.units]))
            parts.append(f"{listed(every)} units{'' if verdict.units_given else ' (none given)'}")
    speeds = [
        row.speed
        for row in verdict.rows
        if row.speed is not None
        and row.types[1] != "wall"
        and verdict.has_plain(row) == (verdict.units == "lj")
    ]
    ends = [digits(end, 3) for end in (min(speeds), max(speeds))] if speeds else []
    if len(set(ends)) > 1:
        shown = "–".join(ends)
        parts.append(f"speeds {shown}" if verdict.units == "lj" else f"{shown} m/s")
    if verdict.time_step is not None:
        parts.append(f"time step {time(verdict.time_step, verdict.units == 'lj', 4)}")
    return " · ".join(filter(None, parts))


def grouped(rows: Iterable[CheckedContact], apart: bool) -> Iterator[list[CheckedContact]]:
    """The rows of each contact, which differ in the speed; each alone if they are to stand ``apart``."""
    groups: dict[Any, list[CheckedContact]] = {}
    for row in rows:
        speed = row.speed if apart else None
        groups.setdefault((row.stage, row.types, row.wall, row.radius, row.other_radius, speed), []).append(
            row
        )
    yield from groups.values()


def merged(groups: Sequence[list[CheckedContact]]) -> list[list[CheckedContact]]:
    """The contacts with equal walls as one, which has the names of all."""
    groups_of: dict[Any, list[list[CheckedContact]]] = {}
    for rows in groups:
        wall = rows[0].types[1] == "wall"
        key = repr([replace(row, wall=None) for row in rows]) if wall else len(groups_of)
        groups_of.setdefault(key, []).append(rows)
    return [
        [replace(row, wall=wall_names([rows_of_wall[0].wall for rows_of_wall in each])) for row in each[0]]
        for each in groups_of.values()
    ]


def wall_names(names: Sequence[str | None]) -> str | None:
    """Names of walls, at most two of them."""
    known = [name for name in names if name]
    more = len(known) - 2
    return f"{', '.join(known[:2])}{f' and {more} more' if more > 0 else ''}" or None


def name(row: CheckedContact, plain: bool, walls: bool) -> str:
    """Types and sizes, and the name of the wall if there are several."""
    radii = [r for r in (row.radius, row.other_radius) if r is not None]
    sizes = ", ".join(dict.fromkeys(digits(r, 4) if plain else length(float(f"{r:.4g}")) for r in radii))
    wall = f" {row.wall}" if row.wall and (walls or row.types[1] != "wall") else ""
    return f"{'–'.join(row.types)}{wall}{f' R {sizes}' if sizes else ''}"


def span(rows: Sequence[CheckedContact]) -> str:
    """ε over the speeds; a dash if it is not known."""
    values = [row.restitution for row in rows if row.restitution is not None]
    ends = [digits(v, 3) for v in (min(values), max(values))] if values else ["–"]
    return "–".join(dict.fromkeys(ends))


def time(value: float, plain: bool, significant: int = 3) -> str:
    """A time with its unit, or a number in lj units."""
    return digits(value, significant) if plain else quantity(value, "s", significant)


def cells(rows: Sequence[CheckedContact], plain: bool, quantity: str | None) -> list[str]:
    """One contact: ε over all speeds, other numbers at the highest one."""
    row = rows[-1]
    requested, tc, steps = row.restitution_asked, row.duration, row.steps_per_contact
    error, overlap, tc_nu = row.restitution_error_of_step, row.largest_overlap, row.tc_nu
    error_of_beta = row.friction.tangential_restitution_error_of_step
    wrong = judged(row, Question(quantity)) if quantity else None
    if row.types[1] == "wall":
        wrong = None
    return [
        "–" if requested is None else digits(requested, 3),
        span(rows),
        "–" if tc is None else time(tc, plain),
        "–" if steps is None else str(steps),
        "–" if error is None else small(error),
        "–" if error_of_beta is None else small(error_of_beta),
        "–" if overlap is None else percent(overlap),
        "–" if tc_nu is None else digits(tc_nu, 2),
        "–" if wrong is None else FAR if (tc_nu or 0.0) > MEASURED_TC_NU else cools(*wrong),
    ]


def small(error: float) -> str:
    """An error of ε or β."""
    if error > 1.0:
        return "> 1"
    return "< 1e-4" if error < SMALLEST_ERROR else digits(error, 2)


def cools(value: float, bar: float) -> str:
    """The error of cooling, negative if event-driven cools too slowly."""
    text = percent_with_error(abs(value), bar)
    return text if value >= 0.0 else f"−{text}"


def lists(verdict: Verdict, verbose: bool) -> str:
    """What was checked, ignored, invalidates the answer and is not known."""

    def whats(findings: Sequence[Finding]) -> str:
        """Findings in a few words, each kind once; all of them if ``verbose``."""
        if verbose:
            return ", ".join(dict.fromkeys(finding.what for finding in findings))
        kinds: dict[str, str] = {}
        for finding in findings:
            kinds.setdefault(finding.what.partition(" (")[0], finding.what)
        texts = list(kinds.values())
        if len(texts) > 1:
            texts = [text if len(text) <= LONGEST else f"{text[:LONGEST]}…" for text in texts]
        if len(texts) <= MAX_FINDINGS:
            return ", ".join(texts)
        return f"{', '.join(texts[: MAX_FINDINGS - 1])} and {len(texts) - MAX_FINDINGS + 1} more"

    parts = [f"Checked: {', '.join(finding.what for finding in verdict.checked)}." if verdict.checked else ""]
    if verdict.ignored:
        parts.append(f"Ignored: {whats(verdict.ignored)} (head-on ε stands).")
    if len(verdict.invalidates) > 1:  # the first is in the sentence
        parts.append(f"Not possible by events either: {whats(verdict.invalidates[1:])}.")
    unknown = [
        finding for finding in verdict.unknown if (finding.where or finding.what) not in verdict.sentence
    ]
    if unknown:
        parts.append(f"Not understood: {whats(unknown)}.")
    no_gas = verdict.state.name in ("rest", "pressed", "flow") or verdict.state.grains is not None
    unasked = {"speeds", "packing"} if no_gas else set()
    estimated = {"speeds"} if any(number.what == "speed" for number in verdict.inferred) else set()
    missing = [what for what in verdict.missing if what not in unasked | estimated]
    if missing and not any(listed(words) in verdict.sentence for words in (missing, verdict.missing)):
        parts.append(f"Not known: {listed(missing)}{given_by(missing, bool(verdict.states))}.")
    return " ".join(filter(None, parts))


def details(verdict: Verdict) -> None:
    """Each contact at each speed, the runs, the dump, and quoted lines."""
    for row in verdict.rows:
        say(detail(row, verdict.has_plain(row), verdict.restitution_error))
    for stage in verdict.stages:
        say(f"Run {stage.number}{units_of(verdict, stage.number)}: {stage.command}")
    plain = verdict.units == "lj"
    for state in verdict.states:
        phi, t, unit = state.packing_fraction, state.temperature, "" if plain else " m/s"
        parts = [
            f"φ {digits(phi, 3)}" if phi is not None else "",
            f"temperature {digits(t, 3)}{'' if plain else ' m²/s²'}" if t is not None else "",
            f"impact speeds {', '.join(digits(v, 3) for v in state.speeds)}{unit}" if state.speeds else "",
            f"largest overlap {percent(state.largest_overlap)}" if state.largest_overlap is not None else "",
            f"{digits(state.coordination, 3)} contacts per grain" if state.coordination is not None else "",
            f"{percent(state.in_several_contacts)} in several"
            if state.in_several_contacts is not None
            else "",
        ]
        say(f"Frame {state.step}, {state.grains} grains: {', '.join(filter(None, parts))}")
    for title, findings in (
        ("Ignored", verdict.ignored),
        ("Not possible", verdict.invalidates),
        ("Not understood", verdict.unknown),
    ):
        for finding in findings:
            types = f" ({', '.join(finding.types)})" if finding.types else ""
            say(f"{title}: {finding.what}{types}{f', {finding.where}' if finding.where else ''}")


def detail(row: CheckedContact, plain: bool, accepted: float) -> str:
    """All numbers of a contact at one speed."""

    def number(value: float | None, significant: int = 3) -> str | None:
        return None if value is None else digits(value, significant)

    def when(value: float | None) -> str | None:
        return None if value is None else time(value, plain)

    spring, error_of_beta = row.spring, row.friction.tangential_restitution_error_of_step
    parts = {
        "ε": number(row.restitution, 4),
        "t_c": when(row.duration),
        "steps": None if row.steps_per_contact is None else str(row.steps_per_contact),
        "error of ε": None if row.restitution_error_of_step is None else small(row.restitution_error_of_step),
        "error of β": None if error_of_beta is None else small(error_of_beta),
        "overlap": None if row.largest_overlap is None else percent(row.largest_overlap),
        "t_c ν": number(row.tc_nu, 2),
        "δ/d": number(row.delta_over_d, 2),
        "T_r/T": number(row.temperature_ratio, 2),
        f"time step for an error of {digits(accepted, 2)}": when(row.time_step),
        "Rayleigh time": when(row.rayleigh_time),
        "P-wave time": when(row.p_wave_time),
        "friction": words([row.friction]) or None,
        "error 1 % at": None
        if spring is None
        else f"{stiffness(spring[0])} of {digits(spring[2], 3)} {row.stiffness_unit}".rstrip(),
        "cools faster by": ", ".join(f"{cools(*e)} (rule {rule})" for rule, e in row.error.items()) or None,
    }
    unit = "" if plain else " m/s"
    speed = "" if row.speed is None else f" at {digits(row.speed, 3)}{unit}"
    force = "" if row.clipped is None else " (never attracts)" if row.clipped else " (attracts at its end)"
    return f"{name(row, plain, True)}{speed}, {row.model or 'no model'}{force}: " + ", ".join(
        f"{key} {value}" for key, value in parts.items() if value is not None
    )
