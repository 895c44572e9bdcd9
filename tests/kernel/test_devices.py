"""`lbr devices` on devices of the kernel: found by the names of udev, asked what they are and nothing else, rows proposed."""

import json
import os
import sys
import time
from contextlib import ExitStack
from dataclasses import replace

import pytest

from tests.support import programs, tap
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
    given_to(service, found)
    assert said(service, found, "db", "init").returncode == 0
    return found


def said(user, home, *words):
    argv = [*as_user(user), sys.executable, "-m", "lbr.cli", *words]
    env = os.environ | {"LBR_HOME": str(home)}
    return programs.run(argv, env=env, cwd="/", capture_output=True, text=True, timeout=SAID_S, check=False)


def looked(user, home, *words):
    done = said(user, home, "devices", "--json", "--robot", "lbr", *words)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def test_each_on_a_serial_line_is_asked_what_it_is_and_nothing_else(service, home, place, record_property):
    before = (home / "robot.db").read_bytes()
    with ExitStack() as stack:
        rigs = {one: stack.enter_context(on_line(one, place, *line)) for one, line in LINES.items()}
        heard = {one: tap.of(rig.twin) for one, rig in rigs.items()}
        found = {one["address"]: one for one in looked(service, home)["devices"]}
        wheels = rigs["roboteq"].twin.twin.wheels(time.monotonic())
        torques = [drive.torque for one in SERVOS for drive in rigs[one].twin.twin.drives(time.monotonic()).values()]
    seen = {one: found[str(by_id(identity))] for one, (_, identity) in LINES.items()}
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


def test_rows_are_proposed_written_when_asked_and_then_known(service, home, place, record_property):
    types = ("roboteq", "riox", "ld06")
    with ExitStack() as stack:
        for one in types:
            stack.enter_context(on_line(one, place, *LINES[one]))
        addresses = {str(by_id(LINES[one][1])): one for one in types}

        def proposed(*words):
            told = looked(service, home, *words)
            return told, {addresses[one["address"]]: one for one in told["proposals"] if one["address"] in addresses}

        written, offers = proposed("--write")
        record_property("proposed", {one: offer["text"][:60] for one, offer in offers.items()})
        assert set(offers) == {"riox", "ld06"}, "the motor controller has the shipped row's name"
        assert not any(offer["problems"] for offer in offers.values())
        assert written["written"], written
        again, offers = proposed()
        assert not offers
        rows = {addresses[one["address"]]: one["row"] for one in again["devices"] if one["address"] in addresses}
        assert rows == {"roboteq": "motor_controller", "riox": "riox", "ld06": "ld06"}
    assert said(service, home, "db", "check", "--robot", "lbr").returncode == 0
    assert said(service, home, "db", "undo").returncode == 0
