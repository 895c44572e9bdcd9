"""Options that several commands share."""

import errno
import os
from collections.abc import Callable, Iterable
from functools import wraps
from math import isnan
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import click
import msgspec
from click.shell_completion import CompletionItem

from lbr import home
from lbr.errors import InputError
from lbr.executive.planning import profile
from lbr.messages.rows import short
from lbr.names import did_you_mean
from lbr.robot import registry

F = TypeVar("F", bound=Callable[..., Any])


class Number(click.FloatRange):
    """A number within bounds; NaN is refused, although it exceeds no bound."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        found = super().convert(value, param, ctx)
        if found is not None and isnan(found):
            self.fail(f"{value!r} is not a number from {self.min:g} to {self.max:g}.", param, ctx)
        return found


class FileName(click.Path):
    """The name of a file or folder, existing or not, that the system permits; given as a `Path`."""

    def __init__(self, **conditions: Any) -> None:
        super().__init__(path_type=Path, **conditions)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path."""
        if not os.fspath(value):
            self.fail("the name of a file is missing.", param, ctx)
        try:
            os.lstat(value)
        except OSError as err:
            if err.errno in {errno.ENAMETOOLONG, errno.ELOOP}:
                self.fail(f"'{os.fsdecode(value)[:40]}…' is not a file: {err.strerror}.", param, ctx)
        return super().convert(value, param, ctx)


DEFAULT_PROFILE = "lbr-sim"
"""The default profile of `lbr run`."""


class Whom(NamedTuple):
    """The robot that a command means, and the credentials for it."""

    robot: str | None
    connect: str | None
    token_file: Path | None


def together(name: str, kind: type[Any], *options: Callable[[Any], Any]) -> Callable[[F], F]:
    """Return a decorator that adds these options; the command gets them as one `kind`, a named tuple, of this name."""

    def added(function: F) -> F:
        @wraps(function)
        def with_one(*arguments: object, **given: Any) -> object:
            one = kind(**{field: given.pop(field) for field in kind._fields})
            return function(*arguments, **given, **{name: one})

        for option in reversed(options):
            with_one = option(with_one)
        return with_one  # type: ignore[return-value]  # click calls it by names only

    return added


def complete_running(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return the robots that run here, for completion."""
    return [CompletionItem(one.robot, help=one.profile) for one in home.running() if one.robot.startswith(begun)]


robot_options = together(
    "whom",
    Whom,
    click.option(
        "--robot",
        metavar="NAME",
        shell_complete=complete_running,
        help="Which robot; the only one that runs here if left out.",
    ),
    click.option("--connect", metavar="ENDPOINT", help="Reach a robot elsewhere, such as tls/192.168.1.7:7447."),
    click.option(
        "--token-file",
        type=FileName(),
        metavar="FILE",
        help="Holds the token for --connect. Else it is LBR_TOKEN, a saved one, or asked for.",
    ),
)


def database_option(function: F) -> F:
    """Add --db; the command gets it as `database`."""
    return click.option("--db", "database", type=FileName(), metavar="FILE", help="$LBR_HOME/robot.db if left out.")(
        function
    )


def json_option(function: F) -> F:
    """Add --json."""
    return click.option("--json", "as_json", is_flag=True, help="Print JSON, for programs.")(function)


def print_json(value: object) -> None:
    """Print a value as one line of JSON."""
    click.echo(msgspec.json.encode(value).decode())


def refuse_unknown(part: str, names: Iterable[object], robot: str) -> None:
    """Raise InputError if a robot has no part of this name."""
    there = set(map(str, names))
    if part not in there:
        hint = did_you_mean(part, there)
        raise InputError(f"'{short(robot)}' has no part '{short(part)}'; {hint}", "unknown_name")


def complete_robot(_context: click.Context, _parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return all robots, for completion."""
    return [
        CompletionItem(found.name, help=found.robot.summary)
        for found in registry.every()
        if found.robot is not None and found.name.startswith(begun)
    ]


def complete_profile(context: click.Context, parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """Return all launch profiles, and files, for completion."""
    found = [CompletionItem(name) for name in profile.names() if name.startswith(begun)]
    return found or click.Path().shell_complete(context, parameter, begun)  # a shell offers files or words, not both
