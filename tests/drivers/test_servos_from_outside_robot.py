"""A whole simulated robot with a servo family that lbr does not know: its kind and its twin are found by entry points."""

from pathlib import Path

import pytest

from tests.support import robot as robots
from tests.support.robot import until

ROOT = Path(__file__).resolve().parents[2]
ROWS = (
    "INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'arm_bus', 'feetech', 'usb:1a86:55d3')",
    "INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'arm', 'feetech', '{\"device\": \"arm_bus\"}')",
    "INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps) VALUES "
    + ", ".join(f"('lbr', 'arm_{number}', {number}, -1.5, 1.5, 2.0)" for number in range(1, 7)),
    robots.only("lbr", "world", "arm"),
)


@pytest.fixture
def robot(tmp_path, monkeypatch):
    """A robot beside which the package is installed as pip would: modules on the path, and metadata with entry points."""
    info = tmp_path / "packages" / "my_sts-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-sts\nVersion: 1.0\n")
    points = "[lbr.capabilities]\nfeetech = tests.drivers.sts.driver:KIND\n[lbr.twins]\nfeetech = tests.drivers.sts.twin:TWIN\n"
    (info / "entry_points.txt").write_text(points)
    monkeypatch.setenv("PYTHONPATH", f"{info.parent}:{ROOT}")
    robot = robots.start(robots.prepare(tmp_path / "home", edits=ROWS))
    yield robot
    robot.close()


def test_a_robot_of_rows_gets_driver_and_twin_and_its_faults_are_told(robot):
    def servos():
        state = robot.ask("arm/state") or {}
        return {servo["id"]: servo for servo in state.get("servos", [])}

    until(lambda: robot.capability("arm")["phase"] == "ready", what="the arm's driver")
    until(lambda: [one["voltage_v"] for one in servos().values()] == [12.1] * 6, what="six servos")
    reply = robot.ask("world/fault", {"device": "arm_bus", "name": "overload", "value": "3"})
    assert reply["accepted"], reply
    until(lambda: servos()[3]["latched"] == ["overload"], what="the overload of servo 3")
    assert not servos()[2]["latched"]
