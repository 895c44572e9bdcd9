"""The one lease by which the API moves motors: taken with the first move, joined by others, over when all have arrived."""

from collections import OrderedDict, deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field
from math import inf
from typing import Any

from msgspec.structs import replace

from lbr.apps.web.bridge import Promise
from lbr.apps.web.face import Refused
from lbr.apps.web.robot import Robot, answer_of
from lbr.apps.web.uxa90.counts import joint_rad, strength
from lbr.apps.web.uxa90.deciding import Turn
from lbr.messages.codes import Reason
from lbr.messages.drive import GoalResult
from lbr.messages.joints import Joint, JointsCommand
from lbr.messages.leases import CommandReply, StopCommand, refused

RENEW_S = 0.1
TTL_S = 0.5
ANSWER_S = 1.0
MOST_TRIES = 20
"""Where several clients move motors a little, each lease is over as soon as it is there."""
MOST_RENEWALS = 4
MOST_ENDED = 64
PLANNED = ("reached", "superseded")


@dataclass(slots=True, eq=False)
class _Wish:
    """What one request wants, who waits for it, after how many releases, and how often it was sent in vain.

    What was `timed` begins only if nobody has stopped the joints since they were heard last.
    """

    command: JointsCommand
    promise: Promise[None]
    releases: int
    timed: bool
    tries: int = 0


@dataclass(slots=True, eq=False)
class _Hold:
    """The lease we have; `goal` is what it lives for now."""

    lease: str
    goal: str
    sent: float
    heard: float
    renewals: int = field(default=0)


class Mover:
    """Borrows the joints for all motors together; everything here is in the capability's loop.

    `lost` is told when a move ended by anything but its arrival, or another of ours.
    """

    def __init__(self, robot: Robot, lost: Callable[[str], None]) -> None:
        self._robot = robot
        self._lost = lost
        self._hold: _Hold | None = None
        self._taking: _Wish | None = None
        self._wishes: deque[_Wish] = deque()
        self._ended: OrderedDict[str, GoalResult] = OrderedDict()
        self._releases = 0
        self._begun = -inf

    @property
    def holds(self) -> bool:
        """Whether motors are under way by our lease, or it is being asked for."""
        return self._hold is not None or self._taking is not None

    def turn(self, turns: Iterable[Turn], joint: Callable[[Turn], Joint], *, timed: bool = False) -> Promise[None]:
        """Move motors; the promise is kept once the joints have accepted all of it, else Refused with their reason.

        `timed`: it was asked for long ago, so a stop that was not heard of yet is to come first.
        """
        promise: Promise[None] = Promise()
        command = _command(turns, joint)
        if command is None:
            promise.keep(None)
        else:
            self._wishes.append(_Wish(command, promise, self._releases, timed))
            self._go()
        return promise

    def step(self, now: float) -> None:
        """Read how goals ended, and renew the lease while something is under way."""
        for result in self._robot.moved:
            self._note(result)
        self._go()
        hold = self._hold
        if hold is None:
            return
        if not now - hold.heard <= TTL_S + RENEW_S:
            self._over("joints operation does not answer")
        elif now - hold.sent >= RENEW_S and hold.renewals < MOST_RENEWALS:
            hold.sent = now
            hold.renewals += 1
            promise = self._robot.follow("move", JointsCommand(lease=hold.lease, ttl_s=TTL_S), ANSWER_S)
            promise.add_done_callback(lambda done, hold=hold: self._renewed(hold, done))  # type: ignore[misc]

    def release(self, why: str) -> Promise[Any] | None:
        """Give the joints back, where they are; the promise is kept when they have said so. None: nothing is held."""
        self.drop(why)
        self._releases += 1
        if not self.holds:
            return None
        self._hold = None
        return self._robot.follow("halt", StopCommand(reason=why), ANSWER_S)

    def drop(self, why: str) -> None:
        """Begin nothing of what waits to be sent."""
        while self._wishes:
            self._wishes.popleft().promise.refuse(Refused(409, why, code="cancelled"))

    def _go(self) -> None:
        """Send what waits: by the lease, or the first of it to get one."""
        while self._wishes and self._taking is None:
            wish = self._wishes[0]
            if wish.timed and self._hold is None and self._heard_s() <= self._begun:
                return  # its date would be before that of our last lease; the joints are heard again in a moment
            self._wishes.popleft()
            if self._hold is None:
                self._taking = wish
            self._send(wish, self._hold)

    def _heard_s(self) -> float:
        joints = self._robot.snapshot.joints
        return inf if joints is None else joints.arrived

    def _send(self, wish: _Wish, hold: _Hold | None) -> None:
        if hold is not None:
            hold.sent = self._robot.now()
            said = replace(wish.command, lease=hold.lease)
        else:
            self._begun = self._robot.now()
            said = replace(wish.command, asked_s=min(self._heard_s(), self._begun) if wish.timed else None)
        promise = self._robot.follow("move", said, ANSWER_S)
        promise.add_done_callback(lambda done: self._answered(wish, hold, done))

    def _answered(self, wish: _Wish, hold: _Hold | None, done: "Future[Any]") -> None:
        if hold is None:
            self._taking = None
        try:
            reply = answer_of("move", done.result())
        except Refused as err:
            reply = refused(Reason(err.code, err.message))
        if reply.accepted:
            self._accepted(hold, reply)
            wish.promise.keep(None)
        else:
            self._refused(wish, hold, reply)
        self._go()

    def _refused(self, wish: _Wish, hold: _Hold | None, reply: CommandReply) -> None:
        """Ask anew, if the motors arrived just then; whatever else ended the lease ends what was asked by it."""
        dead = hold is not None and reply.code == "dead_lease"
        if dead and self._hold is hold:
            self._hold = None
        if dead and reply.cause == "done" and wish.releases == self._releases and wish.tries < MOST_TRIES:
            wish.tries += 1
            self._wishes.appendleft(wish)
        else:
            wish.promise.refuse(Refused(409, reply.why))

    def _accepted(self, hold: _Hold | None, reply: CommandReply) -> None:
        now = self._robot.now()
        if hold is None:
            hold = self._hold = _Hold(reply.lease, reply.goal, sent=now, heard=now)
        hold.heard = now
        hold.goal = reply.goal or hold.goal
        if self._hold is hold and (ended := self._ended.get(hold.goal)) is not None:
            self._finish(ended)

    def _renewed(self, hold: _Hold, done: "Future[Any]") -> None:
        hold.renewals -= 1
        if self._hold is not hold:
            return
        try:
            reply = answer_of("move", done.result())
        except Refused:
            return  # silence is seen by `heard`
        if reply.accepted:
            hold.heard = self._robot.now()
        else:
            self._hold = None  # how it ended is told by its result

    def _note(self, result: GoalResult) -> None:
        self._ended[result.goal] = result
        while len(self._ended) > MOST_ENDED:
            self._ended.popitem(last=False)
        if self._hold is not None and result.goal == self._hold.goal:
            self._finish(result)

    def _finish(self, result: GoalResult) -> None:
        self._hold = None
        if result.result not in PLANNED:
            self._lost(result.reason or result.result)

    def _over(self, why: str) -> None:
        self._hold = None
        self._lost(why)


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
