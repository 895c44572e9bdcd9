"""The service's knowledge of robots: their names, how to reach them, and their last report. Pure."""

from collections.abc import Collection
from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import replace

from lbr.messages.units import Name

MOST_ROBOTS = 1000
KEPT_S = 24 * 3600.0
SILENT = 3.0
"""A robot that was silent for so many of its own periods is gone."""
Address = Annotated[str, Meta(pattern=r"^https?://[!-~]{1,200}$(?!\n)")]
Endpoint = Annotated[str, Meta(pattern=r"^(tls|tcp)/[A-Za-z0-9.:\[\]_-]{1,200}$(?!\n)")]


class Entry(Struct, frozen=True, kw_only=True):
    """The report of a robot. `up_s` is for how long it has been up, and `every_s` the pace of its reports."""

    robot: Name
    version: Annotated[str, Meta(pattern=r"^[!-~]{0,40}$(?!\n)")] = ""
    urls: Annotated[tuple[Address, ...], Meta(max_length=8)] = ()
    endpoints: Annotated[tuple[Endpoint, ...], Meta(max_length=8)] = ()
    up_s: Annotated[float, Meta(ge=0.0, le=1e10)] = 0.0
    every_s: Annotated[float, Meta(ge=5.0, le=300.0)] = 10.0


class Listed(Struct, frozen=True, kw_only=True):
    """A robot in the list: its token's name, whether it is up, what it said of itself, from where, and how long ago."""

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
    left: bool = False


class Book:
    """Robots by the names of their tokens; one that was not heard of for a day is forgotten."""

    def __init__(self) -> None:
        self._known: dict[str, _Known] = {}

    def register(self, name: str, address: str, entry: Entry, now: float) -> bool:
        """Take what a robot says; False if there is no room for one more."""
        self._forget(now)
        if name not in self._known and len(self._known) >= MOST_ROBOTS:
            return False
        self._known[name] = _Known(entry, address, now)
        return True

    def leave(self, name: str) -> None:
        """Take a robot's word that it is shutting down."""
        if name in self._known:
            self._known[name] = replace(self._known[name], left=True)

    def keep(self, names: Collection[str]) -> None:
        """Forget all robots but those whose tokens still count."""
        self._known = {name: one for name, one in self._known.items() if name in names}

    def listed(self, now: float) -> tuple[Listed, ...]:
        """Return all robots, those that are up first."""
        self._forget(now)
        found = [
            Listed(
                name=name,
                up=not one.left and now - one.at <= SILENT * one.entry.every_s,
                robot=one.entry.robot,
                version=one.entry.version,
                urls=one.entry.urls,
                endpoints=one.entry.endpoints,
                address=one.address,
                up_s=round(one.entry.up_s, 1),
                seen_s=round(now - one.at, 1),
            )
            for name, one in self._known.items()
        ]
        return tuple(sorted(found, key=lambda one: (not one.up, one.name)))

    def _forget(self, now: float) -> None:
        for name in [name for name, one in self._known.items() if now - one.at > KEPT_S]:
            del self._known[name]
