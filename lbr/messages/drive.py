"""Messages on `drive/*`: commands for the base, and its state."""

from typing import Literal

from msgspec import Struct

from lbr.messages.codes import ReasonCode
from lbr.messages.leases import LeaseId
from lbr.messages.units import (
    AngleDeg,
    DistanceCm,
    HeadingDeg,
    IntervalS,
    Name,
    Power,
    RangeCm,
    SignedPower,
    SpeedMps,
    TtlS,
    TurnDeg,
    TurnRps,
)

Direction = Literal["forward", "back", "left", "right"]
Sensor = Name
"""A row of `range_sensor`."""


class DriveCommand(Struct, frozen=True, kw_only=True):
    """Drive at `power` towards `angle_deg` while the lease is renewed, within the bounds."""

    power: Power
    angle_deg: AngleDeg = 0.0
    lease: LeaseId = ""
    range_cm: RangeCm = 0.0
    sensor: Sensor = "forward"
    interval_s: IntervalS = 0.0
    distance_cm: DistanceCm = 0.0
    ttl_s: TtlS | None = None
    take_over: bool = False


class TurnCommand(Struct, frozen=True, kw_only=True):
    """Turn on the spot by an angle, while the lease is renewed with the same command."""

    angle_deg: TurnDeg
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class HeadingCommand(Struct, frozen=True, kw_only=True):
    """Turn on the spot to a compass heading, the shorter way, while the lease is renewed."""

    heading_deg: HeadingDeg
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class TwistCommand(Struct, frozen=True, kw_only=True):
    """Move with this twist (REP 103: ahead, left, anticlockwise) while the lease is renewed.

    A twist beyond the motors' limits is scaled down as a whole. `vy_mps` is for bases that move sideways.
    """

    vx_mps: SpeedMps = 0.0
    vy_mps: SpeedMps = 0.0
    wz_rps: TurnRps = 0.0
    lease: LeaseId = ""
    ttl_s: TtlS | None = None
    take_over: bool = False


class GoalResult(Struct, frozen=True, kw_only=True):
    """The end of a bounded move or a turn. `reached` and `interval` are the planned ends; all others carry a reason.

    `code`: why it ended. `cause`: a second code for programs. `note`: the same for people. `error_deg`: turned past the
    target, clockwise positive. `error_m`: the same of a distance.
    """

    goal: str
    result: Literal["reached", "interval", "stopped", "lapsed", "superseded", "fault"]
    reason: str
    elapsed_s: float
    code: ReasonCode = ""
    cause: ReasonCode = ""
    note: str = ""
    range_cm: float | None = None
    turned_deg: float | None = None
    error_deg: float | None = None
    distance_m: float | None = None
    error_m: float | None = None


class LoopStatistics(Struct, frozen=True, kw_only=True):
    """The fixed-rate loop in the last second or so, in milliseconds."""

    rate_hz: float
    period_p99_ms: float
    period_max_ms: float
    overruns: int


class DriveState(Struct, frozen=True, kw_only=True):
    """The motion of the base, its holder, and why it is slower than asked or stands still.

    `sees`: obstacles of sensors that watch by themselves, in metres from the base's outline, by sensor and side; null:
    not known. `aside`: the part of the motion to the left, a fraction of full speed.
    """

    moving: bool
    power: Power
    angle_deg: AngleDeg
    left: SignedPower
    right: SignedPower
    holder: str | None
    goal: str | None
    limited_by: str
    reason: str
    estop: bool
    loop: LoopStatistics | None
    stopped_s: float | None = None
    stopped_by: str = ""
    halted_s: float | None = None
    halted_by: str = ""
    code: ReasonCode = ""
    sees: dict[str, float | None] = {}
    aside: SignedPower = 0.0


class CheckRequest(Struct, frozen=True, kw_only=True):
    """A motion command before it is accepted, for a user's own check.

    `command`: the motion; of a turn its first spin, of a `twist` the nearest power and angle.
    """

    source: str
    command: DriveCommand
    turn: TurnCommand | None = None
    heading: HeadingCommand | None = None
    twist: TwistCommand | None = None


class CheckVerdict(Struct, frozen=True, kw_only=True):
    """The verdict of a check on a command, for its sender."""

    accepted: bool
    reason: str = ""
    code: ReasonCode = ""
