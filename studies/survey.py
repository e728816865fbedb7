"""Which answers do the scripts of a folder get from ``check``, and how many have the number of their state?

    python studies/survey.py FOLDER [--json FILE] [--most 20]

Every file below the folder that is a script or a log of LAMMPS, LIGGGHTS or YADE is checked as it is, without further
numbers; copies of the same text count once. Listed apart as "other", whether or not they are answered, are scripts

* whose contacts are those of other bodies or models than spheres with springs (polyhedra, grids, bonds, beams of
  ``L6Geom``, smoothed particles);
* of Python that set contacts only in functions or classes that they do not run themselves: modules and unit tests;
* in which no grain moves freely, as in computations of heat between fixed spheres.

number: κ_p of grains at rest, pressed or flowing, Γ of shaken ones, t_c ν of a gas (0 of grains that never meet; its
bound in a stream), ε, duration and overlap of one or two grains, or of grains that meet walls only. border: instead of
it, up to which pressure grains are rigid and κ_p below 100 layers, or t_c ν of a gas at a supposed packing fraction or
speed. step: the longest stable time step. any: one of the three. The reasons for a missing number and the statements
that are not understood are listed by how often they occur.
"""

import argparse
import json
import re
from collections import Counter
from pathlib import Path
from typing import Any, Final

import hardlimit as hl

LARGEST: Final = 2_000_000  #: bytes of a file
NOT_SCRIPTS: Final = ("has no granular contacts of", "cannot be read")
ANSWERS: Final = {True: "yes", False: "no", None: "cannot be said"}
STATES: Final = ("rest", "pressed", "flow", "shaken", "gas", "refused")
NUMBERS: Final = ("number", "border", "step")
#: What makes contacts of spheres with springs in a script: a pair style or a wall of grains, or YADE's functors.
SPHERES: Final = re.compile(
    r"pair_style\s.*\bgran|\bwall/gran|^\s*model\s+\w+"
    r"|Ip2_(FrictMat_FrictMat_(Mindlin|Frict)|ViscElMat_ViscElMat_ViscEl|CohFrictMat_CohFrictMat_CohFrict)Phys",
    re.MULTILINE,
)
#: Bodies and models of other kinds in scripts of YADE, and atom styles without spheres.
OTHERS: Final = re.compile(
    r"Polyhedra|Potential(Block|Particle)|[lL]evelSet|GridCo|[pP][fF]acet|Lubrication|SPHEngine|FoamCoupling"
    r"|Ip2_(?!FrictMat_FrictMat_(Mindlin|Frict)Phys|ViscElMat_ViscElMat_ViscElPhys|CohFrictMat_CohFrictMat_CohFrict)"
    r"|Ig2_Sphere_Sphere_L6Geom|setCohesion(Now|OnNewContacts)\s*=\s*(True|1)|superquadric|convexhull|pair_style\s+sph|bond_style\s+(?!none|zero)|cohesion\s+bond"
    r"|(IGeom|IPhys|Geometry|Physics|Constitutive)\w*Dispatcher"
)

#: The message for scripts whose grains are all fixed.
FIXED: Final = "no grain moves freely"
#: Beginnings of definitions in Python.
DEFINITION: Final = re.compile(r"(?:async\s+)?(?:def|class)\s+(\w+)|@")


def is_module(text: str) -> bool:
    """Whether a text of Python sets contacts only in functions or classes that it does not run itself."""
    blocks: list[list[str]] = [[]]
    for line in text.splitlines():
        decorated = len(blocks[-1]) == 1 and blocks[-1][0].startswith("@")
        if line[:1].strip() and not line.startswith(("#", ")", "]", "}")) and not decorated:
            blocks.append([])
        blocks[-1].append(line)
    run, defined = "", dict[str, str]()
    for lines in blocks:
        heads = [match for line in lines[:2] if (match := DEFINITION.match(line))]
        name = next((match[1] for match in heads if match[1]), None)
        if name is None:
            run += "\n".join(lines) + "\n"
        else:
            defined[name] = "\n".join(lines)
    while called := [name for name in defined if re.search(rf"\b{name}\s*\(", run)]:
        run += "".join(defined.pop(name) for name in called)
    return not SPHERES.search(run)


