"""The body of a robot: its owner's own, its package's, or one made of its rows of wheels."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from lbr.apps.bodies import mjcf, wheeled
from lbr.apps.bodies.parts import Body, JointRange, RobotModel
from lbr.errors import InputError
from lbr.messages.joints import Joint
from lbr.messages.kinematics import Wheel
from lbr.messages.sensing import RangeSensor
from lbr.robot import registry


def body_file(robot: str, home: Path) -> Path | None:
    """Return the description of a robot's body: its owner's own, else its package's."""
    own = home / "models" / f"{robot}.xml"
    if own.is_file():
        return own
    brought = registry.find(robot)
    return brought.robot.body if brought is not None and brought.robot is not None else None


def model(
    robot: str, file: Path | None, joints: Sequence[Joint], wheels: Sequence[Wheel], sensors: Sequence[RangeSensor]
) -> RobotModel:
    """Return a robot's body with the limits of its rows; without a body, the reason."""
    body, reason = Body(), ""
    if file is not None:
        try:
            body = mjcf.read(file)
        except InputError as err:
            reason = str(err)
    elif not joints:
        body = wheeled.body(wheels, sensors)
    else:
        reason = (
            f"no package brings a body for '{robot}': put one, as MJCF, into models/{robot}.xml of the robot's home"
        )
    return RobotModel(
        robot=robot,
        links=body.links,
        joints=_ranges(body, joints),
        sensors=body.sensors,
        left_out=body.left_out,
        reason=reason,
    )


def _ranges(body: Body, rows: Iterable[Joint]) -> dict[str, JointRange]:
    """Return the range of each row's joint, and of each wheel; other joints of the body stay at 0."""
    ranges = {
        row.name: JointRange(
            lower=row.lower_rad,
            upper=row.upper_rad,
            kind=body.joints.get(row.name, "hinge"),
            side=row.side,
            speed_rps=row.speed_rps,
            drawn=row.name in body.joints,
        )
        for row in rows
    }
    wheels = {name: JointRange(kind="wheel") for name, kind in body.joints.items() if kind == "wheel"}
    return {**wheels, **ranges}
