"""A manoeuvre's knowledge of the robot: the newest message of each stream, while it is fresh enough."""

from math import inf
from typing import Any

from lbr.capability.context import Context
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.dock import DockSignal
from lbr.messages.motors import RESTS_S
from lbr.messages.sensing import Ranges
from lbr.robots.lbr.beacon.moves import shortest
from lbr.robots.lbr.beacon.view import Beam

ATTITUDE_S, RANGES_S, SIGNAL_S, BATTERY_S = 0.7, 0.7, 1.5, 3.0
SEEN_S = 0.45
"""The age limit of a beam, which comes nine times a second."""
BEAMS: tuple[Beam, ...] = ("left", "right", "power")


class BlindError(Exception):
    """The robot lacks knowledge that a manoeuvre needs; the text names it."""


class Senses:
    """The robot's own reports. Directions count from `heading_deg`, or without a compass from the first look."""

    def __init__(self, ctx: Context[Any], heading_deg: float) -> None:
        self._ctx = ctx
        self._heading_deg = heading_deg
        self._zero: tuple[str, float] | None = None
        self._measured: dict[str, tuple[float | None, float]] = {}

    def direction_deg(self) -> float:
        """Return the robot's direction, clockwise from the docked one; raise BlindError if it is unknown."""
        attitude: AttitudeState | None = self._newest("attitude", RESTS_S)
        if attitude is None or (self._newest("attitude", ATTITUDE_S) is None and not attitude.rests):
            raise BlindError("the robot does not say how it lies: the capability 'attitude' is silent")
        if not attitude.valid or attitude.turned_deg is None:
            raise BlindError(f"the robot does not know how it lies: {attitude.reason or 'no reason given'}")
        turned_deg = attitude.turned_deg
        if self._zero is None or self._zero[0] != attitude.epoch:
            known = attitude.heading_deg is not None
            if not known and self._zero is not None:
                raise BlindError("the attitude started over, and without a compass the direction is lost")
            looks_deg = shortest((attitude.heading_deg or 0.0) - self._heading_deg) if known else 0.0
            self._zero = (attitude.epoch, turned_deg - looks_deg)
        return shortest(turned_deg - self._zero[1])

    def listen(self) -> None:
        """Process the sensors' messages."""
        for received in self._ctx.take("ranges"):
            message: Ranges = received.message
            for sensor in ("forward", "back"):
                if message.tells_of(sensor) and message.status.get(sensor, "ok") in {"ok", "over_range"}:
                    until = received.arrived + (RESTS_S if message.rests else RANGES_S)
                    self._measured[sensor] = (message.metres(sensor), until)

    def metres(self, sensor: str) -> float | None:
        """Return a sensor's distance, None if nothing is within its reach; raise BlindError without a fresh reading."""
        metres, until = self._measured.get(sensor, (None, -inf))
        if not self._ctx.clock() <= until:
            raise BlindError(f"the sensor '{sensor}' measures nothing: what stands in the way is not known")
        return metres

    def battery(self) -> BatteryState | None:
        """Return the state of the battery, None if it is unknown."""
        battery: BatteryState | None = self._newest("battery", BATTERY_S)
        return battery if battery is not None and battery.valid else None

    def beams(self) -> frozenset[Beam]:
        """Return the dock's beams in sight now."""
        received, now = self._ctx.latest("dock"), self._ctx.clock()
        if received is None or not received.age_s(now) <= SIGNAL_S:
            return frozenset()
        signal: DockSignal = received.message
        ages = {beam: getattr(signal, f"{beam}_age_s") for beam in BEAMS}
        old_s = received.age_s(now)
        return frozenset(beam for beam, seen_s in ages.items() if seen_s is not None and seen_s + old_s < SEEN_S)

    def _newest(self, port: str, within_s: float) -> Any:
        received = self._ctx.latest(port)
        return received.message if received is not None and received.age_s(self._ctx.clock()) <= within_s else None
