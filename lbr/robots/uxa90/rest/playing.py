"""The motion that the API plays: one at a time, by a lease that is renewed until it has ended."""

from collections.abc import Callable

from lbr.apps.web.bridge import until
from lbr.apps.web.face import Refused
from lbr.apps.web.robot import Robot
from lbr.leases.client import LeaseClient, LeaseTarget
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason
from lbr.messages.joints import PlayCommand

LENDER = LeaseTarget("play", "stop_motion", "motions", "'motions' does not answer any more")
OLDEST_S = 1.5
"""The age limit of a state of motions, which comes twice a second."""


class Player:
    """A client of `motions`, which runs in the capability's loop. It calls `lost` when a motion ends unasked."""

    def __init__(self, robot: Robot, lost: Callable[[str], None]) -> None:
        self._robot = robot
        self._lost = lost
        self._command = PlayCommand(motion="none")
        self._holder = Holder(robot.ctx)
        self._until: float | None = None
        self._why: Reason | None = None

    def busy(self, now: float) -> str:
        """Return a sentence about the current motion, of any sender, and its remaining time; empty without one."""
        if self._holder.asks:
            left = "" if self._until is None else f" for another {max(0.0, self._until - now):.1f} s"
            return f"busy: '{self._command.motion}' plays{left}"
        received, state = self._robot.snapshot.motions, self._robot.snapshot.motions_state
        if received is None or state is None or not state.playing or received.age_s(now) > OLDEST_S:
            return ""
        return f"busy: '{state.motion}' is played by {state.holder or 'another'}"

    async def play(self, motion: str) -> None:
        """Play a motion; return once it was accepted, else raise Refused with the reason."""
        if why := self.busy(self._robot.now()):
            raise Refused(409, why, code="busy")
        self._command, self._until = PlayCommand(motion=motion), None
        lease = self._holder.begin(LENDER, self._command)
        await until(lambda: lease.accepted is not None or lease.ended is not None)
        if lease.accepted is None:
            raise Refused(409, self._why or "it has ended", code=None if self._why else "done")

    def step(self, now: float) -> None:
        """Process replies, renew the lease, and detect the end."""
        ended = self._holder.step(self._robot.played)
        if self._holder.holds and self._until is None:
            self._until = now + self._takes_s()
        if ended is not None and self._holder.lease is not None:
            self._end(self._holder.lease, ended)

    def stop(self, why: str) -> None:
        """End the motion played here."""
        if self._holder.lease is not None and self._holder.asks:
            self._end(self._holder.lease, Reason("stopped", why))
            self._holder.release(why)

    def _end(self, lease: LeaseClient, why: Reason) -> None:
        self._why = None if lease.good else why
        if self._why is not None and lease.accepted is not None:
            self._lost(why.text)

    def _takes_s(self) -> float:
        row = self._robot.motion(self._command.motion)
        if row is None:
            return 0.0
        return row.slot_s if row.slot_s is not None else sum(frame.duration_s for frame in row.frames)
