"""The PhidgetSpatial as a capability: every sample, dated by the device's own clock."""

import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from math import inf

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.inertial import QUIET_HZ, LifeSigns, Notices, Quiet
from lbr.drivers.phidget_spatial import PhidgetSpatialSettings
from lbr.drivers.phidget_spatial.emulated import RECORD
from lbr.drivers.phidget_spatial.library import Opened, find
from lbr.drivers.phidget_spatial.readings import DeviceClock, Reading, sample
from lbr.errors import DeviceError
from lbr.messages.imu import ImuSample
from lbr.messages.leases import CommandReply

ATTACH_MS = 800
SILENT_S = 0.2
ZERO_S = 2.2
STILL_DPS = 5.0
MOST_ALIKE = 25
MOST_WAITING = 512
READING_HZ, LOOKING_HZ = 125.0, 5.0
QUIET_MS = round(1000.0 / QUIET_HZ)


class PhidgetSpatial(Capability[PhidgetSpatialSettings]):
    """Publishes the unit's measurements; the library's thread only queues them."""

    rate_hz = READING_HZ

    def __init__(self, ctx: Context[PhidgetSpatialSettings]) -> None:
        super().__init__(ctx)
        self._notices = Notices(ctx)
        self._opened: Opened | None = None
        self._interval_ms: int = ctx.settings.interval_ms
        self._waiting: deque[Reading] = deque(maxlen=MOST_WAITING)
        self._begin()

    def open(self) -> None:
        """Wait a moment for the unit, and start measuring."""
        device = self.device_row
        opened = self._opened = find(device)
        self._begin()
        opened.unit.setOnSpatialDataHandler(self._on_data)
        opened.unit.setOnDetachHandler(self._on_detach)
        try:
            opened.unit.openWaitForAttachment(ATTACH_MS)
            opened.unit.setDataInterval(self._interval_ms)
            if self.ctx.settings.zero_at_start:
                self._zero(opened)
        except opened.errors as err:
            raise DeviceError(
                f"{self._device_text()}: {_error_text(err)}; is it plugged in, and may this user use it?"
            ) from err
        device.tap.opened()
        self._heard_s = self.ctx.clock()

    def step(self) -> None:
        """Publish the queued samples; raise DeviceError if there have been none for too long."""
        now = self.ctx.clock()
        quiet = self._slow and not self._waiting
        while self._waiting:
            reading = self._waiting.popleft()
            self._heard_s = reading.arrived_s
            sample = self._sample(reading)
            self.ctx.publish("sample", sample)
            quiet = self._quiet.look(sample) or quiet  # a burst may repeat samples
        self._pace(quiet=quiet)
        if self._detached:
            raise DeviceError(f"{self._device_text()} was unplugged; plug it in again")
        if not now - self._heard_s <= SILENT_S + 4 * self._interval_ms / 1000.0:
            raise DeviceError(f"{self._device_text()} has fallen silent; reopening it")

    def command(self, call: Call) -> None:
        """Take the gyro's zero, if the unit lies still."""
        if call.name != "zero":
            super().command(call)
        elif self._opened is None or self.ctx.clock() - self._heard_s > SILENT_S:
            call.refuse("the unit measures nothing now", "unreachable")
        elif self._turns:
            call.refuse(
                f"it turns by more than {STILL_DPS:g} degrees a second; keep it still for two seconds", "not_ready"
            )
        else:
            try:
                self._zero(self._opened)
            except self._opened.errors as err:
                call.refuse(f"{self._device_text()}: {_error_text(err)}", "failed")
                return
            call.reply(CommandReply(accepted=True, reason=f"keep it still for {ZERO_S:g} s"))

    def degraded(self, reason: str) -> None:
        """Publish that nothing is measured."""
        self.ctx.publish("sample", ImuSample(valid=False, time_s=self.ctx.clock(), reason=reason))

    def close(self) -> None:
        """Close the unit."""
        opened, self._opened = self._opened, None
        if opened is not None:
            with suppress(*opened.errors):
                opened.unit.close()

    def _begin(self) -> None:
        self._waiting.clear()
        self._clock = DeviceClock()
        self._signs = LifeSigns(MOST_ALIKE)
        self._zeroed_s = -inf
        self._heard_s = -inf
        self._detached = self._turns = self._slow = False
        self._quiet = Quiet(self.ctx.settings.still_rps, self.ctx.settings.still_mps2)
        self.rate_hz, self._interval_ms = READING_HZ, self.ctx.settings.interval_ms

    def _pace(self, *, quiet: bool) -> None:
        """Make a unit that lies still measure seldom, each sample waking the loop; otherwise restore its row's
        interval."""
        if quiet == self._slow or self._opened is None:
            return
        usual_ms = self.ctx.settings.interval_ms
        self._slow, self._interval_ms = quiet, max(usual_ms, QUIET_MS) if quiet else usual_ms
        self.rate_hz = LOOKING_HZ if quiet else READING_HZ
        try:
            self._opened.unit.setDataInterval(self._interval_ms)
        except self._opened.errors as err:
            raise DeviceError(f"{self._device_text()}: {_error_text(err)}; reopening it") from err

    def _on_data(
        self, _: object, accel: Sequence[float], gyro: Sequence[float], mag: Sequence[float], device_ms: float
    ) -> None:
        """Queue a sample, on the library's thread, which reuses its lists; the recorder gets it as the emulated unit's
        record."""
        self._waiting.append(Reading(tuple(accel), tuple(gyro), tuple(mag), device_ms, time.monotonic()))
        if self.ctx.device is not None and self.ctx.device.tap.wanted:
            self.ctx.device.tap.came(RECORD.pack(*accel, *gyro, *mag, device_ms))
        if self._slow:
            self.ctx.wake()

    def _on_detach(self, _: object) -> None:
        self._detached = True
        self.ctx.wake()

    def _sample(self, reading: Reading) -> ImuSample:
        time_s = self._clock.date_s(reading)
        self._turns = not max(map(abs, reading.gyro_dps), default=inf) <= STILL_DPS
        if time_s < self._zeroed_s:
            return ImuSample(valid=False, time_s=time_s, reason="the gyro's zero is being taken; keep it still")
        counts = tuple(round(value * 1e6) for value in (*reading.accel_g, *reading.gyro_dps) if abs(value) < 1e6)
        if why := self._signs.missing(counts):
            self._notices.tell("imu_dead", f"{self._device_text()}: {why}")
            return ImuSample(valid=False, time_s=time_s, reason=why)
        return sample(reading, time_s, self.ctx.settings.gravity_sign)

    def _zero(self, opened: Opened) -> None:
        opened.unit.zeroGyro()
        self._zeroed_s = self.ctx.clock() + ZERO_S

    def _device_text(self) -> str:
        return f"device '{self.device_row.name}' at {self.device_row.address}"


def _error_text(err: Exception) -> str:
    details = getattr(err, "details", "") or getattr(err, "strerror", "") or err
    return str(details) or type(err).__name__
