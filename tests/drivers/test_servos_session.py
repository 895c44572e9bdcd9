"""An open line of servos and its guard: no torque before that listens, and what it is left with at the end."""

from pathlib import Path

import pytest

from lbr.drivers.servos.bus_thread import STOP, WRITE, BusThread
from lbr.drivers.servos.line import LONGEST_DELAY_S, SERVO_S
from lbr.drivers.servos.registers import RegisterServos
from lbr.errors import DeviceError
from tests.drivers.servo_peers import MemoryLine
from tests.drivers.test_dynamixel_capability import SETTINGS, START, Rig
from tests.support.waiting import HANG_S, until


class Guard:
    """What a guard's process is told by its driver."""

    def __init__(self):
        self.standing, self.listens, self.frozen, self.told = True, False, False, []

    def beat(self, *, turning):
        self.told.append("turns" if turning else "rests")

    def woken(self):
        woken, self.frozen = self.frozen, False
        return woken

    def leave(self):
        self.told.append("leave")

    def dismiss(self):
        self.told.append("dismiss")


@pytest.fixture
def guard(monkeypatch):
    guard = Guard()
    monkeypatch.setattr(RegisterServos, "guard", lambda *_: guard)
    return guard


@pytest.fixture
def start(chain, monkeypatch):
    rigs = []

    def start(**settings):
        row = SETTINGS.replace(
            '"guard": false', ", ".join(['"guard": true', *(f'"{k}": "{v}"' for k, v in settings.items())])
        )
        rigs.append(Rig(monkeypatch, chain, row))
        return rigs[-1]

    yield start
    for rig in rigs:
        rig.close()


def test_no_servo_gets_torque_before_its_guard_listens(start, guard, chain):
    rig = start()
    rig.send()
    for _ in range(200):
        rig.step()
    assert not any(servo.torque for servo in chain.servos.values())
    assert set(guard.told) == {"rests"}
    guard.listens = True
    rig.on()
    assert guard.told[-1] == "turns"


@pytest.mark.parametrize(
    ("on", "failed", "ending", "last"),
    [
        (True, False, "hold", "leave"),
        (True, False, "release", "dismiss"),
        (True, True, "hold", "dismiss"),
        (False, False, "hold", "dismiss"),
    ],
)
def test_servos_that_keep_their_torque_at_the_end_are_left_to_the_guard(start, guard, chain, on, failed, ending, last):
    guard.listens = True
    rig = start(on_close=ending)
    if on:
        rig.on()
    else:
        rig.until(rig.seen)
    if failed:
        session = rig.driver._session
        session.thread.submit(lambda _bus: Path("/nonexistent").read_bytes(), STOP)
        START(rig.threads.pop())
        until(lambda: session.failure)
    rig.close()
    assert guard.told[-1] == last


def test_a_guard_that_does_not_start_or_is_gone_ends_the_session_and_one_that_was_frozen_is_told(
    start, guard, monkeypatch
):
    rig = start()
    with monkeypatch.context() as patch:
        patch.setattr(RegisterServos, "guard", lambda *_: Path("/nonexistent").read_bytes())
        with pytest.raises(DeviceError, match="does not start"):
            rig.until(rig.seen)
    rig.until(rig.seen)
    guard.frozen = True
    rig.step()
    rig.step()
    assert rig.ctx.kinds().count("guard") == 1
    guard.standing = False
    with pytest.raises(DeviceError, match="died or hangs"):
        rig.step()


def test_a_bus_that_was_held_up_is_no_silence_of_its_servos(start, guard, chain):
    rig = start()
    rig.until(rig.seen)
    chain.dead.add(3)
    rig.until(lambda: rig.servo(3).reason)
    rig.ctx.now += 2.0
    rig.driver.step()
    assert rig.driver.answers()


def test_a_stop_that_waits_and_an_end_are_urgent_and_nothing_else():
    thread = BusThread(None)
    assert not thread.urgent()
    thread.submit(lambda _bus: None, WRITE)
    assert not thread.urgent()
    thread.submit(lambda _bus: None, STOP)
    assert thread.urgent()
    thread.start()
    assert thread.join(HANG_S)
    assert thread.urgent()


def test_a_transaction_takes_as_long_as_its_bytes_both_ways_and_each_servo(chain):
    line = MemoryLine(chain, None, 1_000_000, 0.0)
    assert line.busy_s(8, 15, 2) == pytest.approx(230e-6 + 2 * (SERVO_S + LONGEST_DELAY_S))
