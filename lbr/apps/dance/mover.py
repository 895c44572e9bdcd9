"""Moving the base by a lease: taken at rest, changed at once, and given up whenever it is lost."""

from lbr.apps.dance.choreography import REST, Move
from lbr.capability.loan import Asking, Lender, Loan
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand

DRIVE = Lender("motion", "halt", "drive", "the drive does not answer; the base has stopped by itself")
TAKING_POWER = 0.001
"""No lease is given for standing still; so much moves nothing, and a stop from now on ends what has not begun yet."""


class Mover:
    """Holds the base for one dance."""

    def __init__(self, ctx: Asking, first: Move) -> None:
        self.changes = 0
        self._wanted = REST
        self._sent: Move | None = None
        self._loan = Loan(ctx, DRIVE, DriveCommand(power=TAKING_POWER, angle_deg=first.angle_deg))

    @property
    def ended(self) -> Reason | None:
        """Why it holds the base no more, if it does not."""
        return self._loan.ended

    @property
    def holds(self) -> bool:
        """Whether it has the base."""
        return self._loan.holds

    def move(self, move: Move) -> None:
        """Move so from now on."""
        if self.holds and move != self._wanted:
            self._wanted = move
            self.changes += 1

    def step(self) -> None:
        """Read the answers, and renew or change when it is due."""
        self._loan.step()
        if self._loan.due or (self.holds and self._wanted != self._sent):
            command = DriveCommand(power=self._wanted.power, angle_deg=self._wanted.angle_deg)
            if self._loan.send(command) is not None:
                self._sent = self._wanted

    def release(self) -> None:
        """Stop the base, if it is still ours to stop or may become so."""
        self._loan.release("the dance is over")
