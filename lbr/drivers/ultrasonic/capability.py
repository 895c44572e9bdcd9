"""The ultrasonic ring as a capability: every good frame becomes a message at once; no frame, no message."""

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.serial_line import open_line
from lbr.drivers.ultrasonic import UltrasonicSettings
from lbr.drivers.ultrasonic.controller import RangeBoard
from lbr.drivers.ultrasonic.protocol import to_ranges
from lbr.errors import DeviceError

REPORT_PERIOD_S = 5.0
LOOKS_HZ = 100.0
BEFORE_SHARE, BEFORE_MOST_S, SLOWER = 0.8, 0.1, 1.1
"""The driver looks again after this share of the usual period. The usual period grows by this factor at most."""


class UltrasonicRing(Capability[UltrasonicSettings]):
    """Publishes what the range board measures."""

    rate_hz = LOOKS_HZ

    def __init__(self, ctx: Context[UltrasonicSettings]) -> None:
        super().__init__(ctx)
        self._board: RangeBoard | None = None
        self._bad_told = 0
        self._told = 0.0
        self._waited = False
        self._came = self._next = 0.0
        self._usual_s = 1 / LOOKS_HZ

    def open(self) -> None:
        """Open the line and start the board."""
        settings = self.ctx.settings
        if self.ctx.device is None:
            raise DeviceError(f"'{self.ctx.name}' has no device row '{settings.device}'; add it")
        self._board = RangeBoard(open_line(self.ctx.device, settings.baud), settings, self.ctx.clock)
        self._board.open()
        self._bad_told = 0

    def step(self) -> None:
        """Publish what has come in."""
        board = self._board
        assert board is not None
        frames = board.poll()
        for frame in frames:
            self.ctx.publish("readings", to_ranges(frame, self.ctx.settings))
        self._take_pace(came=bool(frames))
        self._tell_state()
        self._tell_bad_lines(board)

    def answers(self) -> bool:
        """Opening the line is not enough: ready is who has measured."""
        return self._board is not None and self._board.frames > 0

    def close(self) -> None:
        """Stop the board and close the line."""
        board, self._board = self._board, None
        if board is not None:
            board.close()

    def _take_pace(self, *, came: bool) -> None:
        """Look a hundred times a second once a frame is near, and rest before."""
        now = self.ctx.clock()
        if came:
            self._usual_s, self._came = min(now - self._came, SLOWER * self._usual_s), now
            self._next = now + min(BEFORE_SHARE * self._usual_s, BEFORE_MOST_S)
        self.rate_hz = 1 / max(self._next - now, 1 / LOOKS_HZ)

    def _tell_state(self) -> None:
        """Say at the first opening what is waited for; later ones leave said what was wrong until it is over."""
        if self.answers():
            self.ctx.ready()
        elif not self._waited:
            self.ctx.warn("waiting for the first reading", "not_ready")
        self._waited = True

    def _tell_bad_lines(self, board: RangeBoard) -> None:
        now = self.ctx.clock()
        if board.bad_lines > self._bad_told and now - self._told > REPORT_PERIOD_S:
            self._bad_told, self._told = board.bad_lines, now
            text = f"{board.bad_lines} lines from the range board were no readings"
            self.ctx.event("bad_lines", text, level="warning", data={"bad": board.bad_lines, "good": board.frames})
