"""The check of a servo before its use, and its recovery from faults. No value that it keeps is changed."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import inf

from lbr.drivers.servos.contract import Tell
from lbr_so101 import table
from lbr_so101.bus import FeetechBus

GARBLED = 3
COOLER_C = 5
"""A servo must be so far below its limit to count as cooled down."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The values of a servo's EEPROM on which the driver depends."""

    max_torque: int
    temperature_limit: int
    lowest_voltage: int
    highest_voltage: int
    unloading: int


class Setup:
    """Checks the values that a servo keeps, and reports why it is unusable."""

    def __init__(self, models: Collection[int], tell: Tell, *, check_phase: bool = True) -> None:
        self.kept: dict[int, Kept] = {}
        self._models = models
        self._tell = tell
        self._check_phase = check_phase
        self._garbled: dict[int, int] = {}
        self._told: dict[int, str] = {}

    def prepare(self, bus: FeetechBus, servo: int) -> str:
        """Return why a servo is unusable now, or an empty text; to be repeated later."""
        strays = bus.strays[servo]
        status = bus.read(servo, 0, table.EEPROM_BYTES, tries=1)
        if status is None:
            return self._why_not(bus, servo)
        self._garbled[servo] = 0
        twice = bus.strays[servo] > strays or any(one.id == servo for one in bus.leftover())
        wrong = self._duplicate(servo) if twice else self._wrong(status.params)
        if not wrong:
            self.kept[servo] = _kept(status.params)
        return self._said(servo, wrong)

    def recovery(self, servo: int) -> Callable[[FeetechBus], str] | None:
        """Return the job that recovers a servo from its faults, and returns why it failed; None: not known yet."""
        kept = self.kept.get(servo)
        return None if kept is None else lambda bus: _recovered(bus, servo, kept)

    def _why_not(self, bus: FeetechBus, servo: int) -> str:
        self._garbled[servo] = self._garbled.get(servo, 0) + 1 if bus.lost == "garbled" else 0
        return self._said(servo, self._duplicate(servo)) if self._garbled[servo] >= GARBLED else bus.trouble

    @staticmethod
    def _duplicate(servo: int) -> str:
        return f"answers garbled or twice: there are two servos with id {servo}, or its cable is bad"

    def _wrong(self, block: bytes) -> str:
        model, mode, phase = (register.decode(block) for register in (table.MODEL, table.MODE, table.PHASE))
        if model not in self._models:
            return f"is a model {model}, not {' or '.join(map(str, self._models))}; look at the row's models"
        if mode:
            return f"is in mode {mode} and does not go to positions; set its mode (register 33) to 0"
        if table.LOWEST.decode(block) == table.HIGHEST.decode(block) == 0:
            return "is set to turn endlessly; give it limits (registers 9 and 11)"
        if self._check_phase and (phase & table.MANY_TURNS or not phase & table.SPEED_IN_STEPS):
            return f"counts turns or speeds in another way (register 18 is {phase}); clear its bit 4 and set its bit 2"
        if not table.RESPONSE_LEVEL.decode(block):
            return "acknowledges nothing; set its response level (register 8) to 1"
        return ""

    def _said(self, servo: int, wrong: str) -> str:
        """Report it once, not at each look."""
        if wrong and self._told.get(servo) != wrong:
            self._tell("servo_wrong", f"servo {servo} {wrong}", "warning")
        self._told[servo] = wrong
        return wrong


def _recovered(bus: FeetechBus, servo: int, kept: Kept) -> str:
    """Switch its torque off, which ends an overload, and return the remaining faults."""
    bus.put(servo, table.TORQUE_ENABLE, 0)
    state = bus.read_state(servo, inf)
    if state is None:
        return bus.trouble
    (error, *_), slow = state
    if slow.enabled:
        return "keeps its torque"
    cool = kept.temperature_limit - COOLER_C
    if error & table.OVERHEAT or slow.temperature_c > cool:
        return f"is still too hot: {slow.temperature_c:g} degrees C, and {cool} are allowed; let it cool down"
    if error & table.VOLTAGE:
        allowed = f"{kept.lowest_voltage / 10:g} to {kept.highest_voltage / 10:g} V"
        return f"has {slow.voltage_v:g} V, outside {allowed}; look at its supply"
    left = table.error_names(error & (kept.unloading | table.OVERLOAD))
    return f"still reports {', '.join(left)}" if left else ""


def _kept(block: bytes) -> Kept:
    return Kept(
        max_torque=table.MAX_TORQUE.decode(block),
        temperature_limit=table.MAX_TEMPERATURE.decode(block),
        lowest_voltage=table.MIN_VOLTAGE.decode(block),
        highest_voltage=table.MAX_VOLTAGE.decode(block),
        unloading=table.UNLOADING.decode(block),
    )
