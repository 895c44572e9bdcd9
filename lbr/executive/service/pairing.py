"""The life of a code that lets a phone in: drawn for a person at the console, good for two minutes, for one token and
five wrong tries in all. Pure: clock and chance come from outside."""

import hmac
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable

from msgspec import Struct

from lbr.messages.pairing import DIGITS
from lbr.messages.system import Role

GOOD_FOR_S = 120.0
"""Time to pick a phone up, scan, and wait for its browser's warning."""
WRONG_TRIES = 5
"""A person mistypes twice; by guessing, five tries in all are one code in 200,000."""
MOST_ADDRESSES = 256
"""Remembered with how often they were wrong; the one that was wrong longest ago makes room."""


class Code(Struct, frozen=True, kw_only=True):
    """The digits that a person was told, what they give, who asked for them, and when they end."""

    digits: str
    role: Role
    by: str
    ends_s: float


class Try(Struct, frozen=True, kw_only=True):
    """The result of a try: `code` if it was right. `tries_left` are the wrong tries that the code still bears, None without a
    code; `from_there` is how often that address was wrong since the robot started."""

    code: Code | None = None
    tries_left: int | None = None
    from_there: int = 0


def boot_s() -> float:
    """Return a time that goes on while the machine sleeps, and that no setting of the clock changes."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


def drawn() -> str:
    """Return six digits by chance, each as likely as any other."""
    return f"{secrets.randbelow(10**DIGITS):0{DIGITS}d}"


class Pairing:
    """Holds one code at most, in memory alone: it is over with its time, its use, its wrong tries, the next code, and
    the end of the robot's process."""

    def __init__(self, clock: Callable[[], float] = boot_s, draw: Callable[[], str] = drawn) -> None:
        self._clock = clock
        self._draw = draw
        self._code: Code | None = None
        self._wrong = 0
        self._wrong_from: OrderedDict[str, int] = OrderedDict()

    def begin(self, role: Role, by: str) -> Code:
        """Return a new code; the one before is over."""
        self._wrong = 0
        self._code = Code(digits=self._draw(), role=role, by=by, ends_s=self._clock() + GOOD_FOR_S)
        return self._code

    def cancel(self) -> bool:
        """End the code; say whether there was one."""
        code, self._code = self._living(), None
        return code is not None

    def attempt(self, digits: str, address: str) -> Try:
        """Compare digits, in the same time whatever they are, and count; right ones use the code up."""
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
