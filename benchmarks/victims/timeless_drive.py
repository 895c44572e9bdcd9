"""Drive operations broken on purpose: a lease never lapses."""

import dataclasses
from math import inf

from msgspec.structs import replace

from lbr.operations import drive
from lbr.operations.drive.capability import Drive


class TimelessDrive(Drive):
    def step(self) -> None:
        hold = self._state.hold
        if hold is not None:
            self._state = replace(self._state, hold=replace(hold, expires=inf))
        super().step()


KIND = dataclasses.replace(drive.KIND, name="timeless_drive", entry=TimelessDrive)
