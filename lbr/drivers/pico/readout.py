"""One sweep over the supply's registers: each is checked, and read again if it fails. No I/O."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from lbr.drivers.pico import PicoSettings, registers
from lbr.errors import MalformedError
from lbr.messages.power import UpsState


class Item(NamedTuple):
    """A register to read: its name for people, its address and size, and its decoder."""

    name: str
    register: int
    word: bool
    decode: Callable[[int], Any]
    essential: bool = True
    command: bool = False


def items(settings: PicoSettings, cell: registers.Cell | None) -> tuple[Item, ...]:
    """Return the registers of a sweep, in order: the running counter first and last, the chemistry only if `cell` is
    None."""
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
    """A sweep in progress: the remaining registers, the values, and the failures."""

    items: list[Item]
    retries: int
    values: dict[str, Any] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    blind: bool = False
    tries: int = 0

    @property
    def next(self) -> Item | None:
        """Return the next register; None at the end, which is early if an essential one fails."""
        return self.items[0] if self.items and not self.blind else None

    def take(self, bits: int) -> None:
        """Store a value; undecodable bits are read again."""
        try:
            self.values[self.items[0].name] = self.items[0].decode(bits)
        except MalformedError as err:
            self.fail(str(err))
        else:
            self._go_on()

    def fail(self, why: str) -> None:
        """Count a failed reading; after the last retry the sweep continues without it, or ends if it is essential."""
        self.tries += 1
        if self.tries > self.retries:
            self.missing[f"{self.items[0].name} (register {self.items[0].register:#04x})"] = why
            self.blind = self.items[0].essential
            self._go_on()

    def state(self, firmware: str, cell: registers.Cell | None, relay_on: int) -> UpsState:
        """Return the state: invalid, with the reason, if anything essential is missing or the supply hangs."""
        unread = "; ".join(f"{name} cannot be read: {why}" for name, why in self.missing.items())
        if self.blind:
            return UpsState(valid=False, reason=unread, code="unreachable", firmware=firmware)
        values = self.values
        if values["counter"] == values["counter again"]:
            reason = "the supply hangs: its running counter stands still, so its numbers may be old"
            return UpsState(valid=False, reason=reason, code="stale_sensor", firmware=firmware)
        relay = values.get("relay")
        return UpsState(
            valid=True,
            reason=unread,
            code="stale_sensor" if unread else "",
            source=values["source"],
            external_v=values["external_v"],
            battery_v=values["battery_v"],
            output_v=values["output_v"],
            charge=None if cell is None else round(registers.charge(values["battery_v"], cell), 3),
            charging=values.get("charging"),
            temperature_c=values.get("temperature_c"),
            relay=None if relay is None else relay == bool(relay_on),
            firmware=firmware,
        )

    def _go_on(self) -> None:
        self.tries = 0
        self.items.pop(0)
