"""A gamepad of the kernel's own, made by `uinput`: found, driven with on a whole robot, and pulled out in full motion."""

import fcntl
import json
import os
import struct
import sys
import time
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.usb import robots, vhci
from tests.support.usb.rig import ARDUINO, ROBOTEQ, CdcAcm, as_user, on_line, until

UINPUT = Path("/dev/uinput")
UI_DEV_CREATE, UI_DEV_DESTROY = 0x5501, 0x5502
UI_DEV_SETUP, UI_ABS_SETUP = 0x405C5503, 0x401C5504
UI_SET_EVBIT, UI_SET_KEYBIT, UI_SET_ABSBIT = 0x40045564, 0x40045565, 0x40045567
EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
USB, BLUETOOTH = 3, 5
NAME = "Example Pad"
ADDRESS = f"input:{NAME}"
A, B, TL = 0x130, 0x131, 0x136
STICKS = {0: 32767, 1: 32767, 3: 32767, 4: 32767}
RIGHT_X = 3
GENTLE = 13000
"""A sensor of distance that always says the same is taken for frozen once the wheels have gone some way."""
HELD_S = 0.1
PAD = (
    *robots.ON_WHEELS_EDITS,
    f"INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'pad', 'gamepad', '{ADDRESS}')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'gamepad', 'gamepad', '{\"device\": \"pad\"}')",
    'UPDATE capability SET settings = \'{"turn_rps": 3, "ttl_s": 1, "stale_s": 1}\' WHERE name = \'teleop\'',
    "UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'teleop'",
)
"""An emulated processor is slow: the driver gets longer to be heard. A pad that goes is told at once all the same."""


class Pad:
    """A gamepad that exists while it is plugged in (linux/uinput.h)."""

    def __init__(self, bus: int = USB) -> None:
        self.bus = bus
        self._fd = -1

    def plug(self) -> None:
        self._fd = os.open(UINPUT, os.O_WRONLY | os.O_NONBLOCK)
        for kind in (EV_KEY, EV_ABS):
            fcntl.ioctl(self._fd, UI_SET_EVBIT, kind)
        for key in (A, B, TL):
            fcntl.ioctl(self._fd, UI_SET_KEYBIT, key)
        for axis, most in STICKS.items():
            fcntl.ioctl(self._fd, UI_SET_ABSBIT, axis)
            fcntl.ioctl(self._fd, UI_ABS_SETUP, struct.pack("=H2x6i", axis, 0, -most, most, 16, 128, 0))
        identity = struct.pack("=4H80sI", self.bus, 0x1209, 0x0001, 1, NAME.encode(), 0)
        fcntl.ioctl(self._fd, UI_DEV_SETUP, identity)
        fcntl.ioctl(self._fd, UI_DEV_CREATE)

    def unplug(self) -> float:
        """Pull it out; return when."""
        at = time.monotonic()
        if self._fd >= 0:
            fcntl.ioctl(self._fd, UI_DEV_DESTROY)
            os.close(self._fd)
            self._fd = -1
        return at

    def press(self, *, button: int | None = None, down: bool = True, **axes: int) -> None:
        told = [(EV_KEY, button, int(down))] if button is not None else []
        told += [(EV_ABS, RIGHT_X, axes["right_x"])] if axes else []
        os.write(self._fd, b"".join(struct.pack("@llHHi", 0, 0, *one) for one in (*told, (EV_SYN, 0, 0))))


@pytest.fixture(scope="module")
def pad():
    if why := vhci.why_no_module("uinput", there=UINPUT):
        pytest.skip(why)
    until(UINPUT.exists, "the node of uinput", 60.0)
    found = Pad()
    found.plug()
    until(nodes, "its node", 60.0)
    yield found
    found.unplug()


@pytest.fixture(scope="module")
def motors(service, place):
    with (
        on_line("roboteq", place, CdcAcm, ROBOTEQ) as found,
        on_line("ultrasonic_ring", place, CdcAcm, ARDUINO),
    ):
        yield found


@pytest.fixture(scope="module")
def robot(service, place, motors, pad):
    names = (*robots.ON_WHEELS, "gamepad", "teleop")
    with robots.running(service, place / "pad", *names, edits=PAD) as found:
        yield found


def nodes() -> list[Path]:
    named = Path("/sys/class/input").glob("event*/device/name")
    return [one for one in named if one.read_text().strip() == NAME]


def told(robot, **state) -> bool:
    found = robot.ask("teleop/state") or {}
    return all(found.get(name) == value for name, value in state.items())


