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
from tests.support.waiting import HANG_S


class Pty:
    """A pty under a stable symlink; `replug` gives it a new pts behind the same name."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.plug()

    def plug(self) -> None:
        master, keeper = pty.openpty()
        tty.setraw(keeper)
        os.set_blocking(master, False)  # before a thread sees it: it must not wait there
        self.master, self.keeper = master, keeper
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


class RoboteqScript:
    """Answers as the controller does, and misbehaves when told to."""

    def __init__(self) -> None:
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
        self.reads, self.unread = True, b""
        self.deaf_to_settings = False
        self.echo_always: bool | None = None
        self.answer: Callable[[str], bytes | None] = lambda _line: None  # None: as usual
        self._buffer = b""

    def motor_commands(self) -> list[str]:
        return [line for line in self.log if line.startswith("!")]

    def poll(self, _now: float) -> bytes:
        return b""

    def feed(self, data: bytes, now: float) -> bytes:
        """Return what is answered to the lines that are whole."""
        if not self.reads:
            self.unread += data
            return b""
        *lines, self._buffer = (self._buffer + data).split(b"\r")
        answers = b""
        for line in lines:
            text = line.decode("ascii", "replace")
            self.log.append(text)
            self.times.append(now)
            echo = self.settings["ECHOF"] == 0 if self.echo_always is None else self.echo_always
            answer = self.answer(text)
            answers += (line + b"\r" if echo else b"") + self._reply(text) if answer is None else answer
        return answers

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


class ScriptedRoboteq(RoboteqScript, Pty):
    """That controller at the end of a line; a thread answers."""

    def __init__(self, path: Path) -> None:
        RoboteqScript.__init__(self)
        Pty.__init__(self, path)
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        self._begin(self._serve)

    def babble(self, noise: bytes) -> None:
        """Talk without end, as fast as the line takes it, and answer nothing; still hear everything."""
        self.answer = lambda _line: b""
        self._begin(self._babble, noise)

    def finish(self) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join()
        super().finish()

    def _begin(self, work: Callable[..., None], *args: Any) -> None:
        self._threads.append(threading.Thread(target=work, args=args, daemon=True))
        self._threads[-1].start()

    def _serve(self) -> None:
        while not self._stop.wait(0.001):
            with suppress(OSError, ValueError):  # it was unplugged
                while select.select([self.master], [], [], 0.005)[0]:
                    os.write(self.master, self.feed(os.read(self.master, 4096), time.monotonic()))

    def _babble(self, noise: bytes) -> None:
        while not self._stop.is_set():
            with suppress(BlockingIOError):
                if select.select([], [self.master], [], 0.005)[1]:
                    os.write(self.master, noise)


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
