"""Messages on `motors/*`: between drive operations and the motor driver."""

from msgspec import Struct

from lbr.messages.units import Name, SignedPower


class MotorSetpoint(Struct, frozen=True, kw_only=True):
    """Power of the two sides, forward positive; valid for 0.1 s. `lease` is a mark of the lease it comes by, which
    cannot be quoted.

    Where rows name other motors than `left` and `right`, `motors` has the power of each.
    """

    left: SignedPower
    right: SignedPower
    lease: str = ""
    motors: dict[Name, SignedPower] = {}


class MotorState(Struct, frozen=True, kw_only=True):
    """Power and measurements of one motor, forward positive; null is not measured."""

    power: float
    amps_a: float | None = None
    counts: int | None = None


class MotorsState(Struct, frozen=True, kw_only=True):
    """Powers and measurements of the motor controller; null is not measured.

    `armed` says that a setpoint would be applied; `reason` says why not. Volts: `voltage_v` is the battery,
    `internal_v` the controller's own supply. Motor currents and encoder counts are signed, forward positive. `faults`
    are names of faults that the controller tells, as its driver lists them. Where rows name other motors than `left`
    and `right`, each is in `motors`, and `left` and `right` are what the base makes of them. `heard`: whether the
    controller has sent anything since its line was opened; where it has not, all else here is what it was told.
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
    motors: dict[Name, MotorState] = {}
    heard: bool | None = None
