import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.drivers.peers import Board, ScriptedRoboteq


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[ScriptedRoboteq]:
    peer = ScriptedRoboteq(tmp_path / "ttyRoboteq")
    yield peer
    peer.finish()


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    board = Board(tmp_path / "ttyRanges")
    yield board
    if board.master >= 0:
        board.unplug()


@pytest.fixture
def line() -> Iterator[int]:
    near, far = os.openpty()
    yield far
    os.close(near)
    os.close(far)
