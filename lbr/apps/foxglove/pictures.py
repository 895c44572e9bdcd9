"""The cameras that viewers watch, each subscribed to once. A camera without viewers is not subscribed to, and rests."""

from collections.abc import Callable, Iterable

from lbr.apps.web.api.feeds import Sample
from lbr.apps.web.api.robot_bus import RobotBus
from lbr.bus import stamp
from lbr.bus.wire import PolledSubscription


class Pictures:
    """The newest picture of each watched camera; on the server's thread alone."""

    def __init__(self, bus: RobotBus, key: Callable[[str], str]) -> None:
        self._bus = bus
        self._key = key
        self._wanted: dict[object, frozenset[str]] = {}
        self._subscribed: dict[str, tuple[PolledSubscription, Sample | None]] = {}

    def want(self, viewer: object, names: Iterable[str]) -> None:
        """Replace the cameras that a viewer watches; with none it has left."""
        self._wanted[viewer] = frozenset(names)
        if not self._wanted[viewer]:
            del self._wanted[viewer]
        wanted = frozenset().union(*self._wanted.values())
        for name in self._subscribed.keys() - wanted:
            self._subscribed.pop(name)[0].close()
        for name in wanted - self._subscribed.keys():
            self._subscribed[name] = self._bus.hear(self._key(name)), None

    def newest(self, name: str) -> Sample | None:
        """Return the newest picture of a watched camera, as bytes."""
        if name not in self._subscribed:
            return None
        feed, newest = self._subscribed[name]
        for raw in feed.take():
            sent_s = stamp.sent_s(stamp.read(raw.attachment), raw.arrived)
            newest = Sample(raw.payload, sent_s, newest.number + 1 if newest is not None else 1)
        self._subscribed[name] = feed, newest
        return newest
