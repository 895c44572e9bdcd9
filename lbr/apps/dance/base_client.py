"""Moving the base by a lease: taken at rest, changed at once, and given up whenever it is lost."""

from lbr.apps.dance.choreography import REST, Move
from lbr.leases.client import LeaseClient, LeaseTarget, Transport
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand

DRIVE = LeaseTarget("motion", "halt", "drive", "the drive does not answer; the base has stopped by itself")
TAKING_POWER = 0.001
"""No lease is given for standing still; so much moves nothing, and a stop from now on ends what has not begun yet."""


class BaseClient:
    """Holds the base for one dance."""

    def __init__(self, ctx: Transport, first: Move) -> None:
        self.changes = 0
        self._wanted = REST
        self._lease = LeaseClient(ctx, DRIVE, DriveCommand(power=TAKING_POWER, angle_deg=first.angle_deg))

    @property
    def ended(self) -> Reason | None:
        """Return why it holds the base no more, if it does not."""
        return self._lease.ended

    @property
    def holds(self) -> bool:
        """Return whether it has the base."""
        return self._lease.holds

    def move(self, move: Move) -> None:
        """Move so from now on."""
        if self.holds and move != self._wanted:
            self._wanted = move
            self.changes += 1

    def step(self) -> None:
        """Read the answers, and renew or change when it is due."""
        self._lease.step()
        self._lease.keep(DriveCommand(power=self._wanted.power, angle_deg=self._wanted.angle_deg))

    def release(self) -> None:
        """Stop the base, if it is still ours to stop or may become so."""
        self._lease.release("the dance is over")
