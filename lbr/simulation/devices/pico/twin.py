"""An emulated UPS PIco, register by register. Status answers at its address, commands two above.

The manual leaves gaps. This device assumes: it switches to its battery below 7 V and back above 7.5 V. Without power,
only the relay keeps its state. Its registers can be read in any length, one after the other.
"""

from collections.abc import Mapping

from lbr.capability.context import Device
from lbr.simulation.devices.pico import PicoFaults, PicoRow
from lbr.simulation.i2c import I2cDevice, RegisterDevice
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.i2c import I2cTwin

ADDRESS = 0x69
COMMANDS_ABOVE = 2
LEAST_EXTERNAL_V, BACK_EXTERNAL_V = 7.0, 7.5
OUTPUT_V, FULL_V = 5.12, 4.2
RESETS_AT_ONCE, TIMER_OFF = 0x00, 0xFF

_MODE, _BATTERY, _OUTPUT, _EXTERNAL, _NTC, _TO92, _CHARGER, _COUNTER = 0x00, 0x08, 0x0A, 0x0C, 0x1B, 0x1C, 0x20, 0x22
_BOARD, _LOADER, _FIRMWARE = 0x24, 0x25, 0x26
_TIMER, _CHEMISTRY, _RELAY = 0x05, 0x07, 0x0C


class Pico:
    """The supply from power-up on; it receives the state of its source. `resets` counts the resets of its computer."""

    def __init__(self, battery_v: float = FULL_V, temperature_c: int = 33, faults: PicoFaults | None = None) -> None:
        self.external_v = 12.0
        self.battery_v = battery_v
        self.temperature_c = temperature_c
        self.relay = 0
        self.resets = 0
        self.status = _Status(self)
        self.commands = _Commands(self)
        self._faults = faults or PicoFaults()
        self._on_battery = False
        self._held_counter: int | None = None
        self.power_up()

    @property
    def faults(self) -> PicoFaults:
        """Return the faults; setting them takes effect at once."""
        return self._faults

    @faults.setter
    def faults(self, faults: PicoFaults) -> None:
        if self._faults.brown_out and not faults.brown_out:
            self.power_up()
        self._faults = faults

    def power_up(self) -> None:
        """Reset everything but the relay, which is bistable."""
        self.timer, self.timer_ends = TIMER_OFF, float("inf")
        self._held_counter = None

    def on_bus(self, address: int) -> Mapping[int, I2cDevice]:
        """Return the devices that now answer on the bus, with the status at `address`."""
        if self._faults.brown_out:
            return {}
        return {address: self.status, address + COMMANDS_ABOVE: self.commands}

    def set_timer(self, value: int, now: float) -> None:
        """Set the still-alive timer: 0 resets the computer at once."""
        self.timer = value
        self.timer_ends = now if value == RESETS_AT_ONCE else float("inf") if value == TIMER_OFF else now + value
        self.run(now)

    def run(self, now: float) -> None:
        """Advance the still-alive timer."""
        if now >= self.timer_ends:
            self.timer_ends, self.timer = float("inf"), TIMER_OFF
            self.resets += 1

    def registers(self, now: float) -> dict[int, int]:
        """Return the present status registers."""
        faults = self._faults
        external_v = self.external_v if faults.external_v is None else faults.external_v
        battery_v = self.battery_v if faults.battery_v is None else faults.battery_v
        self._on_battery = external_v < (BACK_EXTERNAL_V if self._on_battery else LEAST_EXTERNAL_V)
        on_battery = self._on_battery if faults.source is None else faults.source == "battery"
        bytes_ = {
            _MODE: (0x80 if faults.mode_bit_7 else 0) | (2 if on_battery else 1),
            _NTC: _decimals(self.temperature_c),
            _TO92: _decimals(self.temperature_c),
            _CHARGER: int(not on_battery),
            _BOARD: 0x33,
            _LOADER: ord("P"),
            _FIRMWARE: 0x40,
        }
        words = {
            _BATTERY: _hundredths(battery_v),
            _OUTPUT: _hundredths(OUTPUT_V),
            _EXTERNAL: _hundredths(external_v),
            _COUNTER: self._counter(now),
        }
        if faults.bad_bcd:
            words[_EXTERNAL] |= 0x0A00
        for register, word in words.items():
            bytes_[register], bytes_[register + 1] = word & 0xFF, word >> 8
        return bytes_

    def _counter(self, now: float) -> int:
        """Return the counter of milliseconds, which stops while the processor hangs."""
        counter = int(now * 1000) & 0xFFFF
        self._held_counter = (
            (self._held_counter if self._held_counter is not None else counter) if self._faults.hung else None
        )
        return counter if self._held_counter is None else self._held_counter


class _Status(RegisterDevice):
    """The registers at the lower address, which are read-only."""

    def __init__(self, pico: Pico) -> None:
        super().__init__()
        self._pico = pico
        self._now: dict[int, int] = {}

    def start(self, now: float) -> None:
        self._pico.run(now)
        self._now = self._pico.registers(now)

    def store(self, register: int, value: int, now: float) -> None:
        """Ignore the byte: these registers are read-only."""

    def fetch(self, register: int, now: float) -> int:  # noqa: ARG002
        return self._now.get(register, 0)


class _Commands(RegisterDevice):
    """The registers at the upper address."""

    def __init__(self, pico: Pico) -> None:
        super().__init__()
        self._pico = pico
        self._values: dict[int, int] = {_CHEMISTRY: ord("P")}

    def start(self, now: float) -> None:
        self._pico.run(now)

    def store(self, register: int, value: int, now: float) -> None:
        if register == _RELAY:
            self._pico.relay = value & 1
        elif register == _TIMER:
            self._pico.set_timer(value, now)
        else:
            self._values[register] = value

    def fetch(self, register: int, now: float) -> int:  # noqa: ARG002
        if register == _RELAY:
            return self._pico.relay
        if register == _TIMER:
            return self._pico.timer
        return self._values.get(register, 0)


def _hundredths(value: float) -> int:
    return _decimals(round(value * 100))


def _decimals(value: int) -> int:
    """Return a number's digits, four bits for each."""
    return int(str(max(0, min(9999, value))), 16)


class PicoTwin(I2cTwin[PicoFaults]):
    """Reports the voltage of the world's battery, unless a fault sets another."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, PicoRow)
        super().__init__(device.name, device.address, settings.faults, around.seed_for(device) + 1)
        self._address = settings.i2c_address
        self._relay_on = settings.relay_on
        self._supply = Pico(settings.battery_v, settings.temperature_c, settings.faults)
        self._supply.relay = settings.relay_on

    @property
    def motors_on(self) -> bool:
        """Return whether the relay gives the servos power."""
        return self._supply.relay == self._relay_on

    def sense(self, sensed: Sensed) -> None:
        """Set the voltage that feeds it."""
        self._supply.external_v = sensed.battery_v

    def take_over(self) -> None:
        """Pass the present faults to the supply."""
        if self._supply.faults is not self._faults:
            self._supply.faults = self._faults

    def devices(self) -> Mapping[int, I2cDevice]:
        """Return the devices on the bus: status and commands."""
        return self._supply.on_bus(self._address)
