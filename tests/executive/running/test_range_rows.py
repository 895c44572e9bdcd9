"""Sensors of distance by rows, on a running robot: they come with an edit, count at once, and stop it when they fail."""

import json
import os
import signal
import sqlite3
import time
from contextlib import suppress

import pytest

from tests.support.robot import Robot
from tests.support.trace import Trace
from tests.support.waiting import until

SIDES = {
    "north": (2.5, 0.0, 0.1, 5.0),
    "south": (-2.5, 0.0, 0.1, 5.0),
    "west": (0.0, 2.5, 5.0, 0.1),
    "east": (0.0, -2.5, 5.0, 0.1),
}
WALLS = [{"name": n, "x_m": x, "y_m": y, "length_m": a, "width_m": b} for n, (x, y, a, b) in SIDES.items()]
ROOM = f"""
UPDATE capability SET settings = json_set(settings, '$.walls', json('{json.dumps(WALLS)}'), '$.dock', json('null'))
WHERE robot = 'lbr' AND name = 'world'
"""
LIDAR = """
INSERT INTO range_sensor (robot, name, kind, z_m, fov_rad, min_m, max_m, rays) VALUES
    ('lbr', 'lidar', 'lidar', 0.25, 6.2832, 0.02, 12, 360);
INSERT INTO device (robot, name, type, address) VALUES ('lbr', 'lidar_line', 'ld06', '/dev/ttyUSB7');
INSERT INTO capability (robot, name, kind, settings) VALUES ('lbr', 'lidar', 'ld06', '{"device": "lidar_line"}');
INSERT INTO channel (robot, source, target) VALUES ('lbr', 'lidar.scan', 'drive.scans');
"""


def edit(robot: Robot, script: str) -> None:
    with sqlite3.connect(robot.home / "robot.db", timeout=5.0) as database:
        database.executescript(f"PRAGMA foreign_keys = ON; BEGIN; {script} COMMIT;")
    database.close()


def phase(robot: Robot, name: str) -> str:
    return robot.capability(name)["phase"]


def state(robot: Robot) -> dict:
    return until(lambda: robot.ask("drive/state"), what="an answer")


def drives(robot: Robot, line: str = "/r/0.2/0") -> dict | None:
    """Return what holds the base if it moves so; what had it before has ended."""
    said = robot.line(line)
    return said.get("hold") if said["code"] == 0 else None


def refusal(robot: Robot, line: str) -> str:
    """Return why a standing robot does not begin a motion; empty if it does."""
    robot.line("s")
    said = robot.line(line)
    return said["text"] if said["code"] else ""


def renew(robot: Robot, hold: dict) -> dict:
    return robot.ask(hold["key"].partition("/")[2], hold["payload"]) or {}


def left(robot: Robot) -> float | None:
    """Return the power of the left motor, if its driver tells it."""
    return (robot.ask("motors/state") or {}).get("left")


def seen(robot: Robot) -> dict[str, float]:
    """Return what is seen at a moment at which all of it is known."""
    return until(lambda: None not in (sees := state(robot).get("sees", {"": None})).values() and sees, what="all seen")


def why_it_stands(robot: Robot, hold: dict, line: str) -> str:
    """Renew a hold, and return why the base stands; where a busy machine ended the motion, the line begins another."""
    renew(robot, hold)
    drive = state(robot)
    if drive["holder"] is not None:
        return drive["reason"]
    reply = robot.line(line)
    hold.update(reply.get("hold") or {})
    return f"{drive['reason']}; {reply['text']}"


@pytest.fixture
def lidar(robot):
    """The robot with a lidar, ready, in a room with nothing near."""
    if phase(robot, "lidar") == "absent":
        edit(robot, f"{ROOM}; {LIDAR}")
    for fault in ("unplug", "dark", "frozen"):
        robot.line(f"/fault/lidar_line/{fault}/off")
    robot.line("/obstacle/off")
    until(lambda: phase(robot, "lidar") == "ready" and phase(robot, "drive") == "ready")
    until(lambda: set(state(robot).get("sees", {})) == {f"lidar {s}" for s in ("forward", "back", "left", "right")})
    until(lambda: None not in state(robot)["sees"].values(), what="a whole scan")
    yield robot
    robot.line("s")


def test_rows_make_a_lidar_that_the_drive_goes_by(lidar):
    sees = seen(lidar)
    assert sees["lidar forward"] == pytest.approx(2.45 - 0.215, abs=0.05)
    assert sees["lidar left"] == pytest.approx(2.45 - 0.15, abs=0.05)
    told = until(lambda: lidar.line("/report/telemetry")["data"].get("lidar/scan"), what="the scan, reported in time")
    assert told["sensor"] == "lidar"
    refused = lidar.line("/r/0.2/0/60/lidar/3")
    assert "sensor 'lidar' is not one of forward, back, left, right, bottom" in refused["text"]
    until(lambda: (hold := drives(lidar)) and renew(lidar, hold).get("accepted"), what="a motion that is held")