def surveyed(path: Path) -> dict[str, Any] | None:
    """What is said of one file; None if it is no script."""
    text = path.read_text("utf-8", errors="replace")
    other = not SPHERES.search(text) or bool(OTHERS.search(text))
    other = other or (path.suffix == ".py" and is_module(text))
    empty = {"state": "refused", "answer": "refused", **dict.fromkeys((*NUMBERS, "any"), False), "quotes": []}
    try:
        verdict = hl.check(path)
    except ValueError as error:
        message = str(error)
        if any(words in message for words in NOT_SCRIPTS):
            return None
        return {**empty, "other": other or FIXED in message, "why": [reason(message)]}
    state = verdict.state
    own = {"shaken": state.shaking, "gas": max((row.tc_nu or 0.0 for row in verdict.rows), default=0.0)}
    known = {
        "number": bool(
            own.get(state.name)
            or state.stiffness_number
            or state.grains is not None
            or state.never_meet
            or state.tc_nu_is_bound
        ),
        "border": state.pressure_for_rigid is not None
        or (state.supposed_tc_nu is not None and not state.tc_nu_is_bound),
        "step": state.largest_stable_step is not None,
    }
    quotes = [kind(quote) for quote in verdict.to_dict()["unknown"]]
    why = [f"not known: {what}" for what in verdict.missing] + [
        f"not understood: {quote}" for quote in quotes[:1]
    ]
    return {
        "state": state.name,
        "answer": ANSWERS[verdict.admissible],
        "other": other,
        **known,
        "any": any(known.values()),
        "why": [] if any(known.values()) else why or ["no pressure"],
        "quotes": quotes,
    }


def reason(message: str) -> str:
    """A message without file, line and the words of the script."""
    return re.sub(r"'[^']*'|\d+", "…", re.sub(r"^.*?line \d+: ", "", message))[:100]


def kind(quote: str) -> str:
    """The name of a quoted statement: its first word, of a fix its style."""
    statement = re.sub(r"^.*?line \d+: ", "", quote)
    words = statement.split()
    if words[:1] == ["fix"] and len(words) > 3:
        return f"fix {words[3]}"
    return re.split(r"[\s(=]", statement)[0][:40]


def table(results: list[dict[str, Any]]) -> str:
    """Counts by state: answers, and how many have their number."""
    names = (*NUMBERS, "any")
    head = "".join(f"{name:>8}" for name in names)
    lines = [f"{'state':10}{'scripts':>8}{'yes':>6}{'no':>6}{'not said':>10}{head}"]
    for state in (*STATES, "all", "other"):
        own = [
            each
            for each in results
            if each["other"] == (state == "other") and state in ("all", "other", each["state"])
        ]
        counts = Counter(each["answer"] for each in own)
        columns = f"{counts['yes']:6}{counts['no']:6}{counts['cannot be said']:10}"
        lines.append(
            f"{state:10}{len(own):8}{columns}"
            + "".join(f"{sum(each[name] for each in own):8}" for name in names)
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path, help="write what is said of each file")
    parser.add_argument("--most", type=int, default=20, help="reasons that are listed")
    arguments = parser.parse_args()
    results, texts = dict[str, dict[str, Any]](), set[bytes]()
    for path in sorted(arguments.folder.rglob("*")):
        if not path.is_file() or path.stat().st_size > LARGEST or path.read_bytes() in texts:
            continue
        texts.add(path.read_bytes())
        if (said := surveyed(path)) is not None:
            results[str(path.relative_to(arguments.folder))] = said
    print(table(list(results.values())))
    for title, name in (("No number, because", "why"), ("Not understood", "quotes")):
        counts = Counter(text for each in results.values() for text in set(each[name]))
        print(f"\n{title}:", *(f"{n:5} {text}" for text, n in counts.most_common(arguments.most)), sep="\n")
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
