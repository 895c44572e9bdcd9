"""A whole robot driven by nodes of ROS that are processes: however they or the router go, the motors stand and stay so."""

import json
import os
import signal
import sys
import time

import pytest

from tests.support import needs, programs
from tests.support.commands import here
from tests.support.robot import free_port, only, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import STOPS_S, until

needs.modules("rosbags")
needs.modules("xxhash")
pytestmark = pytest.mark.slow_start

STAYS_S = 1.0
PATIENT = {"silent_s": 1.0, "late_s": 5.0}
"""Of the row: a busy machine may hold a node up, which then has lost the robot before anybody kills it."""


def refusals(robot):
    return [one["code"] for one in robot.events() if one["kind"] == "ros2_refused"]


class Ros:
    """A robot with ROS beside it: nodes, and the router unless the robot is that."""

    def __init__(self, robot, endpoint):
        self.robot, self.endpoint = robot, endpoint
        self.trace = Trace(robot.trace)
        self.processes = []

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        for process in self.processes:
            process.kill()
            process.wait()

    def started(self, *arguments):
        process = programs.start([sys.executable, "-m", "tests.support.ros_side", self.endpoint, *arguments])
        self.processes.append(process)
        return process

    def drives(self):
        """Have a node drive, and return its process."""
        since_ns = time.monotonic_ns()
        node = self.started()
        until(lambda: self.trace.read() and self.turned(since_ns), what="turning wheels")
        return node

    def turned(self, since_ns):
        """Say whether the wheels turned after a moment."""
        return any(not one.zero for one in self.trace.outputs(since_ns))

    def stand(self, since_ns):
        """Wait for the wheels to stand, and see that they stay so."""
        zero = self.trace.first_zero(since_ns, STOPS_S)
        assert zero is not None, "the wheels still turn"
        self.rest(zero.at_ns)

    def rest(self, since_ns):
        """See that the wheels stand for a while."""
        end = time.monotonic() + STAYS_S
        until(lambda: time.monotonic() > end)
        self.trace.read()
        assert not self.turned(since_ns), "they turned again"


@pytest.fixture(scope="module")
def homes(tmp_path_factory):
    def make(robot="lbr", *edits, **settings):
        edit = (
            f"UPDATE capability SET enabled = 1, settings = '{json.dumps({'token': 'ros', **PATIENT, **settings})}'"
            f" WHERE robot = '{robot}' AND name = 'ros2'"
        )
        home = prepare(tmp_path_factory.mktemp("ros2"), "ros2", edits=(edit, *edits))
        assert here(home, "token", "add", "ros", "--role", "operate").returncode == 0
        return home

    return make


@pytest.fixture(scope="module")
def ros(homes):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with running(homes(listen=endpoint)) as robot, Ros(robot, endpoint) as ros:
        yield ros


def test_a_node_that_is_killed_while_it_drives_stops_the_robot(ros):
    node = ros.drives()
    since = time.monotonic_ns()
    node.kill()
    ros.stand(since)
    until(lambda: "holder_gone" in refusals(ros.robot), what="the event")


def test_a_node_that_is_frozen_stops_the_robot_and_thawed_it_does_not_go_on(ros):
    node = ros.drives()
    since = time.monotonic_ns()
    os.kill(node.pid, signal.SIGSTOP)
    ros.stand(since)
    since = time.monotonic_ns()
    os.kill(node.pid, signal.SIGCONT)
    until(lambda: "rest_first" in refusals(ros.robot), what="the event")
    ros.rest(since)
    node.kill()


def test_a_bridge_that_is_killed_stops_the_robot(ros):
    node = ros.drives()
    since = time.monotonic_ns()
    os.kill(ros.robot.capability("ros2")["pid"], signal.SIGKILL)
    assert ros.trace.first_zero(since, STOPS_S) is not None, "the wheels still turn"
    node.kill()
    until(lambda: ros.robot.capability("ros2")["phase"] == "ready", what="the bridge again")


def test_a_router_that_is_killed_and_replaced_stops_the_robot_and_nothing_resumes(homes):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with running(homes(connect=endpoint)) as robot, Ros(robot, endpoint) as ros:
        router = ros.started("--router")
        until(lambda: robot.capability("ros2")["phase"] == "ready", what="the router")
        ros.drives()
        since = time.monotonic_ns()
        router.kill()
        ros.stand(since)
        until(lambda: robot.capability("ros2")["phase"] == "degraded", what="the loss")
        ros.started("--router")
        until(lambda: robot.capability("ros2")["phase"] == "ready", what="the router again")
        until(lambda: "rest_first" in refusals(robot), what="the same node, refused")
        ros.rest(time.monotonic_ns())


def test_a_node_that_is_killed_while_its_trajectory_goes_on_stops_the_joints(homes):
    needs.modules("mujoco")
    from lbr.apps.ros2 import codec, wire
    from lbr.apps.ros2.trajectory import TRAJECTORY

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    home = homes("bioloid", only("bioloid", "world", "servos", "joints", "ros2"), listen=endpoint)
    point = {"positions": [-1.5], "time_from_start": {"sec": 20}}
    payload = codec.encode(TRAJECTORY, {"joint_names": ["right_elbow"], "points": [point]})

    def joints():
        return robot.ask("joints/state") or {}

    def elbow():
        return joints()["joints"]["right_elbow"]["goal_rad"]

    with running(home, profile="bioloid-sim") as robot, Ros(robot, endpoint) as ros:
        until(lambda: robot.capability("ros2")["phase"] == "ready", what="the router")
        until(lambda: robot.line("/torque/on")["code"] == 0, what="torque")
        node = ros.started(
            "--once", "joint_trajectory", wire.dds_type(TRAJECTORY), codec.type_hash(TRAJECTORY), payload.hex()
        )
        until(lambda: joints().get("moving") and elbow() < -0.1, what="a moving joint")
        node.kill()
        until(lambda: not joints()["moving"], what="its stop")
        stands, end = elbow(), time.monotonic() + STAYS_S
        until(lambda: time.monotonic() > end)
        assert stands > -1.0
        assert elbow() == pytest.approx(stands, abs=0.02)
        until(lambda: "holder_gone" in refusals(robot), what="the event")
