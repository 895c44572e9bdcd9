"""Drive operations broken on purpose: a lease never lapses."""

import dataclasses
from math import inf

from msgspec.structs import replace

from lbr.operations import drive
from lbr.operations.drive.capability import Drive


class TimelessDrive(Drive):
    def step(self) -> None:
        holding = self._state.holding
        if holding.hold is not None:
            holding = replace(holding, hold=replace(holding.hold, expires=inf))
            self._state = replace(self._state, holding=holding)
        super().step()


KIND = dataclasses.replace(drive.KIND, name="timeless_drive", entry=TimelessDrive)
