"""A run of a table, without a robot: which row is taken when, what is ordered, and how it ends."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.behaviours import files
from lbr.apps.behaviours.kernel import DONE, LONGEST_ORDER_S, Outcome, Run
from lbr.apps.behaviours.keys import Key
from lbr.apps.behaviours.outputs import CallTable, Halt, Wait
from lbr.apps.behaviours.table import Table, compile_table
from lbr.messages.behaviour import BehaviourTable
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand, HeadingCommand, TurnCommand
from lbr.messages.speech import SayCommand
from tests.apps.behaviours.test_behaviour_tables import table

TICK_S = 0.05
ENDS = ("Type=end|Current State=Z", "Type=fail|Current State=F")
FAILED = Outcome(False, Reason("obstacle", "a wall is in the way"))


def made(*lines: str, name: str = "t", max_s: float = 600.0) -> Table:
    found = files.read(table(*lines).encode(), name, json=False)
    compiled = compile_table(BehaviourTable(name=name, max_s=max_s), found.rows)
    assert compiled.table is not None, compiled.errors
    return compiled.table


class Stage:
    """A run with values and time of a test's own; each order is done after `takes_s`, as `outcomes` say."""

    def __init__(self, table: Table, *others: Table, dice: int = 0, takes_s: float = 0.1, begin: float = 100.0) -> None:
        self.now = begin
        self.values: dict[str, float | str | None] = {}
        self.ages: dict[str, float] = {}
        self.outcomes: list[Outcome] = []
        self.orders: list[object] = []
        self.states: list[str] = []
        self._takes_s = takes_s
        self._since: tuple[int, float] = (-1, 0.0)
        self.run = Run(table, {one.name: one for one in others}, self.now, lambda count: min(dice, count - 1))

    def look(self, key: Key, newest_s: float) -> float | str | None:
        return self.values.get(key.column) if self.ages.get(key.column, 0.0) <= newest_s else None

    def tick(self) -> None:
        self.run.step(self.now, self.look)
        order = self.run.order
        if self.run.ticket != self._since[0]:
            self._since = self.run.ticket, self.now
            if order is not None:
                self.orders.append(order)
        if (
            order is not None
            and not isinstance(order, Wait)
            and self.now - self._since[1] >= self._takes_s
            and not self.run.paused
        ):
            self.run.ended(self.outcomes.pop(0) if self.outcomes else DONE, self.now)
        if not self.states or self.states[-1] != self.run.state:
            self.states.append(self.run.state)
        self.now += TICK_S

    def play(self, seconds: float) -> "Stage":
        until = self.now + seconds
        while self.now < until and self.run.over is None:
            self.tick()
        return self


def test_the_first_row_whose_conditions_hold_is_taken():
    stage = Stage(
        made(
            "Type=start|Current State=A|Forward=> 90|Next State=B",
            "Current State=A|Forward=< 90|Next State=Z",
            "Current State=B|Next State=Z",
            *ENDS,
        )
    )
    stage.values["Forward"] = 50.0
    assert stage.play(2.0).states == ["A", "Z"]
    assert stage.run.over is not None
    assert stage.run.good


def test_without_a_row_that_holds_it_stays_and_says_why():
    stage = Stage(made("Type=start|Current State=A|Forward=< 40|Next State=Z", *ENDS))
    stage.values["Forward"] = 55.0
    stage.play(5.0)
    assert stage.run.state == "A"
    (row,) = stage.run.why(stage.now, stage.look)
    (unmet,) = row.unmet
    assert (unmet.column, unmet.seen) == ("Forward", 55.0)
    assert unmet.by == pytest.approx(15.0)


def test_a_stale_value_never_matches(wording):
    stage = Stage(made("Type=start|Current State=A|Forward=< 40|Next State=Z", *ENDS))
    stage.values["Forward"], stage.ages["Forward"] = 20.0, 5.0
    assert stage.play(2.0).run.state == "A"
    wording(stage.run.why(stage.now, stage.look)[0].unmet[0].text)
    stage.ages["Forward"] = 0.5
    assert stage.play(1.0).run.good


def test_a_cell_may_take_an_older_value():
    stage = Stage(made("Type=start|Current State=A|Forward=< 40 newer than 10 s|Next State=Z", *ENDS))
    stage.values["Forward"], stage.ages["Forward"] = 20.0, 5.0
    assert stage.play(1.0).run.good


