"""The newest of the robot's streams that docking needs, each for as long as it can be believed."""

from typing import Generic, TypeVar

from msgspec import Struct

from lbr.apps.autodock.view import Beam
from lbr.apps.program import Robot
from lbr.bus import keys, stamp, wire
from lbr.bus.codec import Decoder
from lbr.errors import BusError, MalformedError
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.dock import DockSignal
from lbr.messages.drive import DriveState, GoalResult
from lbr.messages.sensing import Ranges

ATTITUDE_S, RANGES_S, SIGNAL_S, BATTERY_S = 0.7, 0.7, 1.5, 3.0
SEEN_S = 0.45
"""A beam comes nine times a second."""
BEAMS: tuple[Beam, ...] = ("left", "right", "power")

M = TypeVar("M", bound=Struct)


class Stream(Generic[M]):
    """The newest message of a stream and when it was sent."""

    def __init__(self, robot: Robot, capability: str, output: str, message: type[M], *, depth: int = 1) -> None:
        self._decoder = Decoder(message)
        self._subscription = wire.Subscription(robot.bus, keys.port(robot.name, capability, output), depth=depth)
        self._newest: M | None = None
        self._sent = 0.0

    def take(self) -> list[M]:
        """Return what came since the last call."""
        found = []
        for raw in self._subscription.take():
            try:
                found.append(self._decoder.decode(raw.payload))
            except MalformedError:
                continue
            self._newest, self._sent = found[-1], stamp.sent_s(stamp.read(raw.attachment), raw.arrived)
        return found

    def newest(self, now: float, within_s: float) -> tuple[M, float] | None:
        """Return the newest and its age, unless it is too old."""
        self.take()
        age_s = now - self._sent
        return (self._newest, age_s) if self._newest is not None and age_s <= within_s else None


class Senses:
    """What the robot says of itself."""

    def __init__(self, robot: Robot) -> None:
        self._attitude = Stream(robot, "attitude", "state", AttitudeState)
        self._ranges = Stream(robot, "ranges", "readings", Ranges)
        self._signal = Stream(robot, "dock", "signal", DockSignal)
        self._battery = Stream(robot, "battery", "state", BatteryState)
        self._results = Stream(robot, "drive", "result", GoalResult, depth=8)
        self._drive = Stream(robot, "drive", "state", DriveState, depth=64)

    def attitude(self, now: float) -> AttitudeState:
        """Return how the robot lies; raise BusError if that is not known."""
        found = self._attitude.newest(now, ATTITUDE_S)
        if found is None:
            raise BusError("the robot does not say how it lies: the capability 'attitude' is silent")
        if not found[0].valid or found[0].turned_deg is None:
            raise BusError(f"the robot does not know how it lies: {found[0].reason or 'no reason given'}")
        return found[0]

    def ranges(self, now: float) -> Ranges | None:
        """Return the distances around, null if nothing new came."""
        found = self._ranges.newest(now, RANGES_S)
        return found[0] if found else None

    def battery(self, now: float) -> BatteryState | None:
        """Return how the battery is, null if that is not known."""
        found = self._battery.newest(now, BATTERY_S)
        return found[0] if found and found[0].valid else None

    def beams(self, now: float) -> frozenset[Beam]:
        """Return the dock's beams that are seen in this moment."""
        found = self._signal.newest(now, SIGNAL_S)
        if found is None:
            return frozenset()
        signal, age_s = found
        ages = {beam: getattr(signal, f"{beam}_age_s") for beam in BEAMS}
        return frozenset(beam for beam, seen_s in ages.items() if seen_s is not None and seen_s + age_s < SEEN_S)

    def drive(self) -> list[DriveState]:
        """Return what the drive said of itself; it tells each stop."""
        return self._drive.take()

    def results(self) -> list[GoalResult]:
        """Return what the drive said of motions that ended."""
        return self._results.take()
