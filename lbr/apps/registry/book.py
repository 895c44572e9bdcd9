"""The service's records of robots: their names, addresses and last reports. Pure."""

from collections.abc import Collection
from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import replace

from lbr.messages.units import Name

MOST_ROBOTS = 1000
KEPT_S = 24 * 3600.0
SILENT = 3.0
"""The number of its own periods after which a silent robot counts as gone."""
Address = Annotated[str, Meta(pattern=r"^https?://[!-~]{1,200}$(?!\n)")]
Endpoint = Annotated[str, Meta(pattern=r"^(tls|tcp)/[A-Za-z0-9.:\[\]_-]{1,200}$(?!\n)")]


class Entry(Struct, frozen=True, kw_only=True):
    """The report of a robot. `up_s` is its uptime, and `every_s` the period of its reports."""

    robot: Name
    version: Annotated[str, Meta(pattern=r"^[!-~]{0,40}$(?!\n)")] = ""
    urls: Annotated[tuple[Address, ...], Meta(max_length=8)] = ()
    endpoints: Annotated[tuple[Endpoint, ...], Meta(max_length=8)] = ()
    up_s: Annotated[float, Meta(ge=0.0, le=1e10)] = 0.0
    every_s: Annotated[float, Meta(ge=5.0, le=300.0)] = 10.0


class Listed(Struct, frozen=True, kw_only=True):
    """A robot in the list: its token's name, whether it is up, its entry, its address, and the age of the entry."""

    name: str
    up: bool
    robot: str
    version: str
    urls: tuple[str, ...]
    endpoints: tuple[str, ...]
    address: str
    up_s: float
    seen_s: float


class _Known(Struct, frozen=True):
    entry: Entry
    address: str
    at: float
    shutting_down: bool = False


class Book:
    """Robots by the names of their tokens; a robot that is silent for a day is forgotten."""

    def __init__(self) -> None:
        self._known: dict[str, _Known] = {}

    def register(self, name: str, address: str, entry: Entry, now: float) -> bool:
        """Register a robot; False if the book is full."""
        self._forget(now)
        if name not in self._known and len(self._known) >= MOST_ROBOTS:
            return False
        self._known[name] = _Known(entry, address, now)
        return True

    def leave(self, name: str) -> None:
        """Note that a robot shuts down."""
        if name in self._known:
            self._known[name] = replace(self._known[name], shutting_down=True)

    def keep(self, names: Collection[str]) -> None:
        """Forget robots whose tokens were revoked."""
        self._known = {name: one for name, one in self._known.items() if name in names}

    def listed(self, now: float) -> tuple[Listed, ...]:
        """Return all robots, the running ones first."""
        self._forget(now)
        listed = [
            Listed(
                name=name,
                up=not known.shutting_down and now - known.at <= SILENT * known.entry.every_s,
                robot=known.entry.robot,
                version=known.entry.version,
                urls=known.entry.urls,
                endpoints=known.entry.endpoints,
                address=known.address,
                up_s=round(known.entry.up_s, 1),
                seen_s=round(now - known.at, 1),
            )
            for name, known in self._known.items()
        ]
        return tuple(sorted(listed, key=lambda robot: (not robot.up, robot.name)))

    def _forget(self, now: float) -> None:
        for name in [name for name, one in self._known.items() if now - one.at > KEPT_S]:
            del self._known[name]
