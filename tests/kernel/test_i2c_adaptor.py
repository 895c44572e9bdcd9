"""An I2C adaptor of the kernel's `i2c-tiny-usb`: found, not acknowledged, hung, gone."""

import errno

import pytest
from smbus2 import SMBus

from tests.support.usb import vhci
from tests.support.usb.rig import adaptor

IMU, WHO_AM_I = 0x68, 0x75


def error(ask):
    """Return the name of the system's error that a question ends in."""
    with pytest.raises(OSError, match="Errno") as told:
        ask()
    return errno.errorcode[told.value.errno]


def test_a_bus_answers_refuses_hangs_and_goes(played, tmp_path, record_property):
    if why := vhci.why_no_module("i2c-dev"):
        pytest.skip(why)
    with adaptor(tmp_path, "mpu9150") as (number, function, cable), SMBus(number) as bus:
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
