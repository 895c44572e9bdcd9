"""`lbr registry`: a service that lists which robots are up, and how to reach them."""

import os
from pathlib import Path

import click
import msgspec

from lbr import home
from lbr.apps.registry import asking
from lbr.apps.registry.book import Listed
from lbr.apps.registry.guests import Guests
from lbr.bus import tokens
from lbr.bus.tokens import Token
from lbr.commands.options import FileName, json_option, print_json
from lbr.errors import InputError
from lbr.messages.plain import one_line
from lbr.messages.unreadable import UNREADABLE

PORT = 9147
VARIABLE = "LBR_REGISTRY_TOKEN"


@click.group("registry")
def command() -> None:
    """Run a service that lists which robots are up, or ask one.

    The service runs anywhere, without a robot. Each robot gets a token from it, puts that into
    credentials/registry.token, and switches on its row `registrar`. Every holder of a token may read the list.
    """


@command.command("serve")
@click.option("--host", default="127.0.0.1", show_default=True, help="Where to listen; 0.0.0.0 for every network.")
@click.option("--port", type=click.IntRange(0, 65535), default=PORT, show_default=True, help="0: any free one.")
def serve(host: str, port: int) -> int:
    """Run the service until Ctrl-C, by TLS alone, with the certificate of this home."""
    try:
        from lbr.apps.registry import server  # noqa: PLC0415 - it needs an extra
    except ImportError as err:
        raise InputError(f"the registry needs the extra 'web' ({err.name} is missing): pip install 'lbr[web]'") from err
    server.serve(host, port, click.echo)
    return 0


@command.command("add")
@click.argument("name")
def add(name: str) -> int:
    """Make a token of this name and print it, once: for a robot that is to be listed, or for a reader of the list."""
    click.echo(str(Guests().add(name)))
    click.echo(
        "note: on the robot put it into credentials/registry.token of its home, for its eyes alone (chmod 600)",
        err=True,
    )
    return 0


@command.command("revoke")
@click.argument("name")
def revoke(name: str) -> int:
    """Revoke a token; its robot is not listed any more."""
    Guests().revoke(name)
    click.echo(f"the token '{name}' counts for nothing now")
    return 0


@command.command("tokens")
@json_option
def list_tokens(as_json: bool) -> int:
    """List the names of the tokens; the tokens themselves are not stored."""
    tokens_since = Guests().names()
    if as_json:
        print_json([{"name": name, "since": since} for name, since in tokens_since.items()])
        return 0
    for name, since in tokens_since.items():
        click.echo(f"{name}  since {since}")
    return 0


@command.command("list")
@click.argument("url")
@click.option(
    "--token-file", type=FileName(), metavar="FILE", help=f"Holds the token; else it is {VARIABLE}, or this home's own."
)
@json_option
def list_robots(url: str, token_file: Path | None, as_json: bool) -> int:
    """List the robots that the service at URL knows, such as https://HOST:9147, those that are up first."""
    answer = asking.ask(url, _token(token_file), "GET")
    try:
        robots = msgspec.json.decode(answer, type=tuple[Listed, ...])
    except UNREADABLE as err:
        raise InputError(f"{url} does not answer as a registry does ({err})", "malformed") from err
    if as_json:
        print_json(robots)
        return 0
    if not robots:
        click.echo("no robot has registered there")
    for robot in robots:
        ways = ", ".join((*robot.urls, *robot.endpoints)) or "no way in from other machines"
        state = "up" if robot.up else f"gone for {robot.seen_s:.0f} s"
        click.echo(one_line(f"{robot.name}  {robot.robot}  {state}  {ways}  (from {robot.address})"))
    return 0


def _token(path: Path | None) -> Token:
    if path is None and (text := os.environ.get(VARIABLE)):
        return tokens.parse(text)
    own = home.directory("credentials") / "registry.token"
    try:
        return tokens.parse((path or own).read_text(encoding="ascii", errors="replace"))
    except OSError as err:
        raise InputError(
            f"{path or own} cannot be read ({err.strerror}): name a file by --token-file, or set {VARIABLE}"
        ) from err
