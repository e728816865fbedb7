"""What readers of all codes note of a script, and the stages of its runs."""

from __future__ import annotations

from dataclasses import replace

from .description import Contents, Description, Note, Quote, Stage


def names(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


class Reader:
    """Notes on a script, each once and in the order in which they came, and its stages so far."""

    code: str
    version: str | None

    def begin(self) -> None:
        """Without notes."""
        self.ignored: dict[Note, None] = {}
        self.invalidates: dict[Note, None] = {}
        self.warnings: dict[Note, None] = {}
        self.unknown: dict[Quote, None] = {}
        self.refused: dict[str, None] = {}
        self.stages: list[Stage] = []

    def continues(self, new: Stage) -> bool:
        """Whether a run has the settings of the last stage."""
        own = {name: getattr(new, name) for name in ("quote", "steps", "system", "contents")}
        return bool(self.stages) and replace(self.stages[-1], **own) == new

    def longer(self, steps: int | None, contents: Contents) -> None:
        """Continue the last stage."""
        old = self.stages[-1]
        both = None if steps is None or old.steps is None else old.steps + steps
        self.stages[-1] = replace(old, steps=both, contents=contents)

    def described(self) -> Description:
        """All notes and stages."""
        return Description(
            code=self.code,
            version=self.version,
            stages=tuple(self.stages),
            ignored=tuple(self.ignored),
            invalidates=tuple(self.invalidates),
            warnings=tuple(self.warnings),
            unknown=tuple(self.unknown),
            refused=tuple(self.refused),
        )
