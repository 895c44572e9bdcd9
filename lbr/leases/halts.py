"""The last stops of the robot, so that commands written before another's stop move nothing any more. Pure."""

from math import inf

from msgspec import Struct


class Halts(Struct, frozen=True, kw_only=True):
    """The last stop `at`, by `source`, and the last one `before` it by another source."""

    at: float = -inf
    source: str = ""
    before: float = -inf
    before_source: str = ""

    def noted(self, at: float, source: str) -> "Halts":
        """Return the stops with one more; an empty source does not count as a sender."""
        if source and source == self.source:
            return Halts(at=max(at, self.at), source=source, before=self.before, before_source=self.before_source)
        if at >= self.at:
            return Halts(at=at, source=source, before=self.at, before_source=self.source)
        if at >= self.before:
            return Halts(at=self.at, source=self.source, before=at, before_source=source)
        return self

    def by_others(self, source: str) -> tuple[float, str]:
        """Return the time and source of the last stop by another than `source`."""
        return (self.before, self.before_source) if source and source == self.source else (self.at, self.source)
