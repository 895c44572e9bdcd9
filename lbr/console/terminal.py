"""The terminal: a prompt with completion, history and a live status bar. Its motion stops when it ends.

Its loop gives the pulse without which no motion is held, and no part of it waits for the terminal to accept output.
"""

import asyncio
import contextlib
import os
import queue
import re
import sys
import termios
import threading
import time
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.application import create_app_session
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.buffer import Buffer
from prompt_toolkit.filters import Condition
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.input import Input
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.keys import Keys
from prompt_toolkit.search import stop_search
from prompt_toolkit.styles import Style

from lbr.console.completion import LineCompleter
from lbr.console.confirmation import LET_BE, QUESTION, Confirmation
from lbr.console.ear import BEAT_S, STUCK_S, Contact
from lbr.console.greeting import Greeting
from lbr.console.keyboard import CHARACTERS_AT_ONCE, CURSOR_IS_HERE, INTERRUPT, LINES_AT_ONCE, begin_again, listen
from lbr.console.lease_keeper import Ending
from lbr.console.operator import BusOperator
from lbr.console.printable import MAX_LINE, wrapped
from lbr.console.prompt_output import PromptOutput, Screen
from lbr.console.stops import is_stop
from lbr.console.toolbar import CONTACT_S, toolbar
from lbr.errors import LbrError
from lbr.messages.plain import one_line
from lbr.messages.system import ConsoleResult, Event

PROMPT = "Robot> "
REFRESH_S = 0.25
PATIENCE_S = 0.3  # how long the next line waits for the result of this one
SHUTDOWN = "executive.shutdown"
LAST_ANSWER_S = 0.2
LAST_OUTPUT_S = 0.3
WHERE_IS_THE_CURSOR = "\x1b[6n"
STYLE = Style.from_dict(
    {
        "bottom-toolbar": "noreverse bg:#303030 #d0d0d0",
        "good": "#87d787",
        "doubtful": "#ffd75f bold",
        "bad": "bg:#af0000 #ffffff bold",
    }
)
_COLOURS = {"error": "\x1b[31m", "warning": "\x1b[33m"}
_OWN_STOP = re.compile(r"(?P<who>[^:]+(?::[0-9]+)?): stopped by (?P=who)(?:: (?P<why>.+))?")
_PLAIN = "\x1b[0m"


