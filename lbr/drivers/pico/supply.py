"""The supply as a device: one exchange at a time, spaced as the supply needs, so that the caller never waits for it."""

from collections import deque
from collections.abc import Callable
from typing import Protocol

from lbr.capability.context import Device
from lbr.drivers.i2c import unanswered
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.pico import PicoSettings, registers
from lbr.drivers.pico.readout import Readout, items
from lbr.messages.power import UpsState

FED_TIMES = 4
"""The number of times that the still-alive timer is fed within its time."""

_CELLS = {"lipo": registers.LIPO, "lifepo4": registers.LIFEPO4, "auto": None}


class Answer(Protocol):
    """Receives the result of switching the relay: an empty string, or the error."""

    def __call__(self, trouble: str) -> None:
        """Receive the result."""


class Supply:
    """One supply on an open bus; `exchange` does one thing, the most urgent first."""

    def __init__(
        self, bus: Bus, address: int, device: Device, settings: PicoSettings, clock: Callable[[], float]
    ) -> None:
        self.firmware = ""
        self._bus = bus
        self._status, self._commands = address, address + registers.COMMANDS_ABOVE
        self._device = device
        self._settings = settings
        self._clock = clock
        self._cell = _CELLS[settings.chemistry]
        self._errors = 0
        self._feed_at = 0.0
        self._relays: deque[RelaySwitch] = deque()
        self._versions: list[int] = []
        self._sweep = self._begin()

    def switch(self, answer: Answer, *, on: bool) -> None:
        """Queue a switch of the relay, which is read back; it comes before all other exchanges."""
        bits = self._settings.relay_on if on else 1 - self._settings.relay_on
        self._relays.append(RelaySwitch(bits, self._settings.retries, answer))

    def exchange(self) -> UpsState | None:
        """Do one exchange; return the state at the end of a sweep. Raise DeviceError if nothing answers any more."""
        if self._sweep.next is None:
            return self._finish()
        try:
            if self._feed_is_due():
                self._feed()
            elif self._relays:
                self._switch(self._relays[0])
            elif len(self._versions) < 3:
                self._ask_version()
            else:
                self._read()
        except OSError as err:
            self._failed(err)
        else:
            self._errors = 0
        return None

    def close(self) -> None:
        """Stop the timer, refuse pending switches, and close the bus."""
        for relay in self._relays:
            relay.answer("the driver is closing; the relay may be either way")
        self._relays.clear()
        try:
            if self._settings.still_alive_s:
                self._bus.write_byte_data(self._commands, registers.STILL_ALIVE, registers.STILL_ALIVE_OFF)
        except OSError:
            pass  # it is away; if it still runs, its timer resets a computer that no longer feeds it
        finally:
            self._bus.close()

    def _begin(self) -> Readout:
        return Readout(list(items(self._settings, self._cell)), self._settings.retries)

    def _read(self) -> None:
        item = self._sweep.items[0]
        try:
            address = self._commands if item.command else self._status
            read = self._bus.read_word_data if item.word else self._bus.read_byte_data
            self._sweep.take(read(address, item.register))
        except OSError as err:
            self._sweep.fail(err.strerror or str(err))
            raise

    def _finish(self) -> UpsState:
        done, self._cell = self._sweep, self._sweep.values.get("chemistry", self._cell)
        self._sweep = self._begin()
        return done.state(self.firmware, self._cell, self._settings.relay_on)

    def _failed(self, err: OSError) -> None:
        self._errors += 1
        if self._errors >= self._settings.most_errors:
            raise unanswered(self._device, self._status, err) from err

    def _feed_is_due(self) -> bool:
        return bool(self._settings.still_alive_s) and self._clock() >= self._feed_at

    def _feed(self) -> None:
        self._bus.write_byte_data(self._commands, registers.STILL_ALIVE, self._settings.still_alive_s)
        self._feed_at = self._clock() + self._settings.still_alive_s / FED_TIMES

    def _switch(self, relay: "RelaySwitch") -> None:
        """Write the relay, and read it back in the next turn; it is bistable, so writing twice does no harm."""
        try:
            if relay.written:
                relay.found = self._bus.read_byte_data(self._commands, registers.RELAY)
            else:
                self._bus.write_byte_data(self._commands, registers.RELAY, relay.bits)
        except OSError as err:
            relay.tries_left -= 1
            if relay.tries_left < 0:
                self._relays.popleft().answer(f"the supply does not take it: {err.strerror or err}")
            raise
        if relay.written:
            self._relays.popleft().answer(relay.trouble)
        relay.written = True

    def _ask_version(self) -> None:
        self._versions.append(self._bus.read_byte_data(self._status, registers.FIRMWARE + len(self._versions)))
        if len(self._versions) == 3:
            self.firmware = registers.firmware(*self._versions)


class RelaySwitch:
    """A switch of the relay in progress."""

    def __init__(self, bits: int, retries: int, answer: Answer) -> None:
        self.bits = bits
        self.tries_left = retries
        self.answer = answer
        self.written = False
        self.found = bits

    @property
    def trouble(self) -> str:
        """Return the error after the read-back, or an empty string."""
        if self.found == self.bits:
            return ""
        return f"the relay reads {self.found:#04x} after {self.bits} was written; look at the supply"
