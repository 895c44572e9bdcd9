"""The battery as a capability: its state, and warnings in words."""

from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.messages.battery import BatteryState
from lbr.messages.speech import SayCommand
from lbr.operations.battery import BatterySettings
from lbr.operations.battery.gauge import Gauge

PUBLISH_S = 0.75
"""The fourth round of 0.2 s comes after this: the sign of life, once a second at least."""
SAY_WITHIN_S = 2.0


class Battery(Capability[BatterySettings]):
    """Publishes changes of level and charging, and once a second at least; without a voltage the state is invalid."""

    rate_hz = 5.0
    woken_by_streams = False

    def __init__(self, ctx: Context[BatterySettings]) -> None:
        super().__init__(ctx)
        self._gauge = Gauge(ctx.settings)
        self._published: BatteryState | None = None
        self._publish_at = -inf
        self._warned_at: dict[str, float] = {}

    def step(self) -> None:
        """Process the measurements, and publish."""
        for received in self.ctx.take("motors"):
            self._gauge.see(received.message, received.arrived)
        now = self.ctx.clock()
        state, before = self._gauge.state(now), self._published
        if before is None or _gist(state) != _gist(before) or now >= self._publish_at:
            self._published, self._publish_at = state, now + PUBLISH_S
            self.ctx.publish("state", state)
        if before is None or state.valid != before.valid:
            self.ctx.ready() if state.valid else self.ctx.warn(state.reason, "stale_sensor")
        self._tell(state, before, now)

    def _tell(self, state: BatteryState, before: BatteryState | None, now: float) -> None:
        volts = f"{state.rest_voltage_v:.1f} V" if state.rest_voltage_v is not None else ""
        if state.level == "critical":
            self._warn("battery_critical", f"the battery is almost empty ({volts} at rest)", now)
        elif state.level == "low":
            self._warn("battery_low", f"the battery is low ({volts} at rest, charge {state.charge or 0.0:.0%})", now)
        if state.charging and before is not None and before.charging is False:
            self._warn("charging", f"the battery is being charged ({volts})", now, level="info")

    def _warn(self, kind: str, text: str, now: float, *, level: str = "warning") -> None:
        """Publish a warning and speak it, unless that was done not long ago."""
        if not now - self._warned_at.get(kind, -inf) >= self.ctx.settings.repeat_s:
            return
        self._warned_at[kind] = now
        self.ctx.event(kind, text, level=level)
        self.ctx.ask("say", SayCommand(phrase=kind), timeout_s=SAY_WITHIN_S)  # speech reports its own errors


def _gist(state: BatteryState) -> tuple[object, ...]:
    return (state.valid, state.charging, state.level)
