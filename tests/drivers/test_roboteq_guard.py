import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from tty import setraw

import pytest

from lbr.drivers.roboteq import KIND
from lbr.drivers.roboteq.capability import Roboteq
from lbr.drivers.roboteq.protocol import ACKNOWLEDGED, STOP
from lbr.drivers.serial_line import open_line
from lbr.drivers.wheels.guard import PROGRAM
from lbr.errors import DeviceError
from tests.drivers.peers import DriverContext
from tests.support import programs
from tests.support.waiting import HANG_S, STOPS_S, until

ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
DRIVER = """
import sys, time
from tests.drivers.peers import DriverContext
from lbr.drivers.guard import Guard
from lbr.drivers.roboteq import KIND
from lbr.drivers.roboteq.capability import Roboteq
from lbr.messages.motors import MotorSetpoint
row = '{"device": "motors", "setpoint_valid_s": 0.25, "reply_timeout_s": 0.1, "watchdog_ms": 250, "guard_silence_ms": 240}'
ctx = DriverContext(KIND, KIND.parse(row), sys.argv[1], "roboteq")
motors = Roboteq(ctx)
motors.open()
print(motors._guard.pid, flush=True)
while True:
    ctx.give(MotorSetpoint(left=0.5 * ctx.published[-1][1].armed, right=0.5 * ctx.published[-1][1].armed))
    motors.step()
    time.sleep(0.01)
"""


@pytest.fixture
def driver(peer):
    """A driver in a process of its own, driving; and its guard's pid."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    process = programs.start(
        [sys.executable, "-c", DRIVER, str(peer.path)], stdout=subprocess.PIPE, text=True, env=environment
    )
    guard = int(process.stdout.readline())
    until(lambda: peer.motor == (500, 500))
    until(lambda: all(ignores(guard, number) for number in ENDING))
    yield process, guard
    process.kill()
    process.wait()
    process.stdout.close()


def ignores(pid, number):
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("SigIgn:")[1].split()[0], 16) >> (number - 1) & 1


def state(pid):
    return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]


def gone(pid):
    try:
        return state(pid) == "Z"
    except FileNotFoundError:
        return True


def test_killing_the_driver_zeroes_the_motors_long_before_the_watchdog(driver, peer):
    process, guard = driver
    process.kill()
    until(lambda: peer.motor == (0, 0), limit_s=STOPS_S)
    until(lambda: gone(guard))
    line = open_line(DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq").device, 115200)
    line.close()


def test_the_guard_outlives_the_signals_that_end_its_driver(driver, peer):
    process, guard = driver
    for number in ENDING:
        os.kill(guard, number)
    process.kill()
    until(lambda: peer.motor == (0, 0), limit_s=STOPS_S)


def test_a_frozen_driver_is_killed_and_the_motors_zeroed_before_the_watchdog(driver, peer):
    process, _guard = driver
    process.send_signal(signal.SIGSTOP)
    until(lambda: peer.motor == (0, 0), limit_s=STOPS_S)
    assert process.wait(HANG_S) == -signal.SIGKILL


def test_a_driver_that_stands_still_at_rest_is_left_alone(peer):
    ctx = DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq")
    motors = Roboteq(ctx)
    motors.open()
    motors.step()
    time.sleep(0.3)
    motors.step()
    assert motors._guard.standing
    motors.close()


@pytest.mark.parametrize("acknowledged", [ACKNOWLEDGED.hex(), "-"])
def test_the_guard_says_why_before_it_kills(acknowledged):
    tty, line = os.openpty()
    setraw(line)
    beats, alive = os.pipe()
    said, words = os.pipe()
    victim = programs.start(["/bin/sleep", "60"])
    driver = os.pidfd_open(victim.pid)
    numbers = [str(line), str(beats), str(driver), "60"]
    program = [sys.executable, "-I", "-S", str(PROGRAM), *numbers, STOP.hex(), acknowledged]
    guard = programs.start([*program, str(words), b"why".hex()], pass_fds=(line, beats, driver, words))
    os.write(alive, b"m")
    assert victim.wait(HANG_S) == -signal.SIGKILL
    assert os.read(said, 16) == b"why"
    assert os.read(tty, 7) == STOP
    assert guard.wait(HANG_S) == 0
    for fd in (tty, line, beats, alive, said, words, driver):
        os.close(fd)


def test_a_guard_that_is_dismissed_writes_nothing():
    tty, line = os.openpty()
    setraw(line)
    beats, alive = os.pipe()
    driver = os.pidfd_open(os.getpid())
    program = [sys.executable, "-I", "-S", str(PROGRAM), str(line), str(beats), str(driver), "60"]
    guard = programs.start([*program, STOP.hex(), ACKNOWLEDGED.hex()], pass_fds=(line, beats, driver))
    os.write(alive, b"q")
    assert guard.wait(HANG_S) == 0
    os.set_blocking(tty, False)
    with pytest.raises(BlockingIOError):
        os.read(tty, 7)
    for fd in (tty, line, beats, alive, driver):
        os.close(fd)


def test_a_frozen_guard_goes_on_with_the_next_beat_and_that_is_told(peer):
    ctx = DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq")
    motors = Roboteq(ctx)
    motors.open()
    motors.step()
    os.kill(motors._guard.pid, signal.SIGSTOP)
    until(lambda: state(motors._guard.pid) == "T")
    motors._guard.beat(turning=True)
    until(lambda: state(motors._guard.pid) != "T")
    until(lambda: motors.step() or any(event[0] == "guard" for event in ctx.events))
    motors._guard.beat(turning=False)
    motors.close()


def test_a_frozen_guard_writes_zero_when_its_driver_is_killed(driver, peer):
    process, guard = driver
    process.send_signal(signal.SIGSTOP)
    os.kill(guard, signal.SIGSTOP)
    until(lambda: state(guard) == "T")
    process.kill()
    until(lambda: peer.motor == (0, 0), limit_s=STOPS_S)
    until(lambda: gone(guard))


def test_without_its_guard_the_driver_stops_and_opens_anew(peer):
    ctx = DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq")
    motors = Roboteq(ctx)
    motors.open()
    os.kill(motors._guard.pid, signal.SIGKILL)
    with pytest.raises(DeviceError, match="guard process died"):
        until(motors.step)
    motors.close()
    motors.open()
    motors.step()
    motors.close()


def test_closing_dismisses_the_guard_and_frees_the_line(peer):
    ctx = DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq")
    motors = Roboteq(ctx)
    motors.open()
    guard = motors._guard
    assert guard.standing
    with pytest.raises(DeviceError, match="busy"):
        open_line(ctx.device, 115200)
    motors.close()
    assert not guard.standing
    open_line(ctx.device, 115200).close()


def test_the_guard_writes_zero_when_the_closing_driver_was_not_answered(peer):
    ctx = DriverContext(KIND, KIND.parse('{"device": "motors"}'), peer.path, "roboteq")
    motors = Roboteq(ctx)
    motors.open()
    peer.motor = (500, 500)
    unheard = iter(range(3))  # as often as the driver tries itself

    peer.answer = lambda line: b"" if line == "!M 0 0" and next(unheard, None) is not None else None
    guard = motors._guard
    until(lambda: guard.listens)
    motors.close()
    until(lambda: peer.motor == (0, 0))
    assert not guard.standing
    open_line(ctx.device, 115200).close()


def test_the_guard_is_not_held_up_by_a_controller_that_babbles(driver, peer):
    process, guard = driver
    peer.babble(b"junk\r" * 200)
    peer.log.clear()
    process.kill()
    until(lambda: gone(guard))
    until(lambda: "!M 0 0" in peer.log)
