"""A whole robot on mecanum wheels: rows, and a package that brings the driver of its four motors and their twin."""

import os
import signal
from math import hypot
from pathlib import Path

import pytest

from tests.support import robot as robots
from tests.support.packages import PROFILES, on_path, package, robot_package
from tests.support.waiting import STOPS_S, until

ROOT = Path(__file__).resolve().parents[2]
ROWS = """
INSERT INTO robot (name, model) VALUES ('crab', 'four mecanum wheels');
INSERT INTO device (robot, name, type, address) VALUES ('crab', 'controller', 'quad', '/dev/ttyACM9');
INSERT INTO kinematics (robot, name, kind) VALUES ('crab', 'base', 'mecanum');
INSERT INTO wheel (robot, name, motor, x_m, y_m, roller_rad, diameter_m) VALUES
    ('crab', 'fl', 'front_left', 0.13, 0.18, -0.7854, 0.15), ('crab', 'fr', 'front_right', 0.13, -0.18, 0.7854, 0.15),
    ('crab', 'rl', 'rear_left', -0.13, 0.18, 0.7854, 0.15), ('crab', 'rr', 'rear_right', -0.13, -0.18, -0.7854, 0.15);
INSERT INTO capability (robot, name, kind, settings, needs) VALUES
    ('crab', 'motors', 'quad', '{"device": "controller"}', '[]'),
    ('crab', 'drive', 'drive', '{"rules": []}', '["motors"]'),
    ('crab', 'odometry', 'odometry', '{"counts_per_turn": 400}', '["motors"]'),
    ('crab', 'world', 'world', '{"walls": [], "dock": null, "body": {"counts_per_turn": 400}}', '[]');
INSERT INTO channel (robot, source, target) VALUES
    ('crab', 'drive.setpoint', 'motors.setpoint'),
    ('crab', 'motors.state', 'drive.motors'),
    ('crab', 'motors.state', 'odometry.motors'),
    ('crab', 'odometry.state', 'drive.odometry');
"""


@pytest.fixture
def crab(tmp_path, monkeypatch):
    site = tmp_path / "site"
    robot_package(site, "crab", rows=ROWS, profiles=PROFILES)
    brings = {"kinds": {"quad": "tests.drivers.tiny_wheels:QUAD"}, "twins": {"quad": "tests.drivers.quad_twin:TWIN"}}
    package(site, "my-quad", brings=brings, files={})
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((on_path(site), str(ROOT))))
    robot = robots.start(robots.prepare(tmp_path / "home"), profile="crab-sim")
    yield robot
    robot.close()


class Sender:
    """Moves the robot by a twist for as long as it is asked to go on."""

    def __init__(self, robot, **twist):
        self.robot, self.twist, self.lease = robot, twist, ""

    def until(self, enough, what):
        def done():
            reply = self.robot.ask("drive/twist", {**self.twist, "lease": self.lease})
            self.lease = reply["lease"] if reply and reply["accepted"] else ""
            return enough()

        until(done, what=what)


@pytest.mark.slow_start
@pytest.mark.timeout(90)
@pytest.mark.parametrize("killed", ["drive", "motors"])
def test_it_moves_sideways_and_stands_when_a_process_on_the_way_to_its_motors_is_killed(crab, killed):
    def pose():
        return crab.ask("world/pose")

    until(lambda: (crab.ask("odometry/state") or {}).get("valid"), what="odometry")
    sender = Sender(crab, vy_mps=0.3)
    sender.until(lambda: pose()["y_m"] > 0.15, "it goes to the left")
    assert abs(pose()["x_m"]) < 0.03
    told = crab.ask("odometry/state")
    assert told["y_m"] == pytest.approx(pose()["y_m"], abs=0.05)
    assert told["aside_mps"] == pytest.approx(0.3, abs=0.06)
    assert set(crab.ask("motors/state")["motors"]) == {"front_left", "front_right", "rear_left", "rear_right"}
    os.kill(crab.capability(killed)["pid"], signal.SIGKILL)

    def stands():
        before = pose()
        after = until(lambda: pose() if pose()["time_s"] > before["time_s"] + 0.05 else None, what="its world")
        return hypot(after["x_m"] - before["x_m"], after["y_m"] - before["y_m"]) < 1e-4

    until(stands, limit_s=STOPS_S, what="it stands")
    refused = crab.ask("drive/twist", {"vy_mps": 0.3, "lease": sender.lease})
    assert not (refused and refused["accepted"])
