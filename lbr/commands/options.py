"""Options that several commands share."""

from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def robot_options(function: F) -> F:
    """Add --robot and --connect."""
    function = click.option("--robot", metavar="NAME", help="Which robot; the only one that runs here if left out.")(
        function
    )
    return click.option("--connect", metavar="ENDPOINT", help="Reach a robot elsewhere, such as tcp/192.168.1.7:7447.")(
        function
    )


def json_option(function: F) -> F:
    """Add --json."""
    return click.option("--json", "as_json", is_flag=True, help="Print JSON, for programs.")(function)


def print_json(value: Any) -> None:
    """Print a value as one line of JSON."""
    import msgspec  # noqa: PLC0415 - kept out of `lbr --help`

    click.echo(msgspec.json.encode(value).decode())
