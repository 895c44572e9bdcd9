"""The main board's inertial unit: three accelerations, read between servos. Settings say what its bytes mean."""

from math import inf

from msgspec import Struct

from lbr.drivers.inertial import STANDARD_GRAVITY_MPS2, scaled
from lbr.messages.imu import ImuSample
from lbr.robots.uxa90.driver import ImuSettings, frames
from lbr.robots.uxa90.driver.bus import Bus
from lbr.robots.uxa90.driver.frames import Frame

ANSWER_S = 0.15
MISSES = 5
AGAIN_S = 10.0
"""The period of questions after `MISSES` lost ones in a row: each lost question costs readings of servos."""
NOT_ASKED_S = 1.0
NOT_ASKED = "the main board is not asked about its attitude (setting `imu` of its row)"
SILENT = "the main board does not say how it lies"
UNMEASURED = "the main board's inertial unit is at the end of its range, or measures nothing"


class _Asked(Struct):
    at: float = -inf
    waiting: bool = False
    misses: int = 0


class InertialUnit:
    """Asks by `turn`, in the line's thread; the loop calls `hear` and `missed`."""

    def __init__(self, settings: ImuSettings, *, simulated: bool) -> None:
        self.asked = settings.asked == "always" or (settings.asked == "simulated" and simulated)
        self._settings = settings
        self._unit_mps2 = settings.gravity_sign * STANDARD_GRAVITY_MPS2 / settings.lsb_per_g
        self._question = _Asked()
        self._reported_misses = 0
        self._published_at = -inf

    def turn(self, bus: Bus, now: float) -> float:
        """Send the question if it is due and disturbs nobody; return the seconds until it is due."""
        question = self._question
        if question.waiting and now - question.at > ANSWER_S:
            question.waiting, question.misses = False, question.misses + 1
        period_s = 1.0 / self._settings.hz if question.misses < MISSES else AGAIN_S
        left_s = question.at + period_s - now
        if not question.waiting and left_s <= 0.0 and bus.quiet() and not bus.doubtful:
            question.at, question.waiting = now, True
            bus.say(frames.ask("imu"))
            left_s = period_s
        return max(0.001, left_s)

    def hear(self, frame: Frame, now: float) -> ImuSample | None:
        """Return the measurement in a frame, if it answers this question."""
        if frame.type != frames.IMU or not self.asked or len(frame.contents) != frames.QUESTIONS["imu"][1]:
            return None
        self._question.waiting, self._question.misses = False, 0
        x, y, z = (
            int.from_bytes(frame.contents[at : at + 2], self._settings.order, signed=True) for at in range(0, 6, 2)
        )
        accel = scaled((x, y, z), self._unit_mps2)
        if accel is None or not (x or y or z) or (x, y, z) == (-1, -1, -1):
            return ImuSample(valid=False, time_s=now, reason=UNMEASURED)
        return ImuSample(valid=True, time_s=now, accel_mps2=accel)

    def missed(self, now: float) -> ImuSample | None:
        """Return an invalid sample, once for each lost question, or now and then if there are no questions."""
        if not self.asked:
            due = now - self._published_at >= NOT_ASKED_S
            self._published_at = now if due else self._published_at
            return ImuSample(valid=False, time_s=now, reason=NOT_ASKED) if due else None
        misses = self._question.misses
        reported, self._reported_misses = self._reported_misses, misses
        return ImuSample(valid=False, time_s=now, reason=SILENT) if misses > reported else None
