"""Messages of sensors."""

from typing import Literal

from msgspec import Struct

RangeStatus = Literal["ok", "over_range", "invalid", "missing"]


class Ranges(Struct, frozen=True, kw_only=True):
    """Distances around the robot in metres; null is not measured, and `status` says why.

    `over_range`: nothing within the sensor's reach. `invalid`: the sensor answered with a value that it uses for
    errors. `missing`: no such sensor, or it did not answer. `cycle_s` is the board's own measuring cycle.
    """

    forward_m: float | None
    back_m: float | None
    left_m: float | None
    right_m: float | None
    bottom_m: float | None
    status: dict[str, RangeStatus]
    cycle_s: float | None = None
