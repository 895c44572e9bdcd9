"""The range board as a device: started, read, and reported when silent."""

from collections.abc import Callable

from lbr.drivers.byte_line import ByteLine
from lbr.drivers.ultrasonic import UltrasonicSettings
from lbr.drivers.ultrasonic.protocol import FINISH, START, BadLine, Frame, LineParser
from lbr.errors import DeviceError

ASK_PERIOD_S = 0.25
HELD_UP_S = 0.25


class RangeBoard:
    """One board on an open line; silence is a DeviceError, and an error never becomes a number."""

    def __init__(self, line: ByteLine, settings: UltrasonicSettings, clock: Callable[[], float]) -> None:
        self.frames = 0
        self.bad_lines = 0
        self._line = line
        self._settings = settings
        self._clock = clock
        self._parser = LineParser()
        self._asked = 0.0
        self._polled = 0.0
        self._frame_at = 0.0

    def open(self) -> None:
        """Ask the board to begin."""
        now = self._clock()
        self._frame_at = self._polled = now
        self._ask(now)

    def poll(self) -> list[Frame]:
        """Return the frames received since the last call; raise DeviceError if the board was silent for too long."""
        now = self._clock()
        if now - self._polled > HELD_UP_S:
            self._catch_up(now)
        self._polled = now
        found = self._parser.feed(self._line.read())
        frames = [item for item in found if isinstance(item, Frame)]
        self.bad_lines += sum(isinstance(item, BadLine) for item in found)
        self.frames += len(frames)
        if frames:
            self._frame_at = now
        elif not now - self._frame_at < self._allowed_s:
            raise DeviceError(self._silence(now))
        elif self.frames == 0 and now - self._asked >= ASK_PERIOD_S:
            self._ask(now)
        return frames

    def close(self) -> None:
        """Ask the board to stop, and close the line."""
        try:
            self._line.write(FINISH)
        except DeviceError:
            pass  # the line is gone: nothing to stop
        finally:
            self._line.close()

    @property
    def _allowed_s(self) -> float:
        return self._settings.timeout_s if self.frames else self._settings.start_timeout_s

    def _ask(self, now: float) -> None:
        """Send the start byte; a board that restarts when its line is opened misses the first one."""
        self._line.drop_output()
        self._line.write(START)
        self._asked = now

    def _catch_up(self, now: float) -> None:
        """Drop old input after a pause of this process, and wait for the next frame as long as usual."""
        self._line.drop_input()
        self._parser.lines.reset()
        self._frame_at = now

    def _silence(self, now: float) -> str:
        complaint = f"device '{self._settings.device}' is silent: no reading for {now - self._frame_at:.1f} s"
        heard = f", but {self.bad_lines} malformed lines" if self.bad_lines else ""
        return f"{complaint}{heard}; check its cable, power and the setting `board`"
