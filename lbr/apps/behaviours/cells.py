"""The language of condition cells: parses a text into the values that fit, for how long, and how new. Pure.

A cell becomes intervals of numbers and a set of texts. From these follow whether a value fits, by how much it misses,
and whether any value could fit.
"""

import re
from collections.abc import Iterator
from math import inf, isfinite, isnan, nextafter
from typing import NamedTuple

Value = float | str
FULL_TURN = 360.0
LONGEST = 300
DEEPEST = 20
_TOKEN = re.compile(
    r"""\s*(?:
        (?P<number>[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?(?![\w.]))
      | (?P<about>±|\+/-|\+-)
      | (?P<op><=|>=|==|!=|<>|≤|≥|≠|<|>|=)
      | (?P<mark>[:()])
      | "(?P<quoted>[^"]*)"
      | (?P<word>[^\s<>=!():"±≤≥≠]+)
    )""",
    re.VERBOSE,
)
_SPELT = {"≤": "<=", "≥": ">=", "≠": "!=", "<>": "!=", "=": "=="}
_TRUE, _FALSE = frozenset({"true", "yes", "on"}), frozenset({"false", "no", "off"})


class CellError(ValueError):
    """A cell that cannot be parsed; the text names the cure."""


class Texts(NamedTuple):
    """Texts: those `of` the set, or all others."""

    of: frozenset[str]
    others: bool = False

    def has(self, text: str) -> bool:
        """Return whether the set holds a text."""
        return (text in self.of) is not self.others

    def either(self, second: "Texts") -> "Texts":
        """Return the union of two sets."""
        if self.others and second.others:
            return Texts(self.of & second.of, True)
        if self.others or second.others:
            without, those = (self, second) if self.others else (second, self)
            return Texts(without.of - those.of, True)
        return Texts(self.of | second.of)

    def both(self, second: "Texts") -> "Texts":
        """Return the intersection of two sets."""
        found = Texts(self.of, not self.others).either(Texts(second.of, not second.others))
        return Texts(found.of, not found.others)


NO_TEXT, EVERY_TEXT = Texts(frozenset()), Texts(frozenset(), True)


class Fits(NamedTuple):
    """The values that fit: closed intervals of numbers in ascending order, texts, and a missing value if `missing`."""

    numbers: tuple[tuple[float, float], ...] = ()
    texts: Texts = NO_TEXT
    missing: bool = False

    def off(self, value: Value | None, *, turning: bool = False) -> float:
        """Return by how much a value misses: 0 if it fits, infinity without a distance. `turning`: 359 is next to 0."""
        if value is None:
            return 0.0 if self.missing else inf
        if isinstance(value, str):
            return 0.0 if self.texts.has(value) else inf
        least = inf
        for low, high in self.numbers:
            if low <= value <= high:
                return 0.0
            least = min(least, low - value if value < low else value - high)
            if turning:
                least = min(least, (low - value) % FULL_TURN, (value - high) % FULL_TURN)
        return inf if isnan(least) else least  # NaN fits nothing

    def either(self, second: "Fits") -> "Fits":
        """Return the values that fit at least one."""
        return Fits(
            _joined((*self.numbers, *second.numbers)), self.texts.either(second.texts), self.missing or second.missing
        )

    def both(self, second: "Fits") -> "Fits":
        """Return the values that fit both."""
        pairs = (
            (max(low, other_low), min(high, other_high))
            for low, high in self.numbers
            for other_low, other_high in second.numbers
        )
        numbers = _joined(tuple(pair for pair in pairs if pair[0] <= pair[1]))
        return Fits(numbers, self.texts.both(second.texts), self.missing and second.missing)


ANYTHING = Fits(((-inf, inf),), EVERY_TEXT)
MISSING = Fits(missing=True)


class Cell(NamedTuple):
    """A condition on one value.

    - `fits`: the values that meet it.
    - `for_s`: how long the value must fit without a break.
    - `becomes`: true only at the moment at which the value begins to fit.
    - `newest_s`: the greatest age of the value; None: as its key has it.
    """

    text: str
    fits: Fits
    for_s: float = 0.0
    becomes: bool = False
    newest_s: float | None = None


