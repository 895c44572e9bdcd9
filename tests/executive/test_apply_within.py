"""`lbr db apply --within` with a running robot: good rows stay, bad ones go back, also when the executive is killed."""

import json
import os
import signal
import subprocess

from tests.support import programs
from tests.support.databases import asked
from tests.support.robot import LBR, environment, lbr, running
from tests.support.waiting import until

KIND = """
import time
from msgspec import Struct
from lbr.capability import Capability, Kind

class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass

class Late(Capability[Settings]):
    def open(self) -> None:
        time.sleep(60.0)

KIND = Kind(name="late", summary="is never ready", family="app", entry=Late, settings=Settings)
"""
LATE = "INSERT INTO capability (robot, name, kind, restart) VALUES ('lbr', 'late', 'late', 'never')"
GOOD = "UPDATE capability SET help = 'Turns.', settings = json_set(settings, '$.max_power', 0.5) WHERE robot = 'lbr' AND name = 'drive'"


def test_good_rows_stay_bad_ones_go_back_and_a_kill_changes_nothing(shared_home):
    home = shared_home
    (home / "capabilities").mkdir(mode=0o700)
    (home / "capabilities" / "late.py").write_text(KIND)
    (home / "good.sql").write_text(GOOD)
    (home / "late.sql").write_text(LATE)
    refused = lbr(home, "db", "apply", str(home / "good.sql"), "--within", "5")
    assert "no robot runs from" in refused.stderr
    with running(home) as robot:
        good = lbr(home, "db", "apply", str(home / "good.sql"), "--within", "9", "--json")
        assert good.returncode == 0, good.stderr
        said = json.loads(good.stdout)
        assert said["trial"]["state"] == "kept"
        assert said["touched"] == [
            {"robot": "lbr", "runs": True, "start": [], "stop": [], "restart": ["drive"], "tell": []}
        ]
        late = lbr(home, "db", "apply", str(home / "late.sql"), "--within", "0.5")
        assert late.returncode == 1
        assert f"went back to revision {said['revision']}: late is " in late.stderr
        until(lambda: robot.capability("late")["phase"] == "absent")
        assert robot.capability("drive")["phase"] == "ready"
        command = programs.start(
            [*LBR, "db", "apply", str(home / "late.sql"), "--within", "60"],
            env=environment(home), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        until(lambda: robot.capability("late")["phase"] == "starting")
        os.kill(robot.ready["pid"], signal.SIGKILL)
        _, said_of_it = command.communicate(timeout=20.0)
        assert command.returncode == 1
        assert "its robot ended" in said_of_it
        assert asked(home / "robot.db", "SELECT count(*) FROM capability WHERE name = 'late'") == [(1,)]
    with running(home) as robot:
        assert robot.capability("late")["phase"] == "absent"
        assert asked(home / "robot.db", "SELECT state FROM trial ORDER BY revision") == [
            ("kept",),
            ("back",),
            ("back",),
        ]
        assert asked(home / "robot.db", "SELECT help FROM capability WHERE robot = 'lbr' AND name = 'drive'") == [
            ("Turns.",)
        ]
