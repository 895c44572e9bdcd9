"""A capability that records the age of each message of a stream at its step."""

import time
from pathlib import Path
from typing import Any

from msgspec import Struct

from lbr.capability.base import Capability
from lbr.capability.kind import Kind, NoSettings

FILLER = "x" * 160


class Tick(Struct, frozen=True):
    """One message of a stream."""

    sent_ns: int
    text: str = FILLER


class Sink(Capability[NoSettings]):
    """Receives them."""

    rate_hz = 5.0

    def __init__(self, ctx: Any) -> None:
        super().__init__(ctx)
        self._file = (Path(ctx.home) / "hops.txt").open("w", buffering=2048)

    def step(self) -> None:
        """Write their ages, in microseconds."""
        for received in self.ctx.take("ticks"):
            self._file.write(f"{(time.monotonic_ns() - received.message.sent_ns) / 1e3:.1f}\n")


KIND = Kind(name="hop_sink", summary="hears at 1 kHz", family="operation", entry=Sink, inputs={"ticks": Tick})
