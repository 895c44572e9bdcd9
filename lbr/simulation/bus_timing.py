"""The timing of a servo bus. It is a simulation: measurements with it do not apply to a real robot."""

from random import Random
from typing import Annotated, NamedTuple

from msgspec import Meta, Struct

Us = Annotated[float, Meta(ge=0.0, le=100_000.0, description="microseconds")]

_US = 1e-6
_DRIFT = 0.005


class Rhythm(NamedTuple):
    """The interrupts by a servo's motor control: their phase, and the error of its clock."""

    phase_s: float = 0.0
    drift: float = 0.0


STEADY = Rhythm()


def rhythm(random: Random) -> Rhythm:
    """Return a random servo's rhythm: no two have the same."""
    return Rhythm(random.uniform(0.0, 0.1), random.uniform(-_DRIFT, _DRIFT))


class BusTiming(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Delays of an answer besides its bytes' own time at the line's rate. Each part may be 0.

    `ping_us`, `read_us`, `write_us`, `write_byte_us`: a servo's own time, by users; its return delay hides it, or adds
    to it with `delay_adds` (not measured). Every `interrupt_period_us` its motor control takes `interrupt_us`: the
    jitter. `usb_us`: host and USB, for a round trip; 1100 on the first owners' computer. `eeprom_us`: deafness for each
    EEPROM byte.
    """

    ping_us: Us = 18.0
    read_us: Us = 22.0
    write_us: Us = 24.0
    write_byte_us: Us = 6.0
    delay_adds: bool = False
    interrupt_us: Annotated[float, Meta(ge=0.0, le=900.0)] = 130.0
    interrupt_period_us: Annotated[float, Meta(ge=1000.0, le=100_000.0)] = 1000.0
    usb_us: Us = 250.0
    eeprom_us: Us = 6000.0

    def thinking_s(self, code: int, written: int) -> float:
        """Return the delay of a servo before it answers; `written` counts the bytes that it received."""
        if code == 1:
            return self.ping_us * _US
        return (self.read_us if code == 2 else self.write_us + self.write_byte_us * written) * _US

    def begins(self, at: float, thinking_s: float, delay_s: float, rhythm: Rhythm) -> float:
        """Return when the answer to a packet that ended `at` begins."""
        if self.delay_adds:
            return self.finished(at + delay_s, thinking_s, rhythm)
        return max(self.finished(at, thinking_s, rhythm), at + delay_s)

    def finished(self, at: float, work_s: float, rhythm: Rhythm) -> float:
        """Return when work begun `at` is done, with the interrupts in between."""
        period, busy = self.interrupt_period_us * _US * (1.0 + rhythm.drift), self.interrupt_us * _US
        if busy == 0.0:
            return at + work_s
        within = (at - rhythm.phase_s) % period
        if within < busy:
            at, within = at + busy - within, busy
        remaining = period - within
        if work_s < remaining:
            return at + work_s
        rounds, rest = divmod(work_s - remaining, period - busy)
        return at + remaining + rounds * period + busy + rest
