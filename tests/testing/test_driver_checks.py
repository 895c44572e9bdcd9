"""Every driver that has an emulated device passes what `lbr.testing.driver` checks, and one that is wrong does not."""

import json
import threading
from math import nan

import pytest
from msgspec import Struct, ValidationError

from lbr.capability import Capability, Kind
from lbr.capability.registry import find
from lbr.errors import DeviceError
from lbr.messages.joints import Joint
from lbr.messages.sensing import RangeSensor
from lbr.testing.device import plugged
from lbr.testing.driver import (
    CHECKS,
    DriverBench,
    acknowledges_the_emergency_stop,
    closes_twice,
    may_be_killed,
    misses_its_device_and_comes_back,
    names_a_device_that_is_not_there,
    publishes_no_rubbish,
    says_that_its_device_is_silent,
    says_what_it_reads,
)
from tests.support.waiting import HANG_S

SERVOS = tuple(Joint(name=f"joint_{n}", device_id=n, lower_rad=-2.0, upper_rad=2.0, speed_rps=3.0) for n in range(1, 4))
LIDAR = RangeSensor(name="lidar", kind="lidar", fov_rad=6.2832, min_m=0.02, max_m=12.0, rays=360)
DRIVERS = {
    "riox": {},
    "roboteq": {"guard": False},
    "ultrasonic_ring": {},
    "dynamixel": {"guard": False, "reply_margin_s": 0.05, "on_close": "release"},
    "mpu9150": {},
    "pico": {"pace_s": 0.01},
    "ld06": {},
    "phidget_spatial": {},
    "infrared": {},
    "gamepad": {},
    "uxa90": {"guard": False},
}
ROWS = {"dynamixel": {"given": SERVOS}, "uxa90": {"given": SERVOS}, "ld06": {"given": (LIDAR,)}}
I2C = ("mpu9150", "pico")
SOCKETS = (*I2C, "phidget_spatial")
QUIET = {"infrared", "gamepad"}
"""What sees or says nothing most of the time, so that silence is no trouble."""
WIRED = {"dynamixel": ("joints",), "uxa90": ("joints",), "roboteq": ("drive",)}


@pytest.fixture(params=DRIVERS)
def bench(request, tmp_path, monkeypatch):
    monkeypatch.setattr("lbr.testing.driver.BAD_LINE_S", 0.4)  # a device says some ten lines in that time, or more
    name = request.param
    kind = find(name, tmp_path)
    with plugged(name, tmp_path, scheme="unix:" if name in SOCKETS else "") as device:
        settings = json.dumps({"device": "device", **DRIVERS[name]})
        wired = {"setpoint": WIRED.get(name, ())}
        lose = "brown_out" if name in I2C else "unplug"
        yield DriverBench(kind, settings, device, lose=lose, wired=wired, **ROWS.get(name, {}))


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_driver_of_ours_does_what_every_driver_has_to(check, bench):
    if check is not says_that_its_device_is_silent or bench.kind.name not in QUIET:
        check(bench)


class Row(Struct, frozen=True, kw_only=True):
    device: str


class Value(Struct):
    number: float


class Blind(Capability[Row]):
    """Says the same whatever its device does."""

    def step(self):
        self.ctx.publish("value", Value(1))


class Wild(Capability[Row]):
    """Says what is not a number."""

    def step(self):
        self.ctx.publish("value", Value(nan))


class Mute(Capability[Row]):
    """Says nothing."""


class Vague(Blind):
    """Does not say what it misses."""

    def open(self):
        raise DeviceError("something is wrong")


class Once(Blind):
    """Cannot be closed twice."""

    def open(self):
        self.opened = True

    def close(self):
        del self.opened


@pytest.mark.parametrize(
    ("entry", "check", "error"),
    [
        (Mute, says_what_it_reads, "something is published"),
        (Blind, names_a_device_that_is_not_there, "not missed"),
        (Blind, misses_its_device_and_comes_back, "the loss by 'unplug' is reported"),
        (Blind, acknowledges_the_emergency_stop, "acknowledged"),
        (Blind, says_that_its_device_is_silent, "the silence of the device is reported"),
        (Wild, publishes_no_rubbish, "Expected `float`"),
        (Blind, may_be_killed, "is its package installed"),
        (Vague, names_a_device_that_is_not_there, "which device"),
        (Once, closes_twice, "opened"),
    ],
)
def test_a_driver_that_is_wrong_is_found_out(entry, check, error, tmp_path, monkeypatch):
    monkeypatch.setattr("lbr.testing.driver.BAD_LINE_S", 0.05)
    in_a_process = check is may_be_killed  # which takes its time to start
    monkeypatch.setattr("lbr.testing.driver.WITHIN_S", HANG_S if in_a_process else 0.2)
    kind = Kind(
        name="wrong", summary="-", family="driver", entry=entry, settings=Row, outputs={"value": Value}, moves=True
    )
    with (
        plugged("riox", tmp_path) as device,
        pytest.raises((AssertionError, AttributeError, ValidationError), match=error),
    ):
        check(DriverBench(kind, '{"device": "device"}', device))


def test_what_goes_wrong_in_a_devices_thread_is_raised_where_it_is_closed(tmp_path):
    lived = threading.Event()

    def broken(_twin, _now):
        lived.set()
        raise ZeroDivisionError("no axle")

    with pytest.raises(ZeroDivisionError, match="no axle"), plugged("riox", tmp_path, live=broken):
        assert lived.wait(HANG_S)


def test_a_device_has_the_faults_of_its_row(tmp_path):
    with plugged("riox", tmp_path, settings={"faults": {"unplug": True}}) as device:
        assert device.device.address == str(tmp_path / "device")
        device.fault("unplug", value=False)
