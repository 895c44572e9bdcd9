"""The copy of rows that have run well: what is in its way is told, and an edit of this moment is not in its way."""

import threading
from pathlib import Path

import pytest

from lbr.database import copies
from lbr.database.store import Database
from lbr.executive.planning.last_good_copy import AGAIN_AFTER_S, RUN_WELL_S, LastGoodCopy
from tests.support import databases
from tests.support.waiting import until


@pytest.fixture
def path(tmp_path: Path) -> Path:
    databases.fresh(tmp_path / "robot.db")
    return tmp_path / "robot.db"


def digest(path: Path) -> str:
    with Database.open(path) as database:
        return database.load("lbr").digest


def test_an_edit_that_comes_just_before_the_copy_is_no_trouble_and_is_copied_later(path: Path) -> None:
    told: list[str] = []
    copy, before = LastGoodCopy(path, lambda _what, why: told.append(why)), digest(path)
    databases.edit(path, "UPDATE robot SET owner = 'somebody' WHERE name = 'lbr'")
    copy.touched(0.0)
    copy.step(RUN_WELL_S, before)
    until(lambda: all(one.name != "keeper" for one in threading.enumerate()), what="it has looked")
    copy.step(RUN_WELL_S, before)
    assert (told, copies.stored(path)) == ([], ())
    copy.step(RUN_WELL_S + AGAIN_AFTER_S, digest(path))
    until(lambda: copy.step(0.0, "") or told == [""], what="it is copied")
    assert len(copies.stored(path)) == 1
