"""The recording of a capability for a recorder: the bytes of its devices, its requests and answers."""

from msgspec import Raw, Struct


class LineBytes(Struct, frozen=True, array_like=True, gc=False):
    """Bytes sent or received together: the time by the sender's monotonic clock, the direction, and the bytes."""

    at_ns: int
    sent: bool
    data: bytes


class TapedLine(Struct, frozen=True, kw_only=True):
    """The bytes of a device's line since the last message. `opening`: those by which it was opened before the
    recording."""

    device: str
    pieces: tuple[LineBytes, ...]
    opening: bool = False
    lost: int = 0


class TapedCommand(Struct, frozen=True, kw_only=True):
    """A command, by a query or a `put`, and its answer; times by the monotonic clock of the answering process."""

    name: str
    source: str
    at_ns: int
    payload: bytes
    answerable: bool
    answered_ns: int
    reply: Raw


class Taped(Struct, frozen=True, kw_only=True):
    """The bytes in and out since the last one; `now_ns` is the monotonic time of this message."""

    now_ns: int
    lines: tuple[TapedLine, ...] = ()
    commands: tuple[TapedCommand, ...] = ()
