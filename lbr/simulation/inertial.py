"""The readings of the inertial unit: MuJoCo's sensors with the biases, the iron and the noise of a cheap one."""

import numpy as np

from lbr.simulation.bindings import MjData
from lbr.simulation.measured import ImuReading
from lbr.simulation.noise import Floats, Noise
from lbr.simulation.settings import Imu

_SMOOTHING = 0.5
"""Share of the newest step in a measurement: a low pass of about 25 Hz at 250 steps a second."""


class InertialUnit:
    """One unit: `follow` each step, `read` on request."""

    def __init__(self, settings: Imu, seed: int) -> None:
        self._bias = np.array((*settings.gyro_bias_rps, *settings.accel_bias_mps2, *settings.hard_iron_ut))
        spread = (settings.gyro_noise_rps, settings.accel_noise_mps2, settings.mag_noise_ut)
        self._spread = np.repeat(spread, 3)
        self._iron = np.array(settings.soft_iron)
        self._temperature_c = settings.temperature_c
        self._noise = Noise(seed, "imu", 9)
        self._true: Floats | None = None

    def follow(self, data: MjData) -> None:
        """Process a step of the physics; its sensors are gyro, accelerometer and magnetometer, in this order."""
        if self._true is None:
            self._true = np.array(data.sensordata[:9])
        else:
            self._true += (data.sensordata[:9] - self._true) * _SMOOTHING

    def settle(self, data: MjData) -> None:
        """Note that the physics stands."""
        self._true = np.array(data.sensordata[:9])

    def read(self, step: int) -> ImuReading:
        """Return the measurement at a step."""
        true = np.zeros(9) if self._true is None else self._true.copy()
        true[6:] = self._iron @ true[6:]
        a, b, c, d, e, f, g, h, i = (true + self._bias + self._spread * self._noise.at(step)).tolist()
        return ImuReading(gyro_rps=(a, b, c), accel_mps2=(d, e, f), mag_ut=(g, h, i), temperature_c=self._temperature_c)
