"""Connections with a wrong token: counted, reported and slowed down by their host. Pure.

The bus library logs whom it admitted, and that a user or password was wrong, but not on which connection. The oldest
pending connection is blamed. A host that is blamed wrongly loses some seconds at its next connection, and nothing else.
"""

import re
from collections import OrderedDict, deque

from msgspec import Struct

FREE_TRIES = 5
WINDOW_S = 60.0
FIRST_WAIT_S, LONGEST_WAIT_S = 1.0, 30.0
PENDING_S = 3.0
"""The time that the router gives a connection to authenticate."""
MOST_PENDING = 512
MOST_HOSTS = 256
TELL_S = 10.0
UNKNOWN = "a client:0"

_COLOURS = re.compile(r"\x1b\[[0-9;]*m")
_LET_IN = re.compile(r"New transport link accepted from .* dst: (?:tcp|tls)/([^,\s]+)")
_REFUSED = re.compile(r"Invalid (user|password)\b")


class Refusal(Struct, frozen=True, kw_only=True):
    """A wrong token of a host: how often within a minute, and how long its next connections wait."""

    host: str
    tries: int
    wait_s: float
    unknown_name: bool

    @property
    def text(self) -> str:
        """Return it as one sentence."""
        what = "an unknown name" if self.unknown_name else "a wrong secret"
        often = f"; tries within a minute: {self.tries}" if self.tries > 1 else ""
        wait = f"; its next connections wait {self.wait_s:g} s" if self.wait_s else ""
        return f"{self.host} showed a token with {what}{often}{wait}"


class _Host(Struct):
    tries: deque[float]
    wait_s: float = 0.0
    until_s: float = 0.0
    told_s: float = -TELL_S


class Attempts:
    """Decides which connections the router may read now, and reads the results in the library's log."""

    def __init__(self) -> None:
        self.refused = 0
        self._pending: OrderedDict[str, float] = OrderedDict()
        self._hosts: OrderedDict[str, _Host] = OrderedDict()

    def knock(self, address: str, now: float) -> bool:
        """Return whether the router may read a new connection now."""
        host = self._hosts.get(host_of(address))
        if host is not None and now < host.until_s:
            return False
        self._pending[address] = now
        self._forget(now)
        return True

    def read(self, line: str, now: float) -> Refusal | None:
        """Read a line of the log; a host that has to wait is reported at most once in ten seconds."""
        line = _COLOURS.sub("", line)
        if match := _LET_IN.search(line):
            self._pending.pop(match[1], None)
        elif match := _REFUSED.search(line):
            self._forget(now)
            address = self._pending.popitem(last=False)[0] if self._pending else UNKNOWN
            return self._note(host_of(address), now, unknown_name=match[1] == "user")
        return None

    def _note(self, name: str, now: float, *, unknown_name: bool) -> Refusal | None:
        self.refused += 1
        host = self._hosts.setdefault(name, _Host(deque(maxlen=1000)))
        self._hosts.move_to_end(name)
        while len(self._hosts) > MOST_HOSTS:
            self._hosts.popitem(last=False)
        while host.tries and now - host.tries[0] > WINDOW_S:
            host.tries.popleft()
        host.tries.append(now)
        if len(host.tries) <= FREE_TRIES:
            host.wait_s = 0.0
        else:
            host.wait_s = min(LONGEST_WAIT_S, max(FIRST_WAIT_S, 2.0 * host.wait_s))
            host.until_s = now + host.wait_s
        if host.wait_s > FIRST_WAIT_S and now - host.told_s < TELL_S:
            return None
        host.told_s = now
        return Refusal(host=name, tries=len(host.tries), wait_s=host.wait_s, unknown_name=unknown_name)

    def _forget(self, now: float) -> None:
        """Forget connections without a result in time, which the router has ended."""
        while self._pending and (
            len(self._pending) > MOST_PENDING or now - next(iter(self._pending.values())) > PENDING_S
        ):
            self._pending.popitem(last=False)


def host_of(address: str) -> str:
    """Return the host of `address:port`; an IPv4-mapped IPv6 address as IPv4."""
    return address.rpartition(":")[0].strip("[]").removeprefix("::ffff:")
