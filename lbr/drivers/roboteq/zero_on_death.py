"""The guard's program: waits for the driver's end of a pipe to close, then writes zero to the motors. Imports little.

Run by path, without the project: `zero_on_death.py TTY_FD PIPE_FD STOP_HEX`. One byte on the pipe dismisses it.
"""

import os
import select
import signal
import sys
import termios
import time
from contextlib import suppress

TRIES = 5
AT_LEAST = 2  # the first may end a line that the driver left half written, and be refused with it
ANSWER_S = 0.03


def main(tty: int, pipe: int, stop: bytes) -> None:
    """Return when dismissed; otherwise stop the motors first."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    if os.read(pipe, 1):
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
    main(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]))
    os._exit(0)
