"""An emulated MPU-9150, register by register, with its AK8975 behind the bypass.

The datasheet leaves gaps. This device assumes: registers are read-only for 20 ms after a reset. The first sample comes
30 ms after waking. Its compass loses its state only with the supply. Master mode, FIFO and self test are missing: their
registers can be written, without effect.
"""

from collections.abc import Mapping
from math import degrees, floor
from random import Random

from lbr.capability.context import Device
from lbr.messages.units import Vector
from lbr.simulation.devices.mpu9150 import Mpu9150Faults, Mpu9150Row
from lbr.simulation.devices.mpu9150.ak8975 import ADDRESS as COMPASS_ADDRESS
from lbr.simulation.devices.mpu9150.ak8975 import SENSITIVITY, Ak8975
from lbr.simulation.i2c import I2cDevice, RegisterDevice
from lbr.simulation.measured import ImuReading
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.i2c import I2cTwin
from lbr.simulation.wire import strikes

ADDRESS = 0x68
G_MPS2 = 9.80665
RESET_S = 0.02
START_S = 0.03

SMPLRT_DIV, CONFIG, GYRO_CONFIG, ACCEL_CONFIG, INT_PIN_CFG, INT_STATUS = 0x19, 0x1A, 0x1B, 0x1C, 0x37, 0x3A
ACCEL_XOUT_H, EXT_SENS_LAST, USER_CTRL, PWR_MGMT_1, FIFO_R_W, WHO_AM_I = 0x3B, 0x60, 0x6A, 0x6B, 0x74, 0x75

_IDENTITY = 0x68
_REGISTERS = 0x80
_DATA_BYTES = 14
_RESET, _SLEEP, _MASTER, _BYPASS, _DATA_READY = 0x80, 0x40, 0x20, 0x02, 0x01
_ACCEL_LSB_PER_G = (16384.0, 8192.0, 4096.0, 2048.0)
_GYRO_LSB_PER_DPS = (131.0, 65.5, 32.8, 16.4)
_JUMP_RPS = 4.0
_NOISE = {"gyro_rps": 0.002, "accel_mps2": 0.04, "mag_ut": 0.5}
"""Standard deviations; the fault `noise` multiplies them."""


