"""What stops motion, in virtual time: the robot's own drive in its world, over a bus in memory, exact to a round."""

import tempfile
from pathlib import Path

import pytest
from msgspec import Raw, Struct
from msgspec.structs import replace

from lbr.bus import keys, stamp, wire
from lbr.bus.lease_client import LeaseClient, LeaseTarget
from lbr.capability import Capability, Kind, NoSettings
from lbr.capability.config import InputWire, OutputWire, ProcessConfig
from lbr.capability.stage import ROUND_S, Stage
from lbr.commands.behaviour_trials import setup_of
from lbr.commands.rows import opened
from lbr.errors import DeviceError
from lbr.lockstep.faults import NONE
from lbr.lockstep.trial import Trial
from lbr.messages.behaviour import BehaviourRow, BehaviourTable, RunBehaviour
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.motors import MotorSetpoint
from lbr.simulation.settings import StartPose
from tests.support.robot import prepare

pytestmark = pytest.mark.timeout(30)
TTL_S = 0.3


@pytest.fixture(scope="module")
def home():
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h", whole=True)


@pytest.fixture(scope="module")
def of(home):
    table = BehaviourTable(name="ahead")
    lines = (
        {"type": "start", "state": "Going", "outputs": {"level": "0.4", "angle": "0"}, "next_state": "Going"},
        {"type": "end", "state": "There"},
    )
    with opened(home / "robot.db") as database:
        given = tuple(BehaviourRow(behaviour="ahead", step=at, **line) for at, line in enumerate(lines, start=1))
        return setup_of(database.load("lbr"), table, given, 60.0, str(home))


class Driven:
    """A robot that drives ahead: `moved` are the times at which the drive wanted its wheels to turn."""

    def __init__(self, of, faults=NONE, start=None):
        self.trial = Trial(of, 0, start or StartPose(), faults=faults)
        self.stage = self.trial.board
        self.moved = []
        for feeds in of.units.values():
            for port in feeds.outputs.get("setpoint", ()):
                self.stage.listen(port.key, MotorSetpoint, self._hear)
        self.trial.warm_up()

    def _hear(self, setpoint):
        if setpoint.left or setpoint.right:
            self.moved.append(self.stage.now)

    def drive(self, lease="", **more):
        command = DriveCommand(power=0.3, angle_deg=0.0, ttl_s=TTL_S, lease=lease, **more)
        return self.asked("drive", "command", command)

    def asked(self, name, what, message):
        asked = self.stage.command(name, what, message, "test")
        while (answers := asked.answers()) is None:
            self.trial.round()
        return answers[name]

    def driving(self):
        reply = self.drive()
        assert reply.accepted, reply
        for _ in range(5):
            self.trial.rounds(0.1)
            assert self.drive(reply.lease).accepted
        assert self.moved
        assert self.moved[-1] > self.stage.now - 0.1
        return reply.lease


def test_a_lease_that_nobody_renews_lapses_after_its_time_and_nothing_resumes(of):
    robot = Driven(of)
    robot.driving()
    renewed_s = robot.stage.now
    robot.trial.rounds(2.0)
    stopped_after_s = robot.moved[-1] - renewed_s
    assert TTL_S - 0.1 < stopped_after_s <= TTL_S + 0.6  # the ramp down is the drive's own
    at_x = robot.trial.instruments.pose.x_m
    robot.trial.rounds(2.0)
    assert robot.trial.instruments.pose.x_m == at_x


def test_who_renews_in_time_goes_on(of):
    robot = Driven(of)
    lease = robot.driving()
    for _ in range(10):
        robot.trial.rounds(TTL_S - 0.1)
        assert robot.drive(lease).accepted
    assert robot.moved[-1] > robot.stage.now - 0.1


def test_a_press_stops_the_wheels_within_a_few_rounds_and_a_command_is_refused(of):
    robot = Driven(of)
    lease = robot.driving()
    robot.stage.press("test")
    pressed_s = robot.stage.now
    robot.trial.rounds(1.0)
    assert robot.moved[-1] - pressed_s <= 3 * ROUND_S
    assert (robot.drive(lease).code, robot.drive().code) == ("dead_lease", "estop")
    robot.trial.rounds(1.0)
    assert robot.moved[-1] - pressed_s <= 3 * ROUND_S


def test_wheels_stand_when_the_drive_is_killed_and_its_sender_gets_no_answer(of):
    robot = Driven(of)
    lease = robot.driving()
    robot.stage.kill("drive")
    robot.trial.rounds(0.2)
    assert robot.trial.instruments.powers == {}
    assert robot.drive(lease) is None


def test_wheels_stand_while_the_drive_is_frozen_and_do_not_go_on_when_it_wakes(of):
    robot = Driven(of)
    robot.driving()
    robot.stage.members["drive"].frozen = True
    robot.trial.rounds(1.0)
    assert robot.trial.instruments.powers == {}
    robot.stage.members["drive"].frozen = False
    woken_s = robot.stage.now
    robot.trial.rounds(1.0)
    assert all(at < woken_s for at in robot.moved)


def test_ranges_that_end_stop_a_drive(of):
    robot = Driven(of)
    lease = robot.driving()
    robot.trial.instruments._faults = replace(NONE, blind_s=0.0)
    for _ in range(20):
        robot.trial.rounds(0.1)
        reply = robot.drive(lease)
    assert not reply.accepted
    assert robot.moved[-1] < robot.stage.now - 0.5


