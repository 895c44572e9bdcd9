"""Identifies the program at the other end of a connection within this machine, from the kernel's tables. Linux only.

A tunnel or a proxy is itself that program. `is_relayed` recognises those that mark the requests they pass on.
"""

import os
import socket
import struct
from collections.abc import Iterable, Mapping
from pathlib import Path

from lbr.apps.http import listening, names

TABLES = (Path("/proc/self/net/tcp"), Path("/proc/self/net/tcp6"))
ESTABLISHED, NOBODY = "01", 65534
_PASSED_ON = frozenset(
    [
        "forward",
        "forwarded",
        "forwards",
        "proxy",
        "proxied",
        "via",
        "ip",
        "clientip",
        "remote",
        "original",
        "originating",
        "rewrite",
        "gateway",
    ]
)
_PASSED_ON_BY = frozenset(
    [
        "appengine",
        "amzn",
        "arr",
        "azure",
        "cdn",
        "cf",
        "client",
        "cloudfront",
        "cluster",
        "envoy",
        "fastly",
        "fly",
        "fwd",
        "ngrok",
        "sucuri",
        "tailscale",
        "traefik",
        "vercel",
    ]
)
_PASSED_ON_WHOLE = frozenset({"x-host", "x-proto", "x-scheme", "x-http-host-override"})
"""The headers of proxies and tunnels, by the words of their names. Browsers and other clients do not send them. A proxy
without any of them leaves no trace.
"""


def is_relayed(headers: Mapping[str, str], port: int) -> bool:
    """Return whether a request came by a proxy or tunnel: it has such a header, or names another port.

    A relay that leaves no trace counts as the client.
    """
    if any(_names_a_relay(name) for name in headers):
        return True
    asked = names.parsed(headers.get("host", ""))
    return asked is not None and asked[1] not in {None, port}


def _names_a_relay(header: str) -> bool:
    name = header.lower().replace("_", "-")
    words = name.removeprefix("x-").split("-")
    return name in _PASSED_ON_WHOLE or words[0] in _PASSED_ON_BY or not _PASSED_ON.isdisjoint(words)


def whose(client: tuple[str, int], server: tuple[str, int], tables: Iterable[Path] = TABLES) -> str | None:
    """Return the user of the program at the other end, empty on another machine; None if the kernel does not know.

    Reads files.
    """
    ip = names.plain(client[0])
    if ip is None or not listening.is_here(str(ip) if "%" not in client[0] else client[0]):
        return None if ip is None else ""
    uid = uid_of(client, server, tables)
    return None if uid in {None, NOBODY} else f"user {uid}"


def is_own(user: str | None) -> bool:
    """Return whether a user, as `whose` returns it, is this process's own."""
    return user == f"user {os.geteuid()}"


def is_held(connection: socket.socket) -> bool:
    """Return whether a connection stands. While it does, no other has its ports, so a lookup by ports is of it."""
    try:
        connection.getpeername()
    except OSError:
        return False
    return True


def uid_of(client: tuple[str, int], server: tuple[str, int], tables: Iterable[Path] = TABLES) -> int | None:
    """Return the user of the socket at the other end; None if the kernel does not know it, or it is closed."""
    wanted = {
        (_kernel_form(client, family), _kernel_form(server, family)) for family in (socket.AF_INET, socket.AF_INET6)
    }
    for table in tables:
        try:
            lines = table.read_text(encoding="ascii").splitlines()[1:]
        except OSError:
            continue
        for line in lines:
            field = line.split()
            if len(field) > 9 and (field[1], field[2]) in wanted and field[3] == ESTABLISHED and field[9] != "0":
                return int(field[7])
    return None


def _kernel_form(end: tuple[str, int], family: int) -> str:
    """Return an address and port in the form of the kernel's tables; empty if the family has no such address."""
    ip = names.plain(end[0])
    if ip is None or (family == socket.AF_INET and ip.version != 4):
        return ""
    packed = ip.packed
    if family == socket.AF_INET6 and ip.version == 4:
        packed = b"\0" * 10 + b"\xff\xff" + packed
    words = struct.unpack(f"={len(packed) // 4}I", packed)
    return f"{''.join(f'{word:08X}' for word in words)}:{end[1]:04X}"
