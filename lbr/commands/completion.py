"""`lbr completion`."""

import click
from click.shell_completion import get_completion_class

from lbr.cli import cli

SHELLS = ("bash", "zsh", "fish")


@click.command("completion")
@click.argument("shell", type=click.Choice(SHELLS), metavar="SHELL")
def command(shell: str) -> int:
    """Print a script for a shell that completes lbr's commands: profiles, robots, topics, motions and words of a
    running robot.

    \b
    bash   eval "$(lbr completion bash)"           in ~/.bashrc
    zsh    eval "$(lbr completion zsh)"            in ~/.zshrc, after compinit
    fish   lbr completion fish | source            in ~/.config/fish/config.fish
    """
    found = get_completion_class(shell)
    assert found is not None
    click.echo(found(cli, {}, "lbr", "_LBR_COMPLETE").source())
    return 0
