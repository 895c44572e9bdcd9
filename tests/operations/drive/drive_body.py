"""A base of simple physics below a drive kernel: it follows its wheels late, and tells how it turns and how far it goes."""

from collections import deque

from lbr.operations.drive.state import Tick
from tests.operations.drive.drive_bench import Bench

TICK_S = 0.02
FULL_DPS, FULL_MPS = 400.0, 1.0


class Body(Bench):
    """A bench whose wheels move a body: late by `late` ticks, and with a mass that takes `lazy` of each speed along."""

    def __init__(self, *, late=2, lazy=0.6, offset_deg=0.0, **settings):
        super().__init__(**settings)
        self.turned_deg = 1000.0
        self.offset_deg = offset_deg
        self.rate_dps = self.speed_mps = self.way_m = 0.0
        self.gain = self.side = 1.0
        self.attitude_speaks = self.odometry_speaks = True
        self.attitude, self.odometry = {}, {}
        self.farthest_deg = 0.0
        self._lazy = lazy
        self._wheels = deque([(0.0, 0.0)] * (late + 1), maxlen=late + 1)
        self.tell()

    def tell(self):
        if self.attitude_speaks:
            heading_deg = (self.turned_deg + self.offset_deg) % 360.0
            self.look(**{"turned_deg": self.turned_deg, "heading_deg": heading_deg} | self.attitude)
        if self.odometry_speaks:
            self.count(**{"distance_m": self.way_m, "speed_mps": self.speed_mps} | self.odometry)

    def step(self):
        """Let one tick pass."""
        self.now = round(self.now + TICK_S, 6)
        left, right = self._wheels[0]
        self._wheels.append((self.state.left, self.state.right))
        wanted_dps = (left - right) / 2 * FULL_DPS * self.gain * self.side
        wanted_mps = (left + right) / 2 * FULL_MPS * self.gain * self.side
        self.rate_dps = wanted_dps + (self.rate_dps - wanted_dps) * self._lazy
        self.speed_mps = wanted_mps + (self.speed_mps - wanted_mps) * self._lazy
        self.turned_deg += self.rate_dps * TICK_S
        self.way_m += self.speed_mps * TICK_S
        self.farthest_deg = max(self.farthest_deg, abs(self.turned_deg - 1000.0))
        self.tell()
        self.event(Tick())

    def until_over(self, reply, again, most_s=30.0):
        """Renew what was accepted at 10 Hz until it ends; return its result."""
        assert reply.accepted, reply.reason
        for count in range(round(most_s / TICK_S)):
            if count % 5 == 0:
                self.sense()
                again(reply.lease)
            if self.results and self.results[-1].goal == reply.goal:
                return self.results[-1]
            self.step()
        raise AssertionError(f"not over within {most_s} s")

    def turned(self, angle_deg, **more):
        """Turn, and return the result."""
        return self.until_over(self.turn(angle_deg, **more), lambda lease: self.turn(angle_deg, lease=lease))

    def headed(self, heading_deg):
        """Turn to a heading, and return the result."""
        return self.until_over(self.head(heading_deg), lambda lease: self.head(heading_deg, lease=lease))

    def driven(self, power, angle_deg, distance_cm, **more):
        """Drive a distance, and return the result."""
        command = {"power": power, "angle_deg": angle_deg, "distance_cm": distance_cm, **more}
        return self.until_over(self.drive(**command), lambda lease: self.drive(**command, lease=lease))
