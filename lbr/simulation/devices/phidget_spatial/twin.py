"""An emulated PhidgetSpatial 3/3/3 behind Phidgets' library: records of its measurements, by its own clock.

A record is ten little-endian doubles: acceleration, turn rate and field along x, y and z, and the unit's clock. Units
are g (-1 along the axis that points up), degrees a second, gauss and milliseconds. The magnetometer is slower: between
its measurements it has the library's number for unknown.
"""

import json
import struct
from math import degrees, inf

from lbr.capability.context import Device
from lbr.simulation.devices.phidget_spatial import PhidgetSpatialFaults, PhidgetSpatialRow
from lbr.simulation.measured import AT_REST, ImuReading
from lbr.simulation.socket_port import SocketPort
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row

RECORD = struct.Struct("<10d")
NOT_MEASURED = 1e300
STANDARD_GRAVITY_MPS2 = 9.80665
MAG_MS = 8
ZEROING_MS = 2000
USB_MS = 8
"""The interval of its packets: samples at this interval or longer come one by one."""
_LONGEST_LINE = 200
_LATEST_MS = 80.0
"""Later samples are lost: after a pause of the world, many equal ones would look like a frozen unit."""
_JUMP_DPS = 400.0


class PhidgetSpatial:
    """The unit: it receives its motion, and returns the records that are due, `burst` samples together, as over USB."""

    def __init__(self, *, now: float, burst: int = 2) -> None:
        self.faults = PhidgetSpatialFaults()
        self._began = now
        self._burst = burst
        self._felt = ImuReading()
        self._zero = AT_REST
        self.plugged_in()

    def plugged_in(self) -> None:
        """Reset its settings: it is attached again."""
        self._interval_ms = 0
        self._due_ms = inf
        self._frozen = b""
        self._zeroing: list[tuple[float, float, float]] = []
        self._zeroing_until_ms = -inf
        self._line = b""

    def feel(self, reading: ImuReading) -> None:
        """Set its present measurements."""
        self._felt = reading

    def receive(self, data: bytes, now: float) -> None:
        """Receive orders; other bytes are ignored."""
        *lines, rest = (self._line + data).split(b"\n")
        self._line = rest[:_LONGEST_LINE]
        for line in lines:
            self._obey(line, now)

    def next_due(self) -> float:
        """Return when the next burst is complete."""
        late = self._burst - 1 if self._interval_ms < USB_MS else 0
        return self._began + (self._due_ms + late * self._interval_ms) / 1000.0

    def records(self, now: float) -> bytes:
        """Return the records that are due."""
        if now < self.next_due():
            return b""
        now_ms = (now - self._began) * 1000.0
        self._due_ms = max(self._due_ms, now_ms - _LATEST_MS)
        records = b""
        while self._due_ms <= now_ms:
            records += self._record(self._due_ms)
            self._due_ms += self._interval_ms
        return b"" if self.faults.silent else records

    def _obey(self, line: bytes, now: float) -> None:
        try:
            order = json.loads(line)
        except ValueError:
            return
        now_ms = (now - self._began) * 1000.0
        if not isinstance(order, dict):
            return
        interval_ms = order.get("interval_ms")
        if isinstance(interval_ms, int) and 4 <= interval_ms <= 1000:
            self._interval_ms, self._due_ms = interval_ms, now_ms + interval_ms
        if order.get("zero") is True:
            self._zeroing, self._zeroing_until_ms = [], now_ms + ZEROING_MS

    def _record(self, at_ms: float) -> bytes:
        if self.faults.frozen and self._frozen:
            return self._frozen[: RECORD.size - 8] + struct.pack("<d", at_ms)
        x, y, z = (degrees(rate) for rate in self._felt.gyro_rps)
        if at_ms < self._zeroing_until_ms:
            self._zeroing.append((x, y, z))
            gyro = AT_REST
        else:
            self._take_zero()
            gyro = (x - self._zero[0], y - self._zero[1], z - self._zero[2])
        if self.faults.jump:
            gyro = (gyro[0] + _JUMP_DPS, gyro[1], gyro[2])
        accel = [-value / STANDARD_GRAVITY_MPS2 for value in self._felt.accel_mps2]
        measured = not self.faults.no_compass and at_ms % MAG_MS < self._interval_ms
        mag = [value / 100.0 for value in self._felt.mag_ut] if measured else [NOT_MEASURED] * 3
        self._frozen = RECORD.pack(*accel, *gyro, *mag, at_ms)
        return self._frozen

    def _take_zero(self) -> None:
        if not self._zeroing:
            return
        x, y, z = (sum(axis) / len(self._zeroing) for axis in zip(*self._zeroing, strict=True))
        self._zero, self._zeroing = (x, y, z), []


class PhidgetSpatialTwin(PortTwin[SocketPort, PhidgetSpatialFaults]):
    """Serves one client, as a cable does: the next one replaces it."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, PhidgetSpatialRow)
        super().__init__(device.name, SocketPort(device.address), settings.faults)
        self._unit = PhidgetSpatial(now=around.now, burst=settings.burst)
        self._client = -1

    def service(self, now: float) -> None:
        """Do all that is due: the cable, orders in, records out."""
        self._unit.faults = self._faults
        if plug(self.port, present=not self._faults.unplug):
            self._client = -1
        if not self.port.plugged:
            return
        for client, data in self.port.receive():
            if client not in self.port.clients:
                continue
            if client != self._client:
                self.port.drop(self._client)
                self._client = client
                self._unit.plugged_in()
            self._unit.receive(data, now)
        records = self._unit.records(now)
        if records and self.port.send(self._client, records) < len(records):
            self.port.drop(self._client)  # it reads nothing: records could no longer be separated

    def next_due(self) -> float | None:
        """Return when the next records are due."""
        return self._unit.next_due() if self._client in self.port.clients else None

    def feel(self, reading: ImuReading, now: float) -> None:  # noqa: ARG002 - its records are dated when they are due
        """Set its present measurements."""
        self._unit.feel(reading)