def test_what_the_lidar_alone_sees_stops_the_robot_before_it(lidar):
    pose = lidar.ask("world/pose")
    lidar.line(f"/obstacle/{pose['x_m'] + 0.72:.2f}/{pose['y_m'] - 0.31:.2f}")
    until(lambda: seen(lidar)["lidar forward"] < 0.5)
    assert lidar.ask("ranges/readings")["forward_m"] > 0.6, "the sensor ahead hears nothing of it"
    hold = until(lambda: drives(lidar))

    def came_near() -> bool:
        return "lidar forward 0." in why_it_stands(lidar, hold, "/r/0.2/0") and seen(lidar)["lidar forward"] < 0.31

    until(came_near, what="what it is stopped by")
    pose = lidar.ask("world/pose")
    assert not pose["touching"]
    assert seen(lidar)["lidar forward"] == pytest.approx(0.25, abs=0.06)
    until(lambda: "lidar forward" in refusal(lidar, "/r/0.2/0"), what="its refusal")
    assert until(lambda: drives(lidar, "/r/0.2/180")), "away from it is free"


@pytest.mark.parametrize("fault", ["unplug", "dark"])
def test_a_lidar_that_fails_stops_the_robot_and_lets_it_go_on_afterwards(lidar, fault):
    until(lambda: drives(lidar, "/r/0.1/180") and (left(lidar) or 0.0) < 0.0, what="motion")
    lidar.line(f"/fault/lidar_line/{fault}")
    until(lambda: (drives(lidar, "/r/0.1/180"), left(lidar) == 0.0)[1])
    until(lambda: "lidar back" in refusal(lidar, "/r/0.1/180"), what="its refusal")
    lidar.line(f"/fault/lidar_line/{fault}/off")
    until(lambda: drives(lidar, "/r/0.1/0"), what="motion with a lidar that works again")


def test_a_lidar_that_tells_the_same_for_ever_stops_the_robot(lidar):
    lidar.line("/fault/lidar_line/frozen")
    hold = until(lambda: drives(lidar, "/r/0.2/180"))
    until(lambda: "is frozen" in why_it_stands(lidar, hold, "/r/0.2/180"), what="why it does not drive")
    until(lambda: left(lidar) == 0.0)


def test_a_lidar_driver_that_is_killed_and_does_not_come_back_stops_the_robot(lidar):
    until(lambda: drives(lidar, "/r/0.1/0") and (left(lidar) or 0.0) > 0.0, what="motion")
    hold = until(lambda: drives(lidar, "/r/0.1/0"))
    trace, began_ns, killed = Trace(lidar.trace), time.monotonic_ns(), set()

    def stopped() -> bool:
        """Kill it once more: a new one can be there before the last scan is too old, and the robot drives on by right."""
        renew(lidar, hold)
        pid = lidar.capability("lidar")["pid"]
        if pid and pid not in killed and len(killed) < 3:
            killed.add(pid)
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        return trace.first_zero(began_ns, limit_s=0.0) is not None

    until(stopped)
    until(lambda: phase(lidar, "lidar") == "ready" and lidar.capability("lidar")["pid"] not in killed)
    lidar.line("s")
    assert until(lambda: drives(lidar, "/r/0.1/180"))


def test_one_more_distance_is_a_row(lidar):
    edit(
        lidar,
        "INSERT INTO range_sensor (robot, name, kind, x_m, y_m, z_m, max_m) VALUES"
        " ('lbr', 'bow', 'infrared', 0.215, 0.1, 0.2, 4);",
    )
    until(lambda: "bow" in (lidar.ask("ranges/readings") or {}).get("others_m", {}))
    until(lambda: (state(lidar).get("sees") or {}).get("bow forward") is not None)
    assert until(lambda: drives(lidar, "/r/0.1/0/150/bow/2"))
    lidar.line("s")
    lidar.line("/fault/range_board/error/bow")
    until(lambda: "bow forward" in refusal(lidar, "/r/0.1/0"))
    edit(lidar, "DELETE FROM range_sensor WHERE robot = 'lbr' AND name = 'bow';")
    until(lambda: "bow forward" not in (state(lidar).get("sees") or {"bow forward": 0}))
    assert until(lambda: drives(lidar, "/r/0.1/0"))
