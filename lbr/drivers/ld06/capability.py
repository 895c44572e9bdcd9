"""The LD06 as a capability: every complete turn of its mirror becomes a scan."""

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.ld06 import Ld06Settings
from lbr.drivers.ld06.protocol import BAUD, PacketParser, Turn
from lbr.drivers.serial_line import SerialLine, open_line
from lbr.errors import DeviceError
from lbr.messages.sensing import RangeSensor

HELD_UP_S = 0.25
REPORT_PERIOD_S = 5.0


class Ld06(Capability[Ld06Settings]):
    """Publishes the lidar's scans."""

    rate_hz = 50.0

    def __init__(self, ctx: Context[Ld06Settings]) -> None:
        super().__init__(ctx)
        self._line: SerialLine | None = None
        self._parser = PacketParser()
        self._turn: Turn | None = None
        self._reported_at = self._scanned_at = self._polled = 0.0
        self._scans = self._bad_reported = 0
        self._waited = False

    def open(self) -> None:
        """Open the line; the lidar sends by itself."""
        device, settings = self.device_row, self.ctx.settings
        sensor = next(iter(self.ctx.rows(RangeSensor)), None)
        if sensor is None or sensor.rays < 2:
            what = (
                "has no row of range_sensor" if sensor is None else "needs more than one ray in the row of range_sensor"
            )
            raise DeviceError(f"'{self.ctx.name}' {what} '{settings.sensor}', which has the place of the lidar; add it")
        self._line = open_line(device, BAUD)
        self._line.drop_input()
        self._begin()
        self._turn = Turn(sensor, settings.least_confidence)

    def step(self) -> None:
        """Publish the completed turns."""
        line, turn = self._line, self._turn
        assert line is not None
        assert turn is not None
        now = self.ctx.clock()
        if now - self._polled > HELD_UP_S:  # what arrived meanwhile is old
            line.drop_input()
            self._parser.reset()
            self._scanned_at = now
        self._polled = now
        for packet in self._parser.feed(line.read()):
            scan = turn.add(packet)
            if scan is not None:
                self.ctx.publish("scan", scan)
                self._scanned_at, self._scans = now, self._scans + 1
        allowed_s = self.ctx.settings.timeout_s if self._scans else self.ctx.settings.start_timeout_s
        if not now - self._scanned_at < allowed_s:
            raise DeviceError(self._silence(now))
        self._tell_state()
        self._tell_bad(now)

    def answers(self) -> bool:
        """Return whether there was a scan; an open line is not enough."""
        return self._scans > 0

    def close(self) -> None:
        """Close the line."""
        line, self._line = self._line, None
        if line is not None:
            line.close()

    def _begin(self) -> None:
        self._parser = PacketParser()
        self._turn = None
        self._scanned_at = self._polled = self.ctx.clock()
        self._scans = self._bad_reported = 0

    def _tell_state(self) -> None:
        """Publish readiness, or at the first opening what is missing; later ones keep the error until a scan comes."""
        if self.answers():
            self.ctx.ready()
        elif not self._waited:
            self.ctx.warn("waiting for the first scan", "not_ready")
        self._waited = True

    def _tell_bad(self, now: float) -> None:
        bad = self._parser.bad_bytes
        if self._scans and bad > self._bad_reported and now - self._reported_at > REPORT_PERIOD_S:
            self._bad_reported, self._reported_at = bad, now
            broken = self._turn.broken if self._turn else 0
            text = f"{bad} bytes from the lidar were no packets, {broken} scans were not whole"
            self.ctx.event("bad_bytes", text, level="warning", data={"bad": bad, "scans": self._scans})

    def _silence(self, now: float) -> str:
        complaint = f"device '{self.ctx.settings.device}' is silent: no scan for {now - self._scanned_at:.1f} s"
        heard = f", but {self._parser.bad_bytes} bytes that are not packets" if self._parser.bad_bytes else ""
        return f"{complaint}{heard}; check its cable and power, and that its mirror turns"
