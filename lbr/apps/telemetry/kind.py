"""The kind `telemetry`: its settings, ports and words."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.kind import Kind
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.camera import CamerasState
from lbr.messages.dock import DockSignal
from lbr.messages.imu import ImuSample
from lbr.messages.motors import MotorsState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges
from lbr.messages.telemetry import Telemetry


class TelemetrySettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `telemetry`."""

    rate_hz: Annotated[float, Meta(ge=0.1, le=20.0, description="packages a second")] = 5.0


KIND = Kind(
    name="telemetry",
    summary="the robot's telemetry in one nested message",
    family="app",
    entry="lbr.apps.telemetry.capability:TelemetryPackage",
    settings=TelemetrySettings,
    inputs={
        "ranges": Ranges,
        "imu": ImuSample,
        "attitude": AttitudeState,
        "motors": MotorsState,
        "odometry": OdometryState,
        "battery": BatteryState,
        "dock": DockSignal,
        "cameras": CamerasState,
    },
    outputs={"package": Telemetry},
)
