"""The ultrasonic ring as a capability: every good frame becomes a message at once; at rest, those that differ do."""

from math import inf

from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Context
from lbr.drivers.serial_line import open_line
from lbr.drivers.ultrasonic import UltrasonicSettings
from lbr.drivers.ultrasonic.controller import RangeBoard
from lbr.drivers.ultrasonic.protocol import near, to_ranges
from lbr.messages.motors import RESTS_S
from lbr.messages.sensing import Ranges, ranges

REPORT_PERIOD_S = 5.0
LOOKS_HZ = 100.0
BEFORE_SHARE, RESTING_SHARE, BEFORE_MOST_S, SLOWER = 0.8, 0.95, 0.1, 1.1
"""The driver polls again after this share of the usual period, which grows by the factor `SLOWER` at most."""
RESTS_AFTER_S, RESTING_S = 1.0, 0.45
"""After a second without a change, before a standing base that nobody holds, frames are published at long periods."""


class UltrasonicRing(Capability[UltrasonicSettings]):
    """Publishes the range board's measurements."""

    rate_hz = LOOKS_HZ
    woken_by_streams = False

    def __init__(self, ctx: Context[UltrasonicSettings]) -> None:
        super().__init__(ctx)
        self._board: RangeBoard | None = None
        self._bad_reported = 0
        self._reported_at = 0.0
        self._waited = self._rests = False
        self._frame_at = self._next = 0.0
        self._usual_s = 1 / LOOKS_HZ
        self._like: Ranges | None = None
        self._changed_s = self._published_s = -inf

    def open(self) -> None:
        """Open the line and start the board."""
        settings = self.ctx.settings
        self._board = RangeBoard(open_line(self.device_row, settings.baud), settings, self.ctx.clock)
        self._board.open()
        self._bad_reported = 0

    def step(self) -> None:
        """Publish the received frames."""
        board = self._board
        assert board is not None
        frames = board.poll()
        for frame in frames:
            self._publish(to_ranges(frame, self.ctx.settings))
        self._take_pace(has_frame=bool(frames))
        self._tell_state()
        self._tell_bad_lines(board)

    def answers(self) -> bool:
        """Return whether it has measured; an open line is not enough."""
        return self._board is not None and self._board.frames > 0

    def close(self) -> None:
        """Stop the board and close the line; what was reported seldom is not known any more."""
        board, self._board = self._board, None
        if self._rests and self._like is not None:
            self.ctx.publish("readings", ranges({}, dict.fromkeys(self._like.status, "missing")))
        self._like = None
        if board is not None:
            board.close()

    def _publish(self, read: Ranges) -> None:
        now, drive = self.ctx.clock(), self.ctx.latest("drive")
        base = drive.message if drive is not None and drive.age_s(now) <= RESTS_S else None
        stands = base is not None and base.holder is None and not base.moving
        if not (stands and self._like is not None and near(read, self._like, self.ctx.settings.still_cm)):
            self._like, self._changed_s = read, now
        rested, self._rests = self._rests, now - self._changed_s >= RESTS_AFTER_S
        if not (rested and self._rests) or now - self._published_s >= RESTING_S:
            self._published_s = now
            self.ctx.publish("readings", replace(read, rests=self._rests))

    def _take_pace(self, *, has_frame: bool) -> None:
        """Poll a hundred times a second once a frame is near, and rest before."""
        now = self.ctx.clock()
        if has_frame:
            self._usual_s, self._frame_at = min(now - self._frame_at, SLOWER * self._usual_s), now
            share = RESTING_SHARE if self._rests else BEFORE_SHARE
            self._next = now + min(share * self._usual_s, BEFORE_MOST_S)
        self.rate_hz = 1 / max(self._next - now, 1 / LOOKS_HZ)

    def _tell_state(self) -> None:
        """Publish readiness, or at the first opening what is missing; later openings keep the error until a frame
        comes."""
        if self.answers():
            self.ctx.ready()
        elif not self._waited:
            self.ctx.warn("waiting for the first reading", "not_ready")
        self._waited = True

    def _tell_bad_lines(self, board: RangeBoard) -> None:
        now = self.ctx.clock()
        if board.bad_lines > self._bad_reported and now - self._reported_at > REPORT_PERIOD_S:
            self._bad_reported, self._reported_at = board.bad_lines, now
            text = f"{board.bad_lines} lines from the range board were no readings"
            self.ctx.event("bad_lines", text, level="warning", data={"bad": board.bad_lines, "good": board.frames})
