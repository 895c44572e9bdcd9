"""A family of servos that lbr does not know, with its twin: what it gets by bringing a bus, a model and a release program."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from lbr.capability.context import Device
from lbr.capability.faults import faults
from lbr.drivers.servos.protocol1 import packet
from lbr.messages.joints import Joint
from lbr.messages.servos import RecoverServos, ServoGoal, ServoSetpoint
from lbr.simulation.twins import ServoBus, Surroundings
from lbr.testing.context import FakeCall
from tests.drivers.peers import DriverContext, until
from tests.drivers.sts.driver import KIND, RAD_PER_STEP, Sts, StsBus
from tests.drivers.sts.twin import TWIN
from tests.support import programs

IDS = (1, 2, 3, 4, 5, 6)
LINES = 1200
SETTINGS = '{"device": "servos", "guard": false, "reply_margin_s": 0.05, "hold_s": 0.2, "release_s": 0.2}'
DRIVER = """
import sys, time
from lbr.messages.servos import ServoGoal, ServoSetpoint
from tests.drivers.sts.driver import KIND, Sts
from tests.drivers.test_servos_from_outside import IDS, context
ctx = context(sys.argv[1], '{"device": "servos", "reply_margin_s": 0.05, "hold_s": 0.2, "release_s": 0.2}')
servos = Sts(ctx)
servos.open()
while True:
    ctx.give(ServoSetpoint(goals=tuple(ServoGoal(id=n, position_rad=0.5) for n in IDS), lease="a"), source="joints")
    servos.step()
    time.sleep(0.005)
