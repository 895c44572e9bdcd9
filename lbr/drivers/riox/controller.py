"""The RIOX as a device: one query at a time, without ever waiting for an answer."""

import time
from collections.abc import Callable

from lbr.drivers.byte_line import ByteLine
from lbr.drivers.echoed_lines import Ack, Echo, Nak, Noise, Reply, ReplyParser, Value, query
from lbr.drivers.inertial import LifeSigns
from lbr.drivers.riox import RioxSettings
from lbr.drivers.riox.protocol import ECHOES, MOTION, ORIENTATION, counts_of, to_orientation, to_sample
from lbr.errors import DeviceError
from lbr.messages.imu import ImuSample
from lbr.messages.units import Quaternion

HELD_UP_S = 0.25
QUIET_S = 0.03
SPOILT_S = 0.015
"""The remaining wait for an answer after a bad line, which was that answer or its echo."""
MOST_REFUSALS = 3

Tell = Callable[[str, str], None]


class AhrsUnit:
    """One unit on an open line. A lost answer is an invalid sample, silence is a DeviceError.

    A sample is one answer to `ML`, dated by its query, with the orientation queried just before. `tell(kind, text)`
    publishes warnings; it may be called often.
    """

    def __init__(
        self,
        line: ByteLine,
        settings: RioxSettings,
        tell: Tell,
        signs: LifeSigns,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.bad_lines = 0
        self.measured = False
        self._line = line
        self._settings = settings
        self._tell = tell
        self._clock = clock
        self._parser = ReplyParser()
        self._signs = signs
        self._asked = ""
        self._echoed = False
        self._asked_at = self._deadline = self._next = self._quiet_until = 0.0
        self._polled = self._answered_at = 0.0
        self._oriented = settings.orientation
        self._refusals = 0
        self._orientation: Quaternion | None = None

    def open(self) -> None:
        """Begin with an idle line, after the answers to earlier queries."""
        now = self._clock()
        self._polled = self._answered_at = now
        self._forget(now)

    def poll(self) -> list[ImuSample]:
        """Read the answers, send the next query; raise DeviceError if nothing usable came for too long."""
        now = self._clock()
        if now - self._polled > HELD_UP_S:
            self._answered_at = now  # the silence was this process's own
        self._polled = now
        data = self._line.read()
        samples: list[ImuSample] = []
        if now < self._quiet_until:
            return samples
        for reply in self._parser.feed(data):
            sample = self._take(reply)
            if sample is not None:
                samples.append(sample)
        if any(sample.valid for sample in samples):
            self._answered_at, self.measured = now, True
        elif not now - self._answered_at < self._settings.timeout_s:
            raise DeviceError(self._silence(now))
        if self._asked and not now < self._deadline:
            samples.append(self._lose(now))
        if not self._asked and now >= self._quiet_until and now >= self._next:
            self._begin(now)
        return samples

    def close(self) -> None:
        """Close the line."""
        self._line.close()

    def _begin(self, now: float) -> None:
        """Start the next sample; a late one does not hurry those after it."""
        period = 1.0 / self._settings.rate_hz
        self._next = max(self._next + period, now + period / 2.0)
        self._orientation = None
        self._ask(ORIENTATION if self._oriented else MOTION)

    def _ask(self, name: str) -> None:
        self._asked, self._asked_at, self._echoed = name, self._clock(), False
        self._deadline = self._asked_at + self._settings.answer_s
        self._line.write(query(name))  # a query that did not fit gets no answer

    def _take(self, reply: Reply) -> ImuSample | None:
        match reply:
            case Value(name) if (counts := counts_of(reply)) is not None:
                if name == self._asked and self._counts:  # otherwise the answer to a query that was given up
                    return self._answered(name, counts)
            case Echo(command) if command in ECHOES:
                self._echoed = self._echoed or ECHOES[command] == self._asked
            case Nak():
                if self._asked and self._counts:
                    return self._refused()
            case Noise(text) | Value(_, text):
                self._spoilt(text)
            case Echo(command):
                self._spoilt(command.decode("ascii"))
            case Ack():
                self._spoilt("+")
        return None

    def _spoilt(self, line: str) -> None:
        self.bad_lines += 1
        self._deadline = min(self._deadline, self._polled + SPOILT_S)
        complaint = f"{self.bad_lines} lines from the inertial unit were no answers"
        self._tell("bad_lines", f"{complaint}; the last began with '{line[:40]}'")

    @property
    def _counts(self) -> bool:
        return self._echoed or not self._settings.echo

    def _answered(self, name: str, counts: tuple[int, ...]) -> ImuSample | None:
        asked_at, self._asked = self._asked_at, ""
        if name == ORIENTATION:
            self._refusals = 0
            self._orient(counts)
            self._ask(MOTION)
            return None
        missing = self._signs.missing(counts[:7])
        if missing:
            return self._invalid(asked_at, missing)
        sample = to_sample(counts, self._orientation, asked_at, self._settings)
        if sample.accel_mps2 is None or sample.gyro_rps is None:
            self._tell("out_of_range", "what the inertial unit measures is beyond its range")
        return sample

    def _orient(self, counts: tuple[int, ...]) -> None:
        self._orientation = to_orientation(counts, self._settings.quaternion_divisor)
        if self._orientation is None:
            numbers = ":".join(map(str, counts))
            self._tell("orientation", f"{numbers} is not an orientation; is the setting quaternion_divisor right?")

    def _refused(self) -> ImuSample | None:
        asked, self._asked = self._asked, ""
        if asked == MOTION:
            return self._invalid(self._asked_at, f"the unit refuses ?{asked}; is it a RIOX-1216AHRS?")
        self._refusals += 1
        if self._refusals >= MOST_REFUSALS:
            self._oriented = False
            self._tell("orientation", f"the unit refuses ?{asked} and is not asked for it any more")
        self._ask(MOTION)
        return None

    def _lose(self, now: float) -> ImuSample:
        """Give up the answer, and first wait for a quiet line: a late answer looks like the next one."""
        lost, at = self._asked, self._asked_at
        self._forget(now)
        if not self.measured:
            return ImuSample(valid=False, time_s=at, reason=self._silence(now))
        return self._invalid(at, f"no answer to ?{lost} within {now - at:.2f} s")

    def _forget(self, now: float) -> None:
        self._asked = ""
        self._quiet_until = now + QUIET_S
        self._line.drop_output()
        self._line.drop_input()
        self._parser.reset()

    def _invalid(self, at: float, reason: str) -> ImuSample:
        complaint = f"device '{self._settings.device}': {reason}"
        self._tell("unusable", complaint)
        return ImuSample(valid=False, time_s=at, reason=complaint)

    def _silence(self, now: float) -> str:
        complaint = f"device '{self._settings.device}': nothing usable for {now - self._answered_at:.1f} s"
        heard = f", but {self.bad_lines} lines that are not answers" if self.bad_lines else ""
        return f"{complaint}{heard}; check its cable, power and the setting `baud`"
