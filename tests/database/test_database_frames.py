"""Key frames that were captured become rows, all or nothing."""

import pytest

from lbr.database.connection import pragma
from lbr.database.store import Database
from lbr.errors import LbrError
from lbr.messages.joints import CapturedFrame, KeyFrame

BOW = CapturedFrame(
    motion="bow", frame=KeyFrame(positions={"left_knee": -0.5, "right_knee": -0.25}, duration_s=1.5), help="Bows"
)


def steps(database: Database) -> list[tuple[int, float, dict[str, float]]]:
    found = [row for row in database.load("bioloid").motion_steps if row.motion == "bow"]
    return [(row.step, row.duration_s, dict(row.positions)) for row in found]


def test_the_first_makes_the_motion_and_others_come_after_it(database):
    before = len(database.revisions(0))
    database.append_frame("bioloid", BOW)
    database.append_frame("bioloid", BOW)
    positions = {"left_knee": -0.5, "right_knee": -0.25}
    assert steps(database) == [(1, 1.5, positions), (2, 1.5, positions)]
    (motion,) = [row for row in database.load("bioloid").motions if row.name == "bow"]
    assert (motion.help, motion.lead_in, motion.lead_out) == ("Bows", "", "")
    assert len(database.revisions(0)) == before + 3


def test_it_comes_after_the_last_even_if_steps_were_taken_out(database, client):
    for _ in range(3):
        database.append_frame("bioloid", BOW)
    client.execute("DELETE FROM motion_step WHERE motion = 'bow' AND step = 2")
    database.append_frame("bioloid", BOW)
    assert [step for step, _, _ in steps(database)] == [1, 3, 4]


def test_a_full_disk_leaves_no_half_of_it(database, client):
    pages = client.execute("PRAGMA page_count").fetchone()[0]
    pragma(database._connection, f"max_page_count = {pages}")
    with pytest.raises(LbrError, match="full"):  # noqa: PT012 - how many there is room for is not known
        while True:
            database.append_frame("bioloid", BOW)
    written = len(steps(database))
    assert written > 0
    pragma(database._connection, "max_page_count = 1000000")
    database.append_frame("bioloid", BOW)
    assert len(steps(database)) == written + 1


def test_a_database_that_another_program_locks_is_said_to_be(database, client, monkeypatch):
    monkeypatch.setitem(Database._writing.__wrapped__.__kwdefaults__, "patience_s", 0.01)
    client.execute("BEGIN IMMEDIATE")
    with pytest.raises(LbrError, match="locked by another program"):
        database.append_frame("bioloid", BOW)
    client.execute("ROLLBACK")
    database.append_frame("bioloid", BOW)
    assert len(steps(database)) == 1


def test_a_robot_that_is_not_there_is_refused(database):
    with pytest.raises(LbrError):
        database.append_frame("nobody", BOW)
    assert "bow" not in {row.name for row in database.load("bioloid").motions}
