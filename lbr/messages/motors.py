"""Messages on `motors/*`: between drive operations and the motor driver."""

from msgspec import Struct

from lbr.messages.units import SignedPower


class MotorSetpoint(Struct, frozen=True, kw_only=True):
    """Power of the two wheels, forward positive; valid for 0.1 s. `lease` is a mark of the lease it comes by, which cannot be quoted."""

    left: SignedPower
    right: SignedPower
    lease: str = ""


class MotorsState(Struct, frozen=True, kw_only=True):
    """What the motor controller applies and measures; null is not measured.

    `armed` says that a setpoint would be applied; `reason` says why not. Volts: `voltage_v` is the battery,
    `internal_v` the controller's own supply. Motor currents and encoder counts are signed, forward positive.
    `faults` are names of faults that the controller tells, as its driver lists them.
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
