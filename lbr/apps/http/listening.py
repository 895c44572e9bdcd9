"""Sockets that listen, and the robot's certificate."""

import socket

from lbr import home
from lbr.apps.http import names
from lbr.bus import certificates
from lbr.errors import InputError

BUFFER_BYTES = 64 * 1024
BACKLOG = 256


def listen(host: str, port: int) -> socket.socket:
    """Return a listening socket whose connections hold little; InputError says what is wrong with the address."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    except OSError as err:
        raise InputError(f"'{host}' is no address of this machine: {err.strerror or err}") from err
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
    """Say whether only this machine reaches a socket."""
    return names.is_loopback(listening.getsockname()[0])


def certificate() -> tuple[str, str]:
    """Return the files of the robot's private key and certificate, made on first use."""
    key, public = home.credentials(certificates.self_signed, *certificates.FILES)
    return str(key), str(public)
