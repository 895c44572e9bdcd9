import errno
import os

import pytest
import serial

from lbr.capability.context import Device
from lbr.drivers import access, serial_line
from lbr.drivers.serial_line import open_line, resolve
from lbr.errors import DeviceError

PORTS = [
    ("/dev/ttyACM0", 0x20D2, 0x5740, "A1"),
    ("/dev/ttyACM1", 0x2341, 0x0043, "B2"),
    ("/dev/ttyACM2", 0x2341, 0x0043, "C3"),
    ("/dev/ttyS0", None, None, ""),
]


def row(address):
    return Device("motors", "roboteq", str(address), {})


@pytest.mark.parametrize(
    ("address", "path"),
    [
        ("/dev/ttyUSB7", "/dev/ttyUSB7"),
        ("usb:20d2:5740", "/dev/ttyACM0"),
        ("usb:20D2:5740:A1", "/dev/ttyACM0"),
        ("usb:2341:0043:C3", "/dev/ttyACM2"),
    ],
)
def test_an_address_finds_its_path(address, path):
    assert resolve(row(address), lambda: PORTS) == path


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        ("usb:2341:0043", r"'motors'.*matches /dev/ttyACM1, /dev/ttyACM2"),
        ("usb:dead:beef", r"nothing matches usb:dead:beef"),
        ("usb:2341", r"'usb:2341' is not one of a path"),
        ("", r"'' is not one of a path"),
        ("by-id:*nowhere*", r"nothing matches by-id"),
    ],
)
def test_an_address_that_finds_nothing_or_too_much_says_so(address, complaint):
    with pytest.raises(DeviceError, match=complaint):
        resolve(row(address), lambda: PORTS)


def test_a_glob_finds_the_name_that_udev_gave(tmp_path, monkeypatch):
    (tmp_path / "usb-Roboteq-if00").touch()
    (tmp_path / "usb-Arduino-if00").touch()
    monkeypatch.setattr(serial_line, "BY_ID", str(tmp_path))
    assert resolve(row("by-id:*Roboteq*")) == str(tmp_path / "usb-Roboteq-if00")
    with pytest.raises(DeviceError, match=r"Arduino.*Roboteq"):
        resolve(row("by-id:usb-*"))


def test_bytes_go_both_ways_and_nothing_blocks(board):
    line = open_line(row(board.path), 115200)
    assert line.read() == b""
    assert line.read(0.01) == b""
    board.say(b"hello")
    assert line.read(1.0) == b"hello"
    assert line.write(b"ping") == 4
    assert board.heard() == b"ping"
    line.close()


def test_a_full_line_takes_what_it_can_and_says_how_much(board):
    line = open_line(row(board.path), 115200)
    counts = [line.write(b"x" * 1000) for _ in range(200)]
    assert counts[0] == 1000
    assert counts[-1] == 0
    line.close()


def test_a_busy_line_names_who_holds_it(board):
    held = serial.Serial(str(board.path), exclusive=True)
    with pytest.raises(DeviceError, match=rf"'motors'.*busy: held by .*pid {os.getpid()}") as err:
        open_line(row(board.path), 115200)
    held.close()
    open_line(row(board.path), 115200).close()
    assert err.value.code == "busy"


def test_a_missing_line_says_what_to_do(tmp_path):
    with pytest.raises(DeviceError, match=r"'motors' at .*nowhere is missing; plug it in"):
        open_line(row(tmp_path / "nowhere"), 115200)


@pytest.mark.parametrize("path", ["file", ".", "/dev/null"])
def test_what_is_no_tty_is_told(tmp_path, path):
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceError, match=r"'motors' at .* is no serial line; correct the address"):
        open_line(row(tmp_path / path), 115200)


@pytest.mark.parametrize("action", ["read", "drop_input", "drop_output"])
def test_unplugging_is_told_by_whatever_is_tried_next(board, action):
    line = open_line(row(board.path), 115200)
    board.unplug()
    with pytest.raises(DeviceError, match=r"'motors' at .*went away"):
        getattr(line, action)()
    with pytest.raises(DeviceError, match="went away"):
        line.write(b"x")
    line.close()
    line.close()


@pytest.mark.parametrize(
    ("number", "code"), [(errno.EACCES, "rights"), (errno.EBUSY, "busy"), (errno.ENOENT, "unreachable"), (None, "unreachable")]
)  # fmt: skip
def test_a_device_that_this_machine_does_not_give_is_told_from_one_that_is_not_there(number, code):
    assert access.code_of(OSError(number, "x") if number else ValueError("x")) == code
    assert DeviceError("it is not there").code == "unreachable"
