"""Sockets that listen, and the robot's certificate."""

import errno
import socket

from lbr import home
from lbr.apps.http import names
from lbr.bus import certificates
from lbr.errors import InputError

BUFFER_BYTES = 64 * 1024
BACKLOG = 256
BESIDE = {"0.0.0.0": "::1", "127.0.0.1": "::1", "::1": "127.0.0.1"}  # noqa: S104 - compared
"""This machine's other address, for those that lead to it by one family alone."""
TRIES = 20
"""For a port that the kernel chooses: it is free by IPv4, and mostly by IPv6."""


def listen(host: str, port: int) -> list[socket.socket]:
    """Return listening sockets whose connections hold little; InputError names the fault of the address.

    One is at the address. Where that leads to this machine by IPv4 or IPv6 alone, another is at the loopback of the
    other: browsers take `localhost` for both, and what another user of this machine served there would be of our own
    origin.
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
    """Return whether this machine has an address; a loopback's it lacks without that family of addresses."""
    try:
        with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.bind((address, 0))
    except OSError as err:
        return err.errno not in {errno.EAFNOSUPPORT, errno.EADDRNOTAVAIL}
    return True


def _listen(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as err:  # the latter for what no name of a machine may have in it
        why = getattr(err, "strerror", "") or "no machine is called so"
        raise InputError(f"'{host[:80]}' is not an address of this machine: {why}") from err
    listening = socket.socket(family, kind, protocol)  # asyncio sends at once only what it knows to be TCP
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
    """Return whether only this machine reaches a socket."""
    return names.is_loopback(listening.getsockname()[0])


def certificate() -> tuple[str, str]:
    """Return the files of the private key and certificate that browsers are shown; the robot's are made on first
    use."""
    key, public = home.given_credentials(*certificates.OWN_FILES) or home.credentials(
        certificates.self_signed, *certificates.FILES
    )
    return str(key), str(public)
