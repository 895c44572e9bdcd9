"""The output of an LD06: packets of twelve distances, clockwise, each packet with a check byte. No I/O.

Written from public programs that read one; not yet read from a device.
"""

from math import inf, nan, radians, tau
from typing import NamedTuple

from msgspec import Struct

from lbr.messages.sensing import RangeSensor, Scan, readings

BAUD = 230_400
HEAD = b"\x54\x2c"
POINTS = 12
PACKET_BYTES = 47
FULL_TURN_CDEG = 36_000
WIDEST_CDEG = 3_000
"""The limit for a packet: at the slowest turn that is worth a scan, twelve distances cover 20 degrees."""
GAP_CDEG = 500
"""The limit for the step between successive packets, which is 0.8 degrees."""


class Point(NamedTuple):
    """A distance in millimetres (0: no echo) and the lidar's confidence in it, 0 to 255."""

    distance_mm: int
    confidence: int


class Packet(Struct, frozen=True):
    """Twelve distances, evenly spaced from one angle to another, in hundredths of a degree clockwise."""

    speed_dps: int
    start_cdeg: int
    end_cdeg: int
    points: tuple[Point, ...]

    @property
    def span_cdeg(self) -> int:
        """Return the angle from the first to the last distance."""
        return (self.end_cdeg - self.start_cdeg) % FULL_TURN_CDEG


class PacketParser:
    """Turns bytes, in pieces of any size, into packets; it holds less than one. `bad_bytes` counts all others."""

    def __init__(self) -> None:
        self.bad_bytes = 0
        self._held = bytearray()

    def feed(self, data: bytes) -> list[Packet]:
        """Return the packets that these bytes complete."""
        self._held += data
        packets: list[Packet] = []
        at = 0
        while True:
            head = self._held.find(HEAD, at)
            if head < 0:
                keep = len(self._held) - (1 if self._held.endswith(HEAD[:1]) else 0)
                self.bad_bytes += max(0, keep - at)
                at = max(at, keep)
                break
            self.bad_bytes += head - at
            at = head
            if len(self._held) - at < PACKET_BYTES:
                break
            packet = decode(bytes(self._held[at : at + PACKET_BYTES]))
            if packet is None:
                self.bad_bytes += 1
                at += 1
                continue
            packets.append(packet)
            at += PACKET_BYTES
        del self._held[:at]
        return packets

    def reset(self) -> None:
        """Forget the unfinished packet."""
        self._held.clear()

    @property
    def held_bytes(self) -> int:
        """Return how many bytes of an unfinished packet it holds."""
        return len(self._held)


def decode(data: bytes) -> Packet | None:
    """Return the packet, or None if the bytes are not one."""
    if len(data) != PACKET_BYTES or not data.startswith(HEAD) or check(data[:-1]) != data[-1]:
        return None
    packet = Packet(
        speed_dps=_number(data, 2),
        start_cdeg=_number(data, 4),
        end_cdeg=_number(data, 42),
        points=tuple(Point(_number(data, at), data[at + 2]) for at in range(6, 6 + 3 * POINTS, 3)),
    )
    sane = packet.start_cdeg < FULL_TURN_CDEG and packet.end_cdeg < FULL_TURN_CDEG and packet.span_cdeg <= WIDEST_CDEG
    return packet if sane else None


def check(data: bytes) -> int:
    """Return the check byte: a CRC with the polynomial 0x4D."""
    crc = 0
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc


class Turn:
    """Gathers the packets of one turn of the mirror; a turn with a missing packet gives no scan."""

    def __init__(self, sensor: RangeSensor, least_confidence: int = 0) -> None:
        self.broken = 0
        self._sensor = sensor
        self._least = least_confidence
        self._at_cdeg = 0.0
        self._whole = False
        self._begin()

    def add(self, packet: Packet) -> Scan | None:
        """Add a packet; return the scan that it completes, or None."""
        done: Scan | None = None
        if (packet.start_cdeg - self._at_cdeg) % FULL_TURN_CDEG > GAP_CDEG:
            self._whole = False
        step = packet.span_cdeg / (POINTS - 1)
        for number, point in enumerate(packet.points):
            at_cdeg = (packet.start_cdeg + number * step) % FULL_TURN_CDEG
            if at_cdeg < self._at_cdeg - FULL_TURN_CDEG / 2:
                done = self._scan(packet.speed_dps) if self._whole else None
                self.broken += done is None
                self._begin()
                self._whole = True
            self._at_cdeg = at_cdeg
            self._take(-radians(at_cdeg / 100), point)
        return done

    def _begin(self) -> None:
        self._metres = [nan] * self._sensor.rays

    def _take(self, angle_rad: float, point: Point) -> None:
        sensor = self._sensor
        number = int(((angle_rad - sensor.first_rad + sensor.step_rad / 2) % tau) / sensor.step_rad)
        if number >= sensor.rays or point.distance_mm == 0 or point.confidence < self._least:
            return
        metres = point.distance_mm / 1000
        if metres < sensor.min_m:
            metres = -inf
        elif metres > sensor.max_m:
            metres = inf
        if not metres >= self._metres[number]:  # this way round, a number replaces NaN
            self._metres[number] = metres

    def _scan(self, speed_dps: int) -> Scan:
        sensor = self._sensor
        return Scan(
            sensor=sensor.name,
            angle_min_rad=sensor.first_rad,
            angle_increment_rad=sensor.step_rad,
            range_min_m=sensor.min_m,
            range_max_m=sensor.max_m,
            ranges_m=readings(self._metres),
            scan_s=round(360 / speed_dps, 4) if speed_dps > 0 else None,
        )


def _number(data: bytes, at: int) -> int:
    return data[at] | data[at + 1] << 8


def _entry(value: int) -> int:
    for _ in range(8):
        value = (value << 1 ^ 0x4D if value & 0x80 else value << 1) & 0xFF
    return value


_TABLE = tuple(map(_entry, range(256)))
