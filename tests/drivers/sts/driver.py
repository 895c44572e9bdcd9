"""The driver: settings, kind, control table, bus and model; all else is `lbr.drivers.servos`."""

from collections.abc import Callable, Collection, Mapping
from math import pi
from struct import Struct
from typing import Annotated, NamedTuple

from msgspec import Meta

from lbr.capability.context import Device
from lbr.drivers.servos import RegisterServosSettings, servos_kind
from lbr.drivers.servos.contract import Seen, ServoLink, SlowState
from lbr.drivers.servos.guard import Guard
from lbr.drivers.servos.protocol1 import packet
from lbr.drivers.servos.protocol1.bus import ProtocolBus
from lbr.drivers.servos.protocol1.line import ServoLine, open_servo_line
from lbr.drivers.servos.protocol1.register import Register, as_sign_magnitude, sign_magnitude
from lbr.drivers.servos.registers import RegisterServos

MODEL_STS3215 = 777
RAD_PER_STEP = 2.0 * pi / 4096
CENTRE, LAST_STEP, FULL_TORQUE = 2048, 4095, 1000
POSITION_SIGN, LOAD_SIGN = 15, 10
MODEL = Register("model number", 3, 2, None, 0xFFFF, "")
TORQUE_ENABLE = Register("torque enable", 40, 1, 0, 128, "")
GOAL = Register("goal position", 42, 2, 0, 0xFFFF, "4096 a turn")
SPEED = Register("goal speed", 46, 2, 0, 0x7FFF, "steps/s")
LIMIT = Register("torque limit", 48, 2, 0, 1000, "0.1 %")
PRESENT, PRESENT_BYTES = 56, 15
STATE, STATE_BYTES = 40, 31
_PRESENT = Struct("<3HBB")
_STATE = Struct("<BxHxxHH6x3HBB")
ERRORS = {0: "voltage", 1: "sensor", 2: "overheat", 3: "current", 5: "overload"}
OVERLOAD = 0x20
RELEASE = "tests.drivers.sts.release"


