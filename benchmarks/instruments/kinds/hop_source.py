"""A capability that sends a thousand messages a second."""

import time

from msgspec import Struct

from lbr.capability.base import Capability
from lbr.capability.kind import Kind, NoSettings

FILLER = "x" * 160


class Tick(Struct, frozen=True):
    """One message of a stream."""

    sent_ns: int
    text: str = FILLER


class Source(Capability[NoSettings]):
    """Sends one a round."""

    rate_hz = 1000.0

    def step(self) -> None:
        """Send."""
        if self.ctx.on_tick:
            self.ctx.publish("ticks", Tick(time.monotonic_ns()))


KIND = Kind(name="hop_source", summary="sends at 1 kHz", family="operation", entry=Source, outputs={"ticks": Tick})
