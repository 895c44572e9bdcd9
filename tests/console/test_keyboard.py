"""What is overheard in typed keys, piece by piece as they come."""

import itertools
import os

from hypothesis import given
from hypothesis import strategies as st
from prompt_toolkit.input.vt100_parser import Vt100Parser
from prompt_toolkit.key_binding.key_processor import KeyPress
from prompt_toolkit.keys import Keys

from lbr.console.keyboard import (
    INTERRUPT,
    LINES_AT_ONCE,
    PASTE_BEGINS,
    PASTE_ENDS,
    QUIET_S,
    Heard,
    Keyboard,
    Overhearing,
)
from lbr.console.printable import MAX_LINE

KEYS_BEFORE = [
    "",
    "\x1b",
    "\x1b[",
    "\x1bO",
    "\x1b5",
    "\x1b[M",
    "\x1b[<0;",
    "\x1b]0;",
    "\x1bP",
    "\x1a",
    "\x12",
    "\x00",
    "\udce2",
]


class Typist:
    def __init__(self) -> None:
        self.now = 100.0
        self.overhearing = Overhearing(lambda: self.now)

    def types(self, text: str, *, after_s: float = 0.0) -> Heard:
        self.now += after_s
        return self.overhearing.hear(text)


@given(st.sampled_from(KEYS_BEFORE), st.sampled_from(["s", "S", "stop", "estop", "/s", "ESTOP"]), st.data())
def test_a_stop_is_heard_however_it_is_cut_and_whatever_came_before(before, word, data):
    text = before + word + "\r"
    cut = data.draw(st.integers(0, len(text)))
    typist = Typist()
    heard = [*typist.types(text[:cut]).stops, *typist.types(text[cut:], after_s=0.1).stops]
    assert heard == [word]


@given(
    st.lists(st.text(max_size=20), max_size=20), st.lists(st.sampled_from([0.0, 0.1, 1.0]), min_size=20, max_size=20)
)
def test_no_input_breaks_it_and_a_stop_is_heard_after_any(pieces, pauses):
    typist = Typist()
    for piece, after_s in zip(pieces, pauses, strict=False):
        typist.types(piece, after_s=after_s)
    typist.types("\r", after_s=1.0)
    assert typist.types("s\r", after_s=0.2).stops == ("s",)


def test_other_lines_are_no_stops():
    typist = Typist()
    for line in ("/play/s\r", "xs\r", "status\r", "/s/s\r", "s\x7fx\r", "\x1b[As\r", "reset\r"):
        assert typist.types(line) == Heard()


def test_what_a_whole_paste_holds_is_not_said():
    typist = Typist()
    assert typist.types(f"{PASTE_BEGINS}s\rs\n{PASTE_ENDS}\r") == Heard()
    for piece in (PASTE_BEGINS[:3], PASTE_BEGINS[3:] + "x\r" * 500, "s\r" * 500 + PASTE_ENDS[:2], PASTE_ENDS[2:]):
        assert typist.types(piece, after_s=0.1) == Heard()
    assert typist.types("s\r").stops == ("s",)


def test_in_a_paste_that_was_silent_for_a_while_a_person_is_heard():
    typist = Typist()
    typist.types(f"{PASTE_BEGINS}half")
    assert typist.types("s", after_s=QUIET_S) == Heard()
    assert typist.types("\r").stops == ("s",)
    assert typist.types("\x03").stops == (INTERRUPT,)
    typist.overhearing.forget_paste()
    assert typist.types("x\r" * (LINES_AT_ONCE + 1)).flood


def test_a_flood_lasts_until_nothing_comes_for_a_while():
    typist = Typist()
    assert typist.types("x\r" * LINES_AT_ONCE) == Heard()
    assert typist.types("x\r" * (LINES_AT_ONCE + 1)) == Heard(flood=True, begins=True)
    assert typist.types("0.4/90\r", after_s=0.1) == Heard(flood=True)
    assert typist.types("s\r", after_s=0.1) == Heard(("s",), flood=True)
    assert typist.types("x\r", after_s=QUIET_S) == Heard()


def test_a_line_that_is_longer_than_any_may_be_is_a_flood_and_a_stop_behind_it_is_heard():
    typist = Typist()
    assert typist.overhearing.hear("x" * 96, MAX_LINE - 96) == Heard()
    assert typist.overhearing.hear("x", MAX_LINE) == Heard(flood=True, begins=True)
    for keys in ("x" * 1024, "\t" * 1024, "\x1b[D" * 400, "\x7f" * 1024) * 100:
        assert typist.types(keys).flood
    assert typist.types("\rstop\r") == Heard(("stop",), flood=True)
    assert typist.types("\x03") == Heard((INTERRUPT,), flood=True)
    assert typist.types("x", after_s=QUIET_S) == Heard()


REPORT = "\x1b[20;1R"
WORDS = ["s", "S", "stop", "estop", "/s"]


@given(
    st.sampled_from(WORDS),
    st.sampled_from(["before", "after"]),
    st.sets(st.integers(1, 12)),
    st.sampled_from([0.0, 0.6, 1.0]),
)
def test_a_stop_and_a_terminals_report_cut_anywhere_are_that_stop_and_no_text(word, where, cuts, gap_s):
    """What the editor gets of pieces that come up to a second apart, and what is overheard in them."""
    text = (word + REPORT if where == "after" else REPORT + word) + "\r"
    places = [0, *sorted(cut for cut in cuts if cut < len(text)), len(text)]
    reader, writer = os.pipe()
    heard: list[str] = []
    keyboard = Keyboard(reader, "utf-8", on_stop=heard.append, flooded=lambda: None, typed=lambda: 0)
    now = 100.0
    keyboard.overhearing = Overhearing(lambda: now)
    keys: list[KeyPress] = []
    parser = Vt100Parser(keys.append)
    try:
        for begin, end in itertools.pairwise(places):
            now += gap_s
            os.write(writer, text[begin:end].encode())
            parser.feed(keyboard.read())
            if gap_s >= 0.5:
                parser.flush()
    finally:
        os.close(writer)
        os.close(reader)
    assert heard == [word]
    assert "".join(key.data for key in keys if key.key not in {Keys.CPRResponse, Keys.ControlM}) == word
