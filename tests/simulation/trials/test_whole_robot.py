"""What stops motion, of whole robots in virtual time: from the command to the bytes on a device's line, exact to a round."""

import tempfile
from contextlib import closing
from math import radians
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from lbr.bus import keys, stamp
from lbr.bus.memory import MemoryTransport
from lbr.capability import Capability, Kind, NoSettings
from lbr.capability.stage import ROUND_S, alone
from lbr.commands.rows import opened, planned
from lbr.leases.client import LeaseClient, LeaseTarget
from lbr.messages.behaviour import BehaviourRow, BehaviourTable, RunBehaviour
from lbr.messages.drive import DriveCommand
from lbr.messages.gamepad import GamepadState
from lbr.messages.joints import JointsCommand, TorqueCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.motors import MotorSetpoint
from lbr.messages.rows import row_set
from lbr.messages.system import EstopAcknowledgement
from lbr.simulation.requests import PlaceRequest
from lbr.simulation.twins import ServoBus
from tests.support.robot import prepare
from tests.support.whole_robot import WholeRobot

pytestmark = pytest.mark.timeout(30)
TTL_S, VALID_S, TICK_S = 0.3, 0.1, 0.02
"""A drive's lease; how old a setpoint may be, and how often the motors are told."""
STAND, CUT = b"!M 0 0\r", b"!EX\r"
BASE = ("world", "motors", "ranges", "drive")
WHEELED = (*BASE, "imu", "attitude", "odometry", "battery", "behaviour", "teleop")
ELBOW = "left_elbow"
WAYS = (("world", "pose"), ("odometry", "state"), ("attitude", "state"))
DEVICES = frozenset({"roboteq", "ultrasonic_ring", "mpu9150", "dynamixel", "uxa90"})
"""Those with twins on lines; others, as cameras, are left out."""
EDITS = (
    "UPDATE capability SET settings = json_set(settings, '$.guard', json('false')) WHERE kind IN ('roboteq', 'dynamixel', 'uxa90')",
    "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'teleop'",
    "INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'pad', 'gamepad', '/dev/input/event0')",
    """INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'gamepad', 'gamepad', '{"device": "pad"}')""",
)
"""A guard is a process of its own, and what it does is tested there."""


@pytest.fixture(scope="module")
def home():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h", whole=True, edits=EDITS)


def units_of(home, robot, names):
    with opened(home / "robot.db") as database:
        plan, problems = planned(database.load(robot))
    assert plan is not None, problems
    configs = {name: plan.units[name].config for name in names}
    return {
        name: replace(one, devices=tuple(device for device in one.devices if device.type in DEVICES))
        for name, one in configs.items()
    }


@pytest.fixture(scope="module")
def wheeled(home):
    units = units_of(home, "lbr", WHEELED)
    lines = (
        {"type": "start", "state": "Going", "outputs": {"level": "0.4", "angle": "0"}, "next_state": "Going"},
        {"type": "end", "state": "There"},
    )
    rows = tuple(BehaviourRow(behaviour="ahead", step=at, **line) for at, line in enumerate(lines, start=1))
    tables = {
        BehaviourTable.TABLE: row_set(BehaviourTable, (BehaviourTable(name="ahead"),)),
        BehaviourRow.TABLE: row_set(BehaviourRow, rows),
    }
    return {**units, "behaviour": replace(units["behaviour"], rows={**units["behaviour"].rows, **tables})}


