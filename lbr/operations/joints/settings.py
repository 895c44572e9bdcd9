"""Settings of a row of kind `joints`."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.messages.joints import BusOfJoints
from lbr.messages.units import TtlS


class JointsSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of the motion of a humanoid's joints.

    A motion ends when all its joints measure within `tolerance_rad`, or after `settle_s`. `open_loop`: unmeasured
    joints move, too. They count as being at their commanded position, and arrive by the clock; an unknown one starts at
    its goal, slowly.
    """

    rate_hz: Annotated[float, Meta(ge=10.0, le=200.0, description="setpoints per second")] = 100.0
    ttl_s: TtlS = 0.3
    bus: BusOfJoints = ""
    tolerance_rad: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.05
    settle_s: Annotated[float, Meta(gt=0.0, le=10.0, description="for joints to arrive after a motion")] = 0.5
    servos_max_age_s: Annotated[float, Meta(gt=0.0, le=1.0, description="a silent servo driver ends every motion")] = (
        0.3
    )
    joint_max_age_s: Annotated[float, Meta(gt=0.0, le=10.0, description="an unmeasured joint ends its motion")] = 0.5
    open_loop: Annotated[bool, Meta(description="unmeasured joints may be moved")] = False