def parse(text: str, *, turning: bool = False) -> Cell:
    """Parse a cell; raise CellError with the cure. `turning`: the value is a direction in degrees."""
    if len(text) > LONGEST:
        raise CellError(f"it has {len(text)} characters, and {LONGEST} are the most")
    reader = _Reader(text, turning)
    becomes = reader.word("becomes")
    fits = reader.either(0)
    for_s = reader.seconds("for")
    newest_s = reader.seconds("newer")
    if reader.peek() is not None:
        raise CellError(f"'{reader.rest()}' is too much: join two conditions by 'and' or 'or', and quote a text")
    return Cell(text.strip(), fits, for_s or 0.0, becomes, newest_s)


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


class _Reader:
    """Reads the tokens of a cell, by recursive descent."""

    def __init__(self, text: str, turning: bool) -> None:
        self._text = text
        self._turning = turning
        self._tokens = list(_tokens(text))
        self._next = 0

    def peek(self) -> _Token | None:
        """Return the next token, None at the end."""
        return self._tokens[self._next] if self._next < len(self._tokens) else None

    def rest(self) -> str:
        """Return the rest of the text."""
        token = self.peek()
        return self._text[token.at :].strip() if token else ""

    def word(self, *words: str) -> bool:
        """Skip the next token if it is one of these words, and return whether it was."""
        token = self.peek()
        if token is None or token.kind not in {"word", "mark", "about"} or token.text.lower() not in words:
            return False
        self._next += 1
        return True

    def seconds(self, word: str) -> float | None:
        """Return the seconds after a word, None without that word."""
        if not self.word(word):
            return None
        self.word("than")
        value = self._number(f"after '{word}' come seconds, such as {word} 2 s")
        if not value >= 0.0:
            raise CellError(f"after '{word}' come seconds from 0 on, not {value:g}")
        self.word("s", "sec", "seconds", "second")
        self.word("old")
        return value

    def either(self, depth: int) -> Fits:
        """Parse conditions joined by `or`."""
        found = self._both(depth)
        while self.word("or"):
            found = found.either(self._both(depth))
        return found

    def _both(self, depth: int) -> Fits:
        found = self._term(depth)
        while self.word("and", "&"):
            found = found.both(self._term(depth))
        return found

    def _term(self, depth: int) -> Fits:
        if self.word("("):
            if depth >= DEEPEST:
                raise CellError(f"more than {DEEPEST} brackets are within each other")
            inner = self.either(depth + 1)
            if not self.word(")"):
                raise CellError("a bracket is not closed")
            return inner
        token = self.peek()
        if token is None:
            raise CellError("a value is missing at its end, such as < 50, 40 ± 1, 85:100 or charging")
        if token.kind == "op":
            self._next += 1
            return self._compared(token.text)
        if token.kind == "number":
            return self._from_number()
        if self.word("missing"):
            return MISSING
        if self.word("known", "any"):
            return ANYTHING
        return _same(self._words())

    def _from_number(self) -> Fits:
        low = self._number("")
        if self.word(":"):
            high = self._number(f"a range has two numbers, such as {low:g}:{low + 10:g}")
            return self._between(low, high)
        if self.word("±", "+-", "+/-"):
            wide = self._number(f"after ± comes by how much, such as {low:g} ± 1")
            if wide < 0.0:
                raise CellError(f"after ± comes a number from 0 on, not {wide:g}")
            return self._around(low, wide)
        return self._around(low, 0.0)

    def _around(self, middle: float, wide: float) -> Fits:
        if not self._turning:
            return Fits(((middle - wide, middle + wide),))
        if wide >= FULL_TURN / 2:
            return Fits(((0.0, FULL_TURN),))
        low, high = (middle - wide) % FULL_TURN, (middle + wide) % FULL_TURN
        return self._between(low, high)

    def _between(self, low: float, high: float) -> Fits:
        if self._turning and not (0.0 <= low <= FULL_TURN and 0.0 <= high <= FULL_TURN):
            low, high = (low % FULL_TURN, high % FULL_TURN) if high - low < FULL_TURN else (0.0, FULL_TURN)
        if low <= high:
            fits = Fits(((low, high),))
        elif self._turning:
            fits = Fits(((0.0, high), (low, FULL_TURN)))
        else:
            raise CellError(f"{low:g}:{high:g} holds for nothing: the lower number comes first, {high:g}:{low:g}")
        if self._turning and fits.off(0.0) * fits.off(FULL_TURN) == 0.0:  # 0 and 360 are one direction
            fits = fits.either(Fits(((0.0, 0.0), (FULL_TURN, FULL_TURN))))
        return fits

    def _compared(self, op: str) -> Fits:
        op = _SPELT.get(op, op)
        token = self.peek()
        if token is None or token.kind not in {"number", "word", "quoted"}:
            raise CellError(f"after '{op}' comes a value, such as {op} 20")
        if token.kind != "number":
            text = self._words()
            if op not in {"==", "!="}:
                raise CellError(f"'{text}' is no number: texts are compared by == and != alone")
            return _same(text) if op == "==" else _all_but(text)
        limit = self._number("")
        below, above = (-inf, nextafter(limit, -inf)), (nextafter(limit, inf), inf)
        by_op = {
            "<": Fits((below,)),
            "<=": Fits(((-inf, limit),)),
            ">": Fits((above,)),
            ">=": Fits(((limit, inf),)),
            "!=": Fits((below, above), EVERY_TEXT),
        }
        return by_op.get(op) or self._around(limit, 0.0)

    def _number(self, wanted: str) -> float:
        token = self.peek()
        if token is None or token.kind != "number":
            raise CellError(wanted)
        self._next += 1
        found = float(token.text)
        if not isfinite(found):
            raise CellError(f"{token.text} is no number that anything could be")
        return found

    def _words(self) -> str:
        """Return a text: quoted, or words up to the next keyword."""
        words: list[str] = []
        while (token := self.peek()) is not None:
            if token.kind == "quoted" and not words:
                self._next += 1
                return token.text
            if token.kind != "word" or (words and token.text.lower() in {"and", "or", "for", "newer", "&"}):
                break
            words.append(token.text)
            self._next += 1
        if not words:
            raise CellError(f"'{self.rest()}' is no condition, such as < 50, 40 ± 1, 85:100 or charging")
        return " ".join(words)


