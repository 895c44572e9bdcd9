"""A robot that has looked around: the drive refuses to move towards what was never measured."""

from lbr.bus import wire
from tests.support.robot import Robot
from tests.support.waiting import until


def measured(robot: Robot) -> None:
    """Wait until two more readings have come, so that the drive has had one."""
    readings = wire.Subscription(robot.bus, f"{robot.name}/ranges/readings", depth=4)
    seen: list[wire.RawMessage] = []

    def two() -> bool:
        seen.extend(readings.take())
        return len(seen) >= 2

    until(two, what="two range readings")
    readings.close()
