"""The executive's own words: those that rows may name are those that there are."""

from types import SimpleNamespace

import pytest

from lbr.bus import wire
from lbr.bus.stamp import Origin
from lbr.console.verbs import Vocabulary
from lbr.database.rows import BUILT_IN_VERBS, ExternalCommandRow
from lbr.errors import InputError
from lbr.executive.planning.wiring import EXECUTIVE_ROLES, EXECUTIVE_VERBS
from lbr.executive.service import dispatch
from lbr.executive.service.dispatch import Dispatcher, Sender
from lbr.messages.leases import CommandReply
from lbr.messages.system import ConsoleResult, Role
from tests.support.words import as_shipped


def test_every_word_that_a_row_may_name_exists():
    assert set(Dispatcher(None, None, {})._built_in) == set(EXECUTIVE_VERBS)


def test_a_robot_that_moves_nothing_says_so_when_it_is_stopped(wording):
    plan = SimpleNamespace(robot="lamp", stoppable=tuple)
    words = Vocabulary([])
    dispatcher = Dispatcher(SimpleNamespace(plan=plan, vocabulary=words, record=lambda *_: None), None, {})
    for line in ("s", "S", "stop", "/stop"):
        result = dispatcher.execute(line, Sender("console", "view"))
        assert result.code == 0
        wording(result.text)


ENDS = CommandReply(accepted=False, reason="'drive' ends", code="shutting_down")
DID = CommandReply(accepted=True, reason="stopped by ann")


@pytest.mark.parametrize(
    ("answers", "stop_s", "code"),
    [([None, ENDS, DID], 60.0, "done"), ([None, None], 0.0, "unreachable"), ([ENDS, None], 0.0, "unreachable")],
)
def test_a_stop_asks_what_restarts_until_its_next_process_answers(monkeypatch, answers, stop_s, code):
    left = iter(answers)

    def asked(_bus, movers, *_, **__):
        (key,) = movers
        answer = next(left)
        return [] if answer is None else [SimpleNamespace(key=key, payload=wire.encode(answer))]

    monkeypatch.setattr(wire, "ask_all", asked)
    monkeypatch.setattr(dispatch, "STOP_S", stop_s)
    monkeypatch.setattr(dispatch, "AGAIN_S", 0.0)
    drive = SimpleNamespace(name="drive", pid=7, phase="starting", reason="")
    robot = SimpleNamespace(
        plan=SimpleNamespace(robot="lamp", stoppable=lambda: ("drive",)),
        vocabulary=Vocabulary([]),
        status=lambda: SimpleNamespace(capabilities=(drive,)),
    )
    result = Dispatcher(robot, None, {}).execute("stop", Sender("ann", "view"))
    assert result.reason_code == code
    assert len(list(left)) == (0 if code == "done" else 1)


def test_each_has_a_least_role():
    assert set(EXECUTIVE_ROLES) == set(EXECUTIVE_VERBS)


def test_the_words_of_every_robot_have_the_roles_of_what_they_ask_for():
    assert all(row.role == EXECUTIVE_ROLES[row.target_end[1]] for row in BUILT_IN_VERBS)


def test_what_waits_for_a_machine_that_is_not_there_is_not_said_to_start_anew():
    away = SimpleNamespace(name="motions", host="operator", phase="waiting", reason="waits for host 'operator'")
    robot = SimpleNamespace(
        plan=SimpleNamespace(units={"motions": None}), status=lambda: SimpleNamespace(capabilities=(away,))
    )
    restart = Dispatcher(robot, None, {})._built_in["restart"]
    with pytest.raises(InputError, match="'motions' does not run: waits for host 'operator'"):
        restart(SimpleNamespace(payload={"name": "motions"}), "console")


PROGRAMS: dict[str, Role] = {"dim": "operate", "look": "view"}


def dispatcher_of_programs(started: list[tuple]) -> Dispatcher:
    """A dispatcher whose robot has nothing but a program to start."""
    programs = [ExternalCommandRow(name=name, argv=("true",), role=role) for name, role in PROGRAMS.items()]
    robot = SimpleNamespace(
        plan=SimpleNamespace(robot="lamp", stoppable=tuple, units={}),
        vocabulary=Vocabulary([], programs),
        record=lambda *_: None,
        run_external=lambda *said: started.append(said) or ConsoleResult(code=0, text="begun"),
    )
    return Dispatcher(robot, None, {})


def test_a_program_is_started_after_any_stop_and_told_whose_line_it_was_and_when_that_was_written_and_said():
    """What may not begin any more is decided by who begins it, by source and date."""
    started: list[tuple] = []
    dispatcher = dispatcher_of_programs(started)
    assert dispatcher.execute("s", Sender("bob", "operate", sent_s=3.0)).code == 0
    assert dispatcher.execute("dim", Sender("ann", "operate", sent_s=3.5, waited_s=2.0)).code == 0
    ((call, _who, origin, said_s),) = started
    assert (call.command.name, origin, said_s) == ("dim", Origin("ann", 1.5), 3.5)


@pytest.mark.parametrize(
    ("role", "page", "code"), [("view", True, "role"), ("operate", True, "done"), ("view", False, "done")]
)
def test_rows_are_reported_on_pages_only_to_those_who_may_look_at_rows_there(monkeypatch, role, page, code):
    monkeypatch.setattr("lbr.executive.service.reports.Reports.make", lambda _self, _name: ({}, "rows"))
    report = Dispatcher(None, None, {})._built_in["report"]
    result = report(SimpleNamespace(payload={"name": "rows"}), Sender("phone", role, page=page))
    assert (result.reason_code or "done") == code


def spoken(row, required: int) -> str:
    """A line of a verb's pattern whose fields are all `1`."""
    parts = [part if not part.startswith("{") else "1" for part in row.pattern.strip("/").split("/")]
    return "/".join(("", *parts)) if row.pattern.startswith("/") else " ".join(parts[:required])


@pytest.mark.parametrize("name", ["lbr", "bioloid", "uxa90"])
def test_every_word_of_every_robot_is_refused_to_who_has_a_lower_role_than_it_needs(name):
    rows = as_shipped(name)
    asked: list[str] = []
    robot = SimpleNamespace(
        plan=SimpleNamespace(robot=name, stoppable=tuple, units={}),
        vocabulary=Vocabulary(rows.verbs, rows.external_commands),
        record=lambda *_: None,
        run_external=lambda call, *_: asked.append(call.command.name) or ConsoleResult(code=0, text="begun"),
    )
    dispatcher = Dispatcher(robot, None, {})
    lower: dict[str, tuple[Role, ...]] = {"operate": ("view",), "admin": ("view", "operate")}
    refused = 0
    for row in (*rows.verbs, *BUILT_IN_VERBS):
        line = spoken(row, 9)
        for role in lower.get(row.role, ()):
            result = dispatcher.execute(line, Sender("ann", role))
            if result.code == 2:
                break  # a field that is no number, say: such a line does nothing for anybody
            assert result.reason_code == "role", (line, role, result.text)
            refused += 1
    for program in rows.external_commands:
        for role in lower.get(program.role, ()):
            assert dispatcher.execute(program.name, Sender("ann", role)).reason_code == "role", program.name
            refused += 1
    assert refused > 10, "most words are for those who may do more than look"
    assert asked == []
    for line in ("!print(1)", "!", "restart/drive", "Shutdown"):
        assert dispatcher.execute(line, Sender("ann", "operate")).code != 0, line
