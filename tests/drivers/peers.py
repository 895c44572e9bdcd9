"""What sits at the other end of the wire in these tests: ptys with a scripted controller or a talking board."""

import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from lbr.capability.context import Device
from lbr.capability.kind import Kind
from lbr.capability.tap import Tap
from lbr.messages.system import Stamp
from lbr.testing.driver import RealTimeContext
from tests.support.own_time import own_clock
from tests.support.waiting import HANG_S


class Pty:
    """A pty under a stable symlink; `replug` gives it a new pts behind the same name."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.plug()

    def plug(self) -> None:
        self.master, self.keeper = pty.openpty()
        tty.setraw(self.keeper)
        os.set_blocking(self.master, False)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(self.keeper))

    def unplug(self) -> None:
        self.path.unlink(missing_ok=True)
        os.close(self.keeper)
        os.close(self.master)
        self.master = self.keeper = -1

    def finish(self) -> None:
        if self.master >= 0:
            self.unplug()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_of_error: object) -> None:
        self.finish()

    def waiting(self) -> bytes:
        """Take what came and was not read."""
        try:
            return os.read(self.master, 4096)
        except BlockingIOError:
            return b""


class ScriptedRoboteq(Pty, Tap):
    """Answers as the controller does, and misbehaves when told to.

    As the tap of the driver's line it takes what the driver writes at once, and has its answer lie there before the
    driver reads: the driver gives an answer 5 ms. By `clock` that takes no time, however late the kernel moves the bytes.
    """

    def __init__(self, path: Path) -> None:
        self.settings = {"RWD": 1000, "MXMD": 0, "ECHOF": 0}
        self.answers = {
            "FID": "Roboteq v1.8d SDC2130 01/01/2020",
            "TRN": "SDC21xx:SDC2130",
            "V": "135:126:4730",
            "A": "-51:12",
            "C": "130:-260",
            "T": "30:25:26",
            "FF": "0",
        }
        self.log: list[str] = []
        self.times: list[float] = []
        self.motor = (0, 0)
        self.latched = False
        self.reading = True
        self.deaf_to_settings = False
        self.echo_always: bool | None = None
        self.answer: Callable[[str], bytes | None] = lambda _line: None  # None: as usual
        self._buffer = b""
        self._own_clock = own_clock()
        self._took_s = 0.0
        self._stop = threading.Event()
        self._babbler: threading.Thread | None = None
        self._server: threading.Thread | None = None
        Tap.__init__(self)
        Pty.__init__(self, path)

    def motor_commands(self) -> list[str]:
        return [line for line in self.log if line.startswith("!")]

    def babble(self, noise: bytes) -> None:
        """Talk without end, as fast as the line takes it, and answer nothing; still hear everything."""
        self.answer = lambda _line: b""
        self._babbler = threading.Thread(target=self._babble, args=(noise,), daemon=True)
        self._babbler.start()

    def finish(self) -> None:
        self._stop.set()
        for thread in filter(None, (self._babbler, self._server)):
            thread.join()
        super().finish()

    def serve(self) -> None:
        """Answer in a thread what a driver in another process, or its guard, writes."""
        self._server = threading.Thread(target=self._serve, daemon=True)
        self._server.start()

    def _serve(self) -> None:
        while not self._stop.wait(0.001):
            with suppress(OSError, ValueError):  # it was unplugged
                while self.reading and select.select([self.master], [], [], 0.005)[0]:
                    self._hear(os.read(self.master, 4096))

    def sent(self, data: bytes) -> None:
        super().sent(data)
        began = self._own_clock()
        left = len(data)
        while left and self.reading and select.select([self.master], [], [], HANG_S)[0]:
            came = os.read(self.master, left)
            left -= len(came)
            if self._hear(came):
                select.select([self.keeper], [], [], HANG_S)
        self._took_s += self._own_clock() - began

    def clock(self) -> float:
        return self._own_clock() - self._took_s

    def _babble(self, noise: bytes) -> None:
        while not self._stop.is_set():
            with suppress(BlockingIOError):
                if select.select([], [self.master], [], 0.005)[1]:
                    os.write(self.master, noise)

    def _hear(self, data: bytes) -> bool:
        """Answer what is a whole line; say whether there was anything to say."""
        answered = False
        self._buffer += data
        *lines, self._buffer = self._buffer.split(b"\r")
        for line in lines:
            text = line.decode("ascii", "replace")
            self.log.append(text)
            self.times.append(time.monotonic())
            echo = self.settings["ECHOF"] == 0 if self.echo_always is None else self.echo_always
            answer = self.answer(text)
            if answer is None:
                answer = (line + b"\r" if echo else b"") + self._reply(text)
            answered |= os.write(self.master, answer) > 0
        return answered

    def _reply(self, text: str) -> bytes:
        sign, word, *rest = text[0], *text[1:].split()
        if sign == "?":
            return f"{word}={self.answers[word]}\r".encode() if word in self.answers else b"-\r"
        if sign == "~":
            return f"{word}={self.settings[word]}\r".encode()
        if sign == "^":
            if not self.deaf_to_settings:
                self.settings[word] = int(rest[0])
            return b"+\r"
        if word == "M":
            self.motor = (int(rest[0]), int(rest[1]))
        elif word in {"EX", "MG"}:
            self.latched = word == "EX"
            self.answers["FF"] = "16" if self.latched else "0"
        return b"+\r"


class Board(Pty):
    """A range board that says what the test writes, and notes what it hears."""

    def say(self, data: bytes) -> None:
        os.write(self.master, data)

    def heard(self) -> bytes:
        """Take what comes next, however late the kernel moves it."""
        assert select.select([self.master], [], [], HANG_S)[0]
        return self.waiting()


class DriverContext(RealTimeContext):
    """The context of a driver on real time, beside a `drive` that lives and is wired to it."""

    def __init__(self, kind: Kind, settings: Any, address: Path | str, type_: str, tap: Tap | None = None) -> None:
        device = Device(settings.device, type_, str(address), {}, tap or Tap())
        super().__init__(kind, settings, robot="tester", device=device)
        self.wired["setpoint"] = ("drive",)

    def give(self, message: Any, *, source: str = "drive", stamp: Stamp | None = None) -> None:
        self.arrive("setpoint", message, source=source, stamp=stamp)

    @property
    def state(self) -> Any:
        return self.published[-1][1]

    def kinds(self) -> list[str]:
        return [kind for kind, _ in self.events]
