"""One motion of the base: asked for, renewed under its lease, and how it ended."""

from typing import Any

from lbr.apps.autodock.view import Ending
from lbr.apps.program import Robot
from lbr.bus import keys
from lbr.bus.lease_client import LeaseClient, LeaseTarget
from lbr.bus.over_session import OverSession
from lbr.messages.drive import GoalResult

TTL_S = 0.8
"""Slow motions, by a program that has to wait while the machine is busy."""
DRIVE = LeaseTarget("motion", silent="the drive does not answer", silent_s=1.0 + TTL_S, result_s=0.5)
"""It is stopped by the pilot, who has to know its own stops from others'."""
FINAL = frozenset({"stopped", "stopped_since", "taken_over", "superseded", "held", "estop", "role", "denied"})
"""Why a motion ends, or is refused, when a user wants the robot to stand, or to go elsewhere."""


class Motion:
    """A command of the drive's, such as `turn`, with its fields. When it is not renewed any more, it lapses."""

    def __init__(self, robot: Robot, command: str, fields: dict[str, Any], now: float) -> None:
        self._now = now
        drive = {"motion": keys.port(robot.name, "drive", command)}
        over = OverSession(robot.bus, robot.source, drive, clock=lambda: self._now)
        self._lease = LeaseClient(over, DRIVE, _lasting(fields))

    @property
    def ending(self) -> Ending | None:
        """Return how it ended, if it has."""
        lease, why = self._lease, self._lease.ended
        if why is None:
            return None
        final = lease.silent or (not lease.good and why.code in FINAL)
        return Ending(good=lease.good, text=why.text, final=final)

    def renew(self, fields: dict[str, Any], now: float) -> None:
        """Go on, perhaps otherwise than before."""
        self._now = now
        self._lease.step()
        self._lease.keep(_lasting(fields))

    def hear(self, result: GoalResult) -> None:
        """Take a result, of whichever motion."""
        self._lease.hear(result)


def _lasting(fields: dict[str, Any]) -> dict[str, Any]:
    return fields | {"ttl_s": TTL_S}
