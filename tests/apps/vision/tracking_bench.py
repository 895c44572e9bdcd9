"""A head with a camera, for tests of tracking: it turns with a delay, and its camera sees a ball at a direction."""

from collections import deque
from math import atan, cos, exp, hypot, radians, sin, tan

from lbr.apps.vision.direction import Angles
from lbr.messages.tracking import Seen

FIELD_RAD = radians(60.0)
RADIUS_RAD = radians(2.3)


class Head:
    """Two joints that follow their goal late, at a bounded speed; ticks of 5 ms."""

    TICK_S = 0.005

    def __init__(self, yaw=0.0, pitch=0.0, *, delay_s=0.05, lag_s=0.05, speed_rps=2.5, error_rad=0.0):
        self.now = 0.0
        self.error_rad = error_rad
        self.angles = Angles(yaw, pitch)
        self.goal = Angles(yaw, pitch)
        self._wanted = Angles(yaw, pitch)
        self._late = deque([self.goal] * (round(delay_s / self.TICK_S) + 1))
        self._share = 1.0 - exp(-self.TICK_S / lag_s)
        self._step = speed_rps * self.TICK_S

    def aim(self, angles):
        self._wanted = angles

    def tick(self):
        self.now += self.TICK_S
        self.goal = Angles(*(g + _bounded(w - g, self._step) for g, w in zip(self.goal, self._wanted, strict=True)))
        self._late.append(self.goal)
        late = self._late.popleft()
        moves = (self._share * (g + self.error_rad - a) for g, a in zip(late, self.angles, strict=True))
        self.angles = Angles(*(a + move for a, move in zip(self.angles, moves, strict=True)))


def _bounded(value, most):
    return min(max(value, -most), most)


def project(head, target, radius_rad=RADIUS_RAD, field_rad=FIELD_RAD, ratio=0.75):
    """Return what a camera at `head` sees of a ball in the direction of `target`; None if it is not in the picture."""
    yaw = target.yaw_rad - head.yaw_rad
    ray = (cos(target.pitch_rad) * cos(yaw), cos(target.pitch_rad) * sin(yaw), -sin(target.pitch_rad))
    ahead = cos(head.pitch_rad) * ray[0] - sin(head.pitch_rad) * ray[2]
    up = sin(head.pitch_rad) * ray[0] + cos(head.pitch_rad) * ray[2]
    if ahead <= 0.01:
        return None
    scale = 2.0 * tan(field_rad / 2.0)
    x, y = -ray[1] / ahead / scale, -up / ahead / scale
    if not (abs(x) <= 0.5 and abs(y) <= 0.5 * ratio):
        return None
    return Seen(x=x, y=y, radius=tan(radius_rad) / scale)


def away_rad(seen, field_rad=FIELD_RAD):
    return atan(hypot(seen.x, seen.y) * 2.0 * tan(field_rad / 2.0))
