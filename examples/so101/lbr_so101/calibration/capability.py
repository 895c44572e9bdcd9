"""Calibration as a capability: watches the servos of an arm without torque, and writes joint rows; it moves nothing."""

from collections.abc import Mapping
from math import inf, isfinite

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.messages.joints import Joint, MotionStep
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.servos import ServosState
from lbr_so101.calibration import CalibrationSettings, CalibrationState, DoneCommand, ZeroCommand
from lbr_so101.calibration.sweep import Sweep, begin, beyond, learnt, moved, swept

STATE_EVERY_S = 0.2
FRESH_S = 0.3
NEXT = (
    "0 is noted. Move every joint to both of its ends by hand, first the way it counts up: pan to the right, lift, elbow and "
    "wrist down, roll clockwise as the gripper sees it, gripper open. Then say /calibrate/done; s leaves all as it was"
)


class Calibration(Capability[CalibrationSettings]):
    """Learns joint rows. It writes nothing to servos, and nothing at all before all values are known."""

    rate_hz = 50.0

    def __init__(self, ctx: Context[CalibrationSettings]) -> None:
        super().__init__(ctx)
        self._sweep: Sweep | None = None
        self._reason = ""
        self._tell_at = -inf

    def open(self) -> None:
        """Begin with nothing known."""
        self._tell_at = -inf

    def step(self) -> None:
        """Read the servos' positions."""
        if self._sweep is not None:
            self._look(self._sweep)
        if self.ctx.clock() >= self._tell_at:
            self._tell()

    def command(self, call: Call) -> None:
        """Answer `zero`, `done` and `stop`."""
        try:
            if isinstance(call.message, ZeroCommand):
                self._sweep, self._reason = begin(self._places()), ""
                call.reply(CommandReply(accepted=True, reason=NEXT))
            elif isinstance(call.message, DoneCommand):
                call.reply(CommandReply(accepted=True, reason=self._done(call.source)))
            elif isinstance(call.message, StopCommand):
                self._give_up(f"stopped by {call.source}")
                call.reply(CommandReply(accepted=True, reason="stopped"))
            else:
                super().command(call)
        except InputError as err:
            call.refuse(str(err), err.code)
        self._tell()

    def _look(self, sweep: Sweep) -> None:
        for received in self.ctx.take("servos"):
            state: ServosState = received.message
            if powered := [servo.id for servo in state.servos if servo.id in sweep and servo.torque]:
                self._give_up(f"servo {powered[0]} has torque")
                return
            try:
                self._sweep = sweep = moved(sweep, _places(state), self.ctx.settings.enough_rad)
            except InputError as err:
                self._give_up(str(err))
                return

    def _places(self) -> Mapping[int, float]:
        """Return the position of every servo; raise InputError for one that is not measured, or has torque."""
        newest = self.ctx.latest("servos")
        if newest is None or not newest.age_s(self.ctx.clock()) <= FRESH_S:
            raise InputError("the servos have not been reported for a while", "stale_sensor")
        state: ServosState = newest.message
        servos, places = {servo.id: servo for servo in state.servos}, _places(state)
        for joint in self.ctx.rows(Joint):
            servo = servos.get(joint.device_id)
            if servo is None or joint.device_id not in places:
                why = servo.reason if servo is not None else state.reason
                raise InputError(f"{joint.name} (servo {joint.device_id}) is not measured: {why}", "stale_sensor")
            if servo.torque != 0.0:
                raise InputError(
                    f"{joint.name} has torque, or its servo has not told yet: hold the arm, then take the torque off all "
                    "of it",
                    "not_possible",
                )
        return places

    def _done(self, source: str) -> str:
        if self._sweep is None:
            raise InputError(self._reason or "nothing is being calibrated: hold the arm at 0 and say /calibrate/zero")
        settings, joints = self.ctx.settings, self.ctx.rows(Joint)
        self._places()
        rows = learnt(joints, self._sweep, settings)
        if wrong := beyond(rows, self.ctx.rows(MotionStep)):
            raise InputError(
                f"with these ends a motion would go beyond its limits: {wrong}. Move the joint further, or change that "
                "motion, and say /calibrate/done again"
            )
        still = [joint.name for joint in joints if not swept(joint, self._sweep[joint.device_id], settings).enough]
        self._sweep = None
        self.ctx.learn(*rows)
        text = f"{len(rows)} joint rows were written: where 0 is, which way it counts, and the limits"
        text += f"; but only 0 of {', '.join(still)}, which hardly moved" if still else ""
        self.ctx.event("calibrated", f"{source}: {text}", code="done", about=source)
        return text

    def _give_up(self, why: str) -> None:
        if self._sweep is not None:
            self._sweep, self._reason = None, f"calibration was given up: {why}; the rows are as they were"
            self.ctx.event("calibration_ended", self._reason, level="warning")

    def _tell(self) -> None:
        self._tell_at = self.ctx.clock() + STATE_EVERY_S
        sweep, settings = self._sweep, self.ctx.settings
        found = (
            {}
            if sweep is None
            else {joint.name: swept(joint, sweep[joint.device_id], settings) for joint in self.ctx.rows(Joint)}
        )
        self.ctx.publish("state", CalibrationState(running=sweep is not None, joints=found, reason=self._reason))


def _places(state: ServosState) -> dict[int, float]:
    found = {servo.id: servo.position_rad for servo in state.servos}
    return {servo: at for servo, at in found.items() if at is not None and isfinite(at)}
