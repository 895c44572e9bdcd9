"""By which names a machine may be asked."""

import ipaddress
import socket
from collections.abc import Set as AbstractSet


def is_ours(host: str, names: AbstractSet[str] = frozenset()) -> bool:
    """Say whether a Host header means this machine: an address, its own name, or one of `names`.

    A page of somebody else's whose name was made to lead here shows that name.
    """
    name = host.rpartition(":")[0] if ":" in host.rpartition("]")[2] else host
    name = name.strip("[]").lower().rstrip(".")
    own = socket.gethostname().lower()
    if name in {"localhost", own, own.partition(".")[0], f"{own.partition('.')[0]}.local", *names}:
        return True
    try:
        ipaddress.ip_address(name.partition("%")[0])
    except ValueError:
        return False
    return True
