import threading

import msgspec
import pytest

from lbr.bus import stamp
from lbr.console.operator import BusOperator, emergency
from lbr.console.stops import is_stop
from lbr.errors import BusError, InputError
from lbr.messages.system import ConsoleResult, Event
from tests.console.fake_robot import ROBOT
from tests.support.waiting import until


@pytest.fixture
def operator(client):
    operator = BusOperator(client, ROBOT, "console@here", role="admin")
    yield operator
    operator.close()


def test_a_line_is_said_with_its_source_and_in_its_role(robot, operator):
    robot.lines["s"] = ConsoleResult(code=0, text="stopped")
    assert operator.submit(" s \n").text == "stopped"
    assert robot.said == [("s", "console@here", "admin")]


def test_a_line_with_control_characters_is_never_sent(robot, operator):
    with pytest.raises(InputError, match="control character"):
        operator.submit("/r/0.2/0\x1b[2J")
    assert robot.said == []


def test_a_new_motion_replaces_the_held_one_without_a_stop(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    robot.moves("/r/0.2/90", "L2")
    operator.submit("/r/0.2/0")
    until(lambda: robot.renewed)
    operator.submit("/r/0.2/90")
    until(lambda: robot.renewed[-1][1]["lease"] == "L2")
    assert operator.held().hold.lease == "L2"
    assert robot.stopped == []


def test_release_stops_what_is_held(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    operator.submit("/r/0.2/0")
    operator.release()
    assert operator.held() is None
    assert len(robot.stopped) == 1


def test_who_says_a_stop_renews_no_more_also_when_the_robot_does_not_take_it(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    robot.blocked["s"] = threading.Event()
    operator.submit("/r/0.2/0")
    until(lambda: robot.renewed)
    said = threading.Thread(target=operator.submit, args=("s",))
    said.start()
    until(lambda: operator.held() is None)
    robot.blocked["s"].set()
    said.join(5)


@pytest.mark.parametrize(
    ("line", "reason"), [("estop", ""), ("ESTOP", ""), ("/estop/it burns", "it burns"), ("/estop", "")]
)
def test_an_emergency_stop_is_told_to_what_moves_before_the_executive_answers(robot, operator, line, reason):
    robot.blocked[line] = threading.Event()
    said = threading.Thread(target=operator.submit, args=(line,))
    said.start()
    (press,) = until(robot.presses.take)
    assert msgspec.json.decode(press.payload) == {"engaged": True, "reason": reason}
    assert stamp.read(press.attachment).source == "console@here"
    robot.blocked[line].set()
    said.join(5)


@pytest.mark.parametrize("line", ["s", "stop", "estopp", "/estops/now", "# estop", "!estop", "", "f"])
def test_no_other_line_is_an_emergency_stop(line):
    assert emergency(line) is None


def test_a_motion_accepted_after_a_later_line_is_stopped_not_held(robot, operator, wording):
    robot.moves("/r/0.2/0", "L1")
    robot.lines["s"] = ConsoleResult(code=0, text="stopped")
    gate = robot.blocked["/r/0.2/0"] = threading.Event()
    late = threading.Thread(target=operator.submit, args=("/r/0.2/0",))
    late.start()
    until(lambda: robot.said)
    operator.submit("s")
    gate.set()
    late.join(5)
    assert operator.held() is None
    wording(*robot.stopped)
    assert robot.renewed == []


def test_the_end_of_a_motion_is_told_unless_a_stop_was_said(robot, operator):
    told = []
    operator.on_end = lambda line, ending: told.append((line, ending.text))
    robot.moves("/r/0.2/0", "L1")
    operator.submit("/r/0.2/0")
    robot.dead["L1"] = "an obstacle"
    until(lambda: told)
    assert told == [("/r/0.2/0", "an obstacle")]


def test_what_the_robot_says_is_kept(robot, operator):
    until(lambda: robot.keep_telling() or operator.telemetry().status)
    heard = until(lambda: robot.keep_telling() or operator.events())
    assert {event.text for event in heard} == {"the battery is low"}


def test_events_that_repeat_the_end_of_an_own_motion_are_left_out(robot, operator):
    until(lambda: robot.keep_telling() or operator.telemetry().status)
    operator.events()
    for source in ("console@here", "web@there"):
        robot.events.put(Event(kind="stopped", subject="drive", text=f"{source}: stopped", about=source))
    robot.events.put(Event(kind="ready", subject="drive", text="ready"))
    heard = []
    until(lambda: heard.extend(operator.events()) or any(event.kind == "ready" for event in heard))
    told = [event.text for event in heard if event.subject == "drive"]
    assert told == ["web@there: stopped", "ready"]


@pytest.mark.parametrize("line", ["s", "/stop", " STOP ", "/estop/"])
def test_a_stop_is_known_with_and_without_slashes(line):
    assert is_stop(line)


def test_words_are_the_data_of_help(robot, operator):
    robot.lines["help"] = ConsoleResult(code=0, text="", data=[{"word": "s"}, "odd"])
    assert operator.words() == [{"word": "s"}]


def test_a_robot_of_another_name_is_a_clear_error(client, wording):
    operator = BusOperator(client, "nobody", "console@here")
    with pytest.raises(BusError, match="robot 'nobody' does not answer; 'lbr status'"):
        operator.submit("f")
    with wording.of(BusError):
        operator.submit("s")
    with wording.of(BusError):
        operator.submit("estop")
    operator.close()
