"""The base, moved for one client of the old API at a time: by a lease that is renewed while that client sends requests.

Everything here runs in the capability's loop.
"""

from dataclasses import dataclass
from math import inf

from msgspec import structs

from lbr.apps.http import names
from lbr.apps.web.bridge import until
from lbr.apps.web.face import Refused, Request
from lbr.apps.web.robot import Robot
from lbr.leases.client import RENEW_S, LeaseClient, LeaseTarget
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply, StopCommand
from lbr.robots.lbr.original.heartbeat import Heartbeat
from lbr.robots.lbr.original.wishes import PORTS, Asked, Motion

TTL_S = 0.5
"""The time until the base stops after this process dies; two threads share its interpreter."""
STOP_S = 1.0
REST_S = 1.0
"""The silence of a client whose motion another has stopped, before it may move the base again; or it sends a stop."""
STEP_S = 0.2
"""The longest step that counts as silence: a process that was held up read no requests meanwhile."""
STOPPED = frozenset({"stopped", "estop", "taken_over"})
MOST_TRIES = 3
TARGETS = {
    port: LeaseTarget(
        port, "halt", "drive", "the drive does not answer; the base has stopped by itself", TTL_S + RENEW_S
    )
    for port in PORTS.values()
}


@dataclass(frozen=True, slots=True)
class Client:
    """A client: its address, its token if it has one, and the name of its program."""

    address: str
    token: str
    agent: str

    @classmethod
    def of(cls, request: Request) -> "Client":
        """Return the client of a request."""
        return cls(names.peer_name(request.client.address), request.client.name, request.headers.get("user-agent", ""))

    def is_alive_by(self, asker: "Client") -> bool:
        """Return whether a request is a sign of life of this client: its token, or no token and the same program."""
        if asker.address != self.address:
            return False
        return asker.token == self.token if asker.token else asker.agent == self.agent

    def __str__(self) -> str:
        return f"{self.token} at {self.address}" if self.token else self.address


@dataclass(eq=False, slots=True)
class Hold:
    """The motion of the base now, its client, and that client's heartbeat."""

    client: Client
    motion: Motion
    lease: LeaseClient
    heartbeat: Heartbeat


