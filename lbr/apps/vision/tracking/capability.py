"""Tracking as a capability: searches the pictures of the head's camera on request, and turns the head to the target."""

from dataclasses import dataclass
from functools import partial
from math import inf, radians

from lbr.apps.vision.direction import Angles
from lbr.apps.vision.eye import Eye, Look, camera_off
from lbr.apps.vision.finding import check, finder, load
from lbr.apps.vision.glance import Glance
from lbr.apps.vision.looking import Looking
from lbr.apps.vision.sketch import sketch
from lbr.apps.vision.tracking.control import AHEAD, Tuning, ahead_again, clamped, follow
from lbr.apps.vision.tracking.gaze import Gaze
from lbr.apps.vision.tracking.head_client import HeadClient, Neck
from lbr.apps.vision.tracking.kind import TrackingSettings
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context, Received
from lbr.errors import InputError
from lbr.messages.codes import Reason
from lbr.messages.joints import Joint, JointsState
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.tracking import LookCommand, TrackCommand, TrackingState

STATE_EVERY_S, FOLLOWING_HZ, IDLE_HZ = 0.95, 30.0, 10.0
JOINTS_CURRENT_S = 0.5
ANSWER_S = 1.2
"""The longest wait for the eye before an answer. A sender waits 2 s, and the eye may take longer on a busy machine."""
ROUND_S = 0.5
"""The longest time between two rounds for which the head turns ahead."""


@dataclass(slots=True)
class _Following:
    """The order under way; `call` is answered once the head is leased and the eye is ready."""

    command: TrackCommand
    mover: HeadClient
    looking: Looking
    gaze: Gaze
    call: Call | None
    aim: Angles
    turned_s: float


