"""A made-up inertial unit whose truth is known: it turns as told, with a bias, noise, iron and a mounting of its own."""

from dataclasses import dataclass, field
from math import cos, degrees, radians, sin

import numpy as np

from lbr.messages.imu import ImuSample

G_MPS2 = 9.80665
FIELD_ENU_UT = np.array((0.0, 19.0, -45.0))


def about(axis: int, angle_rad: float) -> np.ndarray:
    c, s = cos(angle_rad), sin(angle_rad)
    turned = {
        0: ((1, 0, 0), (0, c, -s), (0, s, c)),
        1: ((c, 0, s), (0, 1, 0), (-s, 0, c)),
        2: ((c, -s, 0), (s, c, 0), (0, 0, 1)),
    }
    return np.array(turned[axis], dtype=float)


@dataclass
class MadeUpImu:
    """`yaw_deg` is anticlockwise from east, `sensor_in_body` the matrix from the sensor's axes to the body's."""

    yaw_deg: float = 0.0
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    bias_dps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gyro_noise_dps: float = 0.05
    accel_noise_mps2: float = 0.03
    mag_noise_ut: float = 0.3
    hard_iron_ut: tuple[float, float, float] = (0.0, 0.0, 0.0)
    soft_iron: np.ndarray = field(default_factory=lambda: np.eye(3))
    sensor_in_body: np.ndarray = field(default_factory=lambda: np.eye(3))
    field_enu_ut: np.ndarray = field(default_factory=lambda: FIELD_ENU_UT)
    rate_hz: float = 100.0
    mag_every: int = 2
    time_s: float = 1000.0
    seed: int = 1

    def __post_init__(self):
        self.random = np.random.default_rng(self.seed)
        self.turned_deg = 0.0
        self._count = 0
        self._angles, self._to_sensor = None, np.eye(3)

    @property
    def heading_deg(self) -> float:
        return (90.0 - self.yaw_deg) % 360.0

    def body_in_world(self) -> np.ndarray:
        return about(2, radians(self.yaw_deg)) @ about(1, radians(self.pitch_deg)) @ about(0, radians(self.roll_deg))

    def sample(self, clockwise_dps: float = 0.0, *, mag: bool = True) -> ImuSample:
        """Turn for one period about the vertical, then measure."""
        dt = 1.0 / self.rate_hz
        self.time_s += dt
        self.yaw_deg -= clockwise_dps * dt
        self.turned_deg += clockwise_dps * dt
        self._count += 1
        angles = self.yaw_deg, self.pitch_deg, self.roll_deg
        if angles != self._angles:
            self._angles, self._to_sensor = angles, (self.body_in_world() @ self.sensor_in_body).T
        up, noise = self._to_sensor[:, 2], self.random.standard_normal((3, 3))
        gyro = up * -radians(clockwise_dps) + np.radians(self.bias_dps + noise[0] * self.gyro_noise_dps)
        accel = up * G_MPS2 + noise[1] * self.accel_noise_mps2
        field = None
        if mag and self._count % self.mag_every == 0:
            iron = self.soft_iron @ (self._to_sensor @ self.field_enu_ut) + self.hard_iron_ut
            field = tuple((iron + noise[2] * self.mag_noise_ut).tolist())
        return ImuSample(
            valid=True,
            time_s=self.time_s,
            gyro_rps=tuple(gyro.tolist()),
            accel_mps2=tuple(accel.tolist()),
            mag_ut=field,
        )

    def run(self, seconds: float, clockwise_dps: float = 0.0, **options):
        for _ in range(round(seconds * self.rate_hz)):
            yield self.sample(clockwise_dps, **options)


def feed(fusion, samples):
    """Let a fusion feel samples as they come, and return its last state."""
    last = None
    for last in samples:
        fusion.feel(last, last.time_s)
    return fusion.state(last.time_s)


def apart_deg(a: float, b: float) -> float:
    return abs((a - b + 180.0) % 360.0 - 180.0)


def euler_deg(state) -> tuple[float, float]:
    return degrees(state.roll_rad), degrees(state.pitch_rad)
