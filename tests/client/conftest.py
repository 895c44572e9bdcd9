"""A whole robot in simulation for each module, a program that is connected to it, and the distribution's modules."""

import sys
import zipfile
from pathlib import Path

import pytest

from lbr import client
from tests.support import programs
from tests.support import robot as robots

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def running(home, request):
    """A robot of the capabilities that the module names in PARTS, beside those that each has."""
    parts = getattr(request.module, "PARTS", ("attitude", "imu"))
    with robots.running(robots.prepare(home, *parts)) as robot:
        yield robot


@pytest.fixture
def robot(running, home, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(home))
    with client.connect(name="a test") as robot:
        robot.say("reset")
        robot.stop()
        yield robot


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The modules of the distribution, unpacked as pip would."""
    folder = tmp_path_factory.mktemp("wheel")
    build = "from hatchling.build import build_wheel; import sys; print(build_wheel(sys.argv[1]))"
    built = programs.run(
        [sys.executable, "-c", build, str(folder)], cwd=ROOT / "client", capture_output=True, text=True
    )
    assert built.returncode == 0, built.stderr
    with zipfile.ZipFile(folder / built.stdout.split()[-1]) as packed:
        packed.extractall(folder / "site")
    return folder / "site"
