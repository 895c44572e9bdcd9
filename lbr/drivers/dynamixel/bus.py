"""Transactions on a servo bus, one at a time: asked, answered or given up, counted. For one thread.

with open_bus("/dev/ttyACM0") as bus:
    print(bus.scan())                                     # [1, 2, 3]
    for servo, motion in zip((1, 2), bus.read_motions((1, 2))):
        print(servo, motion and motion.position_rad)
    bus.put(1, table.GOAL_POSITION, 512)
    bus.write_all(table.MOVING_SPEED.address, {servo: table.MOVING_SPEED.encode(30) for servo in (1, 2)})
"""

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from struct import Struct

from lbr.capability.context import Device
from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.packet import ADAPTER, adapter_sync_read, error_mask, error_names
from lbr.drivers.dynamixel.table import MODEL_NUMBER, MOTION_ADDRESS, MOTION_BYTES, POSITION_STEPS, Motion
from lbr.drivers.servos.contract import SlowState
from lbr.drivers.servos.line import ServoLine, open_servo_line
from lbr.drivers.servos.protocol1 import packet
from lbr.drivers.servos.protocol1.bus import MARGIN_S, ProtocolBus
from lbr.drivers.servos.protocol1.question import Question

ADAPTER_MODEL = 0x4201
ADAPTER_SERVOS = 30
ADAPTER_SILENCE_S = 0.0012
"""The time that a USB2AX waits for each servo that does not answer."""
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


class Bus(ProtocolBus):
    """A bus of AX-12A; `adapter` is the firmware version of its USB2AX, or None. See `ProtocolBus`."""

    refusals = error_mask("angle_limit", "range", "instruction", "checksum")
    together_errors = False
    """The adapter's sync read gives motions without error bits."""

    def __init__(
        self,
        line: ServoLine,
        *,
        retries: int = 1,
        clock: Callable[[], float] = time.monotonic,
        urgent: Callable[[], object] = lambda: False,
    ) -> None:
        super().__init__(line, retries=retries, clock=clock, urgent=urgent)
        self.adapter: int | None = None
        self._motions: dict[int, Question] = {}
        self._together: dict[tuple[int, ...], Question] = {}

    def error_names(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""
        return error_names(error)

    def read_motion(self, servo: int) -> Motion | None:
        """Return position, speed and load of one servo."""
        question = self._motions.get(servo)
        if question is None:
            question = self.question(servo, packet.read(servo, MOTION_ADDRESS, MOTION_BYTES), MOTION_BYTES)
            self._motions[servo] = question
        answer = self.ask(question)
        if answer is None:
            return None
        motion = Motion._make(_MOTION.unpack(answer))
        return motion if motion.position <= POSITION_STEPS else None

    def read_motions(self, servos: Sequence[int]) -> list[Motion | None]:
        """Return position, speed and load of each servo, with one request where the adapter supports it."""
        if self.adapter is None:
            return [self.read_motion(servo) for servo in servos]
        motions: list[Motion | None] = []
        for first in range(0, len(servos), ADAPTER_SERVOS):
            together = tuple(servos[first : first + ADAPTER_SERVOS])
            motions += self.read_together(together) or [None] * len(together)
        return motions

    def read_together(self, servos: tuple[int, ...]) -> list[Motion | None] | None:
        """Return the motions by the adapter's sync read, without error bits; None if the adapter did not answer."""
        question = self._together.get(servos)
        if question is None:
            request = adapter_sync_read(MOTION_ADDRESS, MOTION_BYTES, servos)
            plain = self.question(ADAPTER, request, MOTION_BYTES * len(servos))
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

    @property
    def together(self) -> bool:
        """Return whether an adapter reads several servos by one request."""
        return self.adapter is not None

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion | None, SlowState] | None:
        """Return motion, torque, goal, limit and supply of one servo, read once; None if it fails, see `trouble`."""
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
        self.write_each(table.GOAL_POSITION, goals)

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal and speed at the same time."""
        encode, speed_of = table.GOAL_POSITION.encode, table.MOVING_SPEED.encode
        blocks = {servo: encode(goal) + speed_of(speed) for servo, (goal, speed) in goals.items()}
        self.write_all(table.GOAL_POSITION.address, blocks)

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit at the same time."""
        self.write_each(table.TORQUE_LIMIT, limits)

    def torque_off(self, servos: Collection[int]) -> None:
        """Switch the torque of all of them off at the same time."""
        self.write_each(table.TORQUE_ENABLE, dict.fromkeys(servos, 0))

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Switch a servo's torque on where it stands; return that position, or the reason for a failure."""
        motion = self.read_motion(servo)
        if motion is None:
            return self.trouble
        goal = table.GOAL_POSITION.encode(motion.position)
        block = goal + table.MOVING_SPEED.encode(speed) + table.TORQUE_LIMIT.encode(limit)
        if not self.write(servo, table.GOAL_POSITION.address, block):
            return "does not take the position where it is for its goal; look at its own angle limits"
        if not self.put(servo, table.TORQUE_ENABLE, 1) and self.get(servo, table.TORQUE_ENABLE) != 1:
            return "does not acknowledge its torque"
        return motion.position

    def find_adapter(self) -> int | None:
        """Check whether the adapter is a USB2AX, whose sync read is then used; return its firmware version."""
        answer = self.read(ADAPTER, 0, 4)
        known = answer is not None and MODEL_NUMBER.decode(answer.params) == ADAPTER_MODEL
        self.adapter = answer.params[2] if answer is not None and known else None
        return self.adapter


def open_bus(path: str, *, baud: int = 1_000_000, margin_s: float = MARGIN_S, retries: int = 1) -> Bus:
    """Open a servo bus for this process alone, by the path of its tty, `usb:VID:PID` or `by-id:GLOB`."""
    return Bus(open_servo_line(Device("servos", "dynamixel", path, {}), baud, margin_s), retries=retries)


def _motion_of(block: bytes) -> Motion | None:
    if block == _PADDING:
        return None
    motion = Motion(0, *_MOTION_DATA.unpack(block))
    return motion if motion.position <= POSITION_STEPS else None
