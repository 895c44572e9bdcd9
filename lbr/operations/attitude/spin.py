"""A turn on the spot, as anybody asks the drive for one: by a lease that is quoted and renewed ten times a second."""

from typing import Literal

from lbr.capability.context import Asked, Context
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.operations.attitude.settings import AttitudeSettings

RENEW_S = 0.1
ANSWER_S = 0.25
CLOCKWISE_DEG, ANTICLOCKWISE_DEG = 90.0, 270.0

Direction = Literal[1, -1]


class Spin:
    """Turns from the first `step` on, for as long as it is stepped; `ended` says why it turns no longer.

    Nothing here outlives its lease: who does not call `step` any more turns no longer.
    """

    def __init__(self, ctx: Context[AttitudeSettings], power: float) -> None:
        self._ctx = ctx
        self._power = power
        self._lease = ""
        self._asked: Asked | None = None
        self._asked_s = 0.0
        self.began = False
        self.ended: Reason | None = None

    def step(self, direction: Direction) -> None:
        """Take in the drive's answer, and renew the lease when it is time."""
        if self.ended:
            return
        now = self._ctx.clock()
        if self._asked is not None:
            self._listen(self._asked, now)
        if not self.ended and self._asked is None and (not self.began or now - self._asked_s >= RENEW_S):
            self._ask(direction, now)

    def halt(self, reason: Reason) -> None:
        """Stop, if it still turns by this lease; a motion of somebody else's is left alone."""
        if not self.ended:
            self.ended = reason
            if self.began or self._asked is not None:
                self._ctx.ask("halt", StopCommand(reason=reason.text[:200]), timeout_s=ANSWER_S)

    def _ask(self, direction: Direction, now: float) -> None:
        angle_deg = CLOCKWISE_DEG if direction > 0 else ANTICLOCKWISE_DEG
        command = DriveCommand(power=self._power, angle_deg=angle_deg, lease=self._lease)
        self._asked, self._asked_s = self._ctx.ask("motion", command, timeout_s=ANSWER_S), now

    def _listen(self, asked: Asked, now: float) -> None:
        answers = asked.answers()
        if answers is None:
            if now - self._asked_s > 2 * ANSWER_S:
                self.ended = Reason("unreachable", "the drive does not answer")
            return
        self._asked = None
        if not answers:
            self.ended = Reason("wiring", "nothing that drives is wired to its request 'motion'")
        for name, answer in answers.items():
            if not isinstance(answer, CommandReply):
                self.ended = Reason("unreachable", f"'{name}' does not answer")
            elif not answer.accepted:
                self.ended = answer.why
            else:
                self._lease, self.began = answer.lease, True
