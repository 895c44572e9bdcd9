"""An emulated AX-12A: its control table, its errors, and the control of its motor.

The manual leaves gaps. This servo assumes: EEPROM may be written only without torque. A write to a read-only register,
or of a value out of range, changes nothing and answers the range error. A goal outside the angle limits is ignored.
Overload stays reported until a torque limit is written. With both angle limits 0 (wheel mode) it does not turn. When
torque is switched on, it goes to the value of its goal register.
"""

from collections.abc import Callable, Mapping

from lbr.simulation.bus_timing import STEADY, Rhythm
from lbr.simulation.devices.dynamixel import registers as reg
from lbr.simulation.devices.dynamixel.motion import MIDDLE, NO_LOAD_RPS, SPEED_RPS, STEP_RAD, as_position, as_signed
from lbr.simulation.devices.dynamixel.packets import BROADCAST, RECEIVE_BYTES, Code, Fault, Instruction, status
from lbr.simulation.measured import ServoDrive, ServoFelt
from lbr.simulation.turning import moved

Act = Callable[[Instruction, float], bytes | None]

OVERLOAD_S = 2.0
"""The time for which it bears its full torque."""

_LEVELS: Mapping[int, int] = {Code.PING: 0, Code.READ: 1}
_FULL = 1023.0
_FULL_SHARE = 0.95
_AMBIENT_C = 30.0
_WARMING_C = 60.0
_WARMING_S = 300.0