def test_a_motion_is_waited_for_before_the_next_state_is_looked_at():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B|O:level=0.2|O:range=40|O:sensor=Forward",
            "Current State=B|Next State=Z",
            *ENDS,
        ),
        takes_s=3.0,
    )
    stage.play(2.0)
    assert stage.run.state == "A"
    assert stage.orders == [DriveCommand(power=0.2, range_cm=40.0, sensor="forward")]
    assert stage.play(3.0).run.good


def test_a_drive_without_an_end_goes_on_while_the_next_states_last():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B|O:level=0.2",
            "Current State=B|Forward=< 50|Next State=Z|O:level=0",
            *ENDS,
        )
    )
    stage.values["Forward"] = 100.0
    stage.play(3.0)
    assert stage.run.keeps == DriveCommand(power=0.2)
    stage.values["Forward"] = 40.0
    stage.play(2.0)
    assert stage.orders == [DriveCommand(power=0.2), Halt()]
    assert stage.run.keeps is None


def test_a_command_that_fails_leads_to_the_failure_state():
    stage = Stage(made("Type=start|Current State=A|Next State=B|O:turn=90", "Current State=B|Next State=Z", *ENDS))
    stage.outcomes = [FAILED]
    assert stage.play(3.0).states == ["A", "F"]
    assert not stage.run.good
    assert str(stage.run.over) == "turn by 90°: a wall is in the way"


def test_a_state_that_asks_for_the_result_takes_a_failure_in_hand():
    text = "Type,Current State,Result,O:turn,Next State\nstart,A,,90,B\n,B,obstacle,-90,C\n,B,done,,Z\n,C,,,Z\nend,Z,,,\nfail,F,,,\n"
    found = compile_table(BehaviourTable(name="t"), files.read(text.encode(), "t", json=False).rows).table
    stage = Stage(found)
    stage.outcomes = [FAILED]
    stage.play(5.0)
    assert stage.orders == [TurnCommand(angle_deg=90.0), TurnCommand(angle_deg=-90.0)]
    assert stage.run.good


@pytest.mark.parametrize(
    ("outcomes", "said"),
    [
        ([FAILED], "ended in 'G', after turn by 90°: a wall is in the way"),
        ([FAILED, DONE], "ended in 'G'"),
        ([], "ended in 'G'"),
    ],
)
def test_a_failure_that_the_table_goes_to_by_itself_tells_the_command_that_failed_last(outcomes, said):
    text = (
        "Type,Current State,Result,O:turn,Next State\nstart,A,,90,B\n"
        ",B,obstacle,{turn},C\n,B,done,,C\n,C,known,,G\nend,Z,,,\nfail,F,,,\nfail,G,,,\n"
    ).replace("{turn}", "-90" if len(outcomes) > 1 else "")
    found = compile_table(BehaviourTable(name="t"), files.read(text.encode(), "t", json=False).rows).table
    stage = Stage(found)
    stage.outcomes = list(outcomes)
    stage.play(5.0)
    assert (stage.run.good, str(stage.run.over)) == (False, said)


def test_a_command_is_tried_again_as_often_as_its_row_says():
    text = "Type,Current State,O:turn,O:retry,Next State\nstart,A,90,2,Z\nend,Z,,,\nfail,F,,,\n"
    found = compile_table(BehaviourTable(name="t"), files.read(text.encode(), "t", json=False).rows).table
    stage = Stage(found)
    stage.outcomes = [FAILED, FAILED]
    assert stage.play(8.0).run.good
    assert len(stage.orders) == 3
    stage = Stage(found)
    stage.outcomes = [FAILED] * 3
    assert not stage.play(8.0).run.good


@pytest.mark.parametrize("code", ["stopped", "taken_over", "estop", "held", "role"])
def test_a_person_who_wants_the_robot_ends_the_run_whatever_the_table_says(code):
    text = "Type,Current State,Result,O:turn,O:retry,Next State\nstart,A,,90,5,B\n,B,known,,,Z\nend,Z,,,,\nfail,F,,,,\n"
    found = compile_table(BehaviourTable(name="t"), files.read(text.encode(), "t", json=False).rows).table
    stage = Stage(found)
    stage.outcomes = [Outcome(False, Reason(code, "a person wants it"))]
    stage.play(3.0)
    assert stage.run.over == Reason(code, "a person wants it")
    assert len(stage.orders) == 1


def test_a_motion_that_was_kept_up_and_ends_by_itself_is_a_failure():
    stage = Stage(
        made("Type=start|Current State=A|Next State=B|O:level=0.2", "Current State=B|Time=> 60|Next State=Z", *ENDS)
    )
    stage.play(1.0)
    stage.run.lost(FAILED)
    stage.play(1.0)
    assert stage.run.over is not None
    assert stage.run.over.code == "obstacle"


