from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.robots.uxa90.uxa90_peers import Board


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    with Board(tmp_path / "ttyBoard") as board:
        yield board
