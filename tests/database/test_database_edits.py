"""Edits from outside: all or none, only what may be changed, and only from what its author has seen."""

import sqlite3

import pytest
from msgspec.structs import replace

from lbr.database import store
from lbr.errors import InputError, RowError
from lbr.messages.faces import Button, EditCommand, Motor
from lbr.messages.joints import Joint, KeyFrame, Motion, MotionRow, MotionStep

MOTOR = Motor(layer="mine", id=23, name="neck", initial=127, lowest=60, highest=200, rest=127)
NOD = Motion(
    name="nod",
    help="Nods",
    frames=(
        KeyFrame(positions={"head_pitch": 0.2, "neck_yaw": 0.1}, duration_s=0.5),
        KeyFrame(positions={"head_pitch": 0.0}, duration_s=0.7),
    ),
)
BUTTON = Button(id=120, name="nod", button="N", motion="nod")
ALL = EditCommand(motors=(MOTOR,), motions=(NOD,), buttons=(BUTTON,), create=True)


@pytest.fixture
def opened(tmp_path):
    store.create(tmp_path / "robot.db")
    with store.Database.open(tmp_path / "robot.db") as database:
        yield database


def of_rows(rows):
    read = [problem for row in (Motor, Joint, MotionRow, MotionStep, Button) for problem in rows.tables.problems(row)]
    return [str(problem) for problem in (*rows.problems, *read)]


def edit(database, command):
    return database.edit("uxa90", command, of_rows)


def steps(database, name):
    return [(s.step, s.duration_s, s.positions) for s in database.load("uxa90").of(MotionStep) if s.motion == name]


def test_new_rows_are_written_in_one_transaction_and_counted(opened):
    before = opened.revision()
    after = edit(opened, ALL)
    assert after == opened.revision() == before + 5
    rows = opened.load("uxa90")
    assert of_rows(rows) == []
    assert [m.name for m in rows.of(Motor) if m.layer == "mine"] == ["neck"]
    assert steps(opened, "nod") == [(1, 0.5, {"head_pitch": 0.2, "neck_yaw": 0.1}), (2, 0.7, {"head_pitch": 0.0})]
    assert [b.motion for b in rows.of(Button) if b.id == 120] == ["nod"]


def test_a_change_touches_only_what_differs(opened):
    before = edit(opened, ALL)
    shorter = replace(NOD, frames=NOD.frames[:1])
    assert edit(opened, EditCommand(motions=(shorter,), motors=(MOTOR,))) == before + 1
    assert [(row.operation, row.table) for row in opened.revisions(before)] == [("delete", "motion_step")]
    assert len(steps(opened, "nod")) == 1


@pytest.mark.parametrize(
    ("command", "why"),
    [
        (EditCommand(), "this edit has no rows"),
        (EditCommand(motors=(MOTOR,)), "there is no motor 23 of layer 'mine'"),
        (EditCommand(motions=(NOD,)), "there is no motion 'nod'"),
        (EditCommand(buttons=(BUTTON,)), "there is no button 120"),
        (EditCommand(motors=(replace(MOTOR, layer="api"),), create=True), "motor 23 of layer 'api' is there already"),
        (EditCommand(motors=(replace(MOTOR, layer="api"),)), "motor 23 of layer 'api' is built in, and stays as it is"),
        (EditCommand(motions=(replace(NOD, name="sit_down"),)), "motion 'sit_down' is built in, and stays as it is"),
        (EditCommand(buttons=(replace(BUTTON, id=1),)), "button 1 is built in, and stays as it is"),
        (EditCommand(motors=(replace(MOTOR, builtin=True),), create=True), "is built in"),
        (EditCommand(motions=(replace(NOD, slot=40, slot_s=1.0),), create=True), "would be in a slot"),
        (EditCommand(motions=(replace(NOD, limp=True),), create=True), "would be in a slot"),
        (EditCommand(motions=(replace(NOD, frames=()),), create=True), "motion 'nod' has no key frames"),
        (EditCommand(motors=(MOTOR, MOTOR), create=True), "motor 23 of layer 'mine' is there twice"),
        (EditCommand(motors=(MOTOR, replace(MOTOR, layer="api")), create=True), "is there already"),
    ],
)
def test_what_may_not_be_is_refused_in_a_sentence_and_nothing_is_written(opened, command, why):
    before = opened.revision()
    with pytest.raises(InputError, match=why):
        edit(opened, command)
    assert opened.revision() == before


@pytest.mark.parametrize(
    ("command", "why"),
    [
        (replace(ALL, motions=(replace(NOD, frames=(KeyFrame(positions={"tail": 0.1}, duration_s=1.0),)),)), "'tail'"),
        (
            replace(ALL, motions=(replace(NOD, frames=(KeyFrame(positions={"head_pitch": 3}, duration_s=1.0),)),)),
            "limits",
        ),
        (replace(ALL, motors=(replace(MOTOR, lowest=200),)), "is not above lowest"),
        (replace(ALL, buttons=(replace(BUTTON, motion="nowhere"),)), "there is no motion 'nowhere'"),
        (replace(ALL, motions=(replace(NOD, lead_in="nowhere"),)), "no other motion 'nowhere'"),
    ],
)
def test_rows_that_would_not_be_good_are_refused_as_an_edit_by_sqlite_would_be(opened, command, why):
    before = opened.revision()
    with pytest.raises(RowError, match=why):
        edit(opened, command)
    assert opened.revision() == before


def test_who_plans_the_robot_may_refuse_too(opened):
    with pytest.raises(RowError, match="too many"):
        opened.edit("uxa90", ALL, lambda _rows: ["too many"])


def test_an_edit_from_an_older_revision_is_refused_where_its_rows_have_changed_since(opened, tmp_path):
    seen = edit(opened, ALL)
    with sqlite3.connect(tmp_path / "robot.db") as other:
        other.execute("UPDATE motion_step SET duration_s = 2 WHERE motion = 'nod' AND step = 2")
    other.close()
    with pytest.raises(InputError, match=f"motion 'nod' has changed since revision {seen}"):
        edit(opened, EditCommand(motions=(NOD,), revision=seen))
    assert edit(opened, EditCommand(motors=(replace(MOTOR, name="a neck"),), revision=seen)) == seen + 2
    assert edit(opened, EditCommand(motions=(NOD,), revision=seen + 2)) == seen + 3


def test_another_writer_between_check_and_writing_begins_it_anew(opened, tmp_path):
    looked = []

    def wrong(rows):
        looked.append(len(of_rows(rows)))
        if len(looked) == 1:
            with sqlite3.connect(tmp_path / "robot.db") as other:
                other.execute("UPDATE robot SET owner = 'somebody'")
            other.close()
        return of_rows(rows)

    opened.edit("uxa90", ALL, wrong)
    assert len(looked) == 2
    assert steps(opened, "nod")


def test_rows_that_are_bad_already_let_nothing_be_written(opened, tmp_path):
    with sqlite3.connect(tmp_path / "robot.db") as other:
        other.execute("UPDATE motion SET lead_in = 'nowhere' WHERE robot = 'uxa90' AND name = 'reset'")
    other.close()
    with pytest.raises(RowError, match="nowhere"):
        edit(opened, ALL)
