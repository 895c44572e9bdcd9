"""The values learnt of joints that a hand moves: pure."""

from collections.abc import Iterable, Mapping, Sequence
from math import degrees, pi
from typing import NamedTuple

from msgspec.structs import replace

from lbr.errors import InputError
from lbr.messages.joints import Joint, MotionStep
from lbr_so101.calibration import CalibrationSettings, Swept


class Way(NamedTuple):
    """Servo angles of one joint: at 0, the least, the greatest, the last; and the sign of its first direction."""

    zero: float
    least: float
    most: float
    last: float
    sign: int = 0


Sweep = Mapping[int, Way]


def begin(places: Mapping[int, float]) -> Sweep:
    """Return the sweep of servos that are held at 0."""
    return {servo: Way(at, at, at, at) for servo, at in places.items()}


def moved(sweep: Sweep, places: Mapping[int, float], enough_rad: float) -> Sweep:
    """Return the sweep after another look; raise InputError if a servo crossed the seam of its turn."""
    found = dict(sweep)
    for servo, at in places.items():
        way = sweep.get(servo)
        if way is None:
            continue
        if abs(at - way.last) > pi:
            raise InputError(
                f"servo {servo} went over the seam of its turn, from {way.last:.2f} to {at:.2f} rad: turn its horn, so "
                "that the middle of the joint is near the middle of the servo, and begin again"
            )
        off = at - way.zero
        sign = way.sign or (0 if abs(off) < enough_rad else 1 if off > 0.0 else -1)
        found[servo] = Way(way.zero, min(way.least, at), max(way.most, at), at, sign)
    return found


def swept(joint: Joint, way: Way, settings: CalibrationSettings) -> Swept:
    """Return the range that a joint was moved."""
    sign = way.sign or joint.sign
    lower, upper = sorted((sign * (way.least - way.zero), sign * (way.most - way.zero)))
    enough = way.sign != 0 and upper - lower > 2.0 * settings.margin_rad + settings.enough_rad
    return Swept(lower_rad=round(lower, 4), upper_rad=round(upper, 4), enough=enough)


def learnt(joints: Iterable[Joint], sweep: Sweep, settings: CalibrationSettings) -> tuple[Joint, ...]:
    """Return the new rows; a joint that was hardly moved only gets its zero."""
    found = []
    for joint in joints:
        way = sweep[joint.device_id]
        row, seen = replace(joint, zero_rad=round(way.zero, 4)), swept(joint, way, settings)
        if seen.enough:
            lower, upper = seen.lower_rad + settings.margin_rad, seen.upper_rad - settings.margin_rad
            row = replace(row, sign=way.sign, lower_rad=round(lower, 4), upper_rad=round(upper, 4))
        found.append(row)
    return tuple(found)


def beyond(joints: Iterable[Joint], steps: Sequence[MotionStep]) -> str:
    """Return the key frames that would exceed the new limits, or an empty text."""
    limits = {joint.name: joint for joint in joints}
    wrong = [
        f"{step.full_name} has {name} at {degrees(angle):.0f} degrees"
        for step in steps
        for name, angle in step.positions.items()
        if name in limits and not limits[name].lower_rad <= angle <= limits[name].upper_rad
    ]
    more = f", and {len(wrong) - 3} more" if len(wrong) > 3 else ""
    return "; ".join(wrong[:3]) + more
