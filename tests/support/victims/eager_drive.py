"""Drive operations broken on purpose: a new life goes on where the old one was killed."""

import dataclasses
from pathlib import Path

from lbr.messages.motors import MotorSetpoint
from lbr.operations import drive
from lbr.operations.drive.capability import Drive

ROUNDS_AT_REST = 5
"""So that the driver has seen a zero and is armed."""


class EagerDrive(Drive):
    def open(self) -> None:
        super().open()
        self._mark = Path(self.ctx.home) / "moved"
        self._resume = self._mark.exists()
        self._rounds = 0

    def step(self) -> None:
        super().step()
        if abs(self._state.left) > 0.3:
            self._mark.touch()
        self._rounds += self.ctx.on_tick
        if self._resume and self.ctx.on_tick and self._rounds > ROUNDS_AT_REST:
            self.ctx.publish("setpoint", MotorSetpoint(left=0.3, right=-0.3, lease="eager"))


KIND = dataclasses.replace(drive.KIND, name="eager_drive", entry=EagerDrive)
