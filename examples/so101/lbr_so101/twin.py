"""The emulated bus of STS3215 servos: rows, faults, servos and line, from the vendor's table, apart from the driver.

The table leaves gaps. This twin assumes: an unreadable register, or an invalid packet, gets no answer. A write to a
read-only register is ignored, and a value out of range is limited, including a goal; neither is reported. Behaviours
that nobody has measured for certain are settings of the row: `goal_switches_on`, `absent_ends_answers`, `lock_drops`.
"""

from collections import deque
from collections.abc import Iterator, Mapping
from math import tau
from random import Random
from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.context import Device
from lbr.capability.twins import DeviceTwin
from lbr.simulation.faults import ServoBusFaults, ServoIds
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.port import PtyPort
from lbr.simulation.turning import moved
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row
from lbr.simulation.wire import Babble, Outbox, flip_one_bit, noise, strikes

STEP_RAD = tau / 4096
SIZE, RAM = 87, 40
BROADCAST = 254
PING, READ, WRITE, REG_WRITE, ACTION, RESET_TURNS, SYNC_READ, SYNC_WRITE = 1, 2, 3, 4, 5, 10, 0x82, 0x83
VOLTAGE, HEAT, OVERLOAD = 0x01, 0x04, 0x20
BAUDS = (1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400)
NO_LOAD_RPS = 3400 * STEP_RAD
SLOPE_RAD = 0.05
"""Softer than the servo, which is nearly a switch: a world with steps of some milliseconds stays calm."""
GAP_S = 0.1
"""A longer pause within a packet makes a servo drop it, as with other makes; nobody has measured it."""
LATE_S = 0.012
LEAST_SUPPLY_V = 3.5
WARM_C = 35.0

# Address: bytes, highest value, value from the factory. The lowest is 0. A version for 12 V.
_REGISTERS: Mapping[int, tuple[int, int, int]] = {
    5: (1, 253, 1), 6: (1, 7, 0), 7: (1, 254, 0), 8: (1, 1, 1), 9: (2, 4094, 0), 11: (2, 4095, 4095), 13: (1, 100, 70),
    14: (1, 254, 140), 15: (1, 254, 50), 16: (2, 1000, 1000), 18: (1, 255, 12), 19: (1, 255, 44), 20: (1, 255, 47),
    21: (1, 254, 32), 22: (1, 254, 32), 23: (1, 254, 0), 24: (2, 1000, 16), 26: (1, 32, 1), 27: (1, 32, 1),
    28: (2, 511, 500), 30: (1, 100, 1), 31: (2, 0xFFF, 0), 33: (1, 3, 0), 34: (1, 100, 20), 35: (1, 254, 200),
    36: (1, 100, 80), 37: (1, 254, 10), 38: (1, 254, 200), 39: (1, 254, 10), 40: (1, 128, 0), 41: (1, 254, 0),
    42: (2, 0xFFFF, 0), 44: (2, 0xFFFF, 0), 46: (2, 0xFFFF, 0), 48: (2, 1000, 1000), 55: (1, 1, 1),
}  # fmt: skip
_WRITABLE = frozenset(at + part for at, (count, _, _) in _REGISTERS.items() for part in range(count))
Id = Annotated[int, Meta(ge=0, le=253)]


