"""``hardlimit paper``: every figure and statement of the paper."""

from __future__ import annotations

import click

from .common import Command


@click.command(cls=Command)
def paper() -> None:
    """Compute the figures of the paper and check what its text states."""
