"""The robot lbr with a RIOX instead of its inertial unit, on a serial line of the kernel: read, pulled out, read again."""

import time

import pytest

from tests.support.usb import robots
from tests.support.usb.rig import RIOX, CdcAcm, by_id, on_line, until

EDITS = (
    f"UPDATE device SET type = 'riox', address = '{by_id(RIOX)}' WHERE robot = 'lbr' AND name = 'imu'",
    "UPDATE capability SET kind = 'riox' WHERE robot = 'lbr' AND name = 'imu'",
)
"""As the robot's page says it."""
SAMPLES = 90


@pytest.fixture(scope="module")
def unit(service, place):
    with on_line("riox", place, CdcAcm, RIOX) as rig:
        yield rig


@pytest.fixture(scope="module")
def robot(service, place, unit):
    with robots.running(service, place / "h", "imu", "attitude", edits=EDITS) as found:
        yield found


def attitude(robot):
    return robot.ask("attitude/state") or {}


def test_it_is_read_through_the_executive(robot, record_property):
    record_property("ready after s", round(robots.ready(robot, "imu"), 1))
    until(lambda: attitude(robot).get("valid"), "the attitude", 60.0)
    record_property("roll in rad", round(attitude(robot)["roll_rad"], 3))


def test_most_samples_are_valid(robot, record_property):
    robots.ready(robot, "imu")
    seen = {}

    def sampled():
        if one := robot.ask("imu/sample"):
            seen[one["time_s"]] = one["valid"]
        return len(seen) >= SAMPLES

    until(sampled, f"{SAMPLES} samples", 120.0)
    record_property("valid samples", f"{sum(seen.values())} of {len(seen)}")
    assert sum(seen.values()) >= 0.9 * len(seen)


def test_a_pulled_cable_is_told_and_it_is_read_again_when_it_is_back(robot, unit, record_property):
    robots.ready(robot, "imu")
    until(lambda: attitude(robot).get("valid"), "the attitude", 60.0)
    pulled = unit.cable.unplug()
    _, reason = robots.degraded(robot, "imu")
    record_property("told after s", round(time.monotonic() - pulled, 2))
    assert any(words in reason for words in ("missing", "went away")), reason
    until(lambda: not attitude(robot).get("valid"), "no attitude any more", 60.0)
    until(lambda: not by_id(RIOX).exists(), "its name gone", 60.0)
    plugged = time.monotonic()
    unit.cable.plug()
    robots.ready(robot, "imu")
    record_property("back after s", round(time.monotonic() - plugged, 2))
    until(lambda: attitude(robot).get("valid"), "the attitude again", 60.0)
