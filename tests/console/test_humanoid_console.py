"""A whole humanoid in a simulated world, as people move it: by lines, and by what becomes of a line whose sender is gone."""

import subprocess
import tempfile
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.robot import LBR, PATIENT_SERVOS, environment, prepare, running
from tests.support.waiting import until

NEEDED = ("servos", "joints", "motions", "world")


@pytest.fixture(scope="module")
def bioloid():
    left_out = f"UPDATE capability SET enabled = 0 WHERE robot = 'bioloid' AND name NOT IN {NEEDED}"
    hung_up = (
        "UPDATE capability SET settings = json_set(settings, '$.stand', json('true')) WHERE kind = 'humanoid_world'"
    )
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        home = prepare(Path(place) / "h", edits=(left_out, hung_up, PATIENT_SERVOS))
        with running(home, profile="bioloid-sim") as robot:
            yield robot


def joints(robot):
    return robot.ask("joints/state")


def torque_on(robot):
    until(lambda: robot.line("/torque/on")["code"] == 0)
    until(lambda: joints(robot)["phase"] == "following")


def send(robot, line, **more):
    return programs.start([*LBR, "send", line], env=environment(robot.home), stdout=subprocess.PIPE, text=True, **more)


def test_torque_comes_first_and_goes_only_when_it_is_meant(bioloid):
    until(lambda: "torque on first" in bioloid.line("/j/left_shoulder_pitch/60")["text"])
    torque_on(bioloid)
    refused = bioloid.line("/torque/off")
    assert (refused["code"], refused["confirm"]) == (1, "/torque/off/all")
    until(lambda: joints(bioloid)["phase"] == "following", what="it has its torque")


def test_a_console_that_is_killed_moves_the_joint_no_further(bioloid):
    torque_on(bioloid)
    with send(bioloid, "/j/left_shoulder_pitch/140/20") as console:
        until(lambda: joints(bioloid)["moving"] or console.poll() is not None)  # one that comes too late lapses
        console.kill()
    state = until(lambda: None if (seen := joints(bioloid))["moving"] or seen["holder"] else seen)
    assert state["goal"] is None
    assert state["reason"]
    assert state["joints"]["left_shoulder_pitch"]["goal_rad"] < 1.5


def test_a_line_is_held_until_the_joint_is_there_and_says_so(bioloid):
    torque_on(bioloid)

    def held() -> str:
        """Say it until no busy machine holds up the console, which then stops what it holds."""
        console = send(bioloid, "/j/right_shoulder_pitch/20/90")
        said = console.communicate()[0]
        return said if console.returncode == 0 else ""

    assert until(held, what="its end").splitlines()[0] == "accepted"
    assert joints(bioloid)["joints"]["right_shoulder_pitch"]["position_rad"] == pytest.approx(0.349, abs=0.1)


def test_completion_knows_the_joints_and_motions_of_the_rows(bioloid):
    entries = {entry["pattern"]: entry for entry in bioloid.line("help")["data"]}
    choices = {pattern: entry["fields"][0]["choices"] for pattern, entry in entries.items() if entry.get("fields")}
    for pattern in ("/j/{joint}/{angle_deg}", "/torque/on/{joints}", "/recover/{joints}"):
        assert len(choices[pattern]) == 18
        assert "left_knee" in choices[pattern]
    for pattern in ("/play/{motion}", "/capture/{motion}"):
        assert "sit" in choices[pattern]
