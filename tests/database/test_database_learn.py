"""What was learnt becomes rows, all of it or none: here, key frames that were captured."""

import msgspec
import pytest
from msgspec.structs import replace

from lbr.database import edits
from lbr.database.connection import pragma
from lbr.database.store import Database
from lbr.errors import LbrError
from lbr.messages.joints import MotionRow, MotionStep

BOW = MotionRow(name="bow", help="Bows")


def step(number: int) -> MotionStep:
    return MotionStep(motion="bow", step=number, duration_s=1.5, positions={"left_knee": -0.5, "right_knee": -0.25})


def steps(database: Database) -> list[tuple[int, float, dict[str, float]]]:
    found = [row for row in database.load("bioloid").of(MotionStep) if row.motion == "bow"]
    return [(row.step, row.duration_s, dict(row.positions)) for row in found]


def test_a_new_motion_comes_with_its_first_key_frame_and_others_after_it(database):
    before = len(database.revisions(0))
    edits.learn(database, "bioloid", [BOW, step(1)])
    edits.learn(database, "bioloid", [step(2)])
    positions = {"left_knee": -0.5, "right_knee": -0.25}
    assert steps(database) == [(1, 1.5, positions), (2, 1.5, positions)]
    (motion,) = [row for row in database.load("bioloid").of(MotionRow) if row.name == "bow"]
    assert (motion.help, motion.lead_in, motion.lead_out) == ("Bows", "", "")
    assert len(database.revisions(0)) == before + 3


def test_what_another_wrote_meanwhile_is_not_written_over(database, client):
    edits.learn(database, "bioloid", [BOW, step(1)])
    client.execute(
        "INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES ('bioloid', 'bow', 2, 3, '{}')"
    )
    with pytest.raises(LbrError, match="table motion_step has a row with this robot, motion, step already"):
        edits.learn(database, "bioloid", [step(2)])
    assert [(number, took) for number, took, _ in steps(database)] == [(1, 1.5), (2, 3.0)]


def test_what_was_known_is_changed(database):
    edits.learn(database, "bioloid", [BOW, step(1)])
    before = database.revision()
    known = {("motion_step", ("bow", 1)): msgspec.to_builtins(step(1))}
    edits.learn(database, "bioloid", [replace(step(1), duration_s=2.0)], known)
    assert [took for _, took, _ in steps(database)] == [2.0]
    assert [(row.table, row.operation) for row in database.revisions(before)] == [("motion_step", "update")]


def test_what_another_edited_of_a_known_row_stays_and_what_is_gone_stays_so(database, client):
    edits.learn(database, "bioloid", [BOW, step(1)])
    known = {("motion", ("bow",)): msgspec.to_builtins(BOW), ("motion_step", ("bow", 1)): msgspec.to_builtins(step(1))}
    client.execute("UPDATE motion SET help = 'Bows deeply' WHERE name = 'bow'")
    client.execute("DELETE FROM motion_step WHERE motion = 'bow'")
    edits.learn(database, "bioloid", [replace(BOW, limp=True), replace(step(1), duration_s=2.0)], known)
    (motion,) = [row for row in database.load("bioloid").of(MotionRow) if row.name == "bow"]
    assert (motion.help, motion.limp) == ("Bows deeply", True)
    assert steps(database) == []


def test_a_full_disk_leaves_no_half_of_it(database, client):
    pages = client.execute("PRAGMA page_count").fetchone()[0]
    pragma(database._connection, f"max_page_count = {pages}")
    edits.learn(database, "bioloid", [BOW])
    with pytest.raises(LbrError, match="full"):  # noqa: PT012 - how many there is room for is not known
        for number in range(1, 10_000):
            edits.learn(database, "bioloid", [step(2 * number - 1), step(2 * number)])
    written = len(steps(database))
    assert written > 0
    assert written % 2 == 0
    pragma(database._connection, "max_page_count = 1000000")
    edits.learn(database, "bioloid", [step(written + 1)])
    assert len(steps(database)) == written + 1


def test_a_database_that_another_program_locks_is_said_to_be(database, client, monkeypatch, wording):
    monkeypatch.setitem(Database.writing.__wrapped__.__kwdefaults__, "patience_s", 0.01)
    client.execute("BEGIN IMMEDIATE")
    with wording.of(LbrError):
        edits.learn(database, "bioloid", [BOW, step(1)])
    client.execute("ROLLBACK")
    edits.learn(database, "bioloid", [BOW, step(1)])
    assert len(steps(database)) == 1


def test_a_robot_that_is_not_there_is_refused(database, wording):
    with wording.of(LbrError):
        edits.learn(database, "nobody", [BOW, step(1)])
    assert "bow" not in {row.name for row in database.load("bioloid").of(MotionRow)}
