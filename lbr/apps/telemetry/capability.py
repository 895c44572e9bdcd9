"""Telemetry as a capability: the package at a steady rate."""

import time

from lbr.apps.telemetry import TelemetrySettings
from lbr.apps.telemetry.package import package
from lbr.capability.base import Capability
from lbr.capability.context import Context


class TelemetryPackage(Capability[TelemetrySettings]):
    """Publishes what it knows, also while nobody speaks."""

    def __init__(self, ctx: Context[TelemetrySettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = ctx.settings.rate_hz

    def step(self) -> None:
        """Publish, at the rate and not on every arrival."""
        if self.ctx.on_tick:
            self.ctx.publish("package", package(self.ctx.latest, self.ctx.clock(), time.time()))
