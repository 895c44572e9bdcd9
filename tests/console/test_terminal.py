"""The terminal on a real pty, in a thread as the robot's own console has it."""

import contextlib
import os
import pty
import re
import shutil
import termios
import threading
from pathlib import Path

import pytest
from prompt_toolkit.input.vt100 import Vt100Input

from lbr.console.keyboard import QUIET_S
from lbr.console.operator import BusOperator
from lbr.console.prompt_output import Screen as TerminalScreen
from lbr.console.terminal import Terminal, describe
from lbr.messages.leases import STOPPED_SINCE
from lbr.messages.system import ConsoleResult, Event
from tests.console.fake_robot import ROBOT
from tests.console.vt import Vt
from tests.support.waiting import HANG_S, until

PASTE = "\x1b[200~{}\x1b[201~"
STEPS = re.compile(r"\x1b\[([0-9]*)C")
MENU_ROWS = 6
CODES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Screen:
    """What a person does and sees at the other end of the pty."""

    def __init__(self, operator: BusOperator, rows: int = 30, columns: int = 120, history: Path | None = None) -> None:
        self.master, slave = pty.openpty()
        self.size = rows, columns
        termios.tcsetwinsize(slave, self.size)
        self._keys = os.fdopen(os.dup(slave), "r", encoding="utf-8")
        self._text = os.fdopen(slave, "w", encoding="utf-8")
        source = Vt100Input(self._keys)
        output = TerminalScreen.on(self._text, term="xterm-256color")
        self.terminal = Terminal(operator, source=source, screen=output, history=history)
        self.code: int | None = None
        self._seen = b""
        self.answers = False
        self.reads = threading.Event()
        self.reads.set()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._runner = threading.Thread(target=self._run, daemon=True)
        self._reader.start()
        self._runner.start()
        self.sees("Robot>")

    @property
    def text(self) -> str:
        """What was written, with the cursor's steps to the right as the blanks they stand for."""
        moved = STEPS.sub(lambda step: " " * int(step[1] or 1), self._seen.decode(errors="replace"))
        return CODES.sub("", moved)

    @property
    def shown(self) -> list[str]:
        """The lines that a person sees now, without empty ones at the end."""
        seen = Vt(*self.size)
        seen.feed(self._seen.decode(errors="replace"))
        return "\n".join(seen.lines).rstrip().splitlines()

    def shows(self, *lines: str) -> None:
        """Wait until the whole screen is these lines, the input with room for its menu, and the bar."""
        *above, prompt = lines
        wanted = [*above, prompt, *[""] * (MENU_ROWS - 1)]
        try:
            until(lambda: self.shown[:-1] == wanted and self.shown[-1].startswith(f" {ROBOT} | "))
        except AssertionError:
            raise AssertionError("the screen is\n" + "\n".join(self.shown)) from None

    def types(self, text: str) -> None:
        os.write(self.master, text.encode())

    def sees(self, text: str) -> None:
        try:
            until(lambda: text in self.text)
        except AssertionError:
            raise AssertionError(f"'{text}' did not come; there is {self.text!r}") from None

    def ends(self) -> int | None:
        self._runner.join(HANG_S)
        assert not self._runner.is_alive()
        return self.code

    def hang_up(self) -> None:
        os.close(self.master)
        self.master = -1

    def close(self) -> None:
        self.reads.set()
        self.terminal.close()
        self._runner.join(5)
        with contextlib.suppress(OSError):
            self._text.close()
        self._keys.close()
        self._reader.join(5)
        if self.master >= 0:
            os.close(self.master)

    def _run(self) -> None:
        self.code = self.terminal.run()

    def _read(self) -> None:
        while True:
            try:
                seen = os.read(self.master, 65536)
            except OSError:
                return
            self._seen += seen
            if self.answers and b"\x1b[6n" in seen:
                self.types("\x1b[7;9R")
            self.reads.wait()


@pytest.fixture
def screen(robot, client, monkeypatch):
    for name in ("CONTACT_S", "STUCK_S"):  # as in the fixture `patient`
        monkeypatch.setattr(f"lbr.console.terminal.{name}", HANG_S)
    robot.lines["help"] = ConsoleResult(
        code=0,
        text="s  Stop",
        data=[
            {"word": "report", "pattern": "/report/{name}", "target": "executive.report", "choices": ["health"]},
            {"word": "Shutdown", "pattern": "Shutdown", "target": "executive.shutdown", "help": ""},
        ],
    )
    robot.lines["s"] = ConsoleResult(code=0, text="motors stopped")
    operator = BusOperator(client, ROBOT, "console")
    seen = Screen(operator)
    until(lambda: seen.terminal._completer.entries)
    yield seen
    seen.close()
    operator.close()


