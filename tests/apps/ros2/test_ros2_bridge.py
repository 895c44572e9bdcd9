"""The bridge beside a drive and a console of the test's own, and nodes of ROS on a real router; its time is the test's."""

import struct
import time

import pytest

from lbr.bus.door import TokenRight
from lbr.bus.session import HELD_MS
from lbr.messages.drive import GoalResult
from lbr.messages.joints import Joint
from lbr.messages.leases import CommandReply
from lbr.messages.odometry import OdometryState
from lbr.messages.system import ConsoleResult
from lbr.testing import FakeContext
from tests.support import needs
from tests.support.replies import dead
from tests.support.robot import free_port
from tests.support.waiting import until

needs.modules("rosbags")
needs.modules("xxhash")
from lbr.apps.ros2 import codec, link  # noqa: E402 - it needs both
from lbr.apps.ros2.kind import KIND  # noqa: E402
from lbr.apps.ros2.trajectory import TRAJECTORY  # noqa: E402
from tests.support import ros_side  # noqa: E402
from tests.support.ros_side import TWIST, twist  # noqa: E402

TICK_S = 0.02
KNEE = Joint(name="left_knee", device_id=5, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0)
JOINT_TRAJECTORY = "trajectory_msgs::msg::dds_::JointTrajectory_", codec.type_hash(TRAJECTORY)


class World(FakeContext):
    """A drive and a console on the other side of the bus."""

    def __init__(self, *joints, **settings):
        rights = (TokenRight(name="ros", role="operate"), *joints)
        given = {"token": "ros", "services": {"hello": "/s/hello"}, "late_s": 5.0, **settings}
        super().__init__(KIND, KIND.settings(**given), robot="lbr", name="ros2", given=rights)
        self.wired = {"scans": (), "frames": (), "joints": ("joints",) if joints else ()}
        self.lease = ""
        self.twists: list[tuple[float, float]] = []
        self.frames: list[tuple] = []
        self.stops = 0
        self.result = ConsoleResult(code=0, text="hello is said")

    def answer(self, request, message):
        return {"other": getattr(self, f"_{request}")(message)}

    def _twist(self, message):
        if message.lease and message.lease != self.lease:
            return dead("", "stopped")
        self.lease = self.lease or f"lease-{len(self.asked)}"
        self.twists.append((message.vx_mps, message.wz_rps))
        return CommandReply(accepted=True, lease=self.lease, ttl_s=message.ttl_s)

    def _joints_move(self, message):
        if message.lease and message.lease != self.lease:
            return dead("", "stopped")
        self.lease = self.lease or f"lease-{len(self.asked)}"
        self.frames.append(message.frames)
        return CommandReply(accepted=True, lease=self.lease, goal="goal", ttl_s=message.ttl_s)

    def _joints_halt(self, message):
        return self._halt(message)

    def _halt(self, _message):
        self.lease = ""
        return CommandReply(accepted=True)

    def _stop_all(self, message):
        assert message.whole
        self.stops += 1
        return self._halt(message)

    def _say(self, message):
        assert message.line == "/s/hello"
        return self.result


class Bridge:
    """A bridge that is stepped, and a node of ROS at its router."""

    def __init__(self, world, endpoint):
        self.world = world
        self.capability = KIND.load()(world)
        self.capability.open()
        self.until(lambda: "ready" in world.health, "the router")
        self.session = ros_side.opened(endpoint)
        self.node = ros_side.Node(self.session)

    def step(self):
        self.capability.step()

    def until(self, look, what=""):
        """Step until something is so; no time goes by for the robot meanwhile."""
        return until(lambda: (self.step(), look())[1], what)

    def run(self, seconds):
        for _ in range(round(seconds / TICK_S)):
            self.step()
            self.world.now += TICK_S

    def drive(self, publisher, speed=0.2):
        """Have a publisher drive."""
        publisher.put(twist(speed))
        self.until(lambda: self.world.lease and self.world.twists[-1] == (speed, 0.0), "motion")

    def told(self):
        return [self.world.codes[at] for at, (kind, _) in enumerate(self.world.events) if kind == "ros2_refused"]

    def close(self):
        self.session.close()
        self.capability.close()


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    monkeypatch.setattr(link, "LINK_LEASE_MS", HELD_MS)  # both ends are in this process, and are held up with it
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def bridge(place):
    bridge = Bridge(World(listen=place), place)
    yield bridge
    bridge.close()


