"""A driver of wheels from outside: what the family gives it, it need not write itself."""

import os
import select
import socket
import subprocess
import sys
import threading
import tty
from contextlib import suppress
from itertools import count
from pathlib import Path

import pytest

from lbr.capability.faults import faults
from lbr.drivers.wheels import EnableCommand
from lbr.drivers.wheels.guard_stop import is_acknowledged, stopped
from lbr.messages.motors import MotorSetpoint
from tests.drivers.peers import DriverContext, Pty
from tests.drivers.tiny_wheels import FOUR, KIND, QUAD, STOP, Tiny
from tests.support import programs
from tests.support.waiting import STOPS_S, until

DRIVER = """
import sys, time
from tests.drivers.peers import DriverContext
from tests.drivers.tiny_wheels import FOUR, KIND, Quad
from lbr.messages.motors import MotorSetpoint
row = '{"device": "motors", "setpoint_valid_s": 0.25, "guard_silence_ms": 250}'
ctx = DriverContext(KIND, KIND.parse(row), sys.argv[1], "tiny")
motors = Quad(ctx)
motors.open()
while True:
    power = 0.5 * ctx.published[-1][1].armed
    ctx.give(MotorSetpoint(left=power, right=power, motors=dict.fromkeys(FOUR, power)))
    motors.step()
    time.sleep(0.01)
"""


class TinyPeer(Pty):
    """The controller's end of the line."""

    def __init__(self, path):
        self.motor, self.answers = None, True
        self._over = threading.Event()
        super().__init__(path)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def finish(self):
        self._over.set()
        self._thread.join()
        self.unplug()

    def _serve(self):
        came = b""
        while not self._over.is_set():
            if select.select([self.master], [], [], 0.005)[0]:
                *lines, came = (came + os.read(self.master, 4096)).split(b"\r")
                for line in lines:
                    self.motor = tuple(int(number) for number in line.split()[1:])
                    if self.answers:
                        os.write(self.master, b"ok\r")


@pytest.fixture
def peer(tmp_path):
    peer = TinyPeer(tmp_path / "tty")
    yield peer
    peer.finish()


@pytest.fixture
def ctx(peer):
    return DriverContext(KIND, KIND.parse('{"device": "motors", "guard": false}'), peer.path, "tiny")


@pytest.fixture
def motors(ctx):
    motors = Tiny(ctx)
    motors.open()
    yield motors
    motors.close()


class Mute(Tiny):
    """Wheels on a controller that takes what it is told, and never answers."""

    def connect(self, device, beat):
        controller = super().connect(device, beat)
        controller.open = controller.stop  # whether there is an answer proves nothing
        return controller


def test_whether_a_controller_has_ever_sent_a_byte_is_in_its_state(ctx, peer):
    peer.answers = False
    motors = Mute(ctx)
    motors.open()
    for _ in range(2):
        ctx.give(MotorSetpoint(left=0.0, right=0.0, lease="L1"))
        motors.step()
    assert ctx.state.armed
    assert ctx.state.heard is False
    peer.answers = True
    until(lambda: motors.step() or ctx.state.heard)
    motors.close()
    motors.degraded("its cable is out")
    assert ctx.state.heard is None


def test_its_kind_is_as_kinds_must_be():
    assert faults(KIND) == faults(QUAD) == ()
    assert KIND.moves
    assert KIND.device_type == "tiny"
    assert dict(KIND.commands) == {"enable": EnableCommand}
    assert {word.pattern: word.fixed for word in KIND.words} == {
        "enable": {"enabled": True},
        "disable": {"enabled": False},
    }


def test_a_row_that_says_nothing_of_safety_has_all_of_its_layers():
    row = KIND.parse('{"device": "motors"}')
    assert (row.enabled, row.guard, row.guard_silence_ms, row.watchdog_ms) == (True, True, 120, 200)
    assert (row.setpoint_valid_s, row.acknowledge_s, row.still_counts) == (0.1, 0.5, 2)


def test_only_a_zero_arms_and_silence_stops(motors, ctx, peer):
    ctx.give(MotorSetpoint(left=0.5, right=0.5, lease="L1"))
    motors.step()
    assert peer.motor == (0, 0)
    leases = count(1)

    def turns():
        """A lease dies where a busy machine holds up what moves."""
        lease = f"L{next(leases)}"
        for power in (0.0, 0.5):
            ctx.give(MotorSetpoint(left=power, right=power, lease=lease))
            motors.step()
        return peer.motor == (500, 500)

    until(turns)
    assert ctx.state.voltage_v == 12.0

    def stopped():
        motors.step()
        return peer.motor == (0, 0) and not ctx.state.armed

    until(stopped, limit_s=STOPS_S)


def test_a_killed_driver_of_four_leaves_all_wheels_at_zero(peer):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    process = programs.start([sys.executable, "-c", DRIVER, str(peer.path)], stdout=subprocess.DEVNULL, env=environment)
    try:
        until(lambda: peer.motor == (500,) * 4)
    finally:
        process.kill()
    until(lambda: peer.motor == (0,) * 4, limit_s=STOPS_S)
    process.wait()


def test_a_driver_of_two_motors_does_not_guess_what_motors_of_other_names_are(motors, ctx, peer):
    ctx.give(MotorSetpoint(left=0.0, right=0.0, lease="L1", motors=dict.fromkeys(FOUR, 0.0)))
    motors.step()
    assert not ctx.state.armed
    assert "motor 'left' no power" in ctx.state.reason


def test_a_stop_reaches_a_line_that_is_no_tty():
    controller, line = socket.socketpair()
    with controller, line:
        controller.send(b"ok\r")
        assert stopped(line.fileno(), STOP, b"ok\r")
        assert controller.recv(64) == STOP


def test_a_stop_waits_behind_nothing_that_the_driver_wrote_and_is_acknowledged_by_nothing_of_before():
    controller, line = os.openpty()
    tty.setraw(line)
    os.set_blocking(line, False)
    os.write(controller, b"ok\r")
    with suppress(BlockingIOError):
        while os.write(line, b"!M 500 500\r"):
            pass
    assert not stopped(line, STOP, b"ok\r")
    os.set_blocking(controller, False)
    received = bytearray()

    def came():
        with suppress(BlockingIOError):
            received.extend(os.read(controller, 65536))
        return received.endswith(STOP)

    until(came, limit_s=STOPS_S, what="the stop, behind what had left the line")
    os.close(controller)
    os.close(line)


def test_an_acknowledgement_counts_only_where_there_is_one():
    assert is_acknowledged(b"noise ok\r", b"ok\r")
    assert not is_acknowledged(b"", b"")
    assert not is_acknowledged(b"anything", b"")
