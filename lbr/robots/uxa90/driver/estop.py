"""The act of the emergency stop on the line, and its acknowledgement after the servos were read standing still."""

from collections.abc import Callable
from math import inf

from lbr.capability.context import Context
from lbr.robots.uxa90.driver import Uxa90Settings
from lbr.robots.uxa90.driver.session import Session

AGAIN_S = 0.3
RELEASED = "the emergency stop let it go; switch its torque off, then on"


class EmergencyStop:
    """The emergency stop; call `step` in every round. A release of the stop reverses none of its acts."""

    def __init__(self, ctx: Context[Uxa90Settings], named: Callable[[list[int], str], str]) -> None:
        self._ctx = ctx
        self._named = named
        self._engaged = False
        self._since = inf
        self._acknowledged_at = -inf
        self._passed = False
        self._done = self._rested = False

    def step(self, session: Session, now: float) -> None:
        """Act by the row, until the effect is known; then acknowledge it."""
        estop = self._ctx.estop
        if not estop.engaged:
            if self._engaged:
                self._engaged = False
                estop.acknowledge(stopped=False, reason="released")
            return
        first = not self._engaged
        if first:
            self._engaged, self._since, self._acknowledged_at = True, now, -inf
            self._done = self._rested = False
            session.targets.watch_rest()
            session.controller.take()
        passes = session.controller.passes
        newly_passes, self._passed = passes and not self._passed, passes
        if not self._done and (first or newly_passes or now - self._acknowledged_at >= AGAIN_S):
            self._acknowledged_at = now
            self._act(session)
        why = self._unconfirmed(session)
        self._done = self._done or not why
        estop.acknowledge(stopped=not why, reason=why)

    def _act(self, session: Session) -> None:
        how = self._ctx.settings.on_estop
        if how == "break":
            session.brake()
        elif how == "release":
            session.targets.release(RELEASED)

    def _unconfirmed(self, session: Session) -> str:
        """Return why the servos are not known to have stood still, or an empty string.

        A servo that was once read standing still, without an order since, is moved only by its weight or by hand.
        """
        if session.controller.occupied or not session.controller.passes:
            self._rested = False
            return "the main board is asked to pass servo packets on"
        if self._ctx.settings.trust == "never" or not self._ctx.settings.sweep_hz:
            return (
                "the stop was sent to the servos, and nothing confirms it: the settings trust or sweep_hz forbid that"
            )
        moving = [] if self._rested else session.targets.unrested(self._since)
        self._rested = not moving
        return self._named(moving, "not confirmed by") if moving else ""