def turn(robot, pad, outputs, push: int = 32767) -> None:
    """Press the dead-man button anew, and turn on the spot."""
    pad.press(button=TL, down=False, right_x=0)
    until(lambda: told(robot, pad=True, dead_man=False), "the button is let go", 60.0)
    pad.press(button=TL)
    until(lambda: told(robot, dead_man=True), "the button is pressed", 60.0)
    pad.press(right_x=push)
    outputs.wait(lambda: not outputs.zero, "motion", 30.0)


def test_it_is_found_by_what_it_is_and_its_rows_are_proposed(service, place, pad):
    home = place / "found"
    home.mkdir(mode=0o700)
    robots.given_to(service, home)
    env = os.environ | {"LBR_HOME": str(home)}
    for words in (("db", "init"), ("devices", "--json", "--robot", "lbr")):
        argv = [*as_user(service), sys.executable, "-m", "lbr.start", *words]
        done = programs.run(argv, env=env, cwd="/", capture_output=True, text=True, timeout=300, check=False)
    said = json.loads(done.stdout)
    (found,) = (one for one in said["devices"] if one["name"] == NAME)
    assert (found["type"], found["address"]) == ("gamepad", ADDRESS)
    (offer,) = (one for one in said["proposals"] if one["address"] == ADDRESS)
    assert not offer["problems"]
    assert "switch on teleop" in offer["text"]


def test_pulled_out_in_motion_the_wheels_stand_and_nothing_resumes_without_the_button(
    robot, pad, motors, record_property
):
    outputs = robots.Outputs(motors)
    for name in ("motors", "gamepad", "teleop"):
        robots.ready(robot, name)
    turn(robot, pad, outputs)
    pulled = pad.unplug()
    outputs.wait(lambda: outputs.zero, "zero", 5.0)
    zero_s = time.monotonic() - pulled
    record_property("zero after ms", round(zero_s * 1e3))
    _, reason = robots.degraded(robot, "gamepad")
    told_s = time.monotonic() - pulled
    record_property("told after s", round(told_s, 2))
    assert "missing" in reason or "went away" in reason
    plugged = time.monotonic()
    pad.plug()
    robots.ready(robot, "gamepad")
    back_s = time.monotonic() - plugged
    record_property("back after s", round(back_s, 2))
    pad.press(button=TL, right_x=32767)
    end = time.monotonic() + 2.0
    while time.monotonic() < end:
        assert outputs.zero, "the old motion goes on"
        time.sleep(0.005)
    turn(robot, pad, outputs)
    pad.press(button=TL, down=False)
    outputs.wait(lambda: outputs.zero, "zero, since the button is let go", 5.0)
    assert zero_s < 0.3
    assert told_s < 1.0
    assert back_s < 3.0


def test_by_radio_it_stands_when_nothing_is_heard_for_long_and_goes_on_once_it_is(robot, pad, motors, record_property):
    outputs = robots.Outputs(motors)
    pad.unplug()
    until(lambda: told(robot, pad=False), "the pad is gone", 60.0)
    pad.bus = BLUETOOTH
    pad.plug()
    robots.ready(robot, "gamepad")
    until(lambda: told(robot, pad=True), "the pad is back", 60.0)
    turn(robot, pad, outputs, GENTLE)
    spoke = time.monotonic()
    outputs.wait(lambda: outputs.zero, "zero, since it may be out of range", 10.0)
    silent_s = time.monotonic() - spoke
    record_property("zero after s of silence", round(silent_s, 2))
    until(lambda: told(robot, dead_man=True, code="stale_sensor"), "why it stands")
    pad.press(right_x=GENTLE + 1000)
    outputs.wait(lambda: not outputs.zero, "motion, since it speaks", 10.0)
    pad.press(button=TL, down=False, right_x=0)
    outputs.wait(lambda: outputs.zero, "zero, since the button is let go", 5.0)
    assert 1.5 < silent_s < 3.0


def test_a_button_that_was_held_while_it_was_plugged_in_is_held_and_moves_nothing(robot, pad, motors):
    outputs = robots.Outputs(motors)
    pad.press(button=TL)
    until(lambda: told(robot, dead_man=True), "the button is pressed", 60.0)
    before = robot.capability("gamepad")["pid"]
    robot.say("/restart/gamepad")
    until(lambda: robot.capability("gamepad")["pid"] not in {None, before}, "another driver", 60.0)
    robots.ready(robot, "gamepad")
    until(lambda: told(robot, pad=True, dead_man=True), "what is held is asked of the kernel", 60.0)
    pad.press(right_x=32767)
    time.sleep(HELD_S * 5)
    assert outputs.zero
    pad.press(button=TL, down=False, right_x=0)
