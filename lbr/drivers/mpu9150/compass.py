"""The AK8975: it measures once at each request, and answers only while the bypass is on."""

from collections.abc import Callable

from lbr.drivers.i2c_bus import Bus
from lbr.drivers.inertial import AT_REST, QUIET_HZ
from lbr.drivers.mpu9150 import registers
from lbr.drivers.mpu9150.registers import MagneticField
from lbr.errors import DeviceError
from lbr.messages.units import Vector

MODE_CHANGE_S = 0.0005
OVERDUE_S = 0.1
EARLY_S = 0.003
REST_S = AT_REST / QUIET_HZ
"""The period of a unit at rest: one measurement for each sample."""


class Compass:
    """A compass on an open bus; its OSErrors are left to the caller."""

    def __init__(self, bus: Bus, rate_hz: float, sleep: Callable[[float], None]) -> None:
        self._bus = bus
        self._full_s = self._period_s = 1.0 / rate_hz
        self._sleep = sleep
        self._unit: Vector = (0.0, 0.0, 0.0)
        self._asked: float | None = None
        self._next = 0.0

    def start(self, name: str) -> None:
        """Check its identity and read its sensitivity; raise DeviceError naming device row `name`."""
        identity = self._bus.read_byte_data(registers.COMPASS_ADDRESS, registers.COMPASS_ID)
        if identity != registers.COMPASS_OWN_ID:
            own = registers.COMPASS_OWN_ID
            complaint = f"device '{name}': its compass has the identity {identity:#04x}, not {own:#04x}"
            raise DeviceError(f"{complaint}; it is not an MPU-9150, or set mag_hz to 0 to go without")
        fuses = self._fuses()
        unit = registers.sensitivity(fuses)
        if unit is None or fuses != self._fuses():
            complaint = f"device '{name}': the sensitivity of its compass cannot be read ({fuses.hex(' ')})"
            raise DeviceError(f"{complaint}; check its wiring, or set mag_hz to 0 to go without")
        self._unit = unit
        self._asked, self._next = None, 0.0

    def rest(self, *, rests: bool) -> None:
        """Measure seldom, or at its row's rate."""
        self._period_s = max(self._full_s, REST_S) if rests else self._full_s

    def poll(self, now: float) -> MagneticField | None:
        """Return a new reading if there is one, and request the next when it is due."""
        field = None
        if self._asked is not None and now - self._asked >= registers.CONVERSION_S:
            field = self._collect(now, now - self._asked)
        if self._asked is None and now >= self._next:
            self._mode(registers.SINGLE)
            self._asked, self._next = now, now + self._period_s - EARLY_S
        return field

    def _collect(self, now: float, waited_s: float) -> MagneticField | None:
        address, length = registers.COMPASS_ADDRESS, registers.COMPASS_READING_BYTES
        data = bytes(self._bus.read_i2c_block_data(address, registers.COMPASS_READING, length))
        field = registers.decode_field(data, self._unit)
        if field is None and waited_s > OVERDUE_S:
            self._mode(registers.OFF)
            self._next = now + MODE_CHANGE_S
            field = MagneticField(None, "the compass does not finish measuring")
        if field is not None:
            self._asked = None
        return field

    def _fuses(self) -> bytes:
        """Read the fuses; every change of mode goes through off, with a pause."""
        for mode in (registers.OFF, registers.FUSES):
            self._mode(mode)
            self._sleep(MODE_CHANGE_S)
        fuses = bytes(self._bus.read_i2c_block_data(registers.COMPASS_ADDRESS, registers.COMPASS_FUSES, 3))
        self._mode(registers.OFF)
        self._sleep(MODE_CHANGE_S)
        return fuses

    def _mode(self, mode: int) -> None:
        self._bus.write_byte_data(registers.COMPASS_ADDRESS, registers.COMPASS_MODE, mode)
