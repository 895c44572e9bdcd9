"""What is published in ROS: messages of each stream with the time of its measurement, transforms that fit the body, URDF."""

from math import inf, isfinite, isnan, pi, radians, tan
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from lbr.apps.bodies.model import body_file, model
from lbr.apps.bodies.turning import rotated
from lbr.messages.attitude import AttitudeState
from lbr.messages.battery import BatteryState
from lbr.messages.camera import JpegFrame
from lbr.messages.imu import ImuSample
from lbr.messages.joints import Joint, JointsState, JointState
from lbr.messages.odometry import OdometryState
from lbr.messages.sensing import RangeSensor, Scan, ranges, ring
from lbr.testing import FakeContext
from tests.support import needs
from tests.support.replies import drive_state

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import codec, topics  # noqa: E402 - it needs both
from lbr.apps.ros2.kind import KIND  # noqa: E402
from lbr.apps.ros2.showing import Showing  # noqa: E402
from lbr.apps.ros2.urdf import urdf  # noqa: E402

PICTURE = b"\xff\xd8\xff\xc0\x00\x11\x08\x01\xe0\x02\x80\x03picture\xff\xd9"
"""As far as anybody here reads it: of 640 x 480."""
WALL_NS = 1_700_000_000_000_000_000
LIDAR = RangeSensor(name="lidar", kind="lidar", x_m=0.1, z_m=0.3, yaw_rad=pi, fov_rad=6.2832, rays=4, max_m=12.0)
SENSORS = (*ring(0.43, 0.30), LIDAR)
JOINTS = (
    Joint(name="right_elbow", device_id=5, side="right", lower_rad=-1.9, upper_rad=0.1, speed_rps=3.0),
    Joint(name="head", device_id=19, lower_rad=-1.0, upper_rad=1.0, speed_rps=2.0),
)


class Ros:
    """What is published to whom subscribes to everything; times are seconds before now."""

    def __init__(self, robot="lbr", joints=(), camera="camera_front", **settings):
        self.ctx = FakeContext(KIND, KIND.settings(**settings), robot=robot, name="ros2", given=(*SENSORS, *joints))
        self.ctx.wired = {"frames": (camera,)}
        self.ports = topics.ports(self.ctx.settings, self.ctx.sources, SENSORS)
        self.body = model(robot, body_file(robot, Path("/nonexistent")), joints, (), SENSORS)
        self.messages: dict[str, list] = {}
        self.showing = Showing(self.ctx, self.ports, self.body, SENSORS, self.publish, lambda: WALL_NS)
        self.showing.subscribed(lambda _topic, _type: True)

    def publish(self, topic, payload):
        self.messages.setdefault(topic, []).append(codec.decode(self.ports[topic].type, payload))

    def step(self):
        self.showing.step(self.ctx.now)
        self.ctx.now += 0.1

    def only(self, topic):
        """Return the one message of a topic."""
        (message,) = self.messages[topic]
        return message


def ago(message):
    stamp = message.header.stamp
    return (WALL_NS - stamp.sec * 1_000_000_000 - stamp.nanosec) / 1e9


@pytest.fixture
def ros():
    return Ros()


def test_odometry_is_shown_with_its_transform_at_the_time_of_its_counts(ros):
    state = OdometryState(
        valid=True, epoch="a", counted_s=ros.ctx.now - 0.2, x_m=1.0, y_m=2.0, yaw_rad=pi, speed_mps=0.3, turn_rps=-0.1
    )
    ros.ctx.arrive("odometry", state)
    ros.step()
    odom, (transform,) = ros.only("odom"), ros.only("tf").transforms
    assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
    assert ago(odom) == ago(transform) == pytest.approx(0.2)
    assert (odom.pose.pose.position.x, odom.pose.pose.orientation.z) == (1.0, pytest.approx(1.0))
    assert (odom.twist.twist.linear.x, odom.twist.twist.angular.z) == (0.3, -0.1)
    assert (transform.child_frame_id, transform.transform.translation.y) == ("base_link", 2.0)


