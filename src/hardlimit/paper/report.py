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


#: Titles of the tables of statements.
DEVIATE: Final = "Statements that do not agree, or agree only in part"
AGREE: Final = "Statements that agree"


@dataclass(frozen=True)
class Row:
    """A row of the table: one statement of the paper, and the result obtained here."""

    statement: str  #: a summary of the text
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

    def tables(self) -> list[tuple[str, list[Row]]]:
        """Title and rows of each table, deviations first."""
        return [
            (DEVIATE, self.chosen("statement", "no", "partly")),
            (AGREE, self.chosen("statement", "yes")),
            ("Density", self.chosen("density")),
            ("Misprints", self.chosen("misprint")),
        ]

    def summary(self) -> str:
        """One sentence: the number of statements that agree."""
        stated = self.chosen("statement")
        yes, partly, no = (len(self.chosen("statement", verdict)) for verdict in ("yes", "partly", "no"))
        misprints = len(self.chosen("misprint", "misprint"))
        return f"{yes} of {len(stated)} statements agree, {partly} in part, {no} not; {misprints} misprints"

    def to_markdown(self) -> str:
        """The report as Markdown: deviations first, then agreement, then the figures."""
        lines = [
            "# Figures and statements of Müller and Pöschel, Phys. Rev. E 83, 041304 (2011), computed",
            "",
            f"Density of the balls: {self.density:g} kg/m³ (the paper states none). {self.summary()}.",
            "",
            "Verdicts: " + "; ".join(f"**{verdict}**: {means}" for verdict, means in VERDICTS.items()) + ".",
        ]
        for title, rows in self.tables():
            lines += _section(title, rows)
        lines += ["", "## What the figures mean for event-driven simulations", ""]
        for number, sentence in self.meanings.items():
            lines.append(f"* **Fig. {number}.** {sentence} {self.choices.get(number, '')}".rstrip())
        return "\n".join(lines) + "\n"


def _section(title: str, rows: list[Row]) -> list[str]:
    """A heading and a table; empty without rows."""
    if not rows:
        return []
    lines = [
        "",
        f"## {title}",
        "",
        "| verdict | statement | place in the paper | result |",
        "|---|---|---|---|",
    ]
    for row in rows:
        cells = (row.agrees, row.statement, row.where, row.result)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines
