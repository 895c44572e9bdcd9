"""Listening sockets, and the robot's certificate."""

import errno
import socket

from lbr import home
from lbr.apps.http import names
from lbr.bus import certificates
from lbr.errors import InputError

BUFFER_BYTES = 64 * 1024
BACKLOG = 256
BESIDE = {"0.0.0.0": "::1", "127.0.0.1": "::1", "::1": "127.0.0.1"}  # noqa: S104 - compared
"""For each address of one family, the loopback address of the other."""
TRIES = 20
"""The tries for a port of the kernel's choice, which is free by IPv4, and mostly by IPv6."""


def listen(host: str, port: int) -> list[socket.socket]:
    """Return listening sockets with small buffers; raise InputError for a bad address.

    The first is at the address. If that reaches this machine by only IPv4 or IPv6, a second is at the other loopback.
    Browsers try both for `localhost`, and another user's server at the free one would have this server's origin.
    """
    for _ in range(TRIES):
        sockets = [_listen(host, port)]
        address, chosen = sockets[0].getsockname()[:2]
        beside = BESIDE.get(address, "")
        if not beside or not is_here(beside):
            return sockets
        try:
            return [*sockets, _listen(beside, chosen)]
        except InputError:
            sockets[0].close()
            if port:
                raise
    raise InputError(f"no port is free both at {host} and at this machine's other loopback")


def is_here(address: str) -> bool:
    """Return whether this machine has an address; a loopback address is missing without its family."""
    try:
        with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.bind((address, 0))
    except OSError as err:
        return err.errno not in {errno.EAFNOSUPPORT, errno.EADDRNOTAVAIL}
    return True


def _listen(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as err:  # UnicodeError: characters that no host name has
        why = getattr(err, "strerror", "") or "no machine is called so"
        raise InputError(f"'{host[:80]}' is not an address of this machine: {why}") from err
    listening = socket.socket(family, kind, protocol)  # only with the protocol set does asyncio disable Nagle's delay
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        if family == socket.AF_INET6:
            listening.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, int(host != "::"))
        listening.bind(address)
        listening.listen(BACKLOG)
    except OSError as err:
        listening.close()
        raise InputError(f"port {port} at {host} cannot be used ({err.strerror})") from err
    return listening


def is_loopback(listening: socket.socket) -> bool:
    """Return whether a socket is reachable from this machine only."""
    return names.is_loopback(listening.getsockname()[0])


def certificate() -> tuple[str, str]:
    """Return the files of private key and certificate for browsers; the robot's own are made on first use."""
    key, public = home.given_credentials(*certificates.OWN_FILES) or home.credentials(
        certificates.self_signed, *certificates.FILES
    )
    return str(key), str(public)