class AxServo:
    """A servo from power-up on, in its own radians; a world moves it by `feel`, otherwise it turns by itself."""

    def __init__(
        self,
        number: int = 1,
        *,
        return_delay: int = 250,
        position_rad: float = 0.0,
        rhythm: Rhythm = STEADY,
        eeprom_s: float = 0.006,
        goal_switches_on: bool = False,
    ) -> None:
        self.rhythm = rhythm
        self.felt = ServoFelt(position_rad=position_rad)
        self.supply_v = 11.1
        self.temperature_c = _AMBIENT_C
        self.deaf_until = 0.0
        self.wrong_model = False
        self._table = reg.factory()
        self._table[reg.ID] = number
        self._table[reg.RETURN_DELAY] = return_delay
        reg.put_word(self._table, reg.GOAL, as_position(position_rad))
        self._eeprom_s = eeprom_s
        self._goal_switches_on = goal_switches_on
        self.powered = True
        self._hot = self._strained = self._overloaded = False
        self._full_since: float | None = None
        self._registered: bytes | None = None
        self._by_itself = True
        self._at = 0.0
        self._drive: ServoDrive | None = None
        self._acts: Mapping[int, Act] = {
            Code.PING: self._ping,
            Code.READ: self._read,
            Code.WRITE: self._write_now,
            Code.REG_WRITE: self._write_later,
            Code.ACTION: self._act,
            Code.FACTORY_RESET: self._reset,
            Code.SYNC_WRITE: self._sync_write,
        }

    @property
    def id(self) -> int:
        """Return its number on the bus."""
        return self._table[reg.ID]

    @property
    def baud(self) -> float:
        """Return the rate of the line at which it listens."""
        return 2e6 / (self._table[reg.BAUD] + 1)

    @property
    def return_delay_s(self) -> float:
        """Return the delay in its register."""
        return self._table[reg.RETURN_DELAY] * 2e-6

    def power(self, *, on: bool) -> None:
        """Switch its supply; without it, only the EEPROM keeps its values."""
        if on and not self.powered:
            reg.boot(self._table)
            reg.put_word(self._table, reg.GOAL, as_position(self.felt.position_rad))
            self._registered = self._full_since = None
            self._overloaded = False
        self.powered = on
        self._drive = None

    def suffer(self, *, hot: bool = False, strained: bool = False) -> None:
        """Make it too hot, or strain it beyond its torque."""
        self._hot, self._strained = hot, strained
        self._overloaded = self._overloaded or strained
        self._protect()

    def drive(self) -> ServoDrive:
        """Return the motor's state by the registers; the same object until one of them changes."""
        if self._drive is None:
            self._drive = self._meant()
        return self._drive

    def feel(self, felt: ServoFelt, supply_v: float, now: float) -> None:
        """Set the angle at which the world has it; from then on it does not turn by itself."""
        dt_s = now - self._at if not self._by_itself else 0.0
        self._by_itself = False
        self.supply_v = supply_v
        self._take(felt, dt_s, now)

    def advance(self, now: float) -> None:
        """Turn by itself until now, if no world moves it."""
        if self._by_itself and now > self._at:
            dt_s = now - self._at if self._at else 0.0
            self._take(moved(self.drive(), self.felt, dt_s, NO_LOAD_RPS), dt_s, now)

    def execute(self, instruction: Instruction, now: float) -> bytes | None:
        """Carry out a packet; return its answer, None without one."""
        self.advance(now)
        if instruction.size > RECEIVE_BYTES:
            return None
        if not instruction.sound:
            return self._answer(instruction, Fault.CHECKSUM)
        act = self._acts.get(instruction.code)
        return act(instruction, now) if act else self._answer(instruction, Fault.INSTRUCTION)

    # What it answers.

    def _answer(self, instruction: Instruction, error: Fault, data: bytes = b"") -> bytes | None:
        level = _LEVELS.get(instruction.code, 2)
        if instruction.id == BROADCAST or self._table[reg.RETURN_LEVEL] < level:
            return None
        return status(instruction.id, error | self.errors(), data)

    def errors(self) -> Fault:
        """Return the present faults."""
        tenths = round(self.supply_v * 10)
        faults = Fault.NONE
        if not self._table[reg.LEAST_VOLTAGE] <= tenths <= self._table[reg.MOST_VOLTAGE]:
            faults |= Fault.VOLTAGE
        if self._celsius() > self._table[reg.HEAT_LIMIT_C]:
            faults |= Fault.HEAT
        return faults | Fault.OVERLOAD if self._overloaded else faults

    def _celsius(self) -> int:
        return round(self._table[reg.HEAT_LIMIT_C] + 10 if self._hot else self.temperature_c)

    def _ping(self, instruction: Instruction, _now: float) -> bytes | None:
        return self._answer(instruction, Fault.NONE)

    def _read(self, instruction: Instruction, _now: float) -> bytes | None:
        if len(instruction.parameters) != 2:
            return self._answer(instruction, Fault.RANGE)
        start, count = instruction.parameters
        if count == 0 or start + count > reg.SIZE:
            return self._answer(instruction, Fault.RANGE)
        if start + count > reg.PRESENT or (start < 2 and self.wrong_model):
            self.measure()
        return self._answer(instruction, Fault.NONE, bytes(self._table[start : start + count]))

    def measure(self) -> None:
        """Update the registers of its measurements."""
        table, felt, drive = self._table, self.felt, self.drive()
        reg.put_word(table, reg.PRESENT, as_position(felt.position_rad))
        reg.put_word(table, reg.PRESENT + 2, as_signed(felt.speed_rps / SPEED_RPS))
        reg.put_word(table, reg.PRESENT + 4, as_signed(felt.load * _FULL))
        table[reg.VOLTAGE] = min(255, max(0, round(self.supply_v * 10)))
        table[reg.VOLTAGE + 1] = min(255, max(0, self._celsius()))
        away = abs(drive.goal_rad - felt.position_rad) > max(drive.margins_rad) + STEP_RAD
        table[reg.MOVING] = drive.torque > 0.0 and away and felt.speed_rps != 0.0
        table[reg.REGISTERED] = self._registered is not None
        reg.put_word(table, 0, reg.MODEL + 6 if self.wrong_model else reg.MODEL)

    # What it is told.

    def _write_now(self, instruction: Instruction, now: float) -> bytes | None:
        return self._answer(instruction, self._write(instruction.parameters, now))

    def _write_later(self, instruction: Instruction, _now: float) -> bytes | None:
        parameters = instruction.parameters
        if len(parameters) < 2 or reg.touched(parameters[0], len(parameters) - 1) is None:
            return self._answer(instruction, Fault.RANGE)
        self._registered = parameters
        return self._answer(instruction, Fault.NONE)

    def _act(self, instruction: Instruction, now: float) -> bytes | None:
        parameters, self._registered = self._registered, None
        return self._answer(instruction, self._write(parameters, now) if parameters else Fault.INSTRUCTION)

    def _reset(self, instruction: Instruction, now: float) -> bytes | None:
        if instruction.id == BROADCAST:
            return None
        answer = self._answer(instruction, Fault.NONE)
        self._table[: reg.RAM] = reg.factory()[: reg.RAM]
        self.deaf_until = now + self._eeprom_s * reg.RAM
        return answer

    def _sync_write(self, instruction: Instruction, now: float) -> bytes | None:
        parameters = instruction.parameters
        if instruction.id != BROADCAST:
            return self._answer(instruction, Fault.INSTRUCTION)
        if len(parameters) > 2:
            start, size = parameters[:2]
            for at in range(2, len(parameters) - size, size + 1):
                if parameters[at] == self.id:
                    self._write(bytes((start,)) + parameters[at + 1 : at + 1 + size], now)
        return None

    def _write(self, parameters: bytes, now: float) -> Fault:
        if len(parameters) < 2:
            return Fault.RANGE
        error = self._put(parameters[0], parameters[1:])
        if not error and parameters[0] < reg.RAM:
            self.deaf_until = now + self._eeprom_s * (len(parameters) - 1)
        return error

    def _put(self, address: int, data: bytes) -> Fault:
        registers = reg.touched(address, len(data))
        if registers is None or not self._writable(address, len(data)):
            return Fault.RANGE
        table = bytearray(self._table)
        table[address : address + len(data)] = data
        if not all(reg.in_range(table, register) for register in registers):
            return Fault.RANGE
        aims = address <= reg.GOAL + 1 and address + len(data) > reg.GOAL
        if aims and not self._within(reg.word(table, reg.GOAL)):
            return Fault.ANGLE
        if aims and self._goal_switches_on:
            table[reg.TORQUE] = 1
        self._table = table
        self._drive = None
        if any(register.address == reg.TORQUE_LIMIT for register in registers):
            self._overloaded = self._strained
        self._protect()
        return Fault.NONE

    def _writable(self, address: int, count: int) -> bool:
        if self._table[reg.LOCK]:
            return address >= reg.RAM and address + count <= reg.PRESENT
        return address >= reg.RAM or not self._table[reg.TORQUE]

    def _within(self, goal: int) -> bool:
        return self._wheel() or reg.word(self._table, reg.CW_LIMIT) <= goal <= reg.word(self._table, reg.CCW_LIMIT)

    def _wheel(self) -> bool:
        return reg.word(self._table, reg.CW_LIMIT) == reg.word(self._table, reg.CCW_LIMIT) == 0

    # What becomes of its motor.

    def _meant(self) -> ServoDrive:
        table = self._table
        speed = reg.word(table, reg.SPEED) & 0x3FF
        on = self.powered and table[reg.TORQUE] and not self._wheel()
        return ServoDrive(
            goal_rad=(reg.word(table, reg.GOAL) - MIDDLE) * STEP_RAD,
            speed_rps=speed * SPEED_RPS if speed else None,
            torque=reg.word(table, reg.TORQUE_LIMIT) / _FULL if on else 0.0,
            margins_rad=(table[reg.CW_MARGIN] * STEP_RAD, table[reg.CCW_MARGIN] * STEP_RAD),
            slopes_rad=(_slope(table[reg.CW_SLOPE]) * STEP_RAD, _slope(table[reg.CCW_SLOPE]) * STEP_RAD),
            punch=reg.word(table, reg.PUNCH) / _FULL,
        )

    def _take(self, felt: ServoFelt, dt_s: float, now: float) -> None:
        self.felt, self._at = felt, now
        load = abs(felt.load)
        rise = load * load * _WARMING_C + _AMBIENT_C - self.temperature_c
        self.temperature_c += rise * min(1.0, max(0.0, dt_s) / _WARMING_S)
        torque = self.drive().torque
        if torque <= 0.0 or load < _FULL_SHARE * torque:
            self._full_since = None
        elif self._full_since is None:
            self._full_since = now
        elif now - self._full_since > OVERLOAD_S:
            self._overloaded = True
        self._protect()

    def _protect(self) -> None:
        if self.errors() & self._table[reg.SHUTDOWN] and reg.word(self._table, reg.TORQUE_LIMIT):
            reg.put_word(self._table, reg.TORQUE_LIMIT, 0)
            self._drive = None


def _slope(register: int) -> int:
    """Return the effective step of a compliance slope: 2, 4, 8 to 128, rounded down."""
    return min(128, max(2, 1 << (register.bit_length() - 1)))
