"""A request made ready, and its answer found among what came."""

from dataclasses import dataclass

GOOD_SUM = 0xFD
"""Low byte of the sum over a whole sound packet, its header and checksum included."""


@dataclass(frozen=True, slots=True)
class Question:
    """A request made ready: its bytes, how its answer begins, how long that is and how long it may take.

    For `busy_s` the wire is taken, by the request or by its answer; what comes later was held up elsewhere.
    """

    servo: int
    request: bytes
    head: bytes
    size: int
    busy_s: float
    within_s: float


def packet_in(data: bytes, question: Question) -> bytes | None:
    """Return the answer that these bytes hold, wherever it begins."""
    at = data.find(question.head)
    while at >= 0 and len(data) >= at + question.size:
        found = data[at : at + question.size]
        if sum(found) & 0xFF == GOOD_SUM and found[4] < 0x80:
            return found
        at = data.find(question.head, at + 1)
    return None