def test_what_is_not_valid_is_not_shown(ros):
    ros.ctx.arrive("odometry", OdometryState(valid=False, epoch="a", reason="no encoders"))
    ros.ctx.arrive("battery", BatteryState(valid=False, reason="no volts"))
    ros.ctx.arrive("imu", ImuSample(valid=False, time_s=0.0))
    ros.step()
    assert set(ros.messages) == {"diagnostics"}


def test_an_inertial_unit_is_shown_with_the_attitude_and_says_what_it_does_not_measure(ros):
    ros.ctx.arrive("imu", ImuSample(valid=True, time_s=ros.ctx.now - 0.01, gyro_rps=(0.1, 0.2, 0.3)))
    ros.step()
    imu = ros.only("imu/data")
    assert ago(imu) == pytest.approx(0.01)
    assert (imu.angular_velocity.y, imu.orientation.w) == (0.2, 1.0)
    assert [one[0] for one in (imu.orientation_covariance, imu.linear_acceleration_covariance)] == [-1.0, -1.0]
    turned = AttitudeState(valid=True, epoch="a", measured_s=0.0, orientation=(0.0, 0.0, 0.0, 1.0))
    ros.ctx.arrive("attitude", turned)
    ros.ctx.arrive("imu", ImuSample(valid=True, time_s=ros.ctx.now, accel_mps2=(0.0, 0.0, 9.8)))
    ros.step()
    imu = ros.messages["imu/data"][-1]
    assert (imu.orientation.z, imu.orientation_covariance[0], imu.linear_acceleration.z) == (1.0, 0.0, 9.8)


def test_a_battery_is_shown_as_ros_counts_its_current_and_what_is_unknown_is_no_number(ros):
    ros.ctx.arrive("battery", BatteryState(valid=True, voltage_v=12.5, current_a=2.0, charge=0.8, charging=False))
    ros.step()
    battery = ros.only("battery_state")
    assert (battery.voltage, battery.current, battery.percentage) == pytest.approx((12.5, -2.0, 0.8))
    assert (battery.power_supply_status, battery.present, isnan(battery.capacity)) == (2, True, True)


def test_distances_are_shown_in_the_frame_of_each_sensor_and_nothing_within_reach_is_infinite(ros):
    readings = ranges(
        {"forward": 1.5, "back": None}, {"back": "over_range", "left": "missing"}, ages_s={"forward": 0.1}
    )
    ros.ctx.arrive("ranges", readings)
    ros.step()
    forward = ros.only("range/forward")
    assert (forward.header.frame_id, forward.range, ago(forward)) == ("forward_range", 1.5, pytest.approx(0.1))
    assert (forward.min_range, forward.max_range, forward.radiation_type) == (pytest.approx(0.17), 8.0, 0)
    assert ros.only("range/back").range == inf
    assert "range/left" not in ros.messages


def test_a_scan_is_shown_by_its_first_ray(ros):
    scan = Scan(
        sensor="lidar",
        angle_min_rad=-pi,
        angle_increment_rad=pi / 2,
        range_min_m=0.1,
        range_max_m=12.0,
        ranges_m=(1.0, "Infinity", None, 0.05),
        scan_s=0.1,
    )
    ros.ctx.arrive("scans", scan)
    ros.step()
    shown = ros.only("scan")
    assert (shown.header.frame_id, ago(shown)) == ("lidar_range", pytest.approx(0.1))
    assert (shown.scan_time, shown.time_increment) == pytest.approx((0.1, 0.025))
    assert list(shown.ranges[:2]) == [1.0, inf]
    assert all(map(isnan, shown.ranges[2:]))


def test_a_picture_is_shown_as_it_is(ros):
    ros.step()
    ros.ctx.arrive("frames", JpegFrame(PICTURE), source="camera_front")
    ros.step()
    picture, info = ros.only("camera_front/image_raw/compressed"), ros.only("camera_front/camera_info")
    assert (picture.format, bytes(picture.data)) == ("jpeg", PICTURE)
    assert picture.header.frame_id == "camera_front"
    assert (info.header, info.width, info.height) == (picture.header, 640, 480)
    assert not any((*info.k, *info.p, *info.d, info.distortion_model)), "its lens is not known"


