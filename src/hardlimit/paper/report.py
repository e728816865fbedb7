"""What `hardlimit paper` hands back: files, sentences, and the table of statements."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

Agreement = Literal["yes", "no", "partly"]


@dataclass(frozen=True)
class Row:
    """One statement of the paper and what comes out here."""

    statement: str  #: in our words
    where: str  #: in the paper
    result: str  #: what we get
    agrees: Agreement
    kind: Literal["statement", "misprint", "density"] = "statement"


@dataclass
class Report:
    """All that one run produced."""

    out: Path
    density: float
    files: list[Path] = field(default_factory=list)
    meanings: dict[int, str] = field(
        default_factory=dict
    )  #: figure → what it means for event-driven simulations
    choices: dict[int, str] = field(
        default_factory=dict
    )  #: figure → what the paper leaves open and was chosen here
    rows: list[Row] = field(default_factory=list)
    wall_time: float = 0.0  #: [s]

    def to_dict(self) -> dict[str, Any]:
        """Plain lists and strings, for JSON."""
        return {
            "out": str(self.out),
            "density": self.density,
            "files": [str(path) for path in self.files],
            "meanings": {str(k): v for k, v in self.meanings.items()},
            "choices": {str(k): v for k, v in self.choices.items() if v},
            "statements": [asdict(row) for row in self.rows],
            "wall_time_s": self.wall_time,
        }

    def to_markdown(self) -> str:
        """The report as a page of text."""
        lines = [
            "# Müller and Pöschel, Phys. Rev. E 83, 041304 (2011), computed",
            "",
            f"Density {self.density:g} kg/m³ (the paper prints none).",
            "",
            "## Figures, and what they mean for event-driven simulations",
            "",
        ]
        for number, sentence in self.meanings.items():
            lines.append(f"* **Fig. {number}.** {sentence} {self.choices.get(number, '')}".rstrip())
        titles = {"statement": "Statements", "density": "Density", "misprint": "Misprints"}
        for kind, title in titles.items():
            rows = [row for row in self.rows if row.kind == kind]
            if not rows:
                continue
            lines += [
                "",
                f"## {title}",
                "",
                "| statement | where | what comes out | agrees |",
                "|---|---|---|---|",
            ]
            for row in rows:
                cells = (row.statement, row.where, row.result, row.agrees)
                lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        return "\n".join(lines) + "\n"
