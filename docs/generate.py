"""Write the parts of the documentation that registries of the package state themselves, to docs/generated/.

``conf.py`` does this before each build.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

Record = Mapping[str, Any]
FOLDER = Path(__file__).resolve().parent / "generated"


def number(x: float) -> str:
    return ("−∞" if x < 0 else "∞") if math.isinf(x) else f"{x:g}".replace("-", "−")


def interval(parameter: Record) -> str:
    """Accepted values, with a round bracket where the bound itself is refused."""
    lowest, highest = parameter["lowest"], parameter["highest"]
    opening = "[" if parameter["lowest_allowed"] else "("
    closing = "]" if parameter["highest_allowed"] else ")"
    return f"{opening}{number(lowest)}, {number(highest)}{closing}"


def parameter_rows(group: str, parameters: Sequence[Record]) -> list[str]:
    """One row for each parameter; the first bears the name of the group."""
    return [
        f"| {'' if i else group} | `{p['name']}` | {p['unit']} | {interval(p)} | {p['meaning']} |"
        for i, p in enumerate(parameters)
    ]


def law_section(law: Record) -> str:
    lines = [
        f"## {law['class_name']}",
        "",
        law["summary"],
        "",
        f"Name on the command line: `{law['name']}`. Source: {law['source']}.",
        "",
        "| given | parameter | unit | range | meaning |",
        "|---|---|---|---|---|",
        *parameter_rows("always", law["common"]),
    ]
    for i, alternative in enumerate(law["alternatives"]):
        lines += parameter_rows("either" if i == 0 else "or", alternative)
    constants = ", ".join(f"`{c['name']}` {c['meaning']} [{c['unit']}]" for c in law["constants"])
    return "\n".join([*lines, "", f"A contact of this law has the attributes {constants}.", ""])


def friction_section(record: dict[str, Any]) -> str:
    lines = [
        "## Friction",
        "",
        "Every law takes `friction=hl.Friction(coefficient, …)`. {ref}`friction` has the equations.",
        "",
        "| given | parameter | unit | range | meaning |",
        "|---|---|---|---|---|",
    ]
    coefficient, *others = record["parameters"]
    lines += parameter_rows("always", [coefficient])
    for parameter in others:
        lines += parameter_rows(
            "or" if parameter["name"] in ("stiffness", "damping") else "either", [parameter]
        )
    lines += ["", "| model | tangential force | source |", "|---|---|---|"]
    lines += [f"| `{model['name']}` | {model['summary']} | {model['source']} |" for model in record["models"]]
    return "\n".join([*lines, ""])


def laws() -> str:
    from hardlimit import _core

    sections = [*(law_section(law) for law in _core.law_records()), friction_section(_core.friction_record())]
    return "\n".join(sections)


def rules() -> str:
    from hardlimit.boxes.rules import RULES

    lines = ["| rule | a collision | assumes | counted | source |", "|---|---|---|---|---|"]
    for rule in RULES.values():
        counted = ", ".join(f"`{name}`" for name in rule.counts)
        lines.append(f"| `{rule.name}` | {rule.meaning} | {rule.assumes} | {counted} | {rule.source} |")
    return "\n".join([*lines, ""])


def observables() -> str:
    from hardlimit.boxes.engines import ENGINES
    from hardlimit.boxes.observables import KINDS, OBSERVABLES

    lines = ["| variable | unit | meaning | shape | engines |", "|---|---|---|---|---|"]
    for record in OBSERVABLES.values():
        engines = [name for name, engine in ENGINES.items() if set(record.needs) <= set(engine.records)]
        if not engines:
            continue
        shown = "all" if len(engines) == len(ENGINES) else ", ".join(engines).replace("_", " ")
        shown += "; with friction" if record.of_friction else ""
        unit = f"{record.unit} (disks: {record.unit_of_disks})" if record.unit_of_disks else record.unit
        unit = unit.replace("m2/s2", "m²/s²")
        meaning = (record.meaning + KINDS[record.kind]).replace("|", "\\|")
        lines.append(f"| `{record.name}` | {unit} | {meaning} | {record.shape} | {shown} |")
    return "\n".join([*lines, ""])


FILES: dict[str, Callable[[], str]] = {"laws.md": laws, "rules.md": rules, "observables.md": observables}


def write() -> None:
    """A file that does not change is left as it is, so that a second build reads it from its cache."""
    FOLDER.mkdir(exist_ok=True)
    for name, content in FILES.items():
        path, text = FOLDER / name, content()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write()