class Driven(WholeRobot):
    """A robot on wheels that drives ahead: `turned` are the times at which its controller was told to turn a wheel."""

    def __init__(self, patch, units, home):
        super().__init__(patch, units, home)
        self.sent_s = 0.0
        self.run(0.7)
        self.twin = self.twins["motor_controller"]

    @property
    def commands(self):
        return [(at, data) for at, data in self.written["motor_controller"] if data.startswith(b"!")]

    @property
    def turned(self):
        return [at for at, data in self.commands if data.startswith(b"!M ") and data != STAND]

    def first(self, data, since_s):
        """Return after how long it was told something; to a millisecond."""
        return round(next(at for at, said in self.commands if at > since_s and said == data) - since_s, 3)

    def drive(self, lease="", power=0.3):
        self.sent_s = self.stage.now
        return self.ask("drive", "command", DriveCommand(power=power, angle_deg=0.0, ttl_s=TTL_S, lease=lease))

    def driving(self):
        reply = self.drive()
        assert reply.accepted, reply
        for _ in range(5):
            self.run(0.1)
            assert self.drive(reply.lease).accepted
        assert self.turned[-1] > self.stage.now - 2 * TICK_S
        return reply.lease

    def stands(self, for_s=2 * TTL_S):
        """Say whether from now on no wheel is told to turn, and none does."""
        since_s = self.stage.now
        self.run(for_s)
        return not any(at > since_s for at in self.turned) and not any(self.twin.wheels(self.stage.now))


@pytest.fixture
def robot(monkeypatch, wheeled, home):
    """Its base alone, for what its other capabilities have no part in."""
    with closing(Driven(monkeypatch, {name: wheeled[name] for name in BASE}, home)) as robot:
        yield robot


@pytest.fixture
def whole(monkeypatch, wheeled, home):
    with closing(Driven(monkeypatch, wheeled, home)) as robot:
        yield robot


def test_a_lease_that_nobody_renews_lapses_to_the_round_and_nothing_resumes(robot):
    robot.driving()
    robot.run(TTL_S)
    assert TTL_S - TICK_S <= robot.first(STAND, robot.sent_s) <= TTL_S
    assert robot.stands()


def test_the_same_robot_says_the_same_bytes_at_the_same_times(monkeypatch, wheeled, home):
    said = []
    for _ in range(2):
        with closing(Driven(monkeypatch, wheeled, home)) as robot:
            robot.driving()
            said.append(robot.commands)
    assert said[0] == said[1]


def test_who_renews_in_time_goes_on(robot):
    lease = robot.driving()
    for _ in range(10):
        robot.run(TTL_S - 0.1)
        assert robot.drive(lease).accepted
    assert robot.turned[-1] > robot.stage.now - 2 * TICK_S


@pytest.mark.parametrize("power", [b"NaN", b"null", b"Infinity", b"1e999"])
def test_a_power_that_is_no_number_is_refused_and_moves_nothing(robot, power):
    command = b'{"power": %s, "angle_deg": 0, "ttl_s": 0.3}' % power
    robot.stage.bus.carry(keys.port("lbr", "drive", "command"), command, b"")
    assert robot.stands(0.5)
    assert (robot.turned, robot.stage.told[-1].subject, robot.stage.told[-1].code) == ([], "drive", "malformed")


def test_a_setpoint_that_gives_a_motor_no_number_stops_it_and_its_lease_is_dead_for_good(robot):
    lease = robot.driving()
    told_s = robot.stage.now
    setpoint = keys.port("lbr", "motors", "setpoint")
    robot.stage.put(setpoint, MotorSetpoint(left=0.0, right=0.0, motors={"left": 0.3}, lease=lease), "drive")
    robot.run(0.1)
    assert robot.first(STAND, told_s) <= 2 * ROUND_S + TICK_S
    assert robot.stands()
    robot.stage.put(setpoint, MotorSetpoint(left=0.3, right=0.3, lease=lease), "drive")
    assert robot.stands()


def test_an_emergency_stop_cuts_the_power_in_the_next_round_and_is_acknowledged(robot):
    said = []
    key = keys.estop_acknowledgement("lbr", "motors")
    robot.stage.listen(key, EstopAcknowledgement, said.append)
    lease = robot.driving()
    pressed_s = robot.stage.now
    robot.stage.press("test")
    robot.run(0.1)
    assert robot.first(CUT, pressed_s) == ROUND_S
    assert robot.first(STAND, pressed_s) < 2 * ROUND_S
    assert (said[-1].engaged, said[-1].stopped) == (True, True)
    assert (robot.drive(lease).code, robot.drive().code) == ("dead_lease", "estop")
    assert robot.stands()


