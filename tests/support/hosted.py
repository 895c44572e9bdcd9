"""Things on a tty outside the robot: an emulated controller whose every byte is kept, a chatterer, a locked port."""

import os
import select
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Self

import serial

from lbr.simulation.devices.roboteq.device import RoboteqDevice
from lbr.simulation.port import PtyPort

GREETING = b"NMEA $GPGGA,,,,,0,,,,,,,,*66\r\n"


class OnTty(ABC):
    """Something on a tty at `path` that a thread serves: `answer(bytes, now)` returns what is said back."""

    def __init__(self, path: Path, answer: Callable[[bytes, float], bytes]) -> None:
        self._answer = answer
        self._port = PtyPort(path)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Self:
        self._port.plug()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._port.unplug()

    @abstractmethod
    def _serve(self) -> None:
        """Answer until it is over."""


class Hosted(OnTty):
    """A tty that answers, and keeps what it heard."""

    def __init__(self, path: Path, answer: Callable[[bytes, float], bytes]) -> None:
        super().__init__(path, answer)
        self.heard = bytearray()

    def _serve(self) -> None:
        while not self._over.is_set():
            select.select([self._port.fileno()], [], [], 0.001)
            data = self._port.read()
            self.heard += data
            said = self._answer(data, time.monotonic())
            if said:
                self._port.write(said)


def controller(path: Path) -> Hosted:
    """An emulated motor controller."""
    device = RoboteqDevice()
    return Hosted(path, lambda data, now: device.feed(data, now) if data else device.poll(now))


def chatterer(path: Path) -> Hosted:
    """Something else, which talks whatever it is told."""
    return Hosted(path, lambda data, _now: GREETING if data else b"")


class Locked:
    """A tty that another process already has."""

    def __init__(self, path: Path) -> None:
        self._port = PtyPort(path)
        self._owner: serial.Serial | None = None

    def __enter__(self) -> Self:
        self._port.plug()
        self._owner = serial.Serial(os.path.realpath(self._port.path), exclusive=True)
        return self

    def __exit__(self, *_: object) -> None:
        if self._owner is not None:
            self._owner.close()
        self._port.unplug()
