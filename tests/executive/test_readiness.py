"""Ready is said when it is so: every capability ready, or its reason in the same line, and none failed."""

import json
import os
import select
import subprocess
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from lbr.executive.processes.readiness import LONGEST_TEXT, readiness
from lbr.messages.system import CapabilityPhase, CapabilityStatus
from tests.support import programs
from tests.support.robot import LBR, environment, prepare, running
from tests.support.waiting import HANG_S, until

BROKEN = """
from lbr.capability import Capability, Kind, NoSettings

class Broken(Capability[NoSettings]):
    def open(self) -> None:
        raise RuntimeError("nothing holds")

    def step(self) -> None:
        pass

KIND = Kind(name="broken", summary="crashes", family="app", entry=Broken)
"""
WITHOUT_MUJOCO = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "mujoco":
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)

sys.meta_path.insert(0, Absent())
"""


def capability(name: str, phase: CapabilityPhase, reason: str = "", host: str = "") -> CapabilityStatus:
    return CapabilityStatus(
        name=name, kind="k", phase=phase, pid=None, restarts=0, uptime_s=None, reason=reason, rates_hz={}, host=host
    )


def test_who_failed_keeps_the_robot_from_being_ready_and_so_does_who_waits_for_it() -> None:
    found = readiness(
        [
            capability("world", "failed", "no MuJoCo"),
            capability("motors", "waiting", "waits for 'world', which is failed"),
        ]
    )
    assert not found.ready
    assert found.words(9.14) == ("not ready after 9.1 s; world: no MuJoCo; motors: waits for 'world', which is failed")


def test_who_is_degraded_or_waits_for_another_machine_is_named_with_the_reason() -> None:
    found = readiness(
        [
            capability("drive", "ready"),
            capability("imu", "degraded", "it is silent"),
            capability("eye", "waiting", "waits for host 'operator'", "operator"),
        ]
    )
    assert found.ready
    assert found.words(2.0) == (
        "all up after 2.0 s; degraded: imu: it is silent; degraded: eye: waiting: waits for host 'operator'"
    )


PHASES = ("waiting", "starting", "ready", "degraded", "stopping", "stopped", "failed")


@given(st.dictionaries(st.sampled_from("abcdef"), st.tuples(st.sampled_from(PHASES), st.text(max_size=3000))))
def test_ready_never_with_a_failed_one_and_nobody_is_left_out(of: dict[str, tuple[CapabilityPhase, str]]) -> None:
    found = readiness(capability(name, phase, reason) for name, (phase, reason) in of.items())
    assert found.ready == all(phase not in {"failed", "waiting"} for phase, _ in of.values())
    assert found.failed.keys() | found.degraded.keys() == {name for name, (phase, _) in of.items() if phase != "ready"}
    assert all(found.failed.values())
    assert all(found.degraded.values())
    assert len(found.words(1.0)) <= LONGEST_TEXT
    assert found.words(1.0).startswith("all up" if found.ready else "not ready")


def test_a_start_with_something_given_up_is_no_ready_line(tmp_path) -> None:
    broken = "INSERT INTO capability (robot, name, kind, restart) VALUES ('lbr', 'broken', 'broken', 'never')"
    home = prepare(tmp_path / "home", edits=(broken,))
    (home / "capabilities").mkdir(mode=0o700)
    (home / "capabilities" / "broken.py").write_text(BROKEN)
    with running(home) as robot:
        first = robot.ready
        assert not first["ready"]
        assert list(first["failed"]) == ["broken"]
        assert "nothing holds" in first["failed"]["broken"]
        assert first["pid"] == robot.popen.pid
        assert not robot.status()["ready"]
        assert not [event for event in robot.events() if event["kind"] == "ready"]
        robot.edit("DELETE FROM capability WHERE name = 'broken'")
        second = line_of(robot.popen)
        assert second["ready"]
        assert not second["failed"]
        assert robot.status()["ready"]
        robot.edit(broken)
        until(lambda: robot.capability("broken")["phase"] == "failed")
        assert not robot.status()["ready"]


def test_a_simulation_without_its_extra_is_refused_in_one_line_before_anything_starts(tmp_path, wording) -> None:
    home = prepare(tmp_path / "home")
    (tmp_path / "absent").mkdir()
    (tmp_path / "absent" / "sitecustomize.py").write_text(WITHOUT_MUJOCO)
    ran = programs.run(
        [*LBR, "run", "lbr-sim", "--no-console"],
        env=environment(home) | {"PYTHONPATH": os.pathsep.join([str(tmp_path / "absent"), str(Path.cwd())])},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=HANG_S,
        check=False,
    )
    assert (ran.returncode, ran.stdout) == (2, "")
    wording(ran.stderr)
    assert not list((home / "logs").glob("*.log"))


def line_of(popen: "subprocess.Popen[str]", limit_s: float = HANG_S) -> dict:
    assert popen.stdout is not None
    readable, _, _ = select.select([popen.stdout], [], [], limit_s)
    assert readable, "no line"
    return json.loads(popen.stdout.readline())
