"""Behaviours as a capability: what is asked of whom, what ends a run, edits while it runs, and what people read."""

import time
from itertools import islice, product
from pathlib import Path

import pytest
from msgspec.structs import replace

from lbr.apps.behaviours import files
from lbr.apps.behaviours.kind import KIND, BehaviourSettings
from lbr.messages.beacon import SeekCommand
from lbr.messages.behaviour import (
    BehaviourOrder,
    BehaviourRow,
    BehaviourState,
    BehaviourTable,
    CheckBehaviour,
    NamedBehaviour,
    ReadBehaviour,
    RunBehaviour,
    WriteBehaviour,
)
from lbr.messages.drive import DriveCommand, GoalResult, TurnCommand
from lbr.messages.joints import JointsState, PlayCommand
from lbr.messages.leases import CommandReply, StopCommand
from lbr.messages.sensing import Ranges
from lbr.messages.sighting import SightingState, WatchCommand
from lbr.messages.speech import SayCommand
from lbr.testing import FakeCall, FakeContext
from tests.support.replies import drive_state

TABLE = """Type,Current State,Forward,Time,O:level,O:range,O:turn,O:speech,Next State
start,Go,> 90,,0.3,70,,,Turn
,Go,<= 90,,,,,near,Turn
,Turn,,,,,90,,Go on
,Go on,,,0.2,,,,Driving
,Driving,,>= 5,0,,,,Home
end,Home,,,0,,,done,
fail,Stuck,,,0,,,,
"""


def rows(text: str = TABLE, name: str = "patrol") -> tuple[BehaviourTable | BehaviourRow, ...]:
    return BehaviourTable(name=name, help="for a test"), *files.read(text.encode(), name, json=False).rows


class Stage:
    """A capability on a robot that accepts what it is asked; a test says how each goal ends."""

    def __init__(self, *given, wired=None, **settings):
        self.ctx = FakeContext(KIND, BehaviourSettings(**settings), given=given or rows())
        self.ctx.name = "behaviour"
        self.ctx.wired = {
            "play": (),
            "play_halt": (),
            "beacon": (),
            "joints": (),
            "motions": (),
            "power": (),
            **(wired or {}),
        }
        self.goals = 0
        self.ctx.answer = self._answer
        self.metres = 2.0
        self.behaviour = KIND.load()(self.ctx)
        self.behaviour.open()

    def _answer(self, request, message):
        if request in {"move", "turn", "heading", "seek", "play"}:
            if not message.lease:
                self.goals += 1
            bounded = request != "move" or message.range_cm or message.interval_s or message.distance_cm
            goal = f"g{self.goals}" if bounded else ""
            return {"drive": CommandReply(accepted=True, lease=f"l{self.goals}", ttl_s=0.5, goal=goal)}
        return {request: CommandReply(accepted=True)}

    def say(self, name, message=None):
        call = FakeCall(name, message or BehaviourOrder())
        self.behaviour.command(call)
        return call

    def edit(self, *given):
        self.ctx.given = given
        self.behaviour.step()

    def tables(self):
        return {one.name: one for one in self.ctx.said("tables")[-1].tables}

    def run(self, name="patrol"):
        return self.say("run", RunBehaviour(name=name))

    def play(self, seconds):
        until = self.ctx.now + seconds
        while self.ctx.now < until:
            metres = self.metres
            self.ctx.arrive(
                "ranges", Ranges(forward_m=metres, back_m=None, left_m=None, right_m=None, bottom_m=None, status={})
            )
            self.behaviour.step()
            self.ctx.now += 0.05
        return self.state

    def ends(self, result="reached", code="done", reason="there"):
        self.ctx.arrive(
            "results", GoalResult(goal=f"g{self.goals}", result=result, reason=reason, code=code, elapsed_s=1.0)
        )
        self.play(0.5)

    @property
    def state(self) -> BehaviourState:
        return self.ctx.said("state")[-1]

    def asked(self, kind):
        return [one.message for one in self.ctx.asked if isinstance(one.message, kind)]