class FeetechFaults(ServoBusFaults, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults of a bus of STS3215. `low_voltage`: what they report; `blocked`: their joint does not turn; `cut_behind`: the
    cable is broken behind that servo.
    """

    low_voltage: ServoIds = ()
    blocked: ServoIds = ()
    cut_behind: ServoIds = ()


class FeetechRow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The servos on a `feetech` device row's bus. `registers` are set in all servos before power-up.

    `goal_switches_on`: a goal also gives torque. `absent_ends_answers`: in a SYNC READ, no servo answers after an
    absent one. `lock_drops`: a write to a locked EEPROM has no effect, instead of one until power off.
    """

    faults: FeetechFaults = FeetechFaults()
    ids: Annotated[tuple[Id, ...], Meta(min_length=1, max_length=100)] = (1, 2, 3, 4, 5, 6)
    positions_rad: dict[str, Annotated[float, Meta(ge=-3.1, le=3.1)]] = {}
    registers: dict[str, Annotated[int, Meta(ge=0, le=0xFFFF)]] = {}
    supply_v: Annotated[float, Meta(ge=0.0, le=25.0)] = 12.0
    usb_us: Annotated[float, Meta(ge=0.0, le=20_000.0, description="added to a round trip")] = 300.0
    eeprom_ms: Annotated[float, Meta(ge=0.0, le=200.0, description="until what is kept is acknowledged")] = 25.0
    goal_switches_on: bool = True
    absent_ends_answers: bool = False
    lock_drops: bool = False


def signed(raw: int, bit: int) -> int:
    """Return a number whose sign is a bit."""
    return (raw & ((1 << bit) - 1)) * (-1 if raw >> bit & 1 else 1)


def unsigned(value: float, bit: int) -> int:
    """Return the register's form of such a number."""
    most = (1 << bit) - 1
    return min(most, round(abs(value))) | (most + 1 if value < 0 and round(value) else 0)


class StsServo:
    """A servo from power-up on; a world moves it by `feel`, otherwise it turns by itself without load."""

    def __init__(self, number: int, settings: FeetechRow) -> None:
        self._settings = settings
        self._flash = bytearray(RAM)
        self.table = bytearray(SIZE)
        self.felt = ServoFelt(position_rad=settings.positions_rad.get(str(number), 0.0))
        self.supply_v = settings.supply_v
        self.powered = self.overloaded = self.hot = self.low = self.blocked = self.strained = False
        self._strained_since: float | None = None
        self._later = b""
        self._by_itself = True
        self._at: float | None = None
        self._drive: ServoDrive | None = None
        for address, (_, _, value) in _REGISTERS.items():
            self._put(address, value)
        self._put(0, 0x0A03)
        self._put(3, 777)
        self.table[5] = number
        for name, value in settings.registers.items():
            self._put(int(name), value)
        self._flash[:] = self.table[:RAM]
        self.power(on=True)

    @property
    def id(self) -> int:
        """Return its number on the bus."""
        return self.table[5]

    @property
    def torque(self) -> bool:
        """Return whether it has torque."""
        return self.drive().torque > 0.0

    def word(self, address: int) -> int:
        """Return two bytes as a number."""
        return self.table[address] | self.table[address + 1] << 8

    def power(self, *, on: bool) -> None:
        """Switch its supply; without it, values that it does not keep are reset."""
        if on and not self.powered:
            self.table[:RAM] = self._flash
            for address, (_, _, value) in _REGISTERS.items():
                if address >= RAM:
                    self._put(address, value)
            self._put(48, self.word(16))
            self.overloaded, self._later, self._strained_since = False, b"", None
        self.powered, self._drive = on, None

    def suffer(self, *, hot: bool, low: bool, blocked: bool, strained: bool) -> None:
        """Make it hot, lower its supply, block its joint, or strain it once beyond its torque."""
        self.overloaded = self.overloaded or (strained and not self.strained)
        self.hot, self.low, self.blocked, self.strained, self._drive = hot, low, blocked, strained, None

    def errors(self) -> int:
        """Return its present errors."""
        found = OVERLOAD if self.overloaded else 0
        if not self.table[15] <= self._tenths() <= self.table[14]:
            found |= VOLTAGE
        return found | (HEAT if self._celsius() > self.table[13] else 0)

    def drive(self) -> ServoDrive:
        """Return the motor's state by the registers; the same object until one of them changes."""
        if self._drive is None:
            table, speed = self.table, abs(signed(self.word(46), 15))
            share = self.word(48) / 1000.0
            share = min(share, table[34] / 100.0) if self.overloaded else share
            off = not self.powered or table[40] != 1 or table[33] or self.errors() & table[19] & ~OVERLOAD
            self._drive = ServoDrive(
                goal_rad=(signed(self.word(42), 15) + signed(self.word(31), 11) - 2048) * STEP_RAD,
                speed_rps=speed * STEP_RAD * (1 if table[18] & 4 else 50) if speed else None,
                torque=0.0 if off else share,
                margins_rad=(table[26] * STEP_RAD, table[27] * STEP_RAD),
                slopes_rad=(SLOPE_RAD, SLOPE_RAD),
                punch=self.word(24) / 1000.0,
                brake=self.powered and table[40] == 2,
            )
        return self._drive

    def feel(self, felt: ServoFelt, supply_v: float, now: float) -> None:
        """Set the angle at which the world has it; from then on it does not turn by itself."""
        self._by_itself = False
        if round(supply_v * 10) != round(self.supply_v * 10):
            self.supply_v, self._drive = supply_v, None
        self._take(felt, now)

    def advance(self, now: float) -> None:
        """Turn by itself until now, if no world moves it."""
        if not self._by_itself:
            return
        dt_s, self._at = max(0.0, now - (now if self._at is None else self._at)), now
        drive = self.drive()
        felt = moved(drive, self.felt, dt_s, NO_LOAD_RPS)
        if self.blocked:
            felt = ServoFelt(position_rad=self.felt.position_rad, load=drive.torque if felt.speed_rps else 0.0)
        self._take(felt, now)

    def execute(self, code: int, parameters: bytes) -> bytes | None:
        """Carry out an instruction; return the bytes of its answer, None without one."""
        acknowledges = b"" if self.table[8] else None
        if code == PING:
            return b""
        if code == READ and len(parameters) == 2 and parameters[1] and sum(parameters) <= SIZE:
            self._measure()
            return bytes(self.table[parameters[0] : sum(parameters)])
        if code == WRITE and len(parameters) > 1:
            self.write(parameters[0], parameters[1:])
            return acknowledges
        if code == REG_WRITE and len(parameters) > 1:
            self._later = parameters
            return acknowledges
        if code == ACTION:
            if self._later:
                self.write(self._later[0], self._later[1:])
            self._later = b""
            return acknowledges
        return acknowledges if code == RESET_TURNS else None

    def write(self, address: int, data: bytes) -> None:
        """Write the writable registers, within their bounds, and keep values in the EEPROM if that is unlocked."""
        goal_given = address <= 42 < address + len(data)
        shifts = address <= 40 < address + len(data) and data[40 - address] == 128
        torque, locked = self.table[40], bool(self.table[55])
        for at, byte in enumerate(data, address):
            if at in _WRITABLE and not (at < RAM and locked and self._settings.lock_drops):
                self.table[at] = byte
        for at, (count, most, _) in _REGISTERS.items():
            if (self.word(at) if count == 2 else self.table[at]) > most:
                self._put(at, most)
        if shifts:
            self.table[40] = torque
            self._measure()
            self._put(31, unsigned(signed(self.word(31), 11) + self.word(56) - 2048, 11))
        if not locked:
            self._flash[:] = self.table[:RAM]
        if goal_given:
            self._aim(switches=address > 40)
        if not self.table[40]:
            self.overloaded, self._strained_since = False, None
        self._drive = None

    def _aim(self, *, switches: bool) -> None:
        lowest, highest = self.word(9), self.word(11)
        if lowest < highest:
            self._put(42, unsigned(max(lowest, min(highest, signed(self.word(42), 15))), 15))
        if switches and self._settings.goal_switches_on:
            self.table[40] = 1

    def _take(self, felt: ServoFelt, now: float) -> None:
        self.felt = felt
        if self.torque and abs(felt.load) >= self.table[36] / 100.0 and not self.overloaded:
            since = self._strained_since = now if self._strained_since is None else self._strained_since
            if now - since > self.table[35] * 0.01:
                self.overloaded, self._drive = True, None
        else:
            self._strained_since = None

    def _measure(self) -> None:
        encoder = 2048 + round(self.felt.position_rad / STEP_RAD)
        position = encoder - signed(self.word(31), 11)
        self._put(56, unsigned(position, 15) if self.table[18] & 0x10 else position % 4096)
        self._put(58, unsigned(self.felt.speed_rps / STEP_RAD, 15))
        self._put(60, unsigned(self.felt.load * 1000.0, 10))
        self.table[62], self.table[63], self.table[64] = self._tenths(), self._celsius(), bool(self._later)
        self.table[65], self.table[66] = self.errors(), self.felt.speed_rps != 0.0
        self._put(69, unsigned(abs(self.felt.load) * 400, 15))

    def _tenths(self) -> int:
        return self.table[15] - 1 if self.low else max(0, min(255, round(self.supply_v * 10)))

    def _celsius(self) -> int:
        return self.table[13] + 10 if self.hot else round(WARM_C)

    def _put(self, address: int, value: int) -> None:
        count = _REGISTERS[address][0] if address in _REGISTERS else 2
        self.table[address : address + count] = value.to_bytes(count, "little")


class FeetechTwin(PortTwin[PtyPort, FeetechFaults]):
    """The bus on its port; moves a body's joints, and measures them."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        self.settings = row(device, FeetechRow)
        super().__init__(device.name, PtyPort(device.address), self.settings.faults)
        self.servos = {number: StsServo(number, self.settings) for number in self.settings.ids}
        self.log: deque[tuple[int, int, bytes]] = deque(maxlen=4096)
        """The last instructions received: id, instruction, parameters."""
        self._random = Random(around.seed_for(device))
        self._struck: FeetechFaults | None = None
        self._supplied = True
        self._held = b""
        self._heard_at = 0.0
        self._babble = Babble(self._random)
        self._outbox = Outbox()

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self._struck is not self._faults:
            self._struck = self._faults
            self._strike()
        if plug(self.port, present=not self._faults.unplug):
            self._outbox.clear()
            self._held = b""
        for servo in self.servos.values():
            servo.advance(now)
        if heard := self.port.read():
            self._hear(heard, now, self.port.baud())
        if self._faults.babbling and (babble := self._babble.due(now)):
            self.port.write(babble)
        if answers := self._outbox.due(now):
            self.port.write(answers)

    def next_due(self) -> float | None:
        """Return when it next sends."""
        dues = (self._outbox.next_due(), self._babble.next_at if self._faults.babbling else None)
        return min((at for at in dues if at is not None), default=None)

    def sense(self, sensed: Sensed) -> None:
        """Do nothing: its servos feel each step of the world."""

    def drives(self, _now: float) -> Mapping[int, ServoDrive]:
        """Return each servo's motor state; a servo without power is limp."""
        return {number: servo.drive() for number, servo in self.servos.items()}

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' angles in the world, and the voltage of their supply."""
        if (supply_v >= LEAST_SUPPLY_V) != self._supplied:
            self._supplied = supply_v >= LEAST_SUPPLY_V
            self._strike()
        for number, servo in self.servos.items():
            if number in felt:
                servo.feel(felt[number], supply_v, now)

    def _strike(self) -> None:
        faults, cut = self._faults, False
        for number, servo in self.servos.items():
            servo.power(on=self._supplied and not (cut or faults.brown_out or number in faults.unpowered))
            servo.suffer(
                hot=number in faults.hot,
                low=number in faults.low_voltage,
                blocked=number in faults.blocked,
                strained=number in faults.overload,
            )
            model = 1284 if number in faults.wrong_model else 777
            servo.table[3], servo.table[4] = model & 0xFF, model >> 8
            cut = cut or number in faults.cut_behind

    def _hear(self, data: bytes, now: float, baud: int) -> None:
        byte_s = 10.0 / (baud or BAUDS[0])
        self._held = data if now - self._heard_at > GAP_S else self._held + data
        self._heard_at = now
        free = now + self.settings.usb_us * 0.5e-6 + len(data) * byte_s
        if self._faults.echo:
            self._outbox.arrive(data, free)
        for number, code, parameters in self._instructions():
            self.log.append((number, code, parameters))
            for servo, said in self._answers(number, code, parameters, baud):
                slow = code in {WRITE, REG_WRITE} and parameters[0] < RAM
                free += servo.table[7] * 2e-6 + 50e-6 + len(said) * byte_s
                self._say(said, servo.id, free + (self.settings.eeprom_ms * 1e-3 if slow else 0.0))

    def _instructions(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield id, instruction and parameters of each complete and valid packet."""
        while len(self._held) >= 4:
            number, length = self._held[2], self._held[3]
            if self._held[:2] != b"\xff\xff" or number > BROADCAST or not 2 <= length <= 250:
                self._held = self._held[1:]
            elif len(self._held) < length + 4:
                return
            else:
                packet, self._held = self._held[: length + 4], self._held[length + 4 :]
                if sum(packet[2:]) & 0xFF == 0xFF:
                    yield number, packet[4], packet[5:-1]

    def _answers(self, number: int, code: int, parameters: bytes, baud: int) -> Iterator[tuple[StsServo, bytes]]:
        """Yield the answering servos with their packets, in the order of the line."""
        there = [one for one in self.servos.values() if self._hears(one, baud)]
        if number == BROADCAST and code == SYNC_READ:
            yield from self._read_together(there, parameters)
        elif number == BROADCAST and code == SYNC_WRITE:
            _written_together(there, parameters)
        else:
            for servo, known_as in [(one, one.id) for one in there if number in {one.id, BROADCAST}]:
                said = servo.execute(code, parameters)
                if said is not None and (number != BROADCAST or code == PING):
                    yield servo, self._status(servo, said, known_as)

    def _read_together(self, there: list[StsServo], parameters: bytes) -> Iterator[tuple[StsServo, bytes]]:
        for wanted in parameters[2:]:
            found = [one for one in there if one.id == wanted]
            if not found and self.settings.absent_ends_answers:
                return
            for servo in found:
                said = servo.execute(READ, parameters[:2])
                if said is not None:
                    yield servo, self._status(servo, said, wanted)

    def _hears(self, servo: StsServo, baud: int) -> bool:
        right = abs(BAUDS[servo.table[6]] - (baud or BAUDS[0])) < 0.03 * BAUDS[servo.table[6]]
        return servo.powered and right and servo.id not in self._faults.other_baud

    @staticmethod
    def _status(servo: StsServo, data: bytes, known_as: int) -> bytes:
        body = bytes((known_as, len(data) + 2, servo.errors())) + data
        return b"\xff\xff" + body + bytes((~sum(body) & 0xFF,))

    def _say(self, said: bytes, number: int, due: float) -> None:
        faults = self._faults
        if number in faults.silent or strikes(faults.drop, self._random):
            return
        if number in faults.duplicate:
            said = bytes(byte & (byte << 1 | 1) for byte in said)
        if strikes(faults.bit_flip, self._random):
            said = flip_one_bit(said, self._random)
        if strikes(faults.garbage, self._random):
            said = noise(self._random) + said
        if strikes(faults.half, self._random):
            said = said[: self._random.randrange(len(said))]
        self._outbox.arrive(said, due + (LATE_S if strikes(faults.late, self._random) else 0.0))


def _written_together(there: list[StsServo], parameters: bytes) -> None:
    if len(parameters) > 2:
        address, size = parameters[:2]
        for at in range(2, len(parameters) - size, size + 1):
            for servo in there:
                if servo.id == parameters[at]:
                    servo.write(address, parameters[at + 1 : at + 1 + size])


TWIN = DeviceTwin(device="feetech", row=FeetechRow, entry=FeetechTwin)
