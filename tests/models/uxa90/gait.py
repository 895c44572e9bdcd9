"""Steps of the UXA-90: the hips sway over the foot that stands, the other is lifted and set down elsewhere."""

from dataclasses import dataclass
from math import cos, pi, sin

from lbr.robots.uxa90.twin.firmware import Frame
from tests.models.uxa90.posture import (
    ARMS,
    BASIC,
    HEIGHT_M,
    HIP_M,
    LEAN_RAD,
    SIDES,
    WEIGHT_M,
    Pose,
    frame,
    hips_ahead_m,
    leg,
)

Place = tuple[float, float, float]
"""Ahead, to the left, turned left; of where the robot began."""

Step = tuple[str, Place]
"""A foot, and where it is set down."""

_LIFT_M, _DOUBLE = 0.03, 0.12
"""How high a foot is lifted, and which share of a step both feet stand before and after."""

_SWING = 1.5
"""How far an arm swings, in radians for each metre that its foot is behind the other."""

_FRAME_S = 0.05


@dataclass(frozen=True, slots=True)
class Gait:
    """Steps of `step_s`; the rest of `total_s` is for `begin_s`, the walking stance, and for swaying in and out."""

    steps: tuple[Step, ...]
    total_s: float
    step_s: float
    begin_s: float = 0.3
    sway_m: float = 0.03

    @property
    def edge_s(self) -> float:
        """How long swaying in takes, and swaying out."""
        return (self.total_s - self.begin_s - len(self.steps) * self.step_s) / 2

    def frames(self) -> tuple[Frame, ...]:
        """Return the key frames; they end in the walking stance."""
        swaying_s = self.total_s - self.begin_s
        count = round(swaying_s / _FRAME_S)
        out = [frame(self._at(0.0), self.begin_s, smooth=False)]
        for number in range(1, count + 1):
            time_s = number * swaying_s / count
            share = _gentle((time_s - swaying_s + self.edge_s) / self.edge_s)
            pose = {name: angle + (BASIC[name] - angle) * share for name, angle in self._at(time_s).items()}
            out.append(frame(pose, swaying_s / count, smooth=False))
        return tuple(out)

    def _at(self, time_s: float) -> Pose:
        number = int((time_s - self.edge_s) // self.step_s)
        if number < 0:
            return self._standing(0, self._eased(time_s / self.edge_s, leaves=False))
        if number >= len(self.steps):
            share = (time_s - self.edge_s) / self.step_s - len(self.steps)
            return self._standing(len(self.steps), self._eased(share * self.step_s / self.edge_s, leaves=True))
        share = (time_s - self.edge_s) / self.step_s - number
        swung = min(1.0, max(0.0, (share - _DOUBLE) / (1 - 2 * _DOUBLE)))
        side, _ = self.steps[number]
        before, after = self._feet(number), self._feet(number + 1)
        feet = {foot: _between(before[foot], after[foot], _gentle(swung)) for foot in before}
        hips = _between(_middle(before), _middle(after), _gentle(share))
        return self._pose(
            feet, hips, self._sense(number) * self.sway_m * sin(pi * share), {side: _LIFT_M * sin(pi * swung) ** 2}
        )

    def _standing(self, done: int, sway_m: float) -> Pose:
        feet = self._feet(done)
        return self._pose(feet, _middle(feet), sway_m, {})

    def _eased(self, share: float, *, leaves: bool) -> float:
        """Return the sway from rest into the first step, or out of the last to rest, with the speed that a step has."""
        pace_m = self.sway_m * pi / self.step_s * self.edge_s
        if leaves:
            return -self._sense(len(self.steps) - 1) * pace_m * (share**3 - 2 * share**2 + share)
        return self._sense(0) * pace_m * (share**3 - share**2)

    def _sense(self, number: int) -> int:
        """Return where the hips sway in a step: to the left if the right foot is lifted."""
        return -1 if self.steps[number][0] == "left" else 1

    def _feet(self, done: int) -> dict[str, Place]:
        return {"left": (0.0, HIP_M, 0.0), "right": (0.0, -HIP_M, 0.0), **dict(self.steps[:done])}

    def _pose(self, feet: dict[str, Place], hips: Place, sway_m: float, lifted: dict[str, float]) -> Pose:
        x, y, yaw = hips[0] - sin(hips[2]) * sway_m, hips[1] + cos(hips[2]) * sway_m, hips[2]
        ahead_m = hips_ahead_m(HEIGHT_M, LEAN_RAD, WEIGHT_M)
        apart_m = feet["left"][0] - feet["right"][0]
        pose = dict(ARMS)
        for side, sense in SIDES:
            dx, dy = feet[side][0] - x, feet[side][1] - y
            along, aside = dx * cos(yaw) + dy * sin(yaw), dy * cos(yaw) - dx * sin(yaw)
            ankle = (along - ahead_m, sense * aside - HIP_M, lifted.get(side, 0.0) - HEIGHT_M)
            pose |= leg(side, ankle, LEAN_RAD, sense * (feet[side][2] - yaw))
            pose[f"{side}_shoulder_pitch"] -= sense * _SWING * apart_m
        return pose


def ahead(count: int, step_m: float) -> tuple[Step, ...]:
    """Return steps ahead, the last one beside the one before."""
    sides = [("left", HIP_M), ("right", -HIP_M)] * count
    places = [*(step_m * number for number in range(1, count)), step_m * (count - 1)]
    return tuple((side, (x, y, 0.0)) for (side, y), x in zip(sides, places, strict=False))


def turned(angle_rad: float, wider_m: float) -> tuple[Step, ...]:
    """Return a step to one side that turns, left positive, and one of the other foot that follows."""
    sense = 1 if angle_rad > 0 else -1
    first, second = ("left", "right") if angle_rad > 0 else ("right", "left")
    y = sense * (HIP_M + wider_m)
    follows = (sense * 2 * HIP_M * sin(angle_rad), y - sense * 2 * HIP_M * cos(angle_rad), angle_rad)
    return (first, (0.0, y, angle_rad)), (second, follows)


def aside(step_m: float) -> tuple[Step, ...]:
    """Return a step to one side, left positive, and one of the other foot that follows."""
    first, second = (("left", HIP_M), ("right", -HIP_M))[:: 1 if step_m > 0 else -1]
    return (first[0], (0.0, first[1] + step_m, 0.0)), (second[0], (0.0, second[1] + step_m, 0.0))


def _gentle(share: float) -> float:
    return (1 - cos(pi * min(1.0, max(0.0, share)))) / 2


def _between(a: Place, b: Place, share: float) -> Place:
    x, y, yaw = (p + (q - p) * share for p, q in zip(a, b, strict=True))
    return x, y, yaw


def _middle(feet: dict[str, Place]) -> Place:
    return _between(feet["left"], feet["right"], 0.5)
