"""One motion after another, each by a lease: renewed while the motion is wanted, then given back."""

from collections.abc import Iterable, Mapping
from typing import Any

from lbr.leases.client import LeaseClient, LeaseTarget, Message, PendingReply, Transport
from lbr.messages.beacon import SeekCommand
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, GoalResult, HeadingCommand, TurnCommand
from lbr.messages.joints import PlayCommand
from lbr.messages.leases import CommandReply

GONE = "it does not answer; what moved has stopped by itself"
RESULT_S = 0.5
"""The result that explains a dead lease arrives within this time, also on a busy machine."""
TARGETS: Mapping[type, LeaseTarget] = {
    DriveCommand: LeaseTarget("move", "halt", "drive", f"the drive: {GONE}", result_s=RESULT_S),
    TurnCommand: LeaseTarget("turn", "halt", "drive", f"the drive: {GONE}", result_s=RESULT_S),
    HeadingCommand: LeaseTarget("heading", "halt", "drive", f"the drive: {GONE}", result_s=RESULT_S),
    PlayCommand: LeaseTarget("play", "play_halt", "motions", f"motions: {GONE}", result_s=RESULT_S),
    SeekCommand: LeaseTarget("seek", "seek_halt", "beacon", f"the beacon: {GONE}", result_s=RESULT_S),
}
"""The lender of each motion, for a capability with these requests."""
FINAL = frozenset({"stopped", "stopped_since", "taken_over", "held", "estop", "role", "denied", "shutting_down"})
"""Codes of an end or a refusal by a person who stops or holds the robot. They end all plans, too."""


def bounded(motion: object) -> bool:
    """Return whether a motion ends by itself."""
    if isinstance(motion, DriveCommand):
        return bool(motion.range_cm or motion.interval_s or motion.distance_cm)
    return True


class Holder:
    """Borrows motion, for one motion at a time; call `step` ten times a second.

    The repeated motion, or `renewal`, renews the lease. `lease` is that of the last motion, until its release.
    """

    def __init__(self, transport: Transport, *, renewal: Message | None = None) -> None:
        self.lease: LeaseClient | None = None
        self.motion: Any = None
        self._transport = transport
        self._renewal = renewal

    @property
    def holds(self) -> bool:
        """Return whether the motion was granted and goes on."""
        return self.lease is not None and self.lease.holds

    @property
    def asks(self) -> bool:
        """Return whether the motion goes on, or is still asked for."""
        return self.lease is not None and self.lease.ended is None

    @property
    def ended(self) -> Reason | None:
        """Return why the last motion is over."""
        return self.lease.ended if self.lease is not None else None

    @property
    def good(self) -> bool:
        """Return whether the last motion ended as planned."""
        return self.lease is not None and self.lease.good

    def begin(self, target: LeaseTarget, motion: Message, *, given: CommandReply | None = None) -> LeaseClient:
        """Begin a motion, by a lease that was `given` if there is one.

        A drive without an end changes into another under the same lease.
        """
        if self.lease is not None and self.lease.holds and not bounded(self.motion) and not bounded(motion):
            self.change(motion)
            return self.lease
        if given is None:
            self.release("another motion begins")
        self.motion = motion
        self.lease = LeaseClient(self._transport, target, motion, given=given)
        return self.lease

    def change(self, motion: Message) -> None:
        """Change the motion under the same lease."""
        self.motion = motion
        if self.lease is not None:
            self.lease.keep(motion)

    def step(self, results: Iterable[GoalResult] = (), lost: Reason | None = None) -> Reason | None:
        """Read the answers, and renew unless the motion's user is `lost`. Return the reason if the motion ended now."""
        lease = self.lease
        if lease is None or lease.ended is not None:
            return None
        for result in results:
            lease.hear(result)
        lease.step()
        if lease.ended is None and lost is not None:
            lease.release(lost.text, lost=lost.code == "holder_gone")
            return lost
        if self._renewal is None:
            lease.keep(self.motion)
        elif lease.renewal_due:
            lease.send(self._renewal)
        return lease.ended

    def release(self, why: str, *, lost: bool = False, by: str = "", at_once: bool = False) -> PendingReply | None:
        """Stop the motion, if the lease is held or still asked for."""
        lease, self.lease = self.lease, None
        return lease.release(why, lost=lost, by=by, at_once=at_once) if lease is not None else None
