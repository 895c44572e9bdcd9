"""The names by which clients may address a machine, and which of them are sure to mean it.

Pure, but for the host name.
"""

import hashlib
import ipaddress
import re
import socket
import uuid
from collections.abc import Set as AbstractSet
from functools import cache

_HOST = re.compile(
    r"(?:\[(?P<bracketed>[0-9A-Fa-f:.]+(?:%[A-Za-z0-9_.~%-]+)?)\]|(?P<name>[A-Za-z0-9._-]+))(?::(?P<port>[0-9]{1,5}))?"
)
EVERYWHERE = ("0.0.0.0", "::")  # noqa: S104 - compared, not bound


def origin(host: str, port: int, *, tls: bool = True) -> str:
    """Return the URL for browsers; if the server listens everywhere, it has the machine's name."""
    name = socket.gethostname() if host in EVERYWHERE else host
    return f"{'https' if tls else 'http'}://{f'[{name}]' if ':' in name else name}:{port}"


def parsed(host: str) -> tuple[str, int | None] | None:
    """Return name and port of a Host header, in lower case and without brackets; None for an invalid one."""
    match = _HOST.fullmatch(host)
    if match is None:
        return None
    port = int(match["port"]) if match["port"] else None
    return (match["bracketed"] or match["name"]).lower(), port


def is_ours(host: str, names: AbstractSet[str] = frozenset(), *, loopback: bool = False) -> bool:
    """Return whether a Host header means this machine: an address, its own name, or one of `names`.

    `loopback`: the request comes from this machine. Then only names of the loopback count, besides `names`. A foreign
    page whose name was made to resolve to this machine shows that name, and only loopback names exclude this.
    """
    found = parsed(host)
    if found is None:
        return False
    name, _ = found
    if name in names or name == "localhost":
        return True
    bracketed = host.startswith("[")
    try:
        address = ipaddress.ip_address(name)
    except ValueError:
        return not loopback and not bracketed and name in _own()
    if bracketed is not isinstance(address, ipaddress.IPv6Address):
        return False
    if loopback:
        return is_loopback(name) and getattr(address, "ipv4_mapped", None) is None and "%" not in name
    return not (_is_unspecified(address) or ("%" in name and not address.is_link_local))


def means_loopback(host: str) -> bool:
    """Return whether a Host header can only mean the loopback."""
    found = parsed(host)
    return found is not None and (found[0] == "localhost" or is_loopback(found[0]))


def is_loopback(address: str) -> bool:
    """Return whether an address is a loopback address; an IPv4 address may be written as IPv6."""
    ip = plain(address)
    return ip is not None and ip.is_loopback


def is_local(host: str) -> bool:
    """Return whether a server at this address is reachable from this machine only."""
    return host == "localhost" or is_loopback(host)


def peer_name(address: str) -> str:
    """Return the name by which a peer's requests are counted: its address, or "this machine" for the loopback."""
    ip = plain(address)
    return address if ip is None else "this machine" if ip.is_loopback else str(ip)


def plain(address: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an address without zone, a mapped one as IPv4; None if it is not an address."""
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return None
    mapped = ip.ipv4_mapped if isinstance(ip, ipaddress.IPv6Address) else None
    return mapped or ip


@cache
def announced() -> str:
    """Return this machine's name in multicast DNS, made of its network card's address."""
    mark = hashlib.blake2b(uuid.getnode().to_bytes(8, "big"), digest_size=2).hexdigest()
    return f"lbr-{mark}.local"


def _own() -> frozenset[str]:
    own = socket.gethostname().lower()
    short = own.partition(".")[0]
    return frozenset({own, short, f"{short}.local", announced()})


def _is_unspecified(address: ipaddress.IPv4Address | ipaddress.IPv6Address) -> bool:
    """Return whether an address means no certain machine; on some systems browsers reach their own by it."""
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped is not None or address.is_unspecified or address in _THIS_NETWORK


_THIS_NETWORK = ipaddress.ip_network("0.0.0.0/8")
