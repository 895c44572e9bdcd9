"""Telemetry as a capability: publishes the package at a steady rate."""

import time
from math import inf

from msgspec import structs

from lbr.apps.telemetry.kind import KIND, TelemetrySettings
from lbr.apps.telemetry.package import is_complete, package
from lbr.capability.base import Capability
from lbr.capability.context import Context, Received

COMPASS_S = 0.5
"""The age up to which a compass value counts; a compass measures less often than the rest of an inertial unit."""
RESTING_S = 0.95
"""The period while the motors stand and the package is complete, if the row has a shorter one."""


class TelemetryPackage(Capability[TelemetrySettings]):
    """Publishes the package, even while no source publishes."""

    woken_by_streams = False

    def __init__(self, ctx: Context[TelemetrySettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz
        self._compass: Received | None = None
        self._published_s, self._complete = -inf, False
        self._wired = [port for port in KIND.inputs if ctx.sources(port)]

    def step(self) -> None:
        """Publish at the set rate, and once a second while the motors stand."""
        now = self.ctx.clock()
        if not self.ctx.on_tick or (self._complete and self._stands() and now - self._published_s < RESTING_S):
            return
        self._published_s = now
        for sample in self.ctx.take("imu"):
            self._compass = sample if sample.message.mag_ut is not None else self._compass
        made = package(self._newest, now, time.time())
        self._complete = is_complete(self._newest, self._wired)
        self.ctx.publish("package", structs.replace(made, complete=self._complete))

    def _stands(self) -> bool:
        motors = self.ctx.latest("motors")
        if motors is None:
            return False
        sides, each = (motors.message.left, motors.message.right), motors.message.motors.values()
        return not any((*sides, *(motor.power for motor in each)))

    def _newest(self, port: str) -> Received | None:
        """Return the newest message of a source; the inertial unit's with the last value of its slower compass."""
        newest, compass = self.ctx.latest(port), self._compass
        if port != "imu" or newest is None or compass is None or not newest.message.valid:
            return newest
        if newest.message.mag_ut is not None or newest.arrived - compass.arrived > COMPASS_S:
            return newest
        sample = structs.replace(newest.message, mag_ut=compass.message.mag_ut)
        return structs.replace(newest, message=sample)
