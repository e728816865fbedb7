"""``hardlimit explore``: the interactive page."""

from __future__ import annotations

import click

from .program import Command


@click.command(cls=Command, epilog="\b\nExample:\n  hardlimit explore --port 8765 --no-browser")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8000,
    show_default=True,
    help="Port of the page; 0 takes any free one.",
)
@click.option("--browser/--no-browser", "open_browser", default=True, help="Open the page in the browser.")
def explore(port: int, open_browser: bool) -> None:
    """Serve the interactive page on 127.0.0.1 until Ctrl-C."""
    from ..explorer import server

    server.serve(port, open_browser)
