"""The black box of a whole robot: it keeps what led to incidents, outlives its own death, and holds up nothing."""

import contextlib
import os
import signal
import threading
import time
from pathlib import Path

import msgspec
import pytest

from lbr.apps.recorder.recording import selection
from lbr.apps.recorder.recording.shelf import Shelf
from tests.support.mover import Mover
from tests.support.robot import lbr, prepare, running
from tests.support.trace import Trace
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start]


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    home = prepare(tmp_path_factory.mktemp("box") / "h", "box")
    with running(home) as found:
        until(lambda: "drive/state" in topics(found), what="streams in the box")
        yield found


def shelf(robot):
    return Shelf(robot.home, "lbr")


def topics(robot, since_ns=0):
    return {one.topic for one in selection.messages(shelf(robot).files()[-1:], since_ns)}


def kept(robot, kind):
    return [one for one in shelf(robot).incidents() if one.why is not None and one.why.kind == kind]


def test_streams_setpoints_events_status_rows_and_lines_are_in_it(robot):
    with (robot.home / "logs" / "lbr-drive.log").open("a") as log:
        log.write("something was printed\n")
    wanted = {"drive/state", "motors/setpoint", "motors/state", "ranges/readings", "@event", "@status", "@rows", "@log"}
    until(lambda: wanted <= topics(robot), what="all of it")

    def printed() -> bool:
        lines = (one for one in selection.messages(shelf(robot).files()) if one.topic == "@log")
        return any(b"something was printed" in one.data for one in lines)

    until(printed, limit_s=10, what="the line")
    found = list(selection.messages(shelf(robot).files()))
    (rows,) = {one.data for one in found if one.topic == "@rows"}
    said = msgspec.json.decode(rows)
    assert said["facts"]["parts"]["drive"]["kind"] == "drive"
    assert "user_token" not in said["tables"]
    state = next(one for one in found if one.topic == "drive/state")
    assert msgspec.json.decode(state.channel.schema)["title"] == "DriveState"
    assert abs(state.log_ns - state.publish_ns) < 5e8


def test_what_is_asked_of_a_box_that_was_held_up_is_answered_once_it_goes_on(robot):
    """A busy machine may keep it waiting for longer than other links may be silent; it is on the bus all the same."""
    pid, held_up = robot.capability("box")["pid"], threading.Event()
    answers = []
    os.kill(pid, signal.SIGSTOP)
    try:
        held_up.wait(1.0)
        asking = threading.Thread(target=lambda: answers.append(robot.ask("box/end", {}, timeout_s=5.0)))
        asking.start()
        asking.join(0.1)
    finally:
        os.kill(pid, signal.SIGCONT)
    asking.join()
    assert answers[0] is not None
    assert "reason" in answers[0]


def test_a_mark_and_an_emergency_stop_are_kept_with_why(robot):
    until(lambda: robot.line("/mark/it limps")["code"] == 0, what="a mark")
    robot.line("estop")
    until(lambda: kept(robot, "mark") and kept(robot, "estop"), what="both kept")
    robot.line("reset")
    mark = kept(robot, "mark")[0]
    assert mark.why.text == "it limps"
    assert mark.files
    done = lbr(robot.home, "box", "show", mark.path.name)
    assert done.returncode == 0, done.stderr
    assert "mark: it limps" in done.stdout.splitlines()
    assert "drive/state" in done.stdout


def test_a_row_that_is_edited_is_in_it_with_its_revision_and_new_streams_are_heard(robot):
    robot.edit("UPDATE capability SET enabled = 1 WHERE robot = 'lbr' AND name = 'battery'")

    def revisions():
        found = selection.messages(shelf(robot).files())
        return {msgspec.json.decode(one.data)["revision"] for one in found if one.topic == "@rows"}

    until(lambda: len(revisions()) == 2 and "battery/state" in topics(robot), what="the new rows and stream")


WRITTEN_S = 5.0
"""The box writes a chunk each second; beside two busy loops a chunk is no older than this."""


def test_a_killed_box_leaves_all_that_is_older_than_some_seconds_and_goes_on(robot):
    from lbr.bus import wire

    feed = wire.Subscription(robot.bus, "lbr/drive/state", depth=1000)
    before = robot.capability("box")["pid"]
    heard = []

    def old():
        heard.extend(feed.take())
        return [one for one in heard if one.arrived < time.monotonic() - WRITTEN_S]

    until(lambda: len(old()) > 10, "some states")
    kept = old()
    os.kill(before, signal.SIGKILL)
    feed.close()
    numbers = [msgspec.json.decode(one.attachment)["seq"] for one in kept]
    written = {one.sequence for one in selection.messages(shelf(robot).files()) if one.topic == "drive/state"}
    missing = [number for number in numbers if number not in written]
    assert len(missing) <= len(numbers) // 50, missing
    files = len(shelf(robot).files())
    until(lambda: robot.capability("box")["pid"] not in {None, before}, what="another box")
    until(lambda: len(shelf(robot).files()) > files and "drive/state" in topics(robot), what="its file")


