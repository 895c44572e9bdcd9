"""Edits from outside: all or none, only what may be changed, and only from what its author has seen."""

import pytest
from msgspec import Raw
from msgspec.structs import replace

from lbr.database import edits, store
from lbr.database.reading import Problem
from lbr.errors import InputError, RowError
from lbr.messages.faces import Button, EditCommand, Motor
from lbr.messages.joints import Joint, KeyFrame, Motion, MotionRow, MotionStep
from lbr.messages.rows import Row, by_table
from tests.support import databases

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


def edit_of(motors=(), motions=(), buttons=(), **more):
    return {"rows": (*motors, *(row for motion in motions for row in motion.rows), *buttons), **more}


def new(motors=(MOTOR,), motions=(NOD,), buttons=(BUTTON,)):
    return edit_of(motors=motors, motions=motions, buttons=buttons, create=True)


ALL = new()


@pytest.fixture
def opened(tmp_path):
    databases.fresh(tmp_path / "robot.db")
    with store.Database.open(tmp_path / "robot.db") as database:
        yield database


def of_rows(rows):
    read = [problem for row in (Motor, Joint, MotionRow, MotionStep, Button) for problem in rows.tables.problems(row)]
    return [*rows.problems, *read]


def edit(database, command, judge=of_rows):
    return edits.write_rows(database, "uxa90", judge=judge, **command).good().revision


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
    assert edit(opened, edit_of(motions=(shorter,), motors=(MOTOR,))) == before + 1
    assert [(row.operation, row.table) for row in opened.revisions(before)] == [("delete", "motion_step")]
    assert len(steps(opened, "nod")) == 1


@pytest.mark.parametrize(
    "command",
    [
        edit_of(),
        edit_of(motors=(MOTOR,)),
        edit_of(motions=(NOD,)),
        edit_of(buttons=(BUTTON,)),
        edit_of(motors=(replace(MOTOR, layer="api"),), create=True),
        edit_of(motors=(replace(MOTOR, layer="api"),)),
        edit_of(motions=(replace(NOD, name="sit_down"),)),
        edit_of(buttons=(replace(BUTTON, id=1),)),
        edit_of(motors=(replace(MOTOR, builtin=True),), create=True),
        edit_of(motions=(replace(NOD, slot=40, slot_s=1.0),), create=True),
        edit_of(motions=(replace(NOD, limp=True),), create=True),
        edit_of(motions=(replace(NOD, frames=()),), create=True),
        edit_of(motors=(MOTOR, MOTOR), create=True),
        edit_of(motors=(MOTOR, replace(MOTOR, layer="api")), create=True),
    ],
)
def test_what_may_not_be_is_refused_in_a_sentence_and_nothing_is_written(opened, command, wording):
    before = opened.revision()
    with wording.of(InputError):
        edit(opened, command)
    assert opened.revision() == before


@pytest.mark.parametrize(
    ("command", "why"),
    [
        (new(motions=(replace(NOD, frames=(KeyFrame(positions={"tail": 0.1}, duration_s=1.0),)),)), "'tail'"),
        (
            new(motions=(replace(NOD, frames=(KeyFrame(positions={"head_pitch": 3}, duration_s=1.0),)),)),
            "limits",
        ),
        (new(motors=(replace(MOTOR, lowest=200),)), "is not above lowest"),
        (new(buttons=(replace(BUTTON, motion="nowhere"),)), "there is no motion 'nowhere'"),
        (new(motions=(replace(NOD, lead_in="nowhere"),)), "no other motion 'nowhere'"),
    ],
)
def test_rows_that_would_not_be_good_are_refused_as_an_edit_by_sqlite_would_be(opened, command, why):
    before = opened.revision()
    with pytest.raises(RowError, match=why):
        edit(opened, command)
    assert opened.revision() == before


def test_who_plans_the_robot_may_refuse_too(opened):
    with pytest.raises(RowError, match="too many"):
        edit(opened, ALL, lambda _rows: [Problem("motor", "mine/23", "", "too many")])


def test_an_edit_from_an_older_revision_is_refused_where_its_rows_have_changed_since(opened, tmp_path, wording):
    seen = edit(opened, ALL)
    databases.edit(tmp_path / "robot.db", "UPDATE motion_step SET duration_s = 2 WHERE motion = 'nod' AND step = 2")
    with wording.of(InputError):
        edit(opened, edit_of(motions=(NOD,), revision=seen))
    assert edit(opened, edit_of(motors=(replace(MOTOR, name="a neck"),), revision=seen)) == seen + 2
    assert edit(opened, edit_of(motions=(NOD,), revision=seen + 2)) == seen + 3


