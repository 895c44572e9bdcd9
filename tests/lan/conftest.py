"""Robots whose door is open: one for all tests here that leave it standing, with its tokens as they were."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support import netns
from tests.support.door import Door, opened
from tests.support.robot import PATIENT, prepare


@pytest.fixture(scope="package")
def door() -> Iterator[Door]:
    with (
        tempfile.TemporaryDirectory(prefix="lbr-") as place,
        opened(prepare(Path(place) / "h", edits=PATIENT)) as found,
    ):
        yield found


@pytest.fixture
def own_door(home: Path) -> Iterator[Door]:
    """One whose tokens and rows a test may change."""
    with opened(home) as found:
        yield found


@pytest.fixture(scope="module")
def network() -> Iterator[netns.Network]:
    if why_not := netns.why_not():
        pytest.skip(why_not)
    with netns.network() as found:
        yield found


@pytest.fixture(scope="module")
def far_door(network: netns.Network, shared_home: Path) -> Iterator[Door]:
    """A robot on one machine, and whoever connects on another."""
    with opened(shared_home, network.address, prefix=network.robot, elsewhere=network.client) as found:
        yield found