def said(robot) -> list[str]:
    return [line for line, _, _ in robot.said if line != "help"]


def test_a_line_is_said_and_its_result_shown(robot, screen):
    screen.types("s\r")
    screen.sees("motors stopped")
    assert said(robot) == ["s"]


def test_what_needs_a_yes_is_asked_for_and_enter_is_no(robot, screen):
    robot.lines["/torque/off"] = ConsoleResult(code=1, text="The robot falls.", confirm="/torque/off/all")
    robot.lines["/torque/off/all"] = ConsoleResult(code=0, text="all are let go")
    screen.types("/torque/off\r")
    screen.sees("Do it? y/N")
    screen.types("\r")
    screen.sees("Nothing was done.")
    assert said(robot) == ["/torque/off"]
    screen.types("/torque/off\r")
    until(lambda: screen.text.count("Do it? y/N") == 2)
    screen.types("y\r")
    screen.sees("all are let go")


def test_tab_completes_words_and_choices(robot, screen):
    robot.lines["/report/health"] = ConsoleResult(code=0, text="all is well")
    buffer = screen.terminal._session.default_buffer
    for typed, completed in (("/re", "/report/"), ("h", "/report/health")):
        screen.types(typed)
        screen.sees("health" if typed == "h" else "/report/")
        screen.types("\t")
        until(lambda: buffer.text == completed)  # noqa: B023 - waited for here
    screen.types("\r")
    screen.sees("all is well")


def test_a_paste_of_several_lines_runs_none_of_them(robot, screen):
    screen.types(PASTE.format("s\rs\ns\n"))
    screen.sees("The paste has 3 lines, and none was run")
    assert said(robot) == []


def test_a_paste_of_one_line_waits_for_enter(robot, screen):
    screen.types(PASTE.format("s\n"))
    until(lambda: screen.terminal._session.default_buffer.text == "s")
    assert said(robot) == []
    screen.types("\r")
    screen.sees("motors stopped")


@pytest.mark.parametrize("leave", ["\x03", "\x04"])
def test_ctrl_c_and_end_of_input_stop_what_moves_and_return(robot, screen, leave):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    screen.sees("moving under L1")
    until(lambda: robot.renewed)
    screen.types(leave)
    assert screen.ends() == 0
    until(lambda: robot.stopped)
    assert len(robot.stopped) == 1


