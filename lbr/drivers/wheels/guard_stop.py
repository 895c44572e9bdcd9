"""The guard's program: waits until the driver dies or falls silent while a motor turns, then writes the stop.

Imports little, and is run by path, without installed packages: `guard_stop.py LINE_FD PIPE_FD DRIVER_PIDFD SILENCE_MS
STOP_HEX ACKNOWLEDGED_HEX [WORDS_FD WORDS_HEX]`. `-` for an acknowledgement: the controller sends none. See
`lbr.drivers.watch` for the driver's messages. Before the guard ends a silent driver it writes the words to WORDS_FD.
"""

import os
import select
import sys
import termios
import time
from contextlib import suppress

if __name__ == "__main__":  # the package of all drivers would import much
    sys.path.append(os.path.abspath(f"{__file__}/../.."))  # noqa: PTH100  importing pathlib takes too long
    from watch import outlast  # type: ignore[import-not-found]
else:
    from lbr.drivers.watch import outlast

TRIES = 10
AT_LEAST = 2  # the first may end a half-written line of the driver, and be refused with it
ANSWER_S = 0.03
KEPT_BYTES = 256


def main(
    line: int,
    pipe: int,
    driver: int,
    silence_ms: int,
    stop: bytes,
    acknowledged: bytes,
    words_fd: int = -1,
    words: bytes = b"",
) -> None:
    """Return when dismissed; otherwise stop the motors first."""
    if not outlast(pipe, driver, silence_ms, words_fd, words):
        return
    for attempt in range(1, TRIES + 1):
        if stopped(line, stop, acknowledged) and attempt >= AT_LEAST:
            return
    with suppress(OSError, termios.error):
        termios.tcflush(line, termios.TCOFLUSH)  # closing a line waits for its output, for half a minute


def stopped(line: int, stop: bytes, acknowledged: bytes) -> bool:
    """Write the stop; return whether it was acknowledged. Continuous input does not extend the wait."""
    answer = b""
    until = time.monotonic() + ANSWER_S
    with suppress(OSError, termios.error):  # only a tty has queues to drop
        termios.tcflush(line, termios.TCIOFLUSH)
    with suppress(OSError):
        os.write(line, stop)
        while not is_acknowledged(answer, acknowledged) and (left_s := until - time.monotonic()) > 0.0:
            if select.select([line], [], [], left_s)[0]:
                answer = (answer + os.read(line, KEPT_BYTES))[-KEPT_BYTES:]
    return is_acknowledged(answer, acknowledged)


def is_acknowledged(answer: bytes, acknowledged: bytes) -> bool:
    """Return whether an answer has the acknowledgement; always False for a controller that sends none."""
    return bool(acknowledged) and acknowledged in answer


if __name__ == "__main__":
    line_fd, pipe_fd, driver_fd, limit_ms = (int(word) for word in sys.argv[1:5])
    stop_hex, answer_hex = sys.argv[5:7]
    last = (int(sys.argv[7]), bytes.fromhex(sys.argv[8])) if len(sys.argv) > 8 else (-1, b"")
    sure = b"" if answer_hex == "-" else bytes.fromhex(answer_hex)
    main(line_fd, pipe_fd, driver_fd, limit_ms, bytes.fromhex(stop_hex), sure, *last)
    os._exit(0)
