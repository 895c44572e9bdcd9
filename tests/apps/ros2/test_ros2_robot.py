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
PATIENT = {"silent_s": 1.0, "late_s": 5.0, "ttl_s": 1.0}
"""Of the row: a busy machine may hold a node up, which then has lost the robot before anybody kills it."""


def refusals(robot, since_ns=0):
    return [one["code"] for one in robot.events() if one["kind"] == "ros2_refused" and one["wall_ns"] > since_ns]


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
        self.began_ns = time.time_ns()
        process = programs.start([sys.executable, "-m", "tests.support.ros_side", self.endpoint, *arguments])
        self.processes.append(process)
        return process

    def drives(self):
        """Have a node drive, and return its process; one whose motion a busy machine ended is followed by another."""
        since_ns, node = time.monotonic_ns(), self.started()
        while until(lambda: self.turned(since_ns) or self.refusals(), what="turning wheels") is not True:
            node.kill()
            node = self.started()
        return node

    def refusals(self):
        """Return why nodes were refused since the newest began."""
        return refusals(self.robot, self.began_ns)

    def turned(self, since_ns):
        """Say whether the wheels turned after a moment."""
        self.trace.read()
        return any(not one.zero for one in self.trace.outputs(since_ns))

    def stand(self):
        """Wait for the wheels to stand, and see that they stay so."""
        until(lambda: self.trace.now().zero, limit_s=STOPS_S, what="wheels that stand")
        self.rest(self.trace.now().at_ns)

    def rest(self, since_ns):
        """See that the wheels stand for a while."""
        end = time.monotonic() + STAYS_S
        until(lambda: time.monotonic() > end)
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
    def ended_by():
        """Kill what drives, and return the code of its end: on a busy machine its motion may have ended before."""
        ros.drives().kill()
        ros.stand()
        return until(ros.refusals, what="the event")[0]

    until(lambda: ended_by() == "holder_gone", what="a motion that ends with its node")


def test_a_node_that_is_frozen_stops_the_robot_and_thawed_it_does_not_go_on(ros):
    node = ros.drives()
    os.kill(node.pid, signal.SIGSTOP)
    ros.stand()
    since = time.monotonic_ns()
    os.kill(node.pid, signal.SIGCONT)
    until(lambda: "rest_first" in refusals(ros.robot), what="the event")
    ros.rest(since)
    node.kill()


def test_a_bridge_that_is_killed_stops_the_robot_and_for_the_next_the_same_node_must_rest_first(ros):
    node = ros.drives()
    os.kill(ros.robot.capability("ros2")["pid"], signal.SIGKILL)
    until(lambda: ros.trace.now().zero, limit_s=STOPS_S, what="wheels that stand")
    stood_ns = ros.trace.now().at_ns
    until(lambda: "rest_first" in ros.refusals(), what="the same node, refused")
    ros.rest(stood_ns)
    node.kill()
    until(lambda: ros.robot.capability("ros2")["phase"] == "ready", what="the bridge again")


def test_a_router_that_is_killed_and_replaced_stops_the_robot_and_nothing_resumes(homes):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with running(homes(connect=endpoint)) as robot, Ros(robot, endpoint) as ros:
        router = ros.started("--router")
        until(lambda: robot.capability("ros2")["phase"] == "ready", what="the router")
        ros.drives()
        router.kill()
        ros.stand()
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
