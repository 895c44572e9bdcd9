"""A killed driver: its guard holds the servos where they are, fades their torque, and switches it off."""

import subprocess
import sys
import time

import pytest
from conftest import IDS

from lbr.capability.context import Device
from lbr.capability.die_with_parent import dying_with_parent

pytestmark = pytest.mark.timeout(60)
HOLD_S, RELEASE_S = 0.5, 0.5
DRIVER = """
import sys, time
from conftest import Arm
from lbr.capability.context import Device

class Line:
    twin = type("Twin", (), {"servos": {}})
    device = Device("arm", "feetech", sys.argv[1], {})
    drivers = []

arm = Arm(Line, '{"device": "arm", "reply_margin_s": 0.03, "hold_s": 0.5, "release_s": 0.5}')
arm.send(position_rad=1.2, speed_rps=0.3)
arm.until(lambda: False, "the end")
"""


@pytest.mark.parametrize("deaf", [(), (2, 5)])
def test_a_killed_driver_leaves_servos_that_hold_fade_and_are_let_go(device, deaf):
    assert isinstance(device.device, Device)
    servos = device.twin.servos
    argv = dying_with_parent((sys.executable, "-c", DRIVER, device.device.address))
    process = subprocess.Popen(argv, cwd=__file__.rpartition("/")[0], stdout=subprocess.DEVNULL)
    try:
        wait(lambda: all(servo.torque and servo.felt.position_rad > 0.1 for servo in servos.values()), "motion")
        device.fault("silent", deaf)
    finally:
        process.kill()
        process.wait()
    killed = time.monotonic()
    wait(lambda: all(servos[n].felt.speed_rps == 0.0 for n in IDS if n not in deaf), "hold")
    assert all(servos[number].torque for number in IDS), "they were not held first"
    assert max(servo.felt.position_rad for number, servo in servos.items() if number not in deaf) < 1.1
    wait(lambda: any(servo.word(48) < 900 for servo in servos.values()), "fading")
    wait(lambda: not any(servo.torque for servo in servos.values()), "off")
    assert time.monotonic() - killed > HOLD_S + RELEASE_S - 0.2


def test_a_driver_that_is_killed_at_its_first_torque_leaves_no_servo_on(device):
    servos = device.twin.servos
    argv = dying_with_parent((sys.executable, "-c", DRIVER, device.device.address))
    process = subprocess.Popen(argv, cwd=__file__.rpartition("/")[0], stdout=subprocess.DEVNULL)
    try:
        wait(lambda: any(servo.torque for servo in servos.values()), "the first torque")
    finally:
        process.kill()
        process.wait()
    wait(lambda: not any(servo.torque for servo in servos.values()), "off")


def wait(condition, what, within_s=20.0):
    end = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < end, f"not within {within_s:g} s: {what}"
        time.sleep(0.002)