def test_a_twist_drives_under_a_lease_follows_and_ends_when_its_publisher_falls_silent(bridge):
    publisher = bridge.node.publisher("cmd_vel", TWIST)
    bridge.drive(publisher)
    lease = bridge.world.lease
    bridge.drive(publisher, 0.3)
    assert bridge.world.lease == lease
    bridge.run(0.24)
    assert bridge.world.lease == lease
    bridge.run(0.04)
    assert bridge.world.lease == ""
    publisher.put(twist(0.2))
    bridge.until(lambda: "rest_first" in bridge.told(), "the refusal")
    assert bridge.world.lease == ""
    assert bridge.told() == ["holder_gone", "rest_first"]
    publisher.put(twist())
    bridge.drive(publisher)


def test_a_node_that_is_gone_stops_at_once(bridge):
    bridge.drive(bridge.node.publisher("cmd_vel", TWIST))
    bridge.session.close()
    bridge.until(lambda: bridge.world.lease == "", "its stop")
    assert bridge.told() == ["holder_gone"]
    assert "/teleop is gone" in bridge.world.told("ros2_refused")[0]


def test_a_stop_of_the_robot_ends_it_and_the_publisher_that_goes_on_is_told_once(bridge):
    publisher = bridge.node.publisher("cmd_vel", TWIST)
    bridge.drive(publisher)
    bridge.world.lease = "another's"

    def goes_on():
        publisher.put(twist(0.2))
        bridge.run(TICK_S)
        return len(bridge.told()) > 1

    until(goes_on, "the refusal")
    assert bridge.told() == ["stopped", "rest_first"]
    assert bridge.world.lease == "another's"


def test_services_stop_and_say_lines(bridge):
    bridge.drive(bridge.node.publisher("cmd_vel", TWIST))
    assert called(bridge, "stop") == (True, "stopped")
    assert bridge.world.stops == 1
    assert bridge.world.lease == ""
    assert called(bridge, "hello") == (True, "hello is said")
    bridge.world.result = ConsoleResult(code=1, text="no voice", reason_code="off")
    assert called(bridge, "hello") == (False, "no voice [off]")
    assert called(bridge, "estop")[0]
    assert bridge.world.latched == ["from ROS"]


def called(bridge, service):
    """Call a service while the bridge steps."""
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:
        answer = pool.submit(bridge.node.call, service)
        bridge.until(answer.done, f"the answer of {service}")
        return answer.result()


def test_odometry_is_shown_while_somebody_subscribes_with_the_time_of_its_counts(bridge):
    state = OdometryState(valid=True, epoch="a", x_m=1.5, y_m=0.5, yaw_rad=0.0, speed_mps=0.2, turn_rps=0.1)
    heard = []

    def measure():
        bridge.world.arrive("odometry", OdometryState(**{**as_dict(state), "counted_s": bridge.world.now - 0.5}))
        bridge.world.now += TICK_S
        bridge.step()

    measure()
    bridge.node.subscribe("odom", ros_side.ODOMETRY, heard)
    until(lambda: (measure(), heard)[1], "odometry")
    data = heard[0].payload.to_bytes()
    sec, nanosec = struct.unpack_from("<iI", data, 4)
    assert 0.4 < time.time() - (sec + nanosec / 1e9) < 60.0
    x_m, y_m = struct.unpack_from("<2d", data, 4 + 40)
    assert (x_m, y_m) == (1.5, 0.5)
    assert len(heard[0].attachment.to_bytes()) == 33


def as_dict(state):
    return {name: getattr(state, name) for name in state.__struct_fields__}


def test_what_stays_is_there_for_who_comes_later(bridge):
    import zenoh

    heard = []
    history = zenoh.ext.HistoryConfig(detect_late_publishers=True)
    held = zenoh.ext.declare_advanced_subscriber(
        bridge.session, ros_side.key("robot_description", ros_side.STRING), heard.append, history=history
    )
    bridge.until(lambda: heard, "the description")
    assert b'<robot name="lbr">' in heard[0].payload.to_bytes()
    held.undeclare()


def test_a_type_that_is_not_taken_is_told_once_by_its_token_alone(bridge):
    bridge.node.endpoint("MP", "cmd_vel", ros_side.STRING)
    bridge.until(bridge.told, "the complaint")
    bridge.node.endpoint("MP", "cmd_vel", ros_side.STRING)
    bridge.run(1.0)
    assert bridge.world.told("ros2_refused") == [
        "/teleop publishes String on /cmd_vel, which takes Twist and TwistStamped"
    ]


def test_who_was_there_before_the_bridge_and_who_has_another_twist_are_told_too(place):
    with ros_side.opened(place, router=True) as router:
        early = ros_side.Node(router, "early")
        early.endpoint("MP", "cmd_vel", ros_side.STRING)
        bridge = Bridge(World(connect=place), place)
        bridge.node.endpoint("MP", "cmd_vel", (TWIST[0], "RIHS01_" + "0" * 64))
        bridge.until(lambda: len(bridge.told()) == 2, "both complaints")
        bridge.close()
    told = " ".join(bridge.world.told("ros2_refused"))
    assert "/early publishes String" in told
    assert "/teleop publishes another geometry_msgs/msg/Twist" in told


