"""``hardlimit completion``: commands and options completed by the shell."""

from __future__ import annotations

import click
from click.shell_completion import get_completion_class

from .program import Command

#: Where each shell reads the script from.
INSTALL = {
    "bash": "hardlimit completion bash >> ~/.bashrc",
    "zsh": "hardlimit completion zsh >> ~/.zshrc",
    "fish": "hardlimit completion fish > ~/.config/fish/completions/hardlimit.fish",
}


@click.command(cls=Command, epilog="\b\nExample:\n  " + "\n  ".join(INSTALL.values()))
@click.argument("shell", type=click.Choice(list(INSTALL)))
def completion(shell: str) -> None:
    """Print the script that completes commands in a shell.

    Write it to where the shell reads it, as in the example, and open a new shell.
    """
    made = get_completion_class(shell)
    if made is None:
        raise RuntimeError(f"completion: click knows no {shell}")
    from . import main

    script = made(main, {}, "hardlimit", "_HARDLIMIT_COMPLETE")
    click.echo(f"# Install with: {INSTALL[shell]}")
    click.echo(script.source_template % script.source_vars())