def test_a_deadline_ends_a_state_also_while_it_moves():
    stage = Stage(
        made("Type=start|Current State=A|Next State=B|O:turn=90|Deadline=2", "Current State=B|Next State=Z", *ENDS),
        takes_s=60.0,
    )
    stage.play(1.9)
    assert stage.run.over is None
    stage.play(1.0)
    assert stage.states == ["A", "F"]
    assert stage.run.over is not None
    assert stage.run.over.code == "timeout"


def test_no_motion_takes_for_ever():
    stage = Stage(made("Type=start|Current State=A|Next State=Z|O:turn=90", *ENDS), takes_s=1e9)
    stage.play(LONGEST_ORDER_S + 1.0)
    assert stage.run.over is not None
    assert stage.run.over.code == "timeout"


def test_a_run_has_a_longest_time():
    stage = Stage(made("Type=start|Current State=A|Forward=< 1|Next State=Z", *ENDS, max_s=5.0))
    assert stage.play(10.0).run.over is not None
    assert stage.run.over.code == "time_over"


def test_time_counts_from_the_entry_of_the_state():
    stage = Stage(
        made("Type=start|Current State=A|Time=>= 2|Next State=B", "Current State=B|Time=>= 2|Next State=Z", *ENDS)
    )
    stage.play(3.5)
    assert stage.run.state == "B"
    assert stage.play(1.0).run.good


def test_for_holds_only_without_a_break():
    stage = Stage(made("Type=start|Current State=A|Forward=< 40 for 2 s|Next State=Z", *ENDS))
    stage.values["Forward"] = 30.0
    stage.play(1.5)
    stage.values["Forward"] = 50.0
    stage.play(0.2)
    stage.values["Forward"] = 30.0
    stage.play(1.5)
    assert stage.run.over is None
    assert stage.run.why(stage.now, stage.look)[0].unmet[0].by == pytest.approx(0.5, abs=0.2)
    assert stage.play(1.0).run.good


def test_becomes_holds_in_the_moment_of_the_change_alone():
    stage = Stage(made("Type=start|Current State=A|Forward=becomes < 40|Next State=Z", *ENDS))
    stage.values["Forward"] = 30.0
    stage.play(2.0)
    assert stage.run.over is None
    stage.values["Forward"] = 60.0
    stage.play(0.5)
    stage.values["Forward"] = 30.0
    assert stage.play(0.5).run.good


def test_variables_count_and_are_compared():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B|O:set=laps = 0",
            "Current State=B|$laps=>= 3|Next State=Z",
            "Current State=B|Next State=B|O:set=laps += 1",
            *ENDS,
        )
    )
    assert stage.play(5.0).run.good
    assert stage.run.variables == {"laps": 3.0}


@pytest.mark.parametrize(("dice", "wanted"), [(0, 90.0), (1, -90.0), (2, 180.0)])
def test_one_of_several_is_drawn(dice, wanted):
    stage = Stage(made("Type=start|Current State=A|Next State=Z|O:turn=90 | -90 | 180", *ENDS), dice=dice)
    stage.play(1.0)
    assert stage.orders == [TurnCommand(angle_deg=wanted)]


def test_a_table_runs_another_and_goes_on_by_how_that_ended():
    inner = made(
        "Type=start|Current State=I|Next State=J|O:turn=45",
        "Type=end|Current State=J",
        "Type=fail|Current State=K",
        name="inner",
    )
    stage = Stage(made("Type=start|Current State=A|Next State=Z|O:run=inner", *ENDS), inner)
    stage.play(0.2)
    assert stage.run.called == ("t",)
    assert stage.run.table == "inner"
    assert stage.play(3.0).run.good
    stage = Stage(made("Type=start|Current State=A|Next State=Z|O:run=inner", *ENDS), inner)
    stage.outcomes = [FAILED]
    assert not stage.play(3.0).run.good
    assert stage.states[-1] == "F"
    assert "'inner' failed" in str(stage.run.over)


def test_what_a_table_does_on_entering_a_state_comes_before_its_rows():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B",
            "Type=entry|Current State=B|O:heading=90",
            "Current State=B|Next State=Z|O:turn=10",
            *ENDS,
        )
    )
    assert stage.play(3.0).run.good
    assert stage.orders == [HeadingCommand(heading_deg=90.0), TurnCommand(angle_deg=10.0)]


