"""The picture of a motion: the one pose of it that is furthest from standing at zero."""

from lbr.messages.joints import Motion

MOST_FRAMES = 2000
"""A picture of a motion need not know what comes later."""


def key_pose(motion: Motion) -> dict[str, float]:
    """Return the joints' angles in the key frame in which they are furthest from where the motion begins and ends."""
    poses: list[dict[str, float]] = []
    pose: dict[str, float] = {}
    for frame in motion.frames[:MOST_FRAMES]:
        pose = {**pose, **frame.positions}
        poses.append(pose)
    if not poses:
        return {}
    rest = {name: (poses[0].get(name, 0.0) + poses[-1].get(name, 0.0)) / 2 for name in poses[-1]}
    if len(poses) <= 2:
        return poses[-1]
    return max(poses, key=lambda one: sum(abs(angle - rest.get(name, 0.0)) for name, angle in one.items()))
