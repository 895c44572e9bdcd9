"""Settings of a row of kind `joints`."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.joints import BusOfJoints
from lbr.messages.units import TtlS


class JointsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of how a humanoid's joints are moved.

    A motion has reached its end when every joint of it was measured within `tolerance_rad`, or `settle_s` later.
    `open_loop`: joints that are not measured may be moved too. They count as being where they were last told to be, and
    arrive by the clock; an unknown one starts at its goal, which its driver makes slow.
    """

    rate_hz: Annotated[float, Meta(ge=10.0, le=200.0, description="setpoints per second")] = 100.0
    ttl_s: TtlS = 0.3
    bus: BusOfJoints = ""
    tolerance_rad: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.05
    settle_s: Annotated[
        float, Meta(gt=0.0, le=10.0, description="how long joints may take to arrive after the end of a motion")
    ] = 0.5
    servos_max_age_s: Annotated[
        float, Meta(gt=0.0, le=1.0, description="a servo driver that is silent for this long ends every motion")
    ] = 0.3
    joint_max_age_s: Annotated[
        float, Meta(gt=0.0, le=10.0, description="a joint that was not measured for this long ends its motion")
    ] = 0.5
    open_loop: Annotated[bool, Meta(description="whether joints whose position is not known may be moved")] = False
