"""Attitude as a capability: every sample goes through the fusion, whose state is published at a fixed rate."""

from math import cos, inf, isfinite, radians
from typing import TYPE_CHECKING

from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.messages.attitude import AttitudeState
from lbr.messages.calibration import CalibrationValue, values
from lbr.messages.leases import CommandReply
from lbr.messages.motors import RESTS_S
from lbr.operations.attitude.calibration import Calibration
from lbr.operations.attitude.gravity import Gravity
from lbr.operations.attitude.settings import AttitudeSettings
from lbr.operations.attitude.turns import Turns

if TYPE_CHECKING:
    from lbr.operations.attitude.fusion import Fusion

TELL_S = 0.5
"""The time without a valid state before the capability is degraded."""
STILL_S = 0.07
"""The period of reports of a body that does not turn: every second tick at the default rate."""
RESTS_AFTER_S, RESTING_S = 1.0, 0.5
"""After a second without a turn, or since its zero was learnt, a body that stands is reported at long periods."""
SAME_S = 0.15
"""So long after the last sample, a body at rest is as it was; a unit at rest has a sample more often."""
STANDS_RAD = radians(45.0)
"""The lean up to which a body without a base stands. A fall is one of 60 degrees, and no body gets there unnoticed."""


class Attitude(Capability[AttitudeSettings]):
    """Publishes the body's orientation and heading, watches turns, and calibrates the compass."""

    woken_by_streams = False

    def __init__(self, ctx: Context[AttitudeSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.publish_hz
        kind: type[Fusion | Gravity] = Gravity
        if ctx.settings.gyro:
            from lbr.operations.attitude import fusion  # noqa: PLC0415 - with numpy, of 8 MiB

            kind = fusion.Fusion
        self._fusion = kind(ctx.settings, values(ctx.rows(CalibrationValue)), f"{ctx.name}-{ctx.clock():.3f}")
        self._turns = Turns(ctx.settings.observe_s)
        self._calibration = Calibration(ctx, self._fusion)
        self._known_s = -inf
        self._warned = ""
        self._published: AttitudeState | None = None
        self._published_s = self._turned_s = self._felt_s = -inf
        self._on_wheels = bool(ctx.sources("drive") or ctx.targets("motion"))

    def open(self) -> None:
        """Publish a warning if the stored calibration cannot be used."""
        problem = self._fusion.calibration.problem
        if problem:
            text = f"the compass goes on uncalibrated: {problem}; calibrate it again, on wheels by `/m/200`"
            self.ctx.event("calibration_unusable", text, level="warning")

    def step(self) -> None:
        """Process the samples; publish at the fixed rate."""
        now = self.ctx.clock()
        for received in self.ctx.take("samples"):
            self._felt_s = now
            self._fusion.feel(received.message, received.arrived)
            self._calibration.take(received.message)
        if self.ctx.on_tick and not self._is_same(now):
            state = self._resting(self._fusion.state(now), now)
            if now - self._published_s >= self._period_s(state):
                self._published, self._published_s = state, now
                self.ctx.publish("state", state)
                self._calibration.published(state)
            for report in self._turns.look(state, now):
                self.ctx.event(report.kind, report.text, data=dict(report.data))
            self._tell_health(state, now)
        self._calibration.step()

    def answers(self) -> bool:
        """Return whether the orientation is known, or its absence was reported."""
        return isfinite(self._known_s) or bool(self._warned)

    def command(self, call: Call) -> None:
        """Watch a turn, calibrate, or end a calibration."""
        if call.name == "observe":
            self._observe(call)
        elif call.name == "calibrate":
            self._calibration.command(call)
        elif call.name == "stop":
            ended = self._calibration.stop(call.message.reason or f"stopped by {call.source}", "stopped")
            nothing = "" if ended or call.message.whole else "no calibration was under way"
            call.reply(CommandReply(accepted=True, reason=nothing))
        else:
            call.refuse(f"{call.name} is not understood here", "unknown_command")

    def close(self) -> None:
        """End a calibration's motion."""
        self._calibration.close()

    def _resting(self, state: AttitudeState, now: float) -> AttitudeState:
        """Return the state, with its flag if body and base are at rest, or a body without a base stands still."""
        if not (state.valid and state.still):
            self._turned_s = now if isfinite(self._known_s) else -inf
        elif now - self._turned_s >= RESTS_AFTER_S:
            return replace(state, rests=self._base_stands(now) if self._on_wheels else _stands(state))
        return state

    def _base_stands(self, now: float) -> bool:
        drive = self.ctx.latest("drive")
        return drive is not None and not drive.message.moving and drive.age_s(now) <= RESTS_S

    def _is_same(self, now: float) -> bool:
        """Return whether nothing can have changed: at rest, between two samples and before the next report."""
        rests = self._published is not None and self._published.rests and now - self._published_s < RESTING_S
        return rests and 0.0 < now - self._felt_s < SAME_S and (not self._on_wheels or self._base_stands(now))

    def _period_s(self, state: AttitudeState) -> float:
        """Return the time between the previous state and this one: 0 for a change."""
        before = self._published
        if before is None or _kind(before) != _kind(state) or not (state.valid and state.still):
            return 0.0
        return RESTING_S if state.rests else STILL_S

    def _observe(self, call: Call) -> None:
        now = self.ctx.clock()
        trouble = self._turns.watch(call.message.angle_deg, self._fusion.state(now), now)
        if trouble:
            call.refuse(trouble)
        else:
            call.reply(CommandReply(accepted=True, reason=f"a turn of {call.message.angle_deg:g} degrees is awaited"))

    def _tell_health(self, state: AttitudeState, now: float) -> None:
        if state.valid:
            self._known_s = now
            if self._warned:
                self._warned = ""
                self.ctx.ready()
        elif now - self._known_s > TELL_S and _gist(state.reason) != _gist(self._warned):
            self._warned = state.reason
            self.ctx.warn(state.reason, "stale_sensor" if isfinite(self._known_s) else "not_ready")


def _stands(state: AttitudeState) -> bool:
    return cos(state.roll_rad or 0.0) * cos(state.pitch_rad or 0.0) > cos(STANDS_RAD)


def _kind(state: AttitudeState) -> tuple[object, ...]:
    """Return the values whose change is published at once."""
    known = state.heading_deg is not None, state.magnetic, state.calibrated
    return (state.valid, state.still, state.rests, state.epoch, *known)


def _gist(reason: str) -> str:
    """Return a reason without its numbers, which change all the time."""
    return "".join(letter for letter in reason if not letter.isdigit())