def test_a_robot_that_was_reset_stands_until_somebody_drives_it_anew(whole):
    lease = whole.driving()
    whole.stage.press("test")
    whole.run(0.5)
    assert whole.reset() == dict.fromkeys(("motors", "drive", "behaviour"), True)
    assert whole.stands()
    assert whole.drive(lease).code == "dead_lease"
    assert whole.stands(0.5)
    assert whole.driving()


def test_a_stop_command_stops_the_motors_within_a_tick(robot):
    lease = robot.driving()
    asked_s = robot.stage.now
    assert robot.ask("drive", "stop", StopCommand(reason="test")).accepted
    assert robot.first(STAND, asked_s) <= ROUND_S + TICK_S
    assert robot.stands()
    assert not robot.drive(lease).accepted


def test_a_frozen_drive_is_given_up_by_the_motors_as_its_last_setpoint_is_too_old(robot):
    robot.driving()
    frozen_s = robot.stage.now
    robot.stage.members["drive"].frozen = True
    robot.run(0.5)
    assert VALID_S <= robot.first(STAND, frozen_s) <= VALID_S + TICK_S
    robot.stage.members["drive"].frozen = False
    assert robot.stands()


def test_a_drive_that_is_killed_is_missed_at_the_next_tick_and_gives_no_answer(robot):
    lease = robot.driving()
    killed_s = robot.stage.now
    robot.stage.kill("drive")
    robot.run(0.1)
    assert robot.first(STAND, killed_s) <= TICK_S + ROUND_S
    assert robot.stands()
    assert robot.drive(lease) is None


def test_a_frozen_driver_leaves_the_wheels_to_the_controllers_watchdog(robot):
    robot.driving()
    robot.stage.members["motors"].frozen = True
    last_s, watchdog_s = robot.commands[-1][0], robot.stage.members["motors"].ctx.settings.watchdog_ms / 1000.0
    robot.run(watchdog_s - 2 * ROUND_S - (robot.stage.now - last_s))
    assert any(robot.twin.wheels(robot.stage.now))
    robot.run(3 * ROUND_S)
    assert not any(robot.twin.wheels(robot.stage.now))
    robot.stage.members["motors"].frozen = False
    assert robot.stands()


def test_a_controller_that_was_unplugged_does_not_go_on_when_it_is_back(robot):
    states = robot.stage.hear("motors", "state")
    robot.driving()
    robot.twin.fault("unplug", value=True)
    robot.run(1.0)
    assert robot.stage.members["motors"].reporter.reported[::2] == ("degraded", "unplugged")
    assert not states[-1].armed
    robot.twin.fault("unplug", value=False)
    robot.run(3.0)
    assert robot.stage.members["motors"].reporter.reported[0] == "ready"
    assert robot.stands()
    assert robot.driving()


def test_it_stops_before_a_wall_by_what_its_range_board_says(robot):
    poses = robot.stage.hear("world", "pose")
    box = PlaceRequest(name="box", x_m=1.3, y_m=0.0, length_m=0.2, width_m=1.0)
    assert robot.ask("world", "place", box).accepted
    lease = robot.driving()
    while robot.drive(lease).accepted and robot.turned[-1] > robot.stage.now - 0.5:
        robot.run(0.1)
    assert robot.stands()
    assert 0.2 < poses[-1].x_m < 1.2
    assert not any(pose.touching for pose in poses)


def test_a_range_board_that_falls_silent_stops_a_drive(robot):
    lease = robot.driving()
    robot.twins["range_board"].fault("silent", value=True)
    silent_s = robot.stage.now
    while (reply := robot.drive(lease)).accepted and robot.stage.now < silent_s + 2.0:
        robot.run(0.1)
    assert not reply.accepted
    assert robot.turned[-1] - silent_s < 1.0
    assert robot.stands()


def board_says(robot, **faults):
    for name, value in faults.items():
        robot.twins["range_board"].fault(name, value=value)


@pytest.fixture
def rested(robot):
    """Its base and what its range board says, which has not changed for a while."""
    heard = robot.stage.hear("ranges", "readings")
    robot.run(2.0)
    heard.clear()
    return robot, heard