def test_a_setpoint_without_the_drives_seal_reaches_no_port():
    bus, heard = Stage("r"), []

    class Motor(Capability[NoSettings]):
        def step(self):
            heard.extend(one.message.left for one in self.ctx.take("setpoint"))

    kind = Kind(name="motor", summary="turns", family="driver", entry=Motor, setpoints={"setpoint": MotorSetpoint})
    key = keys.port("r", "motor", "setpoint")
    wires = {"setpoint": (InputWire(key=key, source="drive", seal="ab" * 16),)}
    bus.add(config("motor", wiring=wires), kind)
    bus.bus.publish(key, MotorSetpoint(left=0.9, right=0.9), "intruder")
    bus.run(0.2)
    bus.put(key, MotorSetpoint(left=0.1, right=0.1), "drive")
    bus.run(0.5)
    assert heard == [0.1]
    assert [(one.kind, one.code) for one in bus.told] == [("refused", "denied")]


def test_a_table_ends_when_its_behaviours_process_is_killed(of):
    robot = Driven(of)
    assert robot.asked(robot.trial._runs, "run", RunBehaviour(name="ahead")).accepted
    robot.trial.rounds(1.5)
    assert robot.moved[-1] > robot.stage.now - 0.1
    killed_s = robot.stage.now
    robot.stage.kill(robot.trial._runs)
    robot.trial.rounds(3.0)
    assert robot.moved[-1] - killed_s < 1.5
    pose = robot.trial.instruments.pose
    assert pose.speed_mps == pytest.approx(0.0, abs=0.01)


def test_a_stop_ends_what_drives(of):
    robot = Driven(of)
    lease = robot.driving()
    assert robot.asked("drive", "stop", StopCommand(reason="test")).accepted
    stopped_s = robot.stage.now
    robot.trial.rounds(1.0)
    assert robot.moved[-1] - stopped_s <= 3 * ROUND_S
    assert not robot.drive(lease).accepted


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
    of, asker, code
):
    robot = Driven(of)
    requests = {"go": {"drive": keys.port(robot.stage.robot, "drive", "command")}}
    borrows = robot.stage.add(replace(config("borrows", requests=requests), robot=robot.stage.robot), BORROWS)
    robot.trial.rounds(0.3)
    written_s = robot.stage.now
    assert robot.asked("drive", "stop", StopCommand(whole=True)).accepted
    start, origin = keys.port(robot.stage.robot, "borrows", "start"), stamp.Origin(asker, written_s)
    robot.stage._outside.query(start, b"{}", timeout_s=1.0, source="web", origin=origin)
    robot.trial.rounds(0.2)
    assert borrows.lease.ended.code == code if code else borrows.lease.accepted
    assert bool(robot.moved) == (code is None)


class Told(Struct):
    """A number."""

    number: float = 0.0


def config(name, **more):
    return ProcessConfig(
        robot="r", name=name, kind=name, settings=Raw(b"{}"), endpoints=(), home="/nonexistent", **more
    )


class Odd(Capability[NoSettings]):
    """Publishes what it is made to, and raises what it is asked for."""

    value: object = 1.0

    def step(self):
        self.ctx.publish("state", Told(number=self.value))

    def command(self, call):
        raise DeviceError("the line is cut", "unplugged") if call.message.number else RuntimeError("a defect")


ODD = Kind(name="odd", summary="is odd", family="app", entry=Odd, outputs={"state": Told}, commands={"do": Told})


@pytest.fixture
def odd():
    stage = Stage("r")
    key = keys.port("r", "odd", "state")
    stage.heard = []
    stage.listen(key, Told, lambda told: stage.heard.append(told.number))
    stage.capability = stage.add(config("odd", outputs={"state": (OutputWire(key=key),)}), ODD)
    stage.run(0.3)
    return stage


def test_a_value_that_its_declaration_does_not_allow_is_not_published_and_reported_once(odd):
    odd.capability.value = "fast"
    odd.run(0.1)
    seen = len(odd.heard)
    odd.run(1.0)
    assert (len(odd.heard), set(odd.heard)) == (seen, {1.0})
    assert [(one.kind, one.code, one.subject) for one in odd.told] == [("refused", "malformed", "odd")]
    odd.capability.value = 2.0
    odd.run(0.5)
    assert odd.heard[-1] == 2.0
    odd.capability.value = object()
    odd.run(0.5)
    assert len(odd.told) == 2


def test_a_handler_that_raises_is_the_answer_before_its_process_ends(odd):
    asked = odd.command("odd", "do", Told(), "test")
    with pytest.raises(RuntimeError, match="a defect"):
        odd.run(0.1)
    odd.kill("odd")
    odd.run(0.05)
    answer = asked.answers()["odd"]
    assert (answer.accepted, answer.code) == (False, "failed")
    assert "a defect" in answer.reason


def test_a_device_that_is_lost_in_a_handler_is_the_answer_and_the_next_command_waits_for_it(odd):
    answer = odd.answer("odd", "do", Told(number=1.0))
    assert (answer.accepted, answer.code) == (False, "unplugged")
    assert odd.members["odd"].reporter.said[::2] == ("degraded", "unplugged")
    odd.run(1.0)
    assert odd.members["odd"].reporter.said[0] == "ready"


def test_a_question_to_one_that_is_frozen_ends_at_its_time_and_to_one_that_is_gone_at_once(odd):
    odd.members["odd"].frozen = True
    asked = odd.command("odd", "do", Told(), "test", 0.5)
    odd.run(0.49)
    assert asked.answers() is None
    odd.run(0.02)
    assert asked.answers() == {"odd": None}
    odd.kill("odd")
    asked = odd.command("odd", "do", Told(), "test", 0.5)
    odd.run(0.01)
    assert asked.answers() == {"odd": None}


def test_what_is_sent_later_in_a_round_is_the_newer(odd):
    first, second = (stamp.read(odd._outside.publisher("k", "s").put(Told())) for _ in range(2))
    assert first.mono_ns < second.mono_ns
    assert stamp.genuine(first, wire.encode(Told()), b"") is False
