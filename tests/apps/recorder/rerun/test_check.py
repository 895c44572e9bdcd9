"""A recording with lines goes through the robot's own processes: the same rows do the same, others are found out."""

import json
import signal
import subprocess
import threading
from contextlib import closing

import pytest

from lbr import client
from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.rerun import check
from lbr.client import RefusalError
from lbr.errors import InputError
from tests.support import programs
from tests.support.robot import LBR, environment, lbr, prepare, running
from tests.support.waiting import until

NAME = "walk"


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A home with a recording in which a robot is driven, refused and stopped."""
    home = prepare(tmp_path_factory.mktemp("replay"), "imu", "attitude", "box")
    with pytest.MonkeyPatch.context() as patch, running(home) as robot:
        patch.setenv("LBR_HOME", str(home))
        command = [*LBR, "record", "--lines", "--name", NAME]
        recording = programs.start(command, env=environment(home), stderr=subprocess.PIPE, text=True)
        with closing(recording.stderr):
            assert "records" in recording.stderr.readline()
            pass_time(robot, 2.5)
            with client.connect("lbr", name="test") as found:
                with found.drive(0.3, 90):
                    until(lambda: abs(robot.ask("motors/state")["left"]) > 0.25, what="motion")
                    pass_time(robot, 0.5)
                with pytest.raises(RefusalError, match="malformed"):
                    found.ask("drive/turn", angle_deg="no number")
            pass_time(robot, 2.0)
            recording.send_signal(signal.SIGINT)
            recording.wait(20)
    return home


def pass_time(robot, seconds):
    """Wait for so much of what the inertial unit measures."""
    begun = robot.ask("imu/sample")["time_s"]
    until(lambda: robot.ask("imu/sample")["time_s"] > begun + seconds, what=f"{seconds} s")


def recorded(home):
    return check.read((home / "recordings" / "lbr" / f"{NAME}.mcap",), 0, selection.LAST_NS)


@pytest.mark.timeout(120)
def test_the_same_rows_do_as_recorded(home):
    done = lbr(home, "replay", NAME, "--check", "--json", limit_s=60.0)
    found = json.loads(done.stdout)
    assert done.returncode == 0, found
    assert found["same"]
    assert found["setpoints"]["motors/setpoint"]["samples"] > 50
    assert found["commands"]["said"] >= 5
    assert found["reasons"]["told"] >= 3
    assert set(found["runs"]) == {"motors", "ranges", "drive", "imu", "attitude"}
    assert "world" in found["left_out"]


@pytest.mark.timeout(120)
def test_rows_that_do_otherwise_are_found_out(home, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(home))
    found = recorded(home)
    drive = next(one for one in found.rows.tables["capability"] if one["name"] == "drive")
    drive["settings"] = json.dumps({"max_power": 0.1})
    outcome = check.run(found, lambda _text: None)
    assert outcome.differs("motors/setpoint")
    assert not outcome.same


@pytest.mark.timeout(120)
def test_a_run_that_was_held_up_shows_nothing(home, monkeypatch):
    """What came late is compared with all around it, so it would be as recorded whatever the robot does."""
    monkeypatch.setenv("LBR_HOME", str(home))
    held_up = threading.Event()
    outcome = check.run(recorded(home), lambda _text: held_up.wait(0.9) and None)
    assert outcome.late_s > check.LATE_S
    assert not outcome.same


def test_what_lacks_lines_or_rows_is_refused_in_words(home, tmp_path):
    whole = home / "recordings" / "lbr" / f"{NAME}.mcap"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:200])
    done = lbr(home, "replay", str(cut), "--check")
    assert done.returncode == 2, done.stderr
    assert f"{cut}: nothing in it can be read" in done.stderr
    box = lbr(home, "replay", "box", "--robot", "lbr", "--check")
    assert box.returncode == 2, box.stderr
    assert "lbr record --lines" in box.stderr


def test_a_table_that_is_not_known_here_is_named(home, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(home))
    found = recorded(home)
    found.rows.tables["wing"] = [{"robot": "lbr", "name": "left"}]
    with pytest.raises(InputError, match="'wing'"):
        check.run(found, lambda _text: None)


def test_nothing_tells_of_its_lines_while_no_recorder_hears(home):
    """The black box itself has none of it: only what is recorded on purpose."""
    files = sorted((home / "box" / "lbr").glob("*.mcap"))
    topics = {one.topic for one in selection.messages(files)}
    assert "motors/setpoint" in topics
    assert not [one for one in topics if one.startswith("@taped")]
