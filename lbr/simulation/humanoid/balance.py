"""The test of a motion's balance: played without devices, as fast as the machine can, and watched."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import ceil, cos, hypot, radians, sin
from typing import Any

import numpy as np
from msgspec.structs import replace

from lbr.messages.joints import Joint
from lbr.messages.motion_work import BalanceReport, BalanceSample, Millimetres
from lbr.simulation.humanoid.body import FLOOR, heading_rad
from lbr.simulation.humanoid.engine import HumanoidEngine
from lbr.simulation.humanoid.servos import Floats, Servo, servo
from lbr.simulation.humanoid.settings import HumanoidWorldSettings
from lbr.simulation.measured import ServoDrive
from lbr.simulation.physics import mujoco

FALLEN_RAD = radians(50.0)
"""A humanoid that leans further than this from its stance cannot recover."""
GOAL_S = 0.02
"""The interval of goals for a servo, as in the joints operation."""
SAMPLE_S, MOST_SAMPLES = 0.04, 600
CALM_S, LONGEST_CALM_S = 0.6, 3.0
"""The time to come to rest before the motion: at least, and at most."""
CALM_RPS = 0.03
AFTER_S = 1.5
"""For so long, a motion is watched after its end: a body that tips over does so within it."""
AFTER_FALL_S = 0.8
TELL_S = 0.2

Goals = Callable[[float], Mapping[str, float]]
Point = tuple[float, float]


class Balance:
    """One motion, played on a free body: `goals` returns the angles of joints at a time, `frame` the key frame.

    `play` yields the progress, 0 to 1; after it, `report` has the result.
    """

    def __init__(
        self,
        settings: HumanoidWorldSettings,
        joints: Sequence[Joint],
        home: str,
        *,
        goals: Goals,
        duration_s: float,
        frame: Callable[[float], int],
    ) -> None:
        alone = replace(settings, stand=False, rests={}, balls={}, mounted={})
        self._engine = HumanoidEngine(alone, joints, home)
        self._model, self._data = self._engine.body.model, self._engine.data
        self._joints = {joint.name: joint for joint in joints}
        self._goals, self._duration_s, self._frame = goals, duration_s, frame
        self._every_s = max(SAMPLE_S, duration_s / MOST_SAMPLES)
        self._floor = self._model.geom(FLOOR).id
        self._trace: list[BalanceSample] = []
        self._origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
        self._fell: BalanceSample | None = None
        self.report = BalanceReport(stands=False, begins=False, duration_s=duration_s, body=settings.model)

    def play(self) -> Iterator[float]:
        """Stand up in the first pose; if it stands there, play the motion, and watch the result."""
        if not self._begin():
            return
        self._origin = self._place()
        end_s = self._duration_s + AFTER_S
        begun_s, sampled_s, told_s = self._engine.time_s, -1.0, 0.0
        while (t := self._engine.time_s - begun_s) < end_s:
            self._go(self._goals(min(t, self._duration_s)))
            if t - sampled_s >= self._every_s - 1e-6:
                sampled_s = t
                self._watch(t)
            if self._fell is not None and t - self._fell.t_s > AFTER_FALL_S:
                break
            if t - told_s >= TELL_S:
                told_s = t
                yield min(0.99, t / end_s)
        self.report = self._judged()

    def _begin(self) -> bool:
        """Put it on the floor in its first pose, and let it come to rest; return whether it stands by itself.

        It is unknown on which sole, or how upright, a pose stands: each is tried.
        """
        first = self._goals(0.0)
        angles = [first.get(name, 0.0) for name in self._joints]
        for foot in ("", *self._engine.body.feet, ""):
            self._engine.put(angles, foot)
            self._settle(first)
            place = tuple(map(float, self._data.subtree_com[self._engine.body.trunk][:2]))
            corners = hull([(float(x), float(y)) for x, y in self._touching()])
            if corners and self._lean()[0] < FALLEN_RAD and margin((place[0], place[1]), corners) > 0.0:
                return True
        return False

    def _settle(self, pose: Mapping[str, float]) -> None:
        for step in range(ceil(LONGEST_CALM_S / GOAL_S)):
            self._go(pose)
            if step * GOAL_S > CALM_S and float(np.abs(self._data.qvel[:6]).max()) < CALM_RPS:
                break

    def _go(self, goals: Mapping[str, float]) -> None:
        self._engine.step(self._drives(goals), GOAL_S)

    def _drives(self, goals: Mapping[str, float]) -> dict[Servo, ServoDrive]:
        return {
            servo(joint.bus, joint.device_id): ServoDrive(
                goal_rad=joint.zero_rad + joint.sign * goals.get(name, 0.0), torque=1.0
            )
            for name, joint in self._joints.items()
        }

    def _place(self) -> tuple[float, float, float]:
        """Return its place on the floor, and its heading."""
        corners = self._touching()
        at = np.mean(corners, axis=0) if corners else self._data.qpos[:2]
        return float(at[0]), float(at[1]), heading_rad(self._data.xmat[self._engine.body.trunk])

    def _watch(self, t: float) -> None:
        tilt, roll, pitch = self._lean()
        mass = self._seen(self._data.subtree_com[self._engine.body.trunk][:2])
        corners = hull([self._seen(point) for point in self._touching()])
        pressed = self._pressure()
        sample = BalanceSample(
            t_s=round(t, 3),
            frame=self._frame(min(t, self._duration_s)),
            tilt_rad=round(tilt, 3),
            roll_rad=round(roll, 3),
            pitch_rad=round(pitch, 3),
            mass=_mm(mass),
            pressure=None if pressed is None else _mm(self._seen(pressed)),
            support=tuple(_mm(point) for point in corners),
            margin_mm=None if not corners else round(1000 * margin(mass, corners)),
        )
        self._trace.append(sample)
        if self._fell is None and tilt > FALLEN_RAD:
            self._fell = sample

    def _lean(self) -> tuple[float, float, float]:
        """Return the lean of the trunk, its roll and its pitch."""
        pose = self._engine.pose()
        upright = max(-1.0, min(1.0, float(self._data.xmat[self._engine.body.trunk][8])))
        return float(np.arccos(upright)), pose.roll_rad, pose.pitch_rad

    def _seen(self, point: Any) -> Point:
        """Return a point of the floor relative to the first stance."""
        x, y, yaw = self._origin
        ahead, left = float(point[0]) - x, float(point[1]) - y
        return ahead * cos(yaw) + left * sin(yaw), left * cos(yaw) - ahead * sin(yaw)

    def _contacts(self) -> Iterator[int]:
        contacts = self._data.contact
        for at in range(self._data.ncon):
            if self._floor in contacts.geom[at]:
                yield at

    def _touching(self) -> list[Floats]:
        return [self._data.contact.pos[at][:2].copy() for at in self._contacts()]

    def _pressure(self) -> Floats | None:
        """Return the centre of pressure on the floor; None without contact."""
        whole, middle, force = 0.0, np.zeros(2), np.zeros(6)
        for at in self._contacts():
            mujoco.mj_contactForce(self._model, self._data, at, force)
            middle += force[0] * self._data.contact.pos[at][:2]
            whole += float(force[0])
        return middle / whole if whole > 1e-6 else None

    def _judged(self) -> BalanceReport:
        standing = [one for one in self._trace if one.margin_mm is not None and not _after(one, self._fell)]
        least = min(standing, key=lambda one: one.margin_mm or 0, default=None)
        fell = self._fell
        return BalanceReport(
            stands=fell is None,
            begins=True,
            duration_s=round(self._duration_s, 2),
            least_mm=least.margin_mm if least is not None else None,
            least_s=least.t_s if least is not None else None,
            falls_s=fell.t_s if fell is not None else None,
            falls_frame=fell.frame if fell is not None else None,
            body=self._engine.settings.model,
            trace=tuple(self._trace),
        )


def hull(points: Sequence[Point]) -> list[Point]:
    """Return the corners of the convex outline of points, anticlockwise."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    return _half(ordered)[:-1] + _half(ordered[::-1])[:-1]


