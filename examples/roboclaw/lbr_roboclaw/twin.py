"""An emulated RoboClaw on a pty: packets in, answers out, motors, serial timeout. Imports nothing of the driver.

The manual leaves gaps. This twin assumes: a request with a wrong CRC, or an unknown command, gets no answer and does
not feed the timeout. A command takes effect with its last byte.
"""

import struct
from binascii import crc_hqx
from random import Random
from typing import Literal

from msgspec import Struct

from lbr.capability.context import Device
from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, Probability
from lbr.simulation.measured import Sensed
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row
from lbr.simulation.wire import Outbox, flip_one_bit, noise

PAUSE_S = 0.010
TURNAROUND_S = 0.0003
IDENTITY = b"USB RoboClaw 2x15a v4.2.4\n\0"
DATA_BYTES = {14: 1, 34: 4} | dict.fromkeys((15, 21, 24, 48, 49, 78, 82, 90), 0)
"""Its known commands, with their bytes of data."""
WRITES = (14, 34)
E_STOP, OVERHEAT, UNDERVOLTAGE = 1, 2, 0x20


class RoboclawFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of the controller; `unplug`: the cable is out while it goes on.

    `silent`: it obeys without answers. `drop`, `bit_flip`, `garbage`: an answer is lost, has a bit wrong, has noise
    before it. `brown_out`: its supply is gone, and with it its serial timeout. `pressed`: the emergency stop at its pin
    S3. `overheat`, `undervoltage`: the fault, with the motors off. `no_watchdog`: its serial timeout can be set, but
    does not stop it.
    """

    silent: bool = False
    drop: Probability = 0.0
    bit_flip: Probability = 0.0
    garbage: Probability = 0.0
    brown_out: bool = False
    pressed: bool = False
    overheat: bool = False
    undervoltage: bool = False
    no_watchdog: bool = False


class RoboclawRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The wiring of a `roboclaw` device row: with a direction of -1, the wheel turns back for a positive power."""

    faults: RoboclawFaults = RoboclawFaults()
    address: int = 0x80
    left_channel: Literal[1, 2] = 1
    left_direction: Literal[-1, 1] = 1
    right_direction: Literal[-1, 1] = 1


class RoboclawTwin(PortTwin[PtyPort, RoboclawFaults]):
    """Turns the wheels, and measures motors and battery."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        self._row = row(device, RoboclawRow)
        super().__init__(device.name, PtyPort(device.address), self._row.faults)
        self._random = Random(around.seed_for(device))
        self._outbox = Outbox()
        self._sensed = Sensed(battery_v=12.0)
        self._begun = bytearray()
        self._heard = self._fed = self._timeout_s = 0.0
        self._duties = (0.0, 0.0)

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self._faults.brown_out:
            self._restart()
        plug(self.port, present=not (self._faults.unplug or self._faults.brown_out))
        if self._begun and now - self._heard > PAUSE_S:
            self._begun.clear()
        for byte in self.port.read():
            self._heard = now
            self._begun.append(byte)
            self._outbox.received(1, now)
            self._take(now)
        if answer := self._outbox.due(now):
            self.port.write(answer)

    def next_due(self) -> float | None:
        """Return when it next sends."""
        return self._outbox.next_due()

    def wheels(self, now: float) -> tuple[float, float]:
        """Return the power of the left and the right wheel, forward positive."""
        late = now - self._fed > self._timeout_s > 0.0 and not self._faults.no_watchdog
        if self._off() or late:
            self._duties = (0.0, 0.0)
        left = self._row.left_channel - 1
        return (
            self._duties[left] * self._row.left_direction + 0.0,
            self._duties[1 - left] * self._row.right_direction + 0.0,
        )

    def sense(self, sensed: Sensed) -> None:
        """Measure the motors and the battery."""
        self._sensed = sensed

    def _restart(self) -> None:
        """Reset the settings, as without its supply."""
        self._begun.clear()
        self._timeout_s = 0.0
        self._duties = (0.0, 0.0)
        self._outbox.clear()

    def _off(self) -> bool:
        return self._status() != 0 or self._faults.brown_out

    def _status(self) -> int:
        faults = self._faults
        return E_STOP * faults.pressed | OVERHEAT * faults.overheat | UNDERVOLTAGE * faults.undervoltage

    def _take(self, now: float) -> None:
        """Carry out a complete request."""
        begun = self._begun
        if begun[0] != self._row.address or (len(begun) > 1 and begun[1] not in DATA_BYTES):
            begun.clear()
        if len(begun) < 2 or len(begun) < DATA_BYTES[begun[1]] + 4:
            return
        body, crc = bytes(begun[:-2]), int.from_bytes(begun[-2:], "big")
        begun.clear()
        if crc_hqx(body, 0) == crc:
            self._fed = now
            self._say(self._obey(body[1], body[2:], now), body[:2], now)

    def _obey(self, command: int, data: bytes, now: float) -> bytes:
        if command == 14:
            self._timeout_s = data[0] / 10
        elif command == 34:
            first, second = struct.unpack(">hh", data)
            self._duties = (0.0, 0.0) if self._off() else (first / 32767, second / 32767)
        else:
            return self._value(command, now)
        return b"\xff"

    def _value(self, command: int, now: float) -> bytes:
        if command == 21:
            return IDENTITY
        self.wheels(now)
        values: dict[int, tuple[str, tuple[float, ...]]] = {
            15: ("B", (self._timeout_s * 10,)),
            24: ("H", (self._sensed.battery_v * 10,)),
            48: ("hh", (self._duties[0] * 32767, self._duties[1] * 32767)),
            49: ("hh", tuple(amps * 100 for amps in self._channels(self._sensed.amps_a))),
            78: ("ii", self._channels(self._sensed.counts)),
            82: ("H", (281,)),
            90: ("I", (self._status(),)),
        }
        form, numbers = values[command]
        return struct.pack(f">{form}", *map(round, numbers))

    def _channels(self, wheels: tuple[float, float]) -> tuple[float, float]:
        left, right = wheels[0] * self._row.left_direction, wheels[1] * self._row.right_direction
        return (left, right) if self._row.left_channel == 1 else (right, left)

    def _say(self, data: bytes, asked: bytes, now: float) -> None:
        if asked[1] not in WRITES:
            data += crc_hqx(asked + data, 0).to_bytes(2, "big")
        if self._faults.silent or self._hit(self._faults.drop):
            return
        if self._hit(self._faults.garbage):
            data = noise(self._random) + data
        if self._hit(self._faults.bit_flip):
            data = flip_one_bit(data, self._random)
        self._outbox.send(data, now, TURNAROUND_S)

    def _hit(self, probability: float) -> bool:
        return probability > 0 and self._random.random() < probability


TWIN = DeviceTwin(device="roboclaw", row=RoboclawRow, entry="lbr_roboclaw.twin:RoboclawTwin")
