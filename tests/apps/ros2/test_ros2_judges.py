"""The bridge judged by software of others, where it is installed: `tests/support/ros_judges` says how."""

import json
import os
import subprocess
import time
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from tests.support import needs, programs, ros_judges, ros_side
from tests.support.robot import free_port, lbr, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import STOPS_S, until

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import codec  # noqa: E402 - it needs both
from tests.apps.ros2.test_ros2_page import steps  # noqa: E402

pytestmark = pytest.mark.slow_start
FOLDER = Path(ros_judges.__file__).parent
RCLPY, SIDES = os.environ.get("LBR_RCLPY", ""), os.environ.get("LBR_ROS_SIDES", "")
HEADER = {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": "base_link"}
POSE = {"position": {"x": 1.5, "y": -2.25, "z": 0.5}, "orientation": {"w": 0.6, "x": 0.0, "y": 0.0, "z": 0.8}}
TWIST = {"linear": {"x": 0.25, "y": 0.5}, "angular": {"z": -1.0}}
NAN = float("nan")
MESSAGES = {
    "geometry_msgs/msg/Twist": TWIST,
    "geometry_msgs/msg/TwistStamped": {"header": HEADER, "twist": TWIST},
    "nav_msgs/msg/Odometry": {
        "header": HEADER, "child_frame_id": "base_link", "pose": {"pose": POSE}, "twist": {"twist": TWIST},
    },
    "geometry_msgs/msg/TransformStamped": {
        "header": HEADER, "child_frame_id": "bcd", "transform": {"translation": {"x": 1.0}, "rotation": {"w": 1.0}},
    },
    "trajectory_msgs/msg/JointTrajectory": {
        "header": HEADER, "joint_names": ["a", "bcd"],
        "points": [
            {"positions": [0.5, 1.5], "velocities": [0.0, NAN], "time_from_start": {"sec": 1, "nanosec": 5}},
            {"positions": [0.25, -1.0], "effort": [2.0], "time_from_start": {"sec": 2}},
        ],
    },
    "sensor_msgs/msg/JointState": {"header": HEADER, "name": ["a", "bc"], "position": [0.5, 1.5], "velocity": [NAN, 0.1]},
    "sensor_msgs/msg/Imu": {"header": HEADER, "orientation_covariance": [-1.0, *[0.0] * 8], "angular_velocity": {"z": 1.0}},
    "sensor_msgs/msg/BatteryState": {"header": HEADER, "voltage": 12.5, "current": NAN, "power_supply_status": 2, "present": True},
    "sensor_msgs/msg/LaserScan": {"header": HEADER, "angle_min": -3.0, "ranges": [1.0, float("inf"), NAN]},
    "sensor_msgs/msg/Range": {"header": HEADER, "radiation_type": 1, "range": 1.25, "max_range": 4.0},
    "sensor_msgs/msg/CompressedImage": {"header": HEADER, "format": "jpeg", "data": b"\xff\xd8\xff\xd9"},
    "sensor_msgs/msg/CameraInfo": {
        "header": HEADER, "height": 480, "width": 640, "distortion_model": "plumb_bob", "d": [0.5], "k": [1.5] * 9, "p": [2.0] * 12,
    },
    "diagnostic_msgs/msg/DiagnosticArray": {
        "header": HEADER,
        "status": [{"level": 2, "name": "lbr: drive", "message": "stopped", "values": [{"key": "code", "value": "estop"}]}],
    },
    "std_msgs/msg/String": {"data": "<robot/>"},
}  # fmt: skip


def plain(value):
    """Return a message of rosbags as rclpy's is told."""
    if is_dataclass(value):
        return {
            one.name: plain(getattr(value, one.name))
            for one in fields(value)
            if one.name.islower() and one.name != "__msgtype__"
        }
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(one) for one in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def rclpy():
    if not RCLPY:
        pytest.skip("LBR_RCLPY names no Python with rclpy")
    judge = programs.start(
        [RCLPY, FOLDER / "rclpy_messages.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )

    def ask(**asked):
        judge.stdin.write(json.dumps(asked) + "\n")
        judge.stdin.flush()
        return json.loads(judge.stdout.readline())

    yield ask
    judge.communicate()


@pytest.mark.parametrize("type_", MESSAGES)
def test_rclpy_has_the_same_hash_and_reads_and_writes_the_same_fields(rclpy, type_):
    data = codec.encode(type_, MESSAGES[type_])
    judged = rclpy(type=type_, hex=data.hex())
    ours = json.dumps(plain(codec.decode(type_, data)), sort_keys=True)
    assert judged["hash"] == codec.type_hash(type_)
    assert json.dumps(judged["fields"], sort_keys=True) == ours
    assert json.dumps(plain(codec.decode(type_, bytes.fromhex(judged["hex"]))), sort_keys=True) == ours


def test_the_hash_of_transforms_is_that_by_the_rule_and_the_descriptions_of_rclpy(rclpy):
    type_ = "tf2_msgs/msg/TFMessage"  # which is not in its registry
    many = ["transforms", "geometry_msgs/msg/TransformStamped"]
    assert rclpy(type=type_, many=many)["hash"] == codec.type_hash(type_)


def test_rclpy_reads_and_writes_both_sides_of_a_service_alike(rclpy):
    ours = codec.answer("stopped", success=True)
    judged = rclpy(type=codec.TRIGGER, part="Response", hex=ours.hex())
    assert judged["hash"] == codec.type_hash(codec.TRIGGER)
    assert judged["fields"] == {"success": True, "message": "stopped"}
    theirs = bytes.fromhex(judged["hex"])
    assert (theirs[:5], theirs[8 : len(ours)]) == (ours[:5], ours[8:]), "but for the padding"
    asked = (ros_side.HEAD + b"\x00").hex()
    assert rclpy(type=codec.TRIGGER, part="Request", hex=asked)["hex"].startswith(asked)


class Side:
    """A node by software of others."""

    def __init__(self, program, endpoint):
        argv = [SIDES, FOLDER / program, endpoint]
        self.popen = programs.start(argv, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, **asked):
        self.popen.stdin.write(json.dumps(asked) + "\n")
        self.popen.stdin.flush()

    def read(self, name):
        """Return what it tells next of a name."""
        while line := self.popen.stdout.readline():
            if name in (told := json.loads(line)):
                return told
        raise AssertionError("it has ended")

    def close(self):
        self.popen.kill()
        self.popen.communicate()


@pytest.fixture(params=["pyzeros_node.py", "sdk_node.py"])
def pair(tmp_path, request):
    """Return a robot that is the router of ROS, and a node by pyzeros or by zenoh-ros2-sdk."""
    if not SIDES:
        pytest.skip("LBR_ROS_SIDES names no Python with pyzeros and zenoh-ros2-sdk")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    listen = f"UPDATE capability SET settings = json_set(settings, '$.listen', '{endpoint}') WHERE name = 'ros2'"
    token, switch_on = steps()
    home = prepare(tmp_path / "h", "ros2", "odometry", "imu", "attitude", edits=(switch_on, listen))
    assert lbr(home, *token).returncode == 0
    with running(home) as robot:
        until(lambda: robot.capability("ros2")["phase"] == "ready", what="the router")
        node = Side(request.param, endpoint)
        try:
            node.read("ready")
            yield robot, node
        finally:
            node.close()


@pytest.mark.timeout(900)
def test_a_node_of_others_drives_round_a_corner_stops_by_a_service_and_its_death_stops_the_robot(pair):
    robot, node = pair
    trace = Trace(robot.trace)
    node.ask(twist=[0.2, 0.5])
    until(lambda: not trace.now().zero, what="turning wheels")
    until(lambda: robot.ask("odometry/state")["yaw_rad"] > 1.5, what="the corner")
    far = node.read("odom")
    while not far["odom"][0] > 0.05:
        far = node.read("odom")
    assert 0.0 <= far["age_s"] < 5.0
    since = time.monotonic_ns()
    node.ask(call="stop")
    assert node.read("success")["success"] is True
    assert trace.first_zero(since, STOPS_S) is not None
    until(lambda: "rest_first" in [one["code"] for one in robot.events()], what="the refusal of the next twist")
    node.ask(twist=[0.0, 0.0])
    node.read("sent_ns")
    node.ask(twist=[0.2, 0.0])
    until(lambda: not trace.now().zero, what="turning wheels after rest")
    since = time.monotonic_ns()
    node.popen.kill()
    assert trace.first_zero(since, STOPS_S) is not None
