"""Detects a still body, and learns the gyro's zero, only then. No I/O, no clock."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import degrees, radians, sqrt

from lbr.messages.units import Vector
from lbr.operations.attitude.geometry import compass_yaw_deg, minus, norm, scaled, wrapped_deg
from lbr.operations.attitude.settings import AttitudeSettings

BLOCK_S = 0.5
NEXT_BLOCKS = 6
"""The number of blocks at rest after which the zero is learnt again."""
FIRST_BLOCK_S = 0.25
FIRST_BLOCKS = 2
"""The first zero comes sooner: 50 samples of an MPU-9150 (0.06 deg/s of noise, datasheet) give it to 0.01 deg/s."""
WEIGHT = 0.3
"""The weight of newer blocks, once a zero is known."""
FIELD_TURNED_DEG = 2.0
ALIKE_DPS = 0.5
ACCEL_NOISE_MPS2 = 0.5
LEAST_SAMPLES = 5

_SMOOTH_S = 0.05
_ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(slots=True)
class _Sums:
    """Sums over some vectors."""

    count: int = 0
    total: Vector = _ZERO
    squares: Vector = _ZERO

    def add(self, value: Vector) -> None:
        x, y, z = value
        a, b, c = self.total
        d, e, f = self.squares
        self.count += 1
        self.total = (a + x, b + y, c + z)
        self.squares = (d + x * x, e + y * y, f + z * z)

    def mean(self) -> Vector:
        return scaled(self.total, 1.0 / self.count)

    def noise(self) -> float:
        """Return the greatest standard deviation of the three."""
        n = self.count
        return max(
            sqrt(max(0.0, square / n - (total / n) ** 2))
            for total, square in zip(self.total, self.squares, strict=True)
        )


@dataclass(slots=True)
class _Block:
    """The samples of a short while."""

    began_s: float
    gyro: _Sums = field(default_factory=_Sums)
    accel: _Sums = field(default_factory=_Sums)
    mag: _Sums = field(default_factory=_Sums)


class Stillness:
    """Processes every sample, along the body's axes, into `still` and `bias_rps` (None until it is known)."""

    def __init__(self, settings: AttitudeSettings) -> None:
        self.bias_rps: Vector | None = None
        self._settings = settings
        self._block: _Block | None = None
        self._streak: list[Vector] = []
        self._yaws: list[float] = []
        self._rate_rps = _ZERO
        self._last_s: float | None = None

    @property
    def still(self) -> bool:
        """Return whether the body turns about no axis."""
        limit = radians(self._settings.still_dps)
        return self.bias_rps is not None and bool(self._streak) and max(map(abs, self._rate_rps)) < limit

    @property
    def compass_deg(self) -> float | None:
        """The compass's yaw over the last block at rest, which is more exact than one sample; None without one."""
        return self._yaws[-1] if self._yaws and self.still else None

    def interrupt(self) -> None:
        """Discard the unfinished blocks, because samples are missing; the learnt zero stays."""
        self._block, self._streak, self._yaws, self._last_s = None, [], [], None

    def add(self, time_s: float, gyro_rps: Vector, accel_mps2: Vector, mag_ut: Vector | None) -> None:
        """Add a sample; `gyro_rps` as it was measured."""
        self._smooth(time_s, gyro_rps)
        block = self._block
        if block is None:
            block = self._block = _Block(time_s)
        block.gyro.add(gyro_rps)
        block.accel.add(accel_mps2)
        if mag_ut is not None:
            block.mag.add(mag_ut)
        least_s = FIRST_BLOCK_S if self.bias_rps is None else BLOCK_S
        if time_s - block.began_s >= least_s and block.gyro.count >= LEAST_SAMPLES:
            self._block = None
            self._judge(block)

    def _smooth(self, time_s: float, gyro_rps: Vector) -> None:
        share = 1.0 if self._last_s is None else min(1.0, (time_s - self._last_s) / _SMOOTH_S)
        self._last_s = time_s
        x, y, z = self._rate_rps
        a, b, c = minus(gyro_rps, self.bias_rps or _ZERO)
        self._rate_rps = (x + share * (a - x), y + share * (b - y), z + share * (c - z))

    def _judge(self, block: _Block) -> None:
        mean = block.gyro.mean()
        if not self._is_quiet(block, mean):
            self._streak, self._yaws = [], []
            return
        if self._streak and norm(minus(mean, self._streak[-1])) > radians(ALIKE_DPS):
            self._streak, self._yaws = [], []
        self._streak.append(mean)
        self._yaws.extend(_yaw_deg(block))
        if self._field_turned():
            self._streak, self._yaws = [], []
        elif len(self._streak) >= (FIRST_BLOCKS if self.bias_rps is None else NEXT_BLOCKS):
            self._learn()

    def _is_quiet(self, block: _Block, mean: Vector) -> bool:
        s = self._settings
        return (
            block.gyro.noise() < radians(s.still_noise_dps)
            and block.accel.noise() < ACCEL_NOISE_MPS2
            and max(map(abs, mean)) < radians(s.bias_limit_dps)
        )

    def _field_turned(self) -> bool:
        return len(self._yaws) > 1 and abs(wrapped_deg(self._yaws[-1] - self._yaws[0])) > FIELD_TURNED_DEG

    def _learn(self) -> None:
        count = len(self._streak)
        sums = _Sums()
        for mean in self._streak:
            sums.add(mean)
        mean, bias = sums.mean(), self.bias_rps
        turned_deg = 0.0 if bias is None else degrees(norm(minus(mean, bias))) * count * BLOCK_S
        watched = len(self._yaws) == count
        self._streak, self._yaws = self._streak[-1:], self._yaws[-1:]
        if bias is None or (watched and turned_deg > 2 * FIELD_TURNED_DEG):
            self.bias_rps = mean  # the gyro measures a turn, and the field does not
        elif norm(minus(mean, bias)) < radians(self._settings.still_dps):
            self.bias_rps = tuple(old + WEIGHT * (new - old) for old, new in zip(bias, mean, strict=True))  # type: ignore[assignment]


def _yaw_deg(block: _Block) -> Iterator[float]:
    """Yield the compass's yaw over a block, if it has one."""
    if block.mag.count == 0:
        return
    accel = block.accel.mean()
    yaw = compass_yaw_deg(block.mag.mean(), scaled(accel, 1.0 / (norm(accel) or 1.0)))
    if yaw is not None:
        yield yaw