class Mpu9150(RegisterDevice):
    """The chip from power-up on: it receives the motion of the world, and returns the newest of its own samples."""

    def __init__(
        self, *, faults: Mpu9150Faults | None = None, seed: int = 0, sensitivity: tuple[int, int, int] = SENSITIVITY
    ) -> None:
        super().__init__()
        self.compass = Ak8975(sensitivity)
        self._faults = faults or Mpu9150Faults()
        self._random = Random(seed)
        self._felt = ImuReading()
        self.power_up()

    @property
    def faults(self) -> Mpu9150Faults:
        """Return the faults; setting them takes effect at once."""
        return self._faults

    @faults.setter
    def faults(self, faults: Mpu9150Faults) -> None:
        if self._faults.brown_out and not faults.brown_out:
            self.power_up()
            self.compass.power_up()
        self._faults = faults
        self.compass.overflows, self.compass.held = faults.overflow, faults.frozen

    def power_up(self) -> None:
        """Forget everything; the chip sleeps."""
        self._pointer = 0
        self._values = bytearray(_REGISTERS)
        self._values[PWR_MGMT_1] = _SLEEP
        self._values[WHO_AM_I] = _IDENTITY
        self._reset_until = self._sampling_from = 0.0
        self._sample = -1

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set the motion from now on."""
        self.start(now)
        self.compass.start(now)
        self._felt = reading
        x, y, z = self._shaken(reading.mag_ut, "mag_ut")
        self.compass.field_ut = (y, x, -z)

    def on_bus(self, address: int) -> Mapping[int, I2cDevice]:
        """Return the devices that now answer on the bus: the compass only through the bypass."""
        if self._faults.brown_out:
            return {}
        through = self._values[INT_PIN_CFG] & _BYPASS and not self._values[USER_CTRL] & _MASTER
        if not through or self._faults.no_compass:
            return {address: self}
        return {address: self, COMPASS_ADDRESS: self.compass}

    def start(self, now: float) -> None:
        """Update the data registers at the start condition; during a read they do not change."""
        if self._values[PWR_MGMT_1] & _RESET and now >= self._reset_until:
            self._values[PWR_MGMT_1] &= ~_RESET
        if self._values[PWR_MGMT_1] & _SLEEP or now < self._sampling_from:
            return
        sample = floor((now - self._sampling_from) * self._rate_hz())
        if sample != self._sample:
            self._sample = sample
            self._values[INT_STATUS] |= _DATA_READY
            if not self._faults.frozen:
                self._values[ACCEL_XOUT_H : ACCEL_XOUT_H + _DATA_BYTES] = self._measured()

    def store(self, register: int, value: int, now: float) -> None:
        """Accept a byte, if the register is writable."""
        if register >= _REGISTERS or now < self._reset_until:
            return
        if register == PWR_MGMT_1:
            self._power(value, now)
        elif register != WHO_AM_I and not INT_STATUS <= register <= EXT_SENS_LAST:
            self._values[register] = value
            if register in {SMPLRT_DIV, CONFIG}:
                self._sampling_from, self._sample = max(now, self._sampling_from), -1

    def fetch(self, register: int, now: float) -> int:  # noqa: ARG002
        """Return a byte; reading INT_STATUS clears it."""
        if register >= _REGISTERS:
            return 0
        value = self._values[register]
        if register == INT_STATUS:
            self._values[INT_STATUS] = 0
        return value

    def after(self, register: int) -> int:
        """Return the next position of the pointer; the FIFO's stays."""
        return register if register == FIFO_R_W else super().after(register)

    def _power(self, value: int, now: float) -> None:
        if value & _RESET:
            self.power_up()
            self._reset_until = now + RESET_S
            self._values[PWR_MGMT_1] = _RESET | _SLEEP
            return
        if self._values[PWR_MGMT_1] & _SLEEP and not value & _SLEEP:
            self._sampling_from, self._sample = now + START_S, -1
        self._values[PWR_MGMT_1] = value

    def _rate_hz(self) -> float:
        """Return the rate of new data: 1 kHz with the low-pass on, otherwise 8 kHz, divided."""
        filtered = 1 <= self._values[CONFIG] & 0x07 <= 6
        return (1000.0 if filtered else 8000.0) / (1 + self._values[SMPLRT_DIV])

    def _measured(self) -> bytes:
        accel_scale = _ACCEL_LSB_PER_G[self._values[ACCEL_CONFIG] >> 3 & 0x03] / G_MPS2
        gyro_scale = degrees(_GYRO_LSB_PER_DPS[self._values[GYRO_CONFIG] >> 3 & 0x03])
        accel = (axis * accel_scale for axis in self._shaken(self._felt.accel_mps2, "accel_mps2"))
        gyro = (axis * gyro_scale for axis in self._spun())
        return b"".join(_word(value) for value in (*accel, (self._felt.temperature_c - 35.0) * 340.0, *gyro))

    def _spun(self) -> Vector:
        x, y, z = self._shaken(self._felt.gyro_rps, "gyro_rps")
        if strikes(self._faults.jump, self._random):
            z += self._random.choice((-_JUMP_RPS, _JUMP_RPS))
        return (x, y, z)

    def _shaken(self, vector: Vector, what: str) -> Vector:
        if not self._faults.noise:
            return vector
        deviation = _NOISE[what] * self._faults.noise
        x, y, z = (axis + self._random.gauss(0.0, deviation) for axis in vector)
        return (x, y, z)


def _word(value: float) -> bytes:
    return max(-32768, min(32767, round(value))).to_bytes(2, "big", signed=True)


class Mpu9150Twin(I2cTwin[Mpu9150Faults]):
    """Follows each step of the world."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Mpu9150Row)
        super().__init__(device.name, device.address, settings.faults, around.seed_for(device) + 1)
        self._address = settings.i2c_address
        self._chip = Mpu9150(seed=around.seed_for(device), sensitivity=settings.sensitivity)

    def take_over(self) -> None:
        """Pass the present faults to the chip."""
        if self._chip.faults is not self._faults:
            self._chip.faults = self._faults

    def devices(self) -> Mapping[int, I2cDevice]:
        """Return the devices on the bus: the chip, and its compass through the bypass."""
        return self._chip.on_bus(self._address)

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set its present measurements."""
        self._chip.feel(reading, now)
