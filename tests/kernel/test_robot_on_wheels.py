"""The robot lbr as it ships, on a motor controller and a range board of the kernel, run as the service runs it."""

import time

import pytest

from tests.support.mover import Mover
from tests.support.usb import robots
from tests.support.usb.rig import ARDUINO, ROBOTEQ, CdcAcm, by_id, on_line, until

STILL_S = 2.0


@pytest.fixture(scope="module")
def devices(service, place):
    with (
        on_line("roboteq", place, CdcAcm, ROBOTEQ) as motors,
        on_line("ultrasonic_ring", place, CdcAcm, ARDUINO) as board,
    ):
        yield motors, board


@pytest.fixture(scope="module")
def robot(service, place, devices):
    with robots.running(service, place / "h", *robots.ON_WHEELS, edits=robots.ON_WHEELS_EDITS) as found:
        yield found


def test_motors_and_ranges_are_ready_at_their_names(robot, record_property):
    for name in robots.ON_WHEELS:
        record_property(f"{name} ready after s", round(robots.ready(robot, name), 1))


def test_a_cable_pulled_in_motion_stops_the_wheels_and_nothing_resumes(robot, devices, record_property):
    motors, _ = devices
    outputs = robots.Outputs(motors)
    robots.ready(robot, "motors")
    mover = Mover(robot, 90.0).start(60.0)
    try:
        outputs.wait(lambda: not outputs.zero, "motion", 30.0)
        pulled = motors.cable.unplug()
        outputs.wait(lambda: outputs.zero, "zero", 5.0)
        zero_s = time.monotonic() - pulled
        record_property("zero after ms", round(zero_s * 1e3))
        _, reason = robots.degraded(robot, "motors")
        record_property("told after s", round(time.monotonic() - pulled, 2))
        assert "missing" in reason or "went away" in reason
        until(lambda: not by_id(ROBOTEQ).exists(), "its name gone", 60.0)
        plugged = time.monotonic()
        motors.cable.plug()
        robots.ready(robot, "motors")
        record_property("back after s", round(time.monotonic() - plugged, 2))
        end = time.monotonic() + STILL_S
        while time.monotonic() < end:
            assert outputs.zero, "the old motion goes on"
            time.sleep(0.005)
    finally:
        mover.cease()
    assert zero_s < 0.3


def test_it_drives_again_when_told_to(robot, devices):
    outputs = robots.Outputs(devices[0])
    robots.ready(robot, "motors")
    mover = Mover(robot, 270.0).start(60.0)
    try:
        outputs.wait(lambda: not outputs.zero, "motion", 30.0)
    finally:
        mover.cease()
    outputs.wait(lambda: outputs.zero, "zero, since nothing renews the lease", 5.0)


def test_the_range_board_goes_and_comes_back(robot, devices, record_property):
    _, board = devices
    robots.ready(robot, "ranges")
    pulled = board.cable.unplug()
    robots.degraded(robot, "ranges")
    record_property("told after s", round(time.monotonic() - pulled, 2))
    plugged = time.monotonic()
    board.cable.plug()
    robots.ready(robot, "ranges")
    record_property("back after s", round(time.monotonic() - plugged, 2))
