"""The robot as docking sees and moves it, over its local door."""

import time
from math import inf
from typing import Any

from lbr.apps.autodock.motion import Motion
from lbr.apps.autodock.moves import shortest
from lbr.apps.autodock.senses import Senses
from lbr.apps.autodock.view import Action, Back, Ending, Go, Say, Turn, View
from lbr.apps.program import Robot
from lbr.bus import codec, keys, wire
from lbr.errors import BusError, MalformedError
from lbr.messages.attitude import AttitudeState
from lbr.messages.drive import DriveState
from lbr.messages.leases import StopCommand
from lbr.messages.speech import SayCommand

STOP_S = 1.0
BACK_DEG = 180.0


class Pilot:
    """Directions count from `heading_deg`, the compass's when the robot is docked; without a compass, from the first.

    `stopped` says who stopped the robot since this was asked for, also while it stood; then nothing more may begin.
    """

    def __init__(self, robot: Robot, heading_deg: float) -> None:
        self._robot = robot
        self._heading_deg = heading_deg
        self._senses = Senses(robot)
        self._zero: tuple[str, float] | None = None
        self._action: Action | None = None
        self._motion: Motion | None = None
        self._ended: Ending | None = None
        self._own_stop = (inf, -inf)
        self._heard_drive = False
        self._since_s = robot.started_s
        self.stopped = ""
        self._steers = -1.0 if _reverses_as_it_travels(robot) else 1.0

    def look(self) -> View:
        """Return what is seen now; raise BusError if the robot does not know how it lies, or was not heard yet."""
        now = time.monotonic()
        attitude = self._senses.attitude(now)
        battery, ranges = self._senses.battery(now), self._senses.ranges(now)
        for state in self._senses.drive():
            self._heard_drive = True
            self._look_for_stops(state)
        if not self._heard_drive:
            raise BusError("the drive does not say whether the robot was stopped: the capability 'drive' is silent")
        for result in self._senses.results():
            if self._motion is not None:
                self._motion.hear(result)
        return View(
            time_s=now,
            direction_deg=self._direction_deg(attitude),
            forward_m=ranges.forward_m if ranges else None,
            back_m=ranges.back_m if ranges else None,
            beams=self._senses.beams(now),
            charging=battery.charging if battery else None,
            rest_voltage_v=battery.rest_voltage_v if battery else None,
            ending=self._motion.ending if self._motion else self._ended,
        )

    def do(self, action: Action) -> None:
        """Begin an action, or go on with it; to be called ten times a second."""
        goes_on = action is self._action or (isinstance(action, Back) and isinstance(self._action, Back))
        self._action = action
        command = self._command(action)
        if command is None:
            if self._motion is not None:
                self.stop()
            if isinstance(action, Say) and not goes_on:
                self._say(action)
        elif not goes_on:
            self._motion, self._ended = Motion(self._robot, *command, time.monotonic()), None
        elif self._motion is not None:
            self._motion.renew(command[1], time.monotonic())

    def break_off(self, why: str) -> None:
        """Stand still, and tell the script why."""
        if self._motion is not None:
            self._ended = Ending(good=False, text=why)
            self.stop()

    def stop(self) -> None:
        """Stand still."""
        self._motion = None
        key, asked_s = keys.port(self._robot.name, "drive", "stop"), time.monotonic()
        wire.ask(self._robot.bus, key, StopCommand(), source=self._robot.source, timeout_s=STOP_S)
        self._own_stop = (asked_s, time.monotonic())

    def _look_for_stops(self, state: DriveState) -> None:
        if self.stopped or state.stopped_s is None or not state.stopped_s > self._since_s:
            return
        self._since_s = state.stopped_s
        asked_s, answered_s = self._own_stop
        own = asked_s <= state.stopped_s <= answered_s
        if not own or state.stopped_by not in {"", self._robot.source}:
            named = state.code == "stopped"
            self.stopped = state.reason if named else f"stopped: {state.reason or 'no reason given'}"

    def _command(self, action: Action) -> tuple[str, dict[str, Any]] | None:
        match action:
            case Turn(angle_deg=angle_deg):
                return "turn", {"angle_deg": round(angle_deg, 1)}
            case Go(power=power, distance_m=distance_m):
                angle_deg = 0.0 if distance_m >= 0.0 else BACK_DEG
                distance_cm = max(1.0, round(abs(distance_m) * 100, 1))
                return "command", {"power": power, "angle_deg": angle_deg, "distance_cm": distance_cm}
            case Back(power=power, steer_deg=steer_deg):
                return "command", {"power": power, "angle_deg": BACK_DEG - self._steers * steer_deg}
        return None

    def _say(self, action: Say) -> None:
        """Say it, if there is a voice, without waiting for the answer."""
        key = keys.port(self._robot.name, "speech", "say")
        wire.put(self._robot.bus, key, SayCommand(phrase=action.phrase), source=self._robot.source)

    def _direction_deg(self, attitude: AttitudeState) -> float:
        turned_deg = attitude.turned_deg or 0.0
        if self._zero is None or self._zero[0] != attitude.epoch:
            known = attitude.heading_deg is not None
            if not known and self._zero is not None:
                raise BusError("the attitude started over, and without a compass the direction is lost")
            direction_deg = shortest((attitude.heading_deg or 0.0) - self._heading_deg) if known else 0.0
            self._zero = (attitude.epoch, turned_deg - direction_deg)
        return shortest(turned_deg - self._zero[1])


def _reverses_as_it_travels(robot: Robot) -> bool:
    """Say whether the drive lets the path, and not the robot, curve to the side that is asked for in reverse."""
    key, line = keys.console(robot.name), b"/report/settings"
    for answer in wire.ask_all(robot.bus, [key], line, source=robot.source, timeout_s=STOP_S):
        try:
            return bool(codec.decode(answer.payload)["data"]["drive"].get("reverse_steering") == "travel")
        except (MalformedError, KeyError, TypeError, AttributeError):
            continue
    return False
