"""The process around the reckoning: it adds arrivals, and publishes the result after each state of the motors."""

import secrets

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.messages.codes import Reason
from lbr.messages.kinematics import Kinematics, Wheel, base_of
from lbr.operations.odometry import OdometrySettings
from lbr.operations.odometry.reckoning import Reckoning

SILENT_PERIOD_S, SOON_S = 0.5, 0.01


class Odometry(Capability[OdometrySettings]):
    """Publishes odometry after each state of the motors."""

    woken_by_streams = frozenset({"motors"})

    def __init__(self, ctx: Context[OdometrySettings]) -> None:
        super().__init__(ctx)
        self._base = base_of(ctx.rows(Kinematics), ctx.rows(Wheel), ctx.settings.track_m)
        self._reckoning = self._fresh()
        self._published_s = 0.0

    def open(self) -> None:
        """Start to count from zero."""
        self._reckoning = self._fresh()
        self._publish()

    def step(self) -> None:
        """Process arrived messages, and publish."""
        for received in self.ctx.take("attitude"):
            self._reckoning.look(received.message)
        arrived = self.ctx.take("motors")
        for received in arrived:
            self._reckoning.count(received.message, received.arrived)
        now = self.ctx.clock()
        self._reckoning.silence(now)
        if arrived or now - self._published_s >= SILENT_PERIOD_S:
            self._publish()
        self.rate_hz = 1.0 / max(self._published_s + SILENT_PERIOD_S - now, SOON_S)

    def lacks(self) -> Reason | None:
        """Return that the motors have reported nothing yet, or None."""
        return self.awaited("motors")

    def _fresh(self) -> Reckoning:
        return Reckoning(self.ctx.settings, secrets.token_hex(3), self._base)

    def _publish(self) -> None:
        self._published_s = self.ctx.clock()
        self.ctx.publish("state", self._reckoning.state())
