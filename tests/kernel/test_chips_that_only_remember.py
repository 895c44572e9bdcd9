"""Chips on the kernel's `i2c-stub`, which keeps what is written and does nothing: known by their registers, not taken for live."""

import os
from pathlib import Path

import pytest
from smbus2 import SMBus

from lbr.commands import recognised
from lbr.drivers import recognising
from lbr.drivers.i2c_socket import SocketBus
from lbr.testing.device import plugged
from tests.support import programs
from tests.support.usb import robots, vhci
from tests.support.usb.rig import ADAPTORS, until

IMU, STATUS, COMMANDS, NOBODY = 0x68, 0x69, 0x6B, 0x22
WHO_AM_I = 0x75
REGISTERS = 256
NAME = "SMBus stub driver"
EDIT = "UPDATE device SET address = 'i2c:{}:{:#04x}' WHERE robot = '{}' AND name = '{}'"


def stubs():
    found = ADAPTORS.glob("*/name") if ADAPTORS.exists() else ()
    return [int(one.parent.name.removeprefix("i2c-")) for one in found if one.read_text().strip() == NAME]


@pytest.fixture(scope="module")
def bus(tmp_path_factory):
    """The number of a bus with an MPU-9150's name, and all registers of an emulated PIco."""
    for module in (("i2c-dev",), ("i2c-stub", f"chip_addr={IMU},{STATUS},{COMMANDS}")):
        if why := vhci.why_no_module(*module):
            pytest.skip(why)
    try:
        until(stubs, "the stub's adaptor", 60.0)
        (number,) = stubs()
        until(Path(f"/dev/i2c-{number}").exists, "its node", 60.0)
        _copy_a_pico(tmp_path_factory.mktemp("pico"), number)
        yield number
    finally:
        programs.run(["modprobe", "-r", "i2c-stub"], check=False)


def _copy_a_pico(folder, number):
    with plugged("pico", folder, name="pico", scheme="unix:"), SMBus(number) as stub:
        until((folder / "pico").exists, "the emulated PIco")
        emulated = SocketBus(str(folder / "pico"), deadline_s=5.0)
        for address in (STATUS, COMMANDS):
            for register in range(REGISTERS):
                stub.write_word_data(address, register, emulated.read_word_data(address, register))
        emulated.close()
        stub.write_byte_data(IMU, WHO_AM_I, IMU)


def test_they_are_known_by_their_registers(bus):
    _, known, _ = recognised.known_kinds(Path(os.devnull))
    assert {(at, type_) for at, (type_, _) in recognising.at_i2c(f"i2c:{bus}", known)} == {
        (IMU, "mpu9150"),
        (STATUS, "pico"),
    }


@pytest.mark.parametrize(
    ("name", "capability", "at", "told"),
    [
        ("lbr", "imu", IMU, "does not answer at 0x68 (Connection timed out)"),
        ("bioloid", "ups", STATUS, "its running counter stands still"),
        ("bioloid", "ups", NOBODY, "does not answer at 0x22 (No such device)"),
    ],
    ids=["inertial unit", "supply", "nobody"],
)
def test_none_is_taken_for_live_and_that_is_told(service, place, bus, name, capability, at, told, record_property):
    edit = EDIT.format(bus, at, name, capability)
    home = place / f"{name}-{at:#x}"
    with robots.running(service, home, capability, robot=name, edits=(edit,)) as robot:
        until(lambda: told in robot.capability(capability)["reason"], f"told: {told}", 60.0)
        record_property("told", robot.capability(capability)["reason"][:160])