def test_a_run_borrows_motion_renews_it_and_follows_its_result():
    stage = Stage()
    assert stage.run().answer.reason == "runs patrol from 'Go'"
    stage.play(1.0)
    moves = stage.asked(DriveCommand)
    assert (moves[0].power, moves[0].range_cm, moves[0].lease) == (0.3, 70.0, "")
    assert {move.lease for move in moves[1:]} == {"l1"}
    assert len(moves) >= 8, "renewed ten times a second"
    stage.ends()
    assert stage.asked(TurnCommand)[0].angle_deg == 90.0
    assert stage.state.state == "Turn"
    stage.ends()
    stage.play(1.0)
    assert (stage.state.state, stage.state.doing) == ("Driving", "drive at 0.2 towards 0°")
    stage.play(6.0)
    assert (stage.state.phase, stage.state.good) == ("ended", True)
    assert stage.asked(SayCommand)[-1].text == "done"
    assert stage.asked(StopCommand)
    assert stage.ctx.told("behaviour_ended") == ["patrol ended in 'Home'"]


@pytest.mark.parametrize(("held_up_s", "phase"), [(2.5, "running"), (3.5, "ended")])
def test_a_run_that_was_frozen_with_its_robot_does_not_go_on_by_itself(held_up_s, phase):
    stage = Stage()
    stage.run()
    stage.play(1.0)
    before = len(stage.asked(DriveCommand))
    stage.ctx.now += held_up_s
    assert stage.play(1.0).phase == phase
    assert (len(stage.asked(DriveCommand)) > before) == (phase == "running")
    assert stage.say("run", RunBehaviour(name="patrol")).answer.accepted == (phase == "ended")


SEEKS = """Type,Current State,Result,O:beacon,Next State
start,Looking,,search,Found
,Found,done,follow,Found
,Found,lost,,Lost
end,Home,,,
fail,Lost,,,
"""


def test_a_manoeuvre_of_the_beacon_is_borrowed_and_its_code_decides():
    stage = Stage(*rows(SEEKS.replace("Lost\nend", "Home\nend")))
    stage.run()
    stage.play(0.5)
    seeks = stage.asked(SeekCommand)
    assert [(one.manoeuvre, one.ttl_s) for one in seeks[:1]] == [("search", 0.5)]
    assert {one.lease for one in seeks[1:]} == {"l1"}
    stage.ends()
    assert stage.asked(SeekCommand)[-1].manoeuvre == "follow"
    stage.ctx.arrive("drive", drive_state(stopped_s=stage.ctx.now, stopped_by="seek"))
    stage.ends("fault", "lost", "the beams were lost")
    assert (stage.state.phase, stage.state.state, stage.state.good) == ("ended", "Home", True)


PLAYS = """Type,Current State,Result,O:motion,Next State
start,Playing,,walk,Played
,Played,fallen,get_up,Up
,Up,,,Home
end,Home,,,
fail,Lost,,,
"""


def joints_state(**given) -> JointsState:
    return JointsState(sequence=1, measured_s=0.0, moving=False, phase="holding", joints={}, **given)


@pytest.mark.parametrize(("who", "goes_on"), [("motions", True), ("console", False)])
def test_a_motion_that_ends_by_itself_and_stops_its_joints_is_no_stop_by_another(who, goes_on):
    stage = Stage(*rows(PLAYS), wired={"play": ("motions",), "play_halt": ("motions",), "joints": ("joints",)})
    stage.run()
    stage.play(0.5)
    assert stage.asked(PlayCommand)[-1].motion == "walk"
    stage.ctx.arrive("joints", joints_state(stopped_s=stage.ctx.now, stopped_by=who))
    stage.ends("fault", "fallen", "the robot has fallen")
    assert (stage.asked(PlayCommand)[-1].motion == "get_up", stage.state.phase == "running") == (goes_on, goes_on)


def test_a_stop_stops_the_manoeuvre_too():
    stage = Stage(*rows(SEEKS))
    stage.run()
    stage.play(0.5)
    stage.say("stop", StopCommand())
    assert [one.request for one in stage.ctx.asked if isinstance(one.message, StopCommand)] == ["seek_halt"]


@pytest.mark.parametrize("cell", ["find", "search follow", "1"])
def test_what_is_no_manoeuvre_is_named(cell, wording):
    faults = Stage(*rows(SEEKS.replace("search", cell))).tables()["patrol"].faults
    wording(*(one.text for one in faults))