class StsSettings(RegisterServosSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row may set."""

    reply_margin_s: Annotated[float, Meta(ge=0.001, le=0.1)] = 0.004


KIND = servos_kind("feetech", "a bus of Feetech STS3215 servos", "tests.drivers.sts.driver:Sts", StsSettings)


class Motion(NamedTuple):
    """Position, speed and load as 56..61 give them, and the error bits that came with them."""

    error: int
    position: int
    speed: int
    load: int

    @property
    def position_rad(self) -> float:
        """Radians from the middle."""
        return position_rad(self.position)

    @property
    def speed_rps(self) -> float:
        """Radians a second."""
        return self.speed * RAD_PER_STEP

    @property
    def load_fraction(self) -> float:
        """Fraction of its most."""
        return self.load / FULL_TORQUE


def position_rad(raw: int) -> float:
    """Return the angle of a position."""
    return (raw - CENTRE) * RAD_PER_STEP


def motion(error: int, position: int, speed: int, load: int) -> Motion:
    """Return a motion of numbers whose sign is a bit."""
    signed = (sign_magnitude(position, POSITION_SIGN), sign_magnitude(speed, POSITION_SIGN))
    return Motion(error, *signed, sign_magnitude(load, LOAD_SIGN))


class StsBus(ProtocolBus):
    """The bus; all servos are read by one SYNC READ, which each answers with its own error bits."""

    together_errors = True
    together = True

    def error_names(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""
        return tuple(name for bit, name in ERRORS.items() if error >> bit & 1)

    def read_singly(self) -> None:
        """Do without SYNC READ."""
        self.together = False

    def read_motion(self, servo: int) -> Motion | None:
        """Return the motion of one servo."""
        status = self.read(servo, PRESENT, PRESENT_BYTES)
        return None if status is None else motion(status.error, *_PRESENT.unpack_from(status.params)[:3])

    def read_together(self, servos: tuple[int, ...]) -> list[Motion | None] | None:
        """Return the motion of each by one request."""
        found = self.ask_each(packet.sync_read(PRESENT, PRESENT_BYTES, servos), servos, PRESENT_BYTES)
        if not found:
            return None
        seen = {one: motion(status.error, *_PRESENT.unpack_from(status.params)[:3]) for one, status in found.items()}
        return [seen.get(servo) for servo in servos]

    def read_state(self, servo: int, patience_s: float) -> tuple[Motion, SlowState] | None:
        """Return all of one servo."""
        status = self.read(servo, STATE, STATE_BYTES, tries=1, patience_s=patience_s)
        if status is None:
            return None
        enabled, goal, speed, limit, *present, tenths, celsius = _STATE.unpack_from(status.params)
        goal = sign_magnitude(goal, POSITION_SIGN)
        slow = SlowState(self._clock(), bool(enabled), goal, speed, limit, tenths / 10.0, float(celsius))
        return motion(status.error, *present), slow

    def write_positions(self, goals: Mapping[int, int]) -> None:
        """Give each servo a goal."""
        self.write_each(GOAL, {one: as_sign_magnitude(goal, POSITION_SIGN) for one, goal in goals.items()})

    def write_goals(self, goals: Mapping[int, tuple[int, int]]) -> None:
        """Give each servo goal, no time, and speed."""
        self.write_all(GOAL.address, {servo: self._course(*one) for servo, one in goals.items()})

    def write_limits(self, limits: Mapping[int, int]) -> None:
        """Give each servo its torque limit."""
        self.write_each(LIMIT, limits)

    def torque_off(self, servos: Collection[int]) -> None:
        """Take the torque off all of them."""
        self.write_each(TORQUE_ENABLE, dict.fromkeys(servos, 0))

    def torque_on(self, servo: int, speed: int, limit: int) -> int | str:
        """Give a servo torque where it is: goal, speed and limit first; an acknowledgement proves nothing, a read does."""
        here = self.read_motion(servo)
        if here is None:
            return self.trouble
        if not self.write(servo, GOAL.address, self._course(here.position, speed) + LIMIT.encode(limit)):
            return self.trouble
        if not self.put(servo, TORQUE_ENABLE, 1) or self.get(servo, TORQUE_ENABLE) != 1:
            return "does not take its torque"
        return here.position

    @staticmethod
    def _course(goal: int, speed: int) -> bytes:
        return GOAL.encode(as_sign_magnitude(goal, POSITION_SIGN)) + b"\0\0" + SPEED.encode(speed)


class StsModel:
    """What the numbers mean."""

    full_torque = FULL_TORQUE
    position_rad = staticmethod(position_rad)

    def position_raw(self, angle_rad: float) -> int:
        """Return the position nearest to an angle."""
        return max(0, min(LAST_STEP, CENTRE + round(angle_rad / RAD_PER_STEP)))

    def speed_raw(self, speed_rps: float | None) -> int:
        """Return the speed; 0 is as fast as it goes."""
        return 0 if speed_rps is None else max(1, min(0x7FFF, round(speed_rps / RAD_PER_STEP)))

    def torque_raw(self, fraction: float) -> int:
        """Return the torque limit of a fraction."""
        return max(0, min(FULL_TORQUE, round(fraction * FULL_TORQUE)))

    def holding_goal(self, position: int, speed: int, goal: int) -> int:
        """Return its own goal while it rests near that."""
        return goal if speed == 0 and abs(goal - position) <= 20 else position

    def most_torque(self, servo: int) -> int:
        """Return the most that it may get."""
        return FULL_TORQUE

    def latched(self, servo: int, seen: Seen) -> tuple[str, ...]:
        """An overload stands in every answer until the torque was off."""
        return ("overload",) if seen.error & OVERLOAD else ()

    def faults(self, error: int) -> tuple[str, ...]:
        """Return the names of error bits."""
        return tuple(name for bit, name in ERRORS.items() if error >> bit & 1)


class Sts(RegisterServos[StsSettings, StsBus]):
    """A bus of STS3215."""

    def connect(self, device: Device, urgent: Callable[[], bool]) -> ServoLink[StsBus]:
        """Open the line."""
        line = open_servo_line(device, self.ctx.settings.baud, self.ctx.settings.reply_margin_s)
        bus = StsBus(line, clock=self.ctx.clock, urgent=urgent)
        return ServoLink(
            bus=bus, model=StsModel(), guard=lambda: self._guard(line), recovery=recovery, prepare=prepared
        )

    def _guard(self, line: ServoLine) -> Guard:
        words = (line.baud, line.margin_s)
        return Guard(RELEASE, line.fileno(), self.ctx.settings, list(self._joints), self.ctx.clock, words=words)


def prepared(bus: StsBus, servo: int) -> str:
    """Say what is wrong with a servo."""
    model = bus.get(servo, MODEL)
    if model is None:
        return bus.trouble
    return "" if model == MODEL_STS3215 else f"is a model {model}, not an STS3215 ({MODEL_STS3215})"


def recovery(servo: int) -> Callable[[StsBus], str]:
    """Return the job that takes a servo out of an overload: without torque it clears by itself."""

    def job(bus: StsBus) -> str:
        if not bus.put(servo, TORQUE_ENABLE, 0):
            return bus.trouble
        seen = bus.read_motion(servo)
        if seen is None:
            return bus.trouble
        return "is still overloaded" if seen.error & OVERLOAD else ""

    return job
