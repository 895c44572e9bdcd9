"""The motors of the API: the rows of one layer, and each motor's last commanded position."""

from collections.abc import Iterable
from math import radians

from msgspec import UNSET

from lbr.apps.web.face import Refused
from lbr.messages.faces import Motor
from lbr.messages.joints import Joint
from lbr.robots.uxa90.driver.messages import HIGHEST, LOWEST
from lbr.robots.uxa90.rest.answers import MotorData, Number
from lbr.robots.uxa90.rest.counts import allowed, count_of, in_degrees
from lbr.robots.uxa90.rest.number import clamped, nearest, plain, written

LARGEST = 1e6
UNITS = ("raw", "percent", "deg")


class MotorTable:
    """One layer's motors by number; `commanded` has their positions, which replies show."""

    def __init__(self, motors: Iterable[Motor], joints: Iterable[Joint], layer: str) -> None:
        self.joints = {joint.device_id: joint for joint in joints}
        self.motors = {motor.id: motor for motor in sorted(motors, key=lambda each: each.id) if motor.layer == layer}
        self.commanded: dict[int, Number] = {number: motor.initial for number, motor in self.motors.items()}

    def put(self, motor: Motor) -> None:
        """Add a new or changed motor; its commanded position stays."""
        self.motors[motor.id] = motor
        self.motors = dict(sorted(self.motors.items()))
        self.commanded.setdefault(motor.id, motor.initial)

    def find(self, number: float) -> Motor:
        """Return a motor by the requested number, which may be any number."""
        motor = self.motors.get(int(number)) if abs(number) < LARGEST and number == int(number) else None
        if motor is None:
            raise Refused(409, f"Motor '{written(number)}' doesn't exist", code="unknown_name")
        return motor

    def data(self, motor: Motor, position: Number | None = None, unit: str = "") -> MotorData:
        """Return a motor's data, with its present or future position."""
        at = self.commanded[motor.id] if position is None else position
        return MotorData(
            id=motor.id,
            name=motor.name,
            description=motor.description,
            position=at,
            min=motor.lowest,
            max=motor.highest,
            default=motor.rest,
            inverted=motor.inverted,
            smartPosition=self.in_unit(motor, at, unit) if unit else UNSET,
            rawPosition=nearest(at) if unit else UNSET,
        )

    def in_unit(self, motor: Motor, count: Number, unit: str) -> Number | None:
        """Return a position in another unit: percent of its range, degrees of its joint (null without a joint)."""
        if unit == "raw":
            return count
        if unit == "deg":
            joint = self.joints.get(motor.id)
            return None if joint is None else plain(in_degrees(joint, count))
        percent = 100.0 * (count - motor.lowest) / max(1, motor.highest - motor.lowest)
        return plain(round(100.0 - percent if motor.inverted else percent, 1))

    def from_unit(self, motor: Motor, value: float, unit: str) -> Number:
        """Return the count for a position, within the motor's range."""
        if unit == "percent":
            percent = clamped(value, 0.0, 100.0)
            share = (100.0 - percent if motor.inverted else percent) / 100.0
            value = nearest(motor.lowest + share * (motor.highest - motor.lowest))
        elif unit == "deg":
            joint = self.joint(motor)
            value = nearest(count_of(joint, radians(clamped(value, -1e6, 1e6))))
        return plain(clamped(value, motor.lowest, motor.highest))

    def joint(self, motor: Motor) -> Joint:
        """Return the joint that a motor turns."""
        joint = self.joints.get(motor.id)
        if joint is None:
            raise Refused(
                409, f"Motor '{motor.id}' turns no joint: no row of `joint` has device_id {motor.id}", code="wiring"
            )
        return joint

    def target(self, motor: Motor, position: Number) -> int:
        """Return the count for the servo; refuse one beyond the limits of its joint or the line."""
        joint, count = self.joint(motor), nearest(position)
        lowest, highest = allowed(joint)
        if lowest <= count <= highest:
            return count
        if not LOWEST <= count <= HIGHEST:
            raise Refused(
                409, f"Motor '{motor.id}': {count} is not a position of a servo ({LOWEST} to {HIGHEST})", code="limit"
            )
        low, high = sorted(in_degrees(joint, one) for one in (lowest, highest))
        within = f"{lowest} to {highest}, which is {low:g} to {high:g} degrees"
        raise Refused(409, f"Motor '{motor.id}': {count} is beyond what {joint.name} may do ({within})", code="limit")