def _tokens(text: str) -> Iterator[_Token]:
    at = 0
    while text[at:].strip():
        match = _TOKEN.match(text, at)
        if match is None:
            raise CellError(f"'{text[at:].strip()[:40]}' cannot be read; quote a text with such characters")
        kind = str(match.lastgroup)
        yield _Token(kind, match.group(kind), match.start(kind))
        at = match.end()


def _same(text: str) -> Fits:
    """Return the values equal to a text; true and false are 1 and 0, too."""
    low = text.lower()
    number = 1.0 if low in _TRUE else 0.0 if low in _FALSE else None
    numbers = () if number is None else ((number, number),)
    return Fits(numbers, Texts(frozenset({text})))


def _all_but(text: str) -> Fits:
    same = _same(text)
    numbers = ((-inf, inf),)
    if same.numbers:
        number = same.numbers[0][0]
        numbers = ((-inf, nextafter(number, -inf)), (nextafter(number, inf), inf))  # type: ignore[assignment]
    return Fits(numbers, Texts(same.texts.of, True))


def _joined(intervals: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """Merge intervals that touch; return them in ascending order."""
    joined: list[tuple[float, float]] = []
    for low, high in sorted(intervals):
        if joined and low <= nextafter(joined[-1][1], inf):
            joined[-1] = (joined[-1][0], max(joined[-1][1], high))
        else:
            joined.append((low, high))
    return tuple(joined)
