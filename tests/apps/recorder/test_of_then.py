"""`lbr at`, `lbr plot` and `lbr logs`: what was, what is over time, and what was written."""

import os
import subprocess
import time
from datetime import datetime

import pytest

from lbr.apps.recorder.commands.plot import MOST_COLUMNS, size, value_of
from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.shelf import Shelf
from tests.support import programs
from tests.support.robot import LBR, environment, lbr, prepare, running
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start]


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    home = prepare(tmp_path_factory.mktemp("then") / "h", "box")
    with running(home) as found:
        place = Shelf(home, "lbr")
        until(lambda: "drive/state" in {one.topic for one in selection.messages(place.files())}, what="streams")
        yield found


def asked(robot, *words, code=0):
    done = lbr(robot.home, *words)
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def said(seconds):
    return datetime.fromtimestamp(seconds).astimezone().isoformat()


def test_why_of_then_is_what_was_answered_then(robot):
    def first(text):
        return text.splitlines()[0]

    before, calm_s = first(asked(robot, "why", "motors")), time.time()
    robot.line("/estop/the dog")
    live = first(until(lambda: text if "the dog" in (text := asked(robot, "why", "drive")) else "", what="why"))
    time_s = time.time()
    until(lambda: time.time() > time_s + 1.5, what="what is in the box")
    assert first(asked(robot, "at", said(time_s), "why", "drive")) == live
    assert first(asked(robot, "at", said(calm_s), "why", "motors")) == before
    robot.line("reset")


def test_a_line_of_the_console_and_what_is_no_text_are_asked_about_as_at_the_console(robot):
    assert asked(robot, "why", "/t/30").startswith("/t/30: ")
    assert "UTF-8" in asked(robot, "why", "\udcff", code=2)


def test_rows_of_then_are_those_before_an_edit(robot):
    before_s = time.time()
    robot.edit("UPDATE capability SET help = 'changed now' WHERE robot = 'lbr' AND name = 'drive'")
    assert "changed now" in asked(
        robot, "at", said(time.time()), "rows", "capability"
    )  # whether or not it was recorded yet
    text = asked(robot, "at", said(before_s), "rows", "capability")
    assert "changed now" not in text
    assert "by the past of" in text
    assert "by the recording box" in asked(robot, "at", said(before_s), "rows", "capability", "--in", "box")
    assert "by the past of" in asked(robot, "at", "1h", "rows", "device")
    assert "there is no table" not in asked(robot, "at", "now", "rows", "nothing", code=2)
    assert "until then" in asked(robot, "at", "3d", "why", code=2)
    assert "lbr-sim" in asked(robot, "at", "now", "status")


def test_numbers_are_plotted_live_and_out_of_the_box(robot):
    text = asked(robot, "plot", "drive/state.power", "drive/state.loop.rate_hz", "--seconds", "1")
    assert "drive/state.loop.rate_hz  " in text
    assert "⠤⠤ drive/state.power" in asked(robot, "plot", "drive/state.power", "--from", "1m")
    assert "'reason' is text" in asked(robot, "plot", "drive/state.reason", "--seconds", "1", code=2)
    assert "no field of a stream" in asked(robot, "plot", "drive", code=2)


def test_of_a_log_without_a_line_it_is_said_that_it_is_empty(robot):
    (robot.home / "logs" / "lbr-mute.log").touch()
    done = lbr(robot.home, "logs", "mute")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "the log 'lbr/mute' is empty\n")


def test_a_log_is_followed_also_after_it_was_cut(robot):
    log = robot.home / "logs" / "lbr-gone.log"
    log.write_text("one\ntwo\nthree\n")
    assert asked(robot, "logs", "gone", "-n", "2").splitlines() == ["two", "three"]
    assert "lbr/gone" in asked(robot, "logs")
    os.mkfifo(robot.home / "logs" / "lbr-pipe.log")
    assert "there is no log 'pipe'" in asked(robot, "logs", "pipe", code=2)
    assert "there is no log 'nix'" in asked(robot, "logs", "nix", code=2)
    popen = programs.start(
        [*LBR, "logs", "gone", "-f", "-n", "1"], env=environment(robot.home), stdout=subprocess.PIPE, text=True
    )
    try:
        assert popen.stdout.readline() == "three\n"
        with log.open("a") as file:
            file.write("four \x1b[2J\n")
        assert popen.stdout.readline() == "four ?[2J\n"
        log.write_text("new\n")
        assert popen.stdout.readline() == "new\n"
    finally:
        popen.kill()
        popen.communicate()


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("a", 1.0),
        ("b.c", 0.5),
        ("d.1", 3.0),
        ("e", 1.0),
        ("f", None),
        ("g", None),
        ("b", None),
        ("d.9", None),
        ("a.b", None),
    ],
)
def test_a_field_is_found_by_its_path(path, value):
    message = {"a": 1, "b": {"c": 0.5}, "d": [2, 3], "e": True, "f": "text", "g": None}
    assert value_of(message, path.split(".")) == value


def test_a_terminal_that_is_said_to_be_without_end_is_drawn_for_in_time(monkeypatch):
    monkeypatch.setenv("COLUMNS", "99999999")
    assert size()[0] == MOST_COLUMNS
