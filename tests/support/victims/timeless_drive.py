"""Drive operations broken on purpose: a lease never lapses."""

import dataclasses
from math import inf

from msgspec.structs import replace

from lbr.operations import drive
from lbr.operations.drive.capability import Drive


class TimelessDrive(Drive):
    def step(self) -> None:
        leases = self._state.leases
        if leases.live is not None:
            leases = replace(leases, live=replace(leases.live, expires=inf))
            self._state = replace(self._state, leases=leases)
        super().step()


KIND = dataclasses.replace(drive.KIND, name="timeless_drive", entry=TimelessDrive)
