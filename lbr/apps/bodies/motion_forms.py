"""The forms of motion files."""

from lbr.robot import registry

OWN = ".json"


def known(robot: str = "") -> tuple[tuple[str, str, bool], ...]:
    """Return the suffix of each form, its summary, and whether it can be written; lbr's own first.

    If the robot's package brings forms, those of other makers are only read.
    """
    found = registry.find(robot)
    own = {one.suffix for one in found.robot.motion_formats} if found is not None and found.robot is not None else set()
    makers = sorted(registry.motion_formats().items())
    writes = ((suffix, one, bool(one.write) and (not own or suffix in own)) for suffix, one in makers)
    return ((OWN, "of lbr's own", True), *((suffix, one.summary, written) for suffix, one, written in writes))
