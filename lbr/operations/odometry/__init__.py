"""Odometry: the way of the base, from the wheels' encoders and the attitude."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.attitude import AttitudeState
from lbr.messages.kinematics import Kinematics, Wheel
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState


class OdometrySettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `odometry`.

    `track_m`: the distance between the wheels by turns on the spot, which exceeds that by a ruler. Rows of `wheel`
    replace it and `wheel_diameter_m`. Stalled: a wheel with `stall_power` or `stall_a` that counts nothing for
    `stall_s`. Slipping: wheels and attitude differ by `slip_dps` and by `slip_share` of the faster, for `slip_s`.
    """

    wheel_diameter_m: Annotated[float, Meta(gt=0.0, le=2.0)] = 0.1778
    counts_per_turn: Annotated[
        float, Meta(gt=0.0, le=1_000_000.0, description="of an encoder, for a turn of its wheel")
    ] = 130.0
    track_m: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.27
    max_speed_mps: Annotated[
        float, Meta(gt=0.0, le=10.0, description="what counts faster than twice this, was reset")
    ] = 1.0
    speed_window_s: Annotated[float, Meta(gt=0.0, le=2.0, description="speeds are averages over this")] = 0.3
    stall_power: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.05
    stall_a: Annotated[float, Meta(gt=0.0, le=200.0)] = 5.0
    stall_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.5
    slip_dps: Annotated[float, Meta(gt=0.0, le=360.0)] = 15.0
    slip_share: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.3
    slip_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.6
    silent_s: Annotated[
        float, Meta(gt=0.0, le=5.0, description="nothing is known without the motors' state for so long")
    ] = 0.3


KIND = Kind(
    name="odometry",
    summary="distance, speed, stall and slip of a base on wheels",
    family="operation",
    entry="lbr.operations.odometry.capability:Odometry",
    settings=OdometrySettings,
    inputs={"motors": MotorsState, "attitude": AttitudeState},
    outputs={"state": OdometryState},
    rows=(Kinematics, Wheel),
)
