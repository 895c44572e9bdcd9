"""What moves the robot outranks what uses it, as far as this user may say so."""

import os
from pathlib import Path

import pytest

from lbr.executive.processes import scheduling
from tests.support import programs


@pytest.fixture
def sleeper():
    process = programs.start(["/bin/sleep", "60"], start_new_session=True)
    yield process
    process.kill()
    process.wait()


def test_niceness_is_given_to_the_process_and_to_its_session(sleeper):
    scheduling.rank(sleeper.pid, scheduling.BACKGROUND)
    assert os.getpriority(os.PRIO_PROCESS, sleeper.pid) == scheduling.BACKGROUND
    autogroup = Path(f"/proc/{sleeper.pid}/autogroup")
    if autogroup.exists() and autogroup.read_text():
        assert autogroup.read_text().split()[-1] == str(scheduling.BACKGROUND)


def test_what_is_gone_or_not_allowed_is_no_error():
    scheduling.rank(2**22 - 1, scheduling.MOTION)
