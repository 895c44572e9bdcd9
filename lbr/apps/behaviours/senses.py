"""The robot's telemetry for conditions: the newest message of each source, until it is too old."""

from lbr.apps.behaviours.cells import Value
from lbr.apps.behaviours.keys import STREAMS, Key
from lbr.apps.behaviours.kind import BehaviourSettings
from lbr.capability.context import Context, Received


class Senses:
    """Reads the streams of a table. Of several sources the newest with a value counts."""

    def __init__(self, ctx: Context[BehaviourSettings]) -> None:
        self._ctx = ctx
        self._newest: dict[str, dict[str, Received]] = {}
        self._arrived: dict[str, list[Received]] = {}

    @property
    def streams(self) -> frozenset[str]:
        """Return the streams of this robot."""
        return frozenset(stream for stream in STREAMS if self._ctx.sources(stream))

    def listen(self, streams: frozenset[str]) -> None:
        """Take the new messages of these streams."""
        for stream in streams:
            self._arrived[stream] = self._ctx.take(stream)
            for received in self._arrived[stream]:
                self._newest.setdefault(stream, {})[received.source] = received

    def newest(self, stream: str) -> list[Received]:
        """Return the newest message of each source of a stream."""
        return list(self._newest.get(stream, {}).values())

    def arrived(self, stream: str) -> list[Received]:
        """Return the messages of a stream that the last `listen` took, oldest first."""
        return self._arrived.get(stream, [])

    def look(self, key: Key, newest_s: float) -> Value | None:
        """Return the value of a key; None if all values are older than `newest_s`."""
        now, newest, arrived = self._ctx.clock(), None, float("-inf")
        for received in self._newest.get(key.stream, {}).values():
            if received.arrived > arrived and now - received.arrived <= newest_s:
                value = key.read(received.message)
                if value is not None:
                    newest, arrived = value, received.arrived
        return newest
