"""The kind `ros2`: its settings, ports and words."""

import re
from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.http.names import is_local
from lbr.apps.motion_requests import motion_requests
from lbr.apps.ros2.messages import Ros2State
from lbr.bus.door import TokenRight
from lbr.capability.kind import Kind, Needs, Rights, Rows, Wire
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.camera import JpegFrame
from lbr.messages.drive import DriveState, GoalResult
from lbr.messages.imu import ImuSample
from lbr.messages.joints import Joint, JointsState
from lbr.messages.kinematics import Wheel
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import Ranges, RangeSensor, Scan
from lbr.messages.system import ConsoleResult, LineCommand
from lbr.messages.units import Name

_ENDPOINT = re.compile(r"tcp/(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9][A-Za-z0-9._-]{0,252}):([0-9]{1,5})")
Endpoint = Annotated[
    str, Meta(max_length=280, description="as Zenoh writes it, such as tcp/127.0.0.1:7447; empty: none")
]
Line = Annotated[str, Meta(min_length=1, max_length=250, description="a line of the console, such as /go/100/0.3")]
STOP, ESTOP = "stop", "estop"


class Ros2Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a row of kind `ros2`.

    `connect`: the router of ROS (`rmw_zenohd`); or the robot is that router, at `listen`. ROS has no login: everybody
    who reaches the router may drive, so one that other machines reach needs `clear_text`. `token`: its role is that of
    ROS; without one ROS only stops. `services`: console lines, by service.
    """

    connect: Endpoint = "tcp/127.0.0.1:7447"
    listen: Endpoint = ""
    clear_text: Annotated[
        bool, Meta(description="with other machines, too: all who reach the router drive by the token")
    ] = False
    domain: Annotated[int, Meta(ge=0, le=232, description="ROS_DOMAIN_ID")] = 0
    namespace: Annotated[
        str, Meta(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)*$(?!\n)", max_length=80, description="such as /rob; empty: none")
    ] = ""
    humble: Annotated[bool, Meta(description="ROS there is Humble, without hashes of types")] = False
    token: Annotated[str, Meta(max_length=40)] = ""
    services: Annotated[dict[Name, Line], Meta(max_length=30)] = {}
    speed_mps: Annotated[float, Meta(gt=0.0, le=10.0, description="the fastest that ROS may drive")] = 0.5
    turn_rps: Annotated[float, Meta(gt=0.0, le=20.0, description="the fastest that ROS may turn")] = 1.5
    silent_s: Annotated[float, Meta(ge=0.1, le=1.0, description="a publisher of cmd_vel silent for longer is gone")] = (
        0.25
    )
    late_s: Annotated[float, Meta(ge=0.1, le=5.0, description="a later twist, or an older stamp, is not followed")] = (
        0.4
    )
    ttl_s: Annotated[float, Meta(ge=0.2, le=1.0, description="motion outlives this process for so long")] = 0.3
    rate_hz: Annotated[float, Meta(ge=0.5, le=50.0, description="messages a second on a topic, at most")] = 20.0

    def __post_init__(self) -> None:
        """Refuse a malformed address, and one that other machines reach without `clear_text`."""
        for field in ("connect", "listen"):
            endpoint = getattr(self, field)
            found = _ENDPOINT.fullmatch(endpoint)
            if endpoint and (found is None or int(found[2]) > 65535):
                raise ValueError(f"{field}: '{endpoint}' is not an address; they look like tcp/127.0.0.1:7447")
            if found is not None and not self.clear_text and not is_local(found[1].strip("[]")):
                raise ValueError(
                    f"{field}: there is no login in ROS; clear_text set to true lets all who reach {endpoint} drive"
                )
        if taken := sorted({STOP, ESTOP} & set(self.services)):
            raise ValueError(f"services: '{taken[0]}' is there always, and is no line")


def address(endpoint: str) -> tuple[str, int]:
    """Return host and port of an address in Zenoh's form."""
    host, _, port = endpoint.partition("/")[2].rpartition(":")
    return host.strip("[]"), int(port)


_MOTION = motion_requests(
    *("twist", "move", "turn", "heading", "halt", "joints_move", "joints_halt"),
    *("play", "play_halt", "seek", "seek_halt", "stop_all"),
)
_STREAMS: dict[str, type[Struct]] = {
    "odometry": OdometryState,
    "attitude": AttitudeState,
    "joints": JointsState,
    "battery": BatteryState,
    "drive": DriveState,
}

SHOWN = frozenset({*_STREAMS, "ranges", "scans", "imu", "frames"})
"""The inputs that are read while a node in ROS subscribes."""

KIND = Kind(
    name="ros2",
    summary="joins ROS 2 by the wire of rmw_zenoh: sensors out, motion and services in",
    family="app",
    rights=Rights(
        serves=True,
        lets_in=("enabled", "connect", "listen", "clear_text", "domain", "token", "services"),
    ),
    entry="lbr.apps.ros2.capability:Ros2",
    settings=Ros2Settings,
    inputs={**_STREAMS, "ranges": Ranges, "scans": Scan, "imu": ImuSample, "frames": JpegFrame, "results": GoalResult},
    optional=(*_STREAMS, "ranges", "scans", "imu", "frames", "results"),
    outputs={"state": Ros2State},
    requests={**_MOTION.requests, "say": LineCommand},
    replies={"say": ConsoleResult},
    rows=(Rows(TokenRight, {"name": "token"}), Joint, Wheel, RangeSensor),
    says="services",
    wires={
        **dict.fromkeys(_STREAMS, Wire("state")),
        "ranges": Wire("readings"),
        "scans": Wire("scan", 4),
        "imu": Wire("sample", 16),
        "results": Wire("result", 16),
        **_MOTION.wires,
    },
    needs=Needs("rosbags", extra="ros2"),
)
