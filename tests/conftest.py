"""Fixtures that start whole robots; the heavy one is shared by all tests of a module that leave it as it was."""

import signal
import sqlite3
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from lbr.database import store
from tests.robot import Robot, running

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored, in children too


BASE = ("motors", "ranges", "drive", "world")
"""What most tests need of the robot; the rest would only make every start slower."""


def prepare(home: Path, *also: str) -> Path:
    """Make a home with the shipped database, whose world traces its motor outputs; of its rows the base runs, and `also`."""
    home.mkdir(mode=0o700, parents=True, exist_ok=True)
    store.create(home / "robot.db")
    with sqlite3.connect(home / "robot.db") as database:
        trace = str(home / "trace.txt")
        database.execute(
            "UPDATE capability SET settings = json_set(settings, '$.trace', ?) WHERE name = 'world'", (trace,)
        )
        running = (*BASE, *also)
        database.execute(
            f"UPDATE capability SET enabled = 0 WHERE name NOT IN ({', '.join('?' * len(running))})", running
        )
    database.close()
    return home


@pytest.fixture
def home() -> Iterator[Path]:
    """A fresh `$LBR_HOME` with a short path, because sockets' names are bounded."""
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h")


@pytest.fixture(scope="module")
def shared_home() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="lbr-") as place:
        yield prepare(Path(place) / "h")


@pytest.fixture(scope="module")
def robot(shared_home: Path) -> Iterator[Robot]:
    """The simulated lbr robot, running; tests leave it standing and unlatched."""
    with running(shared_home) as started:
        yield started
