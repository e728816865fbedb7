"""The command line ``hardlimit``: a module for each command, ``about`` for the small ones. It computes nothing itself.

The functions raise a ValueError for invalid input, which :mod:`hardlimit.cli.program` prints in one line.
"""

from __future__ import annotations

from importlib import import_module

import click

from .program import Program, no_such_command

#: Each command with the first line of its help. A command is imported when it is run.
COMMANDS = {
    "check": "Check what a script's contacts do, and if events may replace it.",
    "cite": "Print BibTeX entries for the package and the methods you used.",
    "completion": "Print a script that completes commands in your shell.",
    "contact": "Compute duration, restitution and damping of one contact.",
    "convert": "Convert a restitution to input of particle codes, and back.",
    "drop": "Drop a column of balls: Newton's equations and event-driven.",
    "explore": "Serve the interactive page on 127.0.0.1 until Ctrl-C.",
    "fit": "Fit a contact law to measurements and test whether it holds.",
    "gas": "Simulate a box of grains as hard spheres.",
    "paper": "Compute Figures 2–8 of the paper and check its statements.",
    "stack": "Find the masses with which a stack throws its top ball fastest.",
    "sweep": "Compute a map over any parameters of a column of balls.",
}
#: Commands that share a module.
ABOUT = ("cite", "completion", "explore")


class Commands(Program):
    """A group that lists its commands without importing them."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module = import_module(f".{'about' if name in ABOUT else name}", __name__)
        command = getattr(module, name)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            raise no_such_command(ctx, args[0], COMMANDS)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="\b\nExample:\n  hardlimit drop --restitution 0.9 --gap 1mm --plot drop.png",
)
@click.option("--version", is_flag=True, help="Show the version and exit.")
@click.option("--verbose", is_flag=True, help="With --version: compiler, instruction set, extras.")
@click.pass_context
def main(context: click.Context, version: bool, verbose: bool) -> None:
    """How far can you trust an event-driven simulation?

    Compares instantaneous collisions with Newton's equations for columns of balls and boxes of grains. Numbers are in
    SI units or have a unit: 1e-3 or 1mm. For the options of a command and an example, run hardlimit COMMAND --help.
    """
    if verbose and not version:
        raise click.UsageError("--verbose: only with --version", context)
    if version:
        from . import about

        try:
            click.echo(about.verbose() if verbose else about.brief())
        except ValueError as error:  # HARDLIMIT_LANES names no instruction set of this processor
            raise click.UsageError(str(error), context) from None
        context.exit()
    if context.invoked_subcommand is None:
        click.echo(context.get_help())
