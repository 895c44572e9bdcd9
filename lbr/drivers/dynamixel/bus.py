"""Transactions on a servo bus, one at a time: asked, answered or given up, counted. For one thread.

with open_bus("/dev/ttyACM0") as bus:
    print(bus.scan())                                     # [1, 2, 3]
    for servo, motion in zip((1, 2), bus.read_motions((1, 2))):
        print(servo, motion and motion.position_rad)
    bus.put(1, table.GOAL_POSITION, 512)
    bus.write_all(table.MOVING_SPEED.address, {servo: table.MOVING_SPEED.encode(30) for servo in (1, 2)})
"""

import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import inf
from struct import Struct
from types import TracebackType
from typing import Literal, Self

from lbr.capability.context import Device
from lbr.drivers.dynamixel import packet, table
from lbr.drivers.dynamixel.line import ServoLine, open_servo_line
from lbr.drivers.dynamixel.packet import Status, StatusParser
from lbr.drivers.dynamixel.question import GOOD_SUM, Question, packet_in
from lbr.drivers.dynamixel.table import MODEL_NUMBER, MOTION_ADDRESS, MOTION_BYTES, POSITION_STEPS, Motion, Register
from lbr.drivers.servos.contract import Counts, SlowState

MARGIN_S = 0.01
QUIET_S = 0.002
"""A line that says nothing for so long has ended its answer, if that is long enough to be one."""
LISTEN_SLICE_S = 0.002
WARY_S = 1.0
"""For so long after an answer was lost the line is emptied before each request."""
LATE_S = 0.01
"""A lost answer may still come so late: who is asked the same again waits for that, lest it pass for the next."""
ADAPTER_MODEL = 0x4201
ADAPTER_SERVOS = 30
ADAPTER_SILENCE_S = 0.0012
"""What a USB2AX waits for each servo that does not answer."""
MOST_BYTES = 4096
_REFUSALS = packet.error_mask("angle_limit", "range", "instruction", "checksum")
_MOTION = Struct("<4xB3Hx")
_MOTION_DATA = Struct("<3H")
_PADDING = b"\xff" * MOTION_BYTES
STATE_ADDRESS, STATE_BYTES = table.TORQUE_ENABLE.address, 20
_STATE_REGISTERS = (
    table.TORQUE_ENABLE,
    table.GOAL_POSITION,
    table.MOVING_SPEED,
    table.TORQUE_LIMIT,
    table.PRESENT_POSITION,
    table.PRESENT_SPEED,
    table.PRESENT_LOAD,
    table.PRESENT_VOLTAGE,
    table.PRESENT_TEMPERATURE,
)


