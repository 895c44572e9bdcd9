"""The twin: rows, faults and the emulated bus in one module, written from the data sheet alone."""

from collections.abc import Mapping
from math import pi
from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.context import Device
from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import Faults, ServoIds
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.port import PtyPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row

STEPS_PER_RAD = 4096 / (2.0 * pi)
BROADCAST = 254
PING, READ, WRITE, SYNC_READ, SYNC_WRITE = 1, 2, 3, 0x82, 0x83
OVERLOAD = 0x20


class StsFaults(Faults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of the bus. `silent`: servos that say nothing; `overload`: that report it until their torque is off."""

    silent: ServoIds = ()
    overload: ServoIds = ()


class StsRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which servos a `feetech` device row's bus has."""

    faults: StsFaults = StsFaults()
    ids: Annotated[tuple[int, ...], Meta(min_length=1)] = (1, 2, 3, 4, 5, 6)


class StsServo:
    """A control table, and a motor that reaches its goal at once, unless a body moves it."""

    def __init__(self, number: int) -> None:
        self.id = number
        self.table = bytearray(87)
        self.error = 0
        self.put(3, 777)
        self.put(48, 1000)
        self.put(56, 2048 + number)
        self.table[62], self.table[63] = 121, 35
        self.driven_by_body = False

    def word(self, address: int) -> int:
        return int.from_bytes(self.table[address : address + 2], "little")

    def put(self, address: int, value: int) -> None:
        self.table[address : address + 2] = value.to_bytes(2, "little")

    @property
    def torque(self) -> bool:
        return self.table[40] == 1

    def write(self, address: int, data: bytes) -> None:
        self.table[address : address + len(data)] = data
        if not self.torque:
            self.error &= ~OVERLOAD
        elif not self.driven_by_body and not self.error:
            self.put(56, self.word(42))


class StsTwin(PortTwin[PtyPort, StsFaults]):
    """The bus on its port."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, StsRow)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self.servos = {number: StsServo(number) for number in settings.ids}
        self._struck = settings.faults
        self._held = b""

    def service(self, now: float) -> None:
        """Do all that is due."""
        plug(self.port, present=not self._faults.unplug)
        if self._faults is not self._struck:
            self._struck = self._faults
            for number in self._faults.overload:
                self.servos[number].error |= OVERLOAD
        self._held += self.port.read()
        while (found := self._next()) is not None:
            if said := self._answers(*found):
                self.port.write(said)

    def next_due(self) -> None:
        """Nothing comes by itself."""

    def sense(self, sensed: Sensed) -> None:
        """Nothing: its servos feel each step of the world."""

    def drives(self, now: float) -> Mapping[int, ServoDrive]:
        """Return what each motor does."""
        return {
            number: ServoDrive(goal_rad=(one.word(42) - 2048) / STEPS_PER_RAD, torque=one.word(48) / 1000 * one.torque)
            for number, one in self.servos.items()
        }

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Take in where the body has the servos."""
        for number, one in self.servos.items():
            if number in felt:
                one.driven_by_body = True
                one.put(56, 2048 + round(felt[number].position_rad * STEPS_PER_RAD))

    def _next(self) -> tuple[int, int, bytes] | None:
        """Return id, instruction and parameters of the next sound packet."""
        while len(self._held) >= 6:
            end = self._held[3] + 4
            if self._held[:2] != b"\xff\xff" or self._held[2] == 255:
                self._held = self._held[1:]
            elif len(self._held) < end:
                return None
            else:
                one, self._held = self._held[:end], self._held[end:]
                if sum(one[2:]) & 0xFF == 0xFF:
                    return one[2], one[4], one[5:-1]
        return None

    def _answers(self, number: int, code: int, params: bytes) -> bytes:
        if code == SYNC_READ:
            address, count, *servos = params
            return b"".join(self._said(one, self._block(one, address, count)) for one in servos if one in self.servos)
        if code == SYNC_WRITE:
            address, size = params[0], params[1]
            for at in range(2, len(params), size + 1):
                if params[at] in self.servos:
                    self.servos[params[at]].write(address, params[at + 1 : at + 1 + size])
            return b""
        if number not in self.servos:
            return b""
        if code == WRITE:
            self.servos[number].write(params[0], params[1:])
        return self._said(number, self._block(number, *params) if code == READ else b"")

    def _block(self, number: int, address: int, count: int) -> bytes:
        return bytes(self.servos[number].table[address : address + count])

    def _said(self, number: int, data: bytes) -> bytes:
        if number in self._faults.silent:
            return b""
        body = bytes((number, len(data) + 2, self.servos[number].error)) + data
        return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))


TWIN = DeviceTwin(device="feetech", row=StsRow, entry=StsTwin)
