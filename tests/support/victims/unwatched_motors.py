"""A motor driver broken on purpose: the controller's own watchdog is off."""

from dataclasses import replace
from typing import Any

from lbr.drivers import roboteq
from lbr.drivers.roboteq import capability
from lbr.drivers.roboteq.capability import Roboteq
from lbr.drivers.roboteq.controller import Controller


class Unwatched(Controller):
    def _insist(self, line: bytes, *rest: Any) -> None:
        super()._insist(line.replace(b"200", b"0") if b"RWD" in line else line, *rest)

    def _verify(self, name: str, *rest: Any) -> None:
        if name != "RWD":
            super()._verify(name, *rest)

    def _note_watchdog(self) -> None:
        return


class UnwatchedMotors(Roboteq):
    def open(self) -> None:
        capability.Controller = Unwatched
        super().open()


KIND = replace(roboteq.KIND, name="unwatched_motors", entry=UnwatchedMotors)