class Driver:
    """Moves the base for one client, until that one stops, falls silent, or the motion is over."""

    def __init__(self, robot: Robot, heartbeat_s: float, unattended_s: float) -> None:
        self._robot = robot
        self._heartbeat_s = heartbeat_s
        self._unattended_s = unattended_s
        self._hold: Hold | None = None
        self._asking = False
        self._given_up = (0, "")  # the number of times, and the last reason
        self._stopped_s = -inf
        self._rests: Client | None = None
        self._silent_s = 0.0  # for how long the client that must rest has been silent
        self._stepped_s = -inf
        self.begun = -inf
        """The time of the last accepted motion."""

    @property
    def holder(self) -> str:
        """Return the client for which the base moves; empty without one."""
        return str(self._hold.client) if self._hold is not None else ""

    def beat(self, client: Client) -> None:
        """Count a request as a sign of life of a client."""
        if self._hold is not None and self._hold.client.is_alive_by(client):
            self._hold.heartbeat.beat(self._robot.now())

    async def move(self, client: Client, asked: Asked, came_s: float = inf) -> None:
        """Start this motion; return once the drive has accepted it, else raise Refused with the reason.

        A request from before a stop that is read only after it begins nothing; `came_s` is its arrival.
        """
        assert asked.motion is not None
        before = self._given_up
        if came_s <= self._stopped_s:
            raise Refused(409, before[1], code="stopped")
        self._refuse_unrested(client)
        await until(lambda: not self._asking or self._given_up != before)
        self._refuse_given_up(before)
        hold = self._hold
        if hold is not None and not hold.client.is_alive_by(client):
            raise Refused(409, f"held by {hold.client}; stop it first", code="held")
        if hold is not None and hold.motion == asked.motion and hold.lease.holds:
            hold.heartbeat.beat(self._robot.now())
            return
        self._asking = True
        try:
            await self._ask(client, asked.motion, self._heartbeat(bounded=asked.bounded), before)
            self.begun = self._robot.now()
        finally:
            self._asking = False

    async def stop(self, client: Client, why: str, came_s: float = inf) -> None:
        """Stop every motion, of any sender; return once that was acknowledged, else raise Refused."""
        if self._rests is not None and self._rests.is_alive_by(client):
            self._rests = None
        self.give_up(why, client, came_s)
        asked = self._robot.ctx.ask("halt", StopCommand(reason=why[:200], whole=True), STOP_S)
        await until(lambda: asked.answers() is not None)
        answers = asked.answers() or {}
        if not answers:
            raise Refused(503, "'halt' is wired to nothing by channel rows", code="wiring")
        for name, answer in answers.items():
            if answer is None:
                raise Refused(503, f"'{name}' does not answer", {"Retry-After": "1"})
            if not answer.accepted:
                raise Refused(409, answer.why)

    def stop_own(self, client: Client, why: str) -> None:
        """Stop a client's motion."""
        if self._hold is not None and self._hold.client.is_alive_by(client):
            self.give_up(why, client)

    def give_up(self, why: str, by: Client | None = None, came_s: float = inf) -> None:
        """Give up the motion, and motions that have not begun; `by` is the client that requests it."""
        self._given_up = (self._given_up[0] + 1, why)
        self._stopped_s = max(self._stopped_s, min(came_s, self._robot.now()))
        hold, self._hold = self._hold, None
        if hold is None:
            return
        hold.lease.release(why)
        if by is None or not hold.client.is_alive_by(by):
            self._rests, self._silent_s = hold.client, 0.0

    def step(self, now: float) -> None:
        """Read replies, renew the lease, and stop motion that has lost its client."""
        self._silent_s += min(now - self._stepped_s, STEP_S)
        self._stepped_s = now
        hold = self._hold
        if hold is None:
            return
        for result in self._robot.moved:
            hold.lease.hear(result)
        hold.lease.step()
        ended = hold.lease.ended
        if hold.heartbeat.is_lost(now):
            self._lose(hold, now)
        elif ended is not None and not self._asking:
            self._hold = None
            if ended.code in STOPPED:
                self._rests, self._silent_s = hold.client, 0.0
        else:
            hold.lease.keep(_timed(hold.motion))

    def _lose(self, hold: Hold, now: float) -> None:
        why = f"its client {hold.client} was silent for {hold.heartbeat.silent_s(now):.1f} s"
        self._given_up = (self._given_up[0] + 1, why)
        self._hold = None
        if hold.lease.ended is None:
            hold.lease.release(why, lost=True)
            self._robot.ctx.event("client_lost", f"the base was stopped: {why}", level="warning", code="holder_gone")

    async def _ask(self, client: Client, motion: Motion, heartbeat: Heartbeat, before: tuple[int, str]) -> None:
        """Begin, or continue under the present lease; retry if that has just ended."""
        why: Reason | None = None
        for _ in range(MOST_TRIES):
            hold = self._hold
            changes = hold is not None and hold.lease.holds
            why = await (self._change if changes else self._begin)(client, motion, heartbeat)
            self._refuse_given_up(before)
            if why is None or not (changes and why.code in {"dead_lease", "done"}):
                break
            self._hold = None
        if why is not None and why.code != "done":  # a range that is reached already needs no motion
            raise Refused(503 if why.code in {"unreachable", "wiring"} else 409, why)

    async def _begin(self, client: Client, motion: Motion, heartbeat: Heartbeat) -> Reason | None:
        lease = LeaseClient(self._robot.ctx, TARGETS[PORTS[type(motion)]], _timed(motion))
        hold = self._hold = Hold(client, motion, lease, heartbeat)
        await until(lambda: self._hold is not hold or _answered(lease))
        if lease.accepted is not None:
            return None
        if self._hold is hold:
            self._hold = None
        return lease.ended or Reason("cancelled", "it was given up")

    async def _change(self, client: Client, motion: Motion, heartbeat: Heartbeat) -> Reason | None:
        """Quote the lease for another motion; a refusal ends the present one."""
        assert self._hold is not None
        assert self._hold.lease.accepted is not None
        held = structs.replace(self._hold.lease.accepted, goal="")
        lease = LeaseClient(self._robot.ctx, TARGETS[PORTS[type(motion)]], given=held)
        asked = lease.send(_timed(motion))
        assert asked is not None
        hold = self._hold = Hold(client, motion, lease, heartbeat)
        await until(lambda: self._hold is not hold or asked.answers() is not None)
        reply = next(iter((asked.answers() or {}).values()), None)
        if self._hold is not hold:
            return Reason("cancelled", "it was given up")
        if not isinstance(reply, CommandReply):
            return Reason("unreachable", "the drive does not answer")
        if reply.accepted:
            return None
        if reply.code == "dead_lease" and reply.cause not in STOPPED:
            return Reason("dead_lease", reply.why.text)
        if reply.code == "dead_lease":
            self._rests, self._silent_s = client, 0.0
        lease.step()  # it halts unwanted motion
        self._hold = None
        return reply.why

    def _heartbeat(self, *, bounded: bool) -> Heartbeat:
        return Heartbeat(self._robot.now(), self._heartbeat_s, self._unattended_s if bounded else 0.0)

    def _refuse_given_up(self, before: tuple[int, str]) -> None:
        if self._given_up != before:
            raise Refused(409, self._given_up[1], code="stopped")

    def _refuse_unrested(self, client: Client) -> None:
        """Refuse a new motion for a client that keeps asking although another has stopped it."""
        if self._rests is None or not self._rests.is_alive_by(client):
            return
        if self._silent_s >= REST_S:
            self._rests = None
            return
        self._silent_s = 0.0
        text = f"stopped by another meanwhile: send level 0, or nothing for {REST_S:g} s"
        raise Refused(409, text, code="rest_first")


def _timed(motion: Motion) -> Motion:
    return structs.replace(motion, ttl_s=TTL_S)


def _answered(lease: LeaseClient) -> bool:
    lease.step()
    return lease.accepted is not None or lease.ended is not None
