"""What the doctor says of device rows."""

import pytest

from lbr.commands import device_checks
from lbr.database.rows import DeviceRow


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


def test_no_speech_engine_is_a_hint(monkeypatch):
    monkeypatch.setattr(device_checks.ctypes.util, "find_library", lambda _name: None)
    (found,) = device_checks.speech()
    assert (found.level, found.do) == ("hint", "sudo apt install espeak-ng")
