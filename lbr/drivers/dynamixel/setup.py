"""Check and setup of a servo before its use, without motion: its identity and its EEPROM."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus, open_bus
from lbr.drivers.servos.contract import SETTING_UP
from lbr.drivers.servos.protocol1.register import Register
from lbr.errors import DeviceError

EEPROM_BYTES = table.RAM
TRIES = 2
GARBLED = 3
QUIET_S = 0.5
BAUDS = (1_000_000, 500_000, 400_000, 250_000, 200_000, 115_200, 57_600, 19_200, 9_600)


@dataclass(frozen=True, slots=True)
class Kept:
    """The EEPROM registers of a servo on which the driver relies."""

    firmware: int
    max_torque: int
    temperature_limit: int
    lowest_voltage: int
    highest_voltage: int
    shutdown: int


class Setup:
    """Checks a servo and writes the wanted values to its EEPROM: only where they differ, without torque, with a check.

    It writes one value at a call: the servo `is being set up` until the next call, with no wait between. `done` lists
    the servos that were set up, with the values written.
    """

    def __init__(
        self,
        wanted: Sequence[tuple[Register, int]],
        tell: Callable[[str, str, str], None] = lambda _kind, _text, _level: None,
    ) -> None:
        self.kept: dict[int, Kept] = {}
        self.done: tuple[tuple[int, str], ...] = ()
        self._wanted = tuple(wanted)
        self._tell = tell
        self._written: dict[int, dict[Register, int]] = {}
        self._garbled: dict[int, int] = {}
        self._warned: dict[int, str] = {}

    def prepare(self, bus: Bus, servo: int) -> str:
        """Return why a servo cannot be used now, or an empty string; then call it again later."""
        strays = bus.strays[servo]
        block = self._eeprom(bus, servo)
        if block is None:
            return self._why_not(bus, servo)
        self._garbled[servo] = 0
        wrong = self._wrong(bus, servo, block, twice=bus.strays[servo] > strays)
        if wrong:
            self._warn(servo, wrong)
            return wrong
        if self._write(bus, servo, block):
            return SETTING_UP
        self.kept[servo] = _eeprom_of(block)
        return ""

    def _eeprom(self, bus: Bus, servo: int) -> bytes | None:
        status = bus.read(servo, 0, EEPROM_BYTES, tries=1)
        if status is not None or bus.lost != "silent" or bus.cut_short:
            return None if status is None else status.params
        if servo not in self.kept and bus.ping(servo, tries=1) is not None:  # set its return level
            bus.write(servo, table.RETURN_LEVEL.address, table.RETURN_LEVEL.encode(2), tries=1)
            bus.trouble, bus.lost = SETTING_UP, ""
        return None

    def _why_not(self, bus: Bus, servo: int) -> str:
        if bus.lost != "garbled":
            return bus.trouble
        self._garbled[servo] = self._garbled.get(servo, 0) + 1
        if self._garbled[servo] < GARBLED:
            return bus.trouble
        wrong = f"answers garbled: there are two servos with id {servo}, or its cable is bad"
        self._warn(servo, wrong)
        return wrong

    def _wrong(self, bus: Bus, servo: int, block: bytes, *, twice: bool) -> str:
        model = table.MODEL_NUMBER.decode(block)
        if model != table.MODEL:
            return f"is a model {model}, not an AX-12A ({table.MODEL})"
        if twice or any(status.id == servo for status in bus.leftover()):
            return f"answers twice: there are two servos with id {servo}; give one of them another"
        if table.CW_LIMIT.decode(block) == table.CCW_LIMIT.decode(block) == 0:
            return "is set to turn endlessly; give it angle limits"
        return ""

    def _write(self, bus: Bus, servo: int, block: bytes) -> bool:
        """Write the next value that differs, and publish it; the servo does not answer for a while then."""
        written = self._written.setdefault(servo, {})
        different = [(register, value) for register, value in self._wanted if register.decode(block) != value]
        names = ", ".join(f"{register.name} ({register.decode(block)}, not {value})" for register, value in different)
        due = [(register, value) for register, value in different if written.get(register, 0) < TRIES]
        if due and bus.get(servo, table.TORQUE_ENABLE) != 0:
            self._warn(servo, f"keeps its {names}: it has torque; restart the driver without")
            return False
        if due:
            register, value = due[0]
            written[register] = written.get(register, 0) + 1
            bus.put(servo, register, value)
            return True
        if different:
            self._warn(servo, f"does not take {names}")
        elif written:
            self.done = (*self.done, (servo, ", ".join(one.name for one in written)))
        self._written[servo] = {}
        return False

    def _warn(self, servo: int, wrong: str) -> None:
        """Publish a warning once, not at each check."""
        if self._warned.get(servo) != wrong:
            self._warned[servo] = wrong
            self._tell("servo_wrong", f"servo {servo} {wrong}", "warning")


class SetupNews:
    """Publishes the EEPROM values that servos were given, one sentence for each set of values, once no more follow."""

    def __init__(self, setup: Setup, clock: Callable[[], float], tell: Callable[[str, str, str], None]) -> None:
        self._setup = setup
        self._clock = clock
        self._tell = tell
        self._done = self._told_of = 0
        self._done_at = -inf

    def step(self) -> None:
        """Publish the pending sentences, if any; runs in the loop's thread."""
        done, now = self._setup.done, self._clock()
        if len(done) > self._done:
            self._done, self._done_at = len(done), now
        elif len(done) > self._told_of and now - self._done_at >= QUIET_S:
            for what in dict.fromkeys(names for _, names in done[self._told_of :]):
                servos = sorted(servo for servo, names in done[self._told_of :] if names == what)
                whom = f"servo {servos[0]}" if len(servos) == 1 else f"servos {', '.join(map(str, servos))}"
                self._tell("servo_set_up", f"{whom}: set {what}", "info")
            self._told_of = len(done)


def find_servos(
    path: str, bauds: Sequence[int] = BAUDS, servos: Sequence[int] = range(253)
) -> Iterator[tuple[int, int]]:
    """Search for servos at every usual speed; yield baud and id. Takes some seconds a baud, so only on request."""
    for baud in bauds:
        try:
            with open_bus(path, baud=baud, margin_s=0.005, retries=0) as bus:
                yield from ((baud, servo) for servo in bus.scan(servos))
        except DeviceError:
            if baud == bauds[0]:
                raise  # not a question of speed


def _eeprom_of(block: bytes) -> Kept:
    return Kept(
        firmware=table.FIRMWARE.decode(block),
        max_torque=table.MAX_TORQUE.decode(block),
        temperature_limit=table.TEMPERATURE_LIMIT.decode(block),
        lowest_voltage=table.MIN_VOLTAGE.decode(block),
        highest_voltage=table.MAX_VOLTAGE.decode(block),
        shutdown=table.SHUTDOWN.decode(block),
    )
