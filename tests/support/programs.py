"""Programs that tests and benchmarks start: the kernel kills each when the process that started it is gone."""

import subprocess
import threading
from collections.abc import Container, Sequence
from os import PathLike
from typing import Any

from lbr.capability.die_with_parent import dying_with_parent

Argv = Sequence["str | PathLike[str]"]


def start(argv: Argv, **options: Any) -> "subprocess.Popen[Any]":
    """Start a program, as `subprocess.Popen` does."""
    return subprocess.Popen(tied(argv, options), **options)


def run(argv: Argv, **options: Any) -> "subprocess.CompletedProcess[Any]":
    """Run a program to its end, as `subprocess.run` does."""
    return subprocess.run(tied(argv, options), **options)  # noqa: PLW1510 - the caller says `check`


def tied(argv: Argv, options: Container[str] = ()) -> list[str]:
    """Return what to start, so that it ends with us.

    From another thread than the main one nothing is tethered, because it would die with that; nor as another user, who may
    not run the interpreter of a folder that is ours.
    """
    words = tuple(str(word) for word in argv)
    ours = threading.current_thread() is threading.main_thread() and "user" not in options
    return dying_with_parent(words) if ours else list(words)
