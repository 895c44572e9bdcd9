"""The emulated LD06: a mirror that turns clockwise ten times a second, and 4500 distances a second in packets.

It follows public programs that read one; it was not compared with a device.
"""

from collections.abc import Callable, Sequence
from math import radians, tau
from random import Random

from lbr.capability.context import Device
from lbr.messages.sensing import RangeSensor
from lbr.simulation.devices.ld06 import Ld06Faults, Ld06Row
from lbr.simulation.measured import Sensed
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin
from lbr.simulation.wire import flip_one_bit, noise

Face = Callable[[float], float | None]
"""Returns the distance in metres along an angle, anticlockwise from the lidar's zero in radians; None: no echo."""

_POINTS, _POINTS_PER_S, _STEP_CDEG, _SPEED_DPS = 12, 4500, 80, 3600
_PACKET_S = _POINTS / _POINTS_PER_S
_BURST = 4
"""The number of packets that are sent together: a host that wakes for each of 375 a second does little else."""
_LATEST_S = 0.1
"""Older output is lost, as nobody read it in time."""
_STARTUP_S = 0.5
_CONFIDENCE = 200
_NOTHING_MM = 0
_MOST_MM = 0xFFFF


class Ld06:
    """A lidar from power-up on; it sends by itself, and has no input. `face` are its surroundings."""

    def __init__(self, *, faults: Ld06Faults | None = None, seed: int = 0, powered_at: float = 0.0) -> None:
        self.faults = faults or Ld06Faults()
        self.face: Face = _nothing
        self._random = Random(seed)
        self.power_cycle(powered_at)

    def power_cycle(self, now: float) -> None:
        """Restart: the mirror takes half a second to reach its speed."""
        self._began = self._next_at = now + _STARTUP_S
        self._angle_cdeg = 0
        self._last: dict[int, int] = {}

    def poll(self, now: float) -> bytes:
        """Return the packets that are ready."""
        packets = bytearray()
        self._next_at = max(self._next_at, now - _LATEST_S) if now > self._next_at else self._next_at
        while now >= self._next_at:
            packets += b"".join(self._packet() for _ in range(_BURST))
            self._next_at += _BURST * _PACKET_S
        return b"" if self.faults.silent else bytes(packets)

    def next_due(self) -> float:
        """Return when the next packets are ready."""
        return self._next_at

    def _packet(self) -> bytes:
        start = self._angle_cdeg
        step = 0 if self.faults.stalled else _STEP_CDEG
        angles = [(start + number * step) % 36000 for number in range(_POINTS)]
        self._angle_cdeg = (start + _POINTS * step) % 36000
        points = b"".join(self._measured(angle).to_bytes(2, "little") + bytes((_CONFIDENCE,)) for angle in angles)
        speed = 0 if self.faults.stalled else _SPEED_DPS
        time_ms = round((self._next_at - self._began) * 1000) % 30000
        head = b"\x54\x2c" + speed.to_bytes(2, "little") + start.to_bytes(2, "little")
        body = head + points + angles[-1].to_bytes(2, "little") + time_ms.to_bytes(2, "little")
        packet = body + bytes((_check(body),))
        if self._random.random() < self.faults.bit_flip:
            packet = flip_one_bit(packet, self._random)
        return noise(self._random) + packet if self._random.random() < self.faults.garbage else packet

    def _measured(self, angle_cdeg: int) -> int:
        if self.faults.dark:
            return _NOTHING_MM
        if not (self.faults.frozen and angle_cdeg in self._last):
            metres = self.face(-radians(angle_cdeg / 100))
            self._last[angle_cdeg] = _NOTHING_MM if metres is None else min(_MOST_MM, round(metres * 1000))
        return self._last[angle_cdeg]


def _nothing(angle_rad: float) -> float | None:
    del angle_rad
    return None


def _check(data: bytes) -> int:
    """Return the packet's last byte: a CRC of eight bits with the polynomial 0x4D."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ 0x4D if crc & 0x80 else crc << 1
            crc &= 0xFF
    return crc


class Ld06Twin(LineTwin[Ld06Faults]):
    """Sends the distances around the place in its row of `range_sensor`; without that row, none."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Ld06Row)
        self._sensor = next((sensor for sensor in around.sensors if sensor.name == settings.sensor), None)
        self._lidar = Ld06(faults=settings.faults, seed=around.seed_for(device), powered_at=around.now)
        super().__init__(device, settings.faults, self._lidar)

    def cable(self, now: float) -> None:
        """Begin anew with each cable, which brings its power."""
        if self.port.plugged:
            self._lidar.power_cycle(now)

    def sense(self, sensed: Sensed) -> None:
        """Set the surroundings from the world."""
        sensor = self._sensor
        if sensor is not None and sensor.name in sensed.scans_m:
            faced = sensed.scans_m[sensor.name]
            self._lidar.face = lambda angle_rad: _along(faced, sensor, angle_rad)


def _along(faced: Sequence[float | None], sensor: RangeSensor, angle_rad: float) -> float | None:
    """Return the distance along an angle, by the nearest ray; None where there is no ray."""
    number = int(((angle_rad - sensor.first_rad + sensor.step_rad / 2) % tau) / sensor.step_rad)
    return faced[number] if number < len(faced) else None
