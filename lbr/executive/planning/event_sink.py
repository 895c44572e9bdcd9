"""The interface by which the executive's parts make events."""

from typing import Any, Protocol


class EventSink(Protocol):
    """Makes an event."""

    def __call__(
        self,
        kind: str,
        subject: str,
        text: str,
        level: str = "info",
        code: str | None = None,
        *,
        data: dict[str, Any] | None = None,
    ) -> None:
        """Make an event."""
