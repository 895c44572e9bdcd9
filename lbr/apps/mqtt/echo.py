"""The delay of a broker, measured by words that it sends back, as its messages have no date. Pure.

A broker that stood still delivers all messages of that time at once, ours and others', in any order. So it counts as
late while our word is missing, and for a moment after one has come back late.
"""

import secrets
from math import inf

EVERY_S = 1.0
LATE_S = 2.0
"""By then a sender has moved on; a broker on another continent takes a fifth of that."""
CALM_S = 2.0
"""By then all messages of the same standstill are delivered, and a later word is back."""
MOST_UNDER_WAY = 60


class Echo:
    """The words under way since the last connection."""

    def __init__(self) -> None:
        self._mark = ""
        self._number = 0
        self._sent: dict[str, float] = {}
        self._received_s = -inf
        """The time at which the newest returned word was sent."""
        self._late_until = -inf
        self._next = -inf
        self.ever = False
        """True once a word has come back since the last connection."""

    def connected(self, now: float) -> None:
        """Start over, as words of an earlier connection do not come back."""
        self._mark, self._number, self._sent = secrets.token_hex(4), 0, {}
        self._received_s, self._late_until, self._next = now, -inf, now
        self.ever = False

    def word(self, now: float) -> str:
        """Return the word to send now, or an empty string."""
        if now < self._next:
            return ""
        self._next = now + EVERY_S
        self._number += 1
        word = f"{self._mark}-{self._number}"
        self._sent[word] = now
        if len(self._sent) > MOST_UNDER_WAY:
            del self._sent[next(iter(self._sent))]
        return word

    def receive(self, payload: bytes, now: float) -> None:
        """Handle a returned message; foreign and repeated ones are ignored."""
        sent = self._sent.pop(payload.decode(errors="replace"), None)
        if sent is None:
            return
        self.ever = True
        self._received_s = max(self._received_s, sent)
        self._sent = {word: at for word, at in self._sent.items() if at > sent}
        if now - sent > LATE_S:
            self._late_until = now + CALM_S

    def late(self, now: float) -> bool:
        """Return whether a message received now may be old."""
        return self.stands_still(now) or now < self._late_until

    def stands_still(self, now: float) -> bool:
        """Return whether none of the latest words has come back."""
        return not now - self._received_s <= LATE_S + EVERY_S  # this way round, NaN is late
