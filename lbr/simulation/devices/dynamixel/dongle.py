"""An emulated USB2AX: a servo of its own at id 0xFD, which reads many servos in one go (firmware 04 and 05)."""

from collections.abc import Callable
from typing import Literal

from lbr.simulation.devices.dynamixel.packets import BROADCAST, Code, Fault, Instruction, sound, status

NUMBER = 0xFD
STRAY = status(NUMBER, Fault.RANGE)
"""The answer of version 05 before it forwards a broadcast that is too long for it."""

_MODEL = 0x4201
_TICK_S = 20e-6
_LONG = 124
_ABSENT = 0xFF
_REPLY_TIMEOUT, _HOLD_OFF, _WRITABLE = 4, 5, (4, 5, 6)
_USB_PACKET = 16

Ask = Callable[[Instruction, float], tuple[bytes | None, float]]


class Usb2Ax:
    """Its registers and its synchronous reads; times are those of the line."""

    def __init__(self, firmware: Literal[4, 5] = 5) -> None:
        self.firmware = firmware
        self._table = bytearray((_MODEL & 0xFF, _MODEL >> 8, firmware, NUMBER, 50, 4, 100))

    def held_s(self, size: int) -> float:
        """Return how long it holds the end of so many bytes back from the host, in case more come."""
        return self._table[_HOLD_OFF] * _TICK_S if size % _USB_PACKET else 0.0

    def stray(self, instruction: Instruction) -> bytes:
        """Return its unrequested packet before a packet that it forwards."""
        long = instruction.id == BROADCAST and len(instruction.parameters) + 2 >= _LONG
        return STRAY if long and self.firmware == 5 else b""

    def answer(self, instruction: Instruction, at: float, ask: Ask) -> tuple[bytes | None, float]:
        """Return its answer to a packet for itself that ended `at`, and its time; `ask` gets a servo's answer."""
        newer = self.firmware == 5
        parameters = instruction.parameters
        if not instruction.sound:
            return (status(NUMBER, Fault.CHECKSUM) if newer else None), at
        match instruction.code:
            case Code.READ if len(parameters) == 2:
                start, count = parameters
                if count and start + count <= (len(self._table) if newer else 4):
                    return status(NUMBER, 0, bytes(self._table[start : start + count])), at
            case Code.SYNC_READ if self._allows(parameters):
                return self._read_all(parameters, at, ask)
            case Code.PING if newer:
                return status(NUMBER, 0), at
            case Code.WRITE if newer and len(parameters) == 2 and parameters[0] in _WRITABLE:
                self._table[parameters[0]] = parameters[1]
                return status(NUMBER, 0), at
        return (status(NUMBER, Fault.RANGE) if newer else None), at

    def _allows(self, parameters: bytes) -> bool:
        if len(parameters) < 3:
            return False
        each, servos = parameters[1], len(parameters) - 2
        if self.firmware == 4:
            return 0 < each <= 6 and len(parameters) + 2 < 35
        return 0 < each <= 122 and servos < 120 and each * servos <= 229

    def _read_all(self, parameters: bytes, at: float, ask: Ask) -> tuple[bytes, float]:
        values = bytearray()
        each = parameters[1]
        for number in parameters[2:]:
            reply, end = ask(Instruction(number, Code.READ, bytes(parameters[:2])), at)
            whole = reply is not None and sound(reply) and reply[2] == number and len(reply) == each + 6
            values += reply[5:-1] if reply is not None and whole else bytes((_ABSENT,)) * each
            at = end if reply is not None else end + self._table[_REPLY_TIMEOUT] * _TICK_S
        return status(NUMBER, 0, bytes(values)), at
