"""The addresses at which other machines or this one reach this machine."""

import ipaddress
import socket
from collections.abc import Iterable
from ipaddress import IPv4Address, IPv6Address

import ifaddr

from lbr.apps.http.names import EVERYWHERE

_OUTSIDE = ("192.0.2.1", 9)
"""An address without a machine (RFC 5737). For a packet to it the kernel names our own address; no packet is sent."""


def of_machine() -> tuple[str, ...]:
    """Return this machine's addresses in its networks, the one that leads outside first, IPv4 before IPv6."""
    found = [ip for adapter in ifaddr.get_adapters() for ip in _addresses(adapter)]
    outward = _outward()
    found.sort(key=lambda ip: (str(ip) != outward, ip.version, int(ip)))
    return tuple(dict.fromkeys(str(ip) for ip in found))


def reached_at(host: str, own_addresses: Iterable[str]) -> tuple[str, ...]:
    """Return the addresses of a server that listens at `host`, on a machine with these addresses."""
    if host not in EVERYWHERE:
        return (host,)
    return tuple(one for one in own_addresses if host == "::" or ":" not in one)


def url(address: str, port: int, *, tls: bool) -> str:
    """Return the URL of a server for a browser or a phone."""
    return f"{'https' if tls else 'http'}://{f'[{address}]' if ':' in address else address}:{port}/"


def _addresses(adapter: ifaddr.Adapter) -> Iterable[IPv4Address | IPv6Address]:
    for one in adapter.ips:
        ip = ipaddress.ip_address(one.ip if isinstance(one.ip, str) else one.ip[0])
        if not (ip.is_loopback or ip.is_link_local or ip.is_multicast or ip.is_unspecified):
            yield ip


def _outward() -> str:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_OUTSIDE)
        except OSError:
            return ""  # no network now
        return str(probe.getsockname()[0])