def test_distances_of_a_standing_base_are_said_twice_a_second_and_a_change_within_a_frame(rested):
    robot, heard = rested
    robot.run(4.0)
    assert 7 <= len(heard) <= 9
    assert all(one.rests for one in heard)
    heard.clear()
    board_says(robot, range_forward_m=0.9)
    robot.run(0.25)
    assert next(one for one in heard if not one.rests).forward_m == 0.9
    robot.run(0.75)
    assert len(heard) > 6
    robot.run(1.0)
    assert heard[-1].rests


def test_a_base_at_rest_turns_its_wheels_as_soon_as_one_whose_distances_are_new(rested):
    robot, heard = rested
    took_s = []
    for rests_s in (0.05, 0.3, 0.5, 3.0):
        robot.run(rests_s)
        assert robot.drive().accepted
        asked_s = robot.sent_s
        robot.run(0.3)
        took_s.append(round(next(at for at in robot.turned if at > asked_s) - asked_s, 3))
        assert not heard[-1].rests
    assert max(took_s) <= ROUND_S + TICK_S


def test_a_range_board_that_is_pulled_from_a_standing_base_is_missed_by_the_next_command(rested):
    robot, heard = rested
    board_says(robot, unplug=True)
    robot.run(0.2)
    assert set(heard[-1].status.values()) == {"missing"}
    assert robot.drive().code == "stale_sensor"
    assert not robot.turned


def test_a_frozen_range_driver_stops_a_motion_from_rest_in_its_usual_time_and_refuses_the_next(rested):
    robot, _ = rested
    robot.stage.members["ranges"].frozen = True
    robot.run(0.5)
    reply = robot.drive()
    began_s = robot.sent_s
    for _ in range(8):
        robot.run(0.1)
        robot.drive(reply.lease)
    assert 0.2 < robot.turned[-1] - began_s <= 0.3 + TICK_S
    robot.run(1.0)
    assert robot.drive().code == "stale_sensor"
    assert robot.stands()


def test_a_reader_that_comes_late_gets_the_last_distances_and_how_old_they_are(rested):
    robot, heard = rested
    heard.clear()
    while not heard:
        robot.round()
    said_s = robot.stage.now
    robot.run(0.3)
    key = keys.port("lbr", "ranges", "readings")
    (raw,) = MemoryTransport(robot.stage.bus).newest([key], source="late", timeout_s=1.0)
    assert msgspec.json.decode(raw.payload)["forward_m"] == heard[-1].forward_m
    assert raw.arrived == pytest.approx(said_s, abs=1.5 * ROUND_S)


def test_what_it_knows_of_its_way_is_what_it_did_in_its_world(whole):
    poses, ways, attitudes = (whole.stage.hear(*one) for one in WAYS)
    whole.run(0.5)
    turned_deg = attitudes[-1].turned_deg
    for angle_deg in (0.0, 90.0):
        lease = ""
        for _ in range(6):
            command = DriveCommand(power=0.2, angle_deg=angle_deg, ttl_s=TTL_S, lease=lease)
            lease = whole.ask("drive", "command", command).lease
            whole.run(0.1)
        whole.ask("drive", "stop", StopCommand(reason="test"))
        whole.run(1.0)
    pose, way = poses[-1], ways[-1]
    assert (way.x_m, way.y_m, way.yaw_rad) == pytest.approx((pose.x_m, pose.y_m, pose.yaw_rad), abs=0.01)
    assert radians(attitudes[-1].turned_deg - turned_deg) == pytest.approx(-pose.yaw_rad, abs=0.01)
    assert (pose.x_m > 0.05, pose.yaw_rad < -0.5) == (True, True)


def test_a_table_drives_and_ends_with_its_process(whole):
    assert whole.ask("behaviour", "run", RunBehaviour(name="ahead")).accepted
    whole.run(1.0)
    assert whole.turned[-1] > whole.stage.now - 2 * TICK_S
    killed_s = whole.stage.now
    whole.stage.kill("behaviour")
    whole.run(1.0)
    assert whole.turned[-1] - killed_s < 0.6
    assert whole.stands()


