"""Sighting as a capability: searches a camera's pictures on request, and reports the target's direction."""

from dataclasses import dataclass
from functools import partial
from math import atan, cos, degrees, inf, pi, radians, remainder, sin, tan

from lbr.apps.vision.direction import Angles, direction, radius_rad
from lbr.apps.vision.eye import Eye, camera_off
from lbr.apps.vision.finding import check, finder
from lbr.apps.vision.glance import Glance
from lbr.apps.vision.looking import Looking
from lbr.apps.vision.sighting.kind import SightingSettings
from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.leases import CommandReply
from lbr.messages.sighting import SightingState, WatchCommand
from lbr.messages.tracking import LookCommand, Seen, Target

STATE_EVERY_S, RESTING_EVERY_S = 0.2, 1.0
LEAST_WIDE_RAD = 1e-3


@dataclass(slots=True)
class _Watch:
    """The target, and the end of the search."""

    target: Target
    looking: Looking
    until_s: float


class Sighting(Capability[SightingSettings]):
    """Searches for one target at a time; without a request it reads no picture, and the camera may rest."""

    rate_hz = 2.0

    def __init__(self, ctx: Context[SightingSettings]) -> None:
        super().__init__(ctx)
        self._watch: _Watch | None = None
        self._glance = Glance(ctx)
        self._why = ""
        self._publish_at = -inf
        self._warned = ""

    def step(self) -> None:
        """Search new pictures, and report."""
        if self._watch is not None:
            self._go_on(self._watch)
        self._glance.step()
        if self.ctx.clock() >= self._publish_at:
            self._publish_state()

    def command(self, call: Call) -> None:
        """Answer `watch` and `look`."""
        if isinstance(call.message, LookCommand):
            self._glance.ask(call, call.message)
            return
        if not isinstance(call.message, WatchCommand):
            super().command(call)
            return
        try:
            answer = self._asked(call.message)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        self._publish_state()
        call.reply(CommandReply(accepted=True, reason=answer))

    def close(self) -> None:
        """End the search."""
        self._end("sighting is shutting down")

    def _asked(self, command: WatchCommand) -> str:
        if command.seconds == 0.0:
            self._end("nobody asks for it")
            return "looks for nothing"
        check(self.ctx.settings, command.target)
        if why := camera_off(self.ctx.latest("camera")):
            raise InputError(why, "unreachable")
        now = self.ctx.clock()
        watch = self._watch
        if watch is None or watch.target != command.target:
            self._end("")
            eye = Eye(partial(finder, self.ctx.settings, command.target), self.ctx.wake)
            watch = self._watch = _Watch(command.target, Looking(self.ctx, eye), until_s=now)
        watch.until_s = max(watch.until_s, now + command.seconds)
        return f"looks for a {watch.target} for {watch.until_s - now:.0f} s"

    def _go_on(self, watch: _Watch) -> None:
        now = self.ctx.clock()
        if watch.looking.take(now):
            self._publish_at = now
        if watch.looking.eye.trouble:
            self._end(watch.looking.eye.trouble)
            self._complain(self._why)
        elif now >= watch.until_s:
            self._end("nobody asks for it any more")
        else:
            self._complain(watch.looking.trouble(now))

    def _end(self, why: str) -> None:
        watch, self._watch, self._why = self._watch, None, why
        if watch is not None:
            watch.looking.close()
            self._publish_at = -inf
        self._complain("")

    def _complain(self, why: str) -> None:
        if why != self._warned:
            self._warned = why
            if why:
                self.ctx.warn(why, "stale_sensor")
            else:
                self.ctx.ready()

    def _publish_state(self) -> None:
        now = self.ctx.clock()
        self._publish_at = now + (RESTING_EVERY_S if self._watch is None else STATE_EVERY_S)
        self.ctx.publish(
            "state", SightingState(watching=False, reason=self._why) if self._watch is None else self._state(now)
        )

    def _state(self, now: float) -> SightingState:
        watch = self._watch
        assert watch is not None
        looking = watch.looking
        seen = looking.last.seen if looking.last is not None and looking.counts(looking.last, now) else None
        return SightingState(
            watching=True,
            target=watch.target,
            left_s=round(max(0.0, watch.until_s - now), 1),
            seen=seen is not None,
            age_s=looking.age_s(now),
            pictures_hz=looking.pictures_hz(now),
            reason=looking.trouble(now) or ("" if seen is not None else "it is not in the picture"),
            **(where(seen, self.ctx.settings) if seen is not None else {}),
        )


def where(seen: Seen, settings: SightingSettings) -> dict[str, float | None]:
    """Return the direction, apparent width and distance of a target, as fields of the state."""
    field_rad = radians(settings.field_deg)
    camera = Angles(radians(settings.yaw_deg), radians(settings.pitch_deg))
    centre = direction(camera, seen, field_rad)
    aside = direction(Angles(0.0, 0.0), seen, field_rad)
    off_axis = cos(aside.yaw_rad) * cos(aside.pitch_rad)
    half_rad = atan(tan(radius_rad(seen, field_rad)) * off_axis**2)  # away from the middle, things look stretched
    diameter_m = settings.diameter_m if half_rad > LEAST_WIDE_RAD else None
    return {
        "bearing_deg": round(-degrees(remainder(centre.yaw_rad, 2.0 * pi)), 1),
        "wide_deg": round(2.0 * degrees(half_rad), 2),
        "distance_m": round(diameter_m / 2.0 / sin(half_rad), 3) if diameter_m is not None else None,
    }
