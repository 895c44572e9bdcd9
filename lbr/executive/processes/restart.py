"""The restart of a process that ended, as an ordered list of decisions without a clock of its own."""

import signal
from enum import Enum
from typing import Literal

from msgspec import Struct

from lbr.messages.codes import Code

FIRST_S = 0.1
MOST_S = 5.0
WINDOW_S = 30.0
ATTEMPTS = 5
HEALTHY_S = 60.0
JITTER = 0.2
NOT_STARTED = {
    126: "its program may not be executed: 'chmod +x' it; a script begins with #! and what runs it",
    127: "there is no such program, or what its first line names after #! is not there",
}
UNSEEN = 256
"""The exit code for an end that nobody saw, because the fork server had ended before; no process ends with it."""


class End(Enum):
    """The end of a process."""

    CLEAN = "ended"
    CRASHED = "crashed"
    HUNG = "hung"
    TAKEN = "taken_along"


CODES: dict[End, Code] = {End.CLEAN: "done", End.CRASHED: "failed", End.HUNG: "timeout", End.TAKEN: "failed"}
"""The reason, by the list of codes, that a process is down after such an end."""


class Decision(Struct, frozen=True):
    """Restart after `delay_s` (`restart`), stay down (`stopped`), or give up (`failed`), with the reason."""

    phase: Literal["restart", "stopped", "failed"]
    delay_s: float = 0.0
    reason: str = ""


def decide(policy: str, end: End, deaths: tuple[float, ...], now: float, jitter: float) -> Decision:
    """Decide what follows an end. `deaths` are earlier ends within the window, `jitter` is -1 to 1.

    0. A fault of a neighbour ended the process that they share: restart at once.
    1. Policy `never`: it stays down. 2. Policy `on-failure` and a clean end: it stays down. 3. More than five ends
    within 30 s: give up until an operator acts. 4. Otherwise restart after 0.1 s, doubled for each recent end, at most
    5 s, 20 % jitter either way. A minute of health forgets the past (the caller drops old deaths).
    """
    if end is End.TAKEN:
        return Decision("restart", FIRST_S)
    if policy == "never":
        return Decision("stopped" if end is End.CLEAN else "failed", reason="its restart policy is 'never'")
    if policy == "on-failure" and end is End.CLEAN:
        return Decision("stopped", reason="it ended by itself")
    recent = [death for death in deaths if now - death < WINDOW_S]
    if len(recent) >= ATTEMPTS:
        return Decision("failed", reason=f"{end.value} {len(recent) + 1} times within {WINDOW_S:.0f} s; given up")
    delay = min(FIRST_S * 2 ** len(recent), MOST_S)
    return Decision("restart", delay * (1 + JITTER * jitter))


def ended_by(code: int, *, program: bool) -> str:
    """Return the meaning of an exit code, below 0 a signal; `program`: it may end by itself."""
    if code == 0 and not program:
        return "ended by a signal that the robot did not send"
    if program and code in NOT_STARTED:
        return NOT_STARTED[code]
    if code == UNSEEN:
        return "ended; how is not known, because the server that had forked it was gone"
    return f"killed by {_signal(-code)}" if code < 0 else f"exit code {code}"


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
