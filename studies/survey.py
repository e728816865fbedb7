"""Which answers do the scripts of a folder get from ``check``, and how many have the number of their state?

    python studies/survey.py FOLDER [--json FILE] [--most 20]

Every file below the folder that is a script or a log of LAMMPS, LIGGGHTS or YADE is checked as it is, without further
numbers. A script at rest, pressed or flowing has its number if κ_p is known, a shaken one if Γ is, a gas if t_c ν is;
those with a longest stable step are counted as well. The reasons for a missing number and the statements that are not
understood are listed by how often they occur.
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


def surveyed(path: Path) -> dict[str, Any] | None:
    """What is said of one file; None if it is no script."""
    try:
        verdict = hl.check(path)
    except ValueError as error:
        text = str(error)
        if any(words in text for words in NOT_SCRIPTS):
            return None
        return {
            "state": "refused",
            "answer": "refused",
            "number": False,
            "step": False,
            "why": [reason(text)],
            "quotes": [],
        }
    state = verdict.state
    numbers = {"shaken": state.shaking, "gas": max((row.tc_nu or 0.0 for row in verdict.rows), default=0.0)}
    number = numbers.get(state.name, state.stiffness_number)
    quotes = [kind(quote) for quote in verdict.to_dict()["unknown"]]
    why = [f"not known: {what}" for what in verdict.missing] + [
        f"not understood: {quote}" for quote in quotes[:1]
    ]
    return {
        "state": state.name,
        "answer": ANSWERS[verdict.admissible],
        "number": bool(number),
        "step": state.largest_stable_step is not None,
        "why": [] if number else why or ["no pressure"],
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
    lines = [f"{'state':10}{'scripts':>8}{'yes':>6}{'no':>6}{'not said':>10}{'number':>8}{'stable step':>13}"]
    for state in (*STATES, "all"):
        own = [each for each in results if state in ("all", each["state"])]
        counts = Counter(each["answer"] for each in own)
        numbers, steps = (sum(each[name] for each in own) for name in ("number", "step"))
        columns = f"{counts['yes']:6}{counts['no']:6}{counts['cannot be said']:10}{numbers:8}{steps:13}"
        lines.append(f"{state:10}{len(own):8}{columns}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path, help="write what is said of each file")
    parser.add_argument("--most", type=int, default=20, help="reasons that are listed")
    arguments = parser.parse_args()
    results = dict[str, dict[str, Any]]()
    for path in sorted(arguments.folder.rglob("*")):
        if path.is_file() and path.stat().st_size <= LARGEST and (said := surveyed(path)) is not None:
            results[str(path.relative_to(arguments.folder))] = said
    print(table(list(results.values())))
    for title, name in (("No number, because", "why"), ("Not understood", "quotes")):
        counts = Counter(text for each in results.values() for text in set(each[name]))
        print(f"\n{title}:", *(f"{n:5} {text}" for text, n in counts.most_common(arguments.most)), sep="\n")
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
