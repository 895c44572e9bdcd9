"""`lbr token`: access from other machines."""

import datetime as dt
import json
import re
import socket
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

import click
import msgspec
import psutil

from lbr import disk, home
from lbr.bus import tokens
from lbr.bus.session import client_settings
from lbr.bus.tokens import Token
from lbr.commands.completing import complete_token
from lbr.commands.options import FileName, json_option, print_json
from lbr.commands.rows import opened
from lbr.database.rows import GoodFor, TokenRow
from lbr.errors import InputError
from lbr.executive.planning import credentials
from lbr.messages.system import TokenRole

if TYPE_CHECKING:
    from lbr.database.store import Database

EVERYWHERE = ("0.0.0.0", "[::]")  # noqa: S104 - read, not bound
UNITS_S = {"m": 60, "h": 3600, "d": 86400, "w": 604800}
database_option = click.option(
    "--db", "database", type=FileName(), metavar="FILE", help="The rows; those of the robot."
)


@click.group("token")
def command() -> None:
    """Give people and programs on other machines access, and take it away again.

    A token is a name with a role: view looks and stops, operate also moves the robot, admin may do everything. With
    host, the machine of that name runs its share of the robot, looks and stops. A token is valid for the bus, which
    consoles and programs use, for the web server, or for both.
    """


@command.command("add")
@click.argument("name")
@click.option(
    "--role",
    type=click.Choice(["view", "operate", "admin", "host"]),
    default="operate",
    show_default=True,
    help="What they may do: look and stop, move, or everything; host is for a share of the robot elsewhere.",
)
@click.option(
    "--for",
    "good_for",
    type=click.Choice(["bus", "web", "both"]),
    default="bus",
    show_default=True,
    help="Where it lets in: bus for consoles and programs, web for browsers and apps.",
)
@click.option("--expires", metavar="TIME", help="When its rights end: after 12h, 30d or 8w. Never if left out.")
@click.option("--file", "path", type=FileName(), metavar="FILE", help="Also write a Zenoh configuration with it.")
@database_option
def add(name: str, role: str, good_for: str, expires: str | None, path: Path | None, database: Path | None) -> int:
    """Make a token and print it, once: it is not stored.

    With --file, any Zenoh client gets access by that file alone: zenoh.open(zenoh.Config.from_file("phone.json5")).
    """
    tokens.check_name(name)
    if good_for == "web" and (role == "host" or path is not None):
        what = "a host" if role == "host" else "--file"
        raise InputError(f"{what} comes in by the bus, and this token would be good for the web alone: --for both")
    ends = end_in(expires) if expires is not None else None
    with _opened(database) as rows, new_file(path) as file:
        door = msgspec.convert(good_for, GoodFor)
        token = credentials.new_token(rows, name, msgspec.convert(role, TokenRole), good_for=door, ends=ends).token
        listen = _listens(rows)
        endpoints = endpoints_of(listen)
        click.echo(str(token))
        if file is not None:
            write_configuration(file, token, endpoints)
            click.echo(f"{path} lets a Zenoh client in; it is as secret as the token", err=True)
    if good_for == "web":
        return 0
    _tell_how(endpoints, f"agent {name}" if role == "host" else "console", on=bool(listen))
    return 0


@command.command("list")
@database_option
@json_option
def list_tokens(database: Path | None, as_json: bool) -> int:
    """List all tokens: name, role, use, begin and end. The tokens themselves are not stored. A token that a device got
    for a code at the console is listed with the device's address."""
    with _opened(database) as rows:
        listed_tokens = rows.tokens()
    if as_json:
        fields = ("name", "role", "good_for", "created_at", "expires_at", "revoked_at", "paired_from", "called")
        print_json(
            [{field: getattr(token, field) for field in fields} | {"state": state_of(token)} for token in listed_tokens]
        )
        return 0
    width = max((len(token.name) for token in listed_tokens), default=0)
    for token in listed_tokens:
        click.echo(
            f"{token.name:<{width}}  {token.role:<8}{token.good_for:<5}{state_of(token):<9}"
            f"since {token.created_at}{until_of(token)}"
            + (f", paired from {token.paired_from}" if token.paired_from else "")
            + (f", called {token.called}" if token.called else "")
        )
    return 0


