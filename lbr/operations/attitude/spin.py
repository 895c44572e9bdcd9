"""A turn on the spot, as anybody asks the drive for one: by a lease that is quoted and renewed ten times a second."""

from typing import Literal

from lbr.leases.client import LeaseClient, LeaseTarget, Transport
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand

DRIVE = LeaseTarget("motion", "halt", "drive", "the drive does not answer")
CLOCKWISE_DEG, ANTICLOCKWISE_DEG = 90.0, 270.0

Direction = Literal[1, -1]


class Spin:
    """Turns from the first `step` on, for as long as it is stepped; `ended` says why it turns no longer.

    Nothing here outlives its lease: what does not call `step` any more turns no longer.
    """

    def __init__(self, ctx: Transport, power: float) -> None:
        self._ctx = ctx
        self._power = power
        self._lease: LeaseClient | None = None
        self._halted: Reason | None = None

    @property
    def began(self) -> bool:
        """Return whether the drive took the command."""
        return self._lease is not None and self._lease.accepted is not None

    @property
    def ended(self) -> Reason | None:
        """Return why it turns no longer, if it does not."""
        return self._halted or (self._lease.ended if self._lease is not None else None)

    def step(self, direction: Direction) -> None:
        """Take in the drive's answer, and renew the lease when it is time."""
        if self.ended is not None:
            return
        command = DriveCommand(power=self._power, angle_deg=CLOCKWISE_DEG if direction > 0 else ANTICLOCKWISE_DEG)
        if self._lease is None:
            self._lease = LeaseClient(self._ctx, DRIVE, command)
        self._lease.step()
        self._lease.keep(command)

    def halt(self, reason: Reason) -> None:
        """Stop, if it still turns by this lease; a motion of another sender's is left alone."""
        if self._lease is not None:
            self._lease.release(reason.text)
        self._halted = self._halted or reason
