"""The examples in docs/examples do what they say, on a whole robot."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path

import pytest

from lbr.bus import wire
from tests.docs.pages import ROOT
from tests.docs.ready import measured
from tests.support import programs
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import HANG_S, STOPS_S, until

EXAMPLES = ROOT / "docs" / "examples"
SCRIPT = EXAMPLES / "drive_with_plain_zenoh.py"


@pytest.fixture
def started(home: Path) -> Iterator[Robot]:
    """A robot of this test's own, because its rows are changed; it has measured its ranges."""
    with running(home) as robot:
        measured(robot)
        yield robot


def install(robot: Robot, name: str, *changes: tuple[str, str]) -> None:
    """Copy a capability file and run its rows, as its page says."""
    folder = robot.home / "capabilities"
    folder.mkdir(mode=0o700, exist_ok=True)
    if "exec" not in (EXAMPLES / f"{name}.sql").read_text():
        shutil.copy(EXAMPLES / f"{name}.py", folder)
        (folder / f"{name}.py").chmod(0o600)
    sql = (EXAMPLES / f"{name}.sql").read_text()
    for old, new in changes:
        assert old in sql
        sql = sql.replace(old, new)
    database = sqlite3.connect(robot.home / "robot.db", timeout=5.0)
    database.executescript(sql)
    database.close()


def ready(robot: Robot, name: str) -> Callable[[], bool]:
    units = lambda: {unit["name"]: unit["phase"] for unit in robot.status()["capabilities"]}  # noqa: E731
    return lambda: units().get(name) == "ready" and set(units().values()) == {"ready"}


def drive_elsewhere(endpoint: str, *prefix: str, seconds: str = "1.0") -> "subprocess.CompletedProcess[str]":
    environment = {key: value for key, value in os.environ.items() if not key.startswith("LBR_")}
    return programs.run(
        [*prefix, sys.executable, str(SCRIPT), endpoint, seconds],
        env=environment,
        capture_output=True,
        text=True,
        timeout=HANG_S,
        check=False,
    )


def test_a_plain_client_drives_reads_ranges_and_stops(robot):
    measured(robot)
    before = robot.ask("world/pose")["x_m"]
    done = drive_elsewhere(robot.endpoints[0])
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("accepted, lease ")
    assert lines[-1] == "stopped"
    assert sum(line.startswith("forward ") for line in lines) >= 5
    assert robot.ask("world/pose")["x_m"] > before + 0.02
    assert robot.ask("drive/state")["holder"] is None


def test_a_plain_client_that_is_killed_leaves_the_robot_standing(robot):
    measured(robot)
    client = programs.start([sys.executable, str(SCRIPT), robot.endpoints[0], "9"], stdout=subprocess.PIPE, text=True)
    assert client.stdout is not None
    client.stdout.readline()
    until(lambda: robot.ask("drive/state")["moving"], what="the robot moves")
    client.kill()
    client.wait()
    client.stdout.close()
    until(lambda: not robot.ask("drive/state")["moving"], limit_s=STOPS_S, what="the lease lapsed")
    assert "lapsed" in robot.ask("drive/state")["reason"]


def test_examples_of_plain_clients_import_nothing_of_ours():
    for name in ("drive_with_plain_zenoh.py", "proximity.py"):
        text = (EXAMPLES / name).read_text()
        assert "import lbr" not in text
        assert "from lbr" not in text


def driven(robot: Robot) -> bool:
    """Say whether wander has come anywhere; programs come last on a busy machine, and its lease may have lapsed."""
    if robot.ask("drive/state")["holder"] != "wander":
        robot.line("wander")
    return abs(robot.ask("world/pose")["x_m"]) > 0.2


def test_wander_drives_when_told_and_rests_when_stopped(started):
    install(started, "wander")
    until(ready(started, "wander"), what="wander is ready")
    assert not started.ask("drive/state")["moving"]
    assert started.line("wander")["code"] == 0
    until(lambda: started.ask("drive/state")["holder"] == "wander", what="wander holds the drive")
    until(lambda: driven(started), what="it drives")
    started.line("stop")
    until(lambda: any(e["kind"] == "wander" for e in started.events()), what="wander rests")
    assert not started.ask("drive/state")["moving"]


TOO_LATE = "check quiet_hours did not answer"
"""What the drive says of a check that came too late, as it may on a busy machine: the answer is no, whatever was asked."""


@pytest.fixture(scope="module")
def quiet() -> Iterator[Robot]:
    """A robot with the check, for which it is quiet now, and whose drive asks it."""
    hour = datetime.now().astimezone().hour
    with tempfile.TemporaryDirectory(prefix="lbr-") as place, running(prepare(Path(place) / "h")) as robot:
        measured(robot)
        install(robot, "quiet_hours", ('"begin": 22, "end": 7', f'"begin": {hour}, "end": {(hour + 2) % 24}'))
        until(ready(robot, "quiet_hours"), what="the check and the drive are ready")
        until(lambda: robot.line("/r/0.15/90")["code"] == 0, what="the check lets slow motion pass")
        yield robot


def test_quiet_hours_refuse_what_is_fast_and_let_pass_what_is_slow(quiet):
    fast = until(lambda: None if TOO_LATE in (said := quiet.line("/r/0.5/90"))["text"] else said)
    assert fast["code"] == 1
    assert "quiet hours until" in fast["text"]
    slow = until(lambda: None if TOO_LATE in (said := quiet.line("/r/0.15/90"))["text"] else said)
    assert slow["code"] == 0, slow


def test_a_check_that_does_not_answer_means_no(quiet):
    quiet.line("stop")
    pid = quiet.capability("quiet_hours")["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        assert quiet.line("/r/0.15/90")["text"] == TOO_LATE
        assert not quiet.ask("drive/state")["moving"]
    finally:
        os.kill(pid, signal.SIGCONT)


def test_a_program_without_our_package_joins_by_its_environment(started):
    install(
        started,
        "proximity",
        ("/opt/proximity/bin/python", sys.executable),
        ("/opt/proximity/proximity.py", str(EXAMPLES / "proximity.py")),
    )
    heard = wire.Subscription(started.bus, f"{started.name}/proximity/nearest", depth=4)
    message = until(heard.take, what="the program speaks")[0]
    near = json.loads(message.payload)["nearest_m"]
    readings = started.ask("ranges/readings")
    assert near == pytest.approx(
        min(readings[key] for key in readings if key.endswith("_m") and readings[key]), abs=0.3
    )
    until(ready(started, "proximity"), what="its token makes it ready")