def test_where_it_is_and_why_it_stays_is_told(wording):
    stage = Stage()
    stage.metres = None
    stage.run()
    state = stage.play(2.0)
    assert (state.phase, state.table, state.state) == ("running", "patrol", "Go")
    assert [row.unmet[0].column for row in state.rows] == ["Forward", "Forward"]
    text = stage.say("why").answer.reason
    wording(text)
    assert "the robot is here" in stage.say("show", NamedBehaviour()).answer.reason
    assert stage.say("list").answer.reason == "▶ patrol  for a test"


def test_a_stop_of_the_whole_robot_says_nothing_where_nothing_runs():
    assert Stage().say("stop", StopCommand(whole=True)).answer == CommandReply(accepted=True)
    assert Stage().say("stop", StopCommand()).answer.reason == "no behaviour runs"


def test_a_stop_ends_the_run_and_halts_what_it_moves():
    stage = Stage()
    stage.run()
    stage.play(1.0)
    assert stage.say("stop", StopCommand(reason="enough")).answer.reason == "patrol is stopped"
    assert stage.state.phase == "ended"
    assert stage.asked(StopCommand)
    before = len(stage.ctx.asked)
    stage.play(3.0)
    assert len(stage.ctx.asked) == before


def test_a_stop_by_another_ends_the_run_also_while_nothing_moves():
    stage = Stage()
    stage.metres = None
    stage.run()
    stage.play(1.0)
    stage.ctx.arrive("drive", drive_state(stopped_s=stage.ctx.now, stopped_by="console"))
    stage.play(0.2)
    assert (stage.state.phase, stage.state.code) == ("ended", "stopped")
    assert stage.state.reason == "stopped by console"


def test_a_stop_from_before_the_run_or_of_its_own_ends_nothing():
    stage = Stage()
    stage.metres = None
    stage.ctx.arrive("drive", drive_state(stopped_s=stage.ctx.now - 5.0, stopped_by="console"))
    stage.run()
    stage.ctx.arrive("drive", drive_state(stopped_s=stage.ctx.now + 0.1, stopped_by="behaviour"))
    assert stage.play(1.0).phase == "running"


def test_the_emergency_stop_ends_the_run_and_lets_none_begin():
    stage = Stage()
    stage.run()
    stage.play(1.0)
    stage.ctx.estop.engaged = True
    stage.play(0.1)
    assert (stage.state.phase, stage.state.code) == ("ended", "estop")
    assert stage.ctx.estop.acknowledged[-1][0] is True
    assert "emergency stop" in stage.run().refused


def test_a_lease_that_is_lost_to_a_person_ends_the_run():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    stage.ends("superseded", "taken_over", "console took over")
    assert (stage.state.phase, stage.state.code, stage.state.good) == ("ended", "taken_over", False)


def test_a_second_run_is_refused_in_words(wording):
    stage = Stage()
    stage.run()
    call = stage.run()
    wording(call.answer)


@pytest.mark.parametrize("name", ["pause", "resume", "step"])
def test_without_a_run_there_is_nothing_to_pause(name):
    assert "no behaviour runs" in Stage().say(name).refused


def test_a_table_that_is_faulty_or_not_there_is_refused_in_words():
    stage = Stage(*rows(TABLE.replace("Forward", "Forwrd")))
    call = stage.run()
    assert (
        "behaviour 'patrol', row 1, Forwrd: there is no 'Forwrd' in the telemetry; did you mean 'Forward'?"
        in call.refused
    )
    assert call.answer.code == "bad_value"
    assert "there is no behaviour 'dance': there is patrol" in stage.run("dance").refused
    assert stage.say("list").answer.reason.startswith("✗ patrol  2 faults, the first: row 1, Forwrd")


def test_what_no_capability_of_the_robot_does_is_refused_before_anything_moves():
    stage = Stage(wired={"turn": ()})
    assert "row 3, O:turn: this robot has no drive that runs" in stage.run().refused
    assert stage.ctx.asked == []


def test_a_pause_stands_still_and_goes_on_with_the_motion():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    assert "is paused in 'Go'" in stage.say("pause").answer.reason
    assert stage.asked(StopCommand)
    before = len(stage.asked(DriveCommand))
    assert stage.play(2.0).phase == "paused"
    assert len(stage.asked(DriveCommand)) == before
    stage.say("resume")
    stage.play(0.5)
    assert stage.asked(DriveCommand)[before].lease == ""
    assert stage.state.phase == "running"


