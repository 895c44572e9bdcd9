"""A small robot for every test here, and a client of it."""

import pytest

from lbr.bus import session
from tests.console.fake_robot import FakeRobot
from tests.support.trace import Trace


@pytest.fixture
def robot(tmp_path):
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
