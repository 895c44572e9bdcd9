"""What a gamepad's driver asks of the kernel (linux/input.h), with the kernel's answers played; the records come by a FIFO."""

import errno
import os
import struct

import pytest

from lbr.capability.context import Device
from lbr.drivers.gamepad.receiver import Receiver
from lbr.drivers.input_events import EVENT
from lbr.errors import DeviceError
from tests.support.waiting import until

TL, KEY, ABS = 0x136, 1, 3


class Kernel:
    """Answers the requests of input devices as an Xbox pad's would be, and knows what is held."""

    def __init__(self):
        self.bus = 0x0005
        self.axes = {0: (-32768, 32767), 1: (-32768, 32767), 2: (0, 1023), 3: (-32768, 32767), 4: (-32768, 32767)}
        self.values = {}
        self.pressed = set()
        self.grabbed_by_another = False
        self.asked = []

    def ioctl(self, _descriptor, request, argument=0):
        self.asked.append(request)
        number, size = request & 0xFF, request >> 16 & 0x3FFF
        assert request >> 8 & 0xFF == ord("E")
        match number:
            case 0x90 if self.grabbed_by_another:
                raise OSError(errno.EBUSY, "Device or resource busy")
            case 0x90 | 0xA0:
                return argument
            case 0x02:
                return struct.pack("=4H", self.bus, 0x045E, 0x02E0, 1)
            case 0x06:
                return b"Xbox Wireless Controller\0".ljust(size, b"\0")
            case 0x18:
                return sum(1 << code for code in self.pressed).to_bytes(size, "little")
            case 0x23:
                return sum(1 << code for code in self.axes).to_bytes(size, "little")
            case _ if 0x40 <= number < 0x80:
                least, most = self.axes[number - 0x40]
                return struct.pack("=6i", self.values.get(number - 0x40, 0), least, most, 16, 128, 0)
        raise OSError(errno.EINVAL, "Invalid argument")


@pytest.fixture
def kernel(monkeypatch):
    kernel = Kernel()
    monkeypatch.setattr("lbr.drivers.input_node.fcntl.ioctl", kernel.ioctl)
    return kernel


@pytest.fixture
def fifo(tmp_path):
    path = tmp_path / "event7"
    os.mkfifo(path)
    descriptor = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    yield path, descriptor
    os.close(descriptor)


@pytest.fixture
def opened(kernel, fifo):
    receivers = []

    def open_it():
        receivers.append(Receiver(Device("pad", "gamepad", str(fifo[0]), {})))
        return receivers[-1]

    yield open_it
    for one in receivers:
        one.close()


def told(fifo, *events):
    os.write(fifo[1], b"".join(EVENT.pack(5, 0, *one) for one in events))


def test_it_takes_the_pad_for_itself_and_asks_what_it_is(kernel, opened):
    receiver = opened()
    assert (receiver.name, receiver.link) == ("Xbox Wireless Controller", "bluetooth")
    assert kernel.asked[:2] == [0x400445A0, 0x40044590], "the clock, then the grab"


@pytest.mark.parametrize(("bus", "link"), [(3, "usb"), (5, "bluetooth"), (0x19, "other")])
def test_by_what_it_is_connected_is_told(kernel, opened, bus, link):
    kernel.bus = bus
    assert opened().link == link


def test_what_is_held_when_it_is_opened_is_known(kernel, opened):
    kernel.pressed, kernel.values = {TL}, {1: -32768, 2: 1023}
    held = opened().held()
    assert held.pressed == ("tl",)
    assert (held.axes["left_y"], held.axes["left_trigger"], held.axes["right_x"]) == (1.0, 1.0, 0.0)


def test_of_dropped_events_the_kernel_is_asked(kernel, opened, fifo):
    receiver = opened()
    kernel.pressed, kernel.values = {0x130}, {0: 32767}
    told(fifo, (KEY, TL, 1), (0, 0, 0), (0, 3, 0), (KEY, TL, 0), (0, 0, 0))
    found = receiver.poll()
    assert [held.pressed for held in found] == [("tl",), ("a",)]
    assert found[-1].axes["left_x"] == 1.0


def test_what_another_program_has_taken_is_busy(kernel, opened):
    kernel.grabbed_by_another = True
    with pytest.raises(DeviceError, match="another program") as err:
        opened()
    assert err.value.code == "busy"


def test_a_keyboard_is_no_gamepad(kernel, opened, wording):
    kernel.axes = {}
    with wording.of(DeviceError):
        opened()


def test_a_pad_that_goes_away_is_told(kernel, opened, fifo, monkeypatch):
    receiver = opened()

    def gone(*_):
        raise OSError(errno.ENODEV, "No such device")

    monkeypatch.setattr("lbr.drivers.input_node.os.read", gone)
    with pytest.raises(DeviceError, match=r"went away \(No such device\); check its cable"):
        receiver.poll()


def test_a_writer_that_ends_is_a_pulled_cable(kernel, tmp_path):
    path = tmp_path / "event8"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    receiver = Receiver(Device("pad", "gamepad", str(path), {}))
    os.close(writer)

    def ended():
        try:
            return bool(receiver.poll())
        except DeviceError as err:
            return "end of file" in str(err)

    until(ended)
    receiver.close()