def test_a_robot_without_a_voice_goes_on():
    stage = Stage(wired={"say": ()})
    stage.metres = 0.5
    stage.run()
    stage.play(1.0)
    assert stage.state.state == "Turn"
    assert stage.asked(SayCommand) == []


def test_rows_that_are_edited_while_it_runs_count_from_the_next_state():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    stage.edit(*rows(TABLE.replace(",,,,,90,,Go on", ",,,,,45,,Go on")))
    assert stage.state.phase == "running"
    stage.ends()
    assert stage.asked(TurnCommand)[0].angle_deg == 45.0


def test_an_edit_with_a_fault_keeps_the_run_as_it_was_and_says_so():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    stage.edit(*rows(TABLE.replace(",,,,,90,,Go on", ",,,,,900,,Go on")))
    (told,) = stage.ctx.told("behaviour_refused")
    assert "it goes on as it was: behaviour 'patrol', row 3, O:turn" in told
    stage.ends()
    assert stage.asked(TurnCommand)[0].angle_deg == 90.0


def test_a_table_taken_away_while_it_runs_stops_the_robot_in_words():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    stage.edit()
    stage.play(0.2)
    assert (stage.state.phase, stage.state.code) == ("ended", "changed")
    assert stage.asked(StopCommand)


def test_closing_stops_what_it_moves():
    stage = Stage()
    stage.run()
    stage.play(0.5)
    stage.behaviour.close()
    assert stage.asked(StopCommand)[-1].reason


def test_all_tables_are_told_with_what_is_wrong_in_them_and_again_after_an_edit():
    stage = Stage(*rows(), *rows(TABLE.replace("> 90", "> 90 90"), "worse"))
    told = stage.tables()
    assert told["patrol"].rows == 7
    assert not [fault for fault in told["patrol"].faults if fault.error]
    assert (told["worse"].faults[0].step, told["worse"].faults[0].column) == (1, "Forward")
    stage.edit(*rows(TABLE, "worse"))
    told = stage.tables()
    assert not [fault for fault in told["worse"].faults if fault.error]


def test_rows_are_checked_before_anybody_keeps_them():
    stage = Stage()
    written = [row for row in rows(TABLE.replace("<= 90", "<= ninety")) if isinstance(row, BehaviourRow)]
    (fault, *_) = stage.say("check", CheckBehaviour(name="patrol", rows=tuple(written))).answer.faults
    assert (fault.step, fault.column, fault.error) == (2, "Forward", True)
    assert not [one for one in stage.tables()["patrol"].faults if one.error]
    stage.run()  # the robot's own are as they were


@pytest.mark.parametrize("form", ["csv", "semicolons", "json"])
def test_a_table_is_written_as_a_file_and_read_back_as_it_was(form):
    stage = Stage()
    written = stage.say("write", WriteBehaviour(name="patrol", form=form)).answer
    file = "patrol.json" if form == "json" else "patrol.csv"
    found = stage.say("read", ReadBehaviour(name="patrol", file=file, content=written.content)).answer
    assert found.rows == tuple(row for row in rows() if isinstance(row, BehaviourRow))
    assert not [fault for fault in found.faults if fault.error]


@pytest.mark.parametrize(
    ("file", "content", "line"),
    [
        ("a.csv", b"PK\x03\x04 a spreadsheet", 0),
        ("a.csv", b"Type,Current State,Forward,Next State\nstart,Go,>> 4,Home\nend,Home,,\n", 2),
        ("a.json", b"[1, 2", 0),
        ("a.csv", b"", 0),
    ],
)
def test_a_file_that_is_no_table_is_told_by_its_line(file, content, line):
    found = Stage().say("read", ReadBehaviour(name="round", file=file, content=content)).answer
    assert found.accepted
    (fault, *_) = [one for one in found.faults if one.error]
    assert fault.text
    assert fault.line == line, found.faults


def test_all_cells_of_a_file_are_told_also_beside_one_that_no_table_can_have():
    content = b"Type,Current State,Forward,Next State,Deadline\nstart,Go,> ninety,Home,-1\nend,Home,,,\n"
    found = Stage().say("read", ReadBehaviour(name="round", file="a.csv", content=content)).answer
    assert [(one.line, one.column) for one in found.faults] == [(2, "Deadline"), (2, "Forward")]
    assert found.rows == ()


