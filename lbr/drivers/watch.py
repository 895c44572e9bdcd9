"""The start of every guard process: waiting until its driver dies, or falls silent while something may move.

The driver writes `m` to the pipe while something may move, `z` while nothing does, and `q` to dismiss. Imports little:
guards that run without the project use it.
"""

import os
import select
import signal
from contextlib import suppress

TURNING, RESTING, DISMISSED = b"m", b"z", b"q"


def outlast(pipe: int, driver: int, silence_ms: int, words_fd: int, words: bytes) -> bool:
    """Return False when dismissed, True when the driver is dead; kill a hung driver after writing `words`."""
    return outlasted(pipe, driver, silence_ms, words_fd, words) != DISMISSED


def outlasted(pipe: int, driver: int, silence_ms: int, words_fd: int, words: bytes) -> bytes:
    """Return `q` when dismissed; when the driver is dead, its last beat: `m` or `z`. See `outlast`."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    end, state = _watched(pipe, silence_ms)
    if end == TURNING:
        with suppress(OSError):
            os.write(words_fd, words)
        with suppress(OSError):
            signal.pidfd_send_signal(driver, signal.SIGKILL)
    return end or state


def watch(pipe: int, silence_ms: int) -> bytes:
    """Return `q` when dismissed, nothing when the driver is dead, `m` when it is silent while something may move."""
    return _watched(pipe, silence_ms)[0]


def _watched(pipe: int, silence_ms: int) -> tuple[bytes, bytes]:
    """Return the result of `watch`, and the last beat."""
    poll = select.poll()
    poll.register(pipe, select.POLLIN)
    state = RESTING
    while poll.poll(silence_ms if state == TURNING else None):
        heard = os.read(pipe, 4096)
        if not heard or DISMISSED in heard:
            return heard and DISMISSED, state
        state = heard[-1:]
    return state, state