def margin(point: Point, corners: Sequence[Point]) -> float:
    """Return the distance of a point inside a convex outline, negative outside."""
    if len(corners) == 1:
        return -hypot(point[0] - corners[0][0], point[1] - corners[0][1])
    edges = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    nearest = min(_distance(point, *edge) for edge in edges)
    inside = len(corners) > 2 and all(_turn(a, b, point) >= 0.0 for a, b in edges)
    return nearest if inside else -nearest


def _half(points: Sequence[Point]) -> list[Point]:
    corners: list[Point] = []
    for point in points:
        while len(corners) > 1 and _turn(corners[-2], corners[-1], point) <= 0.0:
            corners.pop()
        corners.append(point)
    return corners


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _distance(point: Point, a: Point, b: Point) -> float:
    along, across = b[0] - a[0], b[1] - a[1]
    length = along * along + across * across
    share = 0.0 if length == 0.0 else ((point[0] - a[0]) * along + (point[1] - a[1]) * across) / length
    share = max(0.0, min(1.0, share))
    return hypot(point[0] - a[0] - share * along, point[1] - a[1] - share * across)


def _mm(point: Point) -> Millimetres:
    return round(1000 * point[0]), round(1000 * point[1])


def _after(one: BalanceSample, fell: BalanceSample | None) -> bool:
    return fell is not None and one.t_s > fell.t_s
