"""Servos at rest are read seldom, until one of them moves, is told something, or does not answer: in virtual time."""

from itertools import pairwise
from types import SimpleNamespace

import pytest

from lbr.capability.context import Device
from lbr.drivers.dynamixel import KIND, DynamixelSettings, table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.servos.capability import LOST_S, RATE_HZ, REST_HZ, Measured, Servos
from lbr.drivers.servos.poller import Poller
from lbr.drivers.servos.rest import BELIEVED_S, FULL_S, STILL_S, Rest
from lbr.messages.joints import Joint
from lbr.messages.servos import BusStatistics, ServoGoal, ServoSetpoint
from lbr.simulation.devices.dynamixel.bus import DynamixelBus
from lbr.simulation.devices.dynamixel.dongle import Usb2Ax
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.measured import ServoFelt
from lbr.testing import FakeContext
from tests.drivers.test_dynamixel_with_twin import TwinLine

IDS = range(1, 19)
SWEEP_S, REST_S = 0.01, 0.1
BAND_RAD, BAND_LOAD = 0.02, 0.15


class Robot:
    """Eighteen emulated servos, swept as a driver does."""

    def __init__(self, dongle):
        self.servos = {number: AxServo(number, position_rad=0.1 * (number - 9)) for number in IDS}
        self.emulated = DynamixelBus(list(self.servos.values()), dongle=Usb2Ax(dongle) if dongle else None, seed=4)
        self.line = TwinLine(self.emulated)
        self.bus = Bus(self.line, clock=self.clock)
        self.told, self.woken, self.sweeps, self.read = [], [], [], {}
        self.rest = Rest(self.clock, BAND_RAD, BAND_LOAD, lambda: self.woken.append(self.clock()))
        self.poller = Poller(IDS, self.clock, SWEEP_S, tell=self.tell, rest=self.rest, rest_period_s=REST_S)
        if dongle:
            self.bus.find_adapter()
        self.run(2.0)
        assert self.rest.lasts

    def clock(self):
        return self.line.now

    def tell(self, kind, *_):
        self.told.append((kind, self.clock()))

    def run(self, seconds):
        """Sweep for a while; keep when each sweep ended, and when all of a servo was read."""
        until_s, self.sweeps, self.read = self.line.now + seconds, [], {number: [] for number in IDS}
        while self.line.now < until_s:
            sweep = self.poller.snapshot.sweep
            wait_s = self.poller.turn(self.bus)
            self.line.now += max(0.0, min(wait_s, until_s - self.line.now))
            if self.poller.snapshot.sweep != sweep:
                self.sweeps.append(self.clock())
                for number, seen in self.poller.snapshot.servos.items():
                    if seen.slow and seen.slow.at not in self.read[number][-1:]:
                        self.read[number].append(seen.slow.at)

    def move(self, number, by_rad, load=0.0):
        servo = self.servos[number]
        servo.feel(ServoFelt(position_rad=servo.felt.position_rad + by_rad, load=load), 11.1, self.clock())


@pytest.fixture(params=[None, 5], ids=["one by one", "together"])
def robot(request):
    return Robot(request.param)


def test_servos_at_rest_are_swept_ten_times_a_second_and_all_of_each_is_read_twice(robot):
    robot.run(4.0)
    assert 38 <= len(robot.sweeps) <= 41
    for times in robot.read.values():
        gaps = [after - before for before, after in pairwise(times)]
        assert max(gaps) <= FULL_S + 0.05
    assert robot.rest.lasts


def test_a_servo_that_moves_is_seen_in_the_next_sweep_and_then_all_are_swept_as_fast_as_ever(robot):
    robot.run(0.53)
    robot.move(7, 0.05)
    began = robot.clock()
    robot.run(STILL_S)
    assert len(robot.woken) == 1
    assert robot.woken[0] - began <= REST_S + 0.02
    assert len(robot.sweeps) > (STILL_S - REST_S) / 0.025
    robot.run(2.0 * STILL_S)
    assert robot.rest.lasts


def test_a_load_that_changes_ends_the_rest_too(robot):
    robot.move(7, 0.0, load=0.3)
    robot.run(REST_S + 0.03)
    assert not robot.rest.lasts


def test_noise_within_the_bands_does_not(robot):
    for step in range(36):
        robot.move(1 + step % 18, 0.006 if step < 18 else -0.006, load=0.05 * (step % 3))
        robot.run(0.05)
    assert robot.woken == []


def test_a_steady_load_is_rest_too():
    time = SimpleNamespace(now=0.0)
    rest = Rest(lambda: time.now, BAND_RAD, BAND_LOAD)
    for step in range(100):
        time.now += 0.01
        rest.look(1, 0.5, -0.3 + 0.01 * (step % 2))
    assert rest.lasts


def test_a_way_in_small_steps_is_a_motion(robot):
    for _ in range(8):
        robot.move(3, 0.006)
        robot.run(0.1)
    assert robot.woken


def test_an_order_at_rest_is_not_kept_waiting_and_the_sweep_after_it_comes_at_once(robot):
    robot.run(0.53)
    while not robot.poller.turn(robot.bus) > 0.0:
        pass
    robot.rest.stir()
    swept = robot.poller.snapshot.sweep
    assert robot.poller.turn(robot.bus) == 0.0
    robot.run(0.03)
    assert robot.poller.snapshot.sweep > swept