def test_another_writer_between_check_and_writing_begins_it_anew(opened, tmp_path):
    looked = []

    def wrong(rows):
        looked.append(len(of_rows(rows)))
        if len(looked) == 1:
            databases.edit(tmp_path / "robot.db", "UPDATE robot SET owner = 'somebody'")
        return of_rows(rows)

    edit(opened, ALL, wrong)
    assert len(looked) == 2
    assert steps(opened, "nod")


def test_an_edit_that_others_come_before_again_and_again_is_refused_as_busy(opened, tmp_path):
    def wrong(rows):
        databases.edit(tmp_path / "robot.db", "UPDATE robot SET owner = owner || '.' WHERE name = 'uxa90'")
        return ()

    with pytest.raises(InputError, match="others edit") as refused:
        edit(opened, ALL, wrong)
    assert refused.value.code == "busy"


def test_rows_that_are_bad_already_let_nothing_be_written(opened, tmp_path):
    databases.edit(
        tmp_path / "robot.db", "UPDATE motion SET lead_in = 'nowhere' WHERE robot = 'uxa90' AND name = 'reset'"
    )
    with pytest.raises(RowError, match="nowhere"):
        edit(opened, ALL)


# -- edits as they come --------------------------------------------------------------------------------------------------

ALLOWED = (Motor, MotionRow, MotionStep, Button)


def asked(*rows, **more):
    return EditCommand(rows=by_table(rows), **more)


def test_rows_come_by_table_and_are_read_with_their_bounds():
    rows = edits.understood(asked(MOTOR, *NOD.rows, BUTTON), ALLOWED)
    assert rows == (MOTOR, *NOD.rows, BUTTON)
    assert edits.names(rows) == "motor 23 of layer 'mine', motion 'nod', button 120"


@pytest.mark.parametrize(
    ("rows", "code"),
    [
        ({"capability": Raw(b"[]")}, "denied"),
        ({"joint": Raw(b"[]")}, "denied"),
        ({"motor\x1b": Raw(b"[]")}, "denied"),
        ({"motor": Raw(b'[{"layer": "mine"}]')}, "malformed"),
        ({"motor": Raw(b"{}")}, "malformed"),
        ({"motor": Raw(b"[1]")}, "malformed"),
    ],
)
def test_what_it_may_not_write_or_what_is_no_row_is_refused_with_a_code(rows, wording, code):
    with wording.of(InputError) as found:
        edits.understood(EditCommand(rows=rows), ALLOWED)
    assert found.value.code == code


def test_rows_that_make_processes_are_never_written_whatever_a_kind_says(wording):
    class Programs(Row, frozen=True, kw_only=True):
        TABLE = "capability"
        KEY = ("name",)
        name: str

    with wording.of(InputError):
        edits.understood(asked(Programs(name="shell")), (Programs,))


def test_parts_come_with_their_whole_so_that_no_key_frame_is_slipped_under_a_built_in_motion(opened, wording):
    before = opened.revision()
    step = MotionStep(motion="sit_down", step=1, duration_s=1.0, positions={"head_pitch": 0.1})
    with pytest.raises(InputError, match="key frame 1 of 'sit_down' is a part of motion 'sit_down', which this edit"):
        edit(opened, {"rows": (step,)})
    with wording.of(InputError):
        edit(opened, {"rows": (MOTOR, step), "create": True})
    assert opened.revision() == before


def test_an_edit_may_hold_new_rows_and_known_ones_and_may_only_be_tried(opened):
    edit(opened, new(motions=(), buttons=()))
    both = edit_of(motors=(replace(MOTOR, lowest=70), replace(MOTOR, id=24)), create=None)
    before = opened.revision()
    assert edit(opened, {**both, "dry_run": True}) == opened.revision() == before
    assert edit(opened, both) == before + 2
    assert {m.id: m.lowest for m in opened.load("uxa90").of(Motor) if m.layer == "mine"} == {23: 70, 24: 60}


def test_of_a_robots_own_row_an_edit_writes_what_people_say_of_it_and_never_its_emergency_stop(opened, wording):
    seen = opened.load("uxa90").robot
    opened.set_estop("uxa90", engaged=True, reason="smoke")
    opened.record_start("uxa90")
    edit(opened, {"rows": (replace(seen, owner="A Person"),), "create": None})
    robot = opened.load("uxa90").robot
    assert (robot.owner, robot.estop_engaged, robot.estop_reason) == ("A Person", True, "smoke")
    assert robot.last_start
    with pytest.raises(InputError, match="there is no robot 'other'"):
        edit(opened, {"rows": (replace(seen, name="other"),), "create": None})
    since = {"rows": (replace(seen, owner="Another"),), "create": None, "revision": 0}
    with wording.of(InputError):
        edit(opened, since)
