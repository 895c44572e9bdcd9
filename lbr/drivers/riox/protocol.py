"""The output of a RIOX: lines that end with CR, `NAME=number:number:…`, `-` for a refusal. No I/O."""

import re
from dataclasses import dataclass
from math import hypot

from lbr.drivers.inertial import HIGHEST, LOWEST, RAD_PER_DEG, STANDARD_GRAVITY_MPS2, Counts, scaled
from lbr.drivers.lines import LineSplitter, RawLine
from lbr.drivers.riox import RioxSettings
from lbr.messages.imu import ImuSample
from lbr.messages.units import Quaternion

MOTION, ORIENTATION = "ML", "QO"
COUNTS = {MOTION: 10, ORIENTATION: 4}
MAX_LINE_BYTES = 160
LENGTH_TOLERANCE = 0.1


@dataclass(frozen=True, slots=True)
class Answer:
    """The numbers of an answer: for `ML` acceleration, temperature, rotation and field, for `QO` w, x, y, z."""

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Echo:
    """A query, repeated by the unit."""

    name: str


@dataclass(frozen=True, slots=True)
class Refused:
    """The unit refused a query as unknown."""


@dataclass(frozen=True, slots=True)
class BadLine:
    """A line of none of these forms; `text` is its beginning."""

    text: str


Reply = Answer | Echo | Refused | BadLine


class ReplyParser:
    """Turns bytes, in pieces of any size, into replies; it holds at most one line."""

    def __init__(self) -> None:
        self._lines = LineSplitter(rb"[\r\n]", MAX_LINE_BYTES)

    def feed(self, data: bytes) -> list[Reply]:
        """Return the replies that these bytes complete."""
        return [_parse(line) for line in self._lines.feed(data) if line.data.strip()]

    def reset(self) -> None:
        """Forget the unfinished line."""
        self._lines.reset()

    @property
    def held_bytes(self) -> int:
        """Return how many bytes of an unfinished line it holds."""
        return self._lines.held_bytes


def encode_query(name: str) -> bytes:
    """Return the query for `ML` or `QO`."""
    return b"?%s\r" % name.encode("ascii")


def to_sample(motion: Answer, orientation: Quaternion | None, time_s: float, settings: RioxSettings) -> ImuSample:
    """Return an answer to `ML` in SI units."""
    c = motion.counts
    accel: Counts = (c[0], c[1], c[2])
    gyro: Counts = (c[4], c[5], c[6])
    mag: Counts = (c[7], c[8], c[9])
    return ImuSample(
        valid=True,
        time_s=time_s,
        accel_mps2=scaled(accel, STANDARD_GRAVITY_MPS2 / settings.accel_lsb_per_g),
        gyro_rps=scaled(gyro, RAD_PER_DEG / settings.gyro_lsb_per_dps),
        mag_ut=scaled(mag, settings.mag_ut_per_lsb) if any(mag) else None,
        temperature_c=c[3] / settings.temperature_lsb_per_c + settings.temperature_offset_c,
        orientation=orientation,
    )


def to_orientation(answer: Answer, divisor: float) -> Quaternion | None:
    """Return an answer to `QO` at length 1; None if its length is so far from `divisor` that it is no orientation."""
    w, x, y, z = answer.counts
    length = hypot(w, x, y, z)
    if not abs(length / divisor - 1.0) <= LENGTH_TOLERANCE:
        return None
    return (w / length, x / length, y / length, z / length)


def _parse(line: RawLine) -> Reply:
    text = line.data.strip()
    if line.overlong:
        return BadLine(line.readable)
    if text == b"-":
        return Refused()
    if found := _ECHO.fullmatch(text):
        return Echo(found[1].decode("ascii"))
    if found := _ANSWER.fullmatch(text):
        name, counts = found[1].decode("ascii"), tuple(map(int, found[2].split(b":")))
        if len(counts) == COUNTS[name] and all(LOWEST <= count <= HIGHEST for count in counts):
            return Answer(name, counts)
    return BadLine(line.readable)


_ECHO = re.compile(rb"\?(ML|QO)")
_ANSWER = re.compile(rb"(ML|QO)=(-?\d{1,5}(?::-?\d{1,5})*)")
