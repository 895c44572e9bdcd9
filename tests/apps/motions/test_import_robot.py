"""A motion of another program is taken while a robot runs, and its simulated body moves by it."""

import subprocess

from lbr.robots.bioloid.mtn import Page
from tests.support import programs
from tests.support.old_data import BOW, motion_file
from tests.support.robot import LBR, environment, lbr, only, prepare, running
from tests.support.waiting import HANG_S, until

HIP, LEANT_RAD = "left_hip_pitch", 1.0
HUNG_UP = "UPDATE capability SET settings = json_set(settings, '$.stand', json('true')) WHERE kind = 'humanoid_world'"


def test_a_motion_that_is_taken_over_is_played_by_the_robot_that_runs(tmp_path):
    home = prepare(tmp_path / "home", edits=(only("bioloid", "world", "servos", "joints", "motions"), HUNG_UP))
    (tmp_path / "bow.mtn").write_bytes(motion_file(Page("Bow", BOW)))
    with running(home, profile="bioloid-sim") as robot:
        until(lambda: robot.line("/torque/on")["code"] == 0, what="the servos are known")
        until(lambda: robot.ask("joints/state")["phase"] == "following", what="the joints follow")
        assert "there is no motion 'bow'" in robot.line("/play/bow")["text"]
        before = robot.capability("motions")["pid"]
        done = lbr(home, "import", str(tmp_path / "bow.mtn"))
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("took 5 rows for bioloid from bow.mtn (mtn)")
        until(lambda: robot.capability("motions")["pid"] != before, what="the player takes the new rows")
        until(lambda: robot.capability("motions")["phase"] == "ready", what="the player is there again")
        command = [*LBR, "send", "/play/bow"]
        with programs.start(command, env=environment(home), stdout=subprocess.PIPE, text=True) as playing:
            until(lambda: robot.ask("world/pose")["joints"][HIP] > LEANT_RAD, what="it bows")
            out, _ = playing.communicate(timeout=HANG_S)
        assert playing.returncode == 0, out
