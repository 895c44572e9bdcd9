"""Messages on `odometry/*`: the way of the base, by its wheels."""

from msgspec import Struct


class OdometryState(Struct, frozen=True, kw_only=True):
    """The position of the base since `epoch` began (REP 103: x ahead, y left at its start), by encoders and attitude.

    `distance_m`: travelled, backwards negative. `stalled`: the motors push and the wheels stand. `slipping`: wheels and
    body turn differently. `counted_s`: when its counts were read. `aside_mps`: speed to the left, of a base that has
    one. `rests`: its motors do, and it is reported twice a second.
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
    rests: bool = False