def test_a_negative_duration_waits_first_and_speech_is_not_waited_for():
    text = "Type,Current State,O:level,O:duration,O:speech,Next State\nstart,A,0,-2,hello,Z\nend,Z,,,,\nfail,F,,,,\n"
    found = compile_table(BehaviourTable(name="t"), files.read(text.encode(), "t", json=False).rows).table
    stage = Stage(found)
    stage.play(5.0)
    assert stage.orders == [Wait(2.0), SayCommand(text="hello"), Halt()]


def test_a_pause_holds_time_and_begins_the_motion_again():
    stage = Stage(
        made("Type=start|Current State=A|Next State=B|O:turn=90", "Current State=B|Time=>= 2|Next State=Z", *ENDS),
        takes_s=1.0,
    )
    stage.play(0.5)
    ticket = stage.run.ticket
    stage.run.pause(stage.now)
    stage.play(30.0)
    assert stage.run.state == "A"
    stage.run.resume(stage.now)
    assert stage.run.ticket != ticket
    stage.play(2.0)
    assert stage.run.state == "B"
    assert stage.play(2.0).run.good


def test_a_step_goes_on_to_the_next_state_alone():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B",
            "Current State=B|Next State=C",
            "Current State=C|Next State=Z",
            *ENDS,
        )
    )
    stage.run.pause(stage.now)
    for state in ("B", "C", "Z"):
        stage.run.resume(stage.now, one_step=True)
        stage.play(2.0)
        assert stage.run.state == state
        assert stage.run.paused


def test_an_edited_row_counts_from_the_next_entry_of_its_state():
    before = made(
        "Type=start|Current State=A|Time=>= 1|Next State=B",
        "Current State=B|Forward=< 1|Next State=Z",
        "Current State=B|Time=>= 1|Next State=A",
        *ENDS,
    )
    after = made("Type=start|Current State=A|Time=>= 1|Next State=Z", *ENDS)
    stage = Stage(before)
    stage.play(0.5)
    stage.run.replace({"t": after})
    stage.play(0.3)
    assert stage.run.state == "A"
    stage.play(0.5)
    assert stage.run.over is not None, "the state that the old row leads to is gone"
    assert stage.run.over.code == "changed"
    stage = Stage(before)
    stage.play(0.5)
    stage.run.replace(
        {"t": made("Type=start|Current State=A|Time=>= 1|Next State=B", "Current State=B|Next State=Z", *ENDS)}
    )
    assert stage.play(2.0).run.good


def test_a_table_taken_away_ends_the_run_in_words(wording):
    stage = Stage(made("Type=start|Current State=A|Forward=< 1|Next State=Z", *ENDS))
    stage.play(0.5)
    stage.run.replace({})
    wording(stage.run.over)
    assert stage.run.order is None
    assert stage.run.keeps is None


def test_a_number_beyond_its_bounds_at_run_time_is_a_failure_in_words():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B|O:set=fast = 3",
            "Current State=B|Next State=Z|O:level=$fast",
            *ENDS,
        )
    )
    stage.play(2.0)
    assert stage.run.over is not None
    assert "O:level" in str(stage.run.over)


OLD = {
    "Way Point 1": [
        ({"heading": 95.0, "Forward": 230.0}, "Facing Dock"),
        ({"heading": 84.0, "Forward": 230.0}, "Initial Orientation"),
        ({"heading": 101.0, "Forward": 230.0}, "Initial Orientation"),
        ({"heading": 95.0, "Forward": 255.0}, "Dock Failed"),
    ],
    "Facing Dock": [
        ({"Forward": 40.0}, "Approaching"),
        ({"Forward": 38.0}, "Facing Dock"),
        ({"Forward": 42.0}, "Facing Dock"),
    ],
    "Approaching": [
        ({"heading": 336.0, "Forward": 215.0, "Right": 30.0}, "Dock Orientation"),
        ({"heading": 329.0, "Forward": 200.0, "Right": 30.0}, "Approaching"),
        ({"heading": 346.0, "Forward": 200.0, "Right": 30.0}, "Approaching"),
        ({"heading": 336.0, "Forward": 216.0, "Right": 30.0}, "Dock Failed"),
    ],
    "Signal Lock": [
        ({"heading": 175.0, "Dock Left": 1.0, "Dock Right": 1.0}, "Contact"),
        ({"heading": 168.0, "Dock Left": 1.0, "Dock Right": 1.0}, "Signal Lock"),
    ],
    "Contact": [
        ({"Rear": 15.0, "Amps Left": 0.0, "Amps Right": 0.0, "Volts": 12.9}, "Verifying"),
        ({"Rear": 25.0, "Amps Left": 0.0, "Amps Right": 0.0, "Volts": 12.9}, "Signal Lock"),
        ({"Rear": 15.0, "Amps Left": -5.2, "Amps Right": -5.3, "Volts": 12.0}, "Verifying"),
    ],
    "Verifying": [({"Rear": 15.0, "Volts": 12.8}, "Dock Verified"), ({"Rear": 15.0, "Volts": 12.7}, "Verifying")],
}
"""Of the first lbr's table: telemetry, and where it led."""


