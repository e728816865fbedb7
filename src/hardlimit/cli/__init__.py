"""The command line ``hardlimit``: one module for each command. It computes nothing itself."""

from __future__ import annotations

from importlib import import_module

import click

from .program import Program, no_such_command

#: Each command with its first line of help; it is ``NAME`` in the module ``NAME``, which is imported when it is run.
COMMANDS = {
    "cite": "Print BibTeX of the package and of what its results rest on.",
    "completion": "Print the script that completes commands in a shell.",
    "contact": "One contact: its duration, restitution and damping.",
    "convert": "A restitution as the input of particle codes, and back.",
    "drop": "Drop a column of balls: Newton beside event-driven.",
    "explore": "Serve the interactive page on 127.0.0.1 until Ctrl-C.",
    "fit": "Fit a contact law to measurements, and say whether it holds.",
    "gas": "Let grains collide in a box as hard spheres, beside theory.",
    "paper": "Compute Figures 2–8 of the paper, and check its statements.",
    "stack": "Masses with which a stack throws its top ball fastest.",
    "sweep": "Compute a map over any parameters of a column of balls.",
}


class Commands(Program):
    """A group that lists its commands without importing them: each needs other parts of the package."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command = getattr(import_module(f".{name}", __name__), name)
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
