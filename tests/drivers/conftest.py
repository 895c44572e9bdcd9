import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.drivers.peers import Board, ScriptedRoboteq
from tests.drivers.servo_peers import Chain, ServoChain


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[ScriptedRoboteq]:
    with ScriptedRoboteq(tmp_path / "ttyRoboteq") as peer:
        yield peer


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    with Board(tmp_path / "ttyRanges") as board:
        yield board


@pytest.fixture
def tty(tmp_path: Path) -> Iterator[Chain]:
    with Chain(tmp_path / "ttyServos") as chain:
        yield chain


@pytest.fixture
def chain() -> ServoChain:
    return ServoChain()


@pytest.fixture
def line() -> Iterator[int]:
    near, far = os.openpty()
    yield far
    os.close(near)
    os.close(far)
