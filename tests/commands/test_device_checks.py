"""What the doctor says of device rows."""

import re

import pytest

from lbr.commands import device_checks
from lbr.database.rows import DeviceRow
from lbr.drivers import serial_line
from lbr.drivers.infrared import decoders
from tests.support import shipped
from tests.support.packages import imported_from, package


def judged(address, type_="roboteq"):
    return device_checks.device("lbr", DeviceRow(name="d", type=type_, address=address))


def test_a_path_that_is_there_is_good(tmp_path):
    (tmp_path / "tty").touch()
    found = judged(str(tmp_path / "tty"))
    assert (found.level, found.text) == ("good", str(tmp_path / "tty"))


@pytest.mark.parametrize(
    ("address", "type_", "says", "do"),
    [
        ("/dev/no-such-tty", "roboteq", "/dev/no-such-tty is not there", "ls /dev/serial/by-id"),
        ("/dev/no-such-video", "camera", "is not there", "v4l2-ctl --list-devices"),
        ("i2c:97:0x68", "mpu9150", "/dev/i2c-97 is not there", "modprobe i2c-dev"),
        ("unix:/nowhere/twin", "mpu9150", "/nowhere/twin is not there", "lbr status"),
    ],
)
def test_what_is_not_there_is_a_hint_with_what_to_type(address, type_, says, do):
    found = judged(address, type_)
    assert found.level == "hint"
    assert says in found.text
    assert "runs without it" in found.text
    assert do in found.do


def test_a_machine_without_a_sound_card_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(device_checks, "SOUND_CARDS", tmp_path / "cards")
    assert "no sound card" in judged("alsa:default", "speaker").text
    (tmp_path / "cards").write_text(" 0 [PCH            ]: HDA-Intel - HDA Intel PCH\n")
    monkeypatch.setattr(device_checks.shutil, "which", lambda _program: None)
    assert "apt install alsa-utils" in judged("alsa:default", "speaker").do
    monkeypatch.setattr(device_checks.shutil, "which", lambda program: f"/usr/bin/{program}")
    assert judged("alsa:default", "speaker").level == "good"


def test_a_package_whose_twin_cannot_be_used_is_named(tmp_path):
    assert list(device_checks.emulated()) == []
    package(tmp_path, "no-arm", brings={"twins": {"arm": "no_arm:TWIN", "roboteq": "no_arm:TWIN"}}, files={})
    package(tmp_path, "one", brings={"twins": {"claw": "one:TWIN"}}, files={})
    package(tmp_path, "two", brings={"twins": {"claw": "two:TWIN"}}, files={})
    with imported_from(tmp_path):
        found = list(device_checks.emulated())
    said = "\n".join(one.text for one in found)
    assert len(found) == 4
    assert "the twin 'roboteq' of package 'no-arm 0.1' (twins of component 'no_arm'): lbr has its own" in said
    assert (
        "the twin 'arm' of package 'no-arm 0.1' (twins of component 'no_arm'): it does not load: ModuleNotFoundError"
        in said
    )
    assert said.count("packages one 0.1 and two 0.1 bring it") == 2
    assert {one.level for one in found} == {"hint"}


def test_a_package_whose_kind_cannot_be_used_is_named_without_a_row_too(tmp_path):
    assert list(device_checks.of_packages()) == []
    brings = {"kinds": {"arm": "no_arm:KIND", "drive": "no_arm:KIND"}}
    package(tmp_path, "no-arm", requires=("lbr>=99",), brings=brings, files={})
    with imported_from(tmp_path):
        found = list(device_checks.of_packages())
    assert [one.text.partition("): ")[2].partition(" ")[0] for one in found] == ["it", "lbr"]
    assert {one.level for one in found} == {"hint"}


def test_no_speech_engine_is_a_hint(monkeypatch):
    monkeypatch.setattr(device_checks.ctypes.util, "find_library", lambda _name: None)
    (found,) = device_checks.speech()
    assert (found.level, "espeak-ng" in found.do) == ("hint", True)


@pytest.mark.parametrize(
    ("address", "where"),
    [("/dev/ttyACM0", "/dev/serial/by-id"), ("/dev/ttyUSB3", "/dev/serial/by-id"), ("/dev/video0", "/dev/v4l/by-id")],
)
def test_an_address_that_is_a_number_is_warned_of(address, where):
    (found,) = device_checks.numbered(DeviceRow(name="d", type="dynamixel", address=address))
    assert found.level == "hint"
    assert "another device may have" in found.text
    assert where in found.do


@pytest.mark.parametrize("address", ["by-id:usb-*-if00", "usb:2341:0043", "/dev/serial/by-id/usb-x", "i2c:1:0x68"])
def test_an_address_that_stays_is_not_warned_of(address):
    assert list(device_checks.numbered(DeviceRow(name="d", type="dynamixel", address=address))) == []


def test_no_row_of_a_serial_device_ships_with_a_number():
    tables = re.findall(r"^ *\('\w+', '\w+', '(\w+)', '(/dev/tty\w+|by-id:\S+|usb:\S*)',", shipped.sql(), re.MULTILINE)
    assert {kind for kind, _ in tables} >= {"dynamixel", "uxa90"}
    assert [address for _, address in tables if device_checks.NUMBERED.fullmatch(address)] == []


def test_a_pattern_that_matches_nothing_says_so_and_one_that_does_is_looked_at(tmp_path, monkeypatch, wording):
    monkeypatch.setattr(serial_line, "BY_ID", str(tmp_path))
    found = judged("by-id:usb-*-if00")
    assert (found.level, "nothing matches by-id:usb-*-if00" in found.text) == ("hint", True)
    (tmp_path / "usb-a-if00").touch()
    assert judged("by-id:usb-*-if00").level == "good"
    (tmp_path / "usb-b-if00").touch()
    wording(judged("by-id:usb-*-if00").text)


def test_a_receiver_without_a_decoder_is_bad(tmp_path, monkeypatch):
    node = tmp_path / "lirc0"
    node.touch()
    place = tmp_path / "sys" / "lirc" / "lirc0" / "device"
    place.mkdir(parents=True)
    (place / "protocols").write_text("rc-5 nec sony [lirc]\n")
    monkeypatch.setattr(decoders, "SYS", tmp_path / "sys")
    found = judged(str(node), "infrared")
    assert found.level == "bad"
    assert "decodes nothing, so no beam is heard" in found.text
    assert found.do == "sudo ir-keytable -s device -p sony"
    (place / "protocols").write_text("rc-5 nec [sony] [lirc]\n")
    assert judged(str(node), "infrared").level == "good"


def test_right_after_a_plug_in_the_group_may_still_come(tmp_path, monkeypatch, wording):
    monkeypatch.setattr(device_checks.os, "access", lambda *_: False)
    node = tmp_path / "tty"
    node.touch()
    wording(judged(str(node)).text)
    monkeypatch.setattr(device_checks.access.time, "time", lambda: node.stat().st_ctime + 60)
    assert judged(str(node)).text == f"{node} may not be opened"
