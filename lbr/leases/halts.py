"""Remembers who stopped the robot last, so that what others had written before moves nothing any more. Pure."""

from math import inf

from msgspec import Struct


class Halts(Struct, frozen=True, kw_only=True):
    """When another's stop came last, for each who may ask: the last one `at`, by `source`; `before` it, by others than
    that."""

    at: float = -inf
    source: str = ""
    before: float = -inf
    before_source: str = ""

    def noted(self, at: float, source: str) -> "Halts":
        """Return the stops with one more; an empty source is not one that may ask."""
        if source and source == self.source:
            return Halts(at=max(at, self.at), source=source, before=self.before, before_source=self.before_source)
        if at >= self.at:
            return Halts(at=at, source=source, before=self.at, before_source=self.source)
        if at >= self.before:
            return Halts(at=self.at, source=self.source, before=at, before_source=source)
        return self

    def by_others(self, source: str) -> tuple[float, str]:
        """Return when another than `source` stopped it last, and its name."""
        return (self.before, self.before_source) if source and source == self.source else (self.at, self.source)
