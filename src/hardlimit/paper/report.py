"""Report of ``hardlimit paper``: files, the table of statements, and a sentence for each figure."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

Agreement = Literal["yes", "partly", "no", "misprint"]
Kind = Literal["statement", "misprint", "density"]

#: Meaning of each verdict, deviations first.
VERDICTS: Final[dict[Agreement, str]] = {
    "no": "does not agree",
    "partly": "agrees in part",
    "yes": "agrees",
    "misprint": "misprint, contradicted by the numbers",
}


@dataclass(frozen=True)
class Row:
    """A row of the table: one statement of the paper, and the result obtained here."""

    statement: str  #: in our words
    where: str  #: place in the paper
    result: str  #: result obtained here
    agrees: Agreement
    kind: Kind = "statement"


@dataclass
class Report:
    """Result of one run."""

    out: Path
    density: float
    files: list[Path] = field(default_factory=list)
    #: Meaning of each figure for event-driven simulations.
    meanings: dict[int, str] = field(default_factory=dict)
    #: Choices that the paper leaves open, for each figure.
    choices: dict[int, str] = field(default_factory=dict)
    rows: list[Row] = field(default_factory=list)
    wall_time: float = 0.0  #: [s]

    def to_dict(self) -> dict[str, Any]:
        """The report as lists and strings for JSON."""
        return {
            "out": str(self.out),
            "density": self.density,
            "files": [str(path) for path in self.files],
            "meanings": {str(k): v for k, v in self.meanings.items()},
            "choices": {str(k): v for k, v in self.choices.items() if v},
            "statements": [asdict(row) for row in self.rows],
            "wall_time_s": self.wall_time,
        }

    def chosen(self, kind: str, *agrees: Agreement) -> list[Row]:
        """The rows of one kind in the order of the paper, restricted to the given verdicts if any."""
        return [row for row in self.rows if row.kind == kind and (not agrees or row.agrees in agrees)]

    def summary(self) -> str:
        """One sentence: the number of statements that agree."""
        stated = self.chosen("statement")
        count = {verdict: len(self.chosen("statement", verdict)) for verdict in VERDICTS}
        misprints = len(self.chosen("misprint", "misprint"))
        return (
            f"{count['yes']} of {len(stated)} statements agree, {count['partly']} in part, {count['no']} not; "
            f"{misprints} misprints"
        )

    def to_markdown(self) -> str:
        """The report as Markdown: deviations first, then agreement, then the figures."""
        lines = [
            "# Müller and Pöschel, Phys. Rev. E 83, 041304 (2011), computed",
            "",
            f"Density {self.density:g} kg/m³ (the paper prints none). {self.summary()}.",
            "",
            "Verdicts: " + "; ".join(f"**{verdict}**: {means}" for verdict, means in VERDICTS.items()) + ".",
        ]
        lines += _section(
            "Statements that do not agree, or only in part", self.chosen("statement", "no", "partly")
        )
        lines += _section("Statements that agree", self.chosen("statement", "yes"))
        lines += _section("Density", self.chosen("density"))
        lines += _section("Misprints", self.chosen("misprint"))
        lines += ["", "## Figures, and what they mean for event-driven simulations", ""]
        for number, sentence in self.meanings.items():
            lines.append(f"* **Fig. {number}.** {sentence} {self.choices.get(number, '')}".rstrip())
        return "\n".join(lines) + "\n"


def _section(title: str, rows: list[Row]) -> list[str]:
    """A heading and a table; empty without rows."""
    if not rows:
        return []
    lines = ["", f"## {title}", "", "| verdict | statement | where | what comes out |", "|---|---|---|---|"]
    for row in rows:
        cells = (row.agrees, row.statement, row.where, row.result)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines
