"""The common part of inertial units: SI units, ranges, checks that readings are live, and events."""

from math import pi
from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import replace

from lbr.capability.context import Context
from lbr.messages.imu import ImuSample
from lbr.messages.units import Vector

STANDARD_GRAVITY_MPS2 = 9.80665
RAD_PER_DEG = pi / 180.0
LOWEST, HIGHEST = -32768, 32767
REPORT_PERIOD_S = 5.0
Counts = tuple[int, int, int]


def scaled(counts: Counts, unit: float) -> Vector | None:
    """Return three 16-bit numbers in their unit; None if one is at the end of its range, and so was not measured."""
    x, y, z = counts
    if LOWEST in counts or HIGHEST in counts:
        return None
    return (x * unit, y * unit, z * unit)


QUIET_S = 2.0
STILL_RPS = 0.02
STILL_MPS2 = 0.5
"""Ten times the noise of the supported units, and less than any motion that a wheel or a hand begins."""
StillRps = Annotated[float, Meta(ge=0.0, le=0.1, description="a rate of turn within this of what it was is at rest")]
StillMps2 = Annotated[float, Meta(ge=0.0, le=2.0, description="an acceleration within this of what it was is at rest")]
QUIET_HZ = 25.0
"""The rate at which a unit at rest is read. Its first report of a motion is 40 ms old at most. In that time a base at
its highest acceleration turns by half a degree. The mean of two samples keeps most of that."""


AT_REST = 3
"""The number of readings in one sample at rest, where no axis turns faster than `SLOW_RPS`. In 80 ms that is half a
degree. A sample then comes twice within its life: 0.2 s and its span."""
SLOW_RPS = 0.1
LATE_S = 1.5 / QUIET_HZ


class Quiet:
    """Detects that a unit has lain still for a while, within bands for its noise, so that fewer samples are enough."""

    def __init__(self, still_rps: float = STILL_RPS, still_mps2: float = STILL_MPS2) -> None:
        self._still_rps, self._still_mps2 = still_rps, still_mps2
        self._like: ImuSample | None = None
        self._last: ImuSample | None = None

    def look(self, sample: ImuSample) -> bool:
        """Return whether the unit is still, after each sample; an unmeasured value starts the time anew.

        A repeated sample asks for more frequent readings but is no motion: a unit that is read early repeats its last.
        """
        last, self._last = self._last, sample
        if self._like is None or not self._near(sample, self._like):
            self._like = sample if _measured(sample) else None
            return False
        repeats = last is not None and _same(sample, last)
        return not repeats and sample.time_s - self._like.time_s >= QUIET_S

    def _near(self, sample: ImuSample, like: ImuSample) -> bool:
        return (
            sample.valid
            and _differ_less(sample.gyro_rps, like.gyro_rps, self._still_rps)
            and _differ_less(sample.accel_mps2, like.accel_mps2, self._still_mps2)
        )


class RestingSamples:
    """Averages readings of a unit at rest into one sample, so that a heading from them stays as exact."""

    def __init__(self) -> None:
        self._readings: list[ImuSample] = []

    def take(self, reading: ImuSample, *, quiet: bool) -> list[ImuSample]:
        """Return the samples to publish now: empty while more readings are due, all of them as soon as it moves."""
        waiting = self._readings
        if not (quiet and _is_slow(reading)):
            self._readings = []
            return [*waiting, reading]
        if waiting and reading.time_s - waiting[-1].time_s > LATE_S:
            self._readings = [reading]
            return waiting
        waiting.append(reading)
        if len(waiting) < AT_REST:
            return []
        self._readings = []
        return [_mean(waiting)]


class LifeSigns:
    """Distinguishes a working unit from one that is asleep, gone or frozen: real noise never repeats, even after a
    restart."""

    def __init__(self, most_alike: int) -> None:
        self._most_alike = most_alike
        self._last: tuple[int, ...] = ()
        self._alike = 0

    def missing(self, counts: tuple[int, ...]) -> str:
        """Return why the newest reading of all axes is invalid, or an empty string."""
        self._alike = self._alike + 1 if counts == self._last else 1
        self._last = counts
        if not any(counts):
            return "all it reads is zero, as when the unit is asleep"
        if all(count == -1 for count in counts):
            return "all bits it reads are ones, as when no unit drives the bus"
        if self._alike > self._most_alike:
            return f"the unit is frozen: the same {self._alike} times in a row"
        return ""


class Notices:
    """Publishes warnings of a unit, at most one of a kind every few seconds."""

    def __init__(self, ctx: Context[Struct]) -> None:
        self._ctx = ctx
        self._published_at: dict[str, float] = {}

    def tell(self, kind: str, text: str) -> None:
        """Publish a warning, unless one of its kind was published a moment ago."""
        now = self._ctx.clock()
        if now - self._published_at.get(kind, -REPORT_PERIOD_S) >= REPORT_PERIOD_S:
            self._published_at[kind] = now
            self._ctx.event(kind, text, level="warning")


def _measured(sample: ImuSample) -> bool:
    return sample.valid and sample.gyro_rps is not None and sample.accel_mps2 is not None


def _same(one: ImuSample, other: ImuSample) -> bool:
    return one.gyro_rps == other.gyro_rps and one.accel_mps2 == other.accel_mps2


def _differ_less(one: Vector | None, other: Vector | None, by: float) -> bool:
    if one is None or other is None:
        return False
    return all(abs(a - b) < by for a, b in zip(one, other, strict=True))


def _is_slow(sample: ImuSample) -> bool:
    return sample.gyro_rps is not None and max(map(abs, sample.gyro_rps)) < SLOW_RPS


def _mean(readings: list[ImuSample]) -> ImuSample:
    newest = readings[-1]
    fields = [reading.mag_ut for reading in readings if reading.mag_ut is not None]
    return replace(
        newest,
        gyro_rps=_mean_vector([reading.gyro_rps for reading in readings if reading.gyro_rps is not None]),
        accel_mps2=_mean_vector([reading.accel_mps2 for reading in readings if reading.accel_mps2 is not None]),
        mag_ut=fields[-1] if fields else None,
        span_s=newest.time_s - readings[0].time_s,
    )


def _mean_vector(vectors: list[Vector]) -> Vector:
    x, y, z = (sum(axis) / len(vectors) for axis in zip(*vectors, strict=True))
    return (x, y, z)
