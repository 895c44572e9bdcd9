"""The example of a whole robot outside lbr: its own tests, with the package beside lbr as pip would install it."""

import os
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support import robot as robots
from tests.support.packages import of_project
from tests.support.waiting import until

PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "so101"
MOST_LINES = 1200
ALL = {path.name for path in (PACKAGE / "tests").glob("test_*.py")}
WHOLE = sorted(name for name in ALL if name.startswith("test_robot"))
"""Files of tests on whole robots, each by itself; all others are one run."""


@pytest.fixture
def installed(tmp_path):
    """The environment in which its modules are on the path, and its entry points are found."""
    return {**os.environ, "PYTHONPATH": of_project(PACKAGE, tmp_path / "site")}


@pytest.mark.slow_start
@pytest.mark.timeout(400)
@pytest.mark.parametrize("part", [sorted(ALL - {*WHOLE}), *([name] for name in WHOLE)], ids=lambda part: part[-1])
def test_its_own_tests_pass(part, installed, tmp_path):
    argv = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *(f"tests/{name}" for name in part)]
    ended = programs.run(argv, cwd=PACKAGE, env=installed, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout[-6000:] + ended.stderr[-2000:]


def test_driver_and_twin_are_few_lines():
    lines = sum(len(path.read_text().splitlines()) for path in (PACKAGE / "lbr_so101").glob("*.py"))
    assert lines < MOST_LINES


@pytest.mark.slow_start
def test_the_rows_of_its_page_are_an_arm_whose_servos_are_driven_and_fail_in_simulation(
    installed, tmp_path, monkeypatch
):
    monkeypatch.setenv("PYTHONPATH", installed["PYTHONPATH"])
    page = (PACKAGE / "README.md").read_text()
    rows = page.partition("```sql\n")[2].partition("```")[0].split(";\n")
    edits = (*filter(str.strip, rows), robots.only("lbr", "world", "arm"))
    robot = robots.start(robots.prepare(tmp_path / "home", edits=edits))
    try:

        def servos():
            return {servo["id"]: servo for servo in (robot.ask("arm/state") or {}).get("servos", [])}

        until(lambda: robot.capability("arm")["phase"] == "ready", what="the arm's driver")
        until(lambda: [one["voltage_v"] for one in servos().values()] == [12.0] * 6, what="six servos")
        assert all(one["torque"] == 0.0 for one in servos().values())
        reply = robot.ask("world/fault", {"device": "arm_bus", "name": "overload", "value": "3"})
        assert reply["accepted"], reply
        until(lambda: servos()[3]["latched"] == ["overload"], what="the overload of servo 3")
        assert not servos()[2]["latched"]
    finally:
        robot.close()
