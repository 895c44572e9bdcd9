"""One look at everything the supply measures: register after register, each tried again, each checked. No I/O."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lbr.drivers.pico import PicoSettings, registers
from lbr.errors import MalformedError
from lbr.messages.power import UpsState


class Item(NamedTuple):
    """A register to read: what it is to people, where, its size, and how its bits are understood."""

    name: str
    register: int
    word: bool
    decode: Callable[[int], Any]
    essential: bool = True
    command: bool = False


def items(settings: PicoSettings, cell: registers.Cell | None) -> tuple[Item, ...]:
    """Return what is read in one sweep, in order; the running counter comes first and last, `cell` None asks for it."""
    temperature = registers.NTC if settings.temperature_sensor == "ntc" else registers.TO92
    ask = () if cell is not None else (Item("chemistry", registers.CHEMISTRY, False, registers.chemistry, False, True),)
    return (
        Item("counter", registers.COUNTER, True, int),
        Item("source", registers.MODE, False, registers.source),
        Item("external_v", registers.EXTERNAL, True, registers.volts),
        Item("battery_v", registers.BATTERY, True, registers.volts),
        Item("output_v", registers.OUTPUT, True, registers.volts),
        *ask,
        Item("temperature_c", temperature, False, registers.celsius, False),
        Item("charging", registers.CHARGER, False, registers.charging, False),
        Item("relay", registers.RELAY, False, registers.flag, False, True),
        Item("counter again", registers.COUNTER, True, int),
    )


@dataclass(slots=True)
class Readout:
    """A sweep under way: what comes next, what came, and what did not."""

    left: list[Item]
    retries: int
    found: dict[str, Any] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    blind: bool = False
    tries: int = 0

    @property
    def next(self) -> Item | None:
        """Return what is to be read now; None: it is over, early if something essential does not come."""
        return self.left[0] if self.left and not self.blind else None

    def take(self, bits: int) -> None:
        """Take in what was read; bits that mean nothing are read again."""
        try:
            self.found[self.left[0].name] = self.left[0].decode(bits)
        except MalformedError as err:
            self.fail(str(err))
        else:
            self._go_on()

    def fail(self, why: str) -> None:
        """Note that reading gave nothing; after the last retry the rest goes on without, unless it is essential."""
        self.tries += 1
        if self.tries > self.retries:
            self.missing[f"{self.left[0].name} (register {self.left[0].register:#04x})"] = why
            self.blind = self.left[0].essential
            self._go_on()

    def state(self, firmware: str, cell: registers.Cell | None, relay_on: int) -> UpsState:
        """Return what it all says: invalid, with the reason, if anything essential is missing or the supply hangs."""
        said = "; ".join(f"{name} cannot be read: {why}" for name, why in self.missing.items())
        if self.blind:
            return UpsState(valid=False, reason=said, firmware=firmware)
        found = self.found
        if found["counter"] == found["counter again"]:
            reason = "the supply hangs: its running counter stands still, so its numbers may be old"
            return UpsState(valid=False, reason=reason, firmware=firmware)
        relay = found.get("relay")
        return UpsState(
            valid=True,
            reason=said,
            source=found["source"],
            external_v=found["external_v"],
            battery_v=found["battery_v"],
            output_v=found["output_v"],
            charge=None if cell is None else round(registers.charge(found["battery_v"], cell), 3),
            charging=found.get("charging"),
            temperature_c=found.get("temperature_c"),
            relay=None if relay is None else relay == bool(relay_on),
            firmware=firmware,
        )

    def _go_on(self) -> None:
        self.tries = 0
        self.left.pop(0)
