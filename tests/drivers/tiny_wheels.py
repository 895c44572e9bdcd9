"""Drivers of wheels as packages outside lbr would bring them: a controller that takes `P LEFT RIGHT`, and says `ok`.

Another one of the same make has four motors, and may tell what their encoders count before it: `C A B C D ok`.
"""

import re
from math import inf, isfinite

from lbr.drivers.serial_line import open_line
from lbr.drivers.wheels import WheelsSettings, wheels_kind
from lbr.drivers.wheels.capability import Wheels
from lbr.drivers.wheels.contract import GuardStop, Measured
from lbr.errors import DeviceError

STOP, STOP_FOUR = b"P 0 0\r", b"P 0 0 0 0\r"
FOUR = ("front_left", "front_right", "rear_left", "rear_right")
ANSWER_S = 0.02
COUNTS = re.compile(rb"C((?: -?[0-9]+)+) ok\r")


class TinySettings(WheelsSettings, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a row may set."""

    baud: int = 115200


class TinyController:
    """The controller on its line."""

    def __init__(self, line, clock, beat, stop=STOP):
        self.lost = self.refused = 0
        self._rest = (0.0,) * stop.count(b"0")
        self._counts = tuple(range(len(self._rest)))
        self.applied = self.asked = self._rest
        self.resting = self.turning = False
        self.guard_stop = GuardStop(stop, b"ok\r")
        self.faults, self.grave = (), ()
        self._line, self._clock, self._beat = line, clock, beat
        self._fed = -inf

    def open(self):
        if not any(self.stop() for _ in range(5)):
            raise DeviceError("the tiny controller does not answer; check its cable")

    def close(self):
        stopped = self.stop()
        self._line.close()
        return stopped

    def fileno(self):
        return self._line.fileno()

    def drive(self, *powers):
        powers = powers if all(map(isfinite, powers)) else self._rest
        self.turning = self.turning or powers != self._rest
        if self._say(powers):
            self.turning = powers != self._rest

    def stop(self):
        if not self._say(self._rest):
            return False
        self.resting, self.turning = True, False
        return True

    emergency_stop = release = stop

    def poll(self):
        pass

    @property
    def fed_s_ago(self):
        return self._clock() - self._fed

    def faults_after(self, when):
        return None

    def measured(self):
        if len(self._rest) == 2:
            return Measured(voltage_v=12.0)
        return Measured(voltage_v=12.0, motor_counts=self._counts)

    def _say(self, powers):
        self.asked, self.resting, self._fed = powers, False, self._clock()
        self._beat()
        self._line.write(b"P %s\r" % b" ".join(b"%d" % round(power * 1000) for power in powers))
        answer = self._line.read(ANSWER_S)
        if told := COUNTS.search(answer):
            self._counts = tuple(int(count) for count in told[1].split())
        if b"ok\r" not in answer:
            self.lost += 1
            return False
        self.applied = powers
        return True


class Tiny(Wheels[TinySettings]):
    """Two wheels on a tiny controller."""

    def connect(self, device, beat):
        return TinyController(open_line(device, self.ctx.settings.baud), self.ctx.clock, beat)


class Quad(Wheels[TinySettings]):
    """Four wheels on a controller of four motors."""

    motors = FOUR

    def connect(self, device, beat):
        return TinyController(open_line(device, self.ctx.settings.baud), self.ctx.clock, beat, STOP_FOUR)


QUAD = wheels_kind("quad", "a motor controller of four", Quad, TinySettings)
KIND = wheels_kind("tiny", "a tiny motor controller", Tiny, TinySettings)
