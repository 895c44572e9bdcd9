"""The checks of `lbr doctor` for a robot that is served over HTTP: whether its port is free, and who may reach it."""

import errno
import socket
from collections.abc import Iterable, Iterator
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr import home
from lbr.apps.http import listening, names
from lbr.commands.finding import Finding
from lbr.database.rows import CapabilityRow
from lbr.messages.unreadable import UNREADABLE

KIND = "web"


class Place(Struct, frozen=True):
    """Where kind `web` listens, by its row's settings and by default; the rest of them is not looked at."""

    host: str = "127.0.0.1"
    port: Annotated[int, Meta(ge=0, le=65535)] = 50000


def ports(robot: str, rows: Iterable[CapabilityRow]) -> Iterator[Finding]:
    """Look at the port of every capability of a robot that serves."""
    runs = any(one.robot == robot for one in home.running())
    for row in rows:
        if row.kind == KIND and row.enabled:
            try:
                place = msgspec.json.decode(row.settings, type=Place)
            except UNREADABLE as err:
                text = f"the row's settings say no host and port to listen at: {err}"
                yield Finding(about=f"port of '{row.name}'", level="bad", text=text, do="lbr db check")
            else:
                yield _port(robot, row.name, place.host, place.port, runs=runs)


def _port(robot: str, name: str, host: str, port: int, *, runs: bool) -> Finding:
    about, where = f"port of '{name}'", f"port {port} at {host}"
    problem, beside = _taken(host, port), listening.BESIDE.get(host, "")
    if problem is None and beside and listening.is_here(beside):
        problem = _taken(beside, port)
        where = f"port {port} at {beside}" if problem is not None else where
    taken = problem is not None and problem.errno == errno.EADDRINUSE
    if taken and runs:
        return Finding(
            about=about, level="good", text=f"{where}: robot '{robot}' runs here; 'lbr status' shows if it has it"
        )
    if taken:
        text = f"{where} is taken by another program; robot '{robot}' runs, but without its API"
        return Finding(about=about, level="hint", text=text, do=f"ss -ltnp 'sport = :{port}'")
    if problem is not None:
        text = f"{where} cannot be opened: {problem.strerror or problem}"
        return Finding(about=about, level="hint", text=text, do="change host or port in the row's settings")
    reach = "this machine alone reaches it" if names.is_local(host) else "the network reaches it"
    return Finding(about=about, level="good", text=f"{where} is free; {reach}")


def _taken(host: str, port: int) -> OSError | None:
    """Return what the system says against listening there, if it says anything."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((host, port))
            tried.listen(1)
        except OSError as err:
            return err
        except (ValueError, TypeError) as err:  # no name of a machine has such letters, or so many
            return OSError(errno.EINVAL, str(err))
    return None
