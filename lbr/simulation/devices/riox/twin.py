"""An emulated Roboteq RIOX-1216AHRS: bytes in, bytes out.

Its scales are settings of the row, as no manual was at hand. `?ML` answers accelerations, temperature, turn rates and
field, `?QO` the quaternion w, x, y, z, `?EO` roll, pitch and yaw. All other lines are refused with `-`. It echoes until
`^ECHOF 1`.
"""

from collections.abc import Iterable
from math import degrees

from lbr.capability.context import Device
from lbr.simulation.ahrs import Orientation, angles_deg
from lbr.simulation.ascii_device import AsciiDevice
from lbr.simulation.devices.riox import RioxFaults, RioxRow
from lbr.simulation.measured import ImuReading
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin
from lbr.simulation.wire import strikes

G_MPS2 = 9.80665

_JUMP_RPS = 4.0
_PIECE_BYTES = 5
_PAUSE_S = 0.003
_IDENTITY = {"FID": "Roboteq v1.6 RIOX 06/01/2015", "TRN": "RIOX:RIOX1216AHRS"}


class RioxDevice(AsciiDevice[RioxFaults]):
    """The unit from power-up on."""

    def __init__(self, settings: RioxRow, *, seed: int = 0) -> None:
        self._settings = settings
        self._felt = ImuReading()
        self._orientation = Orientation()
        super().__init__(settings.faults, seed)

    def boot(self) -> None:
        """Start with the settings of the row; all other state is reset."""
        super().boot()
        self.echo = self._settings.echo

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set its measurements from now on."""
        if not self.faults.frozen:
            self._felt = reading
            self._orientation.follow(reading, now)

    def feed(self, data: bytes, now: float) -> bytes:
        """Receive bytes from the host; return the bytes that have crossed the line back so far."""
        if self.present(now):
            self.receive(data, now)
        return self.poll(now)

    def poll(self, now: float) -> bytes:
        """Return the bytes that have crossed the line to the host so far."""
        if self.faults.brown_out:
            self.outbox.clear()
        return self.outbox.due(now)

    def next_due(self) -> float | None:
        """Return when an answer will have crossed."""
        return self.outbox.next_due()

    def present(self, now: float) -> bool:  # noqa: ARG002
        """Return whether the host sees the port."""
        return not (self.faults.unplug or self.faults.brown_out)

    def execute(self, line: str, now: float) -> None:
        """Carry out a line, and answer."""
        if line:
            words = line.upper().split()
            refused = strikes(self.faults.refuse, self.random)
            self.answer("-" if refused else self._reply(words), now)

    def send(self, data: bytes, now: float) -> None:
        """Send bytes on the line: whole, cut short or in pieces."""
        if strikes(self.faults.half, self.random):
            data = data[: self.random.randrange(len(data))]
        if not self.faults.pieces:
            super().send(data, now)
            return
        for turn, start in enumerate(range(0, len(data), _PIECE_BYTES)):
            super().send(data[start : start + _PIECE_BYTES], now + turn * _PAUSE_S)

    def _reply(self, words: list[str]) -> str:
        match words:
            case ["?ML"]:
                return "ML=" + _list(self._measured())
            case ["?QO"]:
                scale = self._settings.quaternion_divisor
                return "QO=" + _list(part * scale for part in self._orientation.quaternion or (1.0, 0.0, 0.0, 0.0))
            case ["?EO"]:
                angles = angles_deg(self._orientation.quaternion or (1.0, 0.0, 0.0, 0.0))
                return "EO=" + _list(angle * self._settings.euler_lsb_per_deg for angle in angles)
            case ["?FID" | "?TRN"]:
                return f"{words[0][1:]}={_IDENTITY[words[0][1:]]}"
            case ["^ECHOF", "0" | "1"]:
                self.echo = words[1] == "0"
                return "+"
            case _:
                return "-"

    def _measured(self) -> list[float]:
        row, felt = self._settings, self._felt
        x, y, z = felt.gyro_rps
        if strikes(self.faults.jump, self.random):
            z += self.random.choice((-_JUMP_RPS, _JUMP_RPS))
        return [
            *(axis / G_MPS2 * row.accel_lsb_per_g for axis in felt.accel_mps2),
            (felt.temperature_c - row.temperature_offset_c) * row.temperature_lsb_per_c,
            *(degrees(axis) * row.gyro_lsb_per_dps for axis in (x, y, z)),
            *(axis / row.mag_ut_per_lsb for axis in felt.mag_ut),
        ]


def _list(values: Iterable[float]) -> str:
    return ":".join(str(max(-32768, min(32767, round(value)))) for value in values)


class RioxTwin(LineTwin[RioxFaults]):
    """Answers questions about turn, tilt and field."""

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, RioxRow)
        self._device = RioxDevice(settings, seed=around.seed_for(device))
        super().__init__(device, settings.faults, self._device)

    def present(self, now: float) -> bool:
        """Return whether the host sees the port."""
        return self._device.present(now)

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes; return the bytes that have crossed the line back."""
        return self._device.feed(data, now)

    def feel(self, reading: ImuReading, now: float) -> None:
        """Set its present measurements."""
        self._device.feel(reading, now)