"""


def context(address, settings=SETTINGS):
    ctx = DriverContext(KIND.parse(settings), address, "feetech")
    ctx.wired["setpoint"] = ("joints",)
    ctx.given = tuple(Joint(name=f"j{n}", device_id=n, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0) for n in IDS)
    return ctx


@pytest.fixture
def twin(tmp_path):
    twin = TWIN.load()(Device("servos", "feetech", str(tmp_path / "tty"), {}), Surroundings(1, 0.0))
    ending = threading.Event()

    def serve():
        while not ending.is_set():
            twin.service(time.monotonic())
            time.sleep(0.0005)

    thread = threading.Thread(target=serve)
    thread.start()
    until(twin.port.path.exists)
    yield twin
    ending.set()
    thread.join()
    twin.close()


class Rig:
    """The driver in this process, and a sender that says the same until told otherwise."""

    def __init__(self, twin):
        self.twin = twin
        self.ctx = context(twin.port.path)
        self.driver = Sts(self.ctx)
        self.driver.open()
        self.goals = None
        self.lease = "a"

    def until(self, condition):
        def step():
            if self.goals is not None:
                self.ctx.give(ServoSetpoint(goals=self.goals, lease=self.lease), source="joints")
            self.driver.step()
            time.sleep(0.001)
            return bool(self.ctx.published) and condition()

        until(step, 6.0)

    def send(self, **goal):
        self.goals = tuple(ServoGoal(id=number, **goal) for number in IDS)

    def each(self, check):
        return bool(self.ctx.state.servos) and all(map(check, self.ctx.state.servos))

    @property
    def torques(self):
        return [servo.torque for servo in self.twin.servos.values()]


@pytest.fixture
def rig(twin):
    rig = Rig(twin)
    yield rig
    rig.driver.close()


@pytest.mark.parametrize(
    ("request_", "expected"),
    [
        (packet.ping(1), "FF FF 01 02 01 FB"),
        (packet.read(1, 56, 15), "FF FF 01 04 02 38 0F B1"),
        (packet.sync_read(56, 2, (1, 2)), "FF FF FE 06 82 38 02 01 02 3C"),
        (
            packet.sync_write(40, dict.fromkeys(IDS, b"\0"))[0],
            "FF FF FE 10 83 28 01 01 00 02 00 03 00 04 00 05 00 06 00 30",
        ),
        (packet.write(1, 31, b"\x74\x0e"), "FF FF 01 05 03 1F 74 0E 55"),
    ],
)
def test_the_shared_codec_says_what_the_vendor_says(request_, expected):
    assert request_ == bytes.fromhex(expected)


def test_the_family_is_one_package_of_few_lines_and_as_kinds_must_be():
    parts = (Path(__file__).parent / "sts").glob("*.py")
    assert sum(len(part.read_text().splitlines()) for part in parts) < LINES
    assert faults(KIND) == ()
    assert KIND.moves
    assert KIND.line == "polled"


def test_the_twin_moves_a_body(twin):
    assert isinstance(twin, ServoBus)
    assert all(drive.torque == 0.0 for drive in twin.drives(0.0).values())


def test_opening_moves_nothing_and_torque_comes_on_where_the_servos_are(rig):
    rig.until(lambda: rig.each(lambda servo: servo.voltage_v == 12.1))
    assert rig.ctx.state.phase == "released"
    assert not any(rig.torques)
    rig.send()
    rig.until(lambda: all(rig.torques) and rig.each(lambda servo: servo.torque == 1.0))
    assert [servo.word(42) for servo in rig.twin.servos.values()] == [2048 + number for number in IDS]
    assert rig.ctx.state.bus.sync_read


def test_goals_are_followed_and_a_silent_sender_ends_in_hold_fade_and_off(rig):
    rig.send(position_rad=-0.5, speed_rps=2.0)
    rig.until(lambda: all(rig.torques) and rig.each(lambda one: abs((one.position_rad or 0.0) + 0.5) < RAD_PER_STEP))
    rig.goals = None
    rig.until(lambda: rig.ctx.state.phase == "holding")
    rig.until(lambda: rig.ctx.state.phase == "released" and not any(rig.torques))


def test_the_emergency_stop_is_acknowledged_when_every_servo_was_read_to_hold(rig):
    rig.send(position_rad=0.3)
    rig.until(lambda: all(rig.torques))
    rig.ctx.estop.engaged = True
    rig.until(lambda: rig.ctx.estop.acknowledged[-1][0])
    assert all(rig.torques)


def test_an_overload_is_named_and_ends_the_torque_of_that_servo_alone(rig):
    rig.send(position_rad=0.3)
    rig.until(lambda: all(rig.torques))
    rig.twin.fault("overload", (3,))
    rig.until(lambda: rig.torques == [number != 3 for number in IDS])
    (latched,) = (servo for servo in rig.ctx.state.servos if servo.latched)
    assert (latched.id, latched.latched) == (3, ("overload",))
    assert latched.position_rad is not None


def test_a_silent_servo_is_named_and_the_others_go_on(rig):
    rig.send(position_rad=0.3)
    rig.until(lambda: all(rig.torques))
    rig.twin.fault("silent", (2,))
    rig.until(lambda: "does not answer" in rig.ctx.state.servos[1].reason)
    assert rig.each(lambda servo: servo.id == 2 or not servo.reason)


def test_a_servo_is_recovered_by_the_drivers_own_job(rig):
    rig.send(position_rad=0.3)
    rig.until(lambda: all(rig.torques))
    rig.twin.fault("overload", (3,))
    rig.until(lambda: any(servo.latched for servo in rig.ctx.state.servos))
    call = FakeCall("recover", RecoverServos())
    rig.driver.command(call)
    rig.until(lambda: call.answer is not None)
    assert "recovered, without torque: j3" in call.answer.reason


def test_a_killed_driver_leaves_servos_that_hold_and_are_then_let_go(twin):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", DRIVER, str(twin.port.path)]
    process = programs.start(command, stdout=subprocess.DEVNULL, env=environment)
    try:
        until(lambda: all(servo.torque and servo.word(42) > 2100 for servo in twin.servos.values()), 8.0)
    finally:
        process.kill()
        process.wait()
    time_held = time.monotonic()
    until(lambda: not any(servo.torque for servo in twin.servos.values()), 5.0)
    assert time.monotonic() - time_held > 0.3, "they were not held first"


def test_one_request_reads_all_servos_and_one_that_is_absent_holds_up_nobody(twin):
    from lbr.drivers.servos.protocol1.line import open_servo_line

    with StsBus(open_servo_line(Device("servos", "feetech", str(twin.port.path), {}), 1_000_000, 0.05)) as bus:
        positions = [seen and seen.position for seen in bus.read_together((1, 9, 6))]
    assert positions == [2049, None, 2054]
    assert bus.counts.timeouts == 1
