"""The life of a code that gives a phone access: drawn for a person at the console, valid for two minutes.

It gives one token, and ends after five wrong tries in all. Pure: clock and random numbers are injected.
"""

import hmac
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable

from msgspec import Struct

from lbr.messages.pairing import DIGITS
from lbr.messages.system import Role

GOOD_FOR_S = 120.0
"""Time to pick up a phone, scan the code, and read its browser's warning."""
WRONG_TRIES = 5
"""A person mistypes twice; with five tries in all, the chance to guess a code is one in 200,000."""
MOST_ADDRESSES = 256
"""The number of addresses whose wrong tries are counted; the one with the oldest wrong try makes room."""


class Code(Struct, frozen=True, kw_only=True):
    """The digits that a person was given, the role that they give, who requested them, and when they expire."""

    digits: str
    role: Role
    by: str
    ends_s: float


class Try(Struct, frozen=True, kw_only=True):
    """The result of a try: `code` if it was right.

    `tries_left` are the wrong tries that the code still permits, None without a code. `from_there` counts the wrong
    tries of that address since the robot started.
    """

    code: Code | None = None
    tries_left: int | None = None
    from_there: int = 0


def boot_s() -> float:
    """Return a time that goes on while the machine sleeps, and that setting the clock does not change."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def drawn() -> str:
    """Return six random digits, each equally likely."""
    return f"{secrets.randbelow(10**DIGITS):0{DIGITS}d}"


class Pairing:
    """Holds at most one code, only in memory.

    The code ends with its time, its use, its last wrong try, the next code, or the robot's process.
    """

    def __init__(self, clock: Callable[[], float] = boot_s, draw: Callable[[], str] = drawn) -> None:
        self._clock = clock
        self._draw = draw
        self._code: Code | None = None
        self._wrong = 0
        self._wrong_from: OrderedDict[str, int] = OrderedDict()

    def begin(self, role: Role, by: str) -> Code:
        """Return a new code; the previous one ends."""
        self._wrong = 0
        self._code = Code(digits=self._draw(), role=role, by=by, ends_s=self._clock() + GOOD_FOR_S)
        return self._code

    def cancel(self) -> bool:
        """End the code; return whether there was one."""
        code, self._code = self._living(), None
        return code is not None

    def attempt(self, digits: str, address: str) -> Try:
        """Compare digits, in constant time, and count the try; the right ones use the code up."""
        code = self._living()
        right = hmac.compare_digest(digits.encode(), (code.digits if code else "-" * DIGITS).encode())
        if code is not None and right:
            self._code = None
            return Try(code=code)
        from_there = self._wrong_from.pop(address, 0) + 1
        self._wrong_from[address] = from_there
        while len(self._wrong_from) > MOST_ADDRESSES:
            self._wrong_from.popitem(last=False)
        if code is None:
            return Try(from_there=from_there)
        self._wrong += 1
        left = WRONG_TRIES - self._wrong
        if left <= 0:
            self._code = None
        return Try(tries_left=left, from_there=from_there)

    def _living(self) -> Code | None:
        if self._code is not None and self._clock() >= self._code.ends_s:
            self._code = None
        return self._code
