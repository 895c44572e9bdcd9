"""The line that emulated servos share: half-duplex, one host, and every packet in its own time.

If two send at the same time, both packets are lost. The answer to a packet is timed from its last byte on the line. Its
effect on the servo is computed as soon as the host has sent it, a little early.
"""

from collections.abc import Callable, Iterable
from random import Random

from lbr.simulation.bus_timing import BusTiming
from lbr.simulation.devices.dynamixel import DynamixelFaults
from lbr.simulation.devices.dynamixel.dongle import NUMBER, STRAY, Usb2Ax
from lbr.simulation.devices.dynamixel.packets import BROADCAST, Instruction, InstructionReader
from lbr.simulation.devices.dynamixel.servo import AxServo
from lbr.simulation.wire import Babble, Outbox, flip_one_bit, noise, strikes

LATE_S = 0.012
"""The delay of a late answer."""

PIECES_S = 0.0005
"""The pause between the pieces of an answer in pieces."""

_BAUD_TOLERANCE = 0.03

OnInstruction = Callable[[Instruction, float], None]


class DynamixelBus:
    """Servos and perhaps a dongle from power-up on; `on_instruction` gets each sound packet and the time of its end."""

    def __init__(
        self,
        servos: Iterable[AxServo],
        *,
        dongle: Usb2Ax | None = None,
        timing: BusTiming | None = None,
        faults: DynamixelFaults | None = None,
        seed: int = 0,
        on_instruction: OnInstruction | None = None,
    ) -> None:
        self.servos = tuple(servos)
        self.timing = timing or BusTiming()
        self.baud = 1_000_000.0
        self._dongle = dongle
        self._on_instruction = on_instruction
        self._random = Random(seed)
        self._faults = DynamixelFaults()
        self._supplied = True
        self._reader = InstructionReader()
        self._babble = Babble(self._random)
        self._outbox = Outbox()
        self._host_free = self._answered = 0.0
        self._by_id: dict[int, list[AxServo]] = {}
        self._index()
        self.faults = faults or DynamixelFaults()

    @property
    def faults(self) -> DynamixelFaults:
        """Return the faults; setting them takes effect at once."""
        return self._faults

    @faults.setter
    def faults(self, faults: DynamixelFaults) -> None:
        self._faults = faults
        for servo in self.servos:
            number = servo.id
            servo.power(on=self._supplied and not (faults.brown_out or number in faults.unpowered))
            servo.suffer(hot=number in faults.hot, strained=number in faults.overload)
            servo.wrong_model = number in faults.wrong_model
        self._index()

    @property
    def supplied(self) -> bool:
        """Return whether the servos have power."""
        return self._supplied

    @supplied.setter
    def supplied(self, on: bool) -> None:
        if on != self._supplied:
            self._supplied = on
            self.faults = self._faults

    def feed(self, data: bytes, now: float, baud: float | None = None) -> bytes:
        """Receive bytes that the host sends at a rate; return the bytes that have reached the host so far."""
        self.baud = baud or self.baud
        answers = self.poll(now)
        begin = max(now + self.timing.usb_us * 0.5e-6, self._host_free)
        self._host_free = begin + len(data) * self._byte_s
        if self._faults.echo:
            self._outbox.arrive(data, self._host_free)
        for instruction in self._reader.feed(data, now):
            end = begin + instruction.end * self._byte_s
            if end - instruction.size * self._byte_s < self._answered:
                self._collide(now)
            else:
                self._take(instruction, end)
        return answers + self.poll(now)

    def poll(self, now: float) -> bytes:
        """Return the bytes that have reached the host so far."""
        if self._faults.babbling:
            self._outbox.arrive(self._babble.due(now), now)
        return self._outbox.due(now)

    def next_due(self) -> float | None:
        """Return when the next bytes reach the host."""
        dues = (self._outbox.next_due(), self._babble.next_at if self._faults.babbling else None)
        return min((at for at in dues if at is not None), default=None)

    # Packets.

    @property
    def _byte_s(self) -> float:
        return 10.0 / self.baud

    def _take(self, instruction: Instruction, end: float) -> None:
        if self._on_instruction is not None and instruction.sound:
            self._on_instruction(instruction, end)
        if self._dongle is not None and instruction.id == NUMBER:
            reply, at = self._dongle.answer(instruction, end, self._ask)
            self._answer(reply, at)
            return
        if self._dongle is not None and (stray := self._dongle.stray(instruction)):
            self._outbox.arrive(stray, end)
        if instruction.id == BROADCAST:
            for servo in self.servos:
                if self._hears(servo, end):
                    servo.execute(instruction, end)
            self._index()
        else:
            self._answer(*self._ask(instruction, end, on_line=True))

    def _ask(self, instruction: Instruction, at: float, *, on_line: bool = False) -> tuple[bytes | None, float]:
        """Return the servos' answer to a packet, and its time; it begins `at`, or has been on the line until then."""
        if not on_line:
            at += instruction.size * self._byte_s
        replies = []
        end = at
        for servo in self._by_id.get(instruction.id, ()):
            if not self._hears(servo, at):
                continue
            begin = self._begins(servo, instruction, at)
            reply = servo.execute(instruction, at)
            if (
                reply is not None
                and instruction.id not in self._faults.silent
                and not strikes(self._faults.drop, self._random)
            ):
                replies.append(reply)
                end = max(end, self.timing.finished(begin, len(reply) * self._byte_s, servo.rhythm))
        if instruction.code > 2:
            self._index()
        if not replies:
            return None, at
        return self._on_line(replies, twice=instruction.id in self._faults.duplicate), end

    def _begins(self, servo: AxServo, instruction: Instruction, at: float) -> float:
        thinking_s = self.timing.thinking_s(instruction.code, max(0, len(instruction.parameters) - 1))
        return self.timing.begins(at, thinking_s, servo.return_delay_s, servo.rhythm)

    def _hears(self, servo: AxServo, at: float) -> bool:
        off = abs(servo.baud - self.baud) > _BAUD_TOLERANCE * self.baud or servo.id in self._faults.other_baud
        return servo.powered and not off and at >= servo.deaf_until

    def _index(self) -> None:
        by_id: dict[int, list[AxServo]] = {}
        for servo in self.servos:
            by_id.setdefault(servo.id, []).append(servo)
        self._by_id = by_id

    # Answers.

    def _on_line(self, replies: list[bytes], *, twice: bool) -> bytes:
        """Return the bytes of servos that answer at once: a low level wins."""
        seen = replies[0]
        for other in replies[1:]:
            seen = bytes(a & (b << 1 | 1) for a, b in zip(seen, other, strict=False))
        if twice:
            seen = bytes(byte & (byte << 1 | 1) for byte in seen)
        babbled = self._faults.babbling and self._random.random() < 0.3
        return flip_one_bit(seen, self._random) if babbled or strikes(self._faults.bit_flip, self._random) else seen

    def _answer(self, reply: bytes | None, at: float) -> None:
        """Send an answer, which is over `at`, to the host."""
        if reply is None:
            return
        self._answered = at
        faults, dongle = self._faults, self._dongle
        if strikes(faults.stray, self._random):
            self._outbox.arrive(STRAY, at)
        if strikes(faults.garbage, self._random):
            self._outbox.arrive(noise(self._random), at)
        if strikes(faults.half, self._random):
            reply = reply[: self._random.randrange(len(reply))]
        due = at + self.timing.usb_us * 0.5e-6 + (dongle.held_s(len(reply)) if dongle is not None else 0.0)
        if strikes(faults.late, self._random):
            due += LATE_S
        if strikes(faults.pieces, self._random):
            cut = self._random.randrange(1, max(2, len(reply)))
            self._outbox.arrive(reply[:cut], due)
            reply, due = reply[cut:], due + PIECES_S
        self._outbox.arrive(reply, due)

    def _collide(self, now: float) -> None:
        """Drop the bytes on the line."""
        self._outbox.lose_after(now)
        self._answered = 0.0
