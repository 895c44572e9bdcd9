"""An emulated infrared receiver that sees a dock's beams: the kernel's records.

Each beam is like a held key of a remote control: a code every 110 ms while it is visible. The beams take turns.
"""

import struct
from collections.abc import Mapping
from random import Random

from lbr.capability.context import Device
from lbr.simulation.devices.infrared import InfraredFaults, InfraredRow
from lbr.simulation.measured import Beam, Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin
from lbr.simulation.wire import noise, strikes

EVERY_S = 0.11
RECORD = struct.Struct("<QHHIQ")
"""`struct lirc_scancode`: timestamp in ns, flags, protocol, key code, scancode."""

ORDER: tuple[Beam, ...] = ("left", "right", "power")

_STRAY_CODE = 0x0F1F


class InfraredReceiver:
    """A receiver and the visible `beams`."""

    def __init__(
        self, codes: Mapping[Beam, int], *, protocol: int, faults: InfraredFaults | None = None, seed: int = 0
    ) -> None:
        self.faults = faults or InfraredFaults()
        self.beams: frozenset[Beam] = frozenset()
        self._codes = codes
        self._protocol = protocol
        self._random = Random(seed)
        self._next_at: dict[Beam, float] = {}

    def poll(self, now: float) -> bytes:
        """Return the records that are due."""
        records = b""
        for turn, beam in enumerate(ORDER):
            if not self._seen(beam):
                self._next_at.pop(beam, None)
                continue
            at = self._next_at.setdefault(beam, now + turn * EVERY_S / len(ORDER))
            if now >= at:
                self._next_at[beam] = max(at + EVERY_S, now)
                records += self._record(self._codes[beam], now)
        return records

    def next_due(self) -> float | None:
        """Return when the next record is due."""
        return min(self._next_at.values(), default=None)

    def _seen(self, beam: Beam) -> bool:
        if beam not in self._codes or self.faults.silent:
            return False
        return beam in self.beams or (self.faults.stuck and beam == "left")

    def _record(self, code: int, now: float) -> bytes:
        faults = self.faults
        record = RECORD.pack(int(now * 1e9), 0, self._protocol, 0, code)
        if strikes(faults.half, self._random):
            record = record[: self._random.randrange(RECORD.size)]
        if strikes(faults.garbage, self._random):
            record = noise(self._random) + record
        if strikes(faults.stray, self._random):
            record = RECORD.pack(int(now * 1e9), 0, self._protocol, 0, _STRAY_CODE) + record
        return record


class InfraredTwin(LineTwin[InfraredFaults]):
    """Sends the codes of the visible beams of the dock."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, InfraredRow)
        self._receiver = InfraredReceiver(
            settings.codes.numbers(),
            protocol=settings.protocol,
            faults=settings.faults,
            seed=around.seed_for(device),
        )
        super().__init__(device, settings.faults, self._receiver)

    def sense(self, sensed: Sensed) -> None:
        """Set the visible beams."""
        self._receiver.beams = sensed.beams
