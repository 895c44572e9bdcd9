"""The gamepad as a capability: it publishes sticks and buttons at each change, and often while anything is held."""

from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.gamepad import GamepadSettings
from lbr.drivers.gamepad.pad import Held
from lbr.drivers.gamepad.receiver import Receiver
from lbr.messages.gamepad import GamepadState

HELD_EVERY_S, REST_EVERY_S = 0.05, 0.5
HELD_HZ, REST_HZ = 50.0, 20.0
AT_REST = Held({}, ())


class Gamepad(Capability[GamepadSettings]):
    """Publishes each press and release, however short, and the newest position of sticks, at most at 50 Hz."""

    rate_hz = REST_HZ

    def __init__(self, ctx: Context[GamepadSettings]) -> None:
        super().__init__(ctx)
        self._receiver: Receiver | None = None
        self._held = AT_REST
        self._spoke_at: float | None = None
        self._published_at = -inf

    def open(self) -> None:
        """Open the gamepad; other programs receive nothing from it meanwhile."""
        self._receiver = Receiver(self.device_row)
        self._held, self._spoke_at, self._published_at = self._receiver.held(), None, -inf

    def step(self) -> None:
        """Read the gamepad, and publish its state."""
        receiver = self._receiver
        assert receiver is not None
        packets = receiver.poll()
        now = self.ctx.clock()
        if packets:
            self._spoke_at = now
        for before, held in zip((self._held, *packets), packets, strict=False):
            if held.pressed != before.pressed or held is packets[-1]:
                self._held = held
                self._publish(receiver, now)
        held_now = bool(self._held.pressed) or any(self._held.axes.values())
        self.rate_hz = HELD_HZ if held_now else REST_HZ
        if now - self._published_at >= (HELD_EVERY_S if held_now else REST_EVERY_S):
            self._publish(receiver, now)

    def degraded(self, reason: str) -> None:
        """Publish that there is no gamepad, so nothing is held."""
        self.ctx.publish("state", GamepadState(connected=False, reason=reason))

    def close(self) -> None:
        """Release the gamepad to other programs."""
        receiver, self._receiver = self._receiver, None
        if receiver is not None:
            receiver.close()

    def _publish(self, receiver: Receiver, now: float) -> None:
        self._published_at = now
        silent_s = None if self._spoke_at is None else round(now - self._spoke_at, 3)
        self.ctx.publish(
            "state",
            GamepadState(
                connected=True,
                name=receiver.name,
                link=receiver.link,
                axes=self._held.axes,
                pressed=self._held.pressed,
                silent_s=silent_s,
            ),
        )
