"""The motion that the API plays: one at a time, by a lease that is renewed until it has ended."""

from collections.abc import Callable

from lbr.apps.web.bridge import Promise
from lbr.apps.web.face import Refused
from lbr.apps.web.robot import Robot
from lbr.capability.loan import Lender, Loan
from lbr.messages.joints import PlayCommand

LENDER = Lender("play", "stop_motion", "motions", "'motions' does not answer any more")
OLDEST_S = 1.5
"""A state of motions that is older says nothing: they tell it twice a second."""


class Player:
    """Borrows `motions`; everything here is in the capability's loop. `lost` is told how a motion ended unasked."""

    def __init__(self, robot: Robot, lost: Callable[[str], None]) -> None:
        self._robot = robot
        self._lost = lost
        self._command = PlayCommand(motion="none")
        self._loan: Loan | None = None
        self._promise: Promise[None] | None = None
        self._until = 0.0

    def busy(self, now: float) -> str:
        """Return what is being played, by whomever, and for how long; empty if nothing is."""
        if self._loan is not None:
            left = f" for another {max(0.0, self._until - now):.1f} s" if self._loan.holds else ""
            return f"busy: '{self._command.motion}' plays{left}"
        heard, state = self._robot.snapshot.motions, self._robot.snapshot.motions_state
        if heard is None or state is None or not state.playing or heard.age_s(now) > OLDEST_S:
            return ""
        return f"busy: '{state.motion}' is played by {state.holder or 'somebody'}"

    def play(self, motion: str) -> Promise[None]:
        """Play a motion; the promise is kept once it was accepted, else Refused with the reason."""
        if why := self.busy(self._robot.now()):
            raise Refused(409, why)
        self._command = PlayCommand(motion=motion)
        self._promise = Promise()
        self._until = 0.0
        self._loan = Loan(self._robot.ctx, LENDER, self._command)
        return self._promise

    def step(self, now: float) -> None:
        """Read the answers, renew, and see the end."""
        loan = self._loan
        if loan is None:
            return
        loan.step()
        if self._promise is not None and loan.holds:
            self._until = now + self._takes_s()
            self._promise.keep(None)
            self._promise = None
        goal = loan.granted.goal if loan.granted is not None else None
        ended = next((result for result in self._robot.played if result.goal == goal), None)
        if ended is not None:
            self._end("" if ended.result == "reached" else ended.reason or ended.result)
        elif loan.ended:
            self._end(loan.ended)
        elif loan.due:
            loan.send(self._command)

    def stop(self, why: str) -> None:
        """End what is played here."""
        if self._loan is not None:
            self._loan.release(why)
            self._end(why)

    def _end(self, why: str) -> None:
        self._loan = None
        promise, self._promise = self._promise, None
        if promise is not None:
            promise.refuse(Refused(409, why or "it has ended"))
        elif why:
            self._lost(why)

    def _takes_s(self) -> float:
        row = next((motion for motion in self._robot.motions if motion.name == self._command.motion), None)
        if row is None:
            return 0.0
        return row.slot_s if row.slot_s is not None else sum(frame.duration_s for frame in row.frames)