def test_a_router_that_is_replaced_ends_motion_all_is_declared_anew_and_nothing_resumes(place):
    router = ros_side.opened(place, router=True)
    bridge = Bridge(World(connect=place), place)
    publisher = bridge.node.publisher("cmd_vel", TWIST)
    bridge.drive(publisher)
    router.close()
    bridge.until(lambda: bridge.world.lease == "", "its stop")
    bridge.until(lambda: bridge.world.health[-1] != "ready", "the loss")
    assert bridge.told() in (["unreachable"], ["holder_gone"]), "the node's token may go before the router's link"
    router = until(lambda: again(place), "the router again")
    bridge.until(lambda: bridge.world.health[-1] == "ready", "the bridge again")
    bridge.world.events.clear()
    bridge.world.codes.clear()

    def refused():
        publisher.put(twist(0.2))
        bridge.step()
        return "rest_first" in bridge.told()

    until(refused, "the same publisher, refused")
    assert bridge.world.lease == ""
    bridge.close()
    router.close()


def again(place):
    import zenoh

    try:
        return ros_side.opened(place, router=True)
    except zenoh.ZError:
        return None


def test_without_a_token_ros_looks_and_stops_and_moves_nothing(place):
    bridge = Bridge(World(listen=place, token=""), place)
    bridge.node.publisher("cmd_vel", TWIST).put(twist(0.2))
    bridge.until(lambda: bridge.told() == ["token"], "the refusal")
    assert bridge.world.twists == []
    assert called(bridge, "hello")[0] is False
    assert called(bridge, "stop") == (True, "stopped")
    bridge.close()


def test_a_stamp_of_the_past_stops_and_is_told(bridge):
    publisher = bridge.node.publisher("cmd_vel", ros_side.STAMPED)
    publisher.put(ros_side.stamped(0.2, time.time()))
    bridge.until(lambda: bridge.world.lease, "motion")
    publisher.put(ros_side.stamped(0.2, time.time() - 60.0))
    bridge.until(lambda: bridge.world.lease == "", "its stop")
    assert bridge.told() == ["late"]


def bent(*angles, name="left_knee"):
    """Return a trajectory of a joint, by a point each second."""
    points = [{"positions": [one], "time_from_start": {"sec": at}} for at, one in enumerate(angles, 1)]
    return codec.encode(TRAJECTORY, {"joint_names": [name] if angles else [], "points": points})


@pytest.fixture
def humanoid(place):
    bridge = Bridge(World(KNEE, listen=place), place)
    yield bridge
    bridge.close()


def bend(bridge, publisher):
    """Have a publisher move the joints."""
    publisher.put(bent(0.5, 0.2))
    bridge.until(lambda: bridge.world.lease, "motion")
    assert [frame.positions for frame in bridge.world.frames[-1]] == [{"left_knee": 0.5}, {"left_knee": 0.2}]


def test_a_trajectory_moves_joints_under_a_lease_until_it_is_over(humanoid):
    publisher = humanoid.node.publisher("joint_trajectory", JOINT_TRAJECTORY)
    bend(humanoid, publisher)
    humanoid.run(5.0)
    assert len(humanoid.world.frames) > 10, "its silence means nothing, and its lease is renewed"
    humanoid.world.lease = ""
    humanoid.world.arrive("results", GoalResult(goal="goal", result="reached", reason="", code="done", elapsed_s=2.0))
    humanoid.run(1.0)
    assert humanoid.told() == []
    bend(humanoid, publisher)


def test_a_node_that_is_gone_ends_its_trajectory_and_another_begins(humanoid):
    with ros_side.opened(humanoid.world.settings.listen) as session:
        one = ros_side.Node(session, "one")
        bend(humanoid, one.publisher("joint_trajectory", JOINT_TRAJECTORY))
        other = humanoid.node.publisher("joint_trajectory", JOINT_TRAJECTORY)
        other.put(bent(0.1))
        humanoid.until(lambda: humanoid.told() == ["held"], "the refusal of the other")
    humanoid.until(lambda: humanoid.world.lease == "", "its stop")
    assert humanoid.told() == ["held", "holder_gone"]
    bend(humanoid, other)


def test_a_trajectory_of_what_is_not_there_moves_nothing_and_is_told_once(humanoid):
    publisher = humanoid.node.publisher("joint_trajectory", JOINT_TRAJECTORY)
    for _ in range(3):
        publisher.put(bent(0.5, name="tail"))
    humanoid.until(humanoid.told, "the refusal")
    humanoid.run(1.0)
    assert humanoid.world.told("ros2_refused") == ["/teleop on /joint_trajectory: there is no joint 'tail'"]
    assert humanoid.world.frames == []
