"""Messages on `motors/*`: between drive operations and the motor driver."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.units import Name, SignedPower

RESTS_S = 1.2
"""The life of messages that come twice a second at rest: two of them may be missing."""


class MotorSetpoint(Struct, frozen=True, kw_only=True):
    """Power of both sides, forward positive, valid for 0.1 s. `lease`: a mark of its lease, which cannot be quoted.

    `motors`: the power of each, where rows name others than `left` and `right`. `moving_s`: the age of the motion,
    null if unknown. A zero with an age stays in force at rest; a motion that begins within 0.1 s may follow it.
    """

    left: SignedPower
    right: SignedPower
    lease: str = ""
    motors: dict[Name, SignedPower] = {}
    moving_s: Annotated[float, Meta(ge=0.0)] | None = None


class MotorState(Struct, frozen=True, kw_only=True):
    """Power and measurements of one motor, forward positive; null: not measured."""

    power: float
    amps_a: float | None = None
    counts: int | None = None


class MotorsState(Struct, frozen=True, kw_only=True):
    """Powers and measurements of the motor controller; null is not measured.

    `armed`: a setpoint would be applied. `voltage_v`: the battery. `internal_v`: the controller's own supply. Currents
    and counts are positive forward. `faults`: as the driver lists them. `motors`: those other than `left` and `right`,
    which the base then derives. `rests`: they stand, and are reported twice a second until they move.
    """

    left: float
    right: float
    armed: bool
    reason: str
    estop: bool
    voltage_v: float | None = None
    internal_v: float | None = None
    output_v: float | None = None
    amps_left_a: float | None = None
    amps_right_a: float | None = None
    counts_left: int | None = None
    counts_right: int | None = None
    temperature_c: float | None = None
    faults: tuple[str, ...] = ()
    trips: int = 0
    code: ReasonCode = ""
    motors: dict[Name, MotorState] = {}
    heard: bool | None = None
    rests: bool = False

    @property
    def each(self) -> dict[str, MotorState]:
        """Return every motor by its name, including `left` and `right`, which have fields of their own."""
        return self.motors or {
            "left": MotorState(power=self.left, amps_a=self.amps_left_a, counts=self.counts_left),
            "right": MotorState(power=self.right, amps_a=self.amps_right_a, counts=self.counts_right),
        }
