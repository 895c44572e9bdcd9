"""The example of a robot of rows alone: its own tests, with the package beside lbr as pip would install it."""

import os
import sys
from pathlib import Path

import pytest

from tests.support import programs
from tests.support.packages import of_project

PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "rover"


@pytest.mark.slow_start
@pytest.mark.timeout(240)
def test_its_own_tests_pass(tmp_path):
    environment = {**os.environ, "PYTHONPATH": of_project(PACKAGE, tmp_path / "site")}
    argv = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"]
    ended = programs.run(argv, cwd=PACKAGE, env=environment, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout[-6000:] + ended.stderr[-2000:]


def test_it_is_rows_alone():
    modules = sorted((PACKAGE / "lbr_rover").glob("**/*.py"))
    assert [path.name for path in modules] == ["__init__.py", "robot.py"]
    assert not [path for path in modules if "def " in path.read_text()]
