"""A whole robot in simulation for all modules here, a program that is connected to it, and the distribution without lbr."""

import pytest

from lbr import client
from tests.client.wheels import release
from tests.support import lbr_client
from tests.support import robot as robots


@pytest.fixture(scope="package")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="package")
def running(home):
    with robots.running(robots.prepare(home, "attitude", "imu", edits=robots.PATIENT)) as robot:
        yield robot


@pytest.fixture
def robot(running, home, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(home))
    with client.connect(name="a test") as robot:
        release(robot)
        robot.stop()
        yield robot


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The distribution, as a release builds it."""
    return lbr_client.build("wheel", tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="session")
def alone(wheel, tmp_path_factory):
    """An interpreter that has the distribution and no lbr."""
    return lbr_client.alone(tmp_path_factory.mktemp("alone"), wheel)