def test_a_frozen_box_holds_up_no_motion(robot):
    until(lambda: robot.capability("box")["phase"] == "ready", what="the box")
    pid = robot.capability("box")["pid"]
    trace = Trace(robot.trace)
    mover = Mover(robot, 90.0).start()
    try:
        until(lambda: trace.now().least >= 0.39, what="motion")
        os.kill(pid, signal.SIGSTOP)
        try:
            begun = time.monotonic_ns()
            until(lambda: time.monotonic_ns() - begun > 1_200_000_000, what="some time")
            trace.read()
            assert all(output.least >= 0.39 for output in trace.outputs(begun)), "the motors were let go"
        finally:
            with contextlib.suppress(ProcessLookupError):  # it was taken for hung
                os.kill(pid, signal.SIGCONT)
    finally:
        mover.cease()


def test_a_recording_on_purpose_is_a_file_of_its_own(robot):
    until(lambda: robot.line("/mark/again")["code"] == 0, what="the box")
    done = lbr(robot.home, "record", "--seconds", "1.5", "--name", "walk", limit_s=40)
    assert done.returncode == 0, done.stderr
    path = Path(robot.home) / "recordings" / "lbr" / "walk.mcap"
    found = {one.topic for one in selection.messages([path])}
    assert {"drive/state", "@rows", "@status"} <= found
    odd = lbr(robot.home, "record", "--name", "a/b")
    assert (odd.returncode, "'a/b' cannot be" in odd.stderr) == (2, True)
    again = lbr(robot.home, "record", "--seconds", "1", "--name", "walk")
    assert again.returncode == 1
    assert "is there already" in again.stderr
    assert "walk.mcap" in lbr(robot.home, "box", "list").stdout


def test_lines_of_a_process_that_several_share_are_found_by_the_name_of_each(robot):
    with (robot.home / "logs" / "lbr-base.log").open("a") as log:
        log.write("a wheel squeaks\n")
    until(lambda: "base: a wheel squeaks" in lbr(robot.home, "logs", "motors", "--from", "5m").stdout)
    assert lbr(robot.home, "logs", "base", "--from", "5m").stdout.count("a wheel squeaks") == 1
    assert "a wheel squeaks" not in lbr(robot.home, "logs", "ranges", "--from", "5m").stdout


def test_what_it_holds_is_written_and_deleted_by_name(robot):
    out = robot.home / "out"
    done = lbr(robot.home, "box", "export", "walk", "--csv", str(out), "--topic", "drive/*")
    assert done.returncode == 0, done.stderr
    assert (out / "drive_state.csv").read_text().startswith("time,time_s,moving")
    assert lbr(robot.home, "box", "export", "walk", "--mcap", str(out / "walk.mcap")).returncode == 0
    assert lbr(robot.home, "box", "delete", "walk").returncode == 0
    assert lbr(robot.home, "box", "show", "walk").returncode == 2
    files = len(shelf(robot).files())
    unset = lbr(robot.home, "box", "delete", "")
    assert (unset.returncode, "nothing is named" in unset.stderr, len(shelf(robot).files()) >= files) == (2, True, True)
    done = lbr(robot.home, "box", "delete", "box")
    assert done.returncode == 0
    assert len(shelf(robot).files()) == 1, "the one that is being written stays"


def gone(robot) -> bool:
    """Return whether the newest recording is told to have ended with its folder."""
    told = [one["text"] for one in robot.events() if one["kind"] == "recorded"]
    return "(No such file or directory)" in told[-1]


def test_a_recording_whose_folder_cannot_be_or_goes_away_is_refused_or_ended_and_the_box_goes_on(robot):
    recordings, pid = robot.home / "recordings", robot.capability("box")["pid"]
    recordings.rename(robot.home / "aside")
    recordings.touch()
    refused = robot.ask("box/record", {"name": "nowhere"}, timeout_s=5.0)
    recordings.unlink()
    assert refused["code"] == "failed"
    assert "cannot be written (Not a directory)" in refused["reason"]
    assert robot.ask("box/record", {"name": "short"}, timeout_s=5.0)["accepted"]
    recordings.rename(robot.home / "away")
    until(lambda: not robot.ask("box/state")["recording"], what="it is ended")
    (robot.home / "aside").rename(recordings)
    until(lambda: gone(robot), what="the event of it")
    assert (robot.capability("box")["phase"], robot.capability("box")["pid"]) == ("ready", pid)
