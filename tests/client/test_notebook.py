"""The notebook of the examples runs in a kernel of Jupyter's, and a kernel that is killed leaves the robot standing."""

import importlib
import json
import os
import signal
import sys
from pathlib import Path

import pytest

from lbr.client import Picture
from tests.client.wheels import turning, wheels
from tests.support import programs
from tests.support import robot as robots
from tests.support.waiting import until

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "examples" / "drive.ipynb"
PARTS = ("attitude", "imu", "odometry", "camera_front")
"""More than a robot has that all modules share."""
DRIVING = """
import os, time
from pathlib import Path
from lbr import client

Path("pid").write_text(str(os.getpid()))
with client.connect() as robot, robot.drive(0.15, 180, at_most_s=20):
    time.sleep(20)
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def running(home):
    with robots.running(robots.prepare(home, *PARTS, edits=robots.PATIENT)) as robot:
        yield robot


@pytest.fixture
def notebook():
    """Load it with matplotlib here: where only other tests run, a second and a half would be for nothing."""
    return importlib.import_module("lbr.client.notebook")


@pytest.fixture
def execute(home, running):
    """Start what runs a notebook of these cells, in the robot's home; the outputs come into that file."""
    running.say("reset")
    own = {name: str(home / "jupyter") for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "MPLCONFIGDIR")}
    started = []

    def start(notebook_json):
        path = home / "book.ipynb"
        path.write_text(notebook_json)
        command = [sys.executable, "-c", "from nbclient.cli import main; main()", "--inplace", str(path)]
        program = programs.start(command, env=robots.environment(home) | own, cwd=home, stdout=-1, stderr=-1, text=True)
        started.append(program)
        return program, path

    yield start
    for program in started:
        program.kill()
        program.communicate()


def test_the_notebook_runs_and_shows_pictures_and_plots(execute):
    program, path = execute(NOTEBOOK.read_text())
    _, told = program.communicate(timeout=50)
    assert program.returncode == 0, told
    cells = json.loads(path.read_text())["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    assert {"image/jpeg", "image/png"} <= {kind for output in outputs for kind in output.get("data", {})}
    assert "degrees" in str([output.get("text") for output in outputs])


def test_a_killed_kernel_leaves_the_robot_standing(execute, home, running):
    book = json.loads(NOTEBOOK.read_text())
    cell = next(cell for cell in book["cells"] if cell["cell_type"] == "code")
    execute(json.dumps(book | {"cells": [cell | {"source": DRIVING}]}))
    until(lambda: turning(running))
    os.kill(int((home / "pid").read_text()), signal.SIGKILL)
    until(lambda: wheels(running) == (0.0, 0.0))


def test_a_picture_shows_itself_and_a_number_is_plotted(notebook, robot):
    samples = notebook.plot(robot, "motors/state.left", for_s=0.3)
    assert samples["motors/state.left"][0][1] == 0.0
    assert Picture(b"\xff\xd8")._repr_jpeg_() == b"\xff\xd8"


@pytest.mark.parametrize("fields", [(), ("motors/state.reason",)])
def test_what_is_no_number_is_refused_in_words(notebook, robot, fields):
    with pytest.raises(Exception, match=r"drive/state\.power"):
        notebook.plot(robot, *fields, for_s=0.1)
