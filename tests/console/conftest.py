"""A small robot for every test here, and a client of it."""

import pytest

from lbr.bus import session
from tests.console.fake_robot import FakeRobot
from tests.support.trace import Trace
from tests.support.waiting import HANG_S

PATIENCE = (
    "ear.FRESH_S",
    "operator.LATE_ANSWER_S",
    "lease_keeper.RESULT_WAIT_S",
    "lease_keeper.SILENCE_S",
    "lease_keeper.STOP_WAIT_S",
)


@pytest.fixture
def patient(monkeypatch):
    """Give a console the patience of a hang; a test that tries a shorter limit sets it. A busy machine holds up tests, too."""
    for name in PATIENCE:
        monkeypatch.setattr(f"lbr.console.{name}", HANG_S)


@pytest.fixture
def robot(tmp_path, patient):
    robot = FakeRobot(f"unixsock-stream/{tmp_path}/r.sock")
    yield robot
    robot.close()


@pytest.fixture
def client(robot):
    with session.open_client([robot.endpoint]) as bus:
        yield bus


@pytest.fixture
def trace(robot):
    """What a real robot does, which stops in the end."""
    yield Trace(robot.trace)
    robot.line("stop")
