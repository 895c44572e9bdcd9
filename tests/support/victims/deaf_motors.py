"""A motor driver broken on purpose: once it moves, neither time nor a zero nor a silent sender stops it."""

from dataclasses import replace

from lbr.drivers import roboteq
from lbr.drivers.roboteq.capability import Roboteq
from lbr.drivers.roboteq.controller import Controller


class DeafMotors(Roboteq):
    def _decide(self, controller: Controller) -> None:
        kept = self._arming
        super()._decide(controller)
        if kept.moving and not self._arming.moving:
            self._arming = kept


KIND = replace(roboteq.KIND, name="deaf_motors", entry=DeafMotors)
