"""A program on a pseudo-terminal that is its controlling one, as a person would run it."""

import fcntl
import os
import select
import struct
import sys
import termios
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from tests.support import programs
from tests.support.robot import environment
from tests.support.waiting import HANG_S

WHERE_IS_THE_CURSOR, CURSOR_IS_HERE = b"\x1b[6n", b"\x1b[1;1R"
TAKE_TERMINAL = "import fcntl,os,sys,termios; fcntl.ioctl(0,termios.TIOCSCTTY,0); os.execv(sys.argv[1],sys.argv[1:])"


class OnTerminal:
    """The program, and the person's end of its terminal."""

    def __init__(self, home: Path, argv: Sequence[str], *, answers: bool = True) -> None:
        self.said = bytearray()
        self._answers = answers
        self._asked_from = 0
        self._reading = threading.Event()
        self._reading.set()
        self._master, slave = os.openpty()
        self.popen = programs.start(
            [sys.executable, "-c", TAKE_TERMINAL, *argv],
            env=environment(home) | {"TERM": "xterm"},
            stdin=slave,
            stdout=slave,
            stderr=slave,
            start_new_session=True,
        )
        os.close(slave)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def wait_for(self, text: bytes, limit_s: float = HANG_S, *, start: int = 0) -> None:
        """Wait until the program has shown this, beyond its first `start` bytes."""
        end = time.monotonic() + limit_s
        while self.said.find(text, start) < 0:
            if time.monotonic() > end or self.popen.poll() is not None:
                raise AssertionError(f"the terminal never showed {text!r}: {bytes(self.said[-500:])!r}")
            select.select([], [], [], 0.02)

    def type(self, keys: bytes) -> None:
        """Type keys."""
        os.write(self._master, keys)

    def freeze(self) -> None:
        """Read no more of what the program shows, as a frozen terminal does; what is typed still arrives."""
        self._reading.clear()

    def thaw(self) -> None:
        """Read on."""
        self._reading.set()

    @property
    def unread(self) -> int:
        """Return how much of what was shown waits to be read."""
        return struct.unpack("i", fcntl.ioctl(self._master, termios.FIONREAD, b"\0" * 4))[0]  # type: ignore[no-any-return]

    def hang_up(self) -> None:
        """Close the terminal, as when its window is closed or the line is cut."""
        master, self._master = self._master, -1
        with suppress(OSError):
            os.close(master)

    def end(self) -> None:
        """Let no process be left."""
        if self.popen.poll() is None:
            self.popen.kill()
        self.popen.wait()
        self.thaw()
        if self._master >= 0:
            self.hang_up()

    def _read(self) -> None:
        while self._master >= 0:
            try:
                ready, _, _ = select.select([self._master], [], [], 0.1)
                self._reading.wait()
                if ready:
                    self.said += os.read(self._master, 4096)
                    self._answer()
            except (OSError, ValueError):
                return

    def _answer(self) -> None:
        """Answer each question once all of it has been read."""
        while self._answers and (asked := self.said.find(WHERE_IS_THE_CURSOR, self._asked_from)) >= 0:
            self._asked_from = asked + len(WHERE_IS_THE_CURSOR)
            os.write(self._master, CURSOR_IS_HERE)