class Borrows(Capability[NoSettings]):
    """Borrows the drive for whoever says so, and never gives it back."""

    lease: LeaseClient | None = None

    def command(self, call):
        self.lease = LeaseClient(self.ctx, LeaseTarget("go"), DriveCommand(power=0.3, angle_deg=90.0))
        call.reply(CommandReply(accepted=True))

    def step(self):
        if self.lease is not None:
            self.lease.step()


BORROWS = Kind(
    name="borrows",
    summary="borrows the drive",
    family="app",
    entry=Borrows,
    commands={"start": StopCommand},
    requests={"go": DriveCommand},
    replies={"start": CommandReply, "go": CommandReply},
)


@pytest.mark.parametrize(("asker", "code"), [("page", "stopped_since"), ("test", None)])
def test_what_a_capability_borrows_for_a_command_moves_nothing_that_another_stopped_since_it_was_written(
    robot, asker, code
):
    requests = {"go": {"drive": keys.port("lbr", "drive", "command")}}
    borrows = robot.stage.add(replace(alone(BORROWS, robot="lbr"), requests=requests), BORROWS)
    robot.run(0.3)
    written_s = robot.stage.now
    assert robot.ask("drive", "stop", StopCommand(whole=True)).accepted
    start, origin = keys.port("lbr", "borrows", "start"), stamp.Origin(asker, written_s)
    MemoryTransport(robot.stage.bus).query(start, b"{}", timeout_s=1.0, source="web", origin=origin)
    robot.run(0.2)
    assert borrows.lease.ended.code == code if code else borrows.lease.accepted
    assert bool(robot.turned) == (code is None)


class Pad:
    """A gamepad whose driver tells fifty times a second what is held."""

    def __init__(self, robot):
        self.robot = robot
        robot.stage.bus.show("gamepad")

    def hold(self, seconds, **held):
        for _ in range(round(seconds / TICK_S)):
            state = GamepadState(connected=True, silent_s=0.0, **held)
            self.robot.stage.put(keys.port("lbr", "gamepad", "state"), state, "gamepad")
            self.robot.run(TICK_S)


def test_a_hand_on_a_gamepad_takes_the_base_once_who_has_it_lets_go_and_its_motion_ends_with_the_hand(whole):
    pad = Pad(whole)
    pad.hold(0.5)
    states = whole.stage.hear("drive", "state")
    whole.driving()
    pad.hold(0.1, pressed=("tl",))
    pad.hold(0.1, pressed=("tl",), axes={"left_y": 1.0})
    assert states[-1].holder == "test", "it is held"
    pad.hold(0.5)
    pad.hold(0.1, pressed=("tl",))
    pad.hold(0.5, pressed=("tl",), axes={"left_y": 1.0})
    assert (states[-1].holder, whole.drive().code) == ("teleop", "held")
    assert whole.turned[-1] > whole.stage.now - 2 * TICK_S
    let_go_s = whole.stage.now
    pad.hold(0.5)
    assert whole.turned[-1] - let_go_s <= 0.1
    assert whole.stands()


