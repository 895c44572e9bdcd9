"""The goal of the follower, and its phase: pure functions of both arms' states."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite

from lbr.messages.codes import Reason
from lbr.messages.joints import Joint, JointsState
from lbr_so101.teleop import Phase, TeleopSettings

Pose = Mapping[str, float]


def pose_of(
    leader: JointsState | None, age_s: float, joints: Sequence[Joint], settings: TeleopSettings
) -> Pose | Reason:
    """Return the leader's pose within the follower's limits, or why it is unknown; NaN and old readings are invalid."""
    if leader is None or not age_s <= settings.max_age_s:
        return Reason("stale_sensor", f"the leader's joints have told nothing for {settings.max_age_s:g} s")
    pose = {}
    for joint in joints:
        name = f"{settings.leader}{joint.name}"
        one = leader.joints.get(name)
        if one is None:
            return Reason("unknown_name", f"the leader has no joint '{name}'; see the setting `leader`")
        if one.position_rad is None or not isfinite(one.position_rad):
            return Reason("stale_sensor", f"{name} is not measured: {one.reason or 'its servo does not answer'}")
        if one.age_s is None or not one.age_s + age_s <= settings.max_age_s:
            return Reason("stale_sensor", f"{name} was not measured for {settings.max_age_s:g} s")
        pose[joint.name] = min(max(one.position_rad, joint.lower_rad), joint.upper_rad)
    return pose


def gap_rad(pose: Pose, follower: JointsState | None) -> float:
    """Return the gap of the follower's worst joint; infinite if one is not measured."""
    joints = follower.joints if follower is not None else {}
    places = {name: joints[name].position_rad for name in pose if name in joints}
    gaps = (inf if (at := places.get(name)) is None or not isfinite(at) else abs(at - to) for name, to in pose.items())
    return max(gaps, default=inf)


def phase_after(before: Phase, gap: float, settings: TeleopSettings) -> Phase:
    """Return the follower's phase at a gap: it follows once it was near, and approaches again from far."""
    return "following" if gap <= (settings.far_rad if before == "following" else settings.near_rad) else "approaching"
