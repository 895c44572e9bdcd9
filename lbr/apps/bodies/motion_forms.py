"""Which forms of motion files there are."""

from lbr.robot import registry

OWN = ".json"


def known(robot: str = "") -> tuple[tuple[str, str, bool], ...]:
    """Return the end of their names, what they are, and whether they are written as well, lbr's own first.

    For a robot whose package brings forms, those of other makers are only read.
    """
    found = registry.find(robot)
    own = {one.suffix for one in found.robot.motion_formats} if found is not None and found.robot is not None else set()
    makers = sorted(registry.motion_formats().items())
    writes = ((suffix, one, bool(one.write) and (not own or suffix in own)) for suffix, one in makers)
    return ((OWN, "of lbr's own", True), *((suffix, one.summary, written) for suffix, one, written in writes))