def test_a_table_that_is_not_there_is_not_written():
    assert Stage().say("write", WriteBehaviour(name="nowhere")).answer.code == "unknown_name"


def test_what_pages_check_costs_little_however_wrong_it_is():
    """Who may only look keeps the robot's mover busy with tables for no longer than a round may take."""
    stage = Stage()
    columns = {"".join(name): "1" for name in islice(product("etaoinsr", repeat=7), 3000)}
    wrong = BehaviourRow(behaviour="patrol", step=1, type="start", state="Go", next_state="Go", conditions=columns)
    alike = [
        BehaviourRow(behaviour="patrol", step=step, state="Go", next_state="Go", conditions={"Time": f"< {step}"})
        for step in range(1, 1000)
    ]
    chosen = {"level": "|".join("1" for _ in range(150))}
    many = [BehaviourRow(behaviour="patrol", step=step, state="Go", next_state="Go", outputs=chosen) for step in (1, 2)]
    began = time.thread_time()
    for asked in ((wrong,), alike, many):
        answer = stage.say("check", CheckBehaviour(name="patrol", rows=tuple(asked))).answer
        assert answer.accepted
        assert answer.faults
        stage.behaviour.step()
    header = ",".join(f"{n:x}" for n in range(9000)).encode()
    assert stage.say("read", ReadBehaviour(name="patrol", file="a.csv", content=header)).answer.faults
    assert time.thread_time() - began < 2.0, "it was 3 s"


def test_tables_are_looked_at_one_a_round_so_that_the_run_goes_on(wording):
    stage = Stage()
    checks = [stage.say("check", CheckBehaviour(name="patrol", rows=())) for _ in range(11)]
    assert [bool(one.answer) for one in checks] == [True, *[False] * 8, True, True]
    wording(*(one.answer for one in checks[9:]))
    for done in range(2, 10):
        stage.behaviour.step()
        assert sum(bool(one.answer) for one in checks[:9]) == done
    stage.behaviour.step()
    assert stage.say("check", CheckBehaviour(name="patrol", rows=())).answer.accepted


@pytest.mark.parametrize("port", ["drive", "joints"])
def test_a_stop_of_anothers_counts_although_a_halt_of_the_tables_own_came_right_behind_it(port):
    stage = Stage(wired={"joints": ("joints",)})
    stage.run()
    stage.play(0.2)
    stopped = {"stopped_s": stage.ctx.now - 0.01, "stopped_by": "console"}
    own = {"stopped_s": stage.ctx.now, "stopped_by": "behaviour"}
    state = {"drive": drive_state, "joints": joints_state}[port]
    for given in (stopped, own):
        stage.ctx.arrive(port, state(**given))
    stage.behaviour.step()
    assert stage.ctx.codes[-1] == "stopped"
    assert stage.behaviour._run is None


@pytest.mark.parametrize("what", ["run", "resume", "step"])
def test_what_was_said_before_a_stop_begins_nothing_however_late_it_comes(what):
    stage = Stage()
    if what != "run":
        stage.run()
        stage.say("pause")
    stage.behaviour.command(FakeCall("stop", StopCommand(), arrived=stage.ctx.now, source="phone"))
    message = RunBehaviour(name="patrol") if what == "run" else BehaviourOrder()
    before = FakeCall(what, message, arrived=stage.ctx.now - 0.01)
    stage.behaviour.command(before)
    assert before.refused
    assert stage.behaviour._run is None


@pytest.mark.parametrize("heard", ["itself", "by the drive"])
def test_what_was_written_before_anothers_stop_begins_no_table(heard):
    """A line that was typed ahead, or a request whose body came slowly, is said after a page has stopped the robot."""
    stage, now = Stage(), 105.0
    stage.ctx.now = now
    if heard == "itself":
        stage.behaviour.command(FakeCall("stop", StopCommand(), arrived=now - 1.0, source="phone"))
    else:
        stage.ctx.arrive("drive", drive_state(halted_s=now - 1.0, halted_by="phone"))

    def run(waited_s, source="console"):
        call = FakeCall("run", RunBehaviour(name="patrol"), arrived=now, source=source, waited_s=waited_s)
        stage.behaviour.command(call)
        return call

    for waited_s in (1.5, float("nan"), float("inf")):
        answer = run(waited_s).answer
        assert (answer.code, "phone" in answer.reason) == ("stopped_since", True)
    assert not run(0.5).refused