class Tracking(Capability[TrackingSettings]):
    """Turns the head to the target, until any stop, or until nothing was seen for long."""

    rate_hz = FOLLOWING_HZ
    woken_by_streams = False

    def __init__(self, ctx: Context[TrackingSettings]) -> None:
        super().__init__(ctx)
        self._following: _Following | None = None
        self._glance = Glance(ctx, sketch)
        self._last = TrackingState(following=False)
        self._publish_at = -inf
        self._warned = ""

    def open(self) -> None:
        """Load OpenCV: loading it later would make the process silent while it holds the head."""
        load()
        self._publish_at = -inf

    def step(self) -> None:
        """Search new pictures, and move the head."""
        if self._following is not None:
            self._go_on(self._following)
        self._glance.step()
        if self.ctx.clock() >= self._publish_at:
            self._publish_state()
        self.rate_hz = FOLLOWING_HZ if self._following is not None else IDLE_HZ

    def command(self, call: Call) -> None:
        """Answer `track`, `look` and `stop`."""
        if isinstance(call.message, TrackCommand):
            try:
                self._begin(call, call.message)
            except InputError as err:
                call.refuse(str(err), err.code)
        elif isinstance(call.message, LookCommand):
            self._glance.ask(call, call.message)
        elif isinstance(call.message, StopCommand):
            said = f": {call.message.reason}" if call.message.reason else ""
            self._end(Reason("stopped", f"stopped by {call.source}{said}"))
            call.reply(CommandReply(accepted=True, reason="stopped"))
        else:
            super().command(call)

    def close(self) -> None:
        """End the tracking; the head holds."""
        self._end(Reason("shutting_down", "tracking is shutting down"))

    def _begin(self, call: Call, command: TrackCommand) -> None:
        if self._following is not None:
            raise InputError(f"the head follows a {self._following.command.target} already; stop that first", "busy")
        settings = self.ctx.settings
        missing = {settings.yaw_joint, settings.pitch_joint} - {joint.name for joint in self.ctx.rows(Joint)}
        if missing:
            raise InputError(
                f"there is no row for joint {', '.join(sorted(missing))}; see the settings of {self.ctx.name}",
                "unknown_name",
            )
        if why := camera_off(self.ctx.latest("camera")):
            raise InputError(why, "unreachable")
        check(settings, command.target)
        gaze, now = Gaze(), self.ctx.clock()
        self._follow_head(gaze, self._joints())
        pose = gaze.at(now)
        aim = clamped(pose.angles if pose is not None else AHEAD, self._tuning())
        neck = Neck(settings.yaw_joint, settings.pitch_joint, settings.speed_rps, settings.torque)
        mover = HeadClient(self.ctx, neck, aim, call.arrived)
        eye = Eye(partial(finder, settings, command.target), self.ctx.wake)
        self._following = _Following(command, mover, Looking(self.ctx, eye), gaze, call, aim, turned_s=now)

    def _joints(self) -> Received:
        """Return the last state of the joints; raise InputError if it is too old."""
        received = self.ctx.latest("joints")
        if received is None or not received.age_s(self.ctx.clock()) <= JOINTS_CURRENT_S:
            raise InputError("the joints have not been reported for a while; see /report/joints", "stale_sensor")
        return received

    def _go_on(self, following: _Following) -> None:
        now = self.ctx.clock()
        for received in self.ctx.take("joints"):
            self._follow_head(following.gaze, received)
        for look in following.looking.take(now):
            self._see(following, look, now)
        self._look_around(following, now)
        following.mover.look(following.aim)
        if following.call is not None and following.mover.holds:
            self._answer(following, following.call, now)
        blind = following.looking.eye.trouble
        if (
            why := (Reason("failed", blind) if blind else None)
            or following.mover.ended
            or self._given_up(following, now)
        ):
            self._end(why)
        else:
            self._complain(following.looking.trouble(now))

    def _follow_head(self, gaze: Gaze, received: Received) -> None:
        settings, state = self.ctx.settings, received.message
        assert isinstance(state, JointsState)
        yaw, pitch = (state.joints.get(name) for name in (settings.yaw_joint, settings.pitch_joint))
        gaze.add(yaw, pitch, received.arrived)

    def _see(self, following: _Following, look: Look, now: float) -> None:
        if look.seen is not None and following.looking.counts(look, now):
            pose = following.gaze.at(look.taken_s)
            if pose is not None:
                following.aim = follow(following.aim, pose, look.seen, self._tuning())
        self._publish_state()

    def _look_around(self, following: _Following, now: float) -> None:
        """Turn ahead slowly if pictures come, but nothing was seen for a while."""
        since_s = min(now - following.turned_s, ROUND_S)
        following.turned_s = now
        lost = now - max(following.looking.seen_s, following.looking.began_s) > self.ctx.settings.lost_s
        if lost and following.looking.has_pictures(now):
            following.aim = ahead_again(following.aim, self.ctx.settings.ahead_rps * since_s, self._tuning())

    def _given_up(self, following: _Following, now: float) -> Reason | None:
        limit_s = self.ctx.settings.give_up_s
        if now - max(following.looking.seen_s, following.looking.began_s) <= limit_s:
            return None
        lost = f"no {following.command.target} was seen for {limit_s:g} s (setting `give_up_s`)"
        return Reason("stale_sensor", lost)

    def _complain(self, why: str) -> None:
        if why != self._warned:
            self._warned = why
            if why:
                self.ctx.warn(why, "stale_sensor")
            else:
                self.ctx.ready()
            self._publish_state()

    def _answer(self, following: _Following, call: Call, now: float) -> None:
        """Answer that the head follows, or will; a sender counts a late answer as a failure."""
        if not (following.looking.eye.ready or now - following.looking.began_s >= ANSWER_S):
            return
        following.call = None
        loading = "" if following.looking.eye.ready else " as soon as its eye is ready"
        text = f"the head follows a {following.command.target}{loading}"
        self.ctx.event("tracking_began", f"{call.source}: {text}", code="done", about=call.source)
        self._publish_state()
        call.reply(CommandReply(accepted=True, reason=text))

    def _end(self, why: Reason) -> None:
        following, self._following = self._following, None
        if following is None:
            return
        following.looking.close()
        following.mover.release(why.text)
        if following.call is not None:
            following.call.refuse(why)
        else:
            text = f"the head follows no {following.command.target} any more: {why}"
            self.ctx.event("tracking_ended", text, code=why.code)
        self._last = TrackingState(following=False, target=following.command.target, reason=why.text)
        self._complain("")
        self._publish_state()

    def _tuning(self) -> Tuning:
        settings = self.ctx.settings
        limits = {joint.name: (joint.lower_rad, joint.upper_rad) for joint in self.ctx.rows(Joint)}
        return Tuning(
            yaw_limits=limits[settings.yaw_joint],
            pitch_limits=limits[settings.pitch_joint],
            field_rad=radians(settings.field_deg),
            dead_zone=settings.dead_zone,
            gain=settings.gain,
        )

    def _publish_state(self) -> None:
        now = self.ctx.clock()
        self._publish_at = now + STATE_EVERY_S
        self.ctx.publish("state", self._last if self._following is None else self._state(self._following, now))

    def _state(self, following: _Following, now: float) -> TrackingState:
        looking = following.looking
        seen = looking.last.seen if looking.last is not None else None
        return TrackingState(
            following=True,
            target=following.command.target,
            seen=seen,
            age_s=looking.age_s(now),
            yaw_rad=round(following.aim.yaw_rad, 4),
            pitch_rad=round(following.aim.pitch_rad, 4),
            pictures_hz=looking.pictures_hz(now),
            reason=following.looking.trouble(now) or ("" if seen is not None else "it is not in the picture"),
        )
