"""The dock's beams by the kernel's own decoders: a loop-back receiver that hears what is sent, and one whose decoder is off."""

import fcntl
import json
import os
import struct
from pathlib import Path

import pytest

from tests.support.usb import robots, vhci
from tests.support.usb.rig import until

RECEIVERS = Path("/sys/class/rc")
CODES = {"left": 0x400021, "right": 0x400022, "power": 0x400024}
SET_SEND_MODE, MODE_SCANCODE, SONY15 = 0x40046911, 8, 7
EDIT = "UPDATE device SET address = '/dev/{}' WHERE robot = 'lbr' AND name = 'dock_receiver'"


def receivers():
    return {one.name for one in RECEIVERS.iterdir()} if RECEIVERS.exists() else set()


@pytest.fixture(scope="module")
def loopback():
    """The kernel's receiver that hears its own sender: its folder in /sys, and its node in /dev."""
    before = receivers()
    if why := vhci.why_no_module("rc-loopback"):
        pytest.skip(why)
    until(lambda: receivers() - before or before, "a receiver", 60.0)
    name = max(receivers() - before or before)
    (node,) = (one.name for one in (RECEIVERS / name).iterdir() if one.name.startswith("lirc"))
    until(Path("/dev", node).exists, "its node", 60.0)
    return RECEIVERS / name, node


@pytest.fixture(scope="module")
def robot(loopback, service, place):
    place_in_sys, node = loopback
    (place_in_sys / "protocols").write_text("+sony")
    with robots.running(service, place / "infrared", "dock", edits=(EDIT.format(node),)) as found:
        yield found


def send(node: str, code: int) -> None:
    """Have the kernel send a scancode as pulses (linux/lirc.h)."""
    sender = os.open(f"/dev/{node}", os.O_WRONLY)
    try:
        fcntl.ioctl(sender, SET_SEND_MODE, struct.pack("I", MODE_SCANCODE))
        os.write(sender, struct.pack("=QHHIQ", 0, 0, SONY15, 0, code))
    finally:
        os.close(sender)


def test_each_beam_is_seen_and_no_other(robot, loopback, record_property):
    robots.ready(robot, "dock")
    for beam, code in CODES.items():
        until(lambda: not any((robot.ask("dock/signal") or {}).get(one) for one in CODES), "no beam", 30.0)
        send(loopback[1], code)
        until(lambda one=beam: (robot.ask("dock/signal") or {}).get(one), f"the beam {beam}", 30.0)
        seen = robot.ask("dock/signal")
        assert [one for one in CODES if seen[one]] == [beam], json.dumps(seen)
    record_property("beams seen", len(CODES))


def test_a_decoder_that_is_off_is_told_with_what_to_type(robot, loopback, record_property):
    place_in_sys, _ = loopback
    (place_in_sys / "protocols").write_text("none")
    try:
        robot.say("/restart/dock")
        _, reason = robots.degraded(robot, "dock")
        until(lambda: "ir-keytable" in robot.capability("dock")["reason"], f"what to type: {reason}", 60.0)
        record_property("told", robot.capability("dock")["reason"][:160])
    finally:
        (place_in_sys / "protocols").write_text("+sony")
    robots.ready(robot, "dock")
