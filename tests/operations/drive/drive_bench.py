"""A drive kernel to talk to in tests: time is a variable, whatever it says is kept."""

from math import nan

from msgspec.structs import replace

from lbr.leases.lease import EstopChanged, Happened, Reply, Result, Setpoint, Stop
from lbr.messages.attitude import AttitudeState
from lbr.messages.codes import MEANINGS
from lbr.messages.drive import DriveCommand, GoalResult, HeadingCommand, TurnCommand
from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges
from lbr.operations.drive.kernel import decide, first_state
from lbr.operations.drive.settings import DriveSettings
from lbr.operations.drive.state import AttitudeSeen, Command, MotorsLost, MotorsSeen, OdometrySeen, RangesSeen, Tick

SENSORS = ("forward", "back", "left", "right", "bottom")


def motors(*, armed=True, reason="", code=""):
    return MotorsState(left=0.0, right=0.0, armed=armed, reason=reason, code=code, estop=False)


def ranges(**metres):
    """Everything over range but what is given: metres, or a status."""
    status = {sensor: metres[sensor] if isinstance(metres.get(sensor), str) else "ok" for sensor in metres}
    values = {f"{sensor}_m": None if isinstance(value, str) else value for sensor, value in metres.items()}
    absent = {f"{sensor}_m": None for sensor in SENSORS if sensor not in metres}
    over = dict.fromkeys((sensor for sensor in SENSORS if sensor not in metres), "over_range")
    return Ranges(**values, **absent, status={**over, **status})


def _shifted(around, by_m):
    values = {f"{sensor}_m": getattr(around, f"{sensor}_m") for sensor in SENSORS}
    moved = {name: None if value is None else value + by_m for name, value in values.items()}
    return replace(around, **moved)


class Bench:
    """A kernel whose motors are armed and whose surroundings are free, unless told otherwise."""

    def __init__(self, **settings):
        self.state = first_state(DriveSettings(**settings))
        self.now = 100.0
        self.setpoints: list[MotorSetpoint] = []
        self.replies: list[CommandReply] = []
        self.events: list[Happened] = []
        self.results: list[GoalResult] = []
        self.around = ranges()
        self.motors = motors()
        self.noise_m = 0.0
        self.motors_speak = self.ranges_speak = True
        self._ids = 0
        self.sense()

    def event(self, event):
        self.state, outputs = decide(self.state, event, self.now)
        for output in outputs:
            match output:
                case Reply(message=message):
                    assert message.accepted or message.code in MEANINGS, message
                    self.replies.append(message)
                case Setpoint(message=message):
                    self.setpoints.append(message)
                case Result(message=message):
                    assert message.code in MEANINGS, message
                    self.results.append(message)
                case Happened():
                    assert output.code in MEANINGS or not {"lost", "why"} & output.data.keys(), output
                    self.events.append(output)
        return outputs

    def sense(self):
        if self.motors_speak:
            self.event(MotorsSeen(motors=self.motors, arrived=self.now))
        if self.ranges_speak:
            self.noise_m = -self.noise_m
            self.event(RangesSeen(ranges=_shifted(self.around, self.noise_m), arrived=self.now))

    def drive(self, power, angle_deg=0.0, *, source="console", checks=None, sent=None, **more):
        """Send a command now or, on the same clock, at `sent`."""
        return self._command(power, angle_deg, source, more, checks=checks or {}, received=sent)

    def drive_from_afar(self, power, angle_deg=0.0, *, source="page", sender_s=nan, answerable=True, **more):
        """Send a command from another machine, whose clock says `sender_s`."""
        return self._command(power, angle_deg, source, more, remote=True, sender_s=sender_s, answerable=answerable)

    def turn(self, angle_deg, *, source="console", checks=None, remote=False, **more):
        """Ask for a turn on the spot."""
        command = TurnCommand(angle_deg=angle_deg, **more)
        return self.send(command, source, checks=checks or {}, remote=remote)

    def head(self, heading_deg, *, source="console", **more):
        """Ask for a turn to a heading."""
        return self.send(HeadingCommand(heading_deg=heading_deg, **more), source)

    def _command(self, power, angle_deg, source, more, **marks):
        return self.send(DriveCommand(power=power, angle_deg=angle_deg, **more), source, **marks)

    def send(self, command, source="console", *, received=None, **marks):
        """Send any motion command."""
        self._ids += 1
        self.event(
            Command(
                command=command,
                source=source,
                new_lease=f"lease{self._ids}",
                new_goal=f"goal{self._ids}",
                received=self.now if received is None else received,
                **marks,
            )
        )
        return self.replies[-1]

    def look(self, **fields):
        """Let the attitude speak now."""
        fields = {"valid": True, "epoch": "e1", "measured_s": self.now, "turned_deg": 0.0} | fields
        self.event(AttitudeSeen(attitude=AttitudeState(**fields), arrived=self.now))

    def count(self, **fields):
        """Let the odometry speak now."""
        told = {"valid": True, "epoch": "o1", "counted_s": self.now, "distance_m": 0.0, "speed_mps": 0.0} | fields
        self.event(OdometrySeen(odometry=OdometryState(**told), arrived=self.now))

    def stop(self, source="phone", reason=""):
        self.event(Stop(source=source, received=self.now, reason=reason))
        return self.replies[-1]

    def estop(self, engaged, reason="button"):
        self.event(EstopChanged(engaged=engaged, reason=reason))

    def event_tick(self):
        self.event(Tick())

    def lose_motors(self, reason="motors is gone"):
        self.event(MotorsLost(reason=reason))

    def run(self, seconds, renew=None, sense_each=5):
        """Tick at 50 Hz with sensors at 10 Hz; `renew` is a function called at each of these."""
        for step in range(round(seconds * 50)):
            self.now = round(self.now + 0.02, 6)
            if step % sense_each == 0:
                self.sense()
                if renew:
                    renew()
            self.event(Tick())

    def see(self, **metres):
        """Surroundings from now on, seen often enough to be believed."""
        self.around = ranges(**metres)
        self.event(RangesSeen(ranges=self.around, arrived=self.now))
        self.event(RangesSeen(ranges=self.around, arrived=self.now))

    @property
    def wheels(self):
        return self.state.left, self.state.right

    @property
    def texts(self):
        return [event.text for event in self.events]
