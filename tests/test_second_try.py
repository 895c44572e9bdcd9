"""What a busy machine fails is tried a second time, aloud; what fails with all its time has failed."""

import os
import sys
from pathlib import Path

from tests.support import programs
from tests.support.second_try import MOST

ROOT = Path(__file__).parent.parent
CONFTEST = """
from tests.conftest import pytest_runtest_makereport, pytest_terminal_summary, left_over
from tests.support import machine
from tests.support.second_try import SecondTry

machine.BUSY_SHARE = {busy}

def pytest_configure(config):
    config.stash[left_over] = []
    config.pluginmanager.register(SecondTry())
"""
TESTS = """
import pytest

made = []

@pytest.fixture(scope="module")
def robot():
    made.append("one")
    return list(made)

def test_a(robot):
    assert robot == ["one"]

def test_b(robot):
    assert len(robot) == 2, "the first robot is worn out"

def test_c(robot):
    assert len(robot) == 2

@pytest.mark.parametrize("n", range({n}))
def test_wrong(n):
    assert n == "wrong"
"""


def tried(place: Path, *, busy: float, wrong: int = 0) -> str:
    (place / "conftest.py").write_text(CONFTEST.format(busy=busy))
    (place / "test_it.py").write_text(TESTS.format(n=wrong))
    options = ("-rA", "-p", "no:xdist", "-p", "no:cacheprovider", "-c", "/dev/null", f"--rootdir={place}")
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = programs.run(
        [sys.executable, "-m", "pytest", *options, place],
        cwd=place, env=environment, capture_output=True, text=True, timeout=9,
    )  # fmt: skip
    return done.stdout + done.stderr


def test_on_a_busy_machine_a_failed_test_has_a_second_try_on_new_fixtures_and_that_is_told(tmp_path):
    said = tried(tmp_path, busy=2.0)
    assert "3 passed" in said, said
    assert "measured more than once" in said
    assert "test_b: FAILED, and was run again" in said
    assert "the first robot is worn out" in said


def test_a_machine_that_gave_all_it_should_gives_no_second_try(tmp_path):
    said = tried(tmp_path, busy=0.0)
    assert "2 failed, 1 passed" in said, said
    assert "run again" not in said


def test_what_fails_again_has_failed_and_only_a_few_have_a_second_try(tmp_path):
    said = tried(tmp_path, busy=2.0, wrong=MOST)
    assert f"{MOST} failed, 3 passed" in said, said
    assert said.count("FAILED, and was run again") == MOST
