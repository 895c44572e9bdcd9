"""The inertial unit as a device: started, read in one burst for each sample, and checked for readings that are not
live."""

import errno
import time
from collections.abc import Callable
from contextlib import suppress

from lbr.capability.context import Device
from lbr.drivers.i2c import unanswered
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.inertial import LifeSigns
from lbr.drivers.mpu9150 import Mpu9150Settings, registers
from lbr.drivers.mpu9150.compass import Compass
from lbr.errors import DeviceError
from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector

RESET_LIMIT_S = 0.2
RESET_PAUSE_S = 0.01
WAKE_S = 0.03
CHECK_PERIOD_S = 0.2
UNUSABLE_S = 1.0
COMPASS_SILENT_S = 1.0
COMPASS_RETRY_S = 2.0

Tell = Callable[[str, str], None]


class InertialUnit:
    """One unit on an open bus. A failed reading is an invalid sample, several in a row are a DeviceError.

    A compass that does not answer is restarted every 2 s, while the rest goes on. `tell(kind, text)` publishes
    warnings; it may be called often. `compass_trouble`: why there was no compass reading for a second, or empty.
    """

    def __init__(
        self,
        bus: Bus,
        address: int,
        device: Device,
        settings: Mpu9150Settings,
        tell: Tell,
        signs: LifeSigns,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.compass_trouble = ""
        self._bus = bus
        self._address = address
        self._device = device
        self._settings = settings
        self._tell = tell
        self._clock = clock
        self._sleep = sleep
        self._compass = Compass(bus, settings.mag_hz, sleep) if settings.mag_hz else None
        self._units = registers.units(settings)
        self._wanted = registers.configuration(settings)
        self._signs = signs
        self._errors = self._compass_errors = self._checks = 0
        self._check_at = self._valid_at = self._field_at = 0.0
        self._compass_runs = False
        self._compass_at = 0.0

    def start(self) -> None:
        """Reset it, write its settings and read them back, start its compass; takes some 0.1 s."""
        try:
            self._identify()
            self._reset()
            for register, value in self._wanted.items():
                self._bus.write_i2c_block_data(self._address, register, value)
                if register == registers.POWER:
                    self._sleep(WAKE_S)
        except DeviceError:
            raise
        except OSError as err:
            raise self._unanswered(err) from err
        for register in self._wanted:
            self._verify(register, "does not keep its settings")
        self._errors = 0
        self._valid_at = self._field_at = self._check_at = self._clock()
        self.compass_trouble = ""
        self._start_compass()

    def sample(self) -> ImuSample:
        """Measure now; raise DeviceError if it has to be restarted."""
        now = self._clock()
        try:
            burst = bytes(self._bus.read_i2c_block_data(self._address, registers.MOTION, registers.MOTION_BYTES))
        except OSError as err:
            return self._failed(now, err)
        self._errors = 0
        counts = registers.decode_motion(burst)
        missing = self._signs.missing(counts)
        if missing:
            return self._unusable(now, missing)
        self._valid_at = now
        self._check_settings(now)
        accel, gyro = registers.motion(counts, self._units)
        if accel is None or gyro is None:
            ranges = "accel_range_g" if accel is None else "gyro_range_dps"
            self._tell("out_of_range", f"what it measures is beyond its range; a larger {ranges} would show it")
        return ImuSample(
            valid=True,
            time_s=now,
            gyro_rps=gyro,
            accel_mps2=accel,
            mag_ut=self._field(now),
            temperature_c=registers.temperature_c(counts[3], self._settings.temperature_offset_c),
        )

    def rest(self, *, rests: bool) -> None:
        """Make its compass measure seldom while it lies still."""
        if self._compass is not None:
            self._compass.rest(rests=rests)

    def close(self) -> None:
        """Close the bus."""
        self._bus.close()

    def _identify(self) -> None:
        """Check that it is an MPU-9150, before anything is written to it."""
        chip = self._bus.read_byte_data(self._address, registers.WHO_AM_I)
        if chip != registers.OWN_ID:
            complaint = (
                f"device '{self._device.name}' at {self._device.address} is not an MPU-9150: WHO_AM_I is {chip:#04x}"
            )
            own = f"({registers.name_of(chip)}), not {registers.OWN_ID:#04x}"
            raise DeviceError(f"{complaint} {own}; check the address in the device row and the wiring")

    def _reset(self) -> None:
        self._bus.write_byte_data(self._address, registers.POWER, registers.RESET)
        until = self._clock() + RESET_LIMIT_S
        while True:
            self._sleep(RESET_PAUSE_S)
            with suppress(OSError):  # during the reset it may not answer
                if not self._bus.read_byte_data(self._address, registers.POWER) & registers.RESET:
                    return
            if not self._clock() < until:
                raise OSError(errno.ETIMEDOUT, "reset")

    def _start_compass(self) -> None:
        """Start the compass; retry later if it does not answer, raise DeviceError if it is another chip."""
        self._compass_errors, self._compass_runs = 0, False
        if self._compass is None:
            return
        try:
            self._compass.start(self._device.name)
        except DeviceError:
            raise
        except OSError as err:
            self._compass_at = self._clock() + COMPASS_RETRY_S
            self.compass_trouble = str(self._unanswered(err, registers.COMPASS_ADDRESS, "its compass"))
        else:
            self._compass_runs = True

    def _failed(self, now: float, err: OSError) -> ImuSample:
        self._errors += 1
        error = self._unanswered(err)
        if self._errors >= self._settings.most_errors:
            raise error from err
        self._tell("bus", str(error))
        return ImuSample(valid=False, time_s=now, reason=str(error))

    def _unusable(self, now: float, reason: str) -> ImuSample:
        complaint = f"device '{self._device.name}' at {self._device.address}: {reason}"
        self._verify(registers.POWER, "lost its settings; was its power interrupted? It is restarted")
        if not now - self._valid_at < UNUSABLE_S:
            raise DeviceError(f"{complaint}; it is restarted; check its power and wiring")
        self._tell("unusable", complaint)
        return ImuSample(valid=False, time_s=now, reason=complaint)

    def _check_settings(self, now: float) -> None:
        """Check one of its settings from time to time: a unit that loses power for a moment loses them."""
        if now >= self._check_at:
            self._check_at = now + CHECK_PERIOD_S
            self._checks += 1
            registers_in_turn = tuple(self._wanted)
            register = registers_in_turn[self._checks % len(registers_in_turn)]
            self._verify(register, "lost its settings; was its power interrupted? It is restarted")

    def _verify(self, register: int, otherwise: str) -> None:
        """Raise DeviceError if a setting is read wrong twice; an error of the bus proves nothing."""
        wanted = self._wanted[register]
        read = b""
        for _ in range(2):
            try:
                read = bytes(self._bus.read_i2c_block_data(self._address, register, len(wanted)))
            except OSError:
                return
            if read == wanted:
                return
        complaint = f"device '{self._device.name}' at {self._device.address} {otherwise}"
        raise DeviceError(f"{complaint} (register {register:#04x} is {read.hex(' ')}, not {wanted.hex(' ')})")

    def _field(self, now: float) -> Vector | None:
        if self._compass is None or not self._compass_is_up(now):
            return None
        try:
            field = self._compass.poll(now)
        except OSError as err:
            self._compass_failed(now, err)
            return None
        self._compass_errors = 0
        if field is not None and field.trouble:
            self._tell("compass", field.trouble)
            self._miss_compass(now, field.trouble)
        elif field is not None:
            self._field_at = now
            self.compass_trouble = ""
        return field.microtesla if field is not None else None

    def _compass_is_up(self, now: float) -> bool:
        if not self._compass_runs and now >= self._compass_at:
            try:
                self._start_compass()
            except DeviceError as err:
                self._compass_at = now + COMPASS_RETRY_S
                self.compass_trouble = str(err)
        return self._compass_runs

    def _compass_failed(self, now: float, err: OSError) -> None:
        self._compass_errors += 1
        trouble = str(self._unanswered(err, registers.COMPASS_ADDRESS, "its compass"))
        self._tell("compass", trouble)
        if self._compass_errors >= self._settings.most_errors:
            self._compass_runs, self._compass_at = False, now
            self.compass_trouble = trouble
        else:
            self._miss_compass(now, trouble)

    def _miss_compass(self, now: float, trouble: str) -> None:
        if not now - self._field_at < COMPASS_SILENT_S:
            self.compass_trouble = trouble

    def _unanswered(self, err: OSError, address: int | None = None, what: str = "") -> DeviceError:
        return unanswered(self._device, self._address if address is None else address, err, what)
