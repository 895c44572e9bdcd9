"""What one servo was told, the job that gives it torque where it is, and whether it did as told."""

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from math import inf

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import Bus
from lbr.drivers.dynamixel.sweep import Seen


@dataclass(slots=True)
class Output:
    """What one servo was told. `settled`: when its torque was on the wire; inf while that waits; `aimed`: its goal.

    `blocked` says why it gets no torque before a setpoint had it without. `stays`: its goal is where it was measured;
    `adrift`: it is to be held where it is as soon as that is measured; `found`: when it was first heard, with torque.
    """

    id: int
    known: bool = False
    on: bool = False
    goal: int | None = None
    speed: int = 0
    limit: int = 0
    full: int = table.FULL_TORQUE
    settled: float = -inf
    aimed: float = -inf
    blocked: str = ""
    trouble: str = ""
    latched: tuple[str, ...] = ()
    stays: bool = False
    adrift: bool = False
    found: float = -inf
    switching: "Future[int | str] | None" = None
    again: float = -inf


def switching(servo: int, speed: int, limit: int) -> Callable[[Bus], int | str]:
    """Return the job that gives a servo torque where it is, and returns that position, or why not."""

    def job(bus: Bus) -> int | str:
        motion = bus.read_motion(servo)
        if motion is None:
            return bus.trouble
        goal = table.GOAL_POSITION.encode(motion.position)
        block = goal + table.MOVING_SPEED.encode(speed) + table.TORQUE_LIMIT.encode(limit)
        if not bus.write(servo, table.GOAL_POSITION.address, block):
            return "does not take the position where it is for its goal; look at its own angle limits"
        if not bus.put(servo, table.TORQUE_ENABLE, 1):
            return "does not acknowledge its torque"
        return motion.position

    return job


def confirms(out: Output, seen: Seen, *, released: bool) -> bool:
    """Say whether a servo was read, since it was told, to hold its goal; or to be without torque if `released`."""
    slow = seen.slow
    if slow is None or slow.at <= max(out.settled, out.aimed) or seen.reason or out.switching is not None:
        return False
    return not slow.enabled if released else out.goal == slow.goal
