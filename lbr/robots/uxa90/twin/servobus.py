"""The servos' line behind the main board: the addressees of a packet, and the time of their answers."""

from collections.abc import Sequence

from lbr.robots.uxa90.twin import Uxa90Row
from lbr.robots.uxa90.twin.packets import EXTENDED, Packet
from lbr.robots.uxa90.twin.registers import BAUD_115200, SAVING
from lbr.robots.uxa90.twin.replies import Replies
from lbr.robots.uxa90.twin.servo import SamServo

_READ, _OTHER, _CONFIGURE = 5, 6, 7
_ALL = 31
_PASSIVE = 0x10
_BRAKE = 0x20
_MOVE_FINE, _READ_FINE = 0xC8, 0xAD


class ServoLine:
    """Servos that answer one after the other; wheel packets and the wCK's synchronous move are not obeyed."""

    def __init__(self, row: Uxa90Row, servos: Sequence[SamServo], replies: Replies) -> None:
        self._row = row
        self._servos = servos
        self._replies = replies

    def take(self, packet: Packet, at: float) -> None:
        """Execute a valid packet that ended `at`."""
        if packet.mode == _CONFIGURE:
            self._configure(packet, at)
        elif packet.mode == _OTHER and packet.id == _ALL:
            if packet.data[1] == _BRAKE:
                self._brake(at)
        elif packet.id != _ALL:
            for servo in self._addressed(packet.id):
                self._answer(_operate(servo, packet), at)

    def _brake(self, at: float) -> None:
        alive = [servo for servo in self._servos if _receives(servo)]
        for servo in alive:
            servo.brake()
        if alive:
            self._answer(bytes((alive[0].registers["id"], 0)), at)

    def _configure(self, packet: Packet, at: float) -> None:
        command, *rest = packet.data[1:]
        extended = packet.id == 0 and command in EXTENDED
        number = rest.pop(0) if extended else packet.id
        for servo in self._addressed(number):
            if extended and command == _MOVE_FINE:
                servo.move_fine(rest[0] << 7 | rest[1])
                self._answer(bytes(rest) if self._row.answers_fine else None, at)
            elif extended and command == _READ_FINE:
                fine = servo.fine_position()
                self._answer(bytes((fine >> 7, fine & 0x7F)), at)
            else:
                later_s = self._row.saving_ms * 1e-3 if command in SAVING else 0.0
                self._answer(servo.configure(command, rest[0], rest[1]), at + later_s)

    def _addressed(self, number: int) -> list[SamServo]:
        return [servo for servo in self._servos if servo.registers["id"] == number and _receives(servo)]

    def _answer(self, data: bytes | None, at: float) -> None:
        if data is not None:
            thinking_s = self._row.reply_ms * 1e-3 + self._replies.jitter(self._row.jitter_ms * 1e-3)
            self._replies.servo(data, at + thinking_s)


def _operate(servo: SamServo, packet: Packet) -> bytes | None:
    """Execute a packet of two bytes; return the answer, with the values before the move."""
    second = packet.data[1]
    if packet.mode == _OTHER:
        if second != _PASSIVE:
            return None
        servo.release()
        return bytes((_PASSIVE, servo.position()))
    if packet.mode != _READ:
        servo.move(second, packet.mode)
    return bytes((servo.load(), servo.position()))


def _receives(servo: SamServo) -> bool:
    return servo.powered and servo.registers["baud"] == BAUD_115200
