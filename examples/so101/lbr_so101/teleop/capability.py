"""Teleoperation as a capability: reads the leader fifty times a second, and moves the follower's joints to it."""

from dataclasses import dataclass, field
from math import inf, isfinite

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.leases.client import LeaseClient, LeaseTarget
from lbr.messages.codes import Reason
from lbr.messages.drive import LoopStatistics
from lbr.messages.joints import Joint, JointsCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.operations.statistics import LoopMeter
from lbr_so101.teleop import Phase, TeleopCommand, TeleopSettings, TeleopState
from lbr_so101.teleop.follow import Pose, gap_rad, phase_after, pose_of

RATE_HZ = 50.0
STATE_EVERY_S = 0.2
JOINTS = LeaseTarget("move", "halt", "joints operation", "the follower's joints do not answer; they hold by themselves")


@dataclass(slots=True)
class _Following:
    """The following under way; `call` waits for the answer until the follower's lease is granted."""

    lease: LeaseClient
    call: Call | None
    phase: Phase = "approaching"
    gap_rad: float = inf
    sent: int = 0
    meter: LoopMeter = field(default_factory=lambda: LoopMeter(RATE_HZ))
    loop: LoopStatistics | None = None


class Teleop(Capability[TeleopSettings]):
    """Follows the leader.

    At an orderly end the follower holds. If the leader or this is lost, it goes limp slowly after its `hold_s`.
    """

    rate_hz = RATE_HZ
    woken_by_streams = False

    def __init__(self, ctx: Context[TeleopSettings]) -> None:
        super().__init__(ctx)
        self._following: _Following | None = None
        self._ended = TeleopState(phase="idle")
        self._tell_at = -inf

    def open(self) -> None:
        """Begin without following."""
        self._tell_at = -inf

    def step(self) -> None:
        """Send the follower to the leader's pose."""
        if self._following is not None:
            self._go_on(self._following)
        if self.ctx.clock() >= self._tell_at:
            self._tell()

    def command(self, call: Call) -> None:
        """Answer `begin` and `stop`."""
        if isinstance(call.message, TeleopCommand):
            self._begin(call)
        elif isinstance(call.message, StopCommand):
            said = f": {call.message.reason}" if call.message.reason else ""
            self._end(Reason("stopped", f"stopped by {call.source}{said}"))
            call.reply(CommandReply(accepted=True, reason="stopped"))
        else:
            super().command(call)

    def close(self) -> None:
        """Have the follower hold."""
        self._end(Reason("shutting_down", "teleoperation is shutting down"))

    def _begin(self, call: Call) -> None:
        if self._following is not None:
            call.refuse("the follower follows already; stop that first", "busy")
            return
        pose = self._pose()
        if isinstance(pose, Reason):
            call.refuse(pose)
            return
        first = self._command(pose, "approaching", asked_s=call.arrived)
        self._following = _Following(LeaseClient(self.ctx, JOINTS, first), call)

    def _go_on(self, following: _Following) -> None:
        following.lease.step()
        pose = self._pose()
        if following.lease.ended is not None:
            self._end(following.lease.ended)
        elif isinstance(pose, Reason):
            self._end(pose, lost=True)
        elif following.lease.holds and self.ctx.on_tick:
            self._send(following, pose)

    def _send(self, following: _Following, pose: Pose) -> None:
        newest = self.ctx.latest("follower")
        following.gap_rad = gap_rad(pose, newest.message if newest is not None else None)
        before, following.phase = following.phase, phase_after(following.phase, following.gap_rad, self.ctx.settings)
        if following.lease.send(self._command(pose, following.phase)) is not None:
            following.sent += 1
            following.loop = following.meter.round(self.ctx.clock()) or following.loop
        if (call := following.call) is not None:
            following.call = None
            text = "the follower goes slowly to where the leader is, then with it; s ends it"
            self.ctx.event("teleop_began", f"{call.source}: {text}", code="done", about=call.source)
            call.reply(CommandReply(accepted=True, reason=text))
        if before != following.phase:
            how = (
                "is with the leader and follows it" if following.phase == "following" else "is far away and approaches"
            )
            self.ctx.event("teleop", f"the follower {how}")
            self._tell()

    def _pose(self) -> Pose | Reason:
        newest = self.ctx.latest("leader")
        age_s = inf if newest is None else newest.age_s(self.ctx.clock())
        return pose_of(newest.message if newest else None, age_s, self.ctx.rows(Joint), self.ctx.settings)

    def _command(self, pose: Pose, phase: Phase, asked_s: float | None = None) -> JointsCommand:
        speed_rps = self.ctx.settings.approach_rps if phase == "approaching" else None
        return JointsCommand(
            positions=dict(pose), join=True, stay=True, interpolation="linear", speed_rps=speed_rps, asked_s=asked_s
        )

    def _end(self, why: Reason, *, lost: bool = False) -> None:
        following, self._following = self._following, None
        if following is None:
            return
        following.lease.release(why.text, lost=lost)
        if following.call is not None:
            following.call.refuse(why)
        else:
            level = "warning" if lost else "info"
            self.ctx.event("teleop_ended", f"the follower follows no more: {why}", level=level, code=why.code)
        self._ended = TeleopState(
            phase="idle", sent=following.sent, loop=following.loop, reason=why.text, code=why.code
        )
        self._tell()

    def _tell(self) -> None:
        self._tell_at = self.ctx.clock() + STATE_EVERY_S
        now = self._following
        if now is None:
            self.ctx.publish("state", self._ended)
            return
        gap = round(now.gap_rad, 4) if isfinite(now.gap_rad) else None
        self.ctx.publish("state", TeleopState(phase=now.phase, gap_rad=gap, sent=now.sent, loop=now.loop))
