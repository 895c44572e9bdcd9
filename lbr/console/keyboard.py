"""The keys of a terminal: stops are found in them before the line editor gets them."""

import re
import time
from collections.abc import Callable

from msgspec import Struct
from prompt_toolkit.input import Input
from prompt_toolkit.input.posix_utils import PosixStdinReader
from prompt_toolkit.input.vt100 import Vt100Input

from lbr.console.printable import MAX_LINE
from lbr.console.stops import is_stop

INTERRUPT = "\x03"
LINES_AT_ONCE = 8
"""More than people type while a busy machine delays the console, and fewer than a worthwhile paste."""
CHARACTERS_AT_ONCE = 1000
"""More than a held key sends while the console is delayed for ten seconds.

Of some keys, such as Tab, a busy machine processes a few a second: keys typed after them would wait for minutes.
"""
QUIET_S = 0.25
"""The silence after a flood, or within a paste whose end was lost: slow lines pause for less."""
LONGEST = 1000
PASTE_BEGINS, PASTE_ENDS = "\x1b[200~", "\x1b[201~"
CURSOR_IS_HERE = re.compile(r"\x1b\[[0-9]+;[0-9]+R")
_CUT_OFF = re.compile(r"\x1b(?:\[[0-9;?<]*)?\Z")
_ENDS = re.compile(r"[\r\n]")
_MARKS = re.compile(r"(\x1b\[20[01]~)")
_HALF_MARKS = ("\x1b[200", "\x1b[201", "\x1b[20", "\x1b[2", "\x1b[", "\x1b")
_KEYS_BEFORE = re.compile(r"(?:\x1b[\[\]OP]?[0-9;<?M~]*|[\x00-\x1f\x7f\ufffd\udc80-\udcff])*")


class Heard(Struct, frozen=True):
    """The stops in a piece of input, in order, and whether it belongs to a flood, or begins one."""

    stops: tuple[str, ...] = ()
    flood: bool = False
    begins: bool = False


class Overhearing:
    """Examines the input piece by piece: finds stops, and distinguishes a flood of lines from typing.

    A stop counts even after keys that the editor would treat as the beginning of something else. Such keys are an
    escape, an incomplete sequence, a byte that is not text, a search, or a paste without end. The content of a complete
    paste is not run.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._last = clock()
        self._flood_until = self._last
        self._carried = ""
        self._line = ""
        self._pasting = self._broken = False

    def hear(self, text: str, typed: int = 0) -> Heard:
        """Examine the next piece of a line that already has `typed` characters.

        A line that exceeds the longest permitted one is a flood, too: each of its characters takes the editor longer
        than the previous one.
        """
        now = self._clock()
        paused, self._last = now - self._last >= QUIET_S, now
        much = (
            len(text) > CHARACTERS_AT_ONCE or typed + len(text) > MAX_LINE or len(_ENDS.findall(text)) > LINES_AT_ONCE
        )
        text = self._carried + text
        self._carried = next((part for part in _HALF_MARKS if text.endswith(part)), "")
        pieces = _MARKS.split(text.removesuffix(self._carried))
        in_paste = self._pasting or len(pieces) > 1
        if self._pasting and paused and pieces[0]:
            self._broken, self._line = True, ""
        stops = [stop for piece in pieces for stop in self._stops(piece)]
        if in_paste or not (now < self._flood_until or much):
            return Heard(tuple(stops))
        begins, self._flood_until = not now < self._flood_until, now + QUIET_S
        return Heard(tuple(stops), flood=True, begins=begins)

    def forget_paste(self) -> None:
        """Treat a paste without end as ended."""
        self._pasting = self._broken = False

    def _stops(self, piece: str) -> list[str]:
        if piece in {PASTE_BEGINS, PASTE_ENDS}:
            self._pasting, self._broken, self._line = piece == PASTE_BEGINS, False, ""
            return []
        if self._pasting and not self._broken:
            return []
        *lines, rest = _ENDS.split(self._line + piece)
        self._line = rest[-LONGEST:]
        words = (_KEYS_BEFORE.sub("", CURSOR_IS_HERE.sub("", line), count=1).strip() for line in lines)
        return [INTERRUPT] * piece.count(INTERRUPT) + [word for word in words if is_stop(word)]


class Keyboard(PosixStdinReader):
    """Reads keys for the editor. `on_stop` gets each stop at once, before the editor; a flood never reaches the editor.

    `typed` returns the number of characters in the editor.
    """

    def __init__(
        self,
        fd: int,
        encoding: str,
        *,
        on_stop: Callable[[str], None],
        flooded: Callable[[], None],
        typed: Callable[[], int],
    ) -> None:
        super().__init__(fd, encoding=encoding)
        self.overhearing = Overhearing(time.monotonic)
        self._on_stop = on_stop
        self._flooded = flooded
        self._typed = typed
        self._begun = ""

    def read(self, count: int = 1024) -> str:
        """Return the text for the editor; an incomplete sequence waits for its end, and never becomes text."""
        text = super().read(count)
        if not text:
            return text
        overheard = self.overhearing.hear(text, self._typed())
        for stop in overheard.stops:
            self._on_stop(stop)
        if overheard.begins:
            self._flooded()
        return self._whole("" if overheard.flood else text)

    def forget(self) -> None:
        """Forget an incomplete sequence."""
        self._begun = ""
        self.overhearing.forget_paste()

    def _whole(self, text: str) -> str:
        text = self._begun + text
        cut_off = _CUT_OFF.search(text)
        self._begun = cut_off.group() if cut_off else ""
        return text.removesuffix(self._begun)


def listen(
    source: Input, *, on_stop: Callable[[str], None], flooded: Callable[[], None], typed: Callable[[], int]
) -> None:
    """Also examine a terminal's keys for stops."""
    if isinstance(source, Vt100Input):
        encoding = source.stdin.encoding or "utf-8"
        source.stdin_reader = Keyboard(source.fileno(), encoding, on_stop=on_stop, flooded=flooded, typed=typed)


def begin_again(source: Input) -> None:
    """Forget incomplete sequences and pastes."""
    if isinstance(source, Vt100Input):
        source.vt100_parser.reset()
        if isinstance(source.stdin_reader, Keyboard):
            source.stdin_reader.forget()
