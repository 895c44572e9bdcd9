"""By which names a machine may be asked, and which of them only it can mean. Pure, but for the machine's own name."""

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
    """Return the address for browsers: the machine's name stands for all of its addresses."""
    name = socket.gethostname() if host in EVERYWHERE else host
    return f"{'https' if tls else 'http'}://{f'[{name}]' if ':' in name else name}:{port}"


def parsed(host: str) -> tuple[str, int | None] | None:
    """Return name and port of a Host header, in small letters and without brackets; None for what is no host."""
    match = _HOST.fullmatch(host)
    if match is None:
        return None
    port = int(match["port"]) if match["port"] else None
    return (match["bracketed"] or match["name"]).lower(), port


def is_ours(host: str, names: AbstractSet[str] = frozenset(), *, loopback: bool = False) -> bool:
    """Return whether a Host header means this machine: an address, its own name, or one of `names`.

    `loopback`: the request comes from this machine. Then only names of the loopback count, besides `names`: what
    browsers say of a page that asks is certain for those alone. A foreign page whose name was made to lead here shows
    that name.
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
    """Return whether a Host header names the loopback and nothing else."""
    found = parsed(host)
    return found is not None and (found[0] == "localhost" or is_loopback(found[0]))


def is_loopback(address: str) -> bool:
    """Return whether an address is of this machine's loopback; an IPv4 address may be written as IPv6."""
    ip = plain(address)
    return ip is not None and ip.is_loopback


def is_local(host: str) -> bool:
    """Return whether only this machine reaches who listens at an address."""
    return host == "localhost" or is_loopback(host)


def peer_name(address: str) -> str:
    """Return the name by which a peer's requests are counted: its address, or "this machine" for the loopback's."""
    ip = plain(address)
    return address if ip is None else "this machine" if ip.is_loopback else str(ip)


def plain(address: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an address without zone, and as IPv4 where it is that; None for what is not an address."""
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return None
    mapped = ip.ipv4_mapped if isinstance(ip, ipaddress.IPv6Address) else None
    return mapped or ip


@cache
def announced() -> str:
    """Return this machine's name in multicast DNS, which is made from the address of its network card."""
    mark = hashlib.blake2b(uuid.getnode().to_bytes(8, "big"), digest_size=2).hexdigest()
    return f"lbr-{mark}.local"


def _own() -> frozenset[str]:
    own = socket.gethostname().lower()
    short = own.partition(".")[0]
    return frozenset({own, short, f"{short}.local", announced()})


def _is_unspecified(address: ipaddress.IPv4Address | ipaddress.IPv6Address) -> bool:
    """Return whether an address stands for no machine: browsers on some systems reach their own by it."""
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped is not None or address.is_unspecified or address in _THIS_NETWORK


_THIS_NETWORK = ipaddress.ip_network("0.0.0.0/8")
