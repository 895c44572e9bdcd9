"""The search in a camera's pictures: which pictures count, the last result, and why it is missing."""

from collections import deque
from math import inf

from lbr.apps.vision.eye import NO_PICTURES, Eye, Look, camera_off
from lbr.apps.vision.settings import VisionSettings
from lbr.capability.context import Context

NO_PICTURE_S = 1.0
RATE_OVER_S = 2.0


class Looking:
    """The search for one target, by an eye that it closes; for the capability's own loop."""

    def __init__(self, ctx: Context[VisionSettings], eye: Eye) -> None:
        self.eye = eye
        self.last: Look | None = None
        self.began_s = ctx.clock()
        self.seen_s = -inf
        self._ctx = ctx
        self._picture_s = -inf
        self._looked: deque[float] = deque(maxlen=100)

    def take(self, now: float) -> list[Look]:
        """Give the eye the newest picture if it is recent; return the eye's new results, oldest first."""
        for received in self._ctx.take("frame")[-1:]:
            if 0.0 <= received.age_s(now) <= self._ctx.settings.max_age_s:
                self._picture_s = received.arrived
                self.eye.look(received.message.data, received.arrived)
        looks = self.eye.looks()
        for look in looks:
            self.last = look
            self._looked.append(now)
            if look.seen is not None and self.counts(look, now):
                self.seen_s = look.taken_s
        return looks

    def counts(self, look: Look, now: float) -> bool:
        """Return whether a picture is new enough."""
        most_s: float = self._ctx.settings.max_age_s
        return now - look.taken_s <= most_s

    def has_pictures(self, now: float) -> bool:
        """Return whether pictures come."""
        return now - self._picture_s <= NO_PICTURE_S

    def trouble(self, now: float) -> str:
        """Return why no pictures are searched, or an empty string; the first one has a while to come."""
        if now - max(self._picture_s, self.began_s) <= NO_PICTURE_S:
            return ""
        return camera_off(self._ctx.latest("camera")) or NO_PICTURES

    def age_s(self, now: float) -> float | None:
        """Return the time since the target was seen; None before that."""
        return round(now - self.seen_s, 3) if self.seen_s > -inf else None

    def pictures_hz(self, now: float) -> float:
        """Return the rate of searched pictures of late."""
        return round(sum(1 for looked in self._looked if now - looked <= RATE_OVER_S) / RATE_OVER_S, 1)

    def close(self) -> None:
        """End the search."""
        self.eye.close()
