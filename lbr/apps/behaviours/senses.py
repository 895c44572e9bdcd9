"""The robot's telemetry as conditions ask for it: the newest message of each source, for as long as it counts."""

from lbr.apps.behaviours.cells import Value
from lbr.apps.behaviours.keys import STREAMS, Key
from lbr.apps.behaviours.kind import BehaviourSettings
from lbr.capability.context import Context, Received


class Senses:
    """Listens to the streams that a table reads; of several sources the newest that has a value counts."""

    def __init__(self, ctx: Context[BehaviourSettings]) -> None:
        self._ctx = ctx
        self._newest: dict[str, dict[str, Received]] = {}
        self._arrived: dict[str, list[Received]] = {}

    @property
    def streams(self) -> frozenset[str]:
        """Return the streams that the robot has."""
        return frozenset(stream for stream in STREAMS if self._ctx.sources(stream))

    def listen(self, streams: frozenset[str]) -> None:
        """Take in what came."""
        for stream in streams:
            self._arrived[stream] = self._ctx.take(stream)
            for received in self._arrived[stream]:
                self._newest.setdefault(stream, {})[received.source] = received

    def newest(self, stream: str) -> list[Received]:
        """Return the newest message of each source of a stream."""
        return list(self._newest.get(stream, {}).values())

    def arrived(self, stream: str) -> list[Received]:
        """Return what was taken in last of a stream, oldest first."""
        return self._arrived.get(stream, [])

    def look(self, key: Key, newest_s: float) -> Value | None:
        """Return the value of a key, None if the newest is older than that."""
        now, newest, arrived = self._ctx.clock(), None, float("-inf")
        for received in self._newest.get(key.stream, {}).values():
            if received.arrived > arrived and now - received.arrived <= newest_s:
                value = key.read(received.message)
                if value is not None:
                    newest, arrived = value, received.arrived
        return newest
