"""The topics and services of the robot in ROS with their types, from its rows and wires. Pure."""

from collections.abc import Callable, Iterable, Iterator, Sequence

from lbr.apps.ros2 import codec
from lbr.apps.ros2.kind import ESTOP, STOP, Ros2Settings
from lbr.apps.ros2.trajectory import TRAJECTORY
from lbr.apps.ros2.wire import HUMBLE_HASH, EndpointKind, Port, Qos, topic_key
from lbr.messages.sensing import RangeSensor

ACCEPTED = {"drive": ("cmd_vel", (codec.TWIST, codec.TWIST_STAMPED)), "joints": ("joint_trajectory", (TRAJECTORY,))}
"""The topic that moves a part, and its types, by the input of that part's state."""
ODOM, TF, TF_STATIC, JOINT_STATES, IMU = "odom", "tf", "tf_static", "joint_states", "imu/data"
BATTERY, DIAGNOSTICS, DESCRIPTION = "battery_state", "diagnostics", "robot_description"
SENSED, KEPT = Qos(reliable=False, depth=5), Qos(transient_local=True, depth=1)
STREAMS = {
    "odometry": (ODOM, "nav_msgs/msg/Odometry"),
    "joints": (JOINT_STATES, "sensor_msgs/msg/JointState"),
    "imu": (IMU, "sensor_msgs/msg/Imu"),
    "battery": (BATTERY, "sensor_msgs/msg/BatteryState"),
}
"""The topic of each input, and its type."""


def ports(
    settings: Ros2Settings, sources: Callable[[str], Sequence[str]], sensors: Iterable[RangeSensor]
) -> dict[str, Port]:
    """Return the published topics, without the namespace, and the received topics and services, by name."""
    shown = [*_always(), *_measured(sources, tuple(sensors))]
    shown += [(topic, type_, Qos()) for port, (topic, type_) in STREAMS.items() if sources(port)]
    made = {topic: _port(settings, "MP", topic, type_, qos) for topic, type_, qos in shown}
    for topic, types in received(sources).items():
        made |= {type_: _port(settings, "MS", topic, type_, Qos()) for type_ in types}
    for service in (STOP, ESTOP, *settings.services):
        made[service] = _port(settings, "SS", service, codec.TRIGGER, Qos())
    return made


def received(sources: Callable[[str], Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Return the topics that move this robot, with their types."""
    return {topic: types for port, (topic, types) in ACCEPTED.items() if sources(port)}


def scan_topics(sources: Callable[[str], Sequence[str]], sensors: Iterable[RangeSensor]) -> dict[str, str]:
    """Return the topic of each scanning sensor: `scan` for the first one."""
    scanning = [one.name for one in sensors if one.rays > 1] if sources("scans") else []
    return {name: f"scan_{name}" if at else "scan" for at, name in enumerate(scanning)}


def range_topic(sensor: str) -> str:
    """Return the topic of a sensor with one ray."""
    return f"range/{sensor}"


def picture_topic(camera: str) -> str:
    """Return the topic of a camera's pictures."""
    return f"{camera}/image_raw/compressed"


def info_topic(camera: str) -> str:
    """Return the topic of a camera's parameters."""
    return f"{camera}/camera_info"


def accepted(settings: Ros2Settings, sources: Callable[[str], Sequence[str]]) -> dict[str, dict[str, tuple[str, str]]]:
    """Return the received topics, with their types and those types' valid hashes."""
    return {
        f"{settings.namespace}/{topic}": {one: (codec.type_hash(one), HUMBLE_HASH) for one in types}
        for topic, types in received(sources).items()
    }


def _always() -> Iterator[tuple[str, str, Qos]]:
    yield TF, "tf2_msgs/msg/TFMessage", Qos(depth=100)
    yield TF_STATIC, "tf2_msgs/msg/TFMessage", KEPT
    yield DIAGNOSTICS, "diagnostic_msgs/msg/DiagnosticArray", Qos()
    yield DESCRIPTION, "std_msgs/msg/String", KEPT


def _measured(
    sources: Callable[[str], Sequence[str]], sensors: Sequence[RangeSensor]
) -> Iterator[tuple[str, str, Qos]]:
    for topic in scan_topics(sources, sensors).values():
        yield topic, "sensor_msgs/msg/LaserScan", SENSED
    for sensor in sensors if sources("ranges") else ():
        if sensor.rays == 1:
            yield range_topic(sensor.name), "sensor_msgs/msg/Range", SENSED
    for camera in sources("frames"):
        yield picture_topic(camera), "sensor_msgs/msg/CompressedImage", SENSED
        yield info_topic(camera), "sensor_msgs/msg/CameraInfo", SENSED


def _port(settings: Ros2Settings, kind: EndpointKind, topic: str, type_: str, qos: Qos) -> Port:
    name, hash_ = f"{settings.namespace}/{topic}", codec.type_hash(type_, humble=settings.humble)
    keys = topic_key(settings.domain, name, type_, "*") if kind == "MS" else ""
    return Port(kind=kind, topic=name, type=type_, hash=hash_, qos=qos, keys=keys)
