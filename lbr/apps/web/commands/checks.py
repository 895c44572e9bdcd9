"""The checks of `lbr doctor` for a robot with a web server: whether its port is free, and which machines reach it."""

import errno
from collections.abc import Iterable, Iterator
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from lbr import home
from lbr.apps.http import listening, names
from lbr.commands.finding import Finding
from lbr.database.rows import CapabilityRow
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE

KIND = "web"


class Place(Struct, frozen=True):
    """The listening address of a row of kind `web`; other settings are ignored."""

    host: str = "127.0.0.1"
    port: Annotated[int, Meta(ge=0, le=65535)] = 50000


def ports(robot: str, rows: Iterable[CapabilityRow]) -> Iterator[Finding]:
    """Check the port of every web server of a robot."""
    runs = any(run.robot == robot for run in home.running())
    for row in rows:
        if row.kind == KIND and row.enabled:
            try:
                place = msgspec.json.decode(row.settings, type=Place)
            except UNREADABLE as err:
                text = f"the row's settings say no host and port to listen at: {err}"
                yield Finding(about=f"port of '{row.name}'", level="bad", text=text, do="lbr db check")
            else:
                yield _port(robot, row.name, place, runs=runs)


def _port(robot: str, name: str, place: Place, *, runs: bool) -> Finding:
    about, where = f"port of '{name}'", f"port {place.port} at {place.host}"
    try:
        for sock in listening.listen(place.host, place.port):
            sock.close()
    except InputError as err:
        if isinstance(err.__cause__, OSError) and err.__cause__.errno == errno.EADDRINUSE:
            if runs:
                text = f"{where}: robot '{robot}' runs here; 'lbr status' shows if it has it"
                return Finding(about=about, level="good", text=text)
            text = f"{err}: by another program; robot '{robot}' runs, but without its API"
            return Finding(about=about, level="hint", text=text, do=f"ss -ltnp 'sport = :{place.port}'")
        return Finding(about=about, level="hint", text=str(err), do="change host or port in the row's settings")
    reach = "this machine alone reaches it" if names.is_local(place.host) else "the network reaches it"
    return Finding(about=about, level="good", text=f"{where} is free; {reach}")