@pytest.mark.parametrize(("state", "values", "wanted"), [(state, *one) for state, some in OLD.items() for one in some])
def test_the_first_lbrs_dock_table_goes_where_it_always_went(state, values, wanted):
    content = Path("docs/examples/behaviours/autodock.csv").read_bytes()
    found = compile_table(BehaviourTable(name="autodock"), files.read(content, "autodock", json=False).rows).table
    assert found is not None
    stage = Stage(found._replace(start=state))
    stage.values = dict(values)
    while not stage.run.transitions and stage.run.over is None:
        stage.tick()
    assert stage.run.state == wanted


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["step", "done", "fail", "stop", "lost", "pause", "resume", "one", "replace"]),
            st.floats(0.0, 3.0),
            st.floats(0.0, 200.0),
        ),
        max_size=40,
    )
)
def test_whatever_happens_a_run_that_is_over_orders_nothing(events):
    one = made(
        "Type=start|Current State=A|Forward=> 90|Next State=B|O:level=0.2",
        "Current State=A|Forward=< 50 for 1 s|Next State=A|O:turn=90|Deadline=5",
        "Current State=A|Next State=B|O:run=inner",
        "Current State=B|Forward=becomes < 100|Next State=A|O:set=n = 1|O:wait=1",
        "Current State=B|Forward=> 150|Next State=Z",
        *ENDS,
    )
    inner = made(
        "Type=start|Current State=I|Next State=J|O:turn=45",
        "Type=end|Current State=J",
        "Type=fail|Current State=K",
        name="inner",
    )
    run, now = Run(one, {"inner": inner}, 100.0, lambda count: count - 1), 100.0
    happen = {
        "step": lambda value: run.step(now, lambda _key, _newest: value),
        "done": lambda _value: run.ended(DONE, now),
        "fail": lambda _value: run.ended(FAILED, now),
        "stop": lambda _value: run.stop(Reason("stopped", "stopped")),
        "lost": lambda _value: run.lost(FAILED),
        "pause": lambda _value: run.pause(now),
        "resume": lambda _value: run.resume(now),
        "one": lambda _value: run.resume(now, one_step=True),
        "replace": lambda value: run.replace({"t": one, "inner": inner} if value > 20.0 else {"t": one}),
    }
    for what, after, value in events:
        now += after
        happen[what](value)
        assert run.state
        run.why(now, lambda _key, _newest: None)
        if run.over is not None:
            assert run.order is None
            assert run.keeps is None
        assert not isinstance(run.order, CallTable), "a table that is run is no order"


def test_a_number_that_grows_beyond_all_ends_the_table_and_not_the_end_of_a_motion():
    """It would be left out of the next command, and what was to end after it would go on."""
    stage = Stage(
        made(
            "Type=start|Current State=A|O:set=x = 1e308|Next State=B",
            "Current State=B|O:set=x += 1.7e308|Next State=C",
            "Current State=C|O:level=0.3|O:range=$x|Next State=Z",
            *ENDS,
        )
    ).play(5.0)
    assert stage.run.state == "F"
    assert [one for one in stage.orders if isinstance(one, DriveCommand)] == []
    assert stage.run.over is not None
    assert stage.run.over.code == "bad_value"


def test_a_state_that_fails_as_it_is_entered_leaves_nothing_else_to_its_failure():
    stage = Stage(
        made(
            "Type=start|Current State=A|Next State=B",
            "Type=entry|Current State=B|O:wait=$x",
            "Type=entry|Current State=B|O:turn=90",
            "Current State=B|Time=> 5|O:set=x = 1|Next State=Z",
            *ENDS,
        )
    ).play(5.0)
    assert stage.run.state == "F"
    assert stage.orders == []


def test_what_a_row_of_a_failed_table_would_have_done_next_is_not_done():
    inner = made(
        "Type=start|Current State=A|O:set=x += 1|O:turn=90|Next State=Z", "Type=end|Current State=Z", name="inner"
    )
    outer = made("Type=start|Current State=A|O:set=x = low|O:run=inner|Next State=Z", *ENDS)
    stage = Stage(outer, inner).play(5.0)
    assert stage.run.state == "F"
    assert [one for one in stage.orders if isinstance(one, TurnCommand)] == []