class Posed(WholeRobot):
    """A humanoid with torque that bends an elbow: `goals` are that servo's, and since when."""

    def __init__(self, patch, units, home):
        super().__init__(patch, units, home)
        self.goals, self.servo, self.sent_s = [], None, 0.0
        self.run(0.5)
        assert self.ask("joints", "torque", TorqueCommand(on=True)).accepted
        states = self.stage.hear("joints", "state")
        self.run(0.5)
        elbow = states[-1].joints[ELBOW]
        self.servo, self.bent_rad = elbow.id, elbow.position_rad - 0.8
        self.bus = next(twin for twin in self.twins.values() if isinstance(twin, ServoBus))

    @property
    def motor(self):
        return self.bus.drives(self.stage.now)[self.servo]

    def round(self):
        super().round()
        if self.servo is not None and (not self.goals or self.goals[-1][1] != self.motor.goal_rad):
            self.goals.append((self.stage.now, self.motor.goal_rad))

    def bend(self, lease=""):
        self.sent_s = self.stage.now
        positions = {} if lease else {ELBOW: self.bent_rad}
        command = JointsCommand(positions=positions, ttl_s=TTL_S, speed_rps=0.5, lease=lease)
        return self.ask("joints", "command", command)

    def bending(self):
        reply = self.bend()
        assert reply.accepted, reply
        for _ in range(3):
            self.run(0.1)
            assert self.bend(reply.lease).accepted
        assert self.goals[-1][0] > self.stage.now - 3 * ROUND_S
        return reply.lease

    def ended(self, since_s):
        """Let time go by, and return after how long the last goal came, to a millisecond."""
        self.run(2 * TTL_S)
        return round(self.goals[-1][0] - since_s, 3)

    def holds(self):
        """Say whether its servo stays where it is, with torque."""
        goals = len(self.goals)
        self.run(0.5)
        return len(self.goals) == goals and self.motor.torque == 1.0


@pytest.fixture(scope="module", params=("bioloid", "uxa90"))
def jointed(request, home):
    return units_of(home, request.param, ("world", "servos", "joints"))


@pytest.fixture
def posed(monkeypatch, jointed, home):
    with closing(Posed(monkeypatch, jointed, home)) as posed:
        yield posed


def test_servos_whose_lease_lapses_end_their_motion_with_it_and_hold(posed):
    lease = posed.bending()
    assert TTL_S - 2 * ROUND_S <= posed.ended(posed.sent_s) <= TTL_S
    assert posed.holds()
    assert posed.bend(lease).code == "dead_lease"


def test_servos_whose_joints_freeze_hold_once_the_last_setpoint_is_too_old_and_do_not_go_on(posed):
    posed.bending()
    frozen_s = posed.stage.now
    posed.stage.members["joints"].frozen = True
    assert posed.ended(frozen_s) <= VALID_S + ROUND_S
    posed.stage.members["joints"].frozen = False
    assert posed.holds()


def test_servos_whose_joints_are_killed_hold_in_the_next_round(posed):
    posed.bending()
    killed_s = posed.stage.now
    posed.stage.kill("joints")
    assert posed.ended(killed_s) <= ROUND_S
    assert posed.holds()


def test_an_emergency_stop_holds_servos_in_the_next_round_or_brakes_them(posed):
    said = []
    posed.stage.listen(keys.estop_acknowledgement(posed.stage.robot, "servos"), EstopAcknowledgement, said.append)
    lease = posed.bending()
    pressed_s = posed.stage.now
    posed.stage.press("test")
    assert posed.ended(pressed_s) <= ROUND_S
    assert (said[-1].engaged, said[-1].stopped) == (True, True)
    assert posed.motor.brake or posed.holds()
    assert (posed.bend(lease).code, posed.bend().code) == ("dead_lease", "estop")


def test_a_place_that_is_no_number_is_refused_and_moves_nothing(posed):
    posed.run(0.1)
    key = keys.port(posed.stage.robot, "joints", "command")
    posed.stage.bus.carry(key, b'{"positions": {"%s": NaN}}' % ELBOW.encode(), b"")
    assert posed.holds()
    assert ("joints", "malformed") in {(event.subject, event.code) for event in posed.stage.told}


def test_servos_that_have_no_sender_any_more_fade_after_their_time(monkeypatch, jointed, home):
    settings = {**msgspec.json.decode(jointed["servos"].settings), "hold_s": 0.5, "release_s": 0.5}
    servos = replace(jointed["servos"], settings=msgspec.Raw(msgspec.json.encode(settings)))
    with closing(Posed(monkeypatch, {**jointed, "servos": servos}, home)) as posed:
        posed.stage.kill("joints")
        posed.run(0.4)
        assert posed.motor.torque == 1.0
        posed.run(0.4)
        assert 0.0 < posed.motor.torque < 1.0
        posed.run(0.4)
        assert posed.motor.torque == 0.0
