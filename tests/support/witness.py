"""Another client of a running robot, which hears what a recorder hears."""

from collections import deque

from lbr.bus import stamp, wire
from tests.support.bench import Bench

COMMAND = "/command"
"""What is asked of a robot comes once and is no stream: a recorder has it only on purpose."""


class Witness:
    """Another client that hears the same streams."""

    def __init__(self, under_test: Bench) -> None:
        self._session = under_test.robot.as_owner()
        self._heard: deque[tuple[str, int, int]] = deque(maxlen=200_000)
        self._subscriber = self._session.declare_subscriber("lbr/*/*", wire.direct(self._hear))

    def between(self, start_ns: int, end_ns: int) -> set[tuple[str, int]]:
        """Return topic and number of what was sent then, by the monotonic clock."""
        return {(topic, seq) for topic, seq, mono_ns in list(self._heard) if start_ns <= mono_ns <= end_ns}

    def close(self) -> None:
        """Hear no more."""
        self._session.close()

    def _hear(self, sample: object) -> None:
        attachment = sample.attachment  # type: ignore[attr-defined]
        found = stamp.read(attachment.to_bytes()) if attachment is not None else None
        topic = str(sample.key_expr).partition("/")[2]  # type: ignore[attr-defined]
        if found is not None and not topic.endswith(COMMAND):
            self._heard.append((topic, found.seq, found.mono_ns))
