"""The one lease by which the API moves motors: taken with the first move, joined by others, over when all have
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
"""Where several clients move motors a little, each lease is over as soon as it is there."""
PLANNED = frozenset({"done", "superseded", "cancelled"})


class MotorClient:
    """Borrows the joints for all motors together; everything here is in the capability's loop.

    `lost` is told when a move ended by anything but its arrival, or another of ours.
    """

    def __init__(self, robot: Robot, lost: Callable[[str], None]) -> None:
        self._robot = robot
        self._lost = lost
        self._holder = Holder(robot.ctx, renewal=RENEWAL)
        self._released = (0, "")  # how often, and why
        self._begun = -inf

    @property
    def holds(self) -> bool:
        """Return whether motors are under way by our lease, or it is being asked for."""
        return self._holder.asks

    async def turn(self, turns: Iterable[Turn], joint: Callable[[Turn], Joint], *, timed: bool = False) -> None:
        """Move motors; return once the joints have accepted all of it, else raise Refused with their reason.

        `timed`: it was asked for long ago, so a stop that was not heard of yet is to come first. A request under a
        lease that ended just then, because all had arrived, is repeated.
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
        """Read how goals ended, and renew the lease while something is under way."""
        lease, ended = self._holder.lease, self._holder.step(self._robot.moved)
        if lease is None or lease.accepted is None or ended is None:
            return
        if not (lease.good or ended.code in PLANNED):
            self._lost(ended.text)

    def release(self, why: str) -> PendingReply | None:
        """Give the joints back, where they are, and begin nothing that waits; the answer says that they hold, if any
        did."""
        self._released = (self._released[0] + 1, why)
        return self._holder.release(why)

    async def _ask(self, command: JointsCommand, released: tuple[int, str], *, timed: bool) -> Reason | None:
        """Ask by the lease, or for one; return why it was refused, or nothing."""
        await until(lambda: self._ready(timed=timed) or self._released != released)
        if self._released != released:
            return Reason("cancelled", self._released[1])
        lease = self._holder.lease
        if lease is not None and lease.ended is None:
            return await self._join(lease, command)
        self._begun = self._robot.now()
        asked_s = min(self._heard_s(), self._begun) if timed else None
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
        """Return whether what waits can be asked for now; a date must not be before that of our last lease."""
        if self._holder.lease is not None and self._holder.asks:
            return self._holder.lease.accepted is not None
        return not timed or self._heard_s() > self._begun

    def _answered(self, lease: LeaseClient) -> bool:
        self.step()
        return lease.accepted is not None or lease.ended is not None

    def _heard_s(self) -> float:
        joints = self._robot.snapshot.joints
        return inf if joints is None else joints.arrived


def _sent(lease: LeaseClient, command: JointsCommand, asked: list[PendingReply]) -> bool:
    """Send a command unless too much waits for answers; what is refused leaves the motors that move alone."""
    found = lease.send(command, vital=False)
    asked += [found] if found is not None else []
    return found is not None


def _command(turns: Iterable[Turn], joint: Callable[[Turn], Joint]) -> JointsCommand | None:
    """Return one command, so that all begin or none does; of several turns of one motor, the last counts."""
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
