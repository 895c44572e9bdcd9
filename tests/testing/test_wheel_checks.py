"""What stops wheels is tried one layer at a time: a driver of ours passes, and one of which a layer is broken does not."""

import json
import textwrap

import pytest

from lbr.capability.registry import find
from lbr.testing import driver
from lbr.testing.device import plugged
from lbr.testing.driver import DriverBench
from lbr.testing.wheels import (
    CHECKS,
    stops_by_its_guard_alone,
    stops_by_its_watchdog_alone,
    turns_each_motor_its_own_way,
)

pytestmark = pytest.mark.timeout(60)  # processes start, more than once

ROW = {"device": "device", "left": {"channel": 1, "direction": -1}}
"""As its device row says that the emulated controller is wired."""
BROKEN = """
    from dataclasses import replace

    from lbr.drivers.roboteq import KIND as BASE
    from lbr.drivers.roboteq import protocol
    from lbr.drivers.roboteq.capability import Roboteq
    from lbr.drivers.roboteq.controller import Controller
    from lbr.drivers.serial_line import open_line
    from lbr.drivers.wheels.contract import GuardStop


    class Broken(Controller):
    {broken}

    class Driver(Roboteq):
        def connect(self, device, beat):
            return Broken(open_line(device, self.ctx.settings.baud), self.ctx.settings, self.ctx.clock, beat)


    KIND = replace(BASE, name="broken", entry=Driver)
"""
UNSET = """
def _insist(self, command, trouble):
    if b"RWD" not in command:
        super()._insist(command, trouble)

def _verify(self, name, expected, meaning):
    pass

def _note_watchdog(self):
    pass
"""
RUBBISH = """
@property
def guard_stop(self):
    return GuardStop(b"xxxx", protocol.ACKNOWLEDGED)
"""
ONE_OF_TWO = """
@property
def guard_stop(self):
    return GuardStop(b"!G 1 0\\r", protocol.ACKNOWLEDGED)
"""
NEVER_TURNING = """
@property
def turning(self):
    return False

@turning.setter
def turning(self, _turning):
    pass
"""
ONE_DIRECTION = """
def _motors(self, left, right):
    channels = {wheel.channel: round(1000 * power) for power, wheel in
                ((left, self._settings.left), (right, self._settings.right))}
    return protocol.motors(channels[1], channels[2])
"""


@pytest.fixture
def bench(tmp_path):
    def made(name, **settings):
        wired = {"setpoint": ("drive",)}
        kind = find(name, tmp_path)
        return DriverBench(kind, json.dumps(ROW | settings), device, wired=wired, home=str(tmp_path))

    with plugged("roboteq", tmp_path) as device:
        yield made


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_driver_of_ours_stops_wheels_by_each_layer(check, bench):
    check(bench("roboteq"))


@pytest.mark.parametrize(
    ("broken", "check", "error"),
    [
        (UNSET, stops_by_its_watchdog_alone, "its controller's watchdog"),
        (RUBBISH, stops_by_its_guard_alone, "its guard, after it was killed"),
        (ONE_OF_TWO, stops_by_its_guard_alone, "its guard, after it was killed"),
        (NEVER_TURNING, stops_by_its_guard_alone, "its guard, while it was frozen"),
        (ONE_DIRECTION, turns_each_motor_its_own_way, "alone turns, in the commanded direction"),
    ],
    ids=["unset watchdog", "rubbish of a guard", "guard of one motor", "never turning", "direction ignored"],
)
def test_a_driver_of_which_a_layer_is_broken_is_found_out(broken, check, error, bench, tmp_path, monkeypatch):
    if check is turns_each_motor_its_own_way:
        monkeypatch.setattr(driver, "WITHIN_S", 2.0)
    folder = tmp_path / "capabilities"
    folder.mkdir(mode=0o700)
    text = textwrap.dedent(BROKEN).replace("{broken}", textwrap.indent(broken, "    "))
    (folder / "broken.py").write_text(text)
    (folder / "broken.py").chmod(0o600)
    with pytest.raises(AssertionError, match=error):
        check(bench("broken"))
