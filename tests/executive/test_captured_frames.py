"""A pose that was captured is played at once, without a restart, and outlives one; if it cannot be kept, that is said."""

import json
import shutil
import tempfile
from pathlib import Path

import pytest

from tests.support import databases
from tests.support.robot import Robot, prepare, running
from tests.support.waiting import until

pytestmark = [pytest.mark.slow_start]

EDITS = (
    "UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN ('joints', 'motions')",
    "UPDATE capability SET kind = 'scripted_joints', settings = '{}' WHERE robot = 'bioloid' AND name = 'joints'",
    "UPDATE joint SET lower_rad = lower_rad - 1, upper_rad = upper_rad + 1",
    """CREATE TRIGGER no_nods BEFORE INSERT ON motion_step WHEN NEW.motion = 'nod'
    BEGIN SELECT RAISE(FAIL, 'there is no room for nods'); END""",
)


@pytest.fixture(scope="module")
def place():
    with tempfile.TemporaryDirectory(prefix="lbr-") as folder:
        home = prepare(Path(folder) / "h", "joints", "motions", edits=EDITS)
        (home / "capabilities").mkdir(mode=0o700)
        shutil.copy(Path(__file__).with_name("scripted_joints.py"), home / "capabilities")
        yield home


def capture(robot: Robot, motion: str) -> str:
    until(lambda: robot.ask("joints/state"), what="joints tell where they are")
    reply = robot.ask("motions/capture", {"motion": motion, "duration_s": 2.0, "help": "Bows"})
    assert reply["accepted"], reply
    return str(reply["reason"])


def play(robot: Robot, motion: str) -> dict[str, object]:
    return robot.ask("motions/play", {"motion": motion, "take_over": True})


def of_motions(robot: Robot, kind: str) -> list[str]:
    return [event["text"] for event in robot.events() if (event["kind"], event["subject"]) == (kind, "motions")]


def rows(home: Path, motion: str) -> list[tuple[int, float, dict[str, float]]]:
    steps = "SELECT step, duration_s, positions FROM motion_step WHERE motion = ? ORDER BY step"
    found = databases.asked(home / "robot.db", steps, motion)
    return [(step, duration_s, json.loads(positions)) for step, duration_s, positions in found]


def test_what_was_captured_is_played_without_a_restart_and_after_one(place):
    with running(place, profile="bioloid-sim") as robot:
        pid = robot.capability("motions")["pid"]
        assert "there is no motion 'bow'" in str(play(robot, "bow")["reason"])
        assert capture(robot, "bow") == "key frame 1 of 'bow' is the pose of now"
        assert capture(robot, "bow") == "key frame 2 of 'bow' is the pose of now"
        assert play(robot, "bow")["accepted"]
        kept = until(lambda: len(rows(place, "bow")) == 2 and rows(place, "bow"))
        assert [(step, duration_s) for step, duration_s, _ in kept] == [(1, 2.0), (2, 2.0)]
        assert set(kept[0][2].values()) == {0.25}
        assert len(kept[0][2]) == 18
        until(lambda: of_motions(robot, "captured"), what="people are told")
        until(lambda: robot.status()["revision"] == databases.newest(place), what="the rows were read again")
        assert robot.capability("motions")["pid"] == pid
        assert robot.ask("motions/stop")["accepted"]
        capture(robot, "nod")
        (lost,) = until(lambda: of_motions(robot, "learnt_lost"))
        assert "the motion 'nod', key frame 1 of 'nod' holds until the next restart only" in lost
        assert "no room for nods" in lost
        assert play(robot, "nod")["accepted"]
    assert rows(place, "nod") == []
    with running(place, profile="bioloid-sim") as robot:
        assert "there is no motion 'nod'" in str(play(robot, "nod")["reason"])
        assert play(robot, "bow")["accepted"]
