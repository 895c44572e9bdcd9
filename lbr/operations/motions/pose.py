"""The pose of the joints: as a key frame, and the time to another. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from math import degrees, isfinite, radians

from lbr.errors import InputError
from lbr.messages.joints import Joint, JointsState, JointState, KeyFrame

OLDEST_S = 0.3
BEYOND_RAD = radians(1.0)
"""The distance beyond its limits at which a joint counts as standing at the limit: servos are no more exact."""
STEEPEST = 1.5
"""The greatest speed of a smooth way from rest to rest, as a multiple of a straight one."""
LONGEST_S = 30.0
DIGITS = 4
MOST_NAMED = 4


def key_frame(joints: Sequence[Joint], state: JointsState, duration_s: float) -> KeyFrame:
    """Return the pose of all joints; raise InputError naming those not measured or out of their limits."""
    if not joints:
        raise InputError("there are no joints among the rows, so there is no pose")
    if missing := _several(_missing(joint, state.joints.get(joint.name)) for joint in joints):
        raise InputError(f"not all joints were measured: {missing}")
    angles = [(joint, state.joints[joint.name].position_rad or 0.0) for joint in joints]
    if beyond := _several(_beyond(joint, angle_rad) for joint, angle_rad in angles):
        raise InputError(f"{beyond}; move it, or change its row")
    positions = {joint.name: _clipped(joint, angle_rad) for joint, angle_rad in angles}
    return KeyFrame(positions=positions, duration_s=duration_s)


def reach_s(joints: Sequence[Joint], state: JointsState, frame: KeyFrame, *, mirror: bool) -> float:
    """Return the time of the joints to a key frame, from their target or position, within all speed limits."""
    known = {joint.name: joint for joint in joints}
    longest_s = 0.0
    for name, angle_rad in frame.positions.items():
        joint = known.get(_partner(name, known) if mirror else name)
        present = _present(state.joints.get(joint.name)) if joint is not None else None
        if joint is not None and present is not None:
            longest_s = max(longest_s, STEEPEST * abs(angle_rad - present) / joint.speed_rps)
    return min(longest_s, LONGEST_S)


def _partner(name: str, known: Mapping[str, Joint]) -> str:
    side = known[name].side if name in known else "centre"
    return name if side == "centre" else name.replace(side, "right" if side == "left" else "left", 1)


def _present(state: JointState | None) -> float | None:
    if state is None:
        return None
    found = state.position_rad if state.goal_rad is None else state.goal_rad
    return found if found is not None and isfinite(found) else None


def _missing(joint: Joint, state: JointState | None) -> str:
    """Return why a joint's angle is unknown, or an empty string."""
    if state is None:
        return f"{joint.name} (servo {joint.device_id}) is not among the states"
    if state.position_rad is None or not isfinite(state.position_rad):
        doubted = "what it reports is not believed" if state.trusted is False else "no reason given"
        return f"{joint.name} (servo {joint.device_id}): {state.reason or doubted}"
    if state.age_s is not None and not state.age_s <= OLDEST_S:
        return f"{joint.name} (servo {joint.device_id}) was measured {state.age_s:.1f} s ago"
    return ""


def _beyond(joint: Joint, angle_rad: float) -> str:
    """Return how far a joint is outside its limits, or an empty string."""
    if joint.lower_rad - BEYOND_RAD <= angle_rad <= joint.upper_rad + BEYOND_RAD:
        return ""
    limits = f"{degrees(joint.lower_rad):.1f} to {degrees(joint.upper_rad):.1f}"
    return f"{joint.name} is at {degrees(angle_rad):.1f} degrees, its limits are {limits}"


def _clipped(joint: Joint, angle_rad: float) -> float:
    return min(max(round(angle_rad, DIGITS), joint.lower_rad), joint.upper_rad)


def _several(whys: Iterable[str]) -> str:
    """Return the first few errors, and the number of the others."""
    errors = [why for why in whys if why]
    more = f", and {len(errors) - MOST_NAMED} more" if len(errors) > MOST_NAMED else ""
    return "; ".join(errors[:MOST_NAMED]) + more