def test_a_terminal_that_hangs_up_stops_what_it_held(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    screen.hang_up()
    until(lambda: robot.stopped)
    screen.ends()


def test_close_from_another_thread_ends_it_and_stops(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    screen.terminal.close()
    assert screen.ends() == 0
    assert len(robot.stopped) == 1


def test_events_and_ends_of_motions_appear_above_the_prompt(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    robot.dead["L1"] = "taken over by web"
    screen.sees("/r/0.2/0: taken over by web")
    robot.tell("no answer from the controller", "error")
    screen.sees("error: motors: no answer from the controller")


def test_a_slow_line_leaves_the_prompt_free_for_a_stop(robot, screen):
    robot.lines["clock"] = ConsoleResult(code=0, text="it is late")
    gate = robot.blocked["clock"] = threading.Event()
    screen.types("clock\r")
    screen.sees("clock (")
    screen.types("s\r")
    screen.sees("motors stopped")
    gate.set()
    screen.sees("it is late")


def test_control_characters_from_the_robot_do_not_reach_the_terminal(robot, screen):
    robot.lines["x"] = ConsoleResult(code=0, text="a\x1b]0;owned\x07b")
    screen.types("x\r")
    screen.sees("a ]0;owned b")


def test_shutdown_leaves_once_it_is_accepted(robot, screen):
    robot.lines["Shutdown"] = ConsoleResult(code=0, text="shutting down")
    screen.types("Shutdown\r")
    assert screen.ends() == 0


def test_a_shutdown_that_is_refused_leaves_the_console_open(robot, screen):
    robot.lines["Shutdown"] = ConsoleResult(code=1, text="this needs the role 'admin'")
    robot.lines["estop"] = ConsoleResult(code=0, text="emergency stop: acknowledged")
    screen.types("Shutdown\r")
    screen.sees("this needs the role 'admin'")
    screen.types("estop\r")
    screen.sees("emergency stop: acknowledged")


def test_what_is_typed_told_and_moved_leaves_one_prompt_and_one_bar(robot, screen):
    screen.shows("Robot>")
    robot.tell("the first")
    screen.shows("motors: the first", "Robot>")
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    screen.shows("motors: the first", "Robot> /r/0.2/0", "moving under L1", "Robot>")
    screen.types("xyz")
    robot.dead["L1"] = "taken over by web"
    robot.show()
    screen.shows(
        "motors: the first", "Robot> /r/0.2/0", "moving under L1", "/r/0.2/0: taken over by web", "Robot> xyz"
    )  # fmt: skip
    until(lambda: screen.shown[-1] == f" {ROBOT} | ready")


def test_a_full_screen_scrolls_and_keeps_one_prompt_and_one_bar(robot, screen):
    for number in range(60):
        robot.tell(f"event {number}")
    rows = screen.size[0] - MENU_ROWS - 1
    wanted = [f"motors: event {number}" for number in range(60)][-rows:]
    screen.types("abc")
    screen.shows(*wanted, "Robot> abc")


def test_what_any_thread_prints_stays_out_of_the_input_line(robot, screen):
    screen.types("abc")
    screen.shows("Robot> abc")
    with screen.terminal._above.catching(screen.terminal._print):
        writers = [threading.Thread(target=print, args=(f"line {number}",)) for number in range(4)]
        for writer in writers:
            writer.start()
            writer.join()
    screen.shows("line 0", "line 1", "line 2", "line 3", "Robot> abc")


def test_a_narrower_terminal_keeps_one_bar_within_its_columns(robot, screen):
    robot.tell("the first")
    screen.shows("motors: the first", "Robot>")
    robot.lines["long"] = ConsoleResult(code=0, text="word " * 30)
    screen.size = 24, 40
    termios.tcsetwinsize(screen.master, screen.size)
    until(lambda: screen.terminal._screen.get_size().columns == 40)
    screen.types("long\r")
    until(lambda: [line for line in screen.shown if line.startswith("  word word")])
    # The prompt is drawn again a moment after what is printed above it.
    until(lambda: sum(line.startswith(f" {ROBOT} | ") for line in screen.shown) == 1)
    assert sum(line.startswith("Robot>") for line in screen.shown) == 2


def test_ctrl_c_clears_a_half_typed_line_and_stops(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    screen.types("half")
    screen.shows("Robot> /r/0.2/0", "moving under L1", "Robot> half")
    screen.types("\x03")
    screen.shows("Robot> /r/0.2/0", "moving under L1", "Robot>")
    until(lambda: robot.stopped)
    robot.show()
    screen.types("\x03")
    assert screen.ends() == 0
    left = ["Robot> /r/0.2/0", "moving under L1", "Stopped; leaving. The robot runs on."]
    until(lambda: screen.shown == left)


def test_who_leaves_without_contact_is_not_told_that_it_stopped(screen, monkeypatch):
    monkeypatch.setattr("lbr.console.terminal.CONTACT_S", 0.0)
    screen.types("\x04")
    assert screen.ends() == 0
    until(lambda: any(line.startswith("Leaving without contact") for line in screen.shown))
    assert not any("Stopped" in line for line in screen.shown)


def test_lines_typed_ahead_are_said_in_their_order(robot, screen, monkeypatch):
    monkeypatch.setattr("lbr.console.terminal.PATIENCE_S", HANG_S)
    words = [f"word{number}" for number in range(8)]
    screen.types("".join(f"{word}\r" for word in words))
    until(lambda: len(said(robot)) == len(words))
    assert said(robot) == words


def test_after_a_stop_by_another_what_was_typed_ahead_is_still_said_and_what_moves_decides(robot, screen):
    robot.lines["/r/0.2/0"] = ConsoleResult(code=1, text=f"{STOPPED_SINCE}by phone", reason_code="stopped_since")
    gate = robot.blocked["/r/0.2/0"] = threading.Event()
    screen.types("/r/0.2/0\r")
    until(lambda: said(robot) == ["/r/0.2/0"])
    screen.types("word1\rword2\r")
    until(
        lambda: screen.terminal._lines.qsize() + len(said(robot)) == 3
    )  # a line waits for another's answer only a moment
    gate.set()
    until(lambda: said(robot) == ["/r/0.2/0", "word1", "word2"])


def flood(robot, screen) -> None:
    """Tell more than the terminal takes; what it answers then is what it would see last."""
    screen.reads.clear()
    for number in range(40):
        robot.tell(f"{number} {'x' * 1000}")
    until(lambda: robot.tell("more") or screen.terminal._screen.outlet.stuck_s > 0.05)


def test_a_terminal_that_is_not_read_stops_what_it_holds(robot, screen, monkeypatch, wording):
    monkeypatch.setattr("lbr.console.terminal.STUCK_S", 0.4)
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    flood(robot, screen)
    until(lambda: robot.stopped)
    wording(*robot.stopped)


def test_a_terminal_whose_output_is_held_back_stops_what_it_holds(robot, screen, monkeypatch):
    monkeypatch.setattr("lbr.console.terminal.STUCK_S", 0.4)
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    termios.tcflow(screen._text.fileno(), termios.TCOOFF)
    flood(robot, screen)
    until(lambda: robot.stopped)
    termios.tcflow(screen._text.fileno(), termios.TCOON)


def test_ctrl_s_and_ctrl_q_are_no_keys(robot, screen):
    screen.types("\x13s\x11\r")
    until(lambda: said(robot) == ["s"])


def test_a_stop_typed_at_a_terminal_that_is_not_read_is_said(robot, screen):
    flood(robot, screen)
    screen.types("s\r")
    until(lambda: said(robot) == ["s"])


@pytest.mark.parametrize("leave", ["\x03", "\x04", ""])
def test_a_terminal_that_is_not_read_can_be_left(robot, screen, leave):
    flood(robot, screen)
    if leave:
        screen.types(leave)
    else:
        screen.terminal.close()
    assert screen.ends() == 0


def test_a_reader_who_is_back_sees_a_whole_screen_and_how_much_was_left_out(robot, screen, monkeypatch):
    flood(robot, screen)
    monkeypatch.setattr("lbr.console.prompt_output.KEPT_CHARS", 100)
    for number in range(50):
        screen.terminal._above.print(f"line {number}")
    screen.types("abc")
    until(lambda: screen.terminal._session.default_buffer.text == "abc")
    screen.reads.set()
    until(lambda: screen.shown[-MENU_ROWS - 2 : -MENU_ROWS] == ["line 49", "Robot> abc"])
    lines = screen.shown
    assert [line for line in lines if line.endswith("left out)")]
    assert sum(line.startswith("Robot>") for line in lines) == 1
    assert sum(line.startswith(f" {ROBOT} | ") for line in lines) == 1


def test_a_terminal_that_ceases_to_answer_stops_what_it_holds(robot, screen, monkeypatch, wording):
    monkeypatch.setattr("lbr.console.ear.ANSWER_S", HANG_S)
    screen.answers = True
    screen.types("\x1b[7;9R")  # to the question at the start
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: screen._seen.count(b"\x1b[6n") > 4)
    assert robot.stopped == []
    screen.answers = False
    monkeypatch.setattr("lbr.console.ear.ANSWER_S", 1.0)
    until(lambda: robot.stopped)
    wording(*robot.stopped)


def test_a_loop_that_hears_no_key_stops_what_it_holds(robot, screen, monkeypatch, wording):
    monkeypatch.setattr("lbr.console.ear.FRESH_S", 0.5)
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    gate = threading.Event()
    screen.terminal._session.app.loop.call_soon_threadsafe(gate.wait, 5)
    until(lambda: robot.stopped)
    gate.set()
    wording(*robot.stopped)


def test_answers_of_the_terminal_never_come_into_the_line(robot, screen):
    screen.types("ab\x1b[7;9Rc")
    for piece in ("d\x1b", "[12;3", "4Re", PASTE.format("f\x1b[7;9Rg"), "\x1b[7;9R"):
        screen.types(piece)
    until(lambda: screen.terminal._session.default_buffer.text == "abcdefg")
    screen.shows("Robot> abcdefg")


def test_a_stop_waits_for_no_line_before_it_and_those_are_not_said(robot, screen):
    robot.lines["clock"] = ConsoleResult(code=0, text="it is late")
    gate = robot.blocked["clock"] = threading.Event()
    screen.types("clock\r")
    until(lambda: said(robot) == ["clock"])
    screen.types("clock\rword1\rword2\rs\r")
    until(lambda: "s" in said(robot))
    gate.set()
    screen.sees("word2")
    screen.types("end\r")
    until(lambda: "end" in said(robot))
    assert "word2" not in said(robot)


def test_a_history_that_cannot_be_written_keeps_no_line_from_being_said(robot, client, tmp_path):
    operator = BusOperator(client, ROBOT, "console")
    (tmp_path / "gone").mkdir()
    seen = Screen(operator, history=tmp_path / "gone" / "history")
    shutil.rmtree(tmp_path / "gone")
    robot.lines["s"] = ConsoleResult(code=0, text="motors stopped")
    for _ in range(2):
        seen.types("s\r")
    until(lambda: said(robot) == ["s", "s"])
    seen.close()
    operator.close()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("lbr send@vm:7: stopped by lbr send@vm:7: the 0.5 s are over", "drive: lbr send@vm:7: the 0.5 s are over"),
        ("console: stopped by console", "drive: console: stopped"),
        ("console: stopped by web@vm:7: a hand", "drive: console: stopped by web@vm:7: a hand"),
        ("console: stopped by console@vm:7", "drive: console: stopped by console@vm:7"),
    ],
)
def test_who_stops_an_own_motion_is_named_once(text, told):
    assert describe(Event(kind="stopped", subject="drive", text=text)) == told


EDITING = {
    "Ctrl-Z": "\x1a",
    "Esc": "\x1b",
    "CSI": "\x1b[",
    "SS3": "\x1bO",
    "Esc 5": "\x1b5",
    "DCS": "\x1bP",
    "OSC": "\x1b]0;",
    "mouse": "\x1b[<0;",
    "Ctrl-R": "\x12",
    "Ctrl-@": "\x00",
}


@pytest.mark.parametrize("before", EDITING.values(), ids=EDITING)
def test_a_stop_is_said_whatever_keys_came_before_it(robot, screen, before):
    screen.types(before)
    screen.types("s\r")
    screen.sees("motors stopped")
    screen.types("s\r")
    until(lambda: said(robot).count("s") == 2)


def test_a_stop_is_said_in_a_paste_that_does_not_end(robot, screen):
    screen.types("\x1b[200~half a line\r")
    until(lambda: screen.terminal._session.app.input.vt100_parser._in_bracketed_paste)
    assert not threading.Event().wait(QUIET_S * 1.2)
    screen.types("s\r")
    screen.sees("motors stopped")
    screen.types("s\r")
    until(lambda: said(robot) == ["s", "s"])


def test_ctrl_c_is_heard_in_a_paste_that_does_not_end(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    screen.types("\x1b[200~half a line\r")
    until(lambda: screen.terminal._session.app.input.vt100_parser._in_bracketed_paste)
    assert not threading.Event().wait(QUIET_S * 1.2)
    screen.types("\x03")
    until(lambda: robot.stopped)  # a console that was held up stops by itself
    until(lambda: not screen.terminal._session.app.input.vt100_parser._in_bracketed_paste)
    screen.types("\x03")
    assert screen.ends() == 0


def test_a_flood_of_lines_is_not_run_and_a_stop_in_it_is(robot, screen):
    robot.lines["x"] = ConsoleResult(code=0, text="ran")
    screen.types("x\r" * 200 + "s\r")
    screen.sees("more than 8 lines, or 1000 characters, came at once")
    screen.sees("motors stopped")
    assert said(robot) == ["s"]


def test_behind_a_line_without_an_end_a_stop_is_heard_at_once(robot, screen):
    robot.moves("/r/0.2/0", "L1")
    screen.types("/r/0.2/0\r")
    until(lambda: robot.renewed)
    screen.types("x" * 100_000 + "\x03")
    until(lambda: robot.stopped)
    screen.sees("or 1000 characters, came at once")
    assert said(robot) == ["/r/0.2/0"]


def test_a_paste_that_is_longer_than_a_line_is_left_out(screen):
    screen.types(f"\x1b[200~{'x' * 5000}\x1b[201~")
    screen.sees("5000 characters")
    assert screen.terminal._session.default_buffer.text == ""
