"""The example of a wheel controller outside lbr: its own tests, with the package beside lbr as pip would install it."""

import os
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.packages import of_project

PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "roboclaw"
MOST_LINES = 600


@pytest.mark.slow_start
@pytest.mark.timeout(240)
@pytest.mark.parametrize("whole_robot", [False, True])
def test_its_own_tests_pass(whole_robot, tmp_path):
    environment = {**os.environ, "PYTHONPATH": of_project(PACKAGE, tmp_path / "site")}
    part = ["tests/test_robot.py"] if whole_robot else ["tests/test_protocol.py", "tests/test_driver.py"]
    argv = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *part]
    ended = programs.run(argv, cwd=PACKAGE, env=environment, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout[-6000:] + ended.stderr[-2000:]


def test_driver_and_twin_are_few_lines():
    assert sum(len(path.read_text().splitlines()) for path in (PACKAGE / "lbr_roboclaw").glob("*.py")) < MOST_LINES
