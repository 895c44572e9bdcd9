"""The picture of a motion: its pose that differs most from its beginning and end."""

from lbr.messages.joints import Motion

MOST_FRAMES = 2000
"""The frames of a motion that its picture considers."""


def key_pose(motion: Motion) -> dict[str, float]:
    """Return the joints' angles in the key frame that differs most from the motion's beginning and end."""
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
