"""A motor driver broken on purpose: work in a callback, on the session that hears the emergency stop."""

import time
from dataclasses import replace

from lbr.bus import wire
from lbr.drivers import roboteq
from lbr.drivers.roboteq.capability import Roboteq

WORK_S = 0.05


class LaboriousMotors(Roboteq):
    def open(self) -> None:
        stopping = self.ctx.estop._session
        self._work = wire.Subscription(stopping, f"{self.ctx.robot}/motors/setpoint", wake=lambda: time.sleep(WORK_S))
        super().open()


KIND = replace(roboteq.KIND, name="laborious_motors", entry=LaboriousMotors)
