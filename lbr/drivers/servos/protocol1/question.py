"""A prepared request, and the search for its answer in the input."""

from dataclasses import dataclass

GOOD_SUM = 0xFD
"""Low byte of the sum over a whole valid packet, header and checksum included."""


@dataclass(frozen=True, slots=True)
class Question:
    """A prepared request: its bytes, and the head, size and time limit of its answer.

    For `busy_s` request and answer occupy the wire; a later answer was delayed elsewhere.
    """

    servo: int
    request: bytes
    head: bytes
    size: int
    busy_s: float
    within_s: float


def packet_in(data: bytes, question: Question) -> bytes | None:
    """Return the answer within these bytes, wherever it begins."""
    at = data.find(question.head)
    while at >= 0 and len(data) >= at + question.size:
        candidate = data[at : at + question.size]
        if sum(candidate) & 0xFF == GOOD_SUM and candidate[4] < 0x80:
            return candidate
        at = data.find(question.head, at + 1)
    return None
