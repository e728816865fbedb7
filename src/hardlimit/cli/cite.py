"""``hardlimit cite``: what to cite for what one has used."""

from __future__ import annotations

import click

from ..support import citations
from .printing import console, show, table
from .program import Command


@click.command(cls=Command, epilog="\b\nExample:\n  hardlimit cite newton viscoelastic > references.bib")
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
def cite(topics: tuple[str, ...]) -> None:
    """Print BibTeX of the package and of what its results rest on.

    A topic is a model, a law, a rule of collision, an engine, a box, a tool or a figure. Without one, a table of all
    topics is printed.
    """
    if topics:
        return click.echo(citations.bibtex(*topics), nl=False)
    rows = [
        [
            kind if name == names[0] else "",
            name,
            "; ".join(map(citations.in_words, citations.publications(name))),
        ]
        for kind, names in citations.topics().items()
        for name in names
    ]
    made = table(["", "topic", "rests on"], rows)
    for column in made.columns[1:]:
        column.justify = "left"
    show(console(), "What to cite", made, "BibTeX: hardlimit cite TOPIC ...")
