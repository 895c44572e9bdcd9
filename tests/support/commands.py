"""Commands of `lbr` in this process, by what is typed after it."""

from click.testing import CliRunner, Result

from lbr.cli import cli


def typed(*words: str) -> Result:
    """Run a command, and return what it printed, returned or raised."""
    return CliRunner().invoke(cli, words, standalone_mode=False)


def db(*words: str) -> Result:
    """Run a command of `lbr db`."""
    return typed("db", *words)
