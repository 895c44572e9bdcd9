"""Robots on an I2C adaptor of the kernel: an inertial unit and a supply, a bus that hangs, an adaptor pulled out."""

import time

import pytest

from tests.support.usb import robots, vhci
from tests.support.usb.rig import adaptor, until

ROBOTS = {
    "lbr": ("mpu9150", "imu", "imu", 0x68, ("imu", "attitude")),
    "bioloid": ("pico", "ups", "ups", 0x69, ("ups",)),
}


@pytest.fixture(scope="module", params=sorted(ROBOTS))
def on_its_bus(request, service, place):
    """A robot with one device on I2C; give it, the device's capability, the function and the cable."""
    if why := vhci.why_no_module("i2c-dev"):
        pytest.skip(why)
    type_, device, name, at, names = ROBOTS[request.param]
    with adaptor(place, type_) as (number, function, cable):
        edit = (
            f"UPDATE device SET address = 'i2c:{number}:{at:#x}' WHERE robot = '{request.param}' AND name = '{device}'"
        )
        with robots.running(service, place / request.param, *names, robot=request.param, edits=(edit,)) as robot:
            yield robot, name, function, cable


def test_it_is_read_through_the_executive(on_its_bus, record_property):
    robot, name, _, _ = on_its_bus
    robots.ready(robot, name)
    if name == "imu":
        until(lambda: (robot.ask("attitude/state") or {}).get("valid"), "the attitude", 60.0)
        record_property("roll in rad", round(robot.ask("attitude/state")["roll_rad"], 3))
    else:
        until(lambda: (robot.ask("ups/state") or {}).get("external_v"), "the supply's voltage", 60.0)
        record_property("external voltage", robot.ask("ups/state")["external_v"])


def test_a_bus_that_hangs_is_told_and_read_again_when_it_lets_go(on_its_bus, record_property):
    robot, name, function, _ = on_its_bus
    robots.ready(robot, name)
    at = time.monotonic()
    function.stuck = True
    try:
        _, reason = robots.degraded(robot, name)
    finally:
        function.stuck = False
    record_property("told after s", round(time.monotonic() - at, 2))
    record_property("told", reason[:100])
    record_property("back after s", round(robots.ready(robot, name), 2))


def test_an_adaptor_pulled_out_is_told_and_read_again_when_it_is_back(on_its_bus, record_property):
    robot, name, _, cable = on_its_bus
    robots.ready(robot, name)
    pulled = cable.unplug()
    robots.degraded(robot, name)
    record_property("told after s", round(time.monotonic() - pulled, 2))
    plugged_s = time.monotonic()
    cable.plug()
    robots.ready(robot, name)
    record_property("back after s", round(time.monotonic() - plugged_s, 2))
