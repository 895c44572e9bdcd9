"""An emulated AK8975 compass, register by register; no I/O.

The datasheet leaves gaps. This device assumes: a mode written while another one runs, or less than 100 us after its
end, is ignored. A measurement has the field of the moment in which it ends.
"""

from math import fsum

from lbr.messages.units import Vector
from lbr.simulation.i2c import RegisterDevice

ADDRESS = 0x0C
CONVERSION_S = 0.0073
MODE_CHANGE_S = 0.0001
UT_PER_LSB = 0.3
OVERFLOW_UT = 2400.0
SENSITIVITY = (176, 178, 166)
"""The ASA values in a typical chip's fuses."""

WIA, INFO, ST1, HXL, HZH, ST2, CNTL, ASTC, ASAX, ASAZ = 0x00, 0x01, 0x02, 0x03, 0x08, 0x09, 0x0A, 0x0C, 0x10, 0x12

_IDENTITY, _OFF, _SINGLE, _SELF_TEST, _FUSES = 0x48, 0x0, 0x1, 0x8, 0xF
_MODES = (_OFF, _SINGLE, _SELF_TEST, _FUSES)
_OVERFLOW, _SELF = 0x08, 0x40
_FULL_SCALE = 4096
_TEST_FIELD_UT: Vector = (0.0, 0.0, -180.0)


class Ak8975(RegisterDevice):
    """The compass from power-up on; `field_ut` is the field along its own axes."""

    def __init__(self, sensitivity: tuple[int, int, int] = SENSITIVITY) -> None:
        super().__init__()
        self.field_ut: Vector = (0.0, 0.0, 0.0)
        self.overflows = False
        self.held = False  # it measures, but always the same
        self._sensitivity = sensitivity
        self.power_up()

    def power_up(self) -> None:
        """Forget everything; the chip is off."""
        self._pointer = 0
        self._mode = _OFF
        self._off_since = -MODE_CHANGE_S
        self._ends_at = 0.0
        self._ready = False
        self._data = bytes(6)
        self._status2 = 0
        self._self_test = 0

    def start(self, now: float) -> None:
        """Finish a measurement whose time is over; after it, the chip is off."""
        if self._mode in {_SINGLE, _SELF_TEST} and now >= self._ends_at:
            self._measure(_TEST_FIELD_UT if self._mode == _SELF_TEST and self._self_test else self.field_ut)
            self._mode, self._off_since = _OFF, self._ends_at

    def store(self, register: int, value: int, now: float) -> None:
        """Accept a mode or the self test's switch; all other registers are read-only."""
        if register == ASTC:
            self._self_test = value & _SELF
        elif register == CNTL:
            self._switch(value & 0x0F, now)

    def fetch(self, register: int, now: float) -> int:  # noqa: ARG002
        """Return a register; reading the data or ST2 ends `ready`."""
        if HXL <= register <= ST2:
            self._ready = False
        if HXL <= register <= HZH:
            return self._data[register - HXL]
        if ASAX <= register <= ASAZ:
            return self._sensitivity[register - ASAX] if self._mode == _FUSES else 0
        constants = {WIA: _IDENTITY, ST1: int(self._ready), ST2: self._status2, CNTL: self._mode}
        return {**constants, ASTC: self._self_test}.get(register, 0)

    def after(self, register: int) -> int:
        """Return the next position of the pointer: around the registers, or around the fuses."""
        return {ASTC: WIA, ASAZ: ASAX}.get(register, (register + 1) & 0xFF)

    def _switch(self, mode: int, now: float) -> None:
        if mode == _OFF:
            self._off_since = now if self._mode != _OFF else self._off_since
            self._mode = _OFF
        elif mode in _MODES and self._mode == _OFF and now - self._off_since >= MODE_CHANGE_S:
            self._mode, self._ends_at = mode, now + CONVERSION_S
            self._ready = False

    def _measure(self, field_ut: Vector) -> None:
        self._ready = True
        if self.held:
            return
        too_much = fsum(abs(axis) for axis in field_ut) >= OVERFLOW_UT
        self._status2 = _OVERFLOW if too_much or self.overflows else 0
        counts = (_counts(axis, fuse) for axis, fuse in zip(field_ut, self._sensitivity, strict=True))
        self._data = b"".join(count.to_bytes(2, "little", signed=True) for count in counts)


def _counts(field_ut: float, fuse: int) -> int:
    """Return the chip's reading, so that count x ((ASA - 128) / 256 + 1) x 0.3 uT is the field again."""
    count = round(field_ut / (UT_PER_LSB * ((fuse - 128) / 256 + 1)))
    return max(-_FULL_SCALE, min(_FULL_SCALE - 1, count))
