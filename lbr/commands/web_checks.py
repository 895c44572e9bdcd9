"""What `lbr doctor` looks at for a robot that is served over HTTP: whether its port is free, and who may reach it."""

import errno
import ipaddress
import json
import os
import socket
from collections.abc import Iterable, Iterator

from lbr import home
from lbr.apps.http import listening
from lbr.commands.finding import Finding
from lbr.database.rows import CapabilityRow

KIND = "web"
USUAL = ("127.0.0.1", 50000)
"""Where kind `web` listens if its row says nothing."""


def ports(robot: str, rows: Iterable[CapabilityRow]) -> Iterator[Finding]:
    """Look at the port of every capability of a robot that serves."""
    runs = any(one.robot == robot for one in home.running())
    for row in rows:
        if row.kind == KIND and row.enabled:
            settings = json.loads(row.settings)
            host, port = str(settings.get("host", USUAL[0])), int(settings.get("port", USUAL[1]))
            yield _port(robot, row.name, host, port, runs=runs)


def _port(robot: str, name: str, host: str, port: int, *, runs: bool) -> Finding:
    about, where = f"port of '{name}'", f"port {port} at {host}"
    problem, beside = _taken(host, port), listening.BESIDE.get(host, "")
    if not problem and beside and listening.is_here(beside):
        problem = _taken(beside, port)
        where = f"port {port} at {beside}" if problem else where
    if problem == errno.EADDRINUSE and runs:
        return Finding(
            about=about, level="good", text=f"{where}: robot '{robot}' runs here; 'lbr status' shows if it has it"
        )
    if problem == errno.EADDRINUSE:
        text = f"{where} is taken by another program; robot '{robot}' runs, but without its API"
        return Finding(about=about, level="hint", text=text, do=f"ss -ltnp 'sport = :{port}'")
    if problem:
        text = f"{where} cannot be opened: {os.strerror(problem)}"
        return Finding(about=about, level="hint", text=text, do="change host or port in the row's settings")
    reach = "this machine alone reaches it" if _is_loopback(host) else "the network reaches it"
    return Finding(about=about, level="good", text=f"{where} is free; {reach}")


def _taken(host: str, port: int) -> int:
    """Return what the system says against listening there; 0 for nothing."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((host, port))
            tried.listen(1)
        except OSError as err:
            return err.errno or errno.EINVAL
    return 0


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
