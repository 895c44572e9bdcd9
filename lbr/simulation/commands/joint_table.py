"""A humanoid as lines of text: how it lies, if its world publishes that, and the last measurement of each joint."""

from math import degrees

from lbr.messages.joints import JointsState, JointState
from lbr.messages.rows import short
from lbr.simulation.messages import HumanoidPose

WEAK = 0.95
"""A joint with less of its torque than this is marked."""
_HEAD = f"{'joint':<22}{'angle':>8}{'goal':>8}{'load':>7}{'°C':>5}{'V':>6}  "


def lines(state: JointsState, pose: HumanoidPose | None, width: int, height: int) -> list[str]:
    """Return the view within this size; angles are degrees from each joint's zero."""
    doing = _plays(state) if state.stored is not None else "moving" if state.moving else state.phase
    by = f", held by {short(state.holder)}" if state.holder else ""
    why = f": {short(state.reason)}" if state.reason and not state.moving else ""
    table = [_row(name, one) for name, one in state.joints.items()]
    return [line[:width] for line in [*_lies(pose), f"{doing}{by}{why}", _HEAD, *table][:height]]


def _plays(state: JointsState) -> str:
    left = "" if state.left_s is None else f" for {state.left_s:.1f} s more"
    return f"the controller plays slot {state.stored}{left}"


def _lies(pose: HumanoidPose | None) -> list[str]:
    if pose is None:
        return []
    lean = f"roll {degrees(pose.roll_rad):+.0f}, pitch {degrees(pose.pitch_rad):+.0f} degrees"
    on_floor = ", ".join(pose.on_floor) or "nothing"
    return [f"{pose.posture}, trunk {pose.z_m * 100:.0f} cm high, {lean}; on the floor: {on_floor}"]


def _row(name: str, one: JointState) -> str:
    numbers = f"{_angle(one.position_rad):>8}{_angle(one.goal_rad):>8}{_percent(one.load):>7}"
    return f"{short(name):<22}{numbers}{_number(one.temperature_c, 0):>5}{_number(one.voltage_v, 1):>6}  {_note(one)}"


def _note(joint: JointState) -> str:
    if joint.latched:
        return f"latched: {', '.join(joint.latched)}"
    doubt = f"says {joint.raw}, not believed" if joint.raw is not None else "not believed"
    doubted = [doubt] if joint.trusted is False else []
    return ", ".join(
        (
            *joint.faults,
            *doubted,
            *([short(joint.reason)] if joint.reason and not doubted else []),
            *(["no torque"] if joint.torque == 0.0 else []),
            *(["torque unknown"] if joint.torque is None else []),
            *([f"torque {joint.torque * 100:.0f} %"] if joint.torque and joint.torque < WEAK else []),
        )
    )


def _angle(rad: float | None) -> str:
    return "-" if rad is None else f"{degrees(rad):z.1f}"


def _percent(load: float | None) -> str:
    return "-" if load is None else f"{load * 100:z.0f} %"


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