class Bus:
    """One servo bus. Lost answers are None, `trouble` then says why and `lost` how; a line that is gone is a DeviceError.

    `written_all` counts what was written to several servos at once. `urgent` is asked while the bus waits although the wire is free, and between tries: the rest is left undone then,
    and `cut_short` tells.
    """

    def __init__(
        self,
        line: ServoLine,
        *,
        retries: int = 1,
        clock: Callable[[], float] = time.monotonic,
        urgent: Callable[[], object] = lambda: False,
    ) -> None:
        self.counts = Counts()
        self.strays: Counter[int] = Counter()
        self.trouble = ""
        self.lost: Literal["", "silent", "garbled", "refused"] = ""
        self.refused = 0
        self.cut_short = False
        self.written_all = 0
        self.echo = False
        self.adapter: int | None = None
        self._line = line
        self._tries = retries + 1
        self._clock = clock
        self._urgent = urgent
        self._wary_until = 0.0
        self._late: dict[bytes, float] = {}
        self._motions: dict[int, Question] = {}
        self._together: dict[tuple[int, ...], Question] = {}

    def ping(self, servo: int, *, tries: int | None = None) -> Status | None:
        """Ask a servo whether it is there; its error bits are in the answer."""
        question = self._question(servo, packet.ping(servo), 0)
        answer = self.ask(question, tries)
        if answer == question.request:  # the echo, or a servo that complains of its voltage: both look like this
            return self.read(servo, 0, 1)
        return _status(answer)

    def read(
        self, servo: int, address: int, count: int, *, tries: int | None = None, patience_s: float = inf
    ) -> Status | None:
        """Return `count` bytes of a servo's control table; an answer later than wire and servo explain gets `patience_s`."""
        return _status(self.ask(self._question(servo, packet.read(servo, address, count), count), tries, patience_s))

    def get(self, servo: int, register: Register) -> int | None:
        """Return the value of a register."""
        status = self.read(servo, register.address, register.size)
        return None if status is None else register.decode(status.params, register.address)

    def put(self, servo: int, register: Register, value: int) -> bool:
        """Write a register and say whether the servo acknowledged it; a ValueError for what it would refuse."""
        return self.write(servo, register.address, register.encode(value))

    def write(self, servo: int, address: int, data: bytes, *, tries: int | None = None) -> bool:
        """Write bytes and say whether the servo acknowledged them, without complaining of them."""
        status = _status(self.ask(self._question(servo, packet.write(servo, address, data), 0), tries))
        return status is not None and not status.error & _REFUSALS

    def write_all(self, address: int, blocks: Mapping[int, bytes]) -> None:
        """Give each servo its block at the same time; nobody answers that."""
        if blocks:
            for request in packet.sync_write(address, blocks):
                self._line.send(request)
            self.written_all += 1

    def read_motion(self, servo: int) -> Motion | None:
        """Return position, speed and load of one servo."""
        question = self._motions.get(servo)
        if question is None:
            question = self._question(servo, packet.read(servo, MOTION_ADDRESS, MOTION_BYTES), MOTION_BYTES)
            self._motions[servo] = question
        answer = self.ask(question)
        if answer is None:
            return None
        motion = Motion._make(_MOTION.unpack(answer))
        return motion if motion.position <= POSITION_STEPS else None

    def read_motions(self, servos: Sequence[int]) -> list[Motion | None]:
        """Return position, speed and load of each; by one request where the adapter can do that."""
        if self.adapter is None:
            return [self.read_motion(servo) for servo in servos]
        found: list[Motion | None] = []
        for first in range(0, len(servos), ADAPTER_SERVOS):
            together = tuple(servos[first : first + ADAPTER_SERVOS])
            found += self.read_together(together) or [None] * len(together)
        return found

    def read_together(self, servos: tuple[int, ...]) -> list[Motion | None] | None:
        """Return the same by the adapter's sync read, without error bits; None if the adapter did not answer."""
        question = self._together.get(servos)
        if question is None:
            request = packet.adapter_sync_read(MOTION_ADDRESS, MOTION_BYTES, servos)
            plain = self._question(packet.ADAPTER, request, MOTION_BYTES * len(servos))
            asked_bytes = 8 * len(servos) + len(request)
            busy_s = self._line.busy_s(asked_bytes, 2 * plain.size, len(servos))
            within_s = busy_s + ADAPTER_SILENCE_S * len(servos) + self._line.margin_s
            question = Question(plain.servo, request, plain.head, plain.size, busy_s, within_s)
            self._together = {servos: question}
        answer = self.ask(question)
        if answer is None:
            return None
        blocks = (answer[first : first + MOTION_BYTES] for first in range(5, len(answer) - 1, MOTION_BYTES))
        return [_motion_of(block) for block in blocks]

    together_errors = False
    """The adapter's sync read gives motions without error bits."""

    @property
    def together(self) -> bool:
        """Whether an adapter reads several servos by one request."""
        return self.adapter is not None

    def read_singly(self) -> None:
        """Do without the adapter's sync read."""
        self.adapter = None

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion | None, SlowState] | None:
        """Return motion, torque, goal, limit and supply of one servo, asked once; None: see `trouble`."""
        status = self.read(servo, STATE_ADDRESS, STATE_BYTES, tries=1, patience_s=patience_s)
        if status is None:
            return None
        value = {register: register.decode(status.params, STATE_ADDRESS) for register in _STATE_REGISTERS}
        slow = SlowState(
            at=self._clock(),
            enabled=bool(value[table.TORQUE_ENABLE]),
            goal=value[table.GOAL_POSITION],
            speed=value[table.MOVING_SPEED],
            limit=value[table.TORQUE_LIMIT],
            voltage_v=value[table.PRESENT_VOLTAGE] / 10.0,
            temperature_c=float(value[table.PRESENT_TEMPERATURE]),
        )
        present = (value[register] for register in (table.PRESENT_POSITION, table.PRESENT_SPEED, table.PRESENT_LOAD))
        motion = Motion(status.error, *present)
        return motion if motion.position <= POSITION_STEPS else None, slow

    def write_positions(self, goals: Mapping[int, int]) -> None:
        """Give each servo a goal at the same time."""
        self._write_all(table.GOAL_POSITION, goals)

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal and speed at the same time."""
        encode, speed_of = table.GOAL_POSITION.encode, table.MOVING_SPEED.encode
        blocks = {servo: encode(goal) + speed_of(speed) for servo, (goal, speed) in goals.items()}
        self.write_all(table.GOAL_POSITION.address, blocks)

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit at the same time."""
        self._write_all(table.TORQUE_LIMIT, limits)

    def torque_off(self, servos: Collection[int]) -> None:
        """Take the torque off all of them at the same time."""
        self._write_all(table.TORQUE_ENABLE, dict.fromkeys(servos, 0))

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Give a servo torque where it is, and return that position, or why not."""
        motion = self.read_motion(servo)
        if motion is None:
            return self.trouble
        goal = table.GOAL_POSITION.encode(motion.position)
        block = goal + table.MOVING_SPEED.encode(speed) + table.TORQUE_LIMIT.encode(limit)
        if not self.write(servo, table.GOAL_POSITION.address, block):
            return "does not take the position where it is for its goal; look at its own angle limits"
        if not self.put(servo, table.TORQUE_ENABLE, 1):
            return "does not acknowledge its torque"
        return motion.position

    def drain(self) -> None:
        """Throw away what came unasked, and notice a line that is gone."""
        self.leftover()

    def find_adapter(self) -> int | None:
        """Ask whether the adapter is a USB2AX, and return its firmware's version; its own sync read is used then."""
        answer = self.read(packet.ADAPTER, 0, 4)
        known = answer is not None and MODEL_NUMBER.decode(answer.params) == ADAPTER_MODEL
        self.adapter = answer.params[2] if answer is not None and known else None
        return self.adapter

    def scan(self, servos: Iterable[int] = range(packet.HIGHEST_ID + 1)) -> list[int]:
        """Return who answers a PING; takes some ten milliseconds for each who does not."""
        return [servo for servo in servos if self.ping(servo) is not None]

    def leftover(self) -> list[Status]:
        """Return what somebody says unasked within a moment, such as a second servo with the same id."""
        data = self._line.receive(QUIET_S)
        return StatusParser().feed(data) if data else []

    def ask(self, question: Question, tries: int | None = None, patience_s: float = inf) -> bytes | None:
        """Send a request and return the whole packet that answers it, tried again as often as agreed."""
        line = self._line
        self.cut_short = False
        for attempt in range(tries or self._tries):
            self.counts.retries += attempt > 0
            if self._wary_until:
                self._settle(question)
            line.send(question.request)
            late_s = min(patience_s, question.within_s - question.busy_s)
            data = line.receive(question.busy_s) or self._patience(late_s)
            if (
                len(data) == question.size
                and data.startswith(question.head)
                and sum(data) & 0xFF == GOOD_SUM
                and data[4] < 0x80
                and data != question.request
            ):
                return data
            found = self._sift(data, question, question.busy_s + late_s)
            if found is not None:
                return found
            if self._urgent():
                self.cut_short = True
                return None
        return None

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, err: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_all(self, register: Register, values: Mapping[int, int]) -> None:
        self.write_all(register.address, {servo: register.encode(value) for servo, value in values.items()})

    def _question(self, servo: int, request: bytes, count: int) -> Question:
        size = packet.OVERHEAD_BYTES + count
        head = packet.HEADER + bytes((servo, count + 2))
        busy_s = self._line.busy_s(len(request), size)
        return Question(servo, request, head, size, busy_s, busy_s + self._line.margin_s)

    def _sift(self, data: bytes, question: Question, within_s: float) -> bytes | None:
        """Find the answer in what comes until its time is over; judge what else there was."""
        until = self._clock() + within_s
        while True:
            rest = self._without_echo(data, question)
            found = packet_in(rest, question)
            if found is not None:
                if len(rest) > question.size:
                    self._judge(rest.replace(found, b"", 1), question)
                return found
            left_s = until - self._clock() if data else 0.0
            if len(rest) >= question.size:
                left_s = min(left_s, QUIET_S)
            more = self._patience(left_s) if len(data) < MOST_BYTES else b""
            if not more:
                break
            data += more
        self._lose(rest, question)
        return None

    def _patience(self, wait_s: float) -> bytes:
        """Return what comes in that time; not a moment longer when something is urgent."""
        until = self._clock() + wait_s
        while (left_s := until - self._clock()) > 0.0 and not self._urgent():
            data = self._line.receive(min(LISTEN_SLICE_S, left_s))
            if data:
                return data
        return b""

    def _without_echo(self, data: bytes, question: Question) -> bytes:
        """Some adapters hear themselves: what was sent comes first then, and must not pass for an answer."""
        request = question.request
        if not data.startswith(request):
            return data
        if not self.echo and len(data) == len(request) == question.size and request[4] == packet.PING:
            return data  # may be an answer as well
        self.echo = self.echo or request[4] != packet.PING
        return data[len(request) :]

    def _lose(self, data: bytes, question: Question) -> None:
        now = self._clock()
        if not data:
            self.counts.timeouts += 1
            self.trouble, self.lost = "does not answer", "silent"
        elif not self._judge(data, question):
            self.counts.corrupt += 1
            self.trouble, self.lost = "answers garbled", "garbled"
        self._late[question.head] = now + LATE_S
        self._wary_until = now + WARY_S

    def _judge(self, data: bytes, question: Question) -> bool:
        """Count what is not the answer; True if it explains why there is none."""
        parser = StatusParser()
        explained = False
        for status in parser.feed(data):
            if status.id == question.servo and len(status.params) + packet.OVERHEAD_BYTES != question.size:
                self.refused = status.error
                named = ", ".join(packet.error_names(status.error))
                self.trouble, self.lost = f"refuses: {named or 'answers too short'}", "refused"
                explained = True
            else:
                self.counts.strays += 1
                self.strays[status.id] += 1
        self.counts.babble += parser.noise + parser.held_bytes
        return explained

    def _settle(self, question: Question) -> None:
        """After a lost answer: throw away what came late, and wait until nothing can that would pass for the next one."""
        listen_until = self._late.pop(question.head, 0.0)
        while (now := self._clock()) < listen_until and not self._urgent():
            self.counts.babble += len(self._line.receive(min(LISTEN_SLICE_S, listen_until - now)))
        if now >= self._wary_until:
            self._wary_until = 0.0
            self._late.clear()
        elif late := self._line.receive(0.0):
            self.counts.babble += len(late)


def open_bus(path: str, *, baud: int = 1_000_000, margin_s: float = MARGIN_S, retries: int = 1) -> Bus:
    """Open a servo bus for this process alone, by the path of its tty, `usb:VID:PID` or `by-id:GLOB`."""
    return Bus(open_servo_line(Device("servos", "dynamixel", path, {}), baud, margin_s), retries=retries)


def _status(answer: bytes | None) -> Status | None:
    return None if answer is None else Status(answer[2], answer[4], answer[5:-1])


def _motion_of(block: bytes) -> Motion | None:
    if block == _PADDING:
        return None
    motion = Motion(0, *_MOTION_DATA.unpack(block))
    return motion if motion.position <= POSITION_STEPS else None
