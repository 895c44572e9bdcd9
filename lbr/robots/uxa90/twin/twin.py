"""The emulated UXA-90 on its serial line."""

from collections.abc import Mapping

from lbr.capability.context import Device
from lbr.robots.uxa90.twin import Uxa90Faults, Uxa90Row
from lbr.robots.uxa90.twin.board import MainBoard
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.trace import TraceFile
from lbr.simulation.twins.base import Surroundings, row
from lbr.simulation.twins.line import LineTwin


class Uxa90Twin(LineTwin[Uxa90Faults]):
    """Moves a body's joints, and measures them; without a body its servos turn by themselves, carrying nothing.

    Its trace has lines of `monotonic_ns` and one of the following. `read HEX`: one piece of input. `said HEX`: output.
    `mode`, then `off`, `normal` or `pc`, then the slot of the current motion, or 0. `plugged` and `unplugged`: the
    cable.
    """

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Uxa90Row)
        self.board = MainBoard(settings, seed=around.seed_for(device))
        super().__init__(device, settings.faults, self.board)
        wanted = f"{device.address}.trace" if settings.trace else ""
        self._trace = TraceFile(wanted, f"device '{device.name}', setting `trace`")
        self._was = ""

    def cable(self, now: float) -> None:
        """Trace the cable."""
        self._trace.write(now, "plugged" if self.port.plugged else "unplugged")

    def hear(self, data: bytes, now: float) -> bytes:
        """Receive bytes at the host's rate; return the bytes that have crossed the line back."""
        if data:
            self._trace.write(now, f"read {data.hex()}")
        answers = self.board.feed(data, now, self.port.baud()) if data else self.board.poll(now)
        self._tell_mode(now)
        return answers

    def say(self, data: bytes, now: float) -> None:
        """Put bytes on the line, if its cable is in."""
        if self.port.plugged:
            self._trace.write(now, f"said {data.hex()}")
            super().say(data, now)

    def sense(self, sensed: Sensed) -> None:
        """Set the measured acceleration; its servos get each step of the world."""
        self.board.imu = sensed.imu

    def drives(self, now: float) -> Mapping[int, ServoDrive]:
        """Return what each servo's motor does now; a servo without supply is limp."""
        return self.board.drives(now)

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' positions in the world, and the voltage of their supply."""
        self.board.feel(felt, supply_v, now)

    def close(self) -> None:
        """Unplug it, and end the trace."""
        super().close()
        self._trace.close()

    def _tell_mode(self, now: float) -> None:
        mode = f"mode {self.board.mode} {self.board.playing or 0}"
        if mode != self._was:
            self._was = mode
            self._trace.write(now, mode)
