"""SO-101: a leader and a follower, as a robot that `lbr run so101-sim` starts."""

from pathlib import Path

from lbr.robot import Robot

_HERE = Path(__file__).parent
ROBOT = Robot(
    name="so101",
    summary="two arms of six Feetech servos: a leader that a hand moves, and a follower",
    rows=_HERE / "rows.sql",
    profiles=_HERE / "profiles",
    body=_HERE / "body.xml",
)
