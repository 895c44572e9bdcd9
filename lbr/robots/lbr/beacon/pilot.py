"""The manoeuvre's view and control of the robot, by a lease of the drive for its duration."""

from collections.abc import Collection
from math import inf

from msgspec.structs import replace

from lbr.capability.context import Context
from lbr.leases.holder import FINAL, TARGETS, Holder
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, DriveState, TurnCommand
from lbr.robots.lbr.beacon import BeaconSettings
from lbr.robots.lbr.beacon.senses import BlindError, Senses
from lbr.robots.lbr.beacon.view import Action, Back, Ending, Go, Turn, View

BACK_DEG = 180.0
DRIVE_S = 1.0
"""The age limit of the drive's state, which comes ten times a second."""


class Pilot:
    """Moves the robot for a manoeuvre, from `begin` on; `stopped` has the sender of a later stop, even of a standing
    robot."""

    def __init__(self, ctx: Context[BeaconSettings]) -> None:
        self.stopped: Reason | None = None
        self._ctx = ctx
        self._senses = Senses(ctx, ctx.settings.heading_deg)
        self._holder = Holder(ctx)
        self._steers = -1.0 if ctx.settings.reverse_steering == "travel" else 1.0
        self._action: Action | None = None
        self._broken: Ending | None = None
        self._began_s = inf
        self._own: Collection[str] = ()

    @property
    def rest_voltage_v(self) -> float | None:
        """Return the battery's voltage without load, None if it is unknown."""
        battery = self._senses.battery()
        return battery.rest_voltage_v if battery is not None else None

    def begin(self, holder: str) -> None:
        """Begin a manoeuvre for a holder, whose own stops do not end it."""
        self.stopped, self._action, self._broken = None, None, None
        self._began_s, self._own = self._ctx.clock(), {"", self._ctx.name, holder}

    def listen(self) -> None:
        """Process arrived messages, and renew the motion."""
        self._senses.listen()
        self._holder.step([received.message for received in self._ctx.take("results")])
        for received in self._ctx.take("drive"):
            state: DriveState = received.message
            for at, who in ((state.stopped_s, state.stopped_by), (state.halted_s, state.halted_by)):
                if self.stopped is None and at is not None and at > self._began_s and who not in self._own:
                    named = state.code == "stopped" and who == state.stopped_by
                    self.stopped = Reason("stopped", state.reason if named else f"stopped by {who}")

    def look(self) -> View:
        """Return the view now; raise BlindError if a part of it is unknown."""
        drive, now = self._ctx.latest("drive"), self._ctx.clock()
        if drive is None or not drive.age_s(now) <= DRIVE_S:
            raise BlindError("the drive does not say whether the robot was stopped: it is silent")
        battery = self._senses.battery()
        return View(
            time_s=now,
            direction_deg=self._senses.direction_deg(),
            forward_m=self._senses.metres("forward"),
            back_m=self._senses.metres("back"),
            beams=self._senses.beams(),
            charging=battery.charging if battery else None,
            ending=self._ending(),
        )

    def do(self, action: Action) -> None:
        """Begin an action, or continue it; to be called ten times a second."""
        goes_on = action is self._action
        self._action = action
        if goes_on:
            return
        command = self._command(action)
        if command is not None:
            self._broken = None
            self._holder.begin(TARGETS[type(command)], replace(command, ttl_s=self._ctx.settings.ttl_s))
        elif self._holder.lease is not None:
            self.halt("this part of the way is done")

    def break_off(self, why: str) -> None:
        """Stop; the manoeuvre gets the reason when it continues."""
        if self._holder.lease is not None:
            self._broken = Ending(good=False, text=why, code="stale_sensor")
            self.halt(why)

    def halt(self, why: str) -> None:
        """Stop."""
        self._holder.release(why)

    def _ending(self) -> Ending | None:
        if self._broken is not None:
            return self._broken
        good, why = self._holder.good, self._holder.ended
        if why is None:
            return None
        final = not good and (why.code in FINAL or why.code == "unreachable")
        return Ending(good=good, text=why.text, code=why.code, final=final)

    def _command(self, action: Action) -> DriveCommand | TurnCommand | None:
        match action:
            case Turn(angle_deg=angle_deg):
                return TurnCommand(angle_deg=round(angle_deg, 1))
            case Go(power=power, distance_m=distance_m):
                angle_deg = 0.0 if distance_m >= 0.0 else BACK_DEG
                distance_cm = max(1.0, round(abs(distance_m) * 100, 1))
                return DriveCommand(power=power, angle_deg=angle_deg, distance_cm=distance_cm)
            case Back(power=power, steer_deg=steer_deg):
                return DriveCommand(power=power, angle_deg=BACK_DEG - self._steers * steer_deg)
        return None
