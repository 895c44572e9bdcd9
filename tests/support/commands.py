"""Commands of `lbr` in this process, by what is typed after it."""

import io
import os
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from subprocess import CompletedProcess
from unittest.mock import patch

from click.testing import CliRunner, Result

from lbr.cli import cli, main


def typed(*words: str) -> Result:
    """Run a command, and return what it printed, returned or raised."""
    return CliRunner().invoke(cli, words, standalone_mode=False)


def db(*words: str) -> Result:
    """Run a command of `lbr db`."""
    return typed("db", *words)


def here(home: Path, *words: str) -> CompletedProcess[str]:
    """Run a command in a home to its end, as a program would: that takes a third of a second to import what is here."""
    out, err = io.StringIO(), io.StringIO()
    with patch.dict(os.environ, LBR_HOME=str(home)), redirect_stdout(out), redirect_stderr(err):
        code = main([*words])
    return CompletedProcess(words, code, out.getvalue(), err.getvalue())
