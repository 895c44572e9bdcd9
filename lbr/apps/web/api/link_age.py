"""The age of the picture by which a person drives, and the speed that it allows. Pure.

A page quotes the newest server time it received. Its age on return is the frame's way to the page, the wait for the
page's next message, and the message's way back.
"""

from collections.abc import Mapping
from math import exp, isnan, nan
from typing import Any

from msgspec import Struct

from lbr.apps.web.api.patience import SILENT_S, silent_s, type_of
from lbr.messages.description import CommandDescription
from lbr.messages.drive import DriveCommand, TwistCommand

OLDEST_S = 0.5
"""The age beyond which a message begins nothing. On a bad phone line a page's answer to a frame takes a third of a
second."""
FULL_S = 0.15
"""The age up to which a stick has its full speed. Between 150 and 225 ms steering by a picture breaks down (A. Khalil
and J. Kwon, arXiv:2603.06850, 180 runs)."""
SMOOTH_S = 0.5
"""Ages are smoothed over this time, so that one lost packet (0.2 s) does not jerk the base."""
STEP, PLAY = 0.1, 0.07
"""The share changes in steps, and only by more than the play."""
_SPEEDS = {DriveCommand.__name__: ("power",), TwistCommand.__name__: ("vx_mps", "vy_mps", "wz_rps")}


class LinkNews(Struct, frozen=True, kw_only=True):
    """The age of the page's picture, and the share of speed that it allows."""

    age_ms: int
    speed: float


class LinkAge:
    """The smoothed age of one page's messages, while its hand is on. At rest frames are rare, so the time in a first
    message may be older than the link's delay by up to `wait_s`."""

    def __init__(self, wait_s: float) -> None:
        self.age_s = nan
        self.share = 1.0
        self._wait_s = wait_s
        self._noted_s = nan

    def note(self, age_s: float, now: float) -> None:
        """Add a message of that age, received now; messages received together count as one."""
        if not age_s >= 0.0:  # NaN, or a time that the server never sent
            return
        if isnan(self.age_s):
            self.age_s = max(0.0, min(age_s, OLDEST_S) - self._wait_s)
        else:
            part = 1.0 - exp(-min(now - self._noted_s, SILENT_S) / SMOOTH_S)
            self.age_s += part * (min(age_s, OLDEST_S) - self.age_s)
        self._noted_s = now
        left = share(self.age_s)
        if abs(left - self.share) > PLAY:
            self.share = round(left / STEP) * STEP

    @property
    def news(self) -> LinkNews:
        """Return the news for the page; the age in steps of 10 ms."""
        return LinkNews(age_ms=round(self.age_s * 100) * 10, speed=round(self.share, 1))


def share(age_s: float) -> float:
    """Return the share of speed at which the base moves no further within the age than at full speed within
    `FULL_S`."""
    return 1.0 if age_s <= FULL_S else FULL_S / age_s


def slowed(command: CommandDescription | None, message: Mapping[str, Any], speed: float) -> Mapping[str, Any]:
    """Scale the speeds in a stick's message; motion that ends by itself stays as it is."""
    names = _SPEEDS.get(type_of(command.schema), ()) if command is not None else ()
    if speed >= 1.0 or silent_s(command, message) > SILENT_S:
        return message
    return {name: value * speed if name in names and _is_number(value) else value for name, value in message.items()}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