def test_a_camera_of_the_body_has_its_field_of_view_and_a_frame():
    ros = Ros("uxa90", camera="camera_head")
    ros.ctx.arrive("frames", JpegFrame(PICTURE), source="camera_head")
    ros.step()
    info = ros.only("camera_head/camera_info")
    assert (info.k[0], info.k[2], info.k[5]) == pytest.approx((240 / tan(radians(46.8) / 2), 320.0, 240.0))
    ros.showing.begin()
    (seat,) = (one.transform for one in ros.only("tf_static").transforms if one.child_frame_id == "camera_head")
    assert rotated((seat.rotation.w, seat.rotation.x, seat.rotation.y, seat.rotation.z), (0, 0, 1)) == pytest.approx(
        (1, 0, 0)
    )


def test_diagnostics_name_each_part_its_reason_and_code_and_what_is_silent(ros):
    ros.ctx.arrive("drive", drive_state(reason="the emergency stop is latched", code="estop", estop=True))
    ros.ctx.arrive("battery", BatteryState(valid=True, voltage_v=10.0, level="low"))
    ros.step()
    ros.step()
    levels = {one.name: (one.level, [pair.value for pair in one.values]) for one in ros.only("diagnostics").status}
    assert levels["lbr: drive"] == (2, ["estop"])
    assert levels["lbr: battery"] == (1, ["low"])
    assert levels["lbr: odometry"] == (3, [])


def test_each_topic_keeps_the_rows_rate():
    ros = Ros(rate_hz=5.0)
    for _ in range(20):
        ros.ctx.arrive("imu", ImuSample(valid=True, time_s=ros.ctx.now))
        ros.step()
    assert len(ros.messages["imu/data"]) == 10


def test_without_a_subscriber_nothing_is_made(ros):
    ros.showing.subscribed(lambda _topic, _type: False)
    ros.ctx.arrive("imu", ImuSample(valid=True, time_s=ros.ctx.now))
    ros.step()
    assert ros.messages == {}


def test_joints_are_shown_where_they_were_measured_and_their_links_move():
    ros = Ros("bioloid", JOINTS)
    state = JointsState(
        sequence=1,
        measured_s=ros.ctx.now - 0.05,
        moving=False,
        phase="released",
        joints={"right_elbow": JointState(id=5, position_rad=-0.5), "head": JointState(id=19)},
    )
    ros.ctx.arrive("joints", state)
    ros.step()
    joints = ros.only("joint_states")
    assert (list(joints.name), list(joints.position), ago(joints)) == (["right_elbow"], [-0.5], pytest.approx(0.05))
    moved = {one.child_frame_id for one in ros.only("tf").transforms}
    ros.showing.begin()
    fixed = {one.child_frame_id for one in ros.only("tf_static").transforms}
    links = {link.name for link in ros.body.links}
    assert moved | fixed >= links - {"base_link"}
    assert not moved & fixed


@pytest.mark.parametrize(("robot", "joints"), [("lbr", ()), ("bioloid", JOINTS), ("uxa90", ())])
def test_the_body_is_one_tree_below_base_link_with_the_frames_of_the_transforms(robot, joints):
    ros = Ros(robot, joints)
    root = ET.fromstring(urdf(ros.body))
    links = [one.get("name") for one in root.findall("link")]
    parents = {one.find("child").get("link"): one.find("parent").get("link") for one in root.findall("joint")}
    assert len(set(links)) == len(links)
    assert set(links) == {"base_link", *parents}
    assert set(parents.values()) <= set(links)
    assert all(links.index(parents[link]) < links.index(link) for link in parents)
    limits = [one.find("limit") for one in root.findall("joint") if one.get("type") == "revolute"]
    assert all(float(one.get("lower")) < float(one.get("upper")) for one in limits)
    assert all(isfinite(float(value)) for one in root.iter("origin") for value in one.get("xyz").split())