def test_an_own_stop_is_no_reason_against_what_was_written_before_it():
    stage = Stage()
    stage.ctx.now = 105.0
    stage.behaviour.command(FakeCall("stop", StopCommand(), arrived=104.0, source="console"))
    call = FakeCall("run", RunBehaviour(name="patrol"), arrived=105.0, waited_s=1.5)
    stage.behaviour.command(call)
    assert not call.refused


FOLLOW = files.read(Path("docs/examples/behaviours/follow.csv").read_bytes(), "follow", json=False).rows
SEEN = SightingState(watching=True, seen=True, bearing_deg=2.0, distance_m=2.0, age_s=0.0, pictures_hz=15.0)


class Following(Stage):
    """The shipped table, with a camera that sees what a test says."""

    def __init__(self, **more):
        empty = rows("Type,Current State,Next State\nstart,Go,Home\nend,Home,\nfail,Stuck,\n", "free_itself")
        super().__init__(BehaviourTable(name="follow"), *FOLLOW, *empty, **more)
        assert self.tables()["follow"].faults == ()
        self.run("follow")

    def look(self, seconds, seen=SEEN):
        for _ in range(round(seconds / 0.1)):
            self.ctx.arrive("sighting", seen)
            self.play(0.1)
        return self.state


def test_a_table_has_the_camera_looked_through_and_goes_by_what_it_sees():
    stage = Following()
    stage.look(0.5)
    assert stage.asked(WatchCommand)[0] == WatchCommand(target="colour")
    assert (stage.asked(DriveCommand)[-1].distance_cm, stage.state.doing[:9]) == (50.0, "drive at ")
    stage.ends()
    stage.look(0.7, replace(SEEN, bearing_deg=-40.0))
    assert stage.asked(TurnCommand)[-1].angle_deg == -30.0
    stage.ends()
    stage.look(1.0, replace(SEEN, distance_m=0.8))
    assert (stage.state.state, stage.state.doing) == ("Near", "")


def test_a_sighting_that_dies_ends_the_motion_and_nothing_old_is_followed():
    stage = Following()
    stage.look(1.0)
    stage.ends()
    stage.look(0.5)
    moves, began = len(stage.asked(DriveCommand)), stage.ctx.now
    stage.ends()
    stage.play(1.2)
    borrowed = [one for one in stage.asked(DriveCommand)[moves:] if not one.lease]
    assert len(borrowed) <= 1, "by what was seen less than a second ago"
    stage.ends()
    before = len(stage.asked(DriveCommand) + stage.asked(TurnCommand))
    assert stage.play(8.0).state == "Blind"
    assert len(stage.asked(DriveCommand) + stage.asked(TurnCommand)) == before
    assert stage.asked(WatchCommand)[-1].seconds == 0.0
    assert stage.ctx.now - began < 12.0


def test_an_eye_that_cannot_look_is_told_and_the_table_ends_as_it_says():
    stage = Following()
    why = CommandReply(accepted=False, reason="it needs OpenCV", code="refused")
    stage.ctx.answer = lambda request, message: {"sighting": why} if request == "watch" else {}
    stage.run("follow")
    stage.play(12.0)
    assert stage.ctx.told("behaviour_blind")[0] == "'sighting' looks for nothing: it needs OpenCV"
    assert (stage.state.state, stage.state.good) == ("Blind", False)


def test_what_nobody_looks_for_is_named_and_a_robot_without_an_eye_goes_on(wording):
    text = "Type,Current State,O:watch,Next State\nstart,Go,colour,Home\nend,Home,off,\nfail,Stuck,,\n"
    faults = Stage(*rows(text.replace("colour", "cats"))).tables()["patrol"].faults
    wording(*(one.text for one in faults))
    stage = Stage(*rows(text), wired={"watch": ()})
    assert [(one.text, one.error) for one in stage.tables()["patrol"].faults] == [
        ("this robot has no sighting that runs", False)
    ] * 2
    stage.run()
    stage.play(1.0)
    assert (stage.state.state, stage.asked(WatchCommand)) == ("Home", [])