@command.command("revoke")
@click.argument("name", shell_complete=complete_token)
@database_option
def revoke(name: str, database: Path | None) -> None:
    """Revoke a token: its users are disconnected within a second, and stay out."""
    with _opened(database) as rows:
        rows.revoke_token(name)


def _opened(path: Path | None) -> "Database":
    here = home.running()
    return opened(path or (Path(here[0].database) if len(here) == 1 else None))


def end_in(text: str) -> dt.datetime:
    """Return the time that long from now, such as `30d`."""
    match = re.fullmatch(r"([1-9][0-9]{0,5})([mhdw])", text)
    if match is None:
        raise InputError(f"'{text[:40]}' is not a time from now: write 90m, 12h, 30d or 8w")
    try:
        return dt.datetime.now(dt.UTC) + dt.timedelta(seconds=int(match[1]) * UNITS_S[match[2]])
    except OverflowError:
        raise InputError(f"'{text}' from now is beyond the last date there is: leave --expires out") from None


def state_of(token: TokenRow) -> str:
    """Return whether a token is valid, expired or revoked."""
    if token.revoked_at is not None:
        return "revoked"
    return "expired" if token.has_expired(dt.datetime.now(dt.UTC)) else "valid"


def until_of(token: TokenRow) -> str:
    """Return the end of a token for a list, empty if it has none."""
    if token.revoked_at is not None:
        return f", until {token.revoked_at}"
    return f", until {token.expires_at}" if token.expires_at else ""


def _listens(rows: "Database") -> tuple[str, ...]:
    """Return the addresses at which a robot of these rows listens: in its run here, otherwise by its rows."""
    for run in home.running():
        if Path(run.database) == rows.path and run.lan:
            return run.lan
    endpoints: list[str] = []
    for name in rows.robots():
        for row in rows.load(name).capabilities:
            if row.kind == "lan" and row.enabled:
                endpoints += json.loads(row.settings).get("listen", [])
    return tuple(dict.fromkeys(endpoints))


def endpoints_of(listen: tuple[str, ...]) -> list[str]:
    """Return the endpoints by which others reach this machine: its addresses, with its open ports."""
    endpoints = []
    for endpoint in listen or ("tls/0.0.0.0:7447",):
        protocol, _, place = endpoint.partition("/")
        host, _, port = place.rpartition(":")
        hosts = _addresses() if host in EVERYWHERE else [host]
        endpoints += [f"{protocol}/{one}:{port}" for one in hosts]
    return endpoints


def _addresses() -> list[str]:
    cards = psutil.net_if_addrs().values()
    every = [one.address for card in cards for one in card if one.family == socket.AF_INET]
    return [address for address in every if not address.startswith("127.")] or ["127.0.0.1"]


@contextmanager
def new_file(path: Path | None) -> Iterator[IO[str] | None]:
    """Open a new file before making its content; it is removed if that fails."""
    if path is None:
        yield None
        return
    with ExitStack() as opened:
        try:
            file = opened.enter_context(disk.created(path, "w"))
        except FileExistsError:
            raise InputError(f"{path} exists already; name another file, or remove it") from None
        except OSError as err:
            raise InputError(f"{path} cannot be written ({err.strerror}): name another file") from err
        yield file


def write_configuration(file: IO[str], token: Token, endpoints: list[str]) -> None:
    """Write the settings of a client that connects with this token."""
    _, certificate = credentials.bus_certificate()
    pem = certificate.read_text(encoding="ascii")
    # each address is tried once: otherwise all the time would be spent on the first, which may be unreachable from
    # there
    settings = client_settings(endpoints, token.credentials, certificate=pem, timeout_s=0.0)
    json.dump(settings, file, indent=2)


def _tell_how(endpoints: list[str], what: str, *, on: bool) -> None:
    for endpoint in endpoints:
        click.echo(f"  lbr {what} --connect {endpoint}", err=True)
    if not on:
        click.echo(
            "no robot listens for that yet: 'lbr run --listen tls/0.0.0.0:7447', or in the rows\n"
            "  UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'lan';    (or another of your robots)",
            err=True,
        )
