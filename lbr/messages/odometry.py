"""Messages on `odometry/*`: how far the base went, by its wheels."""

from msgspec import Struct


class OdometryState(Struct, frozen=True, kw_only=True):
    """Where the base is since `epoch` began (REP 103: x ahead, y left at its start), by encoders and attitude.

    `distance_m` is the way travelled, backwards negative. `stalled`: the motors push and the wheels stand. `slipping`:
    the wheels turn otherwise than the body does. `counted_s` is when the counts in it were read. `aside_mps` is the
    speed to the left, of a base that can move sideways.
    """

    valid: bool
    epoch: str
    reason: str = ""
    counted_s: float | None = None
    x_m: float | None = None
    y_m: float | None = None
    yaw_rad: float | None = None
    distance_m: float | None = None
    speed_mps: float | None = None
    turn_rps: float | None = None
    stalled: bool = False
    slipping: bool = False
    aside_mps: float | None = None