@pytest.mark.parametrize("share", [0.005, 0.02])
def test_answers_that_are_lost_now_and_then_do_not_keep_a_bus_awake(share):
    robot = Robot(5)
    robot.emulated.faults = type(robot.emulated.faults)(drop=share)
    robot.run(10.0)
    assert len(robot.sweeps) < 400
    assert robot.told == []


def test_a_servo_that_falls_silent_at_rest_is_told_within_a_quarter_of_a_second(robot):
    robot.run(0.53)
    robot.emulated.faults = type(robot.emulated.faults)(silent=(7,))
    began = robot.clock()
    robot.run(0.5)
    ((kind, at),) = robot.told
    assert kind == "servo_silent"
    assert at - began <= 0.25
    assert robot.woken


def test_a_servo_that_loses_its_torque_or_latches_a_fault_at_rest_is_read_within_half_a_second(robot):
    robot.run(0.53)
    robot.bus.put(7, table.TORQUE_LIMIT, 0)
    began = robot.clock()
    robot.run(FULL_S + 0.05)
    assert robot.poller.snapshot.servos[7].slow.limit == 0
    assert any(began < at <= began + FULL_S + 0.05 for at in robot.read[7])


class Driver(Servos):
    """A driver of one servo that does nothing but decide, on a clock of the test."""

    def __init__(self, **settings):
        ctx = FakeContext(KIND, DynamixelSettings(device="servos", **settings), name="servos")
        ctx.device = Device("servos", "dynamixel", "/dev/null", {})
        ctx.given = (Joint(name="knee", device_id=1, lower_rad=-1.0, upper_rad=1.0, speed_rps=3.0),)
        ctx.wired["setpoint"] = ("joints",)
        super().__init__(ctx)
        self.follows = []
        self.open()

    def connected(self, _device, _servos):
        nothing = {name: lambda **_: None for name in ("beat", "judge", "close")}
        self.rest = Rest(self.ctx.clock)
        return SimpleNamespace(guard=None, turning=True, answers=True, failure=None, rest=self.rest, **nothing)

    def act(self, _session, _now):
        self.follows.append(self._gate.follows)

    def measured(self, _session, now):
        return Measured(1, now, (), BusStatistics(sweeps_hz=0.0, states_hz=0.0, sweep_ms=0.0))

    def state_key(self, _session, _now):
        return ()

    def unusable(self, _session):
        return ""

    def refuse_waiting(self, _reason):
        pass

    def pass_time(self, seconds, every_s=0.0, to_rad=0.0):
        """Go on in steps of a hundredth of a second; the mover speaks that often."""
        steps, pause = round(seconds / 0.01), round(every_s / 0.01)
        for step in range(steps):
            self.ctx.now = round(self.ctx.now + 0.01, 6)
            if pause and step % pause == 0:
                goals = (ServoGoal(id=1, position_rad=to_rad),)
                self.ctx.arrive("setpoint", ServoSetpoint(goals=goals, lease="a"), source="joints")
            self.step()
        return self


@pytest.fixture
def driver():
    driver = Driver().pass_time(1.5, every_s=0.05)
    assert driver.rate_hz == REST_HZ
    driver.follows.clear()
    return driver


def test_a_mover_of_servos_at_rest_may_speak_ten_times_a_second_and_is_lost_within_its_time(driver):
    driver.pass_time(2.0, every_s=0.1)
    assert all(driver.follows)
    driver.follows.clear()
    driver.pass_time(0.5)
    assert driver.follows.index(False) * 0.01 == pytest.approx(BELIEVED_S - 0.1, abs=0.011)
    assert driver.rate_hz == RATE_HZ


def test_the_first_new_goal_is_believed_as_shortly_as_any_other(driver):
    driver.pass_time(0.01, every_s=0.1, to_rad=0.5)
    assert driver.rate_hz == RATE_HZ
    driver.follows.clear()
    driver.pass_time(0.3)
    assert driver.follows.index(False) * 0.01 == pytest.approx(0.09, abs=0.011)


def test_a_mover_that_was_slow_is_not_lost_when_a_servo_moves(driver):
    driver.pass_time(0.1, every_s=0.1)
    driver.rest.stir()
    driver.pass_time(0.15)
    assert all(driver.follows)
    driver.pass_time(1.0, every_s=0.05)
    assert all(driver.follows)


def test_the_loss_of_a_mover_is_told_as_soon_at_rest_as_in_motion(driver):
    driver.pass_time(0.01, every_s=0.1)
    driver.pass_time(0.1 + LOST_S)
    assert [kind for kind, _ in driver.ctx.events] == []
    driver.pass_time(0.03)
    ((kind, text),) = driver.ctx.events
    assert kind == "mover_lost"
    assert f"for {driver.ctx.settings.hold_s - LOST_S:.0f} s" in text


def test_a_guard_that_has_little_patience_is_fed_often_enough():
    driver = Driver(guard_silence_ms=60).pass_time(1.5, every_s=0.05)
    assert driver.rate_hz >= 4 / 0.06
