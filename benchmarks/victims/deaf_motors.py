"""A motor driver broken on purpose: what it was told once holds until it is told otherwise."""

from dataclasses import replace

from lbr.drivers import roboteq
from lbr.drivers.roboteq.arming import Arming
from lbr.drivers.roboteq.capability import Roboteq
from lbr.drivers.roboteq.controller import Controller


class DeafMotors(Roboteq):
    def _decide(self, controller: Controller) -> None:
        kept = self._arming.setpoint
        super()._decide(controller)
        if self._arming.setpoint is None and kept is not None:
            self._arming = Arming(setpoint=kept)


KIND = replace(roboteq.KIND, name="deaf_motors", entry=DeafMotors)
