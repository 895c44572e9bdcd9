"""The guard's program: waits until the driver dies or falls silent while a motor turns, then writes zero. Imports little.

Run by path, without what is installed: `zero_on_death.py TTY_FD PIPE_FD DRIVER_PIDFD SILENCE_MS STOP_HEX [WORDS_FD WORDS_HEX]`.
See `lbr.drivers.watch` for what the driver says. Before the guard ends a silent driver it writes the words to their
descriptor.
"""

import os
import select
import sys
import termios
import time
from contextlib import suppress

if __name__ == "__main__":
    sys.path.insert(0, os.path.abspath(f"{__file__}/../../../.."))  # noqa: PTH100  importing pathlib takes too long

from lbr.drivers.watch import outlast

TRIES = 10
AT_LEAST = 2  # the first may end a line that the driver left half written, and be refused with it
ANSWER_S = 0.03


def main(
    tty: int, pipe: int, driver: int, silence_ms: int, stop: bytes, words_fd: int = -1, words: bytes = b""
) -> None:
    """Return when dismissed; otherwise stop the motors first."""
    if not outlast(pipe, driver, silence_ms, words_fd, words):
        return
    for attempt in range(1, TRIES + 1):
        if stopped(tty, stop) and attempt >= AT_LEAST:
            return
    with suppress(OSError, termios.error):
        termios.tcflush(tty, termios.TCOFLUSH)  # closing a line waits for its output, for half a minute


def stopped(tty: int, stop: bytes) -> bool:
    """Write zero and say whether it was acknowledged; a line that never falls silent is not waited for."""
    answer = b""
    until = time.monotonic() + ANSWER_S
    with suppress(OSError, termios.error):
        termios.tcflush(tty, termios.TCIOFLUSH)
        os.write(tty, stop)
        while b"+\r" not in answer and (left_s := until - time.monotonic()) > 0.0:
            if select.select([tty], [], [], left_s)[0]:
                answer = (answer + os.read(tty, 256))[-256:]
    return b"+\r" in answer


if __name__ == "__main__":
    tty_fd, pipe_fd, driver_fd, limit_ms = (int(word) for word in sys.argv[1:5])
    last = (int(sys.argv[6]), bytes.fromhex(sys.argv[7])) if len(sys.argv) > 7 else (-1, b"")
    main(tty_fd, pipe_fd, driver_fd, limit_ms, bytes.fromhex(sys.argv[5]), *last)
    os._exit(0)
