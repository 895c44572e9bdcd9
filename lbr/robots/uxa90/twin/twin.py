"""The emulated UXA-90 on its serial line."""

from collections.abc import Mapping

from lbr.capability.context import Device
from lbr.robots.uxa90.twin import Uxa90Faults, Uxa90Row
from lbr.robots.uxa90.twin.board import MainBoard
from lbr.simulation.measured import Sensed, ServoDrive, ServoFelt
from lbr.simulation.port import PtyPort
from lbr.simulation.trace import TraceFile
from lbr.simulation.twins.base import PortTwin, Surroundings, plug, row


class Uxa90Twin(PortTwin[PtyPort, Uxa90Faults]):
    """Moves a body's joints, and measures them; without a body its servos turn by themselves, carrying nothing.

    Its trace has lines of `monotonic_ns` and one of: `read HEX`, what came as one piece; `said HEX`; `mode`, then
    `off`, `normal` or `pc`, then the slot of the motion that plays, or 0; `plugged` and `unplugged`.
    """

    def __init__(self, device: Device, around: Surroundings) -> None:
        settings = row(device, Uxa90Row)
        super().__init__(device.name, PtyPort(device.address), settings.faults)
        self.board = MainBoard(settings, seed=around.seed_for(device))
        wanted = f"{device.address}.trace" if settings.trace else ""
        self._trace = TraceFile(wanted, f"device '{device.name}', setting `trace`")
        self._was = ""

    def watched(self) -> int | None:
        """Return the descriptor whose bytes it will take; None: none now."""
        return None if self._faults.stop_reading else super().watched()

    def service(self, now: float) -> None:
        """Do all that is due: the cable, bytes in, bytes out."""
        if self.board.faults is not self._faults:
            self.board.faults = self._faults
        was_plugged = self.port.plugged
        plug(self.port, present=not self._faults.unplug)
        if self.port.plugged != was_plugged:
            self._trace.write(now, "plugged" if self.port.plugged else "unplugged")
        heard = b"" if self._faults.stop_reading else self.port.read()
        if heard:
            self._trace.write(now, f"read {heard.hex()}")
        answers = self.board.feed(heard, now, self.port.baud()) if heard else self.board.poll(now)
        self._tell_mode(now)
        if answers and self.port.plugged:
            self._trace.write(now, f"said {answers.hex()}")
            self.port.write(answers)

    def next_due(self) -> float | None:
        """Return when it next has something to say or to do."""
        return self.board.next_due()

    def sense(self, sensed: Sensed) -> None:
        """Measure how it is held; its servos feel each step of the world."""
        self.board.imu = sensed.imu

    def drives(self, now: float) -> Mapping[int, ServoDrive]:
        """Return what each servo's motor does now; a servo without supply is limp."""
        return self.board.drives(now)

    def feel_servos(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Take in where the world has the servos, and the voltage of their supply."""
        self.board.feel(felt, supply_v, now)

    def close(self) -> None:
        """Pull it out, and end the trace."""
        super().close()
        self._trace.close()

    def _tell_mode(self, now: float) -> None:
        mode = f"mode {self.board.mode} {self.board.playing or 0}"
        if mode != self._was:
            self._was = mode
            self._trace.write(now, mode)
