"""Keys as they come: what stops the robot is heard in them, whatever the line editor makes of them."""

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
"""More than people type while a busy machine holds the console up, and fewer than what is worth a paste."""
CHARACTERS_AT_ONCE = 1000
"""More than a key that is held down sends while the console is held up for ten seconds. Of some, such as a Tab, a busy
machine takes a few a second, and what was typed behind them would wait for minutes."""
QUIET_S = 0.25
"""The silence after a flood, or within a paste whose end got lost: slow lines pause for less."""
LONGEST = 1000
PASTE_BEGINS, PASTE_ENDS = "\x1b[200~", "\x1b[201~"
CURSOR_IS_HERE = re.compile(r"\x1b\[[0-9]+;[0-9]+R")
_CUT_OFF = re.compile(r"\x1b(?:\[[0-9;?<]*)?\Z")
_ENDS = re.compile(r"[\r\n]")
_MARKS = re.compile(r"(\x1b\[20[01]~)")
_HALF_MARKS = ("\x1b[200", "\x1b[201", "\x1b[20", "\x1b[2", "\x1b[", "\x1b")
_KEYS_BEFORE = re.compile(r"(?:\x1b[\[\]OP]?[0-9;<?M~]*|[\x00-\x1f\x7f\ufffd\udc80-\udcff])*")


class Heard(Struct, frozen=True):
    """The stops in a piece of input, in their order; whether it is part of a flood, or its beginning."""

    stops: tuple[str, ...] = ()
    flood: bool = False
    begins: bool = False


class Overhearing:
    """Follows what is typed, piece by piece: hears stops in it, and knows a flood of lines from typing.

    A stop word is heard although keys came before it that the editor takes for the beginning of something else: an
    escape, a sequence cut short, a byte that is no text, a search, a paste that has no end. The content of a whole
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
        """Take in the next piece, of a line of which `typed` characters are there.

        A line that is longer than any may be is a flood, too: each of its characters takes the editor longer than the
        one before.
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
        """Take a paste that has not ended for ended."""
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
    """Reads keys for the editor. `on_stop` gets each stop at once, before the editor does; a flood never gets there.

    `typed` says how many characters the editor has of a line.
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
        """Return the text for the editor; a sequence that is cut off waits for its end, so that its rest is not
        text."""
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
        """Forget a sequence that was begun and not ended."""
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
    """Read a terminal's keys for stops, too."""
    if isinstance(source, Vt100Input):
        encoding = source.stdin.encoding or "utf-8"
        source.stdin_reader = Keyboard(source.fileno(), encoding, on_stop=on_stop, flooded=flooded, typed=typed)


def begin_again(source: Input) -> None:
    """Forget sequences and pastes that were begun and not ended."""
    if isinstance(source, Vt100Input):
        source.vt100_parser.reset()
        if isinstance(source.stdin_reader, Keyboard):
            source.stdin_reader.forget()
