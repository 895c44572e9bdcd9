"""`lbr devices` on devices of the kernel: found by the names of udev, asked what they are and nothing else, rows proposed."""

import json
import os
import sys
import time
from contextlib import ExitStack
from dataclasses import replace

import pytest

from lbr.capability.context import Device
from lbr.drivers.serial_line import open_line
from tests.support import databases, programs, tap
from tests.support.usb import vhci
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Played
from tests.support.usb.rig import (
    ARDUINO,
    CH343,
    FT232R,
    RIOX,
    ROBOCLAW,
    ROBOTEQ,
    USB2AX,
    CdcAcm,
    Ftdi,
    adaptor,
    as_user,
    by_id,
    given_to,
    on_line,
    until,
)
from tests.support.usb.uvc_function import Camera

LINES = {
    "roboteq": (CdcAcm, ROBOTEQ),
    "ultrasonic_ring": (CdcAcm, ARDUINO),
    "riox": (CdcAcm, RIOX),
    "dynamixel": (CdcAcm, USB2AX),
    "feetech": (CdcAcm, CH343),
    "roboclaw": (CdcAcm, ROBOCLAW),
    "uxa90": (Ftdi, FT232R),
    "ld06": (Ftdi, replace(FT232R, serial="LD06")),
}
AT = {str(by_id(identity)): one for one, (_, identity) in LINES.items()}
OF_LBR = {"roboteq": "motor_controller", "ultrasonic_ring": "range_board", "riox": "riox", "ld06": "ld06"}
"""What the robot lbr may have, by the rows that it then has."""
SERVOS = ("dynamixel", "feetech", "uxa90")
ON_I2C = {"mpu9150": 0x68, "pico": 0x69}
WEBCAM = Identity(0x046D, 0x0825, "Example", "Webcam", "5678", device_class=(0xEF, 2, 1))
WITHIN_S = 2.0
"""In which each is to be recognised, by the machine's own clock."""
SAID_S = 300.0


@pytest.fixture(scope="module")
def home(service, place, outside):
    """Return a home of the service's user, with the rows as they ship."""
    found = place / "home"
    found.mkdir(mode=0o700)
    databases.fresh(found / "robot.db")
    return given_to(service, found)


def line(type_, place):
    """Plug in what is on a serial line. Servos are told nothing of a load: that takes an emulated processor's time."""
    told = {"live": lambda *_: None} if type_ in SERVOS else {}
    return on_line(type_, place, *LINES[type_], **told)


@pytest.fixture
def lines_of_lbr(service, place):
    """What the robot lbr may have on serial lines, plugged in."""
    with ExitStack() as stack:
        for one in OF_LBR:
            stack.enter_context(line(one, place))
        yield


@pytest.fixture(scope="module")
def lines(service, place, outside):
    """All that is on a serial line, plugged in: the rig of each, and what comes to it.

    Until a line was opened once, the kernel may echo some of what a device says by itself: the one that does is opened before.
    """
    with ExitStack() as stack:
        rigs = {one: stack.enter_context(line(one, place)) for one in LINES}
        open_line(Device("lidar", "ld06", str(by_id(LINES["ld06"][1])), {}), 230_400).close()
        yield rigs, {one: tap.of(rig.twin) for one, rig in rigs.items()}


def said(user, home, *words):
    argv = [*as_user(user), sys.executable, "-m", "lbr.start", *words]
    env = os.environ | {"LBR_HOME": str(home)}
    return programs.run(argv, env=env, cwd="/", capture_output=True, text=True, timeout=SAID_S, check=False)


def looked(user, home, *words):
    done = said(user, home, "devices", "--json", "--robot", "lbr", *words)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def test_what_is_on_i2c_is_read_and_cameras_and_receivers_are_known_by_name(service, home, place, record_property):
    for module in ("i2c-dev", "rc-loopback", "uvcvideo"):
        if why := vhci.why_no_module(module):
            pytest.skip(why)
    heard = {one: [] for one in ON_I2C}
    with ExitStack() as stack:
        number = {one: stack.enter_context(adaptor(place, one, heard=heard[one]))[0] for one in ON_I2C}
        stack.enter_context(Played(Camera(lambda *_: b"", WEBCAM)))
        found = {}

        def all_are_there():
            found.update({one["address"]: one for one in looked(service, home)["devices"]})
            return any(one["type"] == "camera" for one in found.values())

        until(all_are_there, "the camera's node", 120.0)
    addresses = {one: f"i2c:{number[one]}:{at:#04x}" for one, at in ON_I2C.items()}
    record_property("after s", {one: found[at]["took_s"] for one, at in addresses.items()})
    assert {one: found[at]["type"] for one, at in addresses.items()} == {one: one for one in ON_I2C}
    for one, pieces in heard.items():
        tap.assert_read_only(one, pieces)
    by_name = {one["type"]: one for one in found.values() if one["place"] in {"video", "lirc"}}
    assert set(by_name) == {"camera", "infrared"}
    assert by_name["camera"]["address"] == "/dev/v4l/by-id/usb-Example_Webcam_5678-video-index0"
    assert max(found[at]["took_s"] for at in addresses.values()) < WITHIN_S


def test_rows_are_proposed_written_when_asked_and_then_known(service, home, lines_of_lbr, record_property):
    ports = [word for address, one in AT.items() if one in OF_LBR for word in ("--port", address)]
    told = looked(service, home, *ports, "--write")
    offers = {AT[one["address"]]: one for one in told["proposals"]}
    record_property("proposed", {one: offer["text"] for one, offer in offers.items()})
    assert set(offers) == set(OF_LBR) - {"roboteq"}, "the motor controller has the name of the shipped row"
    assert not any(offer["problems"] for offer in offers.values())
    assert told["written"], told["problems"]
    again = looked(service, home, *ports)
    assert {AT[one["address"]]: one["row"] for one in again["devices"]} == OF_LBR
    assert again["proposals"] == []


def test_each_on_a_serial_line_is_asked_what_it_is_and_nothing_else(service, home, lines, record_property):
    rigs, heard = lines
    before = (home / "robot.db").read_bytes()
    found = {one["address"]: one for one in looked(service, home)["devices"]}
    wheels = rigs["roboteq"].twin.twin.wheels(time.monotonic())
    torques = [drive.torque for one in SERVOS for drive in rigs[one].twin.twin.drives(time.monotonic()).values()]
    seen = {one: found[address] for address, one in AT.items()}
    record_property("after s", {one: row["took_s"] for one, row in seen.items()})
    assert {one: row["type"] for one, row in seen.items()} == {one: one for one in LINES}
    for one, pieces in heard.items():
        tap.assert_asked_only(one, pieces)
    assert b"".join(heard["ld06"]) == b""
    assert wheels == (0.0, 0.0)
    assert torques
    assert not any(torques)
    assert (home / "robot.db").read_bytes() == before
    assert max(row["took_s"] for row in seen.values()) < WITHIN_S
