"""The command line ``hardlimit``: one module for each command. It computes nothing itself."""

from __future__ import annotations

import click

from .cite import cite
from .completion import completion
from .contact import contact
from .convert import convert_command
from .drop import drop
from .explore import explore
from .fit import fit
from .gas import gas
from .paper import paper
from .program import Program
from .stack import stack
from .sweep import sweep


@click.group(
    cls=Program,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="\b\nExample:\n  hardlimit drop --restitution 0.9 --gap 1mm --plot drop.png",
)
@click.option("--version", is_flag=True, help="Show the version and exit.")
@click.option("--verbose", is_flag=True, help="With --version: compiler, instruction set, extras.")
@click.pass_context
def main(context: click.Context, version: bool, verbose: bool) -> None:
    """How far can you trust an event-driven simulation?

    Columns of balls as instantaneous collisions and under Newton's equations, side by side; boxes of grains as
    hard spheres. Quantities are in SI units, or bear their unit: 1e-3 or 1mm. Each command explains its options
    and shows an example: hardlimit COMMAND --help.
    """
    if verbose and not version:
        raise click.UsageError("--verbose: only with --version", context)
    if version:
        from . import version as report

        click.echo(report.verbose() if verbose else report.brief())
        context.exit()
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for command in (
    drop,
    contact,
    convert_command,
    fit,
    stack,
    paper,
    sweep,
    gas,
    explore,
    cite,
    completion,
):
    main.add_command(command)
