"""An I2C adaptor of the kernel's `i2c-tiny-usb`: found, not acknowledged, hung, gone."""

import errno
from contextlib import contextmanager
from pathlib import Path

import pytest
from smbus2 import SMBus

from lbr.testing.device import plugged
from tests.support.usb import vhci
from tests.support.usb.device import Played
from tests.support.usb.i2c_function import TinyI2c
from tests.support.usb.rig import until

IMU, WHO_AM_I = 0x68, 0x75
ADAPTORS = Path("/sys/class/i2c-adapter")


def adaptors():
    return {one.name for one in ADAPTORS.iterdir()} if ADAPTORS.exists() else set()


def error(ask):
    """Return the name of the system's error that a question ends in."""
    with pytest.raises(OSError, match="Errno") as told:
        ask()
    return errno.errorcode[told.value.errno]


@contextmanager
def adaptor(folder):
    """Play an adaptor with an inertial unit on its bus; give its number, the function and the cable."""
    before = adaptors()
    with plugged("mpu9150", folder, name="imu", scheme="unix:") as twin:
        until((folder / "imu").exists, "the emulated bus")
        function = TinyI2c(folder / "imu")
        with Played(function) as cable:
            until(lambda: adaptors() - before, "an adaptor", 60.0)
            (name,) = adaptors() - before
            until(lambda: Path(f"/dev/{name}").exists(), "its node", 60.0)
            yield int(name.removeprefix("i2c-")), function, cable, twin


def test_a_bus_answers_refuses_hangs_and_goes(played, tmp_path, record_property):
    if why := vhci.why_no_module("i2c-dev"):
        pytest.skip(why)
    with adaptor(tmp_path) as (number, function, cable, _), SMBus(number) as bus:
        assert bus.read_byte_data(IMU, WHO_AM_I) == 0x68
        assert len(bus.read_i2c_block_data(IMU, 0x3B, 14)) == 14
        refused = error(lambda: bus.read_byte_data(0x22, 0))
        assert refused in {"ENXIO", "EREMOTEIO"}
        function.stuck = True
        hung = error(lambda: bus.read_byte_data(IMU, WHO_AM_I))
        function.stuck = False
        assert bus.read_byte_data(IMU, WHO_AM_I) == 0x68
        cable.unplug()
        gone = error(lambda: bus.read_byte_data(IMU, WHO_AM_I))
        for name, told in (("not acknowledged", refused), ("hung", hung), ("gone", gone)):
            record_property(name, told)