class Terminal:
    """The console of one operator. `run` may be called in any thread; `close` ends it from any other.

    The robot's own console has a `greeting`: when it is left, the robot shuts down.
    """

    def __init__(
        self,
        operator: BusOperator,
        *,
        greeting: Greeting | None = None,
        history: Path | None = None,
        source: Input | None = None,
        screen: Screen | None = None,
    ) -> None:
        self._operator = operator
        self._greeting = greeting
        self._source = source
        self._screen = screen or Screen.on(sys.stdout, term=os.environ.get("TERM"))
        self._contact = Contact()
        self._closing = self._left = False
        self._lock = threading.Lock()
        self._under_way: dict[str, float] = {}
        self._completer = LineCompleter()
        self._revision = -1
        self._question = Confirmation()
        self._over = threading.Event()
        self._session: PromptSession[str] = PromptSession(
            PROMPT,
            input=source,
            output=self._screen,
            history=_history(history),
            completer=self._completer,
            complete_while_typing=True,
            auto_suggest=AutoSuggestFromHistory(),
            key_bindings=self._keys(),
            bottom_toolbar=self._bar,
            refresh_interval=REFRESH_S,
            style=STYLE,
            reserve_space_for_menu=6,
            erase_when_done=True,
        )
        self._session.default_buffer.accept_handler = self._accept
        self._stops = 0
        listen(
            self._session.app.input,
            on_stop=self._overheard,
            flooded=self._flooded,
            typed=lambda: len(self._session.app.current_buffer.text),
        )
        self._above = PromptOutput(self._session.app, self._screen)
        self._lines: queue.SimpleQueue[tuple[float, str]] = queue.SimpleQueue()

    def run(self) -> int:
        """Read lines until end of input, Ctrl-C, a shutdown or `close`; stop the held motion, return an exit code."""
        self._operator.on_end = self._ended
        self._operator.ear.also = self._unheard
        helpers = [
            threading.Thread(target=self._follow, name="console events", daemon=True),
            threading.Thread(target=self._say_all, name="console lines", daemon=True),
        ]
        with create_app_session(self._source, self._screen), self._above.catching(self._print):
            for helper in helpers:
                helper.start()
            try:
                self._session.prompt(pre_run=self._begin, handle_sigint=False, set_exception_handler=False)
            except (EOFError, KeyboardInterrupt):
                pass
            except OSError:  # the terminal hung up
                self._closing = True
            finally:
                self._over.set()
                self._lines.put((time.monotonic(), ""))  # a reader that waits for a line must not wait any longer
                self._operator.release()
            if not self._closing:
                self._print(self._parting())
            for helper in helpers:
                helper.join(1.0)
            self._left = True
            self._above.ended()
            self._screen.outlet.drain(LAST_OUTPUT_S if self._screen.outlet.stuck_s < STUCK_S else 0.0)
            self._screen.outlet.close()
            if self._contact.open:
                self._forget_input()
        return 0

    def close(self) -> None:
        """End `run`, from another thread or a signal handler."""
        self._closing = True
        app = self._session.app
        loop = app.loop
        if loop is not None and app.is_running:
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._leave, EOFError)

    def _parting(self) -> str:
        if self._greeting is not None:
            return "Stopped; shutting down."
        if self._operator.telemetry().status_age_s > CONTACT_S:
            return "Leaving without contact: no stop was acknowledged. What you held has lapsed by itself."
        return "Stopped; leaving. The robot runs on."

    def _leave(self, why: type[BaseException]) -> None:
        """Leave the prompt after the terminal's last answer, which the shell behind it must not read."""
        app = self._session.app
        loop = app.loop
        if self._contact.awaited and loop is not None:
            self._contact.on_answer = lambda: self._exit(why)
            loop.call_later(LAST_ANSWER_S, self._exit, why, context=app.context)
        else:
            self._exit(why)

    def _exit(self, why: type[BaseException]) -> None:
        app = self._session.app
        if app.is_running and not app.is_done:
            app.exit(exception=why, style="class:exiting")

    def _forget_input(self) -> None:
        """Drop an answer of the terminal that came when nobody read it any more."""
        with contextlib.suppress(OSError, termios.error):
            termios.tcflush(self._session.app.input.fileno(), termios.TCIFLUSH)

    def _begin(self) -> None:
        self._above.started()
        self._session.app.create_background_task(self._beat())
        if self._closing:
            self._leave(EOFError)

    async def _beat(self) -> None:
        """Report that keys are received, and ask the terminal at intervals for a sign of life."""
        while True:
            self._operator.ear.beat()
            if self._screen.free and self._contact.due(held=self._operator.held() is not None):
                self._contact.asked()
                self._screen.write_raw(WHERE_IS_THE_CURSOR)
                self._screen.flush()
            await asyncio.sleep(BEAT_S)

    def _unheard(self) -> str:
        """Return why the person at the terminal may not see what moves, empty without a sign of that."""
        if self._screen.outlet.error(self._screen.fileno()) is not None:
            return "the terminal is gone"
        if self._screen.outlet.stuck_s > STUCK_S:
            return f"the terminal has taken no output for {STUCK_S:g} s"
        return self._contact.lost()

    def _accept(self, buffer: Buffer) -> bool:
        """Accept a line without leaving the prompt: it appears above when its turn comes, followed by its result."""
        line = buffer.text.strip()
        self._contact.typed()
        if is_stop(line):
            self._stop(line)
        elif line or self._question.open:
            self._lines.put((time.monotonic(), line))
        return False

    def _stop(self, line: str) -> None:
        """Send a stop at once, and drop the lines that were typed before it and still wait."""
        self._stops += 1
        dropped = self._forget_lines()
        self._above.print(PROMPT + one_line(line))
        self._tell_dropped(dropped)
        self._question.answer(line)
        self._start(line, threading.Event())

    def _tell_dropped(self, dropped: list[str]) -> None:
        if dropped:
            self._print(f"Not sent: {', '.join(dropped)}", "warning")

    def _overheard(self, stop: str) -> None:
        """Also stop when the editor does not treat these keys as a line: it searches, or waits for a paste's end."""
        loop = self._session.app.loop
        if loop is not None:
            loop.call_soon(self._stop_unless_counted, stop, self._stops, context=self._session.app.context)

    def _stop_unless_counted(self, stop: str, count: int) -> None:
        app = self._session.app
        if self._stops != count or not app.is_running or app.is_done:
            return
        begin_again(app.input)
        app.key_processor.reset()
        if app.layout.is_searching:
            stop_search()
        self._session.default_buffer.reset()
        if stop == INTERRUPT:
            self._stop_now()
        else:
            self._stop(stop)

    def _flooded(self) -> None:
        self._print(
            f"more than {LINES_AT_ONCE} lines, or {CHARACTERS_AT_ONCE} characters, came at once, and nothing of it was "
            "run: paste one line at a time",
            "error",
        )
        app = self._session.app
        if app.loop is not None:  # the beginning of a line that is too long must not count as a line
            app.loop.call_soon(app.current_buffer.reset, context=app.context)

    def _say_all(self) -> None:
        while not self._over.is_set():
            try:
                typed, line = self._lines.get(timeout=REFRESH_S)
            except queue.Empty:
                continue
            if self._over.is_set():
                return
            self._above.print(PROMPT + one_line(line))
            meant = self._question.answer(line)
            if not meant:
                self._print(LET_BE)
                continue
            line = meant
            answered = threading.Event()
            self._start(line, answered, typed)
            answered.wait(PATIENCE_S)

    def _start(self, line: str, answered: threading.Event, typed: float | None = None) -> None:
        threading.Thread(target=self._say, args=(line, answered, typed), name="console line", daemon=True).start()

    def _say(self, line: str, answered: threading.Event, typed: float | None) -> None:
        with self._lock:
            self._under_way[line] = time.monotonic()
        try:
            result = self._operator.submit(line, 0.0 if typed is None else time.monotonic() - typed)
            self._show(result)
            if result.confirm:
                self._question.ask(result)
                self._print(QUESTION, "warning")
            if result.code == 0 and self._is_shutdown(line):
                self.close()
        except LbrError as err:
            self._print(str(err), "error")
        finally:
            with self._lock:
                self._under_way.pop(line, None)
            answered.set()

    def _is_shutdown(self, line: str) -> bool:
        return any(e.get("target") == SHUTDOWN and e.get("word") == line.strip("/") for e in self._completer.entries)

    def _show(self, result: ConsoleResult) -> None:
        if result.text:
            self._print(result.text, "error" if result.code else "info")

    def _ended(self, line: str, ending: Ending) -> None:
        self._print(f"{one_line(line)}: {ending.text}", "info" if ending.good else "warning")

    def _print(self, text: str, level: str = "info") -> None:
        if self._left:  # a line was still under way
            return
        colour = _COLOURS.get(level, "")
        safe = wrapped(text, self._screen.get_size().columns)
        self._above.print(f"{colour}{safe}{_PLAIN if colour else ''}")

    def _follow(self) -> None:
        while not self._over.is_set():
            status = self._operator.telemetry().status
            for event in self._operator.events():
                if self._greeting is None or self._greeting.shows(event):
                    self._print(describe(event), event.level)
            if self._greeting is not None and self._greeting.is_due(status):
                self._print(self._greeting.text())
            revision = status.revision if status is not None else 0
            if revision != self._revision:
                self._completer.entries = self._operator.words() or self._completer.entries
                self._revision = revision if self._completer.entries else -1
            self._over.wait(REFRESH_S)

    def _bar(self) -> StyleAndTextTuples:
        now = time.monotonic()
        with self._lock:
            under_way = {line: now - since for line, since in self._under_way.items() if now - since > PATIENCE_S}
        operator = self._operator
        columns = self._screen.get_size().columns
        return [*toolbar(operator.robot, operator.telemetry(), operator.held(), under_way, columns)]

    def _keys(self) -> KeyBindings:
        keys = KeyBindings()

        @keys.add(Keys.BracketedPaste)
        def _paste(event: KeyPressEvent) -> None:
            text = CURSOR_IS_HERE.sub("", event.data).replace("\r\n", "\n").replace("\r", "\n").strip("\n")
            if "\n" in text:
                count = len(text.splitlines())
                self._print(f"The paste has {count} lines, and none was run: paste one line at a time.", "error")
            elif len(text) > MAX_LINE:
                self._print(f"The paste has {len(text)} characters, and a line may have {MAX_LINE}: left out.", "error")
            else:
                event.current_buffer.insert_text(text)

        @keys.add(Keys.CPRResponse, save_before=lambda _event: False)
        def _answered(_event: KeyPressEvent) -> None:
            self._contact.answered()

        @keys.add("c-s")
        @keys.add("c-q")
        @keys.add("c-z")
        def _none(_event: KeyPressEvent) -> None:
            """Ignore keys: terminals send the first two by themselves; the last would spoil the line behind it."""

        @keys.add("c-c")
        def _interrupt(event: KeyPressEvent) -> None:
            self._stop_now()
            if event.app.current_buffer.text:
                event.app.current_buffer.reset()
                return
            self._leave(KeyboardInterrupt)

        @keys.add("c-d", filter=Condition(lambda: not self._session.default_buffer.text))
        def _end_of_input(_event: KeyPressEvent) -> None:
            self._stop_now()
            self._leave(EOFError)

        return keys

    def _stop_now(self) -> None:
        """Stop the motors now, whatever the prompt does next; waiting lines are dropped."""
        self._stops += 1
        self._forget_lines()
        threading.Thread(target=self._operator.release, name="release", daemon=True).start()

    def _forget_lines(self) -> list[str]:
        """Remove and return the waiting lines."""
        lines = []
        with contextlib.suppress(queue.Empty):
            while True:
                lines.append(self._lines.get_nowait()[1])
        return lines


def describe(event: Event) -> str:
    """Return an event as one line."""
    level = f"{event.level}: " if event.level != "info" else ""
    own = _OWN_STOP.fullmatch(event.text)
    text = f"{own['who']}: {own['why'] or 'stopped'}" if own else event.text
    return one_line(f"{level}{event.subject}: {text}" if event.subject else f"{level}{text}")


def _history(path: Path | None) -> History:
    if path is None:
        return InMemoryHistory()
    try:
        path.touch(mode=0o600)
    except OSError:
        return InMemoryHistory()
    return _Kept(path) if path.is_file() else InMemoryHistory()


class _Kept(FileHistory):
    """Lines in a file, as far as the disk accepts them: a full disk must not block the console."""

    def store_string(self, string: str) -> None:
        with contextlib.suppress(OSError):
            super().store_string(string)
