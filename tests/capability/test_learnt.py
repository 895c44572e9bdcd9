"""What a capability learns: told in one piece, merged by key, and the same for whoever merges it."""

import os

import msgspec
from msgspec.structs import replace

from lbr.bus import keys
from lbr.capability.base import Capability
from lbr.capability.config import Report
from lbr.capability.kind import Kind, Rows
from lbr.capability.reporter import Reporter
from lbr.messages.joints import Joint, MotionRow, MotionStep
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.rows import RowsChanged, by_table, changed, changes, row_set, with_rows
from lbr.messages.speech import Phrase
from lbr.messages.taped import Taped
from lbr.testing import Stage, alone

NECK = Joint(name="neck", device_id=1, lower_rad=-1.0, upper_rad=1.0, speed_rps=1.0)
BOW = MotionRow(name="bow")


def step(number: int, motion: str = "bow") -> MotionStep:
    return MotionStep(motion=motion, step=number, duration_s=1.0, positions={"neck": 0.5})


def sets(*rows):
    kinds = (Joint, MotionRow, MotionStep)
    return {kind.TABLE: row_set(kind, (row for row in rows if type(row) is kind)) for kind in kinds}


def test_rows_take_the_place_of_those_with_their_key_in_the_order_of_keys():
    faster, jaw = replace(NECK, speed_rps=2.0), replace(NECK, name="jaw", device_id=2)
    after = with_rows(sets(NECK, BOW), by_table([faster, jaw]))
    assert after == sets(jaw, faster, BOW)
    assert after["motion"] is not after["joint"]


def test_a_part_comes_beside_others_and_with_its_whole_in_their_place():
    known = sets(BOW, step(1), step(2), step(1, "nod"))
    assert with_rows(known, by_table([step(3)])) == sets(BOW, step(1), step(2), step(3), step(1, "nod"))
    assert with_rows(known, by_table([BOW, step(1)])) == sets(BOW, step(1), step(1, "nod"))


def test_of_a_row_that_is_known_only_what_changes_is_told_so_that_what_a_person_edits_meanwhile_stays():
    learnt, edited = replace(NECK, speed_rps=2.0), replace(NECK, upper_rad=0.5)
    told = changes(sets(NECK), by_table([learnt]))
    assert msgspec.json.decode(told["joint"]) == [{"name": "neck", "speed_rps": 2.0}]
    assert with_rows(sets(edited), told) == sets(replace(edited, speed_rps=2.0))


def test_rows_that_are_not_known_yet_are_told_whole():
    told = by_table([step(1), Phrase(name="hi", language="en", text="Hi.")])
    assert changes(sets(NECK), told) == told


def test_tables_that_are_not_read_are_left_out():
    assert with_rows(sets(NECK), by_table([Phrase(name="hi", language="en", text="Hi.")])) == sets(NECK)


def test_what_is_learnt_is_one_line_and_too_much_of_it_is_refused(wording):
    reading, writing = os.pipe()
    try:
        reporter = Reporter(writing)
        reporter.learnt(by_table([step(1)]))
        (line,) = os.read(reading, 65536).splitlines()
        rows = msgspec.json.decode(line, type=Report).learnt["motion_step"]
        assert msgspec.json.decode(rows, type=list[MotionStep]) == [step(1)]
        with wording.of(ValueError):
            reporter.learnt(by_table(step(number) for number in range(1, 100)))
    finally:
        os.close(reading)
        os.close(writing)


class Follower(Capability):
    """Says which rows it has after an edit."""

    def command(self, call):
        call.reply(CommandReply(accepted=True, reason=" ".join(one.name for one in self.ctx.rows(MotionRow))))


def test_rows_that_are_edited_while_a_capability_runs_are_its_rows_or_the_edit_is_refused():
    kind = Kind(
        name="follower",
        summary="follows",
        family="app",
        entry=Follower,
        commands={"which": StopCommand},
        rows=(Rows(MotionRow, followed=True), Rows(MotionStep, followed=True)),
    )
    stage = Stage()
    stage.add(alone(kind, rows=(BOW, step(1)), name="follower"), kind)
    edit = changed(sets(BOW, step(1)), sets(MotionRow(name="nod"), MotionRow(name="wave")))
    taped = []
    stage.listen(keys.taped(stage.robot, "follower"), Taped, taped.append)
    assert stage.answer("@edit", "follower", edit).accepted
    assert stage.answer("follower", "which", StopCommand()).reason == "nod wave"
    assert stage.answer("@edit", "follower", RowsChanged(rows={"motion": "[3]"})).code == "malformed"
    assert stage.answer("follower", "which", StopCommand()).reason == "nod wave"
    assert stage.answer("follower", "rows", edit) is None, "whoever may send a command may not edit its rows"
    stage.run(1.0)
    assert [command.name for one in taped for command in one.commands] == ["which", "which"], "rows may have secrets"
