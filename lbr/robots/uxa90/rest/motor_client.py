"""The one lease by which the API moves motors: granted with the first move, joined by others, over when all have
arrived."""

from collections.abc import Callable, Iterable
from math import inf

from msgspec.structs import replace

from lbr.apps.web.bridge import until
from lbr.apps.web.face import Refused
from lbr.apps.web.robot import Robot, answer_of
from lbr.leases.client import RENEW_S, LeaseClient, LeaseTarget, PendingReply
from lbr.leases.holder import Holder
from lbr.messages.codes import Reason
from lbr.messages.joints import Joint, JointsCommand
from lbr.messages.leases import CommandReply
from lbr.robots.uxa90.rest.counts import joint_rad, strength
from lbr.robots.uxa90.rest.parsing import Turn

TTL_S = 0.5
JOINTS = LeaseTarget("move", "halt", "joints operation", "joints operation does not answer", silent_s=TTL_S + RENEW_S)
RENEWAL = JointsCommand(ttl_s=TTL_S)
MOST_TRIES = 20
"""The repetitions of a request: where several clients move motors a little, each lease ends as soon as it begins."""
PLANNED = frozenset({"done", "superseded", "cancelled"})


class MotorClient:
    """Leases the joints for all motors together; everything here runs in the capability's loop.

    It calls `lost` when a move ended by anything but its arrival, or another of ours.
    """

    def __init__(self, robot: Robot, lost: Callable[[str], None]) -> None:
        self._robot = robot
        self._lost = lost
        self._holder = Holder(robot.ctx, renewal=RENEWAL)
        self._released = (0, "")  # the number of releases, and the last reason
        self._begun = -inf

    @property
    def holds(self) -> bool:
        """Return whether motors move under our lease, or it is requested."""
        return self._holder.asks

    async def turn(self, turns: Iterable[Turn], joint: Callable[[Turn], Joint], *, timed: bool = False) -> None:
        """Move motors; return once the joints have accepted all of it, else raise Refused with their reason.

        `timed`: it was requested long ago, so a stop that is still on its way must come first. A request is repeated if
        its lease has just ended because all had arrived.
        """
        command = _command(turns, joint)
        if command is None:
            return
        released, tries = self._released, 0
        while (why := await self._ask(command, released, timed=timed)) is not None:
            tries += 1
            if why.code != "done" or tries > MOST_TRIES:
                raise Refused(409, why)

    def step(self) -> None:
        """Process the ends of goals, and renew the lease during motion."""
        lease, ended = self._holder.lease, self._holder.step(self._robot.moved)
        if lease is None or lease.accepted is None or ended is None:
            return
        if not (lease.good or ended.code in PLANNED):
            self._lost(ended.text)

    def release(self, why: str) -> PendingReply | None:
        """Release the lease, holding the joints, and drop waiting requests; return the reply to come, if there was a
        lease."""
        self._released = (self._released[0] + 1, why)
        return self._holder.release(why)

    async def _ask(self, command: JointsCommand, released: tuple[int, str], *, timed: bool) -> Reason | None:
        """Send a command under the lease, or for a new one; return why it was refused, or None."""
        await until(lambda: self._ready(timed=timed) or self._released != released)
        if self._released != released:
            return Reason("cancelled", self._released[1])
        lease = self._holder.lease
        if lease is not None and lease.ended is None:
            return await self._join(lease, command)
        self._begun = self._robot.now()
        asked_s = min(self._joints_seen_s(), self._begun) if timed else None
        lease = self._holder.begin(JOINTS, replace(command, asked_s=asked_s))
        await until(lambda: self._answered(lease))
        return None if lease.accepted is not None else lease.ended

    async def _join(self, lease: LeaseClient, command: JointsCommand) -> Reason | None:
        asked: list[PendingReply] = []
        await until(lambda: not lease.holds or _sent(lease, command, asked))
        if not asked:
            return lease.ended or Reason("done", "it has ended")
        await until(lambda: asked[0].answers() is not None)
        reply: CommandReply = answer_of("move", dict(asked[0].answers() or {}))
        if reply.code == "dead_lease" and self._holder.lease is lease and reply.cause == "done":
            self._holder.lease = None
        return None if reply.accepted else reply.why

    def _ready(self, *, timed: bool) -> bool:
        """Return whether a waiting request can be sent now; its date must not be before that of our last lease."""
        if self._holder.lease is not None and self._holder.asks:
            return self._holder.lease.accepted is not None
        return not timed or self._joints_seen_s() > self._begun

    def _answered(self, lease: LeaseClient) -> bool:
        self.step()
        return lease.accepted is not None or lease.ended is not None

    def _joints_seen_s(self) -> float:
        joints = self._robot.snapshot.joints
        return inf if joints is None else joints.arrived


def _sent(lease: LeaseClient, command: JointsCommand, asked: list[PendingReply]) -> bool:
    """Send a command unless too many wait for replies; a refusal does not affect moving motors."""
    pending = lease.send(command, vital=False)
    asked += [pending] if pending is not None else []
    return pending is not None


def _command(turns: Iterable[Turn], joint: Callable[[Turn], Joint]) -> JointsCommand | None:
    """Return one command, so that all motors begin or none; of several turns of one motor, the last counts."""
    newest = {turn.motor.id: turn for turn in turns}
    rows = {joint(turn).name: (joint(turn), turn) for turn in newest.values()}
    if not rows:
        return None
    positions = {name: joint_rad(row, turn.count) for name, (row, turn) in rows.items()}
    strengths = {name: strength(turn.level) for name, (_, turn) in rows.items()}
    one = next(iter(strengths.values()))
    if set(strengths.values()) == {one}:
        return JointsCommand(positions=positions, join=True, torque=one, ttl_s=TTL_S)
    return JointsCommand(positions=positions, join=True, torques=strengths, ttl_s=TTL_S)
