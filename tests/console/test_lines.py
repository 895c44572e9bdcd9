import io
import os
import re
import threading
import time

import pytest

from lbr.console.lines import Lines, read, say_once
from lbr.console.local import lines_of
from lbr.console.operator import BusOperator
from lbr.messages.leases import STOPPED_SINCE
from lbr.messages.system import ConsoleResult
from tests.console.fake_robot import ROBOT
from tests.support.waiting import HANG_S, until


@pytest.fixture
def operator(client):
    operator = BusOperator(client, ROBOT, "console@here", listen=False)
    yield operator
    operator.close()


def run(operator, lines, **options) -> tuple[int, str, str]:
    out, err = io.StringIO(), io.StringIO()
    return Lines(operator, out, err, **options).run(lines), out.getvalue(), err.getvalue()


def test_results_go_out_errors_go_to_stderr_and_the_worst_code_counts(robot, operator, wording):
    robot.lines["s"] = ConsoleResult(code=0, text="stopped")
    robot.lines["no"] = ConsoleResult(code=1, text="refused\x1b[2J")
    code, out, err = run(operator, ["s\n", "\n", "bad\n", "no\n", "/s/\udcff\n"])
    assert code == 2
    assert out == "stopped\n"
    wording(err)


def test_empty_lines_and_comments_are_skipped_and_stop_nothing(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    robot.lines["next"] = ConsoleResult(code=0, text="next")

    def lines():
        yield from ["# first a motion\n", "\n", "/r/0.2/0\n", "  # and nothing more\n", " \t\n"]
        until(lambda: len(robot.renewed) > 2)
        yield "next"

    code, out, err = run(operator, lines())
    assert (code, err) == (0, "")
    assert out.splitlines()[:2] == ["moving under L1", "next"]
    assert [line for line, _, _ in robot.said] == ["/r/0.2/0", "next"]


def test_a_bounded_motion_is_waited_for_before_the_next_line(robot, operator):
    robot.moves("/r/0.2/0/40/forward/5", "L1", goal="g1")
    robot.lines["next"] = ConsoleResult(code=0, text="next")

    def lines():
        yield "/r/0.2/0/40/forward/5"
        yield "next"
        until(lambda: len(robot.renewed) > 2)
        assert [said for said, _, _ in robot.said] == ["/r/0.2/0/40/forward/5"]
        robot.finish("g1")

    code, out, _ = run(operator, lines())
    assert code == 0
    assert out.splitlines() == ["moving under L1", "range reached at 40 cm after 1.5 s", "next"]


def test_a_bounded_motion_that_fails_makes_the_exit_code_1(robot, operator):
    robot.moves("/r/0.2/0/40/forward/5", "L1", goal="g1")
    robot.finish("g1", "fault", "the sensor is frozen")
    code, _, err = run(operator, ["/r/0.2/0/40/forward/5"])
    assert code == 1
    assert "the sensor is frozen" in err


def test_an_unbounded_motion_is_held_for_its_time_and_stopped(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    robot.lines["next"] = ConsoleResult(code=0, text="next")
    began = time.monotonic()
    code, out, _ = run(operator, ["/r/0.2/0", "next"], hold_s=0.4)
    took_s = time.monotonic() - began
    assert code == 0
    moving, stopped, after = out.splitlines()
    assert (moving, after) == ("moving under L1", "next")
    held_s = float(re.fullmatch(r"stopped after ([0-9]+\.[0-9]) s", stopped)[1])
    assert 0.4 <= held_s <= round(took_s, 1)
    assert len(robot.stopped) == 1
    assert 1 <= len(robot.renewed) <= 2 + took_s / 0.1


def test_without_a_time_the_end_of_input_stops_it(robot, operator):
    robot.moves("/r/0.2/0", "L1")
    run(operator, ["/r/0.2/0"])
    assert len(robot.stopped) == 1
    assert operator.held() is None


def test_a_stop_does_not_wait_for_the_end_of_a_bounded_motion(robot, operator):
    robot.moves("/r/0.2/0/40/forward/5", "L1", goal="g1")
    robot.lines["stop"] = ConsoleResult(code=0, text="stopped")
    _, out, _ = run(operator, ["/r/0.2/0/40/forward/5", "stop"])
    assert out.splitlines() == ["moving under L1", "stopped"]


def test_a_stop_that_comes_later_waits_for_no_line_before_it(robot, operator, wording):
    robot.moves("/r/0.2/0/40/forward/5", "L1", goal="g1")
    robot.lines["stop"] = ConsoleResult(code=0, text="stopped")

    def lines():
        yield read("/r/0.2/0/40/forward/5", time.monotonic())
        until(lambda: len(robot.renewed) > 2)
        yield read("status", time.monotonic())
        yield read("stop", time.monotonic())

    code, out, err = run(operator, lines())
    assert code == 1
    wording(err)
    assert out.splitlines() == ["moving under L1", "stopped"]


def test_the_lines_of_a_file_and_what_was_written_at_once_are_said_in_their_order(robot, operator, tmp_path):
    robot.moves("/r/0.2/0/40/forward/5", "L1", goal="g1")
    robot.finish("g1")
    robot.lines |= {"next": ConsoleResult(code=0, text="next"), "stop": ConsoleResult(code=0, text="stopped")}
    text = "/r/0.2/0/40/forward/5\nnext\nstop\n"
    (tmp_path / "script").write_text(text)
    reader, writer = os.pipe()
    os.write(writer, text.encode())
    os.close(writer)
    for fd in (os.open(tmp_path / "script", os.O_RDONLY), reader):
        code, out, _ = run(operator, lines_of(fd))
        os.close(fd)
        assert (code, out.splitlines()[-2:]) == (0, ["next", "stopped"])


@pytest.mark.parametrize(
    ("dead", "hold_s", "code", "text"),
    [("", 0.2, 0, r"stopped after [0-9]+\.[0-9] s"), ("an obstacle", HANG_S, 1, "an obstacle")],
)
def test_one_line_is_held_and_then_stopped_unless_it_ends_before(robot, operator, dead, hold_s, code, text):
    robot.moves("/r/0.2/0", "L1")
    robot.dead |= {"L1": dead} if dead else {}
    _, returned, ending = say_once(operator, "/r/0.2/0", hold_s=hold_s, announce=lambda _result: None)
    assert (returned, bool(re.fullmatch(text, ending.text))) == (code, True)
    assert robot.stopped == ([] if dead else ["the 0.2 s are over"])


def test_lines_come_as_they_are_written_and_the_last_needs_no_end():
    reader, writer = os.pipe()
    lines = lines_of(reader)
    os.write(writer, b"a\nb\xff")
    assert next(lines) == "a"
    os.write(writer, b"c")
    os.close(writer)
    assert list(lines) == ["b\udcffc"]
    os.close(reader)


def refuses(robot, line: str) -> None:
    robot.lines[line] = ConsoleResult(code=1, text=f"{STOPPED_SINCE}by phone", reason_code="stopped_since")


def test_after_a_stop_by_another_every_line_of_a_script_is_still_said_and_what_moves_decides(robot, operator):
    refuses(robot, "/r/0.2/0")
    refuses(robot, "/r/0.3/0")
    lines = ["/r/0.2/0", "/report/health", "s", "/r/0.3/0", "mark", "Shutdown"]
    for line in ("/report/health", "s", "mark", "Shutdown"):
        robot.lines[line] = ConsoleResult(code=0, text=line)
    code, _out, err = run(operator, lines)
    assert code == 1
    assert err.splitlines() == [f"{STOPPED_SINCE}by phone"] * 2
    assert [line for line, _, _ in robot.said] == lines


def test_a_line_tells_for_how_long_it_waited(robot, operator):
    gate = robot.blocked["first"] = threading.Event()
    began = time.monotonic()
    heard = []

    def lines():
        yield from ["first", "next"]
        until(lambda: robot.said)
        heard.append(time.monotonic() - began)
        threading.Event().wait(0.2)
        gate.set()

    run(operator, lines())
    assert robot.waited["first"] <= heard[0]
    assert robot.waited["next"] >= 0.2
