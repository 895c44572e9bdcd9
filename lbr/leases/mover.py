"""One motion after another by leases like anyone's: renewed while it is wanted, given up whenever it is not."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from msgspec.structs import replace

from lbr.leases.client import LeaseClient, LeaseTarget, Transport
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, GoalResult, TurnCommand

GONE = "it does not answer; what moved has stopped by itself"
RESULT_S = 0.5
"""A lease that died is heard of before the result that says why: not later than this on a busy machine."""
DRIVE: Mapping[type, LeaseTarget] = {
    DriveCommand: LeaseTarget("move", "halt", "drive", f"the drive: {GONE}", result_s=RESULT_S),
    TurnCommand: LeaseTarget("turn", "halt", "drive", f"the drive: {GONE}", result_s=RESULT_S),
}
"""What a base does, for who has requests of these names."""
FINAL = frozenset({"stopped", "stopped_since", "taken_over", "held", "estop", "role", "denied", "shutting_down"})
"""Why a command ends, or is refused, when a person wants the robot to stand, or has it: then all that was planned is
over."""


class Outcome(NamedTuple):
    """How an order ended: `good` as planned, and why by the list of codes."""

    good: bool
    why: Reason


def bounded(motion: Any) -> bool:
    """Say whether a motion ends by itself."""
    if isinstance(motion, DriveCommand):
        return bool(motion.range_cm or motion.interval_s or motion.distance_cm)
    return True


class Mover:
    """Holds what moves for one motion at a time; a drive without an end may become another one without a halt between.

    `targets` says whom a motion is borrowed from, by the type of its command.
    """

    def __init__(self, transport: Transport, ttl_s: float, targets: Mapping[type, LeaseTarget] | None = None) -> None:
        self._transport = transport
        self._targets = targets or DRIVE
        self._ttl_s = ttl_s
        self._client: LeaseClient | None = None
        self._motion: Any = None

    @property
    def motion(self) -> Any:
        """Return what it does."""
        return self._motion

    def begin(self, motion: Any) -> None:
        """Move so from now on, whatever was before."""
        before, self._motion = self._motion, motion
        steered = isinstance(before, DriveCommand) and not bounded(before) and isinstance(motion, DriveCommand)
        if self._client is not None and self._client.holds and steered and not bounded(motion):
            self._client.keep(self._lasting())
            return
        if self._client is not None and before is not None:
            self.halt("the table goes on otherwise")
            self._motion = motion
        self._client = LeaseClient(self._transport, self._targets[type(motion)], self._lasting())

    def step(self, results: list[GoalResult]) -> None:
        """Read the answers, and renew."""
        if self._client is None or self._motion is None:
            return
        for result in results:
            self._client.hear(result)
        self._client.step()
        self._client.keep(self._lasting())

    def outcome(self) -> Outcome | None:
        """Return what became of the motion: its end, or for one without an end that it has begun."""
        client, motion = self._client, self._motion
        if client is None or motion is None:
            return None
        if client.ended is not None:
            return Outcome(client.good, client.ended)
        if client.holds and not bounded(motion):
            return Outcome(True, Reason("done", "it drives"))
        return None

    @property
    def ended(self) -> bool:
        """Return whether the motion is over."""
        return self._client is None or self._client.ended is not None

    def halt(self, why: str) -> None:
        """Stand still, if it is still ours to stop or may become so."""
        client, self._client, self._motion = self._client, None, None
        if client is not None:
            client.release(why)

    def _lasting(self) -> Any:
        assert self._motion is not None
        return replace(self._motion, ttl_s=self._ttl_s)
