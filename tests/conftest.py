"""Fixtures that start whole robots; the heavy one is shared by all tests of a module that leave it as it was."""

import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.robot import Robot, prepare, running

os.environ["DBUS_SYSTEM_BUS_ADDRESS"] = "unix:path=/nonexistent"  # no test may power this machine off
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell in the background has it ignored, in children too


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
