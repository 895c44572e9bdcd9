"""Odometry: how far the base went, from the wheels' encoders and the attitude."""

from msgspec import Struct

from lbr.capability.kind import Kind
from lbr.messages.attitude import AttitudeState
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState


class OdometrySettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row of kind `odometry` may set."""


KIND = Kind(
    name="odometry",
    summary="distance, speed, stall and slip of a base with two driven wheels",
    family="operation",
    entry="lbr.operations.odometry.capability:Odometry",
    settings=OdometrySettings,
    inputs={"motors": MotorsState, "attitude": AttitudeState},
    outputs={"state": OdometryState},
)
